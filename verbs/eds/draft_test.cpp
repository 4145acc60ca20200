#include "verbs/eds/draft.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "biss/eds/bp3_part.hpp"
#include "biss/eds/common_part.hpp"

namespace biss::verbs {
namespace draft_test {

constexpr const EdsField& bp3(std::string_view symbol) { return *find_field(bp3_fields, symbol); }
constexpr const EdsField& common(std::string_view symbol) {
  return *find_field(common_fields, symbol);
}

const EdsBank rotary_18 =
    sealed(build_bank(Bp3Part{.bp_id = 0x6214, .fi_len = 18, .sip_cnt = 64, .sip_res = 4096}));

EdsBank one_channel() {
  CommonPart part{.eds_len = 2,
                  .usr_sta = 5,
                  .usr_end = 9,
                  .tma = 100,
                  .to_max = 120,
                  .tcyc = 125,
                  .pon_dly = 250,
                  .dc_num = 1,
                  .sl_num = 1};
  part.channels[0] = {.bank = 3, .dlen = 34, .format = 0, .cpoly = 0x21};
  return sealed(build_bank(part));
}

EdsDraft rotary_draft() {
  EdsDraft draft;
  auto& part = draft.profiles[0].emplace();
  part.give(bp3("FI_LEN"), 18);
  part.give(bp3("SIP_CNT"), 64);
  part.give(bp3("SIP_RES"), 4096);
  draft.derive();
  return draft;
}

TEST(EdsDraft, ProfileAlone_GetsVersionsIdentifierAndChecksum) {
  const EdsDraft draft = rotary_draft();
  EXPECT_TRUE(draft.profiles[0]->bank == rotary_18);
  EXPECT_EQ(draft.profile_bank(0), 0U);
}

TEST(EdsDraft, CommonPart_GetsWhatItsChannelsSay) {
  constexpr std::array<std::string_view, 8> derived{"EDS_VER", "EDS_LEN", "DC_NUM",  "SL_NUM",
                                                    "BANK_0",  "DLEN_0",  "CPOLY_0", "CHKSUM"};
  EdsDraft draft;
  draft.eds_bank = 2;
  draft.common.emplace();
  for (const EdsField& field : common_fields) {
    const bool left_out = std::find(derived.begin(), derived.end(), field.symbol) != derived.end();
    if (!left_out) draft.common->give(field, field_value(one_channel(), field));
  }
  auto& part = draft.profiles[0].emplace();
  part.give(bp3("MT_LEN"), 12);
  part.give(bp3("FI_LEN"), 20);
  draft.derive();
  // All fields of the other channels are given as 0, so the device has these channels.
  draft.common->give(common("DC_NUM"), 1);
  draft.common->derive(common_fields, "CHKSUM", eds_checksum(draft.common->bank));
  EXPECT_TRUE(draft.common->bank == one_channel());
  EXPECT_EQ(draft.profile_bank(0), 3U);
  EXPECT_EQ(*draft.identifier(), 0x6222);
}

TEST(EdsDraft, GivenFields_StayAsGiven) {
  EdsDraft draft;
  draft.common.emplace().give(common("BANK_1"), 9);
  auto& part = draft.profiles[1].emplace();
  part.give(bp3("FI_LEN"), 10);
  part.give(bp3("BP_VER"), 3);
  part.give(bp3("CHKSUM"), 0);
  draft.derive();
  const CommonPart found = parse_common_part(draft.common->bank);
  EXPECT_EQ(found.dc_num, 2);
  EXPECT_EQ(found.channels[1].bank, 9);
  EXPECT_EQ(found.eds_len, 9);
  EXPECT_EQ(parse_bp3_part(draft.profiles[1]->bank).bp_ver, 3);
  EXPECT_EQ(parse_bp3_part(draft.profiles[1]->bank).chksum, 0);
  // This slave sends channel 0, which is not described.
  EXPECT_FALSE(draft.identifier().has_value());
}

TEST(EdsDraft, WrongIdentifier_IsNotRepeatedInTheRegisters) {
  EdsDraft draft;
  draft.common.emplace();
  auto& part = draft.profiles[0].emplace();
  part.give(bp3("MT_LEN"), 12);
  part.give(bp3("FI_LEN"), 16);
  part.give(bp3("BP_ID"), 0x6310);
  draft.derive();
  EXPECT_EQ(*draft.identifier(), 0x6324);
  EXPECT_EQ(parse_bp3_part(draft.profiles[0]->bank).bp_id, 0x6310);
}

}  // namespace draft_test
}  // namespace biss::verbs
