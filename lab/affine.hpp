// Bits that are the XOR of data bits and a constant, and systems of conditions on such bits: linear
// algebra over GF(2) in bounded memory.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "biss/base/bits.hpp"
#include "biss/crc/spec.hpp"

namespace biss::frame_detail {

/// XOR of some data bits of each channel, and of 1 when `one`.
template <std::size_t Channels>
struct AffineBit {
  std::array<std::uint64_t, Channels> data{};
  bool one = false;

  constexpr AffineBit& operator^=(const AffineBit& other) {
    for (std::size_t k = 0; k < Channels; ++k) data[k] ^= other.data[k];
    one = one != other.one;
    return *this;
  }
};

/// Conditions, each "this bit is 0", and how many of them are independent.
template <std::size_t Channels>
class AffineSystem {
 public:
  using Bit = AffineBit<Channels>;

  /// A data bit whose value is known beforehand: no condition.
  /// \pre no condition has been added
  constexpr void know(std::size_t channel, std::uint64_t mask, std::uint64_t value) {
    known_[channel] |= mask;
    value_[channel] |= value & mask;
  }

  /// A condition on one data bit. Kept apart from the others because there may be many.
  /// \pre no other condition has been added
  constexpr void require_data(std::size_t channel, std::uint64_t mask, bool level) {
    if ((known_[channel] & mask) != 0) {
      if (((value_[channel] & mask) != 0) != level) possible_ = false;
      return;
    }
    know(channel, mask, level ? mask : 0);
    ++independent_;
  }

  /// \pre at most 32 independent ones a channel
  constexpr void require_zero(Bit bit) {
    for (std::size_t k = 0; k < Channels; ++k) {
      if (std::popcount(bit.data[k] & value_[k]) % 2 != 0) bit.one = !bit.one;
      bit.data[k] &= ~known_[k];
    }
    for (std::size_t row = 0; row < rows_; ++row) {
      const Pivot& pivot = pivot_[row];
      if (((bit.data[pivot.channel] >> pivot.shift) & 1U) != 0) bit ^= row_[row];
    }
    for (std::size_t k = 0; k < Channels; ++k) {
      if (bit.data[k] == 0) continue;
      pivot_[rows_] = {static_cast<std::uint8_t>(k),
                       static_cast<std::uint8_t>(std::countr_zero(bit.data[k]))};
      row_[rows_++] = bit;
      ++independent_;
      return;
    }
    if (bit.one) possible_ = false;
  }

  constexpr std::optional<unsigned> independent() const {
    if (!possible_) return std::nullopt;
    return independent_;
  }

 private:
  struct Pivot {
    std::uint8_t channel = 0;
    std::uint8_t shift = 0;
  };
  // A CRC bit may be asked to have a level, and to agree with the data read: two rows each.
  static constexpr std::size_t most_rows = 2U * max_crc_bits * Channels;

  std::array<std::uint64_t, Channels> known_{};
  std::array<std::uint64_t, Channels> value_{};
  std::array<Bit, most_rows> row_{};
  std::array<Pivot, most_rows> pivot_{};
  std::size_t rows_ = 0;
  unsigned independent_ = 0;
  bool possible_ = true;
};

}  // namespace biss::frame_detail
