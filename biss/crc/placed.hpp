// The CRC of a channel whose data and CRC have a known place in a 64-bit word. The CRC is checked
// without extracting data or CRC.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "biss/base/bits.hpp"
#include "biss/crc/engines.hpp"
#include "biss/crc/spec.hpp"

namespace biss {

/// The CRC of `data_bits` of data, for a word that holds the data from its second bit on (from the
/// top), then the CRC as received; its other bits do not matter. `Engine` is one of
/// biss/crc/engines.hpp.
template <class Engine>
class PlacedCrc {
 public:
  constexpr PlacedCrc() = default;
  /// \pre data_bits is 1…64
  constexpr PlacedCrc(const CrcSpec& spec, unsigned data_bits)
      : engine_(spec), data_bits_(static_cast<std::uint8_t>(data_bits)) {}

  constexpr const CrcSpec& spec() const { return engine_.spec(); }
  /// CRC of right-aligned data, as transmitted.
  [[gnu::always_inline]] constexpr std::uint16_t operator()(std::uint64_t data) const {
    // In bounds, also after a fault of the memory.
    return engine_(data, std::clamp(unsigned{data_bits_}, 1U, 64U));
  }
  /// Whether data and CRC in `word` agree; true without a CRC.
  /// \pre the data and the CRC have at most 63 bits
  [[gnu::always_inline]] constexpr bool is_right(std::uint64_t word) const {
    const unsigned width = spec().width_bits;
    if (width == 0) return true;
    using bits_detail::left, bits_detail::right;
    const std::uint64_t data = right(word << 1U, 64U - data_bits_);
    return right(left(word << 1U, data_bits_), 64U - width) == (*this)(data);
  }

 private:
  Engine engine_;
  std::uint8_t data_bits_ = 1;
};

/// With a table for each byte of the word: the look-ups need neither shift nor mask of the format,
/// and the received CRC is part of the sum. A start value costs nothing.
template <>
class PlacedCrc<CrcSliced> {
 public:
  constexpr PlacedCrc() = default;
  constexpr PlacedCrc(const CrcSpec& spec, unsigned data_bits) : spec_(spec) {
    const bool fits = data_bits + spec.width_bits <= 63;
    last_data_bit_ = static_cast<std::uint8_t>(fits ? 63U - data_bits : 0U);
    const unsigned first_bit = fits ? last_data_bit_ - spec.width_bits : 0U;
    if (fits) slices_ = static_cast<std::uint8_t>((71U - first_bit) / 8U);
    if (!spec.present()) return;
    fill(remainders(first_bit, last_data_bit_ + data_bits));
    // Inversion and start value add the same to every CRC.
    const std::uint16_t constant = CrcBitwise(spec)(0, data_bits);
    for (std::uint16_t& entry : table_[0]) entry = static_cast<std::uint16_t>(entry ^ constant);
  }

  constexpr const CrcSpec& spec() const { return spec_; }
  constexpr std::uint16_t operator()(std::uint64_t data) const {
    return sum(bits_detail::left(data, last_data_bit_));
  }
  constexpr bool is_right(std::uint64_t word) const { return sum(word) == 0; }

 private:
  static constexpr unsigned slices = 8;
  using Remainders = std::array<std::uint16_t, 64>;

  // The remainder of each bit of the word, bit 0 the lowest; 0 for bits outside of data and CRC.
  constexpr Remainders remainders(unsigned first_bit, unsigned end_bit) const {
    Remainders of{};
    std::uint32_t reg = 1;
    // Data that do not fit with their CRC are alone in the word.
    if (last_data_bit_ == 0) {
      for (unsigned i = 0; i < spec_.width_bits; ++i) reg = crc_detail::step(spec_, reg, false);
    }
    for (unsigned bit = first_bit; bit < end_bit; ++bit) {
      of[bit] = static_cast<std::uint16_t>(reg);
      reg = crc_detail::step(spec_, reg, false);
    }
    return of;
  }

  // A remainder is linear in the byte: each bit doubles the entries that are known.
  constexpr void fill(const Remainders& of) {
    for (unsigned slice = 0; slice < slices; ++slice) {
      for (unsigned bit = 0; bit < 8; ++bit) {
        const unsigned known = 1U << bit;
        const std::uint16_t more = of[56U - 8U * slice + bit];
        for (unsigned i = 0; i < known; ++i) {
          table_[slice][known + i] = static_cast<std::uint16_t>(table_[slice][i] ^ more);
        }
      }
    }
  }

  // Keeps GCC from joining this shift and the next one: the two lowest bytes of a register need no
  // shift.
  static constexpr std::uint64_t kept(std::uint64_t word) {
#if defined(__GNUC__) && !defined(__clang__)
    if (!std::is_constant_evaluated()) asm("" : "+r"(word));
#endif
    return word;
  }
  constexpr std::uint16_t at(unsigned slice, std::uint64_t byte) const {
    return table_[slice][byte & 0xFFU];
  }

  [[gnu::always_inline]] constexpr std::uint16_t sum(std::uint64_t word) const {
    using crc_detail::pair;
    const std::uint64_t half = kept(word >> 32U);
    std::uint16_t all =
        pair(pair(at(0, word >> 56U), at(1, half >> 16U)), pair(at(2, half >> 8U), at(3, half)));
    if (slices_ > 4) all = pair(all, at(4, word >> 24U));
    if (slices_ > 5) {
      all = pair(all, at(5, word >> 16U));
      if (slices_ > 6) all = pair(all, pair(at(6, word >> 8U), at(7, word)));
    }
    return all;
  }

  CrcSpec spec_;
  // Right-aligned data are moved up by this many bits.
  std::uint8_t last_data_bit_ = 0;
  // Bytes from the top that hold data or CRC.
  std::uint8_t slices_ = slices;
  std::array<std::array<std::uint16_t, 256>, slices> table_{};
};

}  // namespace biss
