#include "dump/write.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "dump/test_dumps.hpp"

namespace biss::dump {
namespace write_test {

using testing::HasSubstr;

TEST(RoundTrip, HexPageAndIntelHex_KeepEveryByteAndHole) {
  constexpr unsigned seed = 20240817;
  std::mt19937 random(seed);
  for (int i = 0; i < 300; ++i) {
    const RegisterDump dump = random_dump(random);
    if (dump == RegisterDump{}) continue;
    ASSERT_EQ(good(write_hex_page(dump)), dump) << "seed " << seed << ", dump " << i;
    ASSERT_EQ(good(write_intel_hex(dump)), dump) << "seed " << seed << ", dump " << i;
  }
}

TEST(RoundTrip, Binary_KeepsBanksAndFillsHolesWithOnes) {
  constexpr unsigned seed = 7;
  std::mt19937 random(seed);
  for (int i = 0; i < 100; ++i) {
    RegisterDump dump = random_dump(random);
    const auto range = dump.banks();
    if (!range) continue;
    const RegisterDump back =
        good(write_binary(dump, range->first), {.bank = static_cast<std::uint8_t>(range->first)});
    for (unsigned number = range->first; number <= range->last; ++number) {
      for (unsigned at = 0; at < bank_bytes; ++at) {
        ASSERT_EQ(back.bank(number)[at], dump.bank(number)[at].value_or(0xFF))
            << "seed " << seed << ", dump " << i;
      }
    }
    EXPECT_EQ(back.direct(), DumpedBytes{});
  }
}

TEST(Write, PageOfRealDevice_ReadsBack) {
  const RegisterDump dump = good(mhm_page);
  EXPECT_EQ(good(write_hex_page(dump)), dump);
  EXPECT_THAT(write_hex_page(dump),
              HasSubstr("0x70: 00 01 15 15 -- -- -- -- 4D 48 4D 23 44 00 69 43\n"));
}

TEST(Write, IntelHex_IsAsOthersWriteIt) {
  RegisterDump dump;
  dump.at(2, 0) = 0x01;
  dump.at(2, 1) = 0x02;
  dump.at(0, 0x41) = 0x02;
  // objcopy -I binary -O ihex writes the first record so.
  EXPECT_EQ(write_intel_hex(dump), ":0200800001027B\n:0140010002BC\n:00000001FF\n");
}

TEST(Write, CArray_HoldsTheBinarysBytes) {
  RegisterDump dump;
  dump.at(3, 0) = 0x2A;
  const std::string text = write_c_array(dump, "eds", 3);
  EXPECT_THAT(text,
              HasSubstr("const unsigned char eds[64] = {\n    /* bank 3 */\n    0x2A, 0xFF,"));
  EXPECT_THAT(text, testing::EndsWith("0xFF,\n};\n"));
}

}  // namespace write_test
}  // namespace biss::dump
