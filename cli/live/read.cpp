#include "cli/live/read.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "biss/frame/format_text.hpp"
#include "biss/master/spi_read.hpp"
#include "biss/timing/cable.hpp"
#include "biss/timing/cycle.hpp"
#include "cli/live/configure.hpp"
#include "cli/live/end_by_signal.hpp"
#include "cli/live/live_view.hpp"
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
  if (options.live && ::isatty(STDOUT_FILENO) != 1) {
    throw wrong_usage("--live: standard output is not a terminal");
  }
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
  ReadRun(const ReadOptions& options, Host& host, std::function<bool()> goes_on,
          OnPortCycle on_cycle)
      : options_(options),
        goes_on_(std::move(goes_on)),
        on_cycle_(std::move(on_cycle)),
        live_(options.live ? std::make_unique<LiveView>(host, [this] { return begin_live(); })
                           : nullptr),
        host_(live_ ? *live_ : host),
        plan_(plan_line(options)),
        reader_(value_or_fail(live::SpiPort::open(port_setup_of(options)), ExitStatus::io),
                period_of(options.rate), plan_.least, plan_.rest) {
    // Without an axis the rows are read too.
    if (plan_.device) static_cast<void>(make_axis(*plan_.device));
  }

  ExitStatus run() {
    measure_clock();
    reader_.set_bytes(plan_.bytes);
    if (!options_.record.empty()) record_.emplace(options_.record, host_);
    DecodeOptions decode = options_.decode;
    decode.capture.words.file = options_.port;
    decode.capture.words.next = [this] { return next(); };
    DecodeRun run(decode, host_);
    run_ = &run;
    const ExitStatus status = on_cycle_ ? take_cycles(run.capture(), decode) : run.run();
    end_record();
    host_.print_summary(summary());
    return recorded_ ? status : std::max(status, ExitStatus::io);
  }

 private:
  ExitStatus take_cycles(DecodedCapture& capture, const DecodeOptions& decode) const {
    const ExitStatus opened = capture.open(decode.capture);
    if (opened != ExitStatus::done) return opened;
    if (!capture.next()) return capture.status();
    capture.read([this](std::uint64_t, const decode::Cycle& cycle) {
      on_cycle_(&cycle, cycle.time);
      return true;
    });
    return ExitStatus::done;
  }

  // Makes the axes. \return how their positions are shown
  tl::expected<std::vector<LiveSetup::Channel>, std::string> make_axis(const Device& device) {
    std::vector<LiveSetup::Channel> shown;
    std::vector<AxisSetup> setups;
    for (const ChannelFormat& channel : device.format.channels()) {
      const CatalogueEntry* const entry = shown.empty() ? device.entry : nullptr;
      MotionArguments asked = shown.empty() ? options_.decode.motion : MotionArguments{};
      asked.unwrap = true;
      const auto motion = make_motion(asked, channel, entry);
      if (!motion) return tl::unexpected(motion.error());
      auto scale = motion->scale();
      if (!scale && entry != nullptr) scale = scale_of(*entry);
      std::vector<rows::Scale> units{{1, "counts"}};
      if (scale) units.push_back(*scale);
      if (channel.singleturn.present()) {
        units.push_back({std::exp2(-int{channel.singleturn.bits}), "turns"});
      } else if (scale && scale->unit == "deg") {
        units.push_back({scale->per_count / 360, "turns"});
      }
      shown.push_back({channel.position_bits(), std::move(units)});
      setups.push_back({.cycle = period_of(options_.rate),
                        .to_sampling = sampling_delay(plan_.spi, device.timing),
                        .max_step = static_cast<std::int64_t>(motion->max_step()),
                        .bad_cycles = BadCycleRule::hold,
                        .trip_after = 65535});
    }
    auto axis = live::LiveAxis::make(device.format, device.timing, plan_.spi, setups);
    if (!axis) return tl::unexpected(axis.error());
    axis_ = *std::move(axis);
    return shown;
  }

  LiveSetup begin_live() {
    const auto& format = run_->capture().format();
    if (!format) throw wrong_usage("--live: the format of the frame is not known; give -f");
    const std::string clock = reached_ ? with_doubt(*reached_) : text_of(options_.clock);
    return {fmt::format("{}: {}, MA {}", options_.port, format_text(*format).view(), clock),
            options_.rate, value_or_fail(make_axis(plan_.device.value_or(Device{*format, {}})))};
  }

  void end_record() {
    recorded_ = (!record_ || record_->finish()) && recorded_;
    record_.reset();
  }
  // In a file that is not there yet.
  void start_record() try {
    int number = 1;
    const auto path = [&number] { return fmt::format("biss-read-{}.log", number); };
    while (std::filesystem::exists(path())) ++number;
    record_.emplace(path(), host_);
  } catch (const VerbError& error) {
    host_.warn(error.text);
  }

  bool go_on(Picoseconds due) {
    if (!goes_on_() || words_ >= options_.cycles.value_or(~std::uint64_t{}) ||
        (options_.duration && due >= *options_.duration)) {
      return false;
    }
    if (!live_) return true;
    const char key =
        live_->tick(axis_.get(), reader_.counts(), record_ ? record_->path() : std::string());
    if (key == 'r') record_ ? end_record() : start_record();
    return key != 'q';
  }

  void measure_clock() {
    reached_ = reader_.port().measure_clock(goes_on_);
    if (!reached_ && reader_.port().error() == EINVAL) {
      throw wrong_file("{}: the controller does not accept this clock; give another --clock",
                       options_.port);
    }
    // An uncertain clock is only printed.
    if (!reached_ || reached_->uncertainty.count > reached_->clock.count / 10) return;
    // The rate that was asked, less 2 % and what the measurement does not know.
    const std::int64_t least = std::int64_t{options_.clock.count} * 98 / 100;
    if (std::int64_t{reached_->clock.count} + reached_->uncertainty.count >= least) return;
    host_.warn(fmt::format(
        "{}: MA runs at {} in the mean, {} was asked: the controller has a lower clock, or it "
        "pauses between bytes. A pause that is longer than the encoder's timeout cuts a frame off",
        options_.port, with_doubt(*reached_), text_of(options_.clock)));
  }

  std::optional<LoggedWord> next() {
    const auto on_fault = [this](live::PortFault fault, Picoseconds time) {
      if (axis_) axis_->take(time, {});
      if (on_cycle_) on_cycle_(nullptr, time);
      const bool is_first = !std::exchange(fails_, true);
      if (record_ && is_first)
        record_->comment(fmt::format("a transfer failed: {}", name_of(fault)));
      if (reader_.counts().faults[static_cast<std::size_t>(fault)] > 1) return;
      host_.warn(fmt::format("{}: a transfer failed: {}{}; reading goes on", options_.port,
                             name_of(fault), error_text()));
    };
    const auto transfer = reader_.next(on_fault, [this](Picoseconds due) { return go_on(due); });
    if (!transfer) return std::nullopt;
    fails_ = false;
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
    const std::string failed = failed_transfers(counts);
    summary.entry("failed", failed,
                  failed == "none" ? "" : "transfers without bytes; they have no row");
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
  std::function<bool()> goes_on_;
  OnPortCycle on_cycle_;
  std::unique_ptr<LiveView> live_;
  Host& host_;
  LinePlan plan_;
  live::LineReader reader_;
  std::unique_ptr<live::LiveAxis> axis_;
  std::optional<live::ReachedClock> reached_;
  DecodeRun* run_ = nullptr;
  std::optional<Record> record_;
  bool recorded_ = true;
  bool fails_ = false;
  std::uint64_t words_ = 0;
};

}  // namespace

