#include "cli/live/read.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <utility>

#include "biss/master/spi_read.hpp"
#include "biss/timing/cable.hpp"
#include "biss/timing/cycle.hpp"
#include "cli/live/configure.hpp"
#include "cli/live/record.hpp"
#include "live/line_reader.hpp"
#include "live/live_axis.hpp"
#include "live/spi_port.hpp"
#include "report/summary.hpp"
#include "verbs/common/format_option.hpp"
#include "verbs/decode/decode_run.hpp"

namespace biss::cli {

using namespace verbs;

namespace {

struct ReadOptions {
  DecodeOptions decode;
  ConfigureArguments configure;
  std::string port;
  std::string ma_pin = "sck";
  Hertz clock = megahertz(1);
  Hertz rate = kilohertz(1);
  std::optional<Millimetres> cable;
  std::optional<std::uint64_t> cycles;
  std::optional<Picoseconds> duration;
  std::uint64_t bytes = 0;
  std::string record;
};

// The first SIGINT, SIGTERM or SIGHUP ends the reading, and the rows so far are written. The second
// one does what it did before.
class EndBySignal {
 public:
  EndBySignal() {
    wanted_ = 0;
    struct sigaction action {};
    action.sa_handler = end;
    for (const auto& [number, before] : signals_) {
      ::sigaction(number, nullptr, before);
      if (before->sa_handler != SIG_IGN) ::sigaction(number, &action, nullptr);
    }
  }
  ~EndBySignal() {
    for (const auto& [number, before] : signals_) ::sigaction(number, before, nullptr);
  }
  EndBySignal(const EndBySignal&) = delete;
  EndBySignal& operator=(const EndBySignal&) = delete;

  static bool wanted() { return wanted_ != 0; }

 private:
  static void end(int number) {
    if (wanted_ != 0) {
      for (const auto& [each, before] : signals_) ::sigaction(each, before, nullptr);
      ::raise(number);
    }
    wanted_ = 1;
  }

  static inline volatile std::sig_atomic_t wanted_ = 0;
  static inline std::array<struct sigaction, 3> before_{};
  static constexpr std::array<std::pair<int, struct sigaction*>, 3> signals_{
      {{SIGINT, &before_[0]}, {SIGTERM, &before_[1]}, {SIGHUP, &before_[2]}}};
};

// The longest timeout of BiSS C, for an encoder that is not known.
constexpr Picoseconds biss_timeout_longest = microseconds(40);

/// The line at the port, as options describe it.
struct LinePlan {
  std::optional<Device> device;
  SpiSetup spi;
  std::size_t bytes = 0;
  /// The shortest time from one request to the next, and from the end of a transfer.
  Picoseconds least{};
  Picoseconds rest = biss_timeout_longest;
};

SpiSetup spi_setup_of(const ReadOptions& options, const DeviceTiming& timing) {
  SpiSetup setup{.period = period_of(options.clock), .no_error_flag = true, .unchecked = true};
  if (options.cable) {
    setup.line_delay.max =
        std::min(biss_line_delay_max,
                 line_delay(*options.cable, timing.internal_delay_max) + nanoseconds(100));
  }
  return setup;
}

// Throws if the line does not allow the rate.
LinePlan with_rate(LinePlan plan, const ReadOptions& options) {
  const Picoseconds transfer = static_cast<std::int64_t>(8 * plan.bytes) * plan.spi.period;
  plan.least = std::max(plan.least, transfer + plan.rest);
  if (period_of(options.rate) >= plan.least) return plan;
  const std::int64_t most = 1'000'000'000'000 / plan.least.count;
  throw wrong_usage("--rate: {} bytes at this clock and the timeout allow {} at most", plan.bytes,
                    text_of(Hertz(static_cast<std::uint32_t>(most))));
}

LinePlan plan_line(const ReadOptions& options) {
  constexpr std::size_t usual_bytes = 32;
  if (options.record == "-") throw wrong_usage("--record: name a file");
  const FormatArguments& arguments = options.decode.capture.device;
  LinePlan plan{.device = {}, .spi = spi_setup_of(options, {}), .bytes = options.bytes};
  if (arguments.format.empty() || arguments.format == "none") {
    if (plan.bytes == 0) plan.bytes = usual_bytes;
    return with_rate(std::move(plan), options);
  }
  plan.device = value_or_fail(choose_device(arguments));
  const auto& [format, timing] = std::tie(plan.device->format, plan.device->timing);
  plan.spi = spi_setup_of(options, timing);
  if (!accepts_clock(timing, options.clock)) {
    throw wrong_usage("--clock: the encoder accepts {} to {}", text_of(timing.clock_min),
                      text_of(timing.clock_max));
  }
  const CycleBudget budget =
      cycle_budget({format.payload_bits(), 1}, timing, options.clock, plan.spi.line_delay.max);
  plan.least = budget.total;
  plan.rest = budget.timeout;
  if (plan.bytes == 0) plan.bytes = spi_bytes(format, plan.spi, timing);
  if (plan.bytes > live::transfer_bytes_max) {
    throw wrong_usage(
        "--clock: ACK of this encoder needs {} bytes in a transfer, at most {}; use "
        "a lower clock",
        plan.bytes, live::transfer_bytes_max);
  }
  return with_rate(std::move(plan), options);
}

live::SpiPortSetup port_setup_of(const ReadOptions& options) {
  const std::size_t colon = options.port.find(':');
  if (options.port.substr(0, colon) != "spi" || colon == std::string::npos) {
    throw wrong_usage("--port '{}': write spi:DEVICE, such as spi:/dev/spidev0.0", options.port);
  }
  return {.path = options.port.substr(colon + 1),
          .clock = options.clock,
          .ma = options.ma_pin == "mosi" ? live::MaPin::mosi : live::MaPin::sck};
}

std::string with_doubt(const live::ReachedClock& reached) {
  return fmt::format("{} ± {}", text_of(reached.clock), text_of(reached.uncertainty));
}

/// One run of the verb: transfers of the port become the words of a DecodeRun.
class ReadRun {
 public:
  ReadRun(const ReadOptions& options, Host& host)
      : options_(options),
        host_(host),
        plan_(plan_line(options)),
        reader_(value_or_fail(live::SpiPort::open(port_setup_of(options)), ExitStatus::io),
                period_of(options.rate), plan_.least, plan_.rest) {
    if (!plan_.device) return;
    auto axis =
        live::LiveAxis::make(plan_.device->format, plan_.device->timing, plan_.spi,
                             {.cycle = period_of(options.rate),
                              .to_sampling = sampling_delay(plan_.spi, plan_.device->timing),
                              .max_step = no_step_limit,
                              .bad_cycles = BadCycleRule::hold,
                              .trip_after = 65535});
    if (axis) axis_ = std::move(*axis);
  }

