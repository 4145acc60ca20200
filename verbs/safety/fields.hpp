// Tables whose rows bring their columns with them: each field is described once.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "report/table.hpp"

namespace biss::verbs {

/// A column and its cell in one row.
struct Field {
  report::Column column;
  report::Cell cell{};
  /// Instead of the cell: a text that the field owns.
  std::optional<std::string> text{};
};

inline Field text_field(std::string name, std::optional<std::string> text,
                        report::Role role = report::Role::value) {
  return {.column = {.name = std::move(name), .role = role}, .text = std::move(text)};
}
inline Field count_field(std::string name, report::Cell count, std::string heading = {}) {
  return {.column = {.name = std::move(name),
                     .kind = report::Kind::unsigned_integer,
                     .heading = std::move(heading)},
          .cell = count};
}
/// A long double is written as the nearest double.
inline Field real_field(std::string name, std::optional<long double> value) {
  return {.column = {.name = std::move(name), .kind = report::Kind::real},
          .cell = value ? report::Cell(static_cast<double>(*value)) : report::Cell()};
}

using FieldRow = std::vector<Field>;

/// \pre there is at least one row, and all have the same columns
/// \return false if the sink failed
inline bool write_rows(const std::vector<FieldRow>& rows, report::Format to, report::TextSink& sink,
                       report::TableOptions options = {}) {
  std::vector<report::Column> columns;
  for (const Field& each : rows.front()) columns.push_back(each.column);
  const auto table = report::make_table_writer(to, columns, sink, std::move(options));
  for (const FieldRow& row : rows) {
    std::vector<report::Cell> cells;
    for (const Field& each : row) cells.push_back(each.text ? report::Cell(*each.text) : each.cell);
    if (!table->row(cells)) return false;
  }
  return table->finish();
}

inline std::string text_of(const std::vector<FieldRow>& rows, report::Format to) {
  report::StringSink sink;
  write_rows(rows, to, sink);
  return sink.take();
}

}  // namespace biss::verbs
