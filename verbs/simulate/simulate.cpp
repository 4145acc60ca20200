// `biss simulate`: a master, a cable and encoders, written as a capture, with the true values in a
// second file.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "sim/line.hpp"
#include "verbs/common/access_option.hpp"
#include "verbs/common/capture_output.hpp"
#include "verbs/common/verb.hpp"
#include "verbs/simulate/fault_option.hpp"
#include "verbs/simulate/line_options.hpp"
#include "verbs/simulate/replay.hpp"
#include "verbs/simulate/setup.hpp"
#include "verbs/simulate/write.hpp"

namespace biss::verbs {

namespace {

struct SimulateOptions {
  LineOptions line;
  ReplayOptions replay;
  WriteOptions write;
  std::vector<std::string> registers;
  std::vector<std::string> accesses;
};

// Times in 64-bit picoseconds hold a little more.
constexpr Picoseconds longest_capture = milliseconds(100LL * 24 * 3600 * 1000);

class SimulateRun {
 public:
  SimulateRun(const SimulateOptions& options, Host& host) : options_(options), host_(host) {}

  ExitStatus run() {
    const auto format = capture_format_of(options_.write.output);
    if (is_only_read(options_.write.output)) {
      throw wrong_usage(
          "--output: '{}': the extension names a format that is not written; use .vcd, .csv, .sr, "
          ".dsl, .bin or .raw",
          options_.write.output);
    }
    if (options_.write.sample_rate && !is_sampled(format.value_or(CaptureFormat::vcd))) {
      throw wrong_usage(
          "--sample-rate: this format stores changes, not samples; write .sr, .dsl, .bin or .raw");
    }
    const bool replays = !options_.replay.ma_from.empty() || !options_.replay.slo_from.empty();
    if (options_.replay.raw.rate && !replays) {
      throw wrong_usage("--raw-rate: needs --ma-from or --slo-from; for -o use --sample-rate");
    }
    if (options_.replay.raw.analog.given() && !replays) {
      throw wrong_usage("--threshold and --differential: need --ma-from or --slo-from");
    }
    LineOptions line = options_.line;
    load_control(line);
    if (line.device.format.empty()) {
      throw wrong_usage("give --format, or --registers with a profile identifier for each encoder");
    }
    if (replays) {
      const auto replay = options_.replay.ma_from.empty() ? replay_slo : replay_ma;
      return replay(options_.replay, options_.write, line, host_);
    }
    const sim::LineSetup setup = value_or_fail(line_setup(line));
    fail_if(check_run(setup));
    WriteOptions write = options_.write;
    if (const std::string wrong = put_then(line, setup, write); !wrong.empty()) {
      throw wrong_usage("--then: {}", wrong);
    }
    return write_line(setup, write, host_);
  }

 private:
  void load_control(LineOptions& line) const {
    put_registers(options_.registers, line, host_);
    line.setup.accesses = read_accesses(options_.accesses);
    if (line.setup.accesses.empty() && !options_.write.outcomes.empty()) {
      throw wrong_usage("--outcomes: needs --access");
    }
  }

  // The line after a change of the format, or why there is none.
  std::string put_then(const LineOptions& first, const sim::LineSetup& setup,
                       WriteOptions& write) const {
    if (first.then.empty()) return {};
    const std::size_t at = first.then.rfind('@');
    const auto cycle = parse_count(first.then.substr(std::min(at + 1, first.then.size())));
    if (at == std::string::npos || !cycle.ok() || *cycle == 0) {
      return fmt::format("'{}' is not FORMAT@CYCLE", first.then);
    }
    const std::uint64_t cycles = write.cycles.value_or(usual_cycles);
    if (*cycle >= cycles) {
      return fmt::format("no cycle {}; the last one is {}", *cycle, cycles - 1);
    }
    if (setup.has_control() || write.configure) return "not with registers or accesses";
    LineOptions second = first;
    second.device.format = first.then.substr(0, at);
    const auto changed = line_setup(second);
    if (!changed) return changed.error();
    if (changed->format.channel_count != setup.format.channel_count) {
      return fmt::format("as many channels as before, {}", setup.format.channel_count);
    }
    write.then = *changed;
    write.then_cycle = *cycle;
    return check_run(*changed);
  }

  // Why the line, the faults and the accesses do not fit into this many cycles; empty if they do.
  std::string check_run(const sim::LineSetup& setup) const {
    if (std::string wrong = wrong_start(setup); !wrong.empty()) return wrong;
    const sim::NominalCycle nominal = sim::Line(setup).nominal();
    const std::uint64_t least = least_cycles(setup.accesses);
    const std::uint64_t cycles = options_.write.cycles.value_or(std::max(usual_cycles, least));
    const std::int64_t most = longest_capture.count / nominal.interval.count;
    if (cycles > static_cast<std::uint64_t>(most)) {
      return fmt::format("--cycles: a capture holds 100 days, which are {} cycles at this rate",
                         most);
    }
    if (cycles < least) {
      return fmt::format(
          "--cycles: the accesses take at least {}; without --cycles the run is as long as they "
          "need",
          least);
    }
    return wrong_faults(setup.faults, nominal, cycles);
  }

