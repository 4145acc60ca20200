// `biss decode`: a capture in, one row per request cycle out.
#include <fmt/format.h>

#include <algorithm>

#include "biss/frame/format_text.hpp"
#include "cli/common/decoded_capture.hpp"
#include "cli/common/verb.hpp"
#include "cli/common/verbs.hpp"
#include "cli/decode/fail_on.hpp"
#include "cli/decode/motion_options.hpp"
#include "cli/decode/safety.hpp"
#include "cli/decode/summary.hpp"
#include "cli/decode/table.hpp"
#include "decode/limits.hpp"

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
  std::vector<std::string> columns;
  bool only_errors = false;
  std::uint64_t every = 1;
  MotionArguments motion;
};

// What makes the limit known.
std::string_view source_of(decode::Limit limit) {
  switch (limit) {
    case decode::Limit::cycle_min:
      return "-f NAME or --cycle-min";
    case decode::Limit::release:
      return "-f NAME or --timeout";
    default:
      return "-f NAME";
  }
}

// One run of the verb; what must live as long as the rows do.
class DecodeRun {
 public:
  explicit DecodeRun(const DecodeOptions& options) : options_(options) {}

  ExitStatus run() {
    const std::string wrong = fail_on_.read(options_.fail_on);
    if (!wrong.empty()) return fail(ExitStatus::usage, wrong);
    const std::string unusable = options_.motion.wrong_usage();
    if (!unusable.empty()) return fail(ExitStatus::usage, unusable);
    const ExitStatus opened = capture_.open(options_.capture, options_.margin);
    if (opened != ExitStatus::done) return opened;
    if (options_.to == report::Format::vcd && capture_.several()) {
      return fail(ExitStatus::usage, "--to vcd: of one capture and one pair of lines only");
    }
    if (const auto limit = fail_on_.unknown_limit(capture_.timing())) {
      return fail(ExitStatus::usage,
                  fmt::format("--fail-on: {} is not known for this encoder; give {}",
                              name_of(*limit), source_of(*limit)));
    }
    return write_captures(
        capture_, options_.output, TableChoice(options_.to, options_.columns),
        [&] {
          table_.emplace(table_of_capture());
          return table_->columns();
        },
        !options_.fail_on.empty(),
        [&](report::TableWriter& writer, RunMessages& messages) {
          return write_rows(writer, messages);
        });
  }

 private:
  DecodeTable table_of_capture() const {
    const bool varies = capture_.several() && options_.capture.device.format.empty();
    return DecodeTable(capture_.format(), varies, options_.motion.columns());
  }

  // The rows of all captures have the columns of the first one. A capture whose format needs others
  // is judged by its structure.
  void choose_table() {
    DecodeTable own = table_of_capture();
    const auto same_name = [](const report::Column& a, const report::Column& b) {
      return a.name == b.name;
    };
    if (std::equal(own.columns().begin(), own.columns().end(), table_->columns().begin(),
                   table_->columns().end(), same_name)) {
      table_ = std::move(own);
    } else {
      capture_.judge_structure();
    }
  }

  // The format as the user typed it, or as he could.
  std::string format_name() const {
    const std::string& given = options_.capture.device.format;
    return given.empty() && capture_.format() ? std::string(format_text(*capture_.format()).view())
                                              : given;
  }

  // Returns what is wrong, or nothing. The watchdog depends on the rate of requests at the beginning
  // of the capture.
  std::string choose_monitor() {
    const auto& format = capture_.format();
    if (!format) {
      return options_.safety.given() || fail_on_.asks_safety()
                 ? "BiSS Safety: what is in the words is not known without -f"
                 : "";
    }
    if (!options_.safety.given() && !is_safety_format(*format)) {
      return fail_on_.asks_safety() ? "--fail-on: this format is not one of BiSS Safety" : "";
    }
    if (options_.safety.configuration == "off") return "";
    SafetyArguments safety = options_.safety;
    const std::string text = format_name();
    // The shortest cycle of an encoder without a name is not known.
    const bool named =
        !safety.configuration.empty() || implied_configuration(text, *format) != nullptr;
    if (!safety.shortest && !named) safety.shortest = Picoseconds{};
    auto choice = choose_safety(safety, text, *format, capture_.interval());
    if (!choice) return choice.error();
    safety_.emplace(*format, choice->setup);
    safety_name_ = std::move(choice->name);
    return "";
  }