  ExitStatus run() {
    const EndBySignal signals;
    measure_clock();
    reader_.set_bytes(plan_.bytes);
    if (!options_.record.empty()) record_.emplace(options_.record, host_);
    DecodeOptions decode = options_.decode;
    decode.capture.words.file = options_.port;
    decode.capture.words.next = [this] { return next(); };
    const ExitStatus status = DecodeRun(decode, host_).run();
    const bool recorded = !record_ || record_->finish();
    host_.print_summary(summary());
    return recorded ? status : std::max(status, ExitStatus::io);
  }

 private:
  void measure_clock() {
    reached_ = reader_.port().measure_clock([] { return !EndBySignal::wanted(); });
    if (!reached_ && reader_.port().error() == EINVAL) {
      throw wrong_file("{}: the controller does not accept this clock; give another --clock",
                       options_.port);
    }
    // An uncertain clock is only printed.
    if (!reached_ || reached_->uncertainty.count > reached_->clock.count / 30) return;
    // The rate that was asked, less 2 % and what the measurement does not know.
    const std::int64_t least = std::int64_t{options_.clock.count} * 98 / 100;
    if (std::int64_t{reached_->clock.count} + reached_->uncertainty.count >= least) return;
    host_.warn(fmt::format(
        "{}: MA runs at {} in the mean, {} was asked: the controller has a lower clock, or it "
        "pauses between bytes. A pause that is longer than the encoder's timeout cuts a frame off",
        options_.port, with_doubt(*reached_), text_of(options_.clock)));
  }

  std::optional<LoggedWord> next() {
    const auto go_on = [this](Picoseconds due) {
      return !EndBySignal::wanted() && (!options_.cycles || words_ < *options_.cycles) &&
             (!options_.duration || due < *options_.duration);
    };
    const auto on_fault = [this](live::PortFault fault, Picoseconds time) {
      if (axis_) axis_->take(time, {});
      if (reader_.counts().faults[static_cast<std::size_t>(fault)] > 1) return;
      host_.warn(fmt::format("{}: a transfer failed: {}{}; reading goes on", options_.port,
                             name_of(fault), error_text()));
    };
    const auto transfer = reader_.next(on_fault, go_on);
    if (!transfer) return std::nullopt;
    ++words_;
    if (axis_) axis_->take(transfer->time, transfer->bytes);
    if (record_) record_->add(transfer->time, transfer->bytes);
    return LoggedWord{transfer->time,
                      {{transfer->bytes.begin(), transfer->bytes.end()}, 8 * plan_.bytes}};
  }

  std::string error_text() const {
    const int error = reader_.counts().last_error;
    return error == 0 ? std::string() : fmt::format(" ({})", std::strerror(error));
  }

