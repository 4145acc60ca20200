#include "capture/fst.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "capture/fst_file.hpp"

namespace biss::capture {
namespace {

using wire::Level;

// FST_RCV_STR of fstapi.c: x z h u w l - ?
constexpr std::array<Level, 8> rare_levels{Level::unknown, Level::unknown, Level::high,
                                           Level::unknown, Level::unknown, Level::low,
                                           Level::unknown, Level::unknown};

Level level_of(std::uint8_t letter) {
  if (letter == '0' || letter == 'l' || letter == 'L') return Level::low;
  if (letter == '1' || letter == 'h' || letter == 'H') return Level::high;
  return Level::unknown;
}

// The times of a block: differences, read from front to back.
class FstTimes {
 public:
  FstTimes() = default;
  FstTimes(std::vector<std::uint8_t> deltas, std::uint64_t count)
      : deltas_(std::move(deltas)), count_(count) {}

  std::uint64_t count() const { return count_; }
  // The tick of a time; nothing if it is damaged or beyond `last`. Indexes do not fall.
  // \pre index < count()
  std::optional<std::uint64_t> tick_at(std::uint64_t index, std::uint64_t last) {
    FstCursor cursor(std::span<const std::uint8_t>(deltas_).subspan(at_));
    for (; given_ <= index; ++given_) {
      const std::uint64_t delta = cursor.varint();
      if (!cursor.failed()) beyond_ = delta > last - tick_;
      if (cursor.failed() || beyond_) return std::nullopt;
      tick_ += delta;
    }
    at_ += cursor.at();
    return tick_;
  }
  bool beyond() const { return beyond_; }

 private:
  std::vector<std::uint8_t> deltas_;
  std::uint64_t count_ = 0;
  std::size_t at_ = 0;
  std::uint64_t given_ = 0;
  std::uint64_t tick_ = 0;
  bool beyond_ = false;
};

// The changes of one variable in a block.
struct FstChain {
  std::uint32_t variable = 0;
  std::uint64_t time_index = 0;
  Level level = Level::unknown;
  std::span<const std::uint8_t> rest;

  // Goes to the next change. False if there is none or it is damaged.
  bool next(bool& damaged) {
    if (rest.empty()) return false;
    FstCursor cursor(rest);
    const std::uint64_t code = cursor.varint();
    damaged = cursor.failed() || code > UINT32_MAX;
    if (damaged) return false;
    rest = rest.subspan(cursor.at());
    const bool rare = (code & 1U) != 0;
    level = rare ? rare_levels[code >> 1U & 7U] : (code & 2U) != 0 ? Level::high : Level::low;
    time_index += rare ? code >> 4U : code >> 2U;
    return true;
  }
};

// The place of the chain of a handle in the block. Handles may share a chain.
struct FstChainPlace {
  std::uint64_t place = 0;  // from the letter of the packing on; 0: no changes
  std::uint64_t size = 0;
  std::uint32_t owner = 0;
};

// The places of a block's chains, from its index.
class FstChainIndex {
 public:
  // False if the index is damaged. `end` is the end of the chains.
  bool read(std::span<const std::uint8_t> index, bool is_signed, std::size_t most_handles,
            std::uint64_t end) {
    FstCursor cursor(index);
    while (!cursor.at_end()) {
      if (!(is_signed ? read_signed(cursor, most_handles) : read_plain(cursor, most_handles))) {
        return false;
      }
      if (cursor.failed() || places_.size() > most_handles || last_place_ > end) return false;
    }
    if (has_last_) places_[last_].size = end - last_place_;
    for (FstChainPlace& place : places_) {
      if (place.place == 0) place = places_[place.owner];
    }
    return true;
  }

  std::span<const FstChainPlace> places() const { return places_; }

 private:
  bool read_plain(FstCursor& cursor, std::size_t most_handles) {
    const std::uint64_t code = cursor.varint();
    if (code == 0) return add_alias(cursor.varint());
    return (code & 1U) != 0 ? add_chain(code >> 1U) : skip(code >> 1U, most_handles);
  }

