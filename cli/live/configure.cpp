#include "cli/live/configure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <span>
#include <utility>

#include "biss/base/big_endian.hpp"
#include "biss/frame/format_text.hpp"
#include "device/quantity.hpp"
#include "dump/register_dump.hpp"
#include "dump/write.hpp"
#include "live/line_control.hpp"
#include "report/summary.hpp"
#include "sim/control_master.hpp"
#include "verbs/common/access_option.hpp"
#include "verbs/common/configured.hpp"

namespace biss::cli {

using namespace verbs;

namespace {

/// The next step after a configuration without a result; empty if the encoder can be read, with its
/// format identified.
std::string_view remedy_of(ConfigureError cause) {
  switch (cause) {
    case ConfigureError::no_encoder:
      return "no request was answered; check the supply of the encoder, and that MOSI is MA and "
             "MISO is SLO";
    case ConfigureError::line_lost:
    case ConfigureError::control_failed:
    case ConfigureError::too_many_requests:
      return "answers are damaged or missing; check the cable and the supply, use a lower --clock, "
             "and try again";
    case ConfigureError::too_many_slaves:
      return "a chain has eight encoders at most";
    case ConfigureError::no_channel:
    case ConfigureError::too_many_channels:
    case ConfigureError::channels_stay_off:
      return "read it without --configure";
    default:
      return {};
  }
}

/// The meaning of a failed access, and the next step.
std::string_view text_of_failure(ControlError error) {
  switch (error) {
    case ControlError::refused:
      return "the encoder does not have this register, or protects it";
    case ControlError::refused_or_not_addressed:
      return "the encoder does not have this register, or protects it from writing";
    case ControlError::next_unavailable:
      return "the next register does not exist, or the encoder ends each access here; read it "
             "alone";
    case ControlError::no_such_slave:
      return "no encoder has this ID";
    case ControlError::no_answer:
      return "no encoder takes part in the control communication; it may be unidirectional";
    case ControlError::busy_too_long:
    case ControlError::start_missing:
      return "the encoder did not begin the byte in time; it may refuse this register";
    case ControlError::frame_lost:
      return "a request had no answer; check the cable and the supply";
    default:
      return "the answer is damaged; check the cable, or use a lower --clock";
  }
}

/// The registers and banks that the configuration of one slave read.
dump::RegisterDump dump_of(const SlaveDescription& slave, const EdsImage& image) {
  dump::RegisterDump dump;
  const auto put = [&dump](unsigned address, std::uint64_t value, unsigned size) {
    for (unsigned k = 0; k < size; ++k) {
      dump.at(0, address + k) = static_cast<std::uint8_t>(value >> 8U * (size - 1 - k));
    }
  };
  put(reg::eds_bank, slave.eds_bank, 1);
  if (slave.profile) put(reg::bp_id, *slave.profile, 2);
  if (slave.serial) put(reg::dev_sn, *slave.serial, 4);
  if (slave.identity) {
    put(reg::dev_id, slave.identity->device, 6);
    put(reg::mfr_id, slave.identity->manufacturer, 2);
  }
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
  ConfigureRun(const ConfigureArguments& arguments, const live::SpiPortSetup& setup,
               std::vector<sim::ControlAccess> accesses, const std::function<bool()>& go_on,
               Host& host)
      : arguments_(arguments),
        name_("spi:" + setup.path),
        accesses_(std::move(accesses)),
        host_(host),
        control_(value_or_fail(live::SpiPort::open(setup), ExitStatus::io), setup.clock, go_on) {}

  /// Nothing if the format is not known.
  std::optional<Configuration> configure() {
    std::vector<std::string> findings;
    // Activating the channels needs CDS before CDM; and all requests have the same length.
    Configurator configurator({.switch_channels = false, .findings = lines_of_findings(findings)});
    if (!control_.run(configurator)) {
      throw ended("register 0x40 (BSEL) may have another value than before");
    }
    const auto found = configurator.result();
    report::Summary out;
    out.title(fmt::format("{}: configuration, {}", name_,
                          report::counted(configurator.requests(), "request")));
    add_configuration(out, found, findings);
    host_.print_summary(out.text());
    if (configurator.unrestored().banks != 0) {
      host_.warn("register 0x40 (BSEL) could not be restored; switch the encoder off and on");
    }
    if (!found.ok()) {
      const std::string text = "no configuration: " + fault_text(found.error());
      const std::string_view remedy = remedy_of(found.error().cause);
      if (!remedy.empty()) throw failed(fmt::format("{}; {}", text, remedy));
      if (!arguments_.registers.empty()) {
        throw failed(fmt::format("{}; --registers: there are no registers to write", text));
      }
      host_.warn(fmt::format("{}: {}; the format is identified from the frames", name_, text));
      return std::nullopt;
    }
    if (!arguments_.registers.empty()) write_registers(*found, configurator.image());
    return *found;
  }

  ExitStatus access() {
    report::Summary out;
    ExitStatus status = ExitStatus::done;
    for (std::size_t k = 0; k < accesses_.size(); ++k) {
      const auto [bytes, error] = make(accesses_[k]);
      std::string result;
      for (const std::uint8_t byte : bytes) result += fmt::format("{:02X} ", byte);
      if (accesses_[k].kind == sim::AccessKind::write) result = error ? "" : "ok";
      if (error) {
        result += fmt::format("{}: {}", name_of(*error), text_of_failure(*error));
        status = ExitStatus::data_failed;
      }
      out.entry(arguments_.accesses[k], result);
    }
    if (!out.empty()) host_.print_summary(out.text());
    return status;
  }

 private:
  struct Result {
    std::vector<std::uint8_t> bytes;
    std::optional<ControlError> error;
  };

  Result make(const sim::ControlAccess& access) {
    ControlSession session({.retries = 3});
    Result result;
    if (access.kind == sim::AccessKind::read) {
      result.bytes.resize(access.size);
      session.read(access.slave, access.address, result.bytes);
      if (!control_.run(session)) throw ended("no register was changed");
      result.error = session.outcome().error;
      result.bytes.resize(session.outcome().bytes_done);
      return result;
    }
    // Each register alone: only then the encoder may not delay the byte.
    unsigned address = access.address;
    for (const std::uint8_t& byte : access.data) {
      session.write(access.slave, address++, std::span(&byte, 1));
      if (!control_.run(session)) {
        throw ended(fmt::format("read register 0x{:02X} to see its value", address - 1));
      }
      result.error = session.outcome().error;
      if (result.error) break;
    }
    return result;
  }

  void write_registers(const Configuration& found, const EdsImage& image) {
    if (found.slave_count != 1) {
      throw failed(fmt::format("--registers: {} encoders are connected, and a file holds one",
                               found.slave_count));
    }
    const dump::RegisterDump dump = dump_of(found.slave_list[0], image);
    const std::string_view format = dump::format_of(arguments_.registers);
    if (dump::holds_banks_only(format) && !dump.banks()) {
      throw failed("--registers: the encoder has no data sheet, and this format holds only banks");
    }
    const ExitStatus written = write_output(host_, arguments_.registers, [&](Output& file) {
      return file.write(write_as(format, dump, "registers"));
    });
    if (written != ExitStatus::done) throw VerbError{written, ""};
  }

  VerbError failed(const std::string& text) const {
    return {ExitStatus::data_failed, fmt::format("{}: {}", name_, text)};
  }
  VerbError ended(const std::string& state) const {
    const auto fault = control_.fault();
    const std::string_view step = fault == live::PortFault::gone   ? "connect it again"
                                  : fault == live::PortFault::busy ? "end the other program"
                                                                   : "try again";
    return {ExitStatus::io, fault ? fmt::format("{}: transfers fail: {}; {}; {}", name_,
                                                name_of(*fault), step, state)
                                  : fmt::format("{}: interrupted; {}", name_, state)};
  }

  const ConfigureArguments& arguments_;
  std::string name_;
  std::vector<sim::ControlAccess> accesses_;
  Host& host_;
  live::LineControl control_;
};

// The options that the user gave keep their values.
void take(const Configuration& found, Hertz clock, FormatArguments& device) {
  const auto set = [](std::string& text, std::string value) {
    if (text.empty()) text = std::move(value);
  };
  const DeviceTiming& timing = found.timing;
  device.format = format_text(found.format).view();
  // D2: with the delay of START, 40 us at most.
  const Picoseconds ack = timing.ack_max + found.start_delay_clocks * period_of(clock);
  if (device.ack_clocks.empty()) set(device.ack_max, text_of(std::min(ack, biss_busy_max)));
  set(device.timeout, text_of(timing.timeout));
  set(device.clock_max, text_of(timing.clock_max));
  if (timing.cycle_min.count != 0) set(device.cycle_min, text_of(timing.cycle_min));
}

}  // namespace

ExitStatus configure_line(const ConfigureArguments& arguments, live::SpiPortSetup setup,
                          FormatArguments& device, const std::function<bool()>& go_on, Host& host) {
  const char* const option = arguments.configure ? "--configure" : "--access";
  if (setup.ma != live::MaPin::mosi) {
    throw wrong_usage(
        "{}: needs --ma-pin mosi: the clock pin is high after each transfer, so CDM is always 0; "
        "connect MOSI to MA",
        option);
  }
  if (arguments.configure && !device.format.empty()) {
    throw wrong_usage("--configure: finds the format; remove -f");
  }
  std::vector<sim::ControlAccess> accesses = read_accesses(arguments.accesses);
  for (const sim::ControlAccess& access : accesses) {
    const bool registers =
        access.kind == sim::AccessKind::read || access.kind == sim::AccessKind::write;
    if (!registers || access.not_before != 0) {
      throw wrong_usage("--access: a port has only read:ADDRESS and write:ADDRESS=BYTES");
    }
  }
  const Hertz clock = setup.clock;
  setup.clock = std::clamp(clock, common_clock_min, common_clock_max);
  ConfigureRun run(arguments, setup, std::move(accesses), go_on, host);
  if (arguments.configure) {
    if (const auto found = run.configure()) take(*found, clock, device);
  }
  return run.access();
}

void add_configure_options(Verb verb, ConfigureArguments& arguments) {
  Option& configure = verb.add_flag("--configure", arguments.configure,
                                    "Read the data sheet of the encoder first, and use its format "
                                    "and timing; needs --ma-pin mosi");
  verb.add_option("--registers", arguments.registers,
                  "Also write the registers and the data sheet that --configure read: as hex text, "
                  ".ihex, .bin or .c; `biss eds show` reads them")
      .file(FileUse::write)
      .needs(configure);
  verb.add_option("--access", arguments.accesses,
                  "Access registers before reading: read:0x48,2 or write:0x60=02; may be repeated; "
                  "needs --ma-pin mosi")
      .type_name("ACCESS");
}

}  // namespace biss::cli
