// `biss simulate`: master, cable and encoder on the wire, written as a capture, the truth beside
// it.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "cli/common/access_option.hpp"
#include "cli/common/capture_output.hpp"
#include "cli/common/fault_option.hpp"
#include "cli/common/verb.hpp"
#include "cli/common/verbs.hpp"
#include "cli/simulate/registers.hpp"
#include "cli/simulate/replay.hpp"
#include "cli/simulate/setup.hpp"
#include "cli/simulate/write.hpp"
#include "sim/line.hpp"

namespace biss::cli {

namespace {

struct SimulateOptions {
  LineOptions line;
  ReplayOptions replay;
  WriteOptions write;
  std::vector<std::string> registers;
  std::vector<std::string> accesses;
};

// What times in 64-bit picoseconds hold, and something to spare.
constexpr Picoseconds longest_capture = milliseconds(100LL * 24 * 3600 * 1000);

// What the registers say stands where the user says nothing.
void take_described(const FormatArguments& described, FormatArguments& device) {
  for (const auto field :
       {&FormatArguments::format, &FormatArguments::ack_max, &FormatArguments::timeout,
        &FormatArguments::clock_max, &FormatArguments::cycle_min}) {
    if ((device.*field).empty()) device.*field = described.*field;
  }
}

class SimulateRun {
 public:
  explicit SimulateRun(const SimulateOptions& options) : options_(options) {}

  ExitStatus run() {
    if (options_.write.sample_rate && !CaptureOutput::is_sampled(options_.write.output)) {
      return fail(ExitStatus::usage,
                  "--sample-rate: this output holds changes, not samples; write .sr, .bin or .raw");
    }
    if (options_.replay.raw.rate && options_.replay.ma_from.empty() &&
        options_.replay.slo_from.empty()) {
      return fail(ExitStatus::usage,
                  "--raw-rate: goes with --ma-from or --slo-from; for -o use --sample-rate");
    }
    LineOptions line = options_.line;
    if (const ExitStatus status = load_control(line); status != ExitStatus::done) return status;
    if (line.device.format.empty()) {
      return fail(
          ExitStatus::usage,
          "--format is required, or --registers with a profile identifier for each encoder");
    }
    if (!options_.replay.ma_from.empty()) return replay_ma(replay_options(), line);
    if (!options_.replay.slo_from.empty()) return replay_slo(replay_options(), line);
    const LineChoice choice = choose_line(line);
    if (!choice) return fail(ExitStatus::usage, choice.error);
    if (const std::string wrong = check_run(*choice.setup); !wrong.empty()) {
      return fail(ExitStatus::usage, wrong);
    }
    return write_line(*choice.setup, options_.write);
  }

 private:
  ExitStatus load_control(LineOptions& line) const {
    LoadedRegisters loaded = load_registers(options_.registers);
    if (loaded.status != ExitStatus::done) return loaded.status;
    line.registers = std::move(loaded.registers);
    if (line.device.format.empty()) {
      take_described(loaded.device, line.device);
      line.slaves = std::max<std::uint64_t>(line.slaves, line.registers.size());
    }
    auto accesses = read_accesses(options_.accesses);
    if (!accesses) return fail(accesses.error());
    line.accesses = std::move(*accesses);
    if (!line.accesses.empty() || options_.write.outcomes.empty()) return ExitStatus::done;
    return fail(ExitStatus::usage, "--outcomes: without --access there are none");
  }

  // Whether the line, the faults and the accesses fit into this many cycles.
  std::string check_run(const sim::LineSetup& setup) const {
    const sim::NominalCycle nominal = sim::Line(setup).nominal();
    const std::uint64_t least = least_cycles(setup.accesses);
    const std::uint64_t cycles = options_.write.cycles.value_or(std::max(usual_cycles, least));
    const std::int64_t most = longest_capture.count / nominal.interval.count;
    if (cycles > static_cast<std::uint64_t>(most)) {
      return fmt::format("--cycles: a capture holds 100 days, {} cycles at this rate", most);
    }
    if (cycles < least) {
      return fmt::format(
          "--cycles: the accesses take {} at least; without --cycles there are as "
          "many as they need",
          least);
    }
    const auto checked = check_faults(setup.faults, nominal, cycles);
    return checked ? "" : checked.error();
  }

