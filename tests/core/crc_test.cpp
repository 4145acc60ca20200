#include "biss/base/bits.hpp"
#include "biss/crc/engines.hpp"
#include "biss/crc/placed.hpp"
#include "biss/crc/spec.hpp"
#include "tests/core/test.hpp"

namespace biss::crc_test {

constexpr CrcSpec crc4{.polynomial = 0x13, .start = 0, .width_bits = 4, .inverted = true};

constexpr CrcSpec with_start(CrcSpec spec, std::uint16_t start) {
  spec.start = start;
  return spec;
}

constexpr CrcSpec plain(CrcSpec spec) {
  spec.inverted = false;
  return spec;
}

struct Vector {
  CrcSpec spec;
  std::uint64_t data;
  std::uint8_t bits;
  std::uint16_t crc;
};

// Published by iC-Haus (AN18, AN21, AN22 and its demo captures) and Texas Instruments.
constexpr std::array published{
    Vector{crc6, 0x4D5, 12, 0x1C},
    Vector{crc16, 0xD9CFE0C0DA, 40, 0x5F29},
    Vector{crc6, 0x05AC53 * 4 + 0, 26, 0x2F},
    Vector{crc6, 0xFCD * 4 + 3, 14, 0x3D},
    Vector{crc6, 0x37F * 4 + 3, 14, 0x13},
    Vector{crc6, 0x380 * 4 + 3, 14, 0x27},
    Vector{crc6, 0x00000D67, 30, 0x31},
    Vector{crc4, 0x400, 11, 0x6},
    Vector{crc4, 0x420, 11, 0xC},
    Vector{crc4, 0x402, 11, 0x0},
    Vector{crc4, 0x48, 8, 0x3},
    Vector{crc4, 0x44, 8, 0x4},
    Vector{crc4, 0x00, 8, 0xF},
    Vector{crc4, 0x55, 8, 0x2},
    Vector{crc4, 0x40, 8, 0x8},
    Vector{crc6, 0xC00 * 4 + 1, 14, 0x2D},
    Vector{crc16, ((std::uint64_t{65535} << 12U | 2924) * 4 + 1) * 64 + 57, 36, 0xD79F},
    Vector{crc6, 1406 * 4 + 3, 14, 0x36},
    Vector{plain(crc6), 0b110101101110100010001011, 24, 0b110011},
    Vector{crc6, (0xA5AULL << 12U | 0xFA5) * 4 + 3, 26, 0x19},
};

// SPW: position, nE nW = 11, sign of life; CRC16 with start 0 and start 1.
constexpr std::uint64_t spw(std::uint64_t position, std::uint64_t life) {
  return (position * 4 + 3) * 64 + life;
}
constexpr std::array safety{
    Vector{crc16, spw(0x123456, 1), 32, 0x1CBF},
    Vector{crc16, spw(0x1234567, 1), 36, 0xE49E},
    Vector{crc16, spw(0x1234567, 63), 36, 0x7976},
    Vector{crc16, spw(0x12345678, 0), 40, 0x2498},
    Vector{crc16, spw(0x12345678, 1), 40, 0xB441},
    Vector{with_start(crc16, 1), spw(0x123456, 1), 32, 0x24CD},
    Vector{with_start(crc16, 1), spw(0x1234567, 1), 36, 0x420C},
    Vector{with_start(crc16, 1), spw(0x1234567, 63), 36, 0xDFE4},
    Vector{with_start(crc16, 1), spw(0x12345678, 0), 40, 0x8814},
    Vector{with_start(crc16, 1), spw(0x12345678, 1), 40, 0x18CD},
};

struct PositionVector {
  std::uint64_t position;
  std::uint8_t bits;
  std::array<std::uint16_t, 3> crc;  // nE nW = 11, 01, 10
};
constexpr std::array positions{
    PositionVector{0x00000, 18, {0x3A, 0x3C, 0x39}},
    PositionVector{0x12345, 18, {0x0D, 0x0B, 0x0E}},
    PositionVector{0x3FFFF, 18, {0x02, 0x04, 0x01}},
    PositionVector{0x1234567, 26, {0x2B, 0x2D, 0x28}},
    PositionVector{0x12345678, 32, {0x05, 0x03, 0x06}},
    PositionVector{0xFFFFFFFF, 32, {0x1A, 0x1C, 0x19}},
    PositionVector{0x123456789, 36, {0x34, 0x32, 0x37}},
    PositionVector{0xFFFFFFFFF, 36, {0x25, 0x23, 0x26}},
};

template <class Crc>
constexpr bool holds(const Vector& vector) {
  return Crc(vector.spec)(vector.data, vector.bits) == vector.crc;
}

static_assert(holds<CrcBitwise>(published[0]) && holds<CrcTable<4>>(published[0]));
static_assert(holds<CrcBitwise>(safety[9]) && holds<CrcTable<8>>(safety[9]));
// Tables of 4 KiB belong into flash, not onto the stack of a small microcontroller.
constexpr CrcSliced sliced_crc6(crc6);
static_assert(sliced_crc6(0x12345 * 4 + 3, 20) == 0x0D);

// A polynomial for every width, the usual one where there is one.
constexpr CrcSpec spec_of(unsigned width) {
  constexpr std::array<std::uint32_t, 17> polynomials{0,      0,      0,      0x0B,   0x13,   0x25,
                                                      0x43,   0x89,   0x12F,  0x211,  0x633,  0xB75,
                                                      0x180F, 0x201B, 0x4443, 0x8003, 0x190D9};
  return {.polynomial = polynomials[width],
          .start = 0,
          .width_bits = static_cast<std::uint8_t>(width),
          .inverted = true};
}

// Start values in which a fault in any bit of the register is visible.
constexpr std::array<std::uint16_t, 4> starts{0x0000, 0x0001, 0xFFFF, 0xA53C};

template <class Crc>
void compare_with_bitwise(const Crc& engine, test::Random& random) {
  const CrcBitwise reference(engine.spec());
  for (unsigned bits = 1; bits <= max_data_bits; ++bits) {
    const std::uint64_t top = std::uint64_t{1} << (bits - 1U);
    const std::array<std::uint64_t, 5> data{0, 1, top, low_mask(bits), random.bits(bits)};
    for (const std::uint64_t word : data) {
      BISS_ASSERT_EQ(engine(word, bits), reference(word, bits))
          << "width " << engine.spec().width_bits << " start " << engine.spec().start << " bits "
          << bits;
    }
  }
}

template <class Crc>
void compare_every_width(test::Random& random) {
  for (unsigned width = min_crc_bits; width <= max_crc_bits; ++width) {
    for (const std::uint16_t start : starts) {
      const CrcSpec spec = spec_of(width);
      const CrcSpec started = with_start(spec, static_cast<std::uint16_t>(start & spec.mask()));
      compare_with_bitwise(Crc(started), random);
      compare_with_bitwise(Crc(plain(started)), random);
    }
  }
}

constexpr bool on_host = test::rounds(1, 0) == 1;

// A sliced engine has 4 KiB: one for each width on the host, fewer in a microcontroller's flash.
template <unsigned Width>
void compare_sliced(test::Random& random) {
  if constexpr (on_host || Width == 3 || Width == 7 || Width == 16) {
    static constexpr CrcSliced usual(spec_of(Width));
    static constexpr CrcSliced odd(
        plain(with_start(spec_of(Width), 0xA53C & spec_of(Width).mask())));
    compare_with_bitwise(usual, random);
    compare_with_bitwise(odd, random);
  }
}

template <unsigned... Offsets>
void compare_sliced_widths(test::Random& random, std::integer_sequence<unsigned, Offsets...>) {
  (compare_sliced<min_crc_bits + Offsets>(random), ...);
}

/// The number of patterns of exactly three flips in a word of `bits` bits that leave the checksum
/// right.
unsigned triples_that_pass(const CrcBitwise& crc, std::uint64_t data, unsigned data_bits) {
  const unsigned width = crc.spec().width_bits;
  const unsigned bits = data_bits + width;
  const std::uint64_t word = data << width | crc(data, data_bits);
  unsigned passed = 0;
  for (unsigned a = 2; a < bits; ++a) {
    for (unsigned b = 1; b < a; ++b) {
      for (unsigned c = 0; c < b; ++c) {
        const std::uint64_t flips = std::uint64_t{1} << a | std::uint64_t{1} << b | 1ULL << c;
        const std::uint64_t hurt = word ^ flips;
        if (crc(hurt >> width, data_bits) == (hurt & low_mask(width))) ++passed;
      }
    }
  }
  return passed;
}

BISS_TEST(Crc, PublishedNumbers_AreReached) {
  for (const Vector& vector : published) {
    BISS_EXPECT_EQ(CrcBitwise(vector.spec)(vector.data, vector.bits), vector.crc)
        << "data " << vector.data;
    BISS_EXPECT(holds<CrcTable<4>>(vector)) << "data " << vector.data;
    BISS_EXPECT(holds<CrcTable<8>>(vector)) << "data " << vector.data;
  }
}

BISS_TEST(Crc, SafetyWordsWithAndWithoutStartValue_AreReached) {
  for (const Vector& vector : safety) {
    BISS_EXPECT_EQ(CrcBitwise(vector.spec)(vector.data, vector.bits), vector.crc)
        << "data " << vector.data << " start " << vector.spec.start;
    BISS_EXPECT(holds<CrcTable<4>>(vector)) << "data " << vector.data;
    BISS_EXPECT(holds<CrcTable<8>>(vector)) << "data " << vector.data;
  }
}

BISS_TEST(Crc, PositionsWithEachFlag_AreReached) {
  constexpr std::array<std::uint64_t, 3> flags{3, 1, 2};
  for (const PositionVector& vector : positions) {
    for (std::size_t i = 0; i < flags.size(); ++i) {
      const std::uint64_t data = vector.position * 4 + flags[i];
      BISS_EXPECT_EQ(CrcBitwise(crc6)(data, vector.bits + 2U), vector.crc[i]);
      BISS_EXPECT_EQ(sliced_crc6(data, vector.bits + 2U), vector.crc[i]);
      BISS_EXPECT_EQ(CrcFast(crc6).spec(), crc6);
    }
  }
}

BISS_TEST(Crc, NullWord_IsAllOnesWhenInverted) {
  BISS_EXPECT_EQ(CrcBitwise(crc6)(0, 20), 0x3F);
  BISS_EXPECT_EQ(CrcBitwise(plain(crc6))(0, 20), 0);
  BISS_EXPECT_EQ(CrcBitwise(crc16)(0, 64), 0xFFFF);
}

BISS_TEST(Crc, NibbleTableAtEveryWidthAndLength_EqualsBitwise) {
  BISS_RANDOM(random, 0xC0DE'0001);
  compare_every_width<CrcTable<4>>(random);
}

BISS_TEST(Crc, ByteTableAtEveryWidthAndLength_EqualsBitwise) {
  BISS_RANDOM(random, 0xC0DE'0002);
  compare_every_width<CrcTable<8>>(random);
}

BISS_TEST(Crc, SlicedTables_EqualBitwise) {
  BISS_RANDOM(random, 0xC0DE'0003);
  compare_sliced_widths(random,
                        std::make_integer_sequence<unsigned, max_crc_bits - min_crc_bits + 1>{});
}

BISS_TEST(Crc, RandomPolynomials_EqualBitwise) {
  BISS_RANDOM(random, 0xC0DE'0004);
  const std::uint64_t rounds = test::rounds(2'000, 100);
  for (std::uint64_t round = 0; round < rounds; ++round) {
    const unsigned width = min_crc_bits + random.below(max_crc_bits - min_crc_bits + 1);
    const std::uint64_t middle = random.bits(width - 1) << 1U;
    const CrcSpec spec{static_cast<std::uint32_t>((1ULL << width) | middle | 1U),
                       static_cast<std::uint16_t>(random.flip() ? 0 : random.bits(width)),
                       static_cast<std::uint8_t>(width), random.flip()};
    const unsigned bits = 1 + random.below(max_data_bits);
    const std::uint64_t data = random.bits(bits);
    const std::uint16_t expected = CrcBitwise(spec)(data, bits);
    if constexpr (on_host) {
      BISS_ASSERT_EQ(CrcSliced(spec)(data, bits), expected) << "polynomial " << spec.polynomial;
    }
    BISS_ASSERT_EQ(CrcTable<4>(spec)(data, bits), expected) << "polynomial " << spec.polynomial;
    BISS_ASSERT_EQ(CrcTable<8>(spec)(data, bits), expected) << "polynomial " << spec.polynomial;
  }
}

BISS_TEST(Crc, AbsentSpec_MakesEnginesThatKnowIt) {
  CrcSpec absent;
  BISS_EXPECT(!CrcBitwise().spec().present());
  BISS_EXPECT(!CrcBitwise(absent).spec().present());
  BISS_EXPECT(!CrcTable<4>(absent).spec().present());
  BISS_EXPECT(!CrcTable<8>(absent).spec().present());
  if constexpr (on_host) {
    BISS_EXPECT(!CrcSliced(absent).spec().present());
  }
}

static_assert(CrcBitwise()(0x123, 12) == 0 && CrcTable<4>()(0x123, 12) == 0);

BISS_TEST(Crc, AbsentSpec_GivesZero) {
  const std::uint64_t data = 0x0123'4567'89AB'CDEF;
  for (const unsigned bits : {1U, 12U, 40U, 64U}) {
    BISS_EXPECT_EQ(CrcBitwise()(data & low_mask(bits), bits), 0) << bits;
    BISS_EXPECT_EQ(CrcTable<4>()(data & low_mask(bits), bits), 0) << bits;
    BISS_EXPECT_EQ(CrcTable<8>()(data & low_mask(bits), bits), 0) << bits;
    if constexpr (on_host) {
      BISS_EXPECT_EQ(CrcSliced()(data & low_mask(bits), bits), 0) << bits;
    }
  }
}

BISS_TEST(Crc, ThreeFlips_PassAsOftenAsTheCodeSays) {
  BISS_EXPECT_EQ(triples_that_pass(CrcBitwise(crc4), 0x55, 8), 17);
  BISS_EXPECT_EQ(triples_that_pass(CrcBitwise(crc4), 0x40F, 11), 35);
  BISS_EXPECT_EQ(triples_that_pass(CrcBitwise(crc6), 0x12345 * 4 + 3, 20), 40);
}

BISS_TEST(CrcSpec, FullForm_HasTopAndBottomTerm) {
  BISS_EXPECT(is_full_form(0x43, 6));
  BISS_EXPECT(is_full_form(0x190D9, 16));
  BISS_EXPECT(!is_full_form(0x42, 6));
  BISS_EXPECT(!is_full_form(0x43, 5));
  BISS_EXPECT(!is_full_form(0x43, 7));
  BISS_EXPECT(!is_full_form(0, 3));
}

BISS_TEST(CrcSpec, UsualPolynomials_AreTheMastersOnes) {
  constexpr std::array<std::uint32_t, 20> usual{0, 0, 0, 0x0B, 0x13, 0x25, 0x43,    0x89, 0x12F, 0,
                                                0, 0, 0, 0,    0,    0,    0x190D9, 0,    0,     0};
  for (unsigned width = 0; width < usual.size(); ++width) {
    BISS_EXPECT_EQ(default_polynomial(width), usual[width]) << "width " << width;
    BISS_EXPECT(usual[width] == 0 || is_full_form(usual[width], width)) << "width " << width;
  }
}

BISS_TEST(CrcSpec, Mask_IsAsWideAsTheChecksum) {
  BISS_EXPECT_EQ(crc6.mask(), 0x3F);
  BISS_EXPECT_EQ(crc16.mask(), 0xFFFF);
  BISS_EXPECT_EQ(CrcSpec{}.mask(), 0);
}

// Data and CRC in a word with noise around them; one wrong bit in half of the rounds.
template <class Engine>
void expect_placed_as_bitwise(const CrcSpec& spec, std::uint64_t seed) {
  BISS_RANDOM(random, seed);
  for (unsigned bits = 1; bits <= 64; ++bits) {
    const PlacedCrc<Engine> placed(spec, bits);
    BISS_EXPECT(placed.spec() == spec);
    for (std::uint32_t i = 0; i < test::rounds(200, 5); ++i) {
      const std::uint64_t data = random.bits(bits);
      const std::uint16_t crc = CrcBitwise(spec)(data, bits);
      BISS_ASSERT_EQ(placed(data), crc) << bits << " bits";
      if (bits + spec.width_bits > 63) continue;
      const unsigned after = 63U - bits - spec.width_bits;
      const std::uint64_t frame = data << spec.width_bits | crc;
      const std::uint64_t word =
          std::uint64_t{random.flip()} << 63U | frame << after | random.bits(after);
      BISS_ASSERT(placed.is_right(word)) << bits << " bits";
      const unsigned wrong = random.below(bits + spec.width_bits);
      BISS_ASSERT(!placed.is_right(word ^ std::uint64_t{1} << after << wrong)) << bits << " bits";
    }
  }
}

BISS_TEST(PlacedCrc, EveryLengthOfData_AsBitwise) {
  for (const CrcSpec& spec : {crc4, crc6, crc16, plain(crc6), with_start(crc6, 0x2A),
                              with_start(crc16, 0xBEEF), with_start(plain(crc16), 1)}) {
    expect_placed_as_bitwise<CrcSliced>(spec, 0xC2C0);
    expect_placed_as_bitwise<CrcTable<4>>(spec, 0xC2C1);
    expect_placed_as_bitwise<CrcTable<8>>(spec, 0xC2C2);
  }
}

BISS_TEST(PlacedCrc, NoCrc_IsAlwaysRight) {
  BISS_EXPECT(PlacedCrc<CrcSliced>(CrcSpec{}, 20).is_right(0x1234'5678'9ABC'DEF0));
  BISS_EXPECT(PlacedCrc<CrcTable<4>>(CrcSpec{}, 20).is_right(0x1234'5678'9ABC'DEF0));
  BISS_EXPECT(PlacedCrc<CrcBitwise>(CrcSpec{}, 20).is_right(0x1234'5678'9ABC'DEF0));
}

}  // namespace biss::crc_test
