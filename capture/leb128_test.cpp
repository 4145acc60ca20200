#include "capture/leb128.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace biss::capture {
namespace leb128_test {

// Gives the bytes one after the other, then zeros.
template <std::size_t Size>
struct Bytes {
  std::array<std::uint8_t, Size> bytes;
  std::size_t at = 0;

  constexpr std::uint8_t operator()() { return at < Size ? bytes[at++] : std::uint8_t{0}; }
};

static_assert(leb128<std::uint64_t>(Bytes<1>{{0x7F}}) == 127);
static_assert(leb128<std::uint64_t>(Bytes<3>{{0xE5, 0x8E, 0x26}}) == 624'485);
static_assert(leb128<std::int64_t>(Bytes<1>{{0x7F}}) == -1);
static_assert(leb128<std::int64_t>(Bytes<3>{{0xC0, 0xBB, 0x78}}) == -123'456);

constexpr Bytes<10> ten_bytes(std::uint8_t last) {
  return {{0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, last}};
}

TEST(Leb128, NumberOf64Bits_IsWhole) {
  EXPECT_EQ(leb128<std::uint64_t>(ten_bytes(1)), std::numeric_limits<std::uint64_t>::max());
  EXPECT_EQ(leb128<std::int64_t>(ten_bytes(0x7F)), -1);
}

TEST(Leb128, NumberOfMoreThan64Bits_IsNone) {
  EXPECT_FALSE(leb128<std::uint64_t>(ten_bytes(2)));
  EXPECT_FALSE(leb128<std::uint64_t>(ten_bytes(0xFF)));
  EXPECT_FALSE(leb128<std::int64_t>(ten_bytes(0xFF)));
}

}  // namespace leb128_test
}  // namespace biss::capture