  bool read_signed(FstCursor& cursor, std::size_t most_handles) {
    FstCursor again = cursor;
    const std::int64_t code = cursor.signed_varint();
    if ((code & 1) == 0) {
      // Numbers of handles without changes have no sign.
      std::swap(cursor, again);
      return skip(cursor.varint() >> 1U, most_handles);
    }
    const std::int64_t step = code >> 1;
    if (step > 0) return add_chain(static_cast<std::uint64_t>(step));
    if (step < 0) last_alias_ = 0 - static_cast<std::uint64_t>(step);
    return add_alias(last_alias_);
  }

  bool add_chain(std::uint64_t step) {
    if (step == 0 || step > UINT64_MAX - last_place_) return false;
    if (has_last_) places_[last_].size = step;
    last_place_ += step;
    last_ = static_cast<std::uint32_t>(places_.size());
    has_last_ = true;
    places_.push_back({last_place_, 0, last_});
    return true;
  }

  // An alias names an earlier handle, from 1.
  bool add_alias(std::uint64_t handle) {
    if (handle == 0 || handle > places_.size()) return false;
    places_.push_back({0, 0, places_[static_cast<std::size_t>(handle - 1)].owner});
    return true;
  }

  bool skip(std::uint64_t handles, std::size_t most_handles) {
    if (handles > most_handles - std::min(most_handles, places_.size())) return false;
    for (; handles != 0; --handles) {
      places_.push_back({0, 0, static_cast<std::uint32_t>(places_.size())});
    }
    return true;
  }

  std::vector<FstChainPlace> places_;
  std::uint64_t last_place_ = 0;
  std::uint64_t last_alias_ = 0;
  std::uint32_t last_ = 0;
  bool has_last_ = false;
};

class FstReader final : public StepSource {
 public:
  explicit FstReader(FstFile file)
      : file_(std::move(file)),
        driven_(file_.declared(), static_cast<std::uint32_t>(file_.lengths().size())),
        levels_(file_.lengths().size(), no_level) {
    set_lines(file_.declared().take_names());
    constexpr std::uint64_t most_changes_a_byte = 1U << 20U;
    changes_left_ = file_.size() * most_changes_a_byte;
  }

 private:
  // Places count from the beginning of the file.
  struct Part {
    std::uint64_t place = 0;
    std::uint64_t size = 0;  // unpacked
    std::uint64_t packed = 0;
  };

  // The data of a block that is needed while it is opened.
  struct Layout {
    std::uint64_t begin_tick = 0;
    Part frame;  // the initial values
    Part times;
    std::uint64_t times_count = 0;
    std::uint64_t chains_place = 0;
    std::uint64_t index_place = 0;
    std::uint64_t index_size = 0;
    Packing packing{};
  };

  void fail(CaptureCause cause, const char* expected = nullptr) {
    StepSource::fail(
        {.cause = cause, .expected = expected, .part = "block", .part_number = block_number_});
  }
  bool damaged(const char* expected) {
    fail(CaptureCause::damaged, expected);
    return false;
  }
  bool wrong_time() {
    if (!times_.beyond()) return damaged("a time for each change");
    fail(CaptureCause::time_out_of_range);
    return false;
  }
  // Accounts for memory of the block.
  bool take_memory(std::uint64_t bytes) {
    if (bytes <= memory_left_) {
      memory_left_ -= bytes;
      return true;
    }
    fail(CaptureCause::block_too_large);
    return false;
  }

  void step() override {
    while (!ended() && !block_.full()) {
      if (!in_block_) {
        open_block();
      } else if (heap_.empty()) {
        finish_block();
      } else if (go_to(heap_.front() >> 32U)) {
        take_change();
      }
    }
  }

  void open_block() {
    ++block_number_;
    const auto block = file_.next_block();
    if (!block) {
      // Applies the remaining switches, at the last time.
      if (!apply_switch(tick_ + 1)) finish();
      return;
    }
    memory_left_ = FstFile::most_block_bytes;
    chains_.clear();
    chain_data_.clear();
    heap_.clear();
    times_ = {};
    Layout layout;
    in_block_ = true;
    if (!read_layout(*block, layout) || !read_times(layout)) return;
    if (block_number_ == 1 && !read_frame(layout)) return;
    read_chains(*block, layout);
  }

