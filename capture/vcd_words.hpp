// The words of a VCD: the meaning of their first character, and identifiers as numbers.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <unordered_map>
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

  VcdIds();

  /// The number of `id`, a new one when it was not known.
  /// \pre valid(id)
  std::uint32_t add(std::string_view id);
  /// The number of `id`, or none; any text may be looked up.
  std::uint32_t find(std::string_view id) const;
  /// The same for an identifier of one or two characters.
  std::uint32_t find_one(char c) const { return one_[static_cast<unsigned char>(c)]; }
  std::uint32_t find_two(const char* id) const {
    const unsigned first = place(id[0]);
    const unsigned second = place(id[1]);
    if (two_.empty() || first >= letters || second >= letters) return none;
    return two_[first * letters + second];
  }
  std::uint32_t size() const { return size_; }

  static bool valid(std::string_view id);

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
  static std::uint64_t pack(std::string_view id);
  std::size_t slot_of(std::uint64_t key) const;
  std::uint32_t add_packed(std::uint64_t key);
  void grow_slots();

  std::uint32_t size_ = 0;
  std::array<std::uint32_t, 256> one_;
  std::vector<std::uint32_t> two_;  // empty until the first identifier of two characters
  // Three to eight characters are a number; open addressing, never more than half full.
  std::vector<Slot> slots_;
  std::size_t slots_used_ = 0;
  std::unordered_map<std::string, std::uint32_t, TextHash, std::equal_to<>> long_;
};

}  // namespace biss::capture