  // The rows of one capture.
  ExitStatus write_rows(report::TableWriter& writer, RunMessages& messages) {
    choose_table();
    statistics_ = {};
    outside_ = 0;
    written_ = 0;
    std::string wrong = choose_monitor();
    if (wrong.empty()) wrong = choose_motion();
    if (!wrong.empty()) return fail(ExitStatus::usage, wrong);
    decode::LimitWatch limits(capture_.timing(), capture_.margin().resolution);
    const bool read = capture_.read([&](std::uint64_t number, const decode::Cycle& cycle) {
      const decode::LimitSet exceeded = limits.judge(cycle);
      if (!is_wanted(cycle.time)) return true;
      const auto verdict = safety_ ? safety_->judge(cycle) : std::nullopt;
      statistics_.add(cycle, exceeded);
      const MotionValues motion = motion_ ? take_position(number, cycle) : MotionValues{};
      if (options_.only_errors && !is_error(cycle, verdict, exceeded)) return true;
      if (options_.every > 1 && written_++ % options_.every != 0) return true;
      if (options_.to == report::Format::vcd && cycle.time < Picoseconds{}) return !before_zero();
      return writer.row(table_->cells(number, cycle, verdict, exceeded, motion));
    });
    if (before_zero_) {
      return messages.fail(ExitStatus::usage,
                           "--to vcd: the capture begins before 0; give --since 0s");
    }
    const std::string summary = decode_summary(statistics_, capture_, safety(), safety_name_);
    if (!read) {
      messages.add_summary(summary);
      return messages.fail(ExitStatus::io, capture_.input().error());
    }
    const std::string& name = capture_.input().name();
    if (statistics_.cycles() == 0 && outside_ != 0) {
      return messages.fail(
          ExitStatus::data_failed,
          fmt::format("{}: no request cycle between --since and --until; outside: {}", name,
                      outside_));
    }
    if (!has_request()) return messages.fail(ExitStatus::data_failed, capture_.no_request());
    messages.add_summary(summary);
    if (lost_) {
      messages.fail(
          ExitStatus::done,
          fmt::format("{}: unwrapped is not known from cycle {} on: the position may have "
                      "moved by more than half of its range; give --max-step",
                      name, *lost_));
    }
    if (!capture_.format() && fail_on_.asks_format()) {
      return messages.fail(ExitStatus::usage,
                           fmt::format("{}: --fail-on: nE, nW and crc are not known without the "
                                       "format of the frame; give -f",
                                       name));
    }
    return fail_on_.met_by(statistics_, safety()) ? ExitStatus::data_failed : ExitStatus::done;
  }

  // Returns what is wrong, or nothing.
  std::string choose_motion() {
    motion_.reset();
    lost_.reset();
    const MotionArguments& asked = options_.motion;
    if (!asked.columns().any()) return "";
    const auto& format = capture_.format();
    if (!format) return "--unwrap, --scale and --velocity need the format of the frame; give -f";
    const std::string& name = options_.capture.device.format;
    const auto device = parse_device(name.empty() ? "none" : name);
    auto motion = make_motion(asked, format->channel_list[0], device ? device->entry : nullptr);
    if (!motion) return motion.error();
    motion_.emplace(std::move(*motion));
    return "";
  }

  MotionValues take_position(std::uint64_t number, const decode::Cycle& cycle) {
    const auto position =
        cycle.frame ? std::optional(cycle.frame->channel_list[0].position) : std::nullopt;
    const MotionValues values = motion_->take(cycle.time, position);
    if (options_.motion.unwrap && !lost_ && motion_->lost()) lost_ = number;
    return values;
  }

  // The rows of --only-errors: those of `--fail-on any` that a format does not explain, and faults of
  // the safety monitor.
  static bool is_error(const decode::Cycle& cycle, std::optional<SafetyVerdict> verdict,
                       decode::LimitSet exceeded) {
    const bool cut = cycle.status == decode::CycleStatus::cut_start ||
                     cycle.status == decode::CycleStatus::cut_end;
    return (!cut && !decode::is_good(cycle.status)) || exceeded != 0 ||
           (cycle.frame && !cycle.frame->trusted()) || (verdict && is_fault(*verdict));
  }

  bool before_zero() { return before_zero_ = true; }

