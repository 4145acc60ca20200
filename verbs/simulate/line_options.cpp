#include "verbs/simulate/line_options.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "sim/far_end.hpp"
#include "verbs/simulate/fault_option.hpp"
#include "verbs/simulate/registers.hpp"

namespace biss::verbs {

namespace {

// The registers give the values that the user does not give.
void take_described(const FormatArguments& described, FormatArguments& device) {
  for (const auto field :
       {&FormatArguments::format, &FormatArguments::ack_max, &FormatArguments::timeout,
        &FormatArguments::clock_max, &FormatArguments::cycle_min}) {
    if ((device.*field).empty()) device.*field = described.*field;
  }
}

}  // namespace

void add_line_options(Verb all, LineOptions& line, MasterKind master) {
  const bool simulated = master == MasterKind::simulated;
  Verb verb = all.section("Line");
  add_format_option(verb, line.device, false);
  add_rate_option(verb, "--clock", into(line.setup.clock),
                  simulated ? "Frequency of MA; 1 MHz by default"
                            : "Frequency of MA if the program gives none, and by which faults are "
                              "placed; 1 MHz by default");
  if (simulated) {
    add_deviation_option(verb, "--clock-error", into(line.setup.clock_error_ppm),
                         "Deviation of the master's oscillator: 200ppm, -0.5%");
    add_duty_option(verb, "--duty", into(line.setup.duty_per_mille),
                    "Share of a period in which MA is high; 50% by default");
  }
  add_length_option(verb, "--cable", into(line.cable),
                    "Cable length; 10 ns of line delay per metre");
  add_duration_option(verb, "--ma-delay", into(line.ma_delay),
                      "Delay of MA to the encoder; by default half of the delay of the cable");
  add_duration_option(verb, "--slo-delay", into(line.slo_delay),
                      "Delay of SLO to the master; by default half of the delay of the cable");
  add_duration_option(
      verb, "--internal-delay", into(line.internal_delay),
      "Delay from MA to SLO in the encoder; by default the longest of this encoder");
  add_duration_option(verb, "--jitter", into(line.jitter), "Peak edge jitter (±), both directions");
  add_duration_option(verb, "--ma-jitter", into(line.ma_jitter), "Peak edge jitter (±) of MA only");
  add_duration_option(verb, "--slo-jitter", into(line.slo_jitter),
                      "Peak edge jitter (±) of SLO only");
  add_duration_option(verb, "--processing", into(line.processing),
                      "Processing time, from ACK to START; the encoder's shortest by default");
  if (simulated) {
    add_count_option(
        verb, "--slaves", into(line.setup.slaves),
        "Encoders in a daisy chain; 1 by default. Each has one data channel, and the last one has "
        "all further channels",
        max_channels);
  }
  add_rate_option(verb, "--rate", into(line.rate),
                  simulated
                      ? "Requests per second; by default the highest rate that the encoder allows"
                      : "Requests per second that the motion assumes; by default the highest rate "
                        "that the encoder allows");
  if (simulated) {
    verb.add_flag("--no-compensation", line.no_compensation,
                  "Sample half a period after the master's own edge, without the line delay");
  }
  add_timing_options(verb, line.device);
  verb = all.section("Motion");
  verb.add_option("--motion", line.motion,
                  "Kind of motion: constant, ramp (the default), sine, random or max")
      .type_name("KIND");
  add_name_option(verb, "--counter", line.counter, {"count_1_63", "count_0_63"},
                  "Range of the sign of life; count_1_63 by default");
  verb.add_option("--counter-start", line.counter_start,
                  "First sign of life after power-up, one value for all channels or one for each; "
                  "1 by default")
      .delimiter(',')
      .type_name("N,...");
  verb.add_option("--drift", line.drift,
                  "Drift of the other words of an encoder against its first word, in counts per "
                  "cycle")
      .type_name("COUNTS");
  add_count_option(verb, "--seed", into(line.setup.seed),
                   "Random seed of positions, jitter and faults; 1 by default");
  verb = all.section("Faults");
  if (simulated) {
    add_duration_option(
        verb, "--pause", into(line.setup.pause),
        "Length of the pauses of MA within a frame, for --pause-every and for --fault "
        "ma_pause; MA is high");
    add_count_option(verb, "--pause-every", into(line.setup.pause_clocks),
                     "Pause MA after this many clocks, as an SPI port does after 8", 65'535);
    verb.add_option("--then", line.then,
                    "Another format from this cycle on, for an encoder whose frames change")
        .type_name("FORMAT@CYCLE");
  }
  verb.add_option("--fault", line.faults,
                  "Inject a fault into this share of the cycles or, with @CYCLE, into one cycle; "
                  ",bit=N or ,clock=N selects the place in it: " +
                      fault_kinds_text(simulated ? sim::is_injectable : sim::is_of_far_end))
      .type_name("KIND:RATE|KIND@CYCLE[,PLACE]");
}

void add_register_options(Verb verb, std::vector<std::string>& files, LineOptions& line) {
  verb.add_option("--registers", files,
                  "Dump with the registers of the next encoder, beginning at the far end of the "
                  "chain, or of the one with this ID; without -f it also gives the format")
      .type_name("[ID:]FILE")
      .file(FileUse::read, file_of_registers);
  verb.add_option("--register-busy", line.register_busy,
                  "Busy time per byte, in frames or as a time")
      .type_name("N|TIME");
}

void put_registers(const std::vector<std::string>& files, LineOptions& line, Host& host) {
  LoadedRegisters loaded = load_registers(files, host);
  line.setup.registers = std::move(loaded.registers);
  if (line.device.format.empty()) {
    for (const std::string& finding : loaded.findings) host.warn("--registers: " + finding);
    if (!loaded.contradiction.empty()) {
      throw VerbError{
          ExitStatus::data_failed,
          fmt::format("--registers: the data sheet contradicts itself; give --format ({})",
                      loaded.contradiction)};
    }
    take_described(loaded.device, line.device);
    // At most eight encoders have registers.
    line.setup.slaves =
        std::max(line.setup.slaves, static_cast<std::uint8_t>(line.setup.registers.size()));
  }
}

}  // namespace biss::verbs
