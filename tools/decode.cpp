// `biss decode`: a capture in, a row a request cycle out.
#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "decode/decoder.hpp"
#include "decode/lines.hpp"
#include "decode/statistics.hpp"
#include "tools/capture_input.hpp"
#include "tools/decode_safety.hpp"
#include "tools/decode_summary.hpp"
#include "tools/decode_table.hpp"
#include "tools/format_option.hpp"
#include "tools/verb.hpp"
#include "tools/verbs.hpp"

namespace biss::tools {

namespace {

constexpr std::size_t edges_to_find_lines = std::size_t{1} << 18U;

struct DecodeOptions {
  std::vector<std::string> files;
  FormatArguments device;
  SafetyArguments safety;
  RawSamples raw;
  std::string ma;
  std::string slo;
  bool no_compensation = false;
  std::optional<Picoseconds> resolution;
  std::optional<Picoseconds> since;
  std::optional<Picoseconds> until;
  std::vector<std::string> fail_on;
  std::string output;
  report::Format to = report::Format::table;
};

// What `--fail-on` asks for.
class FailOn {
 public:
  /// \return an empty text, or the one line why a word is wrong
  std::string read(const std::vector<std::string>& words) {
    for (const std::string& word : words) {
      if (word == "any") {
        any_ = true;
      } else if (word == "nE") {
        error_ = true;
      } else if (word == "nW") {
        warning_ = true;
      } else if (word == "marginal") {
        marginal_ = true;
      } else if (word == "safety") {
        safety_ = true;
      } else if (const auto verdict = safety_verdict_of(word)) {
        verdicts_.push_back(*verdict);
      } else if (!read_status(word)) {
        return fmt::format(
            "--fail-on: '{}' is none of any, nE, nW, marginal, safety, its verdicts and the causes "
            "of docs/status.md",
            word);
      }
    }
    return {};
  }

  // Whether only a monitor can tell.
  bool asks_safety() const { return safety_ || !verdicts_.empty(); }

  /// \param safety null where there is no monitor
  bool met_by(const decode::Statistics& statistics, const SafetyWatch* safety) const {
    if (safety != nullptr) {
      if (safety_ && safety->faults() != 0) return true;
      const auto is_seen = [&](SafetyVerdict verdict) { return safety->count(verdict) != 0; };
      if (std::any_of(verdicts_.begin(), verdicts_.end(), is_seen)) return true;
    }
    if (any_ && statistics.failed() != 0) return true;
    if ((error_ || any_) && statistics.errors() != 0) return true;
    if (warning_ && statistics.warnings() != 0) return true;
    if (marginal_ && statistics.marginal() != 0) return true;
    return std::any_of(statuses_.begin(), statuses_.end(),
                       [&](auto status) { return statistics.count(status) != 0; });
  }

 private:
  bool read_status(const std::string& word) {
    for (std::size_t i = 1; i < decode::cycle_status_count; ++i) {
      const auto status = static_cast<decode::CycleStatus>(i);
      if (name_of(status) != word) continue;
      statuses_.push_back(status);
      return true;
    }
    return false;
  }

  bool any_ = false;
  bool error_ = false;
  bool warning_ = false;
  bool marginal_ = false;
  bool safety_ = false;
  std::vector<SafetyVerdict> verdicts_;
  std::vector<decode::CycleStatus> statuses_;
};

std::string line_problem_text(decode::LineProblem problem, const DecodeOptions& options,
                              const CaptureInput& input) {
  std::string names;
  for (std::size_t i = 0; i < std::min<std::size_t>(input.lines().size(), 12); ++i) {
    names += (i == 0 ? "" : ", ") + input.lines()[i];
  }
  switch (problem) {
    case decode::LineProblem::no_such_ma:
      return fmt::format("--ma: no line '{}' in {}; it has {}", options.ma, input.name(), names);
    case decode::LineProblem::no_such_slo:
      return fmt::format("--slo: no line '{}' in {}; it has {}", options.slo, input.name(), names);
    case decode::LineProblem::same_line:
      return "MA and SLO cannot be the same line; name both with --ma and --slo";
    case decode::LineProblem::too_few_lines:
      return fmt::format("{}: fewer than two lines change; MA and SLO are needed", input.name());
    case decode::LineProblem::nothing_behaves:
      return fmt::format(
          "{}: no pair of lines behaves like MA and SLO; it has {}; name them with --ma and --slo",
          input.name(), names);
  }
  return {};
}

bool is_wrong_usage(decode::LineProblem problem) {
  return problem == decode::LineProblem::no_such_ma ||
         problem == decode::LineProblem::no_such_slo || problem == decode::LineProblem::same_line;
}

// One run of the verb; what must live as long as the rows do.
class DecodeRun {
 public:
  explicit DecodeRun(const DecodeOptions& options) : options_(options) {}

