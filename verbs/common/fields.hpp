// Tables whose rows bring their columns with them: each column is next to its value.
#pragma once

#include <algorithm>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "report/table.hpp"
#include "verbs/common/output.hpp"

namespace biss::verbs {

/// A column and its value in one row. The type of the value decides the kind of the column; an
/// optional may be empty. Texts are copied; bits must outlive the field.
class Field {
 public:
  /// \param shown how the column looks, without its name and kind
  template <class Value>
  Field(std::string name, const std::optional<Value>& value, report::Column shown = {})
      : column(std::move(shown)) {
    column.name = std::move(name);
    if constexpr (std::is_convertible_v<Value, std::string_view>) {
      text_ = value;
    } else if constexpr (std::is_floating_point_v<Value>) {
      column.kind = report::Kind::real;
      if (value) cell_ = static_cast<double>(*value);
    } else {
      column.kind = report::Cell(Value()).kind();
      cell_ = value;
    }
  }
  template <class Value>
  Field(std::string name, Value value, report::Column shown = {})
      : Field(std::move(name), std::optional(value), std::move(shown)) {}

  report::Cell cell() const { return text_ ? report::Cell(*text_) : cell_; }

  report::Column column;

 private:
  report::Cell cell_;
  std::optional<std::string> text_;
};

using FieldRow = std::vector<Field>;

inline std::vector<report::Column> columns_of(const FieldRow& row) {
  std::vector<report::Column> columns;
  for (const Field& each : row) columns.push_back(each.column);
  return columns;
}

/// \return as TableWriter::row()
inline bool write_row(report::TableWriter& writer, const FieldRow& row) {
  std::vector<report::Cell> cells;
  for (const Field& each : row) cells.push_back(each.cell());
  return writer.row(cells);
}

/// Writes rows that have the same columns as `columns`.
/// \return false if the sink failed
inline bool write_rows(const FieldRow& columns, const std::vector<FieldRow>& rows,
                       report::Format to, report::TextSink& sink,
                       report::TableOptions options = {}) {
  const auto table = report::make_table_writer(to, columns_of(columns), sink, std::move(options));
  return std::all_of(rows.begin(), rows.end(),
                     [&](const FieldRow& row) { return write_row(*table, row); }) &&
         table->finish();
}

/// The same for at least one row, as it looks in this output.
inline bool write_rows(const std::vector<FieldRow>& rows, report::Format to, Output& output) {
  return write_rows(rows.front(), rows, to, output, output.table_options());
}

/// A row for each thing; a table for people without rows is not a text at all. fields_of() has the
/// same columns for all things, also for an empty one.
template <class Thing, class FieldsOf>
bool write_rows(const std::vector<Thing>& things, report::Format to, Output& output,
                const FieldsOf& fields_of) {
  if (things.empty() && to == report::Format::table) return true;
  std::vector<FieldRow> rows;
  for (const Thing& each : things) rows.push_back(fields_of(each));
  return write_rows(fields_of(Thing()), rows, to, output, output.table_options());
}

/// \pre there is at least one row
inline std::string text_of(const std::vector<FieldRow>& rows, report::Format to) {
  report::StringSink sink;
  write_rows(rows.front(), rows, to, sink);
  return sink.take();
}

/// A number or a time, or nothing if it is 0.
template <class Value>
std::optional<Value> unless_0(Value value) {
  return value == Value{} ? std::nullopt : std::optional(value);
}
/// A text, or nothing if it is empty.
inline std::optional<std::string> unless_empty(std::string_view text) {
  return text.empty() ? std::nullopt : std::optional<std::string>(text);
}

}  // namespace biss::verbs
