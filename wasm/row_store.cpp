#include "wasm/row_store.hpp"

#include <algorithm>
#include <bit>

#include "report/sink.hpp"

namespace biss::wasm {
namespace {

using report::Cell;
using report::Kind;

std::size_t at(std::uint64_t place) { return static_cast<std::size_t>(place); }

}  // namespace

RowStore::RowStore(std::vector<report::Column> columns)
    : columns_(std::move(columns)), values_(columns_.size()) {}

// The tables of the command have few texts: statuses, verdicts, sets of limits.
std::uint64_t RowStore::number_of(std::string_view text) {
  const auto found = std::find(texts_.begin(), texts_.end(), text);
  const auto number = static_cast<std::uint64_t>(found - texts_.begin());
  if (found == texts_.end()) texts_.emplace_back(text);
  return number;
}

void RowStore::put(std::size_t column, const Cell& cell) {
  Values& values = values_[column];
  const bool present = cell.kind() != Kind::absent;
  const Kind kind = columns_[column].kind;
  if (kind == Kind::bits) {
    if (rows_ % rows_of_block == 0) values.places.push_back(values.bytes.size());
    const BitView bits = present ? cell.bits() : BitView();
    values.bit_counts.push_back(static_cast<std::uint16_t>(bits.size_bits()));
    for (std::size_t i = 0; i < bits.size_bits(); i += 8) {
      const auto now = static_cast<unsigned>(std::min<std::size_t>(8, bits.size_bits() - i));
      values.bytes.push_back(static_cast<std::uint8_t>(bits.word(i, now) << (8U - now)));
    }
    return;
  }
  if (kind == Kind::flag) {
    values.small.push_back(present ? static_cast<std::uint8_t>(cell.unsigned_value()) : absent);
    return;
  }
  values.small.push_back(present ? 1 : absent);
  std::uint64_t number = 0;
  if (cell.kind() == Kind::unsigned_integer || cell.kind() == Kind::flag) {
    number = cell.unsigned_value();
  } else if (cell.kind() == Kind::signed_integer) {
    number = static_cast<std::uint64_t>(cell.signed_value());
  } else if (cell.kind() == Kind::nanoseconds) {
    number = static_cast<std::uint64_t>(cell.time().count);
  } else if (cell.kind() == Kind::text) {
    number = number_of(cell.text());
  } else if (cell.kind() == Kind::real) {
    number = std::bit_cast<std::uint64_t>(cell.real_value());
  }
  values.numbers.push_back(number);
}

bool RowStore::row(std::span<const Cell> cells) {
  for (std::size_t i = 0; i < columns_.size(); ++i) put(i, i < cells.size() ? cells[i] : Cell());
  ++rows_;
  return true;
}

bool RowStore::is_present(std::size_t column, std::uint64_t row) const {
  const Values& values = values_[column];
  if (columns_[column].kind == Kind::bits) return values.bit_counts[at(row)] != 0;
  return values.small[at(row)] != absent;
}

Cell RowStore::cell(std::size_t column, std::uint64_t row, std::vector<std::uint8_t>& bits) const {
  if (!is_present(column, row)) return {};
  const Values& values = values_[column];
  switch (columns_[column].kind) {
    case Kind::flag:
      return values.small[at(row)] != 0;
    case Kind::text:
      return texts_[at(values.numbers[at(row)])];
    case Kind::unsigned_integer:
      return values.numbers[at(row)];
    case Kind::signed_integer:
      return static_cast<std::int64_t>(values.numbers[at(row)]);
    case Kind::nanoseconds:
      return picoseconds(static_cast<std::int64_t>(values.numbers[at(row)]));
    case Kind::real:
      return std::bit_cast<double>(values.numbers[at(row)]);
    case Kind::bits: {
      std::uint64_t place = values.places[at(row / rows_of_block)];
      for (std::uint64_t i = row / rows_of_block * rows_of_block; i < row; ++i) {
        place += (values.bit_counts[at(i)] + 7U) / 8U;
      }
      const std::size_t count = values.bit_counts[at(row)];
      const auto begin = values.bytes.begin() + static_cast<std::ptrdiff_t>(place);
      bits.assign(begin, begin + static_cast<std::ptrdiff_t>((count + 7) / 8));
      return BitView(bits, 0, count);
    }
    case Kind::absent:
      break;
  }
  return {};
}

std::string RowStore::text(report::Format format, std::uint64_t from, std::uint64_t to) const {
  report::StringSink sink;
  const auto writer = report::make_table_writer(format, columns_, sink);
  std::vector<std::vector<std::uint8_t>> bits(columns_.size());
  std::vector<Cell> cells(columns_.size());
  for (std::uint64_t row = from; row < to; ++row) {
    for (std::size_t i = 0; i < columns_.size(); ++i) cells[i] = cell(i, row, bits[i]);
    writer->row(cells);
  }
  writer->finish();
  return sink.text();
}

void RowStore::read(std::size_t column, std::uint64_t from, std::uint64_t to,
                    ColumnValues& into) const {
  into.values.clear();
  into.present.clear();
  const Values& values = values_[column];
  const bool small = columns_[column].kind == Kind::flag;
  for (std::uint64_t row = from; row < to; ++row) {
    const bool present = is_present(column, row);
    into.present.push_back(present ? 1 : 0);
    if (columns_[column].kind == Kind::bits) continue;
    const std::uint64_t value = small ? values.small[at(row)] : values.numbers[at(row)];
    into.values.push_back(present ? value : 0);
  }
}

std::size_t RowStore::column(std::string_view name) const {
  const auto found = std::find_if(columns_.begin(), columns_.end(),
                                  [&](const report::Column& each) { return each.name == name; });
  return static_cast<std::size_t>(found - columns_.begin());
}

std::uint64_t RowStore::number(std::size_t column, std::uint64_t row) const {
  return is_present(column, row) ? values_[column].numbers[at(row)] : 0;
}

Picoseconds RowStore::time(std::uint64_t row) const {
  const auto column = std::find_if(columns_.begin(), columns_.end(),
                                   [](const auto& each) { return each.kind == Kind::nanoseconds; });
  const auto& values = values_[static_cast<std::size_t>(column - columns_.begin())];
  return picoseconds(static_cast<std::int64_t>(values.numbers[at(row)]));
}

}  // namespace biss::wasm