Option& add_port_options(Verb verb, ReadOptions& options) {
  Option& port = verb.add_option("--port", options.port,
                                 "The port of the encoder: spi:DEVICE, such as spi:/dev/spidev0.0")
                     .type_name("PORT");
  add_request_options(verb, options);
  return port;
}

void add_request_options(Verb verb, ReadOptions& options) {
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

std::function<ExitStatus()> prepare_read(const ReadOptions& options, Host& host,
                                         std::function<bool()> goes_on, OnPortCycle on_cycle) {
  const auto run =
      std::make_shared<ReadRun>(options, host, std::move(goes_on), std::move(on_cycle));
  return [run] { return run->run(); };
}

ExitStatus read_port(const ReadOptions& options, Host& host, const OnPortCycle& on_cycle) {
  const auto goes_on = [] { return !EndBySignal::wanted(); };
  const EndBySignal signals;
  EndBySignal::before_end = Screen::restore;
  ReadOptions chosen = options;
  if (chosen.configure.given()) {
    const ExitStatus status = configure_line(chosen.configure, port_setup_of(chosen),
                                             chosen.decode.capture.device, goes_on, host);
    if (status != ExitStatus::done || chosen.cycles == 0) return status;
  }
  return prepare_read(chosen, host, goes_on, on_cycle)();
}

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
      [options](Host& host) { return read_port(*options, host); });
  options->decode.capture.identify = true;
  add_port_options(verb, *options).required();
  add_format_option(verb, options->decode.capture.device, false);
  add_timing_options(verb, options->decode.capture.device);
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
  Option& live = own.add_flag("--live", options->live,
                              "Show position, causes and line delay in this terminal instead of "
                              "rows; keys: z zero, u unit, r record, q end");
  for (const char* const name : {"--output", "--to", "--columns", "--only-errors", "--every"}) {
    live.excludes(verb.get_option(name));
  }
}

}  // namespace biss::cli
