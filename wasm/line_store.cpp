#include "wasm/line_store.hpp"

#include <algorithm>

namespace biss::wasm {
namespace {

using wire::Level;

Level inverse(Level level) { return level == Level::high ? Level::low : Level::high; }

// A change is the time since the previous one, and whether its level is the inverse of the previous
// level. If it is not, a byte with the level follows.
constexpr std::uint64_t plain = 0;
constexpr std::uint64_t with_level = 1;

// Ten for a word of 64 bits, and a level.
constexpr std::size_t most_bytes_of_change = 11;
constexpr std::size_t chunk_bytes = 1 << 16;

}  // namespace

void LineStore::push(Picoseconds time, Level level) {
  if (changes_ != 0 && level == level_) return;
  if (changes_ % changes_of_block == 0) {
    begin_block(time.count, level);
  } else {
    const bool inverted = level_ != Level::unknown && level == inverse(level_);
    const auto since = static_cast<std::uint64_t>(time.count - last_);
    std::uint64_t word = since << 1U | (inverted ? plain : with_level);
    for (; word >= 0x80U; word >>= 7U) *free_++ = static_cast<std::uint8_t>(word | 0x80U);
    *free_++ = static_cast<std::uint8_t>(word);
    if (!inverted) *free_++ = static_cast<std::uint8_t>(level);
  }
  ++changes_;
  last_ = time.count;
  level_ = level;
}

void LineStore::begin_block(std::int64_t time, Level level) {
  constexpr std::size_t most_bytes = changes_of_block * most_bytes_of_change;
  if (static_cast<std::size_t>(free_end_ - free_) < most_bytes) {
    chunks_.push_back(std::make_unique_for_overwrite<std::uint8_t[]>(chunk_bytes));
    free_ = chunks_.back().get();
    free_end_ = free_ + chunk_bytes;
  }
  blocks_.push_back({time, free_, level});
}

std::uint64_t LineStore::changes_in(std::size_t block) const {
  return std::min(changes_of_block, changes_ - block * changes_of_block);
}

LineStore::Reader::Reader(const LineStore& store, std::size_t block)
    : store_(&store), block_(block) {
  begin();
}

void LineStore::Reader::begin() {
  at_end_ = block_ == store_->blocks_.size();
  if (at_end_) return;
  const Block& block = store_->blocks_[block_];
  time_ = block.time;
  level_ = block.level;
  bytes_ = block.bytes;
  left_ = store_->changes_in(block_) - 1;
}

void LineStore::Reader::next() {
  if (left_ == 0) {
    ++block_;
    begin();
    return;
  }
  --left_;
  std::uint64_t word = 0;
  for (unsigned shift = 0;; shift += 7) {
    const std::uint8_t byte = *bytes_++;
    word |= std::uint64_t{byte & 0x7FU} << shift;
    if ((byte & 0x80U) == 0) break;
  }
  time_ += static_cast<std::int64_t>(word >> 1U);
  level_ = (word & 1U) == plain ? inverse(level_) : static_cast<Level>(*bytes_++);
}

std::size_t LineStore::block_of(Picoseconds time) const {
  const auto after =
      std::upper_bound(blocks_.begin(), blocks_.end(), time.count,
                       [](std::int64_t value, const Block& block) { return value < block.time; });
  const auto block = static_cast<std::size_t>(after - blocks_.begin());
  return block == 0 ? 0 : block - 1;
}

Picoseconds LineStore::some_before(Picoseconds time) const {
  constexpr std::size_t blocks = 8'192 / changes_of_block;
  if (blocks_.empty()) return time;
  const std::size_t block = block_of(time);
  return picoseconds(blocks_[block - std::min(block, blocks)].time);
}

LineStore::Reader LineStore::at_or_before(Picoseconds time) const {
  Reader at(*this, block_of(time));
  for (Reader next = at; !next.at_end() && next.time() <= time.count; next.next()) at = next;
  return at;
}

void LineStore::append_edges(wire::LineIndex line, Picoseconds from, Picoseconds to,
                             std::vector<wire::Edge>& edges) const {
  std::size_t left = 32'768;
  for (Reader at = at_or_before(from - picoseconds(1));
       !at.at_end() && at.time() <= to.count && left > 0; at.next()) {
    if (at.time() < from.count && at.level() == Level::unknown) continue;
    edges.push_back({picoseconds(std::max(at.time(), from.count)), line, at.level()});
    --left;
  }
}

LineView LineStore::view(Picoseconds from, Picoseconds to, std::uint32_t columns) const {
  LineView view;
  if (blocks_.empty()) return view;
  const std::int64_t column = std::max<std::int64_t>(1, (to.count - from.count) / columns);
  const auto put = [&](std::int64_t time, std::uint8_t shown) {
    if (!view.shown.empty() && view.shown.back() == shown) return;
    view.times.push_back(std::max(time, from.count));
    view.shown.push_back(shown);
  };
  Reader at = at_or_before(from);
  while (!at.at_end() && at.time() < to.count) {
    Reader next = at;
    next.next();
    if (next.at_end() || next.time() - std::max(at.time(), from.count) >= column) {
      put(at.time(), static_cast<std::uint8_t>(at.level()));
      at = next;
      continue;
    }
    // Changes follow one another within a column: the last one of the column continues.
    const std::int64_t end = std::max(at.time(), from.count) + column;
    put(at.time(), busy);
    at = at_or_before(picoseconds(end));
    Reader beyond = at;
    beyond.next();
    const bool rests = beyond.at_end() || beyond.time() - end >= column;
    if (rests) put(at.time(), static_cast<std::uint8_t>(at.level()));
    at = beyond;
  }
  return view;
}

}  // namespace biss::wasm
