#include "cli/live/configure.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <optional>
#include <span>

#include "biss/configure/configure_link.hpp"
#include "biss/frame/format_text.hpp"
#include "device/quantity.hpp"
#include "dump/write.hpp"
#include "live/line_reader.hpp"
#include "verbs/common/access_option.hpp"
#include "verbs/simulate/write.hpp"

namespace biss::cli {

using namespace verbs;

namespace {

// A bank takes 929 requests; each retry goes on with the byte that is not done.
constexpr ControlOptions control_options{.retries = 50};

// The next step if the encoder cannot be read; without one its format is identified.
std::string_view remedy_of(ConfigureError cause) {
  switch (cause) {
    case ConfigureError::no_encoder:
      return "no request had an answer; check the supply, and that MOSI is MA and MISO is SLO";
    case ConfigureError::line_lost:
    case ConfigureError::control_failed:
    case ConfigureError::too_many_requests:
      return "answers are missing or damaged; check cable and supply, or use a lower --clock";
    default:
      return {};
  }
}

std::string_view meaning_of(ControlError error) {
  switch (error) {
    case ControlError::refused:
    case ControlError::refused_or_not_addressed:
    case ControlError::next_unavailable:
      return "the encoder does not have this register, or protects it";
    case ControlError::no_answer:
    case ControlError::no_such_slave:
      return "no encoder with registers has this ID";
    default:
      return "the answer is missing or damaged; check the cable, or use a lower --clock";
  }
}

// The registers and banks that the configuration of one slave read.
dump::RegisterDump dump_of(const SlaveDescription& slave, const EdsImage& image) {
  dump::RegisterDump dump;
  const auto put = [&dump](unsigned address, unsigned size, std::uint64_t value) {
    for (; size-- != 0; value >>= 8U) dump.at(0, address + size) = static_cast<std::uint8_t>(value);
  };
  put(reg::eds_bank, 1, slave.eds_bank);
  if (slave.profile) put(reg::bp_id, 2, *slave.profile);
  if (slave.serial) put(reg::dev_sn, 4, *slave.serial);
  if (slave.identity) put(reg::dev_id, 6, slave.identity->device);
  if (slave.identity) put(reg::mfr_id, 2, slave.identity->manufacturer);
  if (image.common == nullptr) return dump;
  dump.set_bank(slave.eds_bank, *image.common);
  const CommonPart common = parse_common_part(*image.common);
  for (std::size_t i = 0; i < max_channels; ++i) {
    if (image.profiles[i] != nullptr) dump.set_bank(common.channels[i].bank, *image.profiles[i]);
  }
  return dump;
}

class ConfigureRun {
 public:
  ConfigureRun(const live::SpiPortSetup& setup, const std::function<bool()>& go_on, Host& host)
      : name_("spi:" + setup.path),
        host_(host),
        go_on_(go_on),
        bounds_(bounds_up_to_cds(period_of(setup.clock), {})),
        reader_(value_or_fail(live::SpiPort::open(setup), ExitStatus::io), microseconds(10),
                common_cycle, biss_static_timeout_max) {
    // The port samples after the rising edge: on a short line, ACK is the second sample.
    bounds_.lead_min_clocks = 1;
    reader_.set_bytes(bytes_up_to_cds(bounds_));
  }

  /// \param file gets the registers, unless its name is empty
  /// \return nothing if the format is not known
  std::optional<Configuration> configure(const std::string& file) {
    std::vector<std::string> findings;
    Configurator configurator({.switch_channels = false,
                               .control = control_options,
                               .findings = lines_of_findings(findings)});
    run(configurator);
    const auto found = configurator.result();
    report::Summary out;
    out.title(name_ + ": " + report::counted(configurator.requests(), "request"));
    add_configuration(out, found, findings);
    host_.print_summary(out.text());
    if (configurator.unrestored().banks != 0) host_.warn("BSEL (0x40) could not be restored");
    if (found.ok()) {
      if (!file.empty()) write_registers(file, *found, configurator.image());
      return *found;
    }
    const std::string_view remedy = remedy_of(found.error().cause);
    const std::string text = fmt::format(
        "{}: no configuration: {}; {}", name_, fault_text(found.error()),
        remedy.empty() ? "the format is identified, and no registers are written" : remedy);
    if (!remedy.empty()) throw VerbError{ExitStatus::data_failed, text};
    host_.warn(text);
    return std::nullopt;
  }

  /// \return the bytes, or `ok`, and the cause of a failure
  std::string access(const sim::ControlAccess& access, ExitStatus& status) {
    const bool reads = access.kind == sim::AccessKind::read;
    // A byte that is written twice may matter.
    ControlSession session(reads ? control_options : ControlOptions{});
    std::vector<std::uint8_t> bytes(access.size);
    if (reads) session.read(access.slave, access.address, bytes);
    // Each register alone: only then the encoder may not delay the byte.
    for (unsigned k = 0; !reads && k < access.data.size() && !session.outcome().error; ++k) {
      session.write(access.slave, access.address + k, std::span(access.data).subspan(k, 1));
      run(session);
    }
    run(session);
    const ControlOutcome& outcome = session.outcome();
    bytes.resize(reads ? outcome.bytes_done : 0);
    std::string text = fmt::format("{:02X}", fmt::join(bytes, " "));
    if (!outcome.error) return reads ? text : "ok";
    status = ExitStatus::data_failed;
    if (!text.empty()) text += "; ";
    return text + fmt::format("{}: {}", name_of(*outcome.error), meaning_of(*outcome.error));
  }

