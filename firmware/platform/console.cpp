#include "firmware/platform/console.hpp"

#include <array>
#include <cstddef>

namespace firmware {
namespace {

void write_number(std::uint64_t value, unsigned base) {
  std::array<char, 24> digits{};
  std::size_t at = digits.size() - 1;
  do {
    digits[--at] = "0123456789abcdef"[value % base];
    value /= base;
  } while (value != 0);
  write(&digits[at]);
}

}  // namespace

void write_decimal(std::uint64_t value) { write_number(value, 10); }

void write_hex(std::uint64_t value) {
  write("0x");
  write_number(value, 16);
}

}  // namespace firmware
