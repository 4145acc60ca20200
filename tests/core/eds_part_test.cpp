#include "biss/eds/bp3_part.hpp"
#include "biss/eds/common_part.hpp"
#include "biss/eds/image.hpp"
#include "tests/core/eds_banks.hpp"
#include "tests/core/test.hpp"

namespace biss::eds_part_test {

static_assert(parse_bp3_part(test::multiturn_12_20).mt_len == 12);

// Each row of the documents, typed a second time.
struct Row {
  std::string_view symbol;
  unsigned address;
  unsigned bytes;
  std::string_view unit;
  std::uint32_t min;
  std::uint32_t max;
};

constexpr std::uint32_t most16 = 65534;
constexpr std::uint32_t most32 = 4294967294;

// Plain arrays: g++ 12 puts a std::array without its arguments into RAM.
constexpr Row bp3_rows[] = {
    Row{"BP_VER", 0, 1, "", 1, 1},
    Row{"BP_LEN", 1, 1, "banks", 1, 1},
    Row{"BP_ID", 2, 2, "", 0x6202, 0x633F},
    Row{"FB1", 4, 1, "", 1, 1},
    Row{"FB2", 5, 1, "", 2, 2},
    Row{"PON_PDL", 6, 1, "ms", 1, 254},
    Row{"RES_07", 7, 1, "", 0, 0},
    Row{"EN_TYP", 8, 1, "", 0, 1},
    Row{"POS_NUM", 9, 1, "", 1, 2},
    Row{"MT_LEN", 10, 1, "bit", 0, 57},
    Row{"MT_FMT", 11, 1, "", 0, 1},
    Row{"CO_LEN", 12, 1, "bit", 0, 57},
    Row{"CO_FMT", 13, 1, "", 0, 1},
    Row{"FI_LEN", 14, 1, "bit", 0, 57},
    Row{"FI_FMT", 15, 1, "", 0, 1},
    Row{"MT_CNT", 16, 4, "", 1, most32},
    Row{"SIP_CNT", 20, 4, "PPR", 1, most32},
    Row{"SIP_RES", 24, 4, "LSB", 1, most32},
    Row{"CPOLY", 28, 4, "", 0x21, 0x21},
    Row{"CSTART", 32, 4, "", 0, 0},
    Row{"ABS_ACU", 36, 2, "LSB/2", 1, most16},
    Row{"REL_ACU", 38, 2, "LSB/2", 1, most16},
    Row{"SPD_ACU", 40, 2, "LSB/2", 1, most16},
    Row{"HYST", 42, 2, "LSB/2", 1, most16},
    Row{"SPD_MAX", 44, 2, "1/min", 1, most16},
    Row{"ACC_MAX", 46, 2, "1/min2", 1, most16},
    Row{"TMP_MIN", 48, 2, "K", 1, most16},
    Row{"TMP_MAX", 50, 2, "K", 1, most16},
    Row{"VLT_MIN", 52, 2, "mV", 1, most16},
    Row{"VLT_MAX", 54, 2, "mV", 1, most16},
    Row{"CUR_MAX", 56, 2, "mA", 1, most16},
    Row{"RES_3A", 58, 1, "", 0, 0},
    Row{"RES_3B", 59, 1, "", 0, 0},
    Row{"RES_3C", 60, 1, "", 0, 0},
    Row{"RES_3D", 61, 1, "", 0, 0},
    Row{"RES_3E", 62, 1, "", 0, 0},
    Row{"CHKSUM", 63, 1, "", 0, 255},
};

constexpr Row common_rows[] = {
    Row{"EDS_VER", 0x00, 1, "", 1, 255},       Row{"EDS_LEN", 0x01, 1, "banks", 1, 255},
    Row{"USR_STA", 0x02, 1, "", 0, 255},       Row{"USR_END", 0x03, 1, "", 0, 255},
    Row{"TMA", 0x04, 1, "step", 1, 255},       Row{"TO_MIN", 0x05, 1, "step", 0, 255},
    Row{"TO_MAX", 0x06, 1, "step", 0, 255},    Row{"TOS_MIN", 0x07, 1, "step", 0, 255},
    Row{"TOS_MAX", 0x08, 1, "step", 0, 255},   Row{"TCLK_MIN", 0x09, 1, "step", 0, 255},
    Row{"TCLK_MAX", 0x0A, 1, "step", 0, 255},  Row{"TCYC", 0x0B, 1, "step", 0, 255},
    Row{"TBUSY_MAX", 0x0C, 1, "step", 0, 255}, Row{"BUSY_S", 0x0D, 1, "clocks", 0, 8},
    Row{"PON_DLY", 0x0E, 2, "step", 0, 65535}, Row{"DC_NUM", 0x10, 1, "", 0, 8},
    Row{"SL_NUM", 0x11, 1, "", 1, 8},          Row{"SL_OFF", 0x12, 1, "", 0, 7},
    Row{"RES_13", 0x13, 1, "", 0, 255},        Row{"BANK_0", 0x14, 1, "", 0, 255},
    Row{"DLEN_0", 0x15, 1, "bit", 0, 64},      Row{"FORMAT_0", 0x16, 1, "", 0, 255},
    Row{"CPOLY_0", 0x17, 1, "", 0, 255},       Row{"BANK_1", 0x18, 1, "", 0, 255},
    Row{"DLEN_1", 0x19, 1, "bit", 0, 64},      Row{"FORMAT_1", 0x1A, 1, "", 0, 255},
    Row{"CPOLY_1", 0x1B, 1, "", 0, 255},       Row{"BANK_2", 0x1C, 1, "", 0, 255},
    Row{"DLEN_2", 0x1D, 1, "bit", 0, 64},      Row{"FORMAT_2", 0x1E, 1, "", 0, 255},
    Row{"CPOLY_2", 0x1F, 1, "", 0, 255},       Row{"BANK_3", 0x20, 1, "", 0, 255},
    Row{"DLEN_3", 0x21, 1, "bit", 0, 64},      Row{"FORMAT_3", 0x22, 1, "", 0, 255},
    Row{"CPOLY_3", 0x23, 1, "", 0, 255},       Row{"BANK_4", 0x24, 1, "", 0, 255},
    Row{"DLEN_4", 0x25, 1, "bit", 0, 64},      Row{"FORMAT_4", 0x26, 1, "", 0, 255},
    Row{"CPOLY_4", 0x27, 1, "", 0, 255},       Row{"BANK_5", 0x28, 1, "", 0, 255},
    Row{"DLEN_5", 0x29, 1, "bit", 0, 64},      Row{"FORMAT_5", 0x2A, 1, "", 0, 255},
    Row{"CPOLY_5", 0x2B, 1, "", 0, 255},       Row{"BANK_6", 0x2C, 1, "", 0, 255},
    Row{"DLEN_6", 0x2D, 1, "bit", 0, 64},      Row{"FORMAT_6", 0x2E, 1, "", 0, 255},
    Row{"CPOLY_6", 0x2F, 1, "", 0, 255},       Row{"BANK_7", 0x30, 1, "", 0, 255},
    Row{"DLEN_7", 0x31, 1, "bit", 0, 64},      Row{"FORMAT_7", 0x32, 1, "", 0, 255},
    Row{"CPOLY_7", 0x33, 1, "", 0, 255},       Row{"BC_OFF", 0x34, 1, "", 0, 255},
    Row{"RES_35", 0x35, 1, "", 0, 0},          Row{"RES_36", 0x36, 1, "", 0, 0},
    Row{"RES_37", 0x37, 1, "", 0, 0},          Row{"RES_38", 0x38, 1, "", 0, 0},
    Row{"RES_39", 0x39, 1, "", 0, 0},          Row{"RES_3A", 0x3A, 1, "", 0, 0},
    Row{"RES_3B", 0x3B, 1, "", 0, 0},          Row{"RES_3C", 0x3C, 1, "", 0, 0},
    Row{"RES_3D", 0x3D, 1, "", 0, 0},          Row{"RES_3E", 0x3E, 1, "", 0, 0},
    Row{"CHKSUM", 0x3F, 1, "", 0, 255},
};

void expect_rows(std::span<const EdsField> fields, std::span<const Row> rows) {
  BISS_ASSERT_EQ(fields.size(), rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const EdsField& field = fields[i];
    const Row& row = rows[i];
    BISS_EXPECT(field.symbol == row.symbol) << i;
    BISS_EXPECT_EQ(field.address, row.address) << i;
    BISS_EXPECT_EQ(field.bytes, row.bytes) << i;
    BISS_EXPECT(text_of(field.unit, false) == row.unit) << i;
    BISS_EXPECT_EQ(field.min, row.min) << i;
    BISS_EXPECT_EQ(field.max, row.max) << i;
    BISS_EXPECT(!field.meaning.empty()) << i;
    BISS_EXPECT(find_field(fields, row.symbol) == &field) << i;
  }
}

BISS_TEST(EdsTable, Bp3_IsTheDocuments) {
  expect_rows(bp3_fields, bp3_rows);
  BISS_EXPECT(find_field(bp3_fields, "mt_len") == nullptr);
}

BISS_TEST(EdsTable, Common_IsTheDriversPlusReserved) { expect_rows(common_fields, common_rows); }

BISS_TEST(EdsTable, LinearUnits_DifferWhereTheDocumentSays) {
  constexpr std::array<std::string_view, 4> symbols{"SIP_CNT", "ABS_ACU", "SPD_MAX", "ACC_MAX"};
  constexpr std::array<std::string_view, 4> units{"nm", "um", "m/min", "m/min2"};
  for (std::size_t i = 0; i < symbols.size(); ++i) {
    BISS_EXPECT(text_of(find_field(bp3_fields, symbols[i])->unit, true) == units[i]) << i;
  }
  for (const EdsField& field : bp3_fields) {
    bool listed = false;
    for (const std::string_view symbol : symbols) listed = listed || symbol == field.symbol;
    BISS_EXPECT_EQ(text_of(field.unit, true) == text_of(field.unit, false), !listed);
  }
}

BISS_TEST(EdsTable, ValuesOfTables_HaveNames) {
  BISS_EXPECT(name_of(EdsKind::feedback, 0) == "no function");
  BISS_EXPECT(name_of(EdsKind::feedback, 1) == "nE");
  BISS_EXPECT(name_of(EdsKind::feedback, 2) == "nW");
  BISS_EXPECT(name_of(EdsKind::feedback, 3).empty());
  BISS_EXPECT(name_of(EdsKind::encoder_type, 0) == "rotary");
  BISS_EXPECT(name_of(EdsKind::encoder_type, 1) == "linear");
  BISS_EXPECT(name_of(EdsKind::encoder_type, 2).empty());
  BISS_EXPECT(name_of(EdsKind::position_value, 2) == "position 2");
  BISS_EXPECT(name_of(EdsKind::alignment, 0) == "right");
  BISS_EXPECT(name_of(EdsKind::alignment, 1) == "left");
  BISS_EXPECT(name_of(EdsKind::number, 1).empty());
}

BISS_TEST(EdsPart, MultiturnBank_ParsesToItsValues) {
  const Bp3Part part = parse_bp3_part(test::multiturn_12_20);
  constexpr Bp3Part expected{.bp_ver = 1,
                             .bp_len = 1,
                             .bp_id = 0x6222,
                             .fb1 = 1,
                             .fb2 = 2,
                             .pon_pdl = 100,
                             .reserved_07 = 0,
                             .en_typ = 0,
                             .pos_num = 1,
                             .mt_len = 12,
                             .mt_fmt = 0,
                             .co_len = 6,
                             .co_fmt = 1,
                             .fi_len = 14,
                             .fi_fmt = 1,
                             .mt_cnt = 4096,
                             .sip_cnt = 64,
                             .sip_res = 16384,
                             .cpoly = 0x21,
                             .cstart = 0,
                             .abs_acu = 40,
                             .rel_acu = 4,
                             .spd_acu = 12,
                             .hyst = 2,
                             .spd_max = 12000,
                             .acc_max = 60000,
                             .tmp_min = 233,
                             .tmp_max = 393,
                             .vlt_min = 4500,
                             .vlt_max = 5500,
                             .cur_max = 120,
                             .reserved_3a = {},
                             .chksum = 0x74};
  BISS_EXPECT(part == expected);
  BISS_EXPECT_EQ(part.position_bits(), 32);
  BISS_EXPECT(!part.linear());
}

BISS_TEST(EdsPart, OtherBp3Banks_ParseToTheirValues) {
  const Bp3Part rotary = parse_bp3_part(test::rotary_18);
  BISS_EXPECT_EQ(rotary.bp_id, 0x6214);
  BISS_EXPECT_EQ(rotary.position_bits(), 18);
  BISS_EXPECT_EQ(rotary.sip_cnt, 64U);
  BISS_EXPECT_EQ(rotary.sip_res, 4096U);
  BISS_EXPECT_EQ(rotary.chksum, 0xFF);
  const Bp3Part odd = parse_bp3_part(test::multiturn_odd);
  BISS_EXPECT_EQ(odd.mt_cnt, 1000U);
  BISS_EXPECT_EQ(odd.sip_cnt, 3600U);
  BISS_EXPECT_EQ(odd.pos_num, 2);
  BISS_EXPECT_EQ(odd.abs_acu, 0xFFFF);
  BISS_EXPECT_EQ(odd.tmp_max, 358);
  const Bp3Part linear = parse_bp3_part(test::linear_36);
  BISS_EXPECT(linear.linear());
  BISS_EXPECT_EQ(linear.mt_cnt, 2500000U);
  BISS_EXPECT_EQ(linear.sip_cnt, 20000U);
  BISS_EXPECT_EQ(linear.co_len, 22);
  BISS_EXPECT_EQ(linear.cur_max, 250);
  const Bp3Part one_run = parse_bp3_part(test::linear_26);
  BISS_EXPECT_EQ(one_run.fi_len, 26);
  BISS_EXPECT_EQ(one_run.sip_res, 400U);
  const Bp3Part longest = parse_bp3_part(test::longest_55);
  BISS_EXPECT_EQ(longest.position_bits(), 55);
  BISS_EXPECT_EQ(longest.mt_cnt, 16777216U);
  BISS_EXPECT_EQ(longest.vlt_max, 30000);
  BISS_EXPECT_EQ(longest.cur_max, 65534);
  const Bp3Part safety = parse_bp3_part(test::safety_cpw);
  BISS_EXPECT_EQ(safety.bp_id, 0x6324);
  BISS_EXPECT_EQ(safety.tmp_min, 248);
}

BISS_TEST(EdsPart, CommonBanks_ParseToTheirValues) {
  constexpr CommonPart expected{.eds_ver = 1,
                                .eds_len = 2,
                                .usr_sta = 5,
                                .usr_end = 9,
                                .tma = 100,
                                .to_min = 60,
                                .to_max = 120,
                                .tos_min = 20,
                                .tos_max = 40,
                                .tclk_min = 10,
                                .tclk_max = 20,
                                .tcyc = 125,
                                .tbusy_max = 64,
                                .busy_s = 3,
                                .pon_dly = 250,
                                .dc_num = 1,
                                .sl_num = 1,
                                .sl_off = 0,
                                .unnamed_13 = 0,
                                .channels = {{{3, 34, 0, 0x21}}},
                                .bc_off = 0,
                                .reserved_35 = {},
                                .chksum = 0x85};
  BISS_EXPECT(parse_common_part(test::one_channel) == expected);
  const CommonPart slow = parse_common_part(test::slow_coupler);
  BISS_EXPECT_EQ(slow.tma, 250);
  BISS_EXPECT_EQ(slow.channels[1].bank, 0x82);
  BISS_EXPECT(slow.channels[1].left_aligned() && !slow.channels[0].left_aligned());
  BISS_EXPECT(slow.channels[2].leading_stop_bit() && !slow.channels[2].actuator());
  BISS_EXPECT(slow.has_bus_coupler());
  BISS_EXPECT_EQ(slow.bus_coupler_slave(), 1);
  BISS_EXPECT_EQ(slow.first_slave(5), 3);
  const CommonPart two = parse_common_part(test::two_channels);
  BISS_EXPECT_EQ(two.dc_num, 2);
  BISS_EXPECT(two.channels[0] == CommonChannel({6, 42, 0, 0}));
  BISS_EXPECT(two.channels[1] == CommonChannel({5, 30, 0, 0x21}));
}

// A member of a part, and the symbol of its field.
struct Member {
  std::string_view symbol;
  std::uint32_t value;
};

BISS_TEST(EdsPart, AnyBytes_MembersAreTheFieldsOfTheTable) {
  BISS_RANDOM(random, 0xED5);
  for (std::uint64_t round = test::rounds(20'000, 100); round-- > 0;) {
    EdsBank bank{};
    for (std::uint8_t& byte : bank) byte = static_cast<std::uint8_t>(random.bits(8));
    const Bp3Part bp3 = parse_bp3_part(bank);
    const Member of_bp3[] = {
        {"BP_VER", bp3.bp_ver},   {"BP_LEN", bp3.bp_len},   {"BP_ID", bp3.bp_id},
        {"FB1", bp3.fb1},         {"FB2", bp3.fb2},         {"PON_PDL", bp3.pon_pdl},
        {"EN_TYP", bp3.en_typ},   {"POS_NUM", bp3.pos_num}, {"MT_LEN", bp3.mt_len},
        {"MT_FMT", bp3.mt_fmt},   {"CO_LEN", bp3.co_len},   {"CO_FMT", bp3.co_fmt},
        {"FI_LEN", bp3.fi_len},   {"FI_FMT", bp3.fi_fmt},   {"MT_CNT", bp3.mt_cnt},
        {"SIP_CNT", bp3.sip_cnt}, {"SIP_RES", bp3.sip_res}, {"CPOLY", bp3.cpoly},
        {"CSTART", bp3.cstart},   {"ABS_ACU", bp3.abs_acu}, {"REL_ACU", bp3.rel_acu},
        {"SPD_ACU", bp3.spd_acu}, {"HYST", bp3.hyst},       {"SPD_MAX", bp3.spd_max},
        {"ACC_MAX", bp3.acc_max}, {"TMP_MIN", bp3.tmp_min}, {"TMP_MAX", bp3.tmp_max},
        {"VLT_MIN", bp3.vlt_min}, {"VLT_MAX", bp3.vlt_max}, {"CUR_MAX", bp3.cur_max},
        {"CHKSUM", bp3.chksum}};
    for (const Member& member : of_bp3) {
      BISS_ASSERT_EQ(member.value, field_value(bank, *find_field(bp3_fields, member.symbol)));
    }
    const CommonPart common = parse_common_part(bank);
    const Member of_common[] = {
        {"EDS_VER", common.eds_ver},     {"EDS_LEN", common.eds_len},   {"USR_STA", common.usr_sta},
        {"USR_END", common.usr_end},     {"TMA", common.tma},           {"TO_MIN", common.to_min},
        {"TO_MAX", common.to_max},       {"TOS_MIN", common.tos_min},   {"TOS_MAX", common.tos_max},
        {"TCLK_MIN", common.tclk_min},   {"TCLK_MAX", common.tclk_max}, {"TCYC", common.tcyc},
        {"TBUSY_MAX", common.tbusy_max}, {"BUSY_S", common.busy_s},     {"PON_DLY", common.pon_dly},
        {"DC_NUM", common.dc_num},       {"SL_NUM", common.sl_num},     {"SL_OFF", common.sl_off},
        {"BC_OFF", common.bc_off},       {"CHKSUM", common.chksum}};
    for (const Member& member : of_common) {
      BISS_ASSERT_EQ(member.value, field_value(bank, *find_field(common_fields, member.symbol)));
    }
    for (std::size_t k = 0; k < max_channels; ++k) {
      const std::uint8_t* const at = bank.data() + common_channel_address(k);
      BISS_ASSERT(common.channels[k] == CommonChannel({at[0], at[1], at[2], at[3]}));
    }
  }
}

BISS_TEST(EdsField, SetAndGet_AreInverseAndTouchNothingElse) {
  BISS_RANDOM(random, 0xF1E1D);
  for (const EdsPart part : {EdsPart::common, EdsPart::bp3}) {
    for (const EdsField& field : fields_of(part)) {
      EdsBank bank{};
      for (std::uint8_t& byte : bank) byte = static_cast<std::uint8_t>(random.bits(8));
      const EdsBank before = bank;
      const auto value = static_cast<std::uint32_t>(random.bits(8U * field.bytes));
      BISS_ASSERT(set_field(bank, field, value));
      BISS_EXPECT_EQ(field_value(bank, field), value);
      BISS_EXPECT_EQ(bank[field.address], value >> (8U * (field.bytes - 1U)));
      for (std::size_t i = 0; i < bank.size(); ++i) {
        if (i >= field.address && i < field.address + std::size_t{field.bytes}) continue;
        BISS_EXPECT_EQ(bank[i], before[i]);
      }
      if (field.bytes == 4) continue;
      const EdsBank kept = bank;
      BISS_EXPECT(!set_field(bank, field, field.all_ones() + 1));
      BISS_EXPECT(bank == kept);
    }
  }
  BISS_EXPECT(fields_of(EdsPart::raw).empty());
}

BISS_TEST(EdsBank, Checksum_IsTheSumOfTheBytesBefore) {
  for (const EdsBank* bank : {&test::rotary_18, &test::linear_36, &test::one_channel}) {
    BISS_EXPECT_EQ(eds_checksum(*bank), (*bank)[63]);
  }
  EdsBank ones{};
  ones.fill(0xFF);
  BISS_EXPECT_EQ(eds_checksum(ones), (63 * 255) & 0xFF);
  BISS_EXPECT_EQ(sealed(ones)[63], 0xC1);
  BISS_EXPECT(is_filled_with(ones, 0xFF) && !is_filled_with(sealed(ones), 0xFF));
}

BISS_TEST(EdsScale, OnlyTheClockAndBusyS_AreSourced) {
  BISS_EXPECT_EQ(eds_scales.size(), 10U);
  for (const EdsScale& scale : eds_scales) {
    BISS_EXPECT(find_field(common_fields, scale.symbol) != nullptr);
    BISS_EXPECT_EQ(scale.hypothesis, scale.symbol != "TMA");
  }
  for (const EdsField& field : common_fields) {
    BISS_EXPECT_EQ(find_scale(field.symbol) != nullptr, field.unit == EdsUnit::time_step);
  }
  BISS_EXPECT(eds_time("TMA", 100) == nanoseconds(100));
  BISS_EXPECT(eds_time("TO_MAX", 80) == microseconds(20));
  BISS_EXPECT(eds_time("TOS_MIN", 40) == microseconds(1));
  BISS_EXPECT(eds_time("TCLK_MAX", 20) == nanoseconds(20));
  BISS_EXPECT(eds_time("TCYC", 125) == nanoseconds(31250));
  BISS_EXPECT(eds_time("PON_DLY", 250) == milliseconds(250));
}

}  // namespace biss::eds_part_test