 private:
  // Makes the requests of a Configurator or of a ControlSession.
  template <class Master>
  void run(Master& master) {
    unsigned faults = 0;  // in a row
    while (!master.done()) {
      reader_.port().end_with(master.cdm_ahead());
      std::optional<live::PortFault> fault;
      Picoseconds time;
      const auto transfer = reader_.next(
          [&](live::PortFault why, Picoseconds began) {
            fault = why;
            time = began;
          },
          [&](Picoseconds) { return !fault && go_on_(); });
      faults = fault ? faults + 1 : 0;
      if (fault == live::PortFault::gone || faults == 10) {
        throw ended(
            fmt::format("transfers fail: {}; connect the port, or end the program that "
                        "uses it, and start again",
                        live::name_of(*fault)));
      }
      if (!transfer && !fault) throw ended("interrupted");
      // A transfer that failed may have been made in part.
      master.take_cds(transfer ? transfer->time : time,
                      transfer ? cds_of(BitView(transfer->bytes), bounds_) : CdsBit::missing);
    }
  }

  VerbError ended(const std::string& why) const {
    return wrong_file("{}: {}; a register, BSEL (0x40) too, may have another value than before",
                      name_, why);
  }

  void write_registers(const std::string& file, const Configuration& found, const EdsImage& image) {
    if (found.slave_count != 1) {
      throw wrong_file("--registers: a file holds one encoder, {} are connected; use --access",
                       found.slave_count);
    }
    const ExitStatus written = write_output(host_, file, [&](Output& output) {
      return output.write(
          write_as(dump::format_of(file), dump_of(found.slave_list[0], image), "registers"));
    });
    if (written != ExitStatus::done) throw VerbError{written, "--registers: not written"};
  }

  std::string name_;
  Host& host_;
  const std::function<bool()>& go_on_;
  FrameBounds bounds_;
  live::LineReader reader_;
};

// Options of the user keep their values.
void take(const Configuration& found, Hertz clock, FormatArguments& device) {
  const DeviceTiming& timing = found.timing;
  device.format = format_text(found.format).view();
  // D2: with the delay of START, 40 us at most.
  const Picoseconds ack = timing.ack_max + found.start_delay_clocks * period_of(clock);
  const auto set = [](std::string& text, std::string found_text) {
    if (text.empty()) text = std::move(found_text);
  };
  if (device.ack_clocks.empty()) set(device.ack_max, text_of(std::min(ack, biss_busy_max)));
  set(device.timeout, text_of(timing.timeout));
  set(device.clock_max, text_of(timing.clock_max));
  set(device.cycle_min, text_of(timing.cycle_min));
}

}  // namespace

ExitStatus configure_line(const ConfigureArguments& arguments, live::SpiPortSetup setup,
                          FormatArguments& device, const std::function<bool()>& go_on, Host& host) {
  if (setup.ma != live::MaPin::mosi) {
    throw wrong_usage(
        "--configure and --access need --ma-pin mosi: the clock pin is high after each transfer, "
        "so CDM is always 0; connect MOSI to MA");
  }
  if (arguments.configure && !device.format.empty()) {
    throw wrong_usage("--configure: finds the format; remove -f");
  }
  const auto accesses = read_accesses(arguments.accesses);
  for (const sim::ControlAccess& access : accesses) {
    if (access.kind > sim::AccessKind::write || access.not_before != 0) {
      throw wrong_usage("--access: a port has only read:ADDRESS[,COUNT] and write:ADDRESS=BYTES");
    }
  }
  const Hertz clock = setup.clock;
  setup.clock = std::clamp(clock, common_clock_min, common_clock_max);
  ConfigureRun run(setup, go_on, host);
  const auto found = arguments.configure ? run.configure(arguments.registers) : std::nullopt;
  if (found) take(*found, clock, device);
  ExitStatus status = ExitStatus::done;
  report::Summary out;
  for (const sim::ControlAccess& access : accesses) {
    const bool reads = access.kind == sim::AccessKind::read;
    out.entry(fmt::format("{}/{}:0x{:02X}", access.slave, reads ? "read" : "write", access.address),
              run.access(access, status));
  }
  if (!out.empty()) host.print_summary(out.text());
  return status;
}

void add_configure_options(Verb verb, ConfigureArguments& arguments) {
  Option& configure = verb.add_flag("--configure", arguments.configure,
                                    "First read the data sheet of the encoder, and use its format "
                                    "and timing; needs --ma-pin mosi");
  verb.add_option("--registers", arguments.registers,
                  "Also write the registers that --configure read: as hex text, .ihex, .bin or .c")
      .file(FileUse::write)
      .needs(configure);
  verb.add_option("--access", arguments.accesses,
                  "First access registers: read:0x48,2 or write:0x60=02; may be repeated; needs "
                  "--ma-pin mosi")
      .type_name("ACCESS");
}

}  // namespace biss::cli