  bool read_layout(const FstBlock& block, Layout& layout) {
    constexpr std::uint64_t tail_bytes = 24;
    constexpr std::uint64_t index_size_bytes = 8;
    if (!read_head(block, layout)) return false;
    const std::uint64_t end = block.place + block.size;
    std::array<std::uint8_t, tail_bytes> tail{};
    if (end - layout.chains_place < tail_bytes + index_size_bytes ||
        !file_.read(end - tail_bytes, tail)) {
      return damaged("the sizes of its times");
    }
    FstCursor cursor(tail);
    layout.times.size = cursor.fixed64();
    layout.times.packed = cursor.fixed64();
    layout.times_count = cursor.fixed64();
    std::uint64_t room = end - layout.chains_place - tail_bytes - index_size_bytes;
    if (layout.times.packed > room) return damaged("times that fit into it");
    layout.times.place = end - tail_bytes - layout.times.packed;
    room -= layout.times.packed;
    std::array<std::uint8_t, index_size_bytes> index_size{};
    if (!file_.read(layout.times.place - index_size_bytes, index_size)) {
      return damaged("the size of its index");
    }
    layout.index_size = FstCursor(index_size).fixed64();
    if (layout.index_size > room) return damaged("an index that fits into it");
    layout.index_place = layout.times.place - index_size_bytes - layout.index_size;
    return true;
  }

  // From the times of the block to the letter of its packing.
  bool read_head(const FstBlock& block, Layout& layout) {
    constexpr std::uint64_t times_and_three_numbers = 24 + 30;
    constexpr std::uint64_t number_and_letter = 11;
    const auto head_part = [&](std::uint64_t place, std::uint64_t most) {
      return file_.bytes(place, std::min(block.place + block.size - place, most));
    };
    const auto head = head_part(block.place, times_and_three_numbers);
    FstCursor cursor(head);
    layout.begin_tick = cursor.fixed64();
    cursor.fixed64();  // the end
    cursor.fixed64();  // the memory that fstapi takes for it
    layout.frame.size = cursor.varint();
    layout.frame.packed = cursor.varint();
    cursor.varint();  // variables in the frame
    layout.frame.place = block.place + cursor.at();
    if (cursor.failed() || layout.frame.packed > block.size - cursor.at()) {
      return damaged("initial values that fit into it");
    }
    const auto rest = head_part(layout.frame.place + layout.frame.packed, number_and_letter);
    FstCursor letter(rest);
    letter.varint();  // variables with changes
    const std::uint8_t packing = letter.byte();
    if (letter.failed()) return damaged("how its changes are packed");
    layout.chains_place = layout.frame.place + layout.frame.packed + letter.at() - 1;
    layout.packing = packing == '4'   ? Packing::lz4
                     : packing == 'F' ? Packing::fastlz
                                      : Packing::zlib;
    if (packing == '4' || packing == 'F' || packing == 'Z' || packing == '!') return true;
    return damaged("changes packed by zlib, LZ4 or FastLZ");
  }

  // The content of a part. \param possible, inflates describe a part that is right
  bool unpack(const Part& part, std::vector<std::uint8_t>& into, const char* possible,
              const char* inflates) {
    if (part.size / max_packing_ratio > part.packed) return damaged(possible);
    if (!take_memory(part.size + part.packed)) return false;
    into.resize(static_cast<std::size_t>(part.size));
    return file_.unpack(Packing::zlib, part.place, part.packed, into) || damaged(inflates);
  }

  bool read_times(const Layout& layout) {
    if (layout.times_count > layout.times.size || layout.times_count > UINT32_MAX) {
      return damaged("no more times than bytes of them");
    }
    std::vector<std::uint8_t> times;
    if (!unpack(layout.times, times, "a size of its times that the compressed data can have",
                "times that inflate to their size")) {
      return false;
    }
    times_ = FstTimes(std::move(times), layout.times_count);
    return true;
  }

