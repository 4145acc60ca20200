#include "python/column_store.hpp"

#include <algorithm>
#include <bit>
#include <utility>

namespace biss::python {
namespace {

using report::Cell;
using report::Kind;

// The tables of the command have few texts: statuses, verdicts, names of files.
std::uint64_t number_of(std::string_view text, std::vector<std::string>& texts) {
  const auto found = std::find(texts.begin(), texts.end(), text);
  const auto number = static_cast<std::uint64_t>(found - texts.begin());
  if (found == texts.end()) texts.emplace_back(text);
  return number;
}

// Gives each of the rows so far that many words.
void widen(StoredColumn& stored, std::size_t lanes) {
  const std::size_t rows = stored.numbers.size() / stored.lanes;
  Values<std::uint64_t> wide;
  wide.reserve(stored.numbers.capacity() / stored.lanes * lanes);
  wide.resize(rows * lanes);
  for (std::size_t row = 0; row < rows; ++row) {
    const auto to = wide.begin() + static_cast<std::ptrdiff_t>(row * lanes);
    const auto from = stored.numbers.begin() + static_cast<std::ptrdiff_t>(row * stored.lanes);
    const auto added = static_cast<std::ptrdiff_t>(lanes - stored.lanes);
    std::fill_n(to, added, 0U);
    std::copy_n(from, stored.lanes, to + added);
  }
  stored.numbers = std::move(wide);
  stored.lanes = lanes;
}

void put_bits(StoredColumn& stored, BitView bits) {
  const std::size_t words = std::max<std::size_t>((bits.size_bits() + 63) / 64, 1);
  if (words > stored.lanes) widen(stored, words);
  stored.bit_counts.push_back(static_cast<std::uint16_t>(bits.size_bits()));
  const std::size_t first = stored.numbers.size();
  stored.numbers.resize(first + stored.lanes);
  std::size_t end = bits.size_bits();
  for (std::size_t lane = stored.lanes; lane-- > 0;) {
    const auto taken = static_cast<unsigned>(std::min<std::size_t>(end, 64));
    end -= taken;
    stored.numbers[first + lane] = taken == 0 ? 0 : bits.word(end, taken);
  }
}

std::uint64_t number_in(const Cell& cell) {
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

}  // namespace

ColumnStore::ColumnStore(std::span<const report::Column> columns, std::vector<StoredColumn>& into)
    : columns_(into) {
  columns_.clear();
  for (const report::Column& column : columns) columns_.emplace_back().column = column;
}

void ColumnStore::put_value(StoredColumn& stored, const Cell& cell) const {
  switch (stored.column.kind) {
    case Kind::flag:
      stored.flags.push_back(static_cast<std::uint8_t>(number_in(cell)));
      break;
    case Kind::bits:
      put_bits(stored, cell.kind() == Kind::bits ? cell.bits() : BitView());
      break;
    case Kind::text:
      stored.numbers.push_back(
          number_of(cell.kind() == Kind::text ? cell.text() : std::string_view(), stored.texts));
      break;
    default:
      stored.numbers.push_back(number_in(cell));
  }
}

void ColumnStore::put(StoredColumn& stored, const Cell& cell) const {
  const bool absent = cell.kind() == Kind::absent;
  if (absent && stored.absent.empty()) stored.absent.assign(static_cast<std::size_t>(rows_), 0);
  // In the first row too: where it is not absent, the column is without absent values so far.
  if (absent || !stored.absent.empty()) stored.absent.push_back(absent ? 1 : 0);
  put_value(stored, cell);
}

bool ColumnStore::row(std::span<const Cell> cells) {
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    put(columns_[i], i < cells.size() ? cells[i] : Cell());
  }
  ++rows_;
  return true;
}

}  // namespace biss::python
