// The rows of a table, kept by column: as arrays, or to be read again.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "report/sink.hpp"
#include "report/table.hpp"

namespace biss::report {

/// The values of a column, a row each. `Values<T>` is a container such as std::vector.
template <template <class> class Values>
struct StoredColumn {
  Column column;
  /// Numbers, picoseconds, the bits of a double, or the number of a text in `texts`. For bits,
  /// `lanes` words per row, the most significant one first.
  Values<std::uint64_t> numbers{};
  /// In place of `numbers` for a column of flags.
  Values<std::uint8_t> flags{};
  /// 1 if the value is absent; empty if no value is absent.
  Values<std::uint8_t> absent{};
  /// In the order of their first use. The tables of the command have few: statuses, verdicts, files.
  std::vector<std::string> texts{};
  Values<std::uint16_t> bit_counts{};
  std::size_t lanes = 1;

  bool is_absent(std::size_t row) const { return !absent.empty() && absent[row] != 0; }
  /// 0 if it is absent. \pre the row is stored, and the column has no bits
  std::uint64_t number(std::size_t row) const {
    return column.kind == Kind::flag ? flags[row] : numbers[row];
  }
};

/// Keeps every row. A column of text takes cells of text alone.
template <template <class> class Values>
class RowStore : public TableWriter {
 public:
  using Stored = StoredColumn<Values>;

  explicit RowStore(std::span<const Column> columns) {
    for (const Column& column : columns) columns_.push_back(Stored{.column = column});
  }

  bool row(std::span<const Cell> cells) override {
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      put(columns_[i], i < cells.size() ? cells[i] : Cell());
    }
    ++rows_;
    return true;
  }
  bool finish() override { return true; }

  std::size_t rows() const { return rows_; }
  const std::vector<Stored>& columns() const { return columns_; }
  std::vector<Stored> take_columns() { return std::move(columns_); }
  /// \pre there is a column of this name
  const Stored& column(std::string_view name) const {
    return *std::find_if(columns_.begin(), columns_.end(),
                         [&](const Stored& stored) { return stored.column.name == name; });
  }

  /// Rows from `from` to before `to`, as the command writes them. \pre from <= to <= rows()
  std::string text(Format format, std::size_t from, std::size_t to) const {
    std::vector<Column> columns;
    for (const Stored& stored : columns_) columns.push_back(stored.column);
    StringSink sink;
    const auto writer = make_table_writer(format, columns, sink);
    std::vector<std::vector<std::uint8_t>> bits(columns.size());
    std::vector<Cell> cells(columns.size());
    for (std::size_t row = from; row < to; ++row) {
      for (std::size_t i = 0; i < columns.size(); ++i) cells[i] = cell(columns_[i], row, bits[i]);
      writer->row(cells);
    }
    writer->finish();
    return sink.text();
  }

 private:
  static std::uint64_t number_in(const Cell& cell) {
    switch (cell.kind()) {
      case Kind::unsigned_integer:
      case Kind::flag:
        return cell.unsigned_value();
      case Kind::signed_integer:
        return static_cast<std::uint64_t>(cell.signed_value());
      case Kind::nanoseconds:
        return static_cast<std::uint64_t>(cell.time().count);
      case Kind::real:
        return std::bit_cast<std::uint64_t>(cell.real_value());
      default:
        return 0;
    }
  }

  static std::uint64_t number_of(std::string_view text, std::vector<std::string>& texts) {
    const auto found = std::find(texts.begin(), texts.end(), text);
    const auto number = static_cast<std::uint64_t>(found - texts.begin());
    if (found == texts.end()) texts.emplace_back(text);
    return number;
  }

  // Gives each of the rows so far that many words.
  void widen(Stored& stored, std::size_t lanes) const {
    Values<std::uint64_t> wide(rows_ * lanes, 0U);
    for (std::size_t i = 0; i < rows_ * stored.lanes; ++i) {
      wide[(i / stored.lanes + 1) * lanes - stored.lanes + i % stored.lanes] = stored.numbers[i];
    }
    stored.numbers = std::move(wide);
    stored.lanes = lanes;
  }

  void put_bits(Stored& stored, BitView bits) const {
    const std::size_t words = std::max<std::size_t>((bits.size_bits() + 63) / 64, 1);
    if (words > stored.lanes) widen(stored, words);
    stored.bit_counts.push_back(static_cast<std::uint16_t>(bits.size_bits()));
    for (std::size_t lane = stored.lanes; lane-- > 0;) {
      const std::size_t end = bits.size_bits() - std::min(64 * lane, bits.size_bits());
      const auto taken = static_cast<unsigned>(std::min<std::size_t>(end, 64));
      stored.numbers.push_back(taken == 0 ? 0 : bits.word(end - taken, taken));
    }
  }

  void put(Stored& stored, const Cell& cell) const {
    const bool absent = cell.kind() == Kind::absent;
    if (absent && stored.absent.empty()) stored.absent.resize(rows_, 0);
    // After the first absent value, every row has an entry, also a row with a value.
    if (absent || !stored.absent.empty()) stored.absent.push_back(absent ? 1 : 0);
    if (stored.column.kind == Kind::flag) {
      stored.flags.push_back(static_cast<std::uint8_t>(number_in(cell)));
    } else if (stored.column.kind == Kind::bits) {
      put_bits(stored, cell.kind() == Kind::bits ? cell.bits() : BitView());
    } else if (stored.column.kind == Kind::text) {
      const bool is_text = cell.kind() == Kind::text;
      stored.numbers.push_back(number_of(is_text ? cell.text() : std::string_view(), stored.texts));
    } else {
      stored.numbers.push_back(number_in(cell));
    }
  }

  static Cell cell(const Stored& stored, std::size_t row, std::vector<std::uint8_t>& bits) {
    if (stored.is_absent(row)) return {};
    switch (stored.column.kind) {
      case Kind::flag:
        return stored.flags[row] != 0;
      case Kind::text:
        return stored.texts[static_cast<std::size_t>(stored.numbers[row])];
      case Kind::unsigned_integer:
        return stored.numbers[row];
      case Kind::signed_integer:
        return static_cast<std::int64_t>(stored.numbers[row]);
      case Kind::nanoseconds:
        return picoseconds(static_cast<std::int64_t>(stored.numbers[row]));
      case Kind::real:
        return std::bit_cast<double>(stored.numbers[row]);
      case Kind::bits: {
        bits.clear();
        for (std::size_t lane = 0; lane < stored.lanes; ++lane) {
          const std::uint64_t word = stored.numbers[row * stored.lanes + lane];
          for (unsigned shift = 64; shift > 0; shift -= 8) {
            bits.push_back(static_cast<std::uint8_t>(word >> (shift - 8)));
          }
        }
        return BitView(bits, 8 * bits.size() - stored.bit_counts[row], stored.bit_counts[row]);
      }
      case Kind::absent:
        break;
    }
    return {};
  }

  std::vector<Stored> columns_;
  std::size_t rows_ = 0;
};

}  // namespace biss::report
