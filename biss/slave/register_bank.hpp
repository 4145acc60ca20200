// 64 registers, and what a master may do with each.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "biss/slave/register_owner.hpp"

namespace biss {

/// The three levels of D2; on the line "protected" and "not there" are the same.
enum class RegisterProtection : std::uint8_t { not_available, read_only, read_write };

inline constexpr std::size_t register_bank_bytes = 64;

/// Offsets are 0 … 63; whoever owns the bank says at which address it begins. At first nothing is
/// available.
class RegisterBank {
 public:
  constexpr RegisterBank() = default;
  /// All 64 with the same protection.
  constexpr RegisterBank(std::span<const std::uint8_t, register_bank_bytes> values,
                         RegisterProtection protection) {
    put(0, values, protection);
  }

  /// Gives registers from `offset` on their values and protection; what would lie behind the last
  /// is left out.
  constexpr void put(std::size_t offset, std::span<const std::uint8_t> values,
                     RegisterProtection protection) {
    for (std::size_t i = 0; i < values.size() && offset + i < register_bank_bytes; ++i) {
      values_[offset + i] = values[i];
      protect(offset + i, protection);
    }
  }
  /// The same for a number that takes `bytes` registers, the highest byte at the lowest offset.
  constexpr void put_number(std::size_t offset, std::uint64_t number, std::size_t bytes,
                            RegisterProtection protection) {
    std::array<std::uint8_t, 8> values{};
    const std::size_t count = std::min(bytes, values.size());
    for (std::size_t i = count; i-- > 0; number >>= 8U) {
      values[i] = static_cast<std::uint8_t>(number);
    }
    put(offset, std::span(values).first(count), protection);
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
  std::array<std::uint8_t, register_bank_bytes> values_{};
  std::uint64_t readable_ = 0;
  std::uint64_t writable_ = 0;
};

}  // namespace biss
