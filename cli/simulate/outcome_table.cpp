#include "cli/simulate/outcome_table.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

#include "biss/control/register_map.hpp"
#include "cli/common/access_option.hpp"
#include "cli/common/message.hpp"

namespace biss::cli {

using report::Cell;
using report::Kind;
using sim::AccessKind;

OutcomeTable::OutcomeTable() {
  columns_ = {{.name = "cycle", .kind = Kind::unsigned_integer},
              {.name = "time_ns", .kind = Kind::nanoseconds},
              {.name = "id", .kind = Kind::unsigned_integer},
              {.name = "access", .kind = Kind::text},
              {.name = "address", .kind = Kind::text},
              {.name = "name", .kind = Kind::text},
              {.name = "data", .kind = Kind::text},
              {.name = "outcome", .kind = Kind::text},
              {.name = "cycles", .kind = Kind::unsigned_integer}};
}

const std::vector<Cell>& OutcomeTable::cells(const sim::ControlAccess& access,
                                             const sim::ControlRecord& record, unsigned id) {
  const bool on_registers = access.kind == AccessKind::read || access.kind == AccessKind::write;
  const bool broadcast = access.kind == AccessKind::broadcast;
  address_ = fmt::format("0x{:02X}", access.address);
  data_ = fmt::format("{:02X}", fmt::join(record.data, " "));
  cells_.clear();
  cells_.emplace_back(record.cycle);
  cells_.emplace_back(record.time);
  cells_.push_back(broadcast ? Cell() : Cell(id));
  cells_.emplace_back(access.kind == AccessKind::read    ? "read"
                      : access.kind == AccessKind::write ? "write"
                                                         : "command");
  cells_.push_back(on_registers ? Cell(address_) : Cell());
  cells_.push_back(on_registers ? Cell(register_field(access.address).name)
                                : Cell(name_of(access.command)));
  cells_.push_back(data_.empty() ? Cell() : Cell(data_));
  cells_.emplace_back(outcome_name(record));
  cells_.emplace_back(record.cycles);
  return cells_;
}

bool OutcomeLog::open(const std::string& path) {
  if (path.empty()) return true;
  if (!output_.open(path)) return false;
  const auto format = path.ends_with(".jsonl") ? report::Format::jsonl : report::Format::csv;
  rows_ = report::make_table_writer(format, table_.columns(), output_);
  return true;
}

bool OutcomeLog::finish(const sim::ControlMaster& control) {
  const auto records = control.records();
  if (rows_) {
    for (const sim::ControlRecord& record : records) {
      const auto put = [this](const std::vector<Cell>& cells) { return rows_->row(cells); };
      if (!table_.rows(control.accesses()[record.access], record, put)) return false;
    }
    if (!rows_->finish() || !output_.finish()) return false;
  }
  if (!control.accesses().empty()) {
    print_summary(outcome_summary(records, control.accesses().size()));
  }
  return true;
}

std::string_view outcome_name(const sim::ControlRecord& record) {
  if (!record.finished) return "unfinished";
  return record.outcome.error ? name_of(*record.outcome.error) : "ok";
}

std::string outcome_summary(const std::vector<sim::ControlRecord>& records, std::size_t accesses) {
  std::vector<std::pair<std::string_view, std::size_t>> counts;
  const auto count = [&](std::string_view name, std::size_t by) {
    const auto same = std::find_if(counts.begin(), counts.end(),
                                   [name](const auto& one) { return one.first == name; });
    if (same != counts.end()) {
      same->second += by;
    } else if (by != 0) {
      counts.emplace_back(name, by);
    }
  };
  for (const sim::ControlRecord& record : records) count(outcome_name(record), 1);
  count("not begun", accesses - records.size());
  std::string text = fmt::format("{} {}: ", accesses, accesses == 1 ? "access" : "accesses");
  for (std::size_t i = 0; i < counts.size(); ++i) {
    text += fmt::format("{}{} {}", i == 0 ? "" : ", ", counts[i].second, counts[i].first);
  }
  return text + "\n";
}

}  // namespace biss::cli
