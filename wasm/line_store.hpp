// The changes of a line, kept so that any stretch of it can be drawn: about two bytes a change.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <vector>

#include "biss/base/units.hpp"
#include "wire/edge.hpp"

namespace biss::wasm {

/// In LineView: several changes up to the next time.
inline constexpr std::uint8_t busy = 3;

/// A stretch of a line: from `times[i]` to `times[i + 1]` it has the wire::Level `shown[i]`, or is busy.
struct LineView {
  std::vector<std::int64_t> times;
  std::vector<std::uint8_t> shown;
};

class LineStore {
 public:
  /// Changes in time order; a change to the present level is ignored.
  void push(Picoseconds time, wire::Level level);

  /// Appends the level before `from`, if it is known, then the changes from `from` to `to`; only the
  /// first ones if there are many.
  void append_edges(wire::LineIndex line, Picoseconds from, Picoseconds to,
                    std::vector<wire::Edge>& edges) const;

  /// A time with at most the last 8192 changes before `time` after it.
  Picoseconds some_before(Picoseconds time) const;

  /// How the line looks from `from` to `to` on a screen of `columns`. Changes closer than a column
  /// are shown as busy; there are at most 3 entries a column.
  /// \pre from < to, columns is 1 or more
  LineView view(Picoseconds from, Picoseconds to, std::uint32_t columns) const;

 private:
  // The first change of a block of changes, and the bytes of those after it.
  struct Block {
    std::int64_t time = 0;
    const std::uint8_t* bytes = nullptr;
    wire::Level level = wire::Level::unknown;
  };
  static constexpr std::uint64_t changes_of_block = 256;

  /// Reads on from the first change of a block.
  class Reader {
   public:
    Reader(const LineStore& store, std::size_t block);
    bool at_end() const { return at_end_; }
    std::int64_t time() const { return time_; }
    wire::Level level() const { return level_; }
    void next();

   private:
    void begin();

    const LineStore* store_;
    std::size_t block_;
    const std::uint8_t* bytes_ = nullptr;
    std::uint64_t left_ = 0;
    std::int64_t time_ = 0;
    wire::Level level_ = wire::Level::unknown;
    bool at_end_ = false;
  };

  // The block of the last change at or before `time`; the first block if there is none.
  std::size_t block_of(Picoseconds time) const;
  // At the last change at or before `time`; at the first one if there is none.
  Reader at_or_before(Picoseconds time) const;
  std::uint64_t changes_in(std::size_t block) const;
  void begin_block(std::int64_t time, wire::Level level);

  std::deque<Block> blocks_;
  // The bytes of a block lie in one of these.
  std::vector<std::unique_ptr<std::uint8_t[]>> chunks_;
  std::uint8_t* free_ = nullptr;
  std::uint8_t* free_end_ = nullptr;
  std::uint64_t changes_ = 0;
  std::int64_t last_ = 0;
  wire::Level level_ = wire::Level::unknown;
};

}  // namespace biss::wasm
