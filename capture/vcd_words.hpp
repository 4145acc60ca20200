// The words of a VCD: the meaning of their first character, and identifiers as numbers.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "capture/text_source.hpp"
#include "wire/edge.hpp"

namespace biss::capture {

/// The kind of a word, from its first character; the first three are levels.
enum class VcdKind : std::uint8_t { low, high, unknown, space, time, vector, value, keyword, none };

constexpr std::array<VcdKind, 256> make_vcd_kinds() {
  std::array<VcdKind, 256> kinds{};
  kinds.fill(VcdKind::none);
  const auto set = [&kinds](std::string_view chars, VcdKind kind) {
    for (const char c : chars) kinds[static_cast<unsigned char>(c)] = kind;
  };
  set("0lL", VcdKind::low);
  set("1hH", VcdKind::high);
  set("xXzZuUwW-", VcdKind::unknown);
  set(" \t\n\v\f\r", VcdKind::space);
  set("#", VcdKind::time);
  set("bB", VcdKind::vector);
  set("rRsS", VcdKind::value);
  set("$", VcdKind::keyword);
  return kinds;
}

inline constexpr std::array<VcdKind, 256> vcd_kinds = make_vcd_kinds();
static_assert(static_cast<int>(VcdKind::low) == static_cast<int>(wire::Level::low));
static_assert(static_cast<int>(VcdKind::high) == static_cast<int>(wire::Level::high));
static_assert(static_cast<int>(VcdKind::unknown) == static_cast<int>(wire::Level::unknown));

constexpr VcdKind vcd_kind_of(char c) { return vcd_kinds[static_cast<unsigned char>(c)]; }

/// \pre a space follows
inline const char* end_of_word(const char* p) {
  while (!is_space(*p)) ++p;
  return p;
}

/// Identifiers to numbers 0, 1, 2, … in the order of their first add().
class VcdIds {
 public:
  static constexpr std::uint32_t none = UINT32_MAX;

  VcdIds() : slots_(64) { one_.fill(none); }

  /// The number of `id`, a new one when it was not known.
  /// \pre valid(id)
  std::uint32_t add(std::string_view id) {
    if (id.size() > packed_chars) {
      const auto [entry, added] = long_.try_emplace(std::string(id), size_);
      if (added) ++size_;
      return entry->second;
    }
    if (id.size() > 2) return add_packed(pack(id));
    if (two_.empty() && id.size() == 2) two_.assign(std::size_t{letters} * letters, none);
    std::uint32_t& entry = id.size() == 1 ? one_[static_cast<unsigned char>(id[0])]
                                          : two_[place(id[0]) * letters + place(id[1])];
    if (entry == none) entry = size_++;
    return entry;
  }

  /// The number of `id`, or none; any text may be requested.
  std::uint32_t find(std::string_view id) const {
    if (id.empty()) return none;
    if (id.size() == 1) return find_one(id[0]);
    if (id.size() == 2) return find_two(id.data());
    // A leading NUL would pack like the shorter identifier after it.
    if (id.size() <= packed_chars) return id[0] == 0 ? none : slots_[slot_of(pack(id))].number;
    const auto entry = long_.find(id);
    return entry == long_.end() ? none : entry->second;
  }

  /// The same for an identifier of one or two characters.
  std::uint32_t find_one(char c) const { return one_[static_cast<unsigned char>(c)]; }
  std::uint32_t find_two(const char* id) const {
    const unsigned first = place(id[0]);
    const unsigned second = place(id[1]);
    if (two_.empty() || first >= letters || second >= letters) return none;
    return two_[first * letters + second];
  }
  std::uint32_t size() const { return size_; }

  static bool valid(std::string_view id) {
    return !id.empty() &&
           std::all_of(id.begin(), id.end(), [](char c) { return place(c) < letters; });
  }

 private:
  static constexpr unsigned letters = '~' - '!' + 1;
  static constexpr std::size_t packed_chars = 8;

  struct Slot {
    std::uint64_t key = 0;
    std::uint32_t number = none;
  };
  struct TextHash {
    using is_transparent = void;
    std::size_t operator()(std::string_view text) const {
      return std::hash<std::string_view>{}(text);
    }
  };

  static unsigned place(char c) { return static_cast<unsigned char>(c) - unsigned{'!'}; }

  static std::uint64_t pack(std::string_view id) {
    std::uint64_t key = 0;
    for (const char c : id) key = key << 8U | static_cast<unsigned char>(c);
    return key;
  }

  // The slot of `key`, or the free slot in which it belongs.
  std::size_t slot_of(std::uint64_t key) const {
    const std::size_t mask = slots_.size() - 1;
    auto at = static_cast<std::size_t>((key * 0x9E3779B97F4A7C15U) >> 20U) & mask;
    while (slots_[at].number != none && slots_[at].key != key) at = (at + 1) & mask;
    return at;
  }

  std::uint32_t add_packed(std::uint64_t key) {
    Slot* slot = &slots_[slot_of(key)];
    if (slot->number != none) return slot->number;
    if (++slots_used_ * 2 > slots_.size()) {
      grow_slots();
      slot = &slots_[slot_of(key)];
    }
    *slot = {key, size_};
    return size_++;
  }

  void grow_slots() {
    const std::vector<Slot> old = std::exchange(slots_, std::vector<Slot>(slots_.size() * 2));
    for (const Slot& slot : old) {
      if (slot.number != none) slots_[slot_of(slot.key)] = slot;
    }
  }

  std::uint32_t size_ = 0;
  std::array<std::uint32_t, 256> one_;
  std::vector<std::uint32_t> two_;  // empty until the first identifier of two characters
  // Three to eight characters are a number; open addressing, never more than half full.
  std::vector<Slot> slots_;
  std::size_t slots_used_ = 0;
  std::unordered_map<std::string, std::uint32_t, TextHash, std::equal_to<>> long_;
};

}  // namespace biss::capture
