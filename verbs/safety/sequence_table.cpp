#include "verbs/safety/sequence_table.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <optional>
#include <vector>

#include "verbs/safety/campaign_table.hpp"

namespace biss::verbs {
namespace {

using lab::SequenceResult;
using lab::SequenceTask;
using report::Cell;
using report::Kind;

// The text of a row's cells; cells do not own their text.
struct Texts {
  std::optional<std::string> theory;
  std::optional<std::string> sigma;
  std::string verdicts;
  std::string odd;
  std::string_view result;

  explicit Texts(const SequenceResult& result_row)
      : verdicts(verdicts_of(result_row.counts)),
        odd(fmt::format("{}", fmt::join(result_row.counts.odd, ";"))),
        result(result_row.passed() ? "ok" : "failed") {
    const auto& [row, counts, share, deviation, bound] = result_row;
    if (share) theory = fmt::format("{:.4g}", static_cast<double>(*share));
    if (deviation) sigma = sigma_text(*deviation);
  }

 private:
  static std::string verdicts_of(const lab::SequenceCounts& counts) {
    std::string text;
    for (std::size_t k = 0; k < counts.verdicts.size(); ++k) {
      if (counts.verdicts[k] == 0) continue;
      if (!text.empty()) text += ' ';
      text += fmt::format("{}:{}", name_of(verdict_of(k)), counts.verdicts[k]);
    }
    return text;
  }
};

Cell text(const std::optional<std::string>& value) { return value ? Cell(*value) : Cell(); }

std::vector<report::Column> columns_for(report::Format to) {
  const bool readable = to == report::Format::table;
  const auto count = [](const char* name, const char* heading) {
    return report::Column{.name = name, .kind = Kind::unsigned_integer, .heading = heading};
  };
  std::vector<report::Column> columns = {{.name = "run"},
                                         {.name = "variant"},
                                         {.name = "counter"},
                                         {.name = "encoder_counter", .heading = "encoder"},
                                         count("frames", ""),
                                         count("false_alarms", "alarms"),
                                         count("misread", ""),
                                         count("events", ""),
                                         count("accepted", ""),
                                         {.name = "theory"},
                                         {.name = "sigma"},
                                         count("worst_cycles", "cycles"),
                                         count("bound_cycles", "bound"),
                                         count("late", ""),
                                         count("unexpected", ""),
                                         {.name = "result", .role = report::Role::status},
                                         {.name = "verdicts"}};
  if (readable) return columns;
  for (const char* name : {"wrong", "position_wraps", "counter_wraps"}) {
    columns.push_back(count(name, ""));
  }
  columns.push_back({.name = "odd"});
  return columns;
}

}  // namespace

bool write_sequences(std::span<const SequenceResult> results, report::Format to,
                     report::TextSink& sink, const report::TableOptions& table_options) {
  const std::vector<report::Column> columns = columns_for(to);
  const auto table = report::make_table_writer(to, columns, sink, table_options);
  for (const SequenceResult& each : results) {
    const Texts texts(each);
    const lab::SequenceCounts& counts = each.counts;
    const bool undamaged = each.row.task == SequenceTask::undamaged;
    const auto of_event = [&](std::uint64_t value) { return undamaged ? Cell() : Cell(value); };
    std::vector<Cell> cells = {each.row.name(),
                               each.row.variant_name(),
                               lab::name_of(each.row.counter),
                               lab::name_of(each.row.encoder_counter),
                               counts.frames,
                               counts.false_alarms,
                               counts.misread,
                               of_event(counts.events),
                               of_event(counts.accepted),
                               undamaged ? Cell() : text(texts.theory),
                               text(texts.sigma),
                               of_event(counts.worst_cycles),
                               of_event(each.bound_cycles),
                               of_event(counts.late),
                               of_event(counts.unexpected),
                               texts.result,
                               texts.verdicts};
    if (to != report::Format::table) {
      cells.insert(cells.end(), {of_event(counts.wrong), counts.position_wraps,
                                 counts.counter_wraps, texts.odd});
    }
    if (!table->row(cells)) return false;
  }
  return table->finish();
}

std::string failure_of(const SequenceResult& result) {
  std::string text = fmt::format("{} {}:", result.row.name(), result.row.variant_name());
  const lab::SequenceCounts& counts = result.counts;
  const auto add = [&text](std::uint64_t count, const char* what) {
    if (count != 0) text += fmt::format(" {} {},", count, what);
  };
  add(counts.false_alarms, "false alarms");
  add(counts.misread, "misread");
  add(counts.late, "late");
  add(counts.unexpected, "with a verdict that is none of the error's");
  if (result.sigma && std::abs(*result.sigma) > lab::sequence_sigma_limit) {
    text += fmt::format(" {} accepted are {:+.1f} standard deviations from the theory,",
                        counts.accepted, *result.sigma);
  } else if (result.theory && *result.theory == 0 && counts.accepted != 0) {
    text += fmt::format(" {} accepted that must be 0,", counts.accepted);
  }
  text.back() = ';';
  return text + fmt::format(" the first at {}", fmt::join(counts.odd, ", "));
}

}  // namespace biss::verbs
