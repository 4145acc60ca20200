// Identifiers of a VCD: one or more characters from '!' to '~', looked up at every change.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace biss::capture {

/// Identifiers to numbers 0, 1, 2, … in the order of their first add().
class VcdIds {
 public:
  static constexpr std::uint32_t none = UINT32_MAX;

  VcdIds();

  /// The number of `id`, a new one when it was not known.
  /// \pre valid(id)
  std::uint32_t add(std::string_view id);
  /// The number of `id`, or none; any text may be asked for.
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