  ExitStatus run() {
    if (const std::string wrong = fail_on_.read(options_.fail_on); !wrong.empty()) {
      return fail(ExitStatus::usage, wrong);
    }
    if (options_.device.format.empty()) {
      const std::string wrong = override_timing(options_.device, timing_);
      if (!wrong.empty()) return fail(ExitStatus::usage, wrong);
    } else {
      const DeviceChoice choice = choose_device(options_.device);
      if (!choice) return fail(ExitStatus::usage, choice.error);
      format_ = choice.device->format;
      timing_ = choice.device->timing;
    }
    const ExitStatus opened = input_.open(options_.files, options_.ma, options_.slo, options_.raw);
    if (opened != ExitStatus::done) return opened;
    if (options_.resolution && !is_resolution(*options_.resolution)) {
      return fail(ExitStatus::usage, "--resolution: from 0s to 1ms");
    }
    if (input_.reads(options_.output)) {
      return fail(ExitStatus::usage,
                  fmt::format("-o {}: is the capture itself; name another file", options_.output));
    }
    margin_ = {.compensated = !options_.no_compensation,
               .resolution = options_.resolution.value_or(input_.sample_period())};
    const decode::CycleReader reader(format_, timing_, margin_);
    const auto beginning = input_.look_at_beginning(edges_to_find_lines);
    const auto found = find_lines(input_.lines(), beginning, input_.line_of(options_.ma),
                                  input_.line_of(options_.slo), reader);
    if (!found.ok()) return no_lines(found.error());
    if (const std::string wrong = set_safety(reader, beginning, *found); !wrong.empty()) {
      return fail(ExitStatus::usage, wrong);
    }
    return write_rows(reader, *found);
  }

 private:
  ExitStatus no_lines(decode::LineProblem problem) {
    if (!input_.error().empty()) return fail(ExitStatus::io, input_.error());
    return fail(is_wrong_usage(problem) ? ExitStatus::usage : ExitStatus::data_failed,
                line_problem_text(problem, options_, input_));
  }

  // Needs to know how fast requests come, by the beginning of the capture.
  std::string set_safety(const decode::CycleReader& reader, std::span<const wire::Edge> beginning,
                         const decode::FoundLines& found) {
    if (!format_) {
      return options_.safety.given() || fail_on_.asks_safety()
                 ? "BiSS Safety: what is in the words is not known without -f"
                 : "";
    }
    if (!options_.safety.given() && !is_safety_format(*format_)) {
      return fail_on_.asks_safety() ? "--fail-on: this format is not one of BiSS Safety" : "";
    }
    decode::Statistics first;
    decode::Decoder decoder(reader, [&](const decode::Cycle& cycle) { first.add(cycle); });
    decoder.push(beginning, found.lines);
    const decode::Distribution& interval = first.interval();
    const Picoseconds cycle =
        interval.count() == 0 ? Picoseconds{} : picoseconds(interval.median());
    const SafetyChoice choice =
        choose_safety(options_.safety, options_.device.format, *format_, cycle);
    if (choice.setup) safety_.emplace(*format_, *choice.setup);
    safety_name_ = choice.name;
    return choice.error;
  }

  ExitStatus write_rows(const decode::CycleReader& reader, const decode::FoundLines& found) {
    Output output;
    if (!output.open(options_.output)) return output.status();
    DecodeTable table(format_);
    const auto writer = report::make_table_writer(options_.to, table.columns(), output,
                                                  {.colour = output.wants_colour()});
    std::uint64_t number = 0;
    bool writing = true;
    decode::Decoder decoder(reader, [&](const decode::Cycle& cycle) {
      const std::uint64_t row = number++;
      if (!is_wanted(cycle.time)) return;
      const auto verdict = safety_ ? safety_->judge(cycle) : std::nullopt;
      statistics_.add(cycle);
      writing = writing && writer->row(table.cells(row, cycle, verdict));
    });
    for (auto block = input_.next(); !block.empty() && writing; block = input_.next()) {
      decoder.push(block, found.lines);
    }
    decoder.finish(input_.end_time());
    if (!writing) return output.status();
    if (!input_.error().empty()) {
      writer->finish();
      output.abandon();
      print_summary(summary(found));
      return fail(ExitStatus::io, input_.error());
    }
    if (!writer->finish() || !output.finish()) return output.status();
    return conclude(found);
  }

