// Every CRC engine compared with the bitwise one and with polynomial division.
#include <gtest/gtest.h>

#include <cstdint>

#include "biss/crc/engines.hpp"
#include "tests/core/test.hpp"
#include "tests/exhaustive/scale.hpp"
#include "tests/oracle/oracle.hpp"

namespace exhaustive {
namespace engines_test {

biss::CrcSpec random_spec(biss::test::Random& random, unsigned width) {
  const std::uint64_t polynomial =
      (std::uint64_t{1} << width) | (random.bits(width - 1) << 1U) | 1U;
  const std::uint64_t start = random.below(3) == 0 ? 0 : random.bits(width);
  return {static_cast<std::uint32_t>(polynomial), static_cast<std::uint16_t>(start),
          static_cast<std::uint8_t>(width), random.flip()};
}

std::uint64_t divided(const biss::CrcSpec& spec, std::uint64_t data, unsigned bits) {
  const oracle::Checksum checksum{oracle::bits_of(spec.polynomial, spec.width_bits + 1U),
                                  oracle::bits_of(spec.start, spec.width_bits), spec.inverted};
  return oracle::number_of(oracle::checksum_of(checksum, oracle::bits_of(data, bits)), 0,
                           spec.width_bits);
}

TEST(Engines, RandomPolynomialsAtEveryWidthAndLength_AgreeWithDivision) {
  BISS_RANDOM(random, 0xE6E0'0001);
  for (unsigned width = biss::min_crc_bits; width <= biss::max_crc_bits; ++width) {
    for (std::uint64_t round = 0; round < rounds(60); ++round) {
      const biss::CrcSpec spec = random_spec(random, width);
      const biss::CrcBitwise bitwise(spec);
      const biss::CrcTable<4> nibbles(spec);
      const biss::CrcTable<8> octets(spec);
      const biss::CrcSliced sliced(spec);
      for (unsigned bits = 1; bits <= biss::max_data_bits; ++bits) {
        const std::uint64_t data = random.bits(bits);
        const std::uint64_t expected = divided(spec, data, bits);
        ASSERT_EQ(bitwise(data, bits), expected) << spec.polynomial << " of " << bits << " bits";
        ASSERT_EQ(nibbles(data, bits), expected) << spec.polynomial << " of " << bits << " bits";
        ASSERT_EQ(octets(data, bits), expected) << spec.polynomial << " of " << bits << " bits";
        ASSERT_EQ(sliced(data, bits), expected) << spec.polynomial << " of " << bits << " bits";
      }
    }
  }
}

}  // namespace engines_test

}  // namespace exhaustive
