// `biss decode`: a capture in, a row a request cycle out.
#include <fmt/format.h>

#include "cli/common/decoded_capture.hpp"
#include "cli/common/fail_on.hpp"
#include "cli/common/verb.hpp"
#include "cli/common/verbs.hpp"
#include "cli/decode/safety.hpp"
#include "cli/decode/summary.hpp"
#include "cli/decode/table.hpp"

namespace biss::cli {

namespace {

struct DecodeOptions {
  CaptureArguments capture;
  MarginArguments margin;
  SafetyArguments safety;
  std::optional<Picoseconds> since;
  std::optional<Picoseconds> until;
  std::vector<std::string> fail_on;
  std::string output;
  report::Format to = report::Format::table;
};

// One run of the verb; what must live as long as the rows do.
class DecodeRun {
 public:
  explicit DecodeRun(const DecodeOptions& options) : options_(options) {}

  ExitStatus run() {
    std::string wrong = fail_on_.read(options_.fail_on);
    if (!wrong.empty()) return fail(ExitStatus::usage, wrong);
    const ExitStatus opened = capture_.open(options_.capture, {options_.output}, options_.margin);
    if (opened != ExitStatus::done) return opened;
    wrong = set_safety();
    return wrong.empty() ? write_rows() : fail(ExitStatus::usage, wrong);
  }

 private:
  // Needs to know how fast requests come, by the beginning of the capture.
  std::string set_safety() {
    const auto& format = capture_.format();
    if (!format) {
      return options_.safety.given() || fail_on_.asks_safety()
                 ? "BiSS Safety: what is in the words is not known without -f"
                 : "";
    }
    if (!options_.safety.given() && !is_safety_format(*format)) {
      return fail_on_.asks_safety() ? "--fail-on: this format is not one of BiSS Safety" : "";
    }
    const SafetyChoice choice = choose_safety(options_.safety, options_.capture.device.format,
                                              *format, capture_.interval());
    if (choice.setup) safety_.emplace(*format, *choice.setup);
    safety_name_ = choice.name;
    return choice.error;
  }

  ExitStatus write_rows() {
    Output output;
    if (!output.open(options_.output)) return output.status();
    DecodeTable table(capture_.format());
    const auto writer = report::make_table_writer(options_.to, table.columns(), output,
                                                  {.colour = output.wants_colour()});
    bool writing = true;
    const bool read = capture_.read([&](std::uint64_t number, const decode::Cycle& cycle) {
      if (!is_wanted(cycle.time)) return true;
      const auto verdict = safety_ ? safety_->judge(cycle) : std::nullopt;
      statistics_.add(cycle);
      writing = writer->row(table.cells(number, cycle, verdict));
      return writing && !is_over(output);
    });
    if (!writing || is_over(output)) return output.status();
    if (!read) {
      writer->finish();
      output.abandon();
      print_summary(summary());
      return fail(ExitStatus::io, capture_.input().error());
    }
    if (!writer->finish() || !output.finish()) return output.status();
    return conclude();
  }

  // The reader of the rows has left, and no judgement needs the rest.
  bool is_over(const Output& output) const {
    return output.reader_left() && options_.fail_on.empty();
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

  ExitStatus conclude() const {
    if (statistics_.cycles() == 0 && passed_over_ != 0) {
      return fail(ExitStatus::data_failed,
                  fmt::format("{}: no request cycle between --since and --until; outside: {}",
                              capture_.input().name(), passed_over_));
    }
    if (!has_request()) return capture_.no_request();
    print_summary(summary());
    return fail_on_.met_by(statistics_, safety()) ? ExitStatus::data_failed : ExitStatus::done;
  }

  std::string summary() const {
    return decode_summary(statistics_, capture_, safety(), safety_name_);
  }

  const decode::SafetyWatch* safety() const { return safety_ ? &*safety_ : nullptr; }

  const DecodeOptions& options_;
  FailOn fail_on_;
  DecodedCapture capture_;
  decode::Statistics statistics_;
  std::optional<decode::SafetyWatch> safety_;
  std::string safety_name_;
  std::uint64_t passed_over_ = 0;
};

}  // namespace

void add_decode(Command& command) {
  const auto options = std::make_shared<DecodeOptions>();
  Verb verb = command.add_verb(
      {.name = "decode",
       .purpose = "Read the positions in a capture of MA and SLO, a row a request cycle",
       .examples = {"biss decode capture.vcd -f pos26,nE,nW,crc6",
                    "biss decode capture.csv -f resolute-32 --to csv -o rows.csv",
                    "biss decode ma.csv slo.csv --ma ma.csv:D0 --slo slo.csv:D1 -f fs-36-28",
                    "biss decode samples.bin --raw-rate 100MHz --ma D0 --slo D3 -f resolute-26"}},
      [options] { return DecodeRun(*options).run(); });
  add_capture_options(verb, options->capture);
  add_safety_options(verb, options->safety);
  verb.add_flag("--no-compensation", options->margin.no_compensation,
                "Judge the column marginal for a master that samples half a period after its own "
                "edges of MA; positions are unaffected");
  add_time_option(verb, "--since", into(options->since), "Only cycles that begin then or later");
  add_time_option(verb, "--until", into(options->until), "Only cycles that begin then or earlier");
  verb.add_option("--fail-on", options->fail_on,
                  "Exit with 1 when such a row occurs: nE, nW, marginal, safety (a fault in that "
                  "column), one of its verdicts, a status such as crc, or any: nE and every status "
                  "but ok, cut_start and cut_end")
      .delimiter(',')
      .type_name("CAUSE,...");
  add_output_option(verb, options->output);
  add_to_option(verb, options->to);
}

}  // namespace biss::cli
