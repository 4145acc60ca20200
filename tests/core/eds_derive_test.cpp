#include "biss/eds/derive.hpp"

#include "tests/core/eds_banks.hpp"
#include "tests/core/test.hpp"

namespace biss::eds_derive_test {

constexpr const EdsField& bp3(std::string_view symbol) { return *find_field(bp3_fields, symbol); }
constexpr const EdsField& common(std::string_view symbol) {
  return *find_field(common_fields, symbol);
}

constexpr EdsDraft rotary_draft() {
  EdsDraft draft;
  auto& part = draft.profiles[0].emplace();
  part.give(bp3("FI_LEN"), 18);
  part.give(bp3("SIP_CNT"), 64);
  part.give(bp3("SIP_RES"), 4096);
  derive_eds(draft);
  return draft;
}
static_assert(rotary_draft().profiles[0]->bank == test::rotary_18);

BISS_TEST(EdsDerive, ProfileAlone_GetsVersionsIdentifierAndChecksum) {
  const EdsDraft draft = rotary_draft();
  BISS_EXPECT(draft.profiles[0]->bank == test::rotary_18);
  BISS_EXPECT_EQ(draft.profile_bank(0), 0U);
}

BISS_TEST(EdsDerive, CommonPart_GetsWhatItsChannelsSay) {
  constexpr std::array<std::string_view, 8> derived{"EDS_VER", "EDS_LEN", "DC_NUM",  "SL_NUM",
                                                    "BANK_0",  "DLEN_0",  "CPOLY_0", "CHKSUM"};
  EdsDraft draft;
  draft.eds_bank = 2;
  draft.common.emplace();
  for (const EdsField& field : common_fields) {
    const bool left_out = std::find(derived.begin(), derived.end(), field.symbol) != derived.end();
    if (!left_out) draft.common->give(field, field_value(test::one_channel, field));
  }
  auto& part = draft.profiles[0].emplace();
  part.give(bp3("MT_LEN"), 12);
  part.give(bp3("FI_LEN"), 20);
  derive_eds(draft);
  // All fields of the other channels are given as 0, so the device has these channels.
  draft.common->give(common("DC_NUM"), 1);
  draft.common->derive(common("CHKSUM"), eds_checksum(draft.common->bank));
  BISS_EXPECT(draft.common->bank == test::one_channel);
  BISS_EXPECT_EQ(draft.profile_bank(0), 3U);
  BISS_EXPECT_EQ(*derived_identifier(draft), 0x6222);
}

BISS_TEST(EdsDerive, GivenFields_StayAsGiven) {
  EdsDraft draft;
  draft.common.emplace().give(common("BANK_1"), 9);
  auto& part = draft.profiles[1].emplace();
  part.give(bp3("FI_LEN"), 10);
  part.give(bp3("BP_VER"), 3);
  part.give(bp3("CHKSUM"), 0);
  derive_eds(draft);
  const CommonPart found = parse_common_part(draft.common->bank);
  BISS_EXPECT_EQ(found.dc_num, 2);
  BISS_EXPECT_EQ(found.channels[1].bank, 9);
  BISS_EXPECT_EQ(found.eds_len, 9);
  BISS_EXPECT_EQ(parse_bp3_part(draft.profiles[1]->bank).bp_ver, 3);
  BISS_EXPECT_EQ(parse_bp3_part(draft.profiles[1]->bank).chksum, 0);
  // This slave sends channel 0, which is not described.
  BISS_EXPECT(!derived_identifier(draft).has_value());
}

BISS_TEST(EdsDerive, WrongIdentifier_IsNotRepeatedInTheRegisters) {
  EdsDraft draft;
  draft.common.emplace();
  auto& part = draft.profiles[0].emplace();
  part.give(bp3("MT_LEN"), 12);
  part.give(bp3("FI_LEN"), 16);
  part.give(bp3("BP_ID"), 0x6310);
  derive_eds(draft);
  BISS_EXPECT_EQ(*derived_identifier(draft), 0x6324);
  BISS_EXPECT_EQ(parse_bp3_part(draft.profiles[0]->bank).bp_id, 0x6310);
}

}  // namespace biss::eds_derive_test
