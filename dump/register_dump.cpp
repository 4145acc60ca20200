#include "dump/register_dump.hpp"

#include <algorithm>

namespace biss::dump {

std::optional<std::uint64_t> RegisterDump::direct_number(unsigned address, unsigned size) const {
  std::uint64_t number = 0;
  for (unsigned i = 0; i < size; ++i) {
    const auto byte = direct_byte(address + i);
    if (!byte) return std::nullopt;
    number = number << 8U | *byte;
  }
  return number;
}

std::size_t RegisterDump::known_bytes(unsigned number) const {
  const auto known = std::count_if(banks_[number].begin(), banks_[number].end(),
                                   [](const auto& byte) { return byte.has_value(); });
  return static_cast<std::size_t>(known);
}

std::optional<EdsBank> RegisterDump::whole_bank(unsigned number) const {
  EdsBank bytes{};
  for (std::size_t i = 0; i < bank_bytes; ++i) {
    if (!banks_[number][i]) return std::nullopt;
    bytes[i] = *banks_[number][i];
  }
  return bytes;
}

std::optional<RegisterDump::BankRange> RegisterDump::banks() const {
  std::optional<BankRange> range;
  for (unsigned number = 0; number < bank_count; ++number) {
    if (known_bytes(number) == 0) continue;
    if (!range) range = BankRange{number, number};
    range->last = number;
  }
  return range;
}

}  // namespace biss::dump
