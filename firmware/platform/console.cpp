#include "firmware/platform/console.hpp"

#include <array>
#include <cstddef>

namespace firmware {
namespace {

void write_in_base(std::uint64_t value, unsigned base) {
  std::array<char, 24> digits{};
  std::size_t at = digits.size() - 1;
  do {
    digits[--at] = "0123456789abcdef"[value % base];
    value /= base;
  } while (value != 0);
  write(&digits[at]);
}

}  // namespace

void write(std::uint64_t number) { write_in_base(number, 10); }

void write(Hex hex) {
  write("0x");
  write_in_base(hex.number, 16);
}

}  // namespace firmware