  bool is_wanted(Picoseconds time) {
    const bool wanted = (!options_.since || time >= *options_.since) &&
                        (!options_.until || time <= *options_.until);
    if (!wanted) ++outside_;
    return wanted;
  }

  // Pulses are no request, and neither is a piece of one among nothing but pulses.
  bool has_request() const {
    const std::uint64_t glitches = statistics_.count(decode::CycleStatus::ma_glitch);
    const std::uint64_t pieces = statistics_.count(decode::CycleStatus::cut_start) +
                                 statistics_.count(decode::CycleStatus::cut_end);
    return statistics_.cycles() > glitches + (glitches != 0 ? pieces : 0);
  }

  const decode::SafetyWatch* safety() const { return safety_ ? &*safety_ : nullptr; }

  const DecodeOptions& options_;
  FailOn fail_on_;
  DecodedCapture capture_;
  std::optional<DecodeTable> table_;
  // Of the capture that is being read.
  decode::Statistics statistics_;
  std::optional<decode::SafetyWatch> safety_;
  std::string safety_name_;
  std::uint64_t outside_ = 0;
  std::optional<Motion> motion_;
  // The first cycle whose unwrapped position is not known.
  std::optional<std::uint64_t> lost_;
  // Rows that --every counts.
  std::uint64_t written_ = 0;
  bool before_zero_ = false;
};

void add_row_options(Verb verb, DecodeOptions& options) {
  verb.add_option("--columns", options.columns, "Write these columns only, in this order")
      .delimiter(',')
      .type_name("NAME,...");
  verb.add_flag("--only-errors", options.only_errors,
                "Write only rows with an error: a status other than ok, unchecked, cut_start and "
                "cut_end, nE = 0, a limit or a fault in the column safety");
  add_count_option(
      verb, "--every",
      [&options](std::uint64_t count) {
        if (count == 0) wrong_value("--every", "'0' is not 1 or more");
        options.every = count;
      },
      "Write the first and then every N-th of the rows");
}

}  // namespace

void add_decode(Command& command) {
  const auto options = std::make_shared<DecodeOptions>();
  options->capture.identify = true;
  Verb verb = command.add_verb(
      {.name = "decode",
       .purpose = "Read the positions in a capture of MA and SLO, one row per request cycle",
       .examples =
           {"biss decode capture.vcd -f pos26,nE,nW,crc6",
            "biss decode capture.csv -f resolute-32 --to csv -o rows.csv",
            "biss decode capture.sr -f resolute-26 --to hdf5 -o rows.h5",
            "biss decode capture.sr -f resolute-26 --scale deg --velocity --to vcd -o motion.vcd",
            "biss decode ma.csv slo.csv --ma ma.csv:D0 --slo slo.csv:D1 -f fs-36-28",
            "biss decode samples.bin --raw-rate 100MHz --ma D0 --slo D3 -f resolute-26"}},
      [options] { return DecodeRun(*options).run(); });
  add_capture_options(verb, options->capture);
  add_safety_options(verb, options->safety);
  verb.add_flag("--no-compensation", options->margin.no_compensation,
                "Compute the column marginal for a master that samples half a period after its own "
                "edges of MA; positions are unaffected");
  add_time_option(verb, "--since", into(options->since), "Skip cycles that begin before this time");
  add_time_option(verb, "--until", into(options->until), "Skip cycles that begin after this time");
  verb.add_option(
          "--fail-on", options->fail_on,
          "Exit with 1 if such a row occurs: nE, nW, marginal, safety (a fault in that "
          "column), one of its verdicts, limits, one of these such as clock_max, a status such "
          "as crc, or any: nE, limits and every status but ok, cut_start and cut_end")
      .delimiter(',')
      .type_name("CAUSE,...");
  verb.add_flag("--no-verify", options->capture.no_verify,
                "Do not verify the checksums of compressed samples (.sr, .dsl)");
  add_count_option(verb, "--threads", into(options->capture.threads),
                   "Worker threads; by default one per core. The rows do not depend on it", 1024);
  add_row_options(verb, *options);
  add_motion_options(verb.section("Motion"), options->motion);
  add_output_option(verb, options->output,
                    "Output file; standard output (-) by default, but --to hdf5 needs a file");
  add_to_option(verb, options->to,
                {report::Format::table, report::Format::csv, report::Format::jsonl,
                 report::Format::vcd, report::Format::hdf5});
}

}  // namespace biss::cli
