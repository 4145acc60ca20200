// `biss conform`: an encoder judged by a capture of it, rule by rule.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>
#include <vector>

#include "cli/common/decoded_capture.hpp"
#include "cli/common/verbs.hpp"
#include "decode/conformance.hpp"
#include "report/summary.hpp"

namespace biss::cli {

namespace {

using decode::Rule;
using decode::RuleResult;
using decode::Verdict;
using report::Cell;
using report::Kind;

struct ConformOptions {
  CaptureArguments capture;
  std::string output;
  report::Format to = report::Format::table;
};

// Limits are times for some rules and counts for others. A count is written as whole nanoseconds,
// which look the same.
const std::vector<report::Column>& columns() {
  static const std::vector<report::Column> all{{.name = "rule", .kind = Kind::text},
                                               {.name = "limit", .kind = Kind::nanoseconds},
                                               {.name = "worst", .kind = Kind::nanoseconds},
                                               {.name = "unit", .kind = Kind::text},
                                               {.name = "margin", .kind = Kind::nanoseconds},
                                               {.name = "cycle", .kind = Kind::unsigned_integer},
                                               {.name = "verdict", .kind = Kind::text},
                                               {.name = "cases", .kind = Kind::unsigned_integer},
                                               {.name = "source", .kind = Kind::text},
                                               {.name = "note", .kind = Kind::text}};
  return all;
}

Picoseconds count_of(std::uint64_t count) {
  return nanoseconds(static_cast<std::int64_t>(std::min<std::uint64_t>(count, INT64_MAX / 1'000)));
}

void put(report::TableWriter& writer, Rule rule, const RuleResult& result) {
  const decode::RuleText& text = text_of(rule);
  std::array<Cell, 10> cells{};
  cells[0] = text.name;
  cells[3] = text.unit;
  if (result.time) {
    cells[1] = result.time->limit;
    cells[2] = result.time->worst;
    cells[4] = result.time->margin;
  } else if (text.unit != "ns" && result.verdict != Verdict::not_judged) {
    cells[1] = Picoseconds{};
    cells[2] = count_of(result.faults);
    cells[4] = -count_of(result.faults);
  }
  cells[5] = result.cycle;
  cells[6] = name_of(result.verdict);
  cells[7] = result.cases;
  cells[8] = text.source;
  if (!result.note.empty()) cells[9] = result.note;
  writer.row(cells);
}

class ConformRun {
 public:
  explicit ConformRun(const ConformOptions& options) : options_(options) {}

  ExitStatus run() {
    const ExitStatus opened = capture_.open(options_.capture);
    if (opened != ExitStatus::done) return opened;
    return write_captures(capture_, options_.output, options_.to, columns, true,
                          [&](report::TableWriter& writer, RunMessages& messages) {
                            return judge(writer, messages);
                          });
  }

 private:
  // The rows of one capture.
  ExitStatus judge(report::TableWriter& writer, RunMessages& messages) {
    decode::Conformance conformance(capture_.format(), capture_.timing());
    std::uint64_t cycles = 0;
    const bool read = capture_.read([&](std::uint64_t number, const decode::Cycle& cycle) {
      ++cycles;
      conformance.push(number, cycle);
      return true;
    });
    conformance.finish();
    if (!read) return messages.fail(ExitStatus::io, capture_.input().error());
    if (cycles == 0) return messages.fail(ExitStatus::data_failed, capture_.no_request());
    std::array<unsigned, 4> verdicts{};
    for (std::size_t i = 0; i < decode::rule_count; ++i) {
      const auto rule = static_cast<Rule>(i);
      const RuleResult result = conformance.result(rule);
      ++verdicts[static_cast<std::size_t>(result.verdict)];
      put(writer, rule, result);
    }
    messages.add_summary(summary(verdicts));
    const bool failed = verdicts[static_cast<std::size_t>(Verdict::fail)] != 0;
    return failed ? ExitStatus::data_failed : ExitStatus::done;
  }

  std::string summary(const std::array<unsigned, 4>& verdicts) const {
    std::string counted;
    for (std::size_t i = 0; i < verdicts.size(); ++i) {
      if (verdicts[i] == 0) continue;
      counted += fmt::format("{}{} {}", counted.empty() ? "" : ", ", verdicts[i],
                             name_of(static_cast<Verdict>(i)));
    }
    report::Summary out;
    out.title(fmt::format("{}: {} rules", capture_.input().name(), decode::rule_count));
    out.entry("verdict", counted);
    return out.text();
  }

  const ConformOptions& options_;
  DecodedCapture capture_;
};

}  // namespace

void add_conform(Command& command) {
  const auto options = std::make_shared<ConformOptions>();
  Verb verb = command.add_verb(
      {.name = "conform",
       .purpose = "Check in a capture, rule by rule, whether an encoder conforms to BiSS C",
       .examples = {"biss conform capture.vcd -f pos26,nE,nW,crc6",
                    "biss conform capture.sr -f pos26,nE,nW,crc6 --timeout adaptive:680ns",
                    "biss conform capture.vcd --to jsonl"}},
      [options] { return ConformRun(*options).run(); });
  add_capture_options(verb, options->capture);
  add_output_option(verb, options->output);
  add_to_option(verb, options->to);
}

}  // namespace biss::cli