  const SimulateOptions& options_;
  Host& host_;
};

void add_control_options(Verb verb, SimulateOptions& options) {
  add_register_options(verb, options.registers, options.line);
  verb.add_option(
          "--access", options.accesses,
          "Read registers, write registers or send a command, in addition to the requests for "
          "positions: read:0x42,2, 1/write:0x48=01FF, 0/command:channels, read:0@500 (not "
          "before cycle 500), or the accesses in a file, one per line")
      .type_name("[ID/]ACCESS|@FILE")
      .file(FileUse::read, file_of_accesses);
  add_count_option(verb, "--retries", into(options.line.setup.control.retries),
                   "Number of times to repeat a failed access; 0 by default", 255);
  verb.add_option("--outcomes", options.write.outcomes,
                  "Write the outcomes of the accesses as CSV, or as JSON lines to FILE.jsonl")
      .file(FileUse::write);
  verb.add_flag("--configure", options.write.configure,
                "Configure the master from the encoders' registers before it reads positions");
}

// The recorded side has no options; giving them is a mistake.
void add_replay_options(Verb verb, ReplayOptions& replay) {
  Option& ma_from = verb.add_option(
      "--ma-from", replay.ma_from,
      "Answer the requests in this capture: write its MA and the simulated SLO. For a master that "
      "waits for START, feed that SLO to it, record its MA again, and repeat");
  Option& slo_from =
      verb.add_option("--slo-from", replay.slo_from,
                      "Read the encoder in this capture: write its SLO and the simulated MA");
  ma_from.file(FileUse::read).excludes(slo_from);
  slo_from.file(FileUse::read);
  for (const char* name : {"--rate", "--cycles", "--fault", "--pause", "--pause-every", "--then",
                           "--jitter", "--ma-jitter", "--slo-jitter", "--at-slave", "--clock-error",
                           "--duty", "--access", "--retries", "--outcomes", "--configure"}) {
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
  verb.add_option("--positions", replay.positions,
                  "Positions of the answers of --ma-from, one per line; after the last one the "
                  "list starts again")
      .file(FileUse::read)
      .needs(ma_from)
      .excludes(verb.get_option("--motion"));
  verb.add_option("--rerun", replay.rerun,
                  "Command that runs the master again with the output as its SLO, and writes the "
                  "capture of --ma-from again; run until every request is answered up to STOP")
      .type_name("COMMAND")
      .needs(ma_from);
  verb.add_option("--ma", replay.ma, "Line of the capture that is MA").type_name("NAME");
  verb.add_option("--slo", replay.slo, "Line of the capture that is SLO")
      .type_name("NAME")
      .needs(slo_from);
  add_raw_options(verb, replay.raw);
  verb.add_option("--readings", replay.readings,
                  "Write the readings of --slo-from as CSV, with the columns of decode")
      .file(FileUse::write)
      .needs(slo_from);
}

void add_output_options(Verb verb, WriteOptions& write, LineOptions& line) {
  add_output_option(verb, write.output, "Output file; - is standard output").required();
  add_count_option(verb, "--cycles", into(write.cycles),
                   "Request cycles; 100 by default, or as many as --access takes", 100'000'000);
  add_rate_option(
      verb, "--sample-rate", into(write.sample_rate),
      "Samples per second of .sr, .bin and .raw; by default the lowest of 1, 2, 5, 10 … "
      "that is at least eight times the clock");
  verb.add_flag("--at-slave", line.setup.record_at_slave, "Also record MA and SLO at the encoder");
  verb.add_option("--truth", write.truth,
                  "Write the values that the encoder meant to send, and the faults, as CSV")
      .file(FileUse::write);
}

}  // namespace

void add_simulate(Command& command) {
  const auto options = std::make_shared<SimulateOptions>();
  Verb verb = command.add_verb(
      {.name = "simulate",
       .purpose = "Simulate a master that reads an encoder, and write the capture",
       .examples =
           {"biss simulate -f resolute-26 --clock 10MHz --cable 50m -o line.vcd",
            "biss simulate -f resolute-18 --fault flip:0.1 --fault cut@40,bit=5 -o line.csv "
            "--truth truth.csv",
            "biss simulate -f resolute-26 --clock 10MHz --sample-rate 200MHz -o line.sr",
            "biss simulate --registers encoder.hex --access read:0x78,8 --outcomes - "
            "-o line.vcd",
            "biss simulate -f pos26,nE,nW,crc6 --ma-from master.vcd -o answered.vcd",
            "biss simulate -f pos26,nE,nW,crc6 --ma-from master.vcd --rerun 'vvp bench.vvp' "
            "--positions positions.txt -o answered.csv"}},
      [options](Host& host) { return SimulateRun(*options, host).run(); });
  add_line_options(verb, options->line, MasterKind::simulated);
  add_control_options(verb.section("Registers"), *options);
  add_output_options(verb.section("Output"), options->write, options->line);
  add_replay_options(verb.section("Replay"), options->replay);
  verb.after_parsing([options, &clock = verb.get_option("--clock")] {
    options->replay.own_clock = !clock.given.empty();
  });
}

}  // namespace biss::verbs