  ReplayOptions replay_options() const {
    ReplayOptions replay = options_.replay;
    replay.sample_rate = options_.write.sample_rate;
    replay.output = options_.write.output;
    replay.truth = options_.write.truth;
    return replay;
  }

  const SimulateOptions& options_;
};

void add_line_options(Verb verb, LineOptions& line) {
  add_format_option(verb, line.device, false);
  add_timing_options(verb, line.device);
  add_rate_option(verb, "--clock", into(line.clock), "MA's frequency; 1 MHz by default");
  add_deviation_option(verb, "--clock-error", into(line.clock_error_ppm),
                       "How much faster the master's oscillator is: 200ppm, -0.5%");
  add_duty_option(verb, "--duty", into(line.duty_per_mille),
                  "Share of a period that MA is high; 50% by default");
  add_length_option(verb, "--cable", into(line.cable), "Cable, 10 ns of line delay a metre");
  add_duration_option(verb, "--ma-delay", into(line.ma_delay),
                      "From the master to the encoder; half of the cable's by default");
  add_duration_option(verb, "--slo-delay", into(line.slo_delay),
                      "From the encoder back to the master; half of the cable's by default");
  add_duration_option(verb, "--internal-delay", into(line.internal_delay),
                      "MA to SLO inside the encoder; its longest by default");
  add_duration_option(verb, "--jitter", into(line.jitter),
                      "Edges come up to so much earlier or later, each way");
  add_duration_option(verb, "--ma-jitter", into(line.ma_jitter), "Only those of MA");
  add_duration_option(verb, "--slo-jitter", into(line.slo_jitter), "Only those of SLO");
  add_duration_option(verb, "--processing", into(line.processing),
                      "From ACK until the encoder has its answer; its shortest by default");
  add_count_option(verb, "--slaves", into(line.slaves),
                   "Encoders in a chain, a channel each, the last one with the rest; 1 by default",
                   max_channels);
  add_rate_option(verb, "--rate", into(line.rate),
                  "Requests a second; as fast as the encoder is ready by default");
  verb.add_option("--motion", line.motion, "constant, ramp (the default), sine, random or max")
      .type_name("KIND");
  add_name_option(verb, "--counter", line.counter, {"count_1_63", "count_0_63"},
                  "The range of the sign of life; count_1_63 by default");
  verb.add_option("--counter-start", line.counter_start,
                  "The first sign of life after power-up, one for all words or one a word; 1 by "
                  "default")
      .delimiter(',')
      .type_name("N,...");
  verb.add_option("--drift", line.drift,
                  "The words behind an encoder's first one show a position that is so many counts "
                  "of the first one's further with each cycle")
      .type_name("COUNTS");
  verb.add_option("--fault", line.faults,
                  "Damage that share of cycles, or, with @CYCLE, that one; ,bit=N or ,clock=N says "
                  "where in it: " +
                      fault_kinds_text())
      .type_name("KIND:RATE|KIND@CYCLE[,PLACE]");
  verb.add_flag("--no-compensation", line.no_compensation,
                "The master samples half a period after its own edge");
  verb.add_flag("--at-slave", line.at_slave, "Record MA and SLO at the encoder, too");
  add_count_option(verb, "--seed", into(line.seed), "Seed of positions, jitter and faults");
}

void add_control_options(Verb verb, SimulateOptions& options) {
  verb.add_option("--registers", options.registers,
                  "A dump with the registers of an encoder, that at the end of a chain first, or "
                  "of the one with this ID; without -f their profiles say the format")
      .type_name("[ID:]FILE")
      .file(FileUse::read, file_of_registers);
  verb.add_option("--register-busy", options.line.register_busy,
                  "The encoder is late by so many frames with each byte, or by such a time")
      .type_name("N|TIME");
  verb.add_option("--access", options.accesses,
                  "The master reads registers, writes some or sends a command, beside its requests "
                  "for positions: read:0x42,2, 1/write:0x48=01FF, 0/command:channels, read:0@500 "
                  "(not before a cycle), or those in a file, one a line")
      .type_name("[ID/]ACCESS|@FILE")
      .file(FileUse::read, file_of_accesses);
  add_count_option(verb, "--retries", into(options.line.retries),
                   "Times that an access is tried again; 0 by default", 255);
  verb.add_option("--outcomes", options.write.outcomes,
                  "What became of the accesses, as CSV, or as JSON lines in FILE.jsonl")
      .type_name("FILE")
      .file(FileUse::write);
  verb.add_flag(
      "--configure", options.write.configure,
      "The master begins with knowing nothing: it asks the encoders for format and timing, "
      "and reads the positions by that");
}

// Options of a side that is recorded say nothing; giving them is a mistake.
void add_replay_options(Verb verb, ReplayOptions& replay) {
  Option ma_from = verb.add_option(
      "--ma-from", replay.ma_from,
      "Answer the requests of the master in this capture; its MA and our SLO are written");
  Option slo_from = verb.add_option(
      "--slo-from", replay.slo_from,
      "Read the encoder in this capture where it was asked; our MA and its SLO are written");
  ma_from.type_name("FILE").file(FileUse::read).excludes(slo_from);
  slo_from.type_name("FILE").file(FileUse::read);
  for (const char* name :
       {"--rate", "--cycles", "--fault", "--jitter", "--ma-jitter", "--slo-jitter", "--at-slave",
        "--clock-error", "--duty", "--access", "--retries", "--outcomes", "--configure"}) {
    ma_from.excludes(verb.get_option(name));
    slo_from.excludes(verb.get_option(name));
  }
  for (const char* name :
       {"--clock", "--no-compensation", "--slaves", "--counter", "--counter-start", "--drift"}) {
    ma_from.excludes(verb.get_option(name));
  }
  for (const char* name : {"--cable", "--ma-delay", "--slo-delay", "--internal-delay",
                           "--processing", "--motion", "--seed", "--truth", "--registers",
                           "--register-busy", "--counter", "--counter-start", "--drift"}) {
    slo_from.excludes(verb.get_option(name));
  }
  verb.add_option("--ma", replay.ma, "The capture's line that is MA").type_name("NAME");
  verb.add_option("--slo", replay.slo, "The capture's line that is SLO")
      .type_name("NAME")
      .needs(slo_from);
  add_raw_options(verb, replay.raw);
  verb.add_option("--readings", replay.readings,
                  "What our master reads with --slo-from, as CSV with the columns of decode")
      .type_name("FILE")
      .file(FileUse::write)
      .needs(slo_from);
}

}  // namespace

void add_simulate(Command& command) {
  const auto options = std::make_shared<SimulateOptions>();
  Verb verb = command.add_verb(
      {.name = "simulate",
       .purpose = "Write a capture of a master reading an encoder, damaged where wanted",
       .examples = {"biss simulate -f resolute-26 --clock 10MHz --cable 50m -o line.vcd",
                    "biss simulate -f pos18,nE,nW,crc6 --fault flip:0.1 --fault cut@40,bit=5 "
                    "-o line.csv --truth truth.csv",
                    "biss simulate -f resolute-26 --clock 10MHz --sample-rate 200MHz -o line.sr",
                    "biss simulate --registers encoder.hex --access read:0x78,8 --outcomes - "
                    "-o line.vcd",
                    "biss simulate -f pos26,nE,nW,crc6 --ma-from master.vcd -o answered.vcd"}},
      [options] { return SimulateRun(*options).run(); });
  add_line_options(verb, options->line);
  add_count_option(verb, "--cycles", into(options->write.cycles),
                   "Request cycles; by default 100, or as many as --access takes", 100'000'000);
  add_rate_option(verb, "--sample-rate", into(options->write.sample_rate),
                  "Samples a second of .sr, .bin and .raw; the next of 1, 2, 5, 10 … from eight "
                  "times the clock on by default");
  add_output_option(verb, options->write.output).required();
  verb.add_option("--truth", options->write.truth, "What the encoder meant to send, as CSV")
      .type_name("FILE")
      .file(FileUse::write);
  add_control_options(verb, *options);
  add_replay_options(verb, options->replay);
  verb.get_option("--clock").on_given([options] { options->replay.own_clock = true; });
}

}  // namespace biss::cli