  bool read_chains(const FstBlock& block, const Layout& layout) {
    FstChainIndex index;
    const std::size_t handles = levels_.size();
    if (!take_memory(layout.index_size + handles * sizeof(FstChainPlace))) return false;
    std::vector<std::uint8_t> bytes(static_cast<std::size_t>(layout.index_size));
    if (!file_.read(layout.index_place, bytes) ||
        !index.read(bytes, block.signed_index, handles, layout.index_place - layout.chains_place)) {
      return damaged("an index of its changes");
    }
    // The place of an owner's data, from 1.
    std::vector<std::uint32_t> data_of(index.places().size());
    for (std::uint32_t variable = 0; variable < index.places().size(); ++variable) {
      const FstChainPlace& place = index.places()[variable];
      if (place.place == 0 || !driven_.drives(variable)) continue;
      std::uint32_t& data = data_of[place.owner];
      if (data == 0) {
        if (!read_chain(place, layout, chain_data_.emplace_back())) return false;
        data = static_cast<std::uint32_t>(chain_data_.size());
      }
      if (!take_memory(sizeof(FstChain) + sizeof(std::uint64_t))) return false;
      const std::vector<std::uint8_t>& changes = chain_data_[data - 1];
      const std::uint64_t most_edges = changes.size() * driven_.lines_of(variable);
      if (most_edges > changes_left_) return damaged("fewer changes than a file of its size has");
      changes_left_ -= most_edges;
      chains_.push_back({.variable = variable, .rest = changes});
      if (!push_chain(chains_.back(), chains_.size() - 1)) return false;
    }
    return true;
  }

  // The changes of one chain, unpacked.
  bool read_chain(const FstChainPlace& place, const Layout& layout,
                  std::vector<std::uint8_t>& changes) {
    constexpr std::uint64_t most_varint_bytes = 10;
    const std::uint64_t at = layout.chains_place + place.place;
    const auto head = file_.bytes(at, std::min(place.size, most_varint_bytes));
    FstCursor cursor(head);
    const std::uint64_t size = cursor.varint();
    if (cursor.failed()) return damaged("the size of each chain of changes");
    const std::uint64_t packed = place.size - cursor.at();
    if (size / max_packing_ratio > packed)
      return damaged("a size that the compressed data can have");
    const std::uint64_t unpacked_size = size == 0 ? packed : size;
    if (!take_memory(unpacked_size + packed + sizeof(std::vector<std::uint8_t>))) return false;
    memory_left_ += packed;  // only while it is unpacked
    changes.resize(static_cast<std::size_t>(unpacked_size));
    const bool good = size == 0
                          ? file_.read(at + cursor.at(), changes)
                          : file_.unpack(layout.packing, at + cursor.at(), packed, changes, false);
    return good || damaged("changes that unpack to their size");
  }

  // Puts the next change of a chain among the changes to come.
  bool push_chain(FstChain chain, std::size_t number) {
    bool is_damaged = false;
    const bool more = chain.next(is_damaged);
    if (is_damaged) return damaged("complete changes");
    if (more && chain.time_index >= times_.count()) return damaged("a time for each change");
    chains_[number] = chain;
    if (!more) return true;
    heap_.push_back(chain.time_index << 32U | number);
    std::push_heap(heap_.begin(), heap_.end(), std::greater<>());
    return true;
  }

  // The initial values. If changes begin at the same time, an unknown initial value only means that
  // there is no value; fst2vcd leaves it out too.
  bool read_frame(const Layout& layout) {
    const std::uint64_t last_tick = file_.timescale().last_tick();
    if (times_.count() == 0) return true;
    const auto first = times_.tick_at(0, last_tick);
    if (!first) return wrong_time();
    if (layout.begin_tick > *first) return damaged("a first time after its begin");
    std::vector<std::uint8_t> values;
    if (!unpack(layout.frame, values,
                "a size of its initial values that the compressed data can have",
                "initial values that inflate to their size")) {
      return false;
    }
    set_tick(layout.begin_tick);
    std::uint64_t at = 0;
    for (std::uint32_t variable = 0; variable < levels_.size() && at < values.size(); ++variable) {
      const std::uint64_t place = std::exchange(at, at + file_.lengths()[variable]);
      if (!driven_.drives(variable)) continue;
      const Level level = level_of(values[static_cast<std::size_t>(place)]);
      if (level == Level::unknown && layout.begin_tick == *first) continue;
      levels_[variable] = static_cast<std::uint8_t>(level);
      driven_.set(variable, level, end_time_, block_);
    }
    memory_left_ += layout.frame.size + layout.frame.packed;
    return true;
  }