  static bool is_resolution(Picoseconds time) {
    return time >= Picoseconds{} && time <= milliseconds(1);
  }

  bool is_wanted(Picoseconds time) {
    const bool wanted = (!options_.since || time >= *options_.since) &&
                        (!options_.until || time <= *options_.until);
    if (!wanted) ++passed_over_;
    return wanted;
  }

  // Pulses are no request, and neither is a piece of one among nothing but pulses.
  bool has_request() const {
    const std::uint64_t glitches = statistics_.count(decode::CycleStatus::ma_glitch);
    const std::uint64_t pieces = statistics_.count(decode::CycleStatus::cut_start) +
                                 statistics_.count(decode::CycleStatus::cut_end);
    return statistics_.cycles() > glitches + (glitches != 0 ? pieces : 0);
  }

  ExitStatus conclude(const decode::FoundLines& found) const {
    if (statistics_.cycles() == 0 && passed_over_ != 0) {
      return fail(ExitStatus::data_failed,
                  fmt::format("{}: no request cycle between --since and --until; outside: {}",
                              input_.name(), passed_over_));
    }
    if (!has_request()) {
      return fail(ExitStatus::data_failed,
                  fmt::format("{}: no request cycle found on MA ({}); is it the right line, is the "
                              "time unit right, and did the master ask?",
                              input_.name(), input_.lines()[found.lines.ma]));
    }
    print_summary(summary(found));
    return fail_on_.met_by(statistics_, safety()) ? ExitStatus::data_failed : ExitStatus::done;
  }

  std::string summary(const decode::FoundLines& found) const {
    return decode_summary(statistics_, input_.name(), input_.lines(), found, margin_, safety(),
                          safety_name_);
  }

  const SafetyWatch* safety() const { return safety_ ? &*safety_ : nullptr; }

  const DecodeOptions& options_;
  FailOn fail_on_;
  std::optional<FrameFormat> format_;
  DeviceTiming timing_;
  decode::MarginSetup margin_;
  CaptureInput input_;
  decode::Statistics statistics_;
  std::optional<SafetyWatch> safety_;
  std::string safety_name_;
  std::uint64_t passed_over_ = 0;
};

}  // namespace

void add_decode(Command& command) {
  const auto options = std::make_shared<DecodeOptions>();
  CLI::App& verb = command.add_verb(
      {.name = "decode",
       .purpose = "Read the positions in a capture of MA and SLO, a row a request cycle",
       .examples = {"biss decode capture.vcd -f pos26,nE,nW,crc6",
                    "biss decode capture.csv -f resolute-32 --to csv -o rows.csv",
                    "biss decode ma.csv slo.csv --ma ma.csv:D0 --slo slo.csv:D1 -f fs-36-28",
                    "biss decode samples.bin --raw-rate 100MHz --ma D0 --slo D3 -f resolute-26"}},
      [options] { return DecodeRun(*options).run(); });
  verb.add_option(
      "FILE", options->files,
      "Captures (VCD, event CSV, .sr, Saleae CSV, raw samples); several are read as one; - is "
      "standard input");
  add_format_option(verb, options->device, false);
  add_timing_options(verb, options->device);
  verb.add_option("--ma", options->ma, "The line that is MA")->type_name("NAME|FILE:NAME");
  verb.add_option("--slo", options->slo, "The line that is SLO")->type_name("NAME|FILE:NAME");
  add_raw_options(verb, options->raw);
  add_safety_options(verb, options->safety);
  verb.add_flag("--no-compensation", options->no_compensation,
                "The master samples half a period after its own edges of MA: column marginal is "
                "judged by that, positions are read all the same");
  add_duration_option(verb, "--resolution", into(options->resolution),
                      "Edges may have been so much earlier than the capture says, for column "
                      "marginal; its sample period where the file tells it, else 0");
  add_duration_option(verb, "--since", into(options->since),
                      "Only cycles that begin then or later");
  add_duration_option(verb, "--until", into(options->until),
                      "Only cycles that begin then or earlier");
  verb.add_option("--fail-on", options->fail_on,
                  "Exit with 1 when such a row occurs: nE, nW, marginal, safety (a fault in the "
                  "last column) "
                  "or its verdicts, causes such as crc, or any: nE "
                  "and every cause but cut_start and cut_end")
      ->delimiter(',')
      ->type_name("CAUSE,...");
  add_output_option(verb, options->output);
  add_to_option(verb, options->to);
}

}  // namespace biss::tools
