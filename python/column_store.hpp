// The rows of a table by column, in memory that NumPy takes over as it is.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "capture/buffer.hpp"
#include "report/table.hpp"

namespace biss::python {

template <class T>
using Values = std::vector<T, capture::Unfilled<T>>;

/// The values of a column, a row each.
struct StoredColumn {
  report::Column column;
  /// Numbers, picoseconds, the bits of a double, or the number of a text in `texts`. Of bits: `lanes`
  /// words a row, the most significant one first.
  Values<std::uint64_t> numbers;
  /// In place of `numbers` for a column of flags.
  Values<std::uint8_t> flags;
  /// 1 where the value is absent; empty where none is.
  Values<std::uint8_t> absent;
  std::vector<std::string> texts;
  Values<std::uint16_t> bit_counts;
  std::size_t lanes = 1;
};

/// Keeps every row. A column of text takes cells of text alone.
class ColumnStore final : public report::TableWriter {
 public:
  ColumnStore(std::span<const report::Column> columns, std::vector<StoredColumn>& into);

  bool row(std::span<const report::Cell> cells) override;
  bool finish() override { return true; }

 private:
  void put(StoredColumn& stored, const report::Cell& cell) const;
  void put_value(StoredColumn& stored, const report::Cell& cell) const;

  std::vector<StoredColumn>& columns_;
  std::uint64_t rows_ = 0;
};

}  // namespace biss::python