  std::string summary() const {
    const live::ReadCounts& counts = reader_.counts();
    report::Summary summary;
    summary.title(options_.port + ": " + report::counted(counts.requests, "request"));
    summary.entry("MA", reached_ ? with_doubt(*reached_) : "not measured",
                  fmt::format("{} asked", text_of(options_.clock)));
    std::string faults;
    for (std::size_t k = 0; k < live::port_fault_count; ++k) {
      report::append_count(faults, counts.faults[k], name_of(static_cast<live::PortFault>(k)));
    }
    summary.entry("failed", faults.empty() ? "none" : faults,
                  faults.empty() ? "" : "transfers without bytes; they have no row");
    summary.entry("late", fmt::format("{} not made", counts.late),
                  counts.late == 0 ? ""
                                   : "this program did not run in time, or a transfer took longer "
                                     "than a period; each is a gap in time_ns");
    add_lateness(summary);
    if (const auto delay = axis_ ? axis_->line_delay_seen() : std::nullopt) {
      summary.entry("line delay",
                    delay->first == delay->second
                        ? report::counted(delay->first, "clock") + " of MA"
                        : fmt::format("{} to {} clocks of MA", delay->first, delay->second));
    }
    return summary.text();
  }

  void add_lateness(report::Summary& summary) const {
    const decode::Distribution& lateness = reader_.lateness();
    if (lateness.count() == 0) return;
    const auto us = [](std::int64_t nanoseconds) {
      return fmt::format("{:.1f} us", static_cast<double>(nanoseconds) / 1000);
    };
    summary.entry("latency", us(lateness.median()),
                  fmt::format("median from due to request; at most {}", us(lateness.max())));
    // Powers of two of a microsecond.
    std::array<std::uint64_t, 24> counts{};
    lateness.for_each_bucket([&counts](std::int64_t begin, std::uint64_t count) {
      const auto power = std::bit_width(static_cast<std::uint64_t>(begin) / 1000);
      counts[std::min<std::size_t>(static_cast<std::size_t>(power), counts.size() - 1)] += count;
    });
    std::string text;
    for (std::size_t k = 0; k < counts.size(); ++k) {
      if (counts[k] == 0) continue;
      text += fmt::format("{}{} below {} us", text.empty() ? "" : ", ", counts[k],
                          std::uint64_t{1} << k);
    }
    summary.entry("", text);
  }

  const ReadOptions& options_;
  Host& host_;
  LinePlan plan_;
  live::LineReader reader_;
  std::unique_ptr<live::LiveAxis> axis_;
  std::optional<live::ReachedClock> reached_;
  std::optional<Record> record_;
  std::uint64_t words_ = 0;
};

void add_line_options(Verb verb, ReadOptions& options) {
  verb.add_option("--port", options.port,
                  "The port of the encoder: spi:DEVICE, such as spi:/dev/spidev0.0")
      .type_name("PORT")
      .required();
  add_format_option(verb, options.decode.capture.device, false);
  add_timing_options(verb, options.decode.capture.device);
  add_rate_option(verb, "--clock", into(options.clock), "Frequency of MA; 1 MHz by default");
  add_rate_option(verb, "--rate", into(options.rate), "Requests per second; 1 kHz by default");
  add_length_option(verb, "--cable", into(options.cable),
                    "Length of the cable; without it, any line delay of BiSS C is accepted");
  add_name_option(verb, "--ma-pin", options.ma_pin, {"sck", "mosi"},
                  "The pin that is MA: the clock (sck), or the data output with two bits for each "
                  "clock (mosi); sck by default");
  add_count_option(verb, "--bytes", into(options.bytes),
                   "Bytes of each transfer; by default as many as the format needs, without a "
                   "format 32",
                   live::transfer_bytes_max);
}

}  // namespace

void add_read(Command& command) {
  const auto options = std::make_shared<ReadOptions>();
  Verb verb = command.add_verb(
      {.name = "read",
       .purpose = "Read the positions of an encoder at an SPI port of this machine",
       .examples = {"biss read --port spi:/dev/spidev0.0 -f resolute-26 --clock 4MHz --duration 2s",
                    "biss read --port spi:/dev/spidev0.0 --cycles 1000",
                    "biss read --port spi:/dev/spidev0.0 --ma-pin mosi --configure --registers "
                    "seen.hex --cycles 1000",
                    "biss read --port spi:/dev/spidev0.0 -f resolute-26 --rate 5kHz --cycles 2000 "
                    "--record line.log -o rows.csv"}},
      [options](Host& host) {
        ReadOptions chosen = *options;
        if (chosen.configure.given()) {
          const EndBySignal signals;
          const ExitStatus status = configure_line(
              chosen.configure, port_setup_of(chosen), chosen.decode.capture.device,
              [] { return !EndBySignal::wanted(); }, host);
          if (status != ExitStatus::done || chosen.cycles == 0) return status;
        }
        return ReadRun(chosen, host).run();
      });
  options->decode.capture.identify = true;
  add_line_options(verb, *options);
  add_safety_options(verb, options->decode.safety);
  const Verb own = verb.scope(Scope::command);
  add_configure_options(own, options->configure);
  add_count_option(own, "--cycles", into(options->cycles), "Ends after this many rows");
  add_duration_option(own, "--duration", into(options->duration), "Ends after this time");
  own.add_option(
         "--record", options->record,
         "Also writes the bytes of each transfer; `biss decode --words FILE` makes the same "
         "rows of them")
      .file(FileUse::write);
  add_judged_row_options(verb, options->decode);
}

}  // namespace biss::cli
