#include "dump/data_sheet.hpp"

#include <gtest/gtest.h>

#include "biss/eds/check.hpp"
#include "biss/eds/common_part.hpp"
#include "dump/test_dumps.hpp"

namespace biss::dump {
namespace data_sheet_test {

// Common part in bank 2, one BP3 part in bank 3.
RegisterDump device() {
  CommonPart common;
  common.eds_len = 2;
  common.tma = 100;
  common.dc_num = 1;
  common.sl_num = 1;
  common.channels[0] = {.bank = 3, .dlen = 30, .format = 0, .cpoly = 0x21};
  Bp3Part part;
  part.bp_id = 0x621E;
  part.pon_pdl = 10;
  part.mt_len = 12;
  part.fi_len = 16;
  RegisterDump dump;
  dump.set_bank(2, sealed(build_bank(common)));
  dump.set_bank(3, sealed(build_bank(part)));
  return dump;
}

unsigned findings(const DataSheet& sheet) {
  unsigned count = 0;
  check_eds(sheet.image(), [&](const EdsFinding&) { ++count; });
  return count;
}

TEST(DataSheet, RegisterNamesTheBank_PartsAreFound) {
  RegisterDump dump = device();
  dump.at(0, 0x41) = 2;
  dump.at(0, 0x42) = 0x62;
  dump.at(0, 0x43) = 0x1E;
  const DataSheet sheet = find_data_sheet(dump, {});
  ASSERT_TRUE(sheet.common && sheet.profiles[0]);
  EXPECT_EQ(sheet.eds_bank, 2);
  EXPECT_EQ(sheet.profiles[0]->bank, 3);
  EXPECT_EQ(sheet.identifiers[0], 0x621E);
  EXPECT_EQ(findings(sheet), 0U);
}

TEST(DataSheet, BinaryWithoutRegisters_IsSearched) {
  RegisterDump dump = device();
  dump.set_bank(0, {});
  dump.set_bank(1, EdsBank{1, 2, 3});  // no checksum
  EXPECT_EQ(find_data_sheet(dump, {}).eds_bank, 2);
}

TEST(DataSheet, RegisterSaysNone_NothingIsFoundUnlessTheBankIsNamed) {
  RegisterDump dump = device();
  dump.at(0, 0x41) = 0;
  EXPECT_TRUE(find_data_sheet(dump, {}).empty());
  EXPECT_EQ(find_data_sheet(dump, {.eds_bank = 2}).eds_bank, 2);
  dump.at(0, 0x41) = 0xFF;  // iC-MU: none; a bank only where its checksum is right
  EXPECT_TRUE(find_data_sheet(dump, {}).empty());
  dump.set_bank(0xFF, *dump.whole_bank(2));
  EXPECT_EQ(find_data_sheet(dump, {}).eds_bank, 0xFF);
}

TEST(DataSheet, LoneBank_IsToldByItsBeginning) {
  RegisterDump dump;
  dump.set_bank(0, *device().whole_bank(3));
  dump.at(0, 0x3F) = 0x00;  // a wrong checksum is for the check to find
  const DataSheet sheet = find_data_sheet(dump, {});
  EXPECT_FALSE(sheet.common.has_value());
  ASSERT_TRUE(sheet.profiles[0].has_value());
  EXPECT_EQ(findings(sheet), 1U);
  dump.set_bank(0, *device().whole_bank(2));
  EXPECT_TRUE(find_data_sheet(dump, {}).common.has_value());
}

TEST(DataSheet, BankWithHoles_IsFoundButNotJudged) {
  RegisterDump dump = device();
  dump.at(0, 0x41) = 2;
  dump.at(3, 0x20) = std::nullopt;
  const DataSheet sheet = find_data_sheet(dump, {});
  ASSERT_TRUE(sheet.profiles[0].has_value());
  EXPECT_FALSE(sheet.profiles[0]->whole);
  EXPECT_EQ(sheet.image().profiles[0], nullptr);
}

TEST(DataSheet, SecondSlave_GivesTheSecondChannelItsIdentifier) {
  RegisterDump dump = device();
  CommonPart common = parse_common_part(*dump.whole_bank(2));
  common.sl_num = 2;
  common.sl_off = 1;
  common.dc_num = 2;
  common.channels[1] = common.channels[0];
  dump.set_bank(2, sealed(build_bank(common)));
  const DataSheet sheet = find_data_sheet(dump, {.eds_bank = 2, .identifier = 0x6210});
  EXPECT_EQ(sheet.identifiers[0], std::nullopt);
  EXPECT_EQ(sheet.identifiers[1], 0x6210);
}

}  // namespace data_sheet_test
}  // namespace biss::dump