  void take_change() {
    std::pop_heap(heap_.begin(), heap_.end(), std::greater<>());
    const auto number = static_cast<std::uint32_t>(heap_.back());
    heap_.pop_back();
    FstChain& chain = chains_[number];
    levels_[chain.variable] = static_cast<std::uint8_t>(chain.level);
    if (on_) driven_.set(chain.variable, chain.level, end_time_, block_);
    push_chain(chain, number);
  }

  // The last times may be without changes.
  void finish_block() {
    if (times_.count() != 0 && !go_to(times_.count() - 1)) return;
    in_block_ = false;
  }

  // False if something else comes first.
  bool go_to(std::uint64_t time_index) {
    const auto tick = times_.tick_at(time_index, file_.timescale().last_tick());
    if (!tick) return wrong_time();
    if (*tick < tick_) {
      fail(CaptureCause::time_backwards);
      return false;
    }
    if (apply_switch(*tick)) return false;
    set_tick(*tick);
    return true;
  }

  // Switches at a time come after its changes. False if there is none before that tick.
  bool apply_switch(std::uint64_t before_tick) {
    const std::vector<FstSwitch>& switches = file_.switches();
    if (next_switch_ == switches.size() || switches[next_switch_].tick >= before_tick) return false;
    const FstSwitch change = switches[next_switch_++];
    set_tick(std::max(tick_, change.tick));
    if (change.on == on_) return true;
    on_ = change.on;
    if (!on_) {
      driven_.lose_levels(end_time_, block_);
      return true;
    }
    for (std::uint32_t variable = 0; variable < levels_.size(); ++variable) {
      if (levels_[variable] == no_level || !driven_.drives(variable)) continue;
      driven_.set(variable, static_cast<Level>(levels_[variable]), end_time_, block_);
    }
    return true;
  }

  void set_tick(std::uint64_t tick) {
    tick_ = tick;
    end_time_ = file_.timescale().time_of(tick);
  }

  FstFile file_;
  DrivenLines driven_;
  std::vector<std::uint8_t> levels_;  // of variables, also while dumping is off
  bool in_block_ = false;
  std::uint64_t tick_ = 0;
  std::size_t next_switch_ = 0;
  bool on_ = true;
  std::uint64_t changes_left_ = 0;

  // The block that is read.
  std::uint64_t block_number_ = 0;
  std::uint64_t memory_left_ = 0;
  FstTimes times_;
  std::vector<std::vector<std::uint8_t>> chain_data_;
  std::vector<FstChain> chains_;
  std::vector<std::uint64_t> heap_;  // time index and number of the chain, the earliest first
};

}  // namespace

bool looks_like_fst(std::string_view head) {
  constexpr std::string_view plain_head("\0\0\0\0\0\0\0\1\x49", 9);
  constexpr std::string_view e_little("\x69\x57\x14\x8B\x0A\xBF\x05\x40", 8);
  constexpr std::string_view e_big("\x40\x05\xBF\x0A\x8B\x14\x57\x69", 8);
  constexpr std::size_t e_place = 25;
  constexpr std::size_t gzip_place = 17;
  if (head.size() < e_place + e_little.size()) return false;
  if (head.starts_with(plain_head)) {
    const std::string_view e = head.substr(e_place, e_little.size());
    return e == e_little || e == e_big;
  }
  return head[0] == '\xFE' && head.substr(gzip_place).starts_with("\x1F\x8B");
}

Opened open_fst(std::unique_ptr<ByteSource> bytes) {
  auto file = FstFile::open(std::move(bytes));
  if (!file) return tl::unexpected(file.error());
  return std::make_unique<FstReader>(std::move(*file));
}

}  // namespace biss::capture
