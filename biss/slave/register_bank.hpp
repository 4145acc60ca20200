// 64 registers, and what a master may do with each.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "biss/base/big_endian.hpp"
#include "biss/control/control_frame.hpp"
#include "biss/control/register_map.hpp"

namespace biss {

/// The three levels of D2; on the line "protected" and "not there" are the same.
enum class RegisterProtection : std::uint8_t { not_available, read_only, read_write };

/// Offsets are 0 … 63; whoever owns the bank says at which address it begins. At first nothing is
/// available.
class RegisterBank {
 public:
  constexpr RegisterBank() = default;
  /// All 64 with the same protection.
  constexpr RegisterBank(std::span<const std::uint8_t, bank_bytes> values,
                         RegisterProtection protection) {
    put(0, values, protection);
  }

  /// Gives registers from `offset` on their values and protection; what would lie behind the last
  /// is left out.
  constexpr void put(std::size_t offset, std::span<const std::uint8_t> values,
                     RegisterProtection protection) {
    for (std::size_t i = 0; i < values.size() && offset + i < bank_bytes; ++i) {
      values_[offset + i] = values[i];
      protect(offset + i, protection);
    }
  }
  /// The same for a number of `Bytes` bytes, the highest at the lowest offset.
  template <std::size_t Bytes>
  constexpr void put_number(std::size_t offset, std::uint64_t number,
                            RegisterProtection protection) {
    put(offset, to_big_endian<Bytes>(number), protection);
  }
  /// \pre offset below 64, here and below
  constexpr void protect(std::size_t offset, RegisterProtection protection) {
    const std::uint64_t mask = std::uint64_t{1} << offset;
    readable_ =
        protection == RegisterProtection::not_available ? readable_ & ~mask : readable_ | mask;
    writable_ = protection == RegisterProtection::read_write ? writable_ | mask : writable_ & ~mask;
  }

  constexpr bool permits(RegisterAccess access, std::size_t offset) const {
    return ((access == RegisterAccess::read ? readable_ : writable_) >> offset & 1U) != 0;
  }
  constexpr std::uint8_t& operator[](std::size_t offset) { return values_[offset]; }
  constexpr std::uint8_t operator[](std::size_t offset) const { return values_[offset]; }

 private:
  std::array<std::uint8_t, bank_bytes> values_{};
  std::uint64_t readable_ = 0;
  std::uint64_t writable_ = 0;
};

}  // namespace biss
