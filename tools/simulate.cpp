// `biss simulate`: master, cable and encoder on the wire, written as a capture, the truth beside
// it.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "sim/ideal_line.hpp"
#include "tools/capture_output.hpp"
#include "tools/format_option.hpp"
#include "tools/simulate_truth.hpp"
#include "tools/verb.hpp"
#include "tools/verbs.hpp"

namespace biss::tools {

namespace {

struct SimulateOptions {
  FormatArguments device;
  Hertz clock = megahertz(1);
  Millimetres cable{};
  std::optional<Hertz> rate;
  std::optional<Hertz> sample_rate;
  std::uint64_t cycles = 100;
  std::string motion = "ramp";
  std::vector<std::string> faults;
  std::uint64_t seed = 1;
  std::string output;
  std::string truth;
};

constexpr std::array<std::string_view, 3> motions{"constant", "ramp", "random"};

// Round trip of a signal in the cable: Renishaw "BiSS C-mode (unidirectional)", "Timing
// information".
constexpr Picoseconds cable_delay_per_metre = nanoseconds(10);

// `flip:0.1`, exact to a part in 10^9. \return an empty text, or the one line why not
std::string read_fault(const std::string& text, std::uint64_t& flip_share) {
  const std::string wrong =
      fmt::format("--fault: '{}' is not KIND:RATE; the kind is flip, the rate 0 to 1", text);
  if (!text.starts_with("flip:")) return wrong;
  const std::string rate = text.substr(5);
  if (rate == "1") {
    flip_share = std::uint64_t{1} << 32U;
    return {};
  }
  if (rate == "0") return {};
  if (!rate.starts_with("0.") || rate.size() > 11 || rate.size() < 3) return wrong;
  std::uint64_t parts = 0;
  std::uint64_t whole = 1;
  for (const char c : rate.substr(2)) {
    if (c < '0' || c > '9') return wrong;
    parts = parts * 10 + static_cast<std::uint64_t>(c - '0');
    whole *= 10;
  }
  flip_share = (parts << 32U) / whole;
  return {};
}

class SimulateRun {
 public:
  explicit SimulateRun(const SimulateOptions& options) : options_(options) {}

  ExitStatus run() {
    const DeviceChoice choice = choose_device(options_.device);
    if (!choice) return fail(ExitStatus::usage, choice.error);
    if (const std::string wrong = prepare(*choice.device); !wrong.empty()) {
      return fail(ExitStatus::usage, wrong);
    }
    return write();
  }

 private:
  std::string prepare(const Device& device) {
    setup_.format = device.format;
    setup_.timing = device.timing;
    setup_.clock = options_.clock;
    setup_.seed = options_.seed;
    setup_.line_delay =
        device.timing.internal_delay_max + cable_delay_per_metre * options_.cable.count / 1000;
    const auto motion = std::find(motions.begin(), motions.end(), options_.motion);
    if (motion == motions.end()) {
      return fmt::format("--motion: '{}' is not one of constant, ramp, random", options_.motion);
    }
    setup_.motion = static_cast<sim::MotionKind>(motion - motions.begin());
    for (const std::string& fault : options_.faults) {
      if (std::string wrong = read_fault(fault, setup_.flip_share); !wrong.empty()) return wrong;
    }
    if (options_.clock < device.timing.clock_min || options_.clock > device.timing.clock_max) {
      return fmt::format("--clock: this encoder takes {} to {}", text_of(device.timing.clock_min),
                         text_of(device.timing.clock_max));
    }
    if (options_.sample_rate && !CaptureOutput::is_sampled(options_.output)) {
      return "--sample-rate: this output holds changes, not samples; write .sr, .bin or .raw";
    }
    if (!options_.rate) return {};
    setup_.interval = period_of(*options_.rate);
    const Picoseconds least = sim::IdealLine(setup_).least_interval();
    if (setup_.interval >= least) return {};
    return fmt::format(
        "--rate: a cycle takes {}, so at most {} is feasible", text_of(least, 3),
        text_of(Hertz{static_cast<std::uint32_t>(picoseconds_per_second / least.count)}));
  }

  ExitStatus write() {
    Output output;
    if (!output.open(options_.output)) return output.status();
    Output truth_output;
    if (!options_.truth.empty() && !truth_output.open(options_.truth)) return truth_output.status();
    CaptureOutput edges(options_.output, {"MA", "SLO"},
                        options_.sample_rate.value_or(usual_sample_rate(options_.clock)), output);
    TruthTable truth(setup_.format);
    std::unique_ptr<report::TableWriter> rows;
    if (!options_.truth.empty()) {
      rows = report::make_table_writer(report::Format::csv, truth.columns(), truth_output);
    }
    sim::IdealLine line(setup_);
    Picoseconds end{};
    for (std::uint64_t i = 0; i < options_.cycles; ++i) {
      const sim::SimulatedCycle cycle = line.next();
      if (!edges.write(first_levels(i)) || !edges.write(cycle.edges)) return edges.status();
      if (rows && !rows->row(truth.cells(i, cycle))) return truth_output.status();
      end = cycle.edges.back().time + 20 * period_of(options_.clock);
    }
    if (!edges.finish(end)) return edges.status();
    if (!output.finish()) return output.status();
    if (rows && (!rows->finish() || !truth_output.finish())) return truth_output.status();
    return ExitStatus::done;
  }

  // Both lines idle high from time 0 on.
  static std::vector<wire::Edge> first_levels(std::uint64_t cycle) {
    if (cycle != 0) return {};
    return {{{}, sim::ma_line, wire::Level::high}, {{}, sim::slo_line, wire::Level::high}};
  }

  const SimulateOptions& options_;
  sim::IdealLineSetup setup_;
};

}  // namespace

void add_simulate(Command& command) {
  const auto options = std::make_shared<SimulateOptions>();
  CLI::App& verb = command.add_verb(
      {.name = "simulate",
       .purpose = "Write a capture of a master reading an encoder on an ideal line",
       .examples =
           {"biss simulate -f resolute-26 --clock 10MHz --cable 50m -o line.vcd",
            "biss simulate -f pos18,nE,nW,crc6 --fault flip:0.1 --seed 7 -o line.csv --truth "
            "truth.csv",
            "biss simulate -f resolute-26 --clock 10MHz --sample-rate 200MHz -o line.sr"}},
      [options] { return SimulateRun(*options).run(); });
  add_format_option(verb, options->device, true);
  add_timing_options(verb, options->device);
  add_rate_option(verb, "--clock", into(options->clock), "MA's frequency; 1 MHz by default");
  add_length_option(verb, "--cable", into(options->cable), "Cable, 10 ns of line delay a metre");
  add_rate_option(verb, "--rate", into(options->rate),
                  "Requests a second; as fast as the encoder is ready by default");
  add_count_option(verb, "--cycles", into(options->cycles), "Request cycles; 100 by default",
                   100'000'000);
  verb.add_option("--motion", options->motion, "constant, ramp (the default) or random")
      ->type_name("KIND");
  verb.add_option("--fault", options->faults,
                  "flip:RATE flips a bit of data or CRC on the line in that share of cycles")
      ->type_name("KIND:RATE");
  add_count_option(verb, "--seed", into(options->seed), "Seed of positions and faults");
  add_rate_option(verb, "--sample-rate", into(options->sample_rate),
                  "Samples a second of .sr, .bin and .raw; the next of 1, 2, 5, 10 … from eight "
                  "times the clock on by default");
  add_output_option(verb, options->output)->required();
  verb.add_option("--truth", options->truth, "What the encoder meant to send, as CSV")
      ->type_name("FILE");
}

}  // namespace biss::tools
