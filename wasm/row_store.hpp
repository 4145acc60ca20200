// The rows of a table, kept by column: any of them can be read again, as values or as text.
#pragma once

#include <cstdint>
#include <deque>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "report/table.hpp"

namespace biss::wasm {

/// Values of a column, a row each. `values` holds what Column::kind says: numbers, picoseconds, the
/// bits of a double, 0 or 1, or the number of a text in `texts`; nothing for bits.
struct ColumnValues {
  std::vector<std::uint64_t> values;
  std::vector<std::uint8_t> present;
};

class RowStore final : public report::TableWriter {
 public:
  explicit RowStore(std::vector<report::Column> columns);

  bool row(std::span<const report::Cell> cells) override;
  bool finish() override { return true; }

  const std::vector<report::Column>& columns() const { return columns_; }
  std::uint64_t rows() const { return rows_; }
  /// Texts that cells of text columns have, in the order of their first use.
  const std::vector<std::string>& texts() const { return texts_; }

  /// Rows from `from` to before `to`, as the command writes them, with the header.
  /// \pre from <= to <= rows()
  std::string text(report::Format format, std::uint64_t from, std::uint64_t to) const;
  /// \pre column is one of columns(), from <= to <= rows()
  void read(std::size_t column, std::uint64_t from, std::uint64_t to, ColumnValues& into) const;
  /// The place of a column. \pre there is one of this name
  std::size_t column(std::string_view name) const;
  /// A cell of a column of numbers; 0 where it is empty. \pre row < rows()
  std::uint64_t number(std::size_t column, std::uint64_t row) const;
  /// The time of a row. \pre row < rows(), and there is a column of nanoseconds
  Picoseconds time(std::uint64_t row) const;

 private:
  // A column of flags has `small`, one of bits the last three, any other `numbers` and in `small`
  // whether they are present. A text is its number in texts().
  struct Values {
    std::deque<std::uint64_t> numbers;
    std::deque<std::uint8_t> small;
    std::deque<std::uint8_t> bytes;
    // Of bits: their count, and for each block of rows where its bytes begin.
    std::deque<std::uint16_t> bit_counts;
    std::deque<std::uint64_t> places;
  };
  static constexpr std::uint64_t rows_of_block = 64;
  static constexpr std::uint8_t absent = 0xFF;

  void put(std::size_t column, const report::Cell& cell);
  std::uint64_t number_of(std::string_view text);
  report::Cell cell(std::size_t column, std::uint64_t row, std::vector<std::uint8_t>& bits) const;
  bool is_present(std::size_t column, std::uint64_t row) const;

  std::vector<report::Column> columns_;
  std::vector<Values> values_;
  std::vector<std::string> texts_;
  std::uint64_t rows_ = 0;
};

}  // namespace biss::wasm
