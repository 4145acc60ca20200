#include "verbs/eds/description.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <sstream>

#include "biss/eds/check.hpp"
#include "dump/data_sheet.hpp"

namespace biss::verbs {
namespace description_test {

using dump::DataSheet;
using dump::RegisterDump;
using testing::HasSubstr;

tl::expected<RegisterDump, std::string> read(const std::string& text) {
  std::istringstream stream(text);
  return read_description(stream, {}).map([](const Description& read) { return read.dump; });
}

RegisterDump good(const std::string& text) {
  const auto described = read(text);
  if (described) return *described;
  ADD_FAILURE() << described.error();
  return {};
}

unsigned findings(const RegisterDump& dump) {
  unsigned count = 0;
  const DataSheet sheet = find_data_sheet(dump, {});
  EXPECT_FALSE(sheet.empty());
  check_eds(sheet.image(), [&](const EdsFinding&) { ++count; });
  return count;
}

const char* const shortest = "[common]\nTMA = 100ns\n[bp3]\nPON_PDL = 10ms\nFI_LEN = 24\n";

TEST(Description, WhatFollowsFromTheRest_IsFilledIn) {
  const RegisterDump dump = good(shortest);
  EXPECT_EQ(findings(dump), 0U);
  EXPECT_EQ(dump.direct_byte(0x41), 1);
  EXPECT_EQ(dump.direct_number(0x42, 2), 0x621AU);
  const CommonPart common = parse_common_part(*dump.whole_bank(1));
  EXPECT_EQ(common.eds_len, 2);
  EXPECT_EQ(common.dc_num, 1);
  EXPECT_EQ(common.channels[0].bank, 2);
  EXPECT_EQ(common.channels[0].dlen, 26);
  EXPECT_EQ(common.channels[0].cpoly, 0x21);
  const Bp3Part part = parse_bp3_part(*dump.whole_bank(2));
  EXPECT_EQ(part.bp_id, 0x621A);
  EXPECT_EQ(part.cpoly, 0x21U);
}

TEST(Description, TwoChannels_StandInTheBanksBehindTheCommonPart) {
  const RegisterDump dump = good(
      "[registers]\nEDS_BANK = 4\n[bp3 1]\nPON_PDL=1\nFI_LEN = 20\n[common]\nTMA=100\n"
      "SL_NUM=2\n[bp3]\nPON_PDL=1\nFI_LEN = 30\n");
  EXPECT_EQ(findings(dump), 0U);
  EXPECT_EQ(parse_bp3_part(*dump.whole_bank(5)).fi_len, 30);
  EXPECT_EQ(parse_bp3_part(*dump.whole_bank(6)).fi_len, 20);
  EXPECT_EQ(parse_common_part(*dump.whole_bank(4)).eds_len, 3);
}

TEST(Description, GivenValues_StayAsGiven) {
  const RegisterDump dump = good(std::string(shortest) + "CHKSUM = 0x00\nBP_ID = 0x6210\n");
  EXPECT_EQ(parse_bp3_part(*dump.whole_bank(2)).chksum, 0);
  EXPECT_GE(findings(dump), 2U);
}

TEST(Description, ProfileAlone_IsABankOfItsOwn) {
  const RegisterDump dump = good("[bp3]\nPON_PDL = 1\nFI_LEN = 10\n");
  EXPECT_EQ(dump.banks()->first, 0U);
  EXPECT_EQ(dump.direct(), dump::DumpedBytes{});
  EXPECT_EQ(findings(dump), 0U);
}

TEST(Description, RegistersAndBanks_TakeBytes) {
  const RegisterDump dump =
      good("[registers]\n0x48 = 01 -- FF\nMFR_ID = 0x6943\n[bank 7]\n0x3E = AA BB # end\n");
  EXPECT_EQ(dump.direct_byte(0x48), 0x01);
  EXPECT_EQ(dump.direct_byte(0x49), std::nullopt);
  EXPECT_EQ(dump.direct_byte(0x4A), 0xFF);
  EXPECT_EQ(dump.direct_number(0x7E, 2), 0x6943U);
  EXPECT_EQ(dump.bank(7)[0x3F], 0xBB);
}

TEST(Description, Mistakes_NameTheirLine) {
  const auto error = [](const std::string& text) {
    const auto described = read(text);
    return described ? std::string() : described.error();
  };
  EXPECT_EQ(error("[bp3]\nMT_LEN = 12\nMT_LEM = 3\n"),
            "line 3: this part has no 'MT_LEM'; did you mean MT_LEN?");
  EXPECT_EQ(error("[bp3]\nMT_LEN = 12\nMT_LEN = 3\n"), "line 3: MT_LEN was given in line 2");
  EXPECT_EQ(error("[bp3]\nMT_LEN = twelve\n"),
            "line 2: MT_LEN = twelve: a number, decimal or 0x...");
  EXPECT_EQ(error("MT_LEN = 12\n"), "line 1: expected a section such as [common] first");
  EXPECT_EQ(error("[bp3]\n\nMT_LEN\n"), "line 3: expected SYMBOL = value");
  EXPECT_EQ(error("[bp3]\nMT_LEN =\n"), "line 2: MT_LEN has no value");
  EXPECT_THAT(error("[bp4]\n"), HasSubstr("line 1: a section is [registers], [common]"));
  EXPECT_THAT(error("[bp3 8]\n"), HasSubstr("line 1: a section is"));
  EXPECT_THAT(error("[bank]\n"), HasSubstr("line 1: a section is"));
  EXPECT_THAT(error("[common 1]\n"), HasSubstr("line 1: a section is"));
  EXPECT_THAT(error("[registers]\n0x3F = 00\n"),
              HasSubstr("line 2: '0x3F' is not a register here"));
  EXPECT_THAT(error("[registers]\nDEV_IX = 0\n"),
              HasSubstr("0x40 to 0x7F, BSEL, EDS_BANK, BP_ID, DEV_SN, DEV_ID, MFR_ID"));
  EXPECT_THAT(error("[registers]\n0x7F = 00 01\n"), HasSubstr("bytes beyond 0x7F"));
  EXPECT_THAT(error("[registers]\nMFR_ID = 0x10000\n"), HasSubstr("a number of at most 2 bytes"));
  EXPECT_THAT(error("[registers]\nMFR_ID = 1\n0x7F = 02\n"), HasSubstr("line 3: register 0x7F"));
  EXPECT_THAT(error("[bank 1]\n0x00 = 0 1\n"), HasSubstr("'0': expected bytes"));
  EXPECT_THAT(error("[bank 1]\n0x00 = 01\n[common]\nTMA = 100\n"),
              HasSubstr("[common] belongs in bank 1, which is given otherwise"));
  EXPECT_THAT(error("[common]\nTMA = 100\nBANK_0 = 1\n[bp3]\nFI_LEN=9\n"),
              HasSubstr("[bp3 0] belongs in bank 1"));
}

TEST(Description, OnlyTextWithASection_LooksLikeOne) {
  EXPECT_TRUE(looks_like_description("# x\n\n [common] # y\n"));
  EXPECT_FALSE(looks_like_description("{\"id\":0}\n"));
  EXPECT_FALSE(looks_like_description("[1,2]"));
  EXPECT_FALSE(looks_like_description("0x00: 01\n"));
  EXPECT_FALSE(looks_like_description(""));
}

// Any content of a dump whose registers point to its data sheet, right or wrong.
TEST(Description, OfAnyDump_BuildsTheSameDump) {
  constexpr unsigned seed = 31;
  std::mt19937 random(seed);
  for (int i = 0; i < 2000; ++i) {
    RegisterDump dump = good(shortest);
    const auto changes = static_cast<unsigned>(random() % 6);
    for (unsigned k = 0; k < changes; ++k) {
      const auto bank = static_cast<unsigned>(random() % 4);
      const auto address = static_cast<unsigned>(random() % 0x80);
      if (address == 0x41 || address == 0x42 || address == 0x43) continue;
      dump.at(bank, address) =
          random() % 9 == 0 ? std::optional<std::uint8_t>() : static_cast<std::uint8_t>(random());
    }
    const std::string text = write_description(dump, find_data_sheet(dump, {}));
    ASSERT_EQ(good(text), dump) << "seed " << seed << ", dump " << i << "\n" << text;
  }
}

TEST(Description, DamagedText_IsRefusedOrRead) {
  constexpr unsigned seed = 32;
  constexpr std::string_view alphabet = "[]=#x0A \n?";
  std::mt19937 random(seed);
  const std::string text = write_description(good(shortest), find_data_sheet(good(shortest), {}));
  unsigned refused = 0;
  for (int i = 0; i < 2000; ++i) {
    std::string damaged = text;
    for (int k = 0; k < 3; ++k) {
      damaged[random() % damaged.size()] = alphabet[random() % alphabet.size()];
    }
    if (!read(damaged)) ++refused;
  }
  EXPECT_GT(refused, 500U);
  EXPECT_LT(refused, 1990U);
}

TEST(Description, CommonPartElsewhereThanTheRegisterSays_IsWrittenAsBytes) {
  RegisterDump dump = good(shortest);
  for (const std::uint8_t stated : {std::uint8_t{0}, std::uint8_t{9}}) {
    dump.at(0, 0x41) = stated;
    const std::string text = write_description(dump, find_data_sheet(dump, {.eds_bank = 1}));
    EXPECT_EQ(good(text), dump) << text;
  }
}

}  // namespace description_test
}  // namespace biss::verbs
