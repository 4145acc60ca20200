#include "biss/eds/check.hpp"

#include <initializer_list>

#include "tests/core/eds_banks.hpp"
#include "tests/core/test.hpp"

namespace biss::eds_check_test {

constexpr std::array good_bp3{&test::rotary_18,  &test::multiturn_12_20, &test::multiturn_odd,
                              &test::linear_36,  &test::linear_26,       &test::longest_55,
                              &test::safety_cpw, &test::shortest_0};
constexpr std::array good_common{&test::one_channel, &test::two_channels, &test::slow_coupler};

// The first findings of one check.
struct Findings {
  std::array<EdsFinding, 16> list{};
  std::size_t count = 0;

  void operator()(const EdsFinding& finding) {
    if (count < list.size()) list[count] = finding;
    ++count;
  }
  bool has(std::string_view symbol, EdsProblem problem) const {
    for (std::size_t i = 0; i < count && i < list.size(); ++i) {
      if (list[i].symbol == symbol && list[i].problem == problem) return true;
    }
    return false;
  }
  bool only(std::string_view symbol, EdsProblem problem, std::uint32_t value) const {
    return count == 1 && list[0].symbol == symbol && list[0].problem == problem &&
           list[0].value == value;
  }
};

Findings check_of(EdsPart part, const EdsBank& bank, const EdsCheckOptions& options = {}) {
  Findings findings;
  if (part == EdsPart::common) {
    check_common_part(bank, findings, std::nullopt, options);
  } else {
    check_bp3_part(bank, findings, {}, options);
  }
  return findings;
}

EdsBank with(const EdsBank& bank, EdsPart part, std::string_view symbol, std::uint32_t value) {
  EdsBank changed = bank;
  const EdsField* field = find_field(fields_of(part), symbol);
  BISS_EXPECT(field != nullptr && set_field(changed, *field, value));
  return sealed(changed);
}

// Checking in a constant expression shows that it needs only the bytes.
constexpr unsigned count_findings(const EdsBank& bank) {
  unsigned count = 0;
  check_bp3_part(bank, [&](const EdsFinding&) { ++count; });
  return count;
}
static_assert(count_findings(test::multiturn_12_20) == 0);
static_assert(count_findings(EdsBank{}) == 1);

BISS_TEST(EdsCheck, GoodBanks_GiveNoFinding) {
  for (const EdsBank* bank : good_bp3) BISS_EXPECT_EQ(check_of(EdsPart::bp3, *bank).count, 0U);
  for (const EdsBank* bank : good_common) {
    BISS_EXPECT_EQ(check_of(EdsPart::common, *bank).count, 0U);
  }
}

struct Wrong {
  const EdsBank* bank;
  EdsPart part;
  std::string_view symbol;
  std::uint32_t value;
  EdsProblem problem;
};

// SIP_RES fills FI_LEN. Its bytes in the other order would make room for a second period.
BISS_TEST(EdsCheck, SecondPeriodOfAResolutionThatFillsItsLength_IsNoByteOrder) {
  for (const std::uint32_t count : {2U, 3U, 16U, 128U}) {
    const Bp3Part part{.bp_id = 0x6220,
                       .mt_len = 12,
                       .fi_len = 18,
                       .mt_cnt = 4096,
                       .sip_cnt = count,
                       .sip_res = 262'144};
    EdsFinding found;
    unsigned findings = 0;
    check_bp3_part(sealed(build_bank(part)), [&](const EdsFinding& each) {
      found = each;
      ++findings;
    });
    BISS_EXPECT_EQ(findings, 1U);
    BISS_EXPECT(found.problem == EdsProblem::count_above_length) << "count " << count;
    BISS_EXPECT(found.symbol == "SIP_CNT" && found.value == count);
    BISS_EXPECT(found.against == "SIP_RES" && found.expected == 262'144);
  }
}

// 2^16 to 2^23 are powers of two in both byte orders.
BISS_TEST(EdsCheck, PowersOfTwoThatAreTooLarge_AreNoByteOrderUnlessThatFillsTheLength) {
  const Bp3Part good{.bp_id = 0x6220,
                     .mt_len = 12,
                     .fi_len = 18,
                     .mt_cnt = 4096,
                     .sip_cnt = 1,
                     .sip_res = 262'144};
  for (const std::string_view symbol : {"MT_CNT", "SIP_CNT", "SIP_RES"}) {
    for (unsigned bits = symbol == "MT_CNT"    ? 13
                         : symbol == "SIP_CNT" ? 1
                                               : 19;
         bits < 32; ++bits) {
      const bool fills = (symbol == "MT_CNT" && bits == 20) || (symbol == "SIP_CNT" && bits == 24);
      const std::uint32_t count = std::uint32_t{1} << bits;
      const Findings found =
          check_of(EdsPart::bp3, with(build_bank(good), EdsPart::bp3, symbol, count));
      BISS_EXPECT(found.only(
          symbol, fills ? EdsProblem::little_endian : EdsProblem::count_above_length, count))
          << symbol.data() << " 2^" << bits;
    }
  }
}

// Their sums do not fit alone, and the other order fills the length.
BISS_TEST(EdsCheck, ScaleWithAllBytesInTheOtherOrder_IsNamedByItsPolynomial) {
  EdsBank bank = test::linear_36;
  for (const std::string_view symbol : {"BP_ID", "MT_CNT", "SIP_RES", "CPOLY"}) {
    const EdsField& field = *find_field(bp3_fields, symbol);
    BISS_ASSERT(set_field(bank, field, bytes_swapped(field_value(bank, field), field.bytes)));
  }
  const Findings found = check_of(EdsPart::bp3, bank);
  BISS_EXPECT(found.has("MT_CNT", EdsProblem::little_endian));
  BISS_EXPECT(found.has("SIP_RES", EdsProblem::little_endian));
}

BISS_TEST(EdsCheck, TimesThatAreNotUsed_AreFound) {
  struct Time {
    std::string_view symbol;
    std::uint32_t last_good;
    std::uint32_t first_bad;
  };
  for (const Time& each : {Time{"TBUSY_MAX", 160, 161}, Time{"TO_MAX", 160, 161},
                           Time{"TMA", 100, 99}, Time{"TMA", 255, 1}}) {
    const auto check = [&](std::uint32_t value) {
      return check_of(EdsPart::common,
                      with(test::one_channel, EdsPart::common, each.symbol, value));
    };
    BISS_EXPECT_EQ(check(each.last_good).count, 0U) << each.symbol.data();
    const Findings found = check(each.first_bad);
    BISS_EXPECT(found.only(each.symbol, EdsProblem::out_of_range, each.first_bad))
        << each.symbol.data();
    BISS_EXPECT(!contradicts(found.list[0]));
  }
  const EdsBank absent = with(test::one_channel, EdsPart::common, "TBUSY_MAX", 255);
  BISS_EXPECT_EQ(check_of(EdsPart::common, absent).count, 0U);
}

bool any_contradicts(const Bp3Part& part) {
  const Findings found = check_of(EdsPart::bp3, sealed(build_bank(part)));
  bool any = false;
  for (std::size_t i = 0; i < found.count && i < found.list.size(); ++i) {
    any = any || contradicts(found.list[i]);
  }
  return any;
}

// A length that the profile does not allow, zeros between the fields, and no error bit: none of
// them has a format that can be right.
BISS_TEST(EdsCheck, PartsWithoutARightFormat_Contradict) {
  const Bp3Part good{.bp_id = 0x6220, .mt_len = 12, .fi_len = 18, .sip_cnt = 1, .sip_res = 262'144};
  BISS_EXPECT(!any_contradicts(good));
  for (std::uint8_t bits = 26; bits < 32; ++bits) {
    Bp3Part part = good;
    part.co_len = bits;
    part.bp_id = static_cast<std::uint16_t>(0x6220 + bits);
    BISS_EXPECT(any_contradicts(part)) << +bits;
  }
  Bp3Part zeros = good;
  zeros.bp_id = 0x6232;
  zeros.co_len = 18;
  zeros.co_fmt = 1;
  BISS_EXPECT(any_contradicts(zeros));
  zeros.fi_fmt = 1;
  BISS_EXPECT(!any_contradicts(zeros));
  zeros.co_fmt = zeros.fi_fmt = 0;
  BISS_EXPECT(!any_contradicts(zeros));  // leading zeros are padding
  Bp3Part scale{.bp_id = 0x6220, .en_typ = 1, .mt_len = 14, .mt_fmt = 1, .fi_len = 16};
  scale.mt_cnt = 1'000;
  scale.sip_res = 50'000;
  BISS_EXPECT(any_contradicts(scale));
  for (std::uint8_t first = 0; first < 4; ++first) {
    for (std::uint8_t second = 0; second < 4; ++second) {
      Bp3Part part = good;
      part.fb1 = first;
      part.fb2 = second;
      BISS_EXPECT_EQ(any_contradicts(part), first != 1 && second != 1) << +first << ' ' << +second;
    }
  }
}

// In each case one field is wrong and the checksum is corrected. Only that field and its fault may
// be reported.
BISS_TEST(EdsCheck, OneWrongField_IsTheOnlyFinding) {
  using enum EdsProblem;
  constexpr EdsPart bp3 = EdsPart::bp3;
  constexpr EdsPart common = EdsPart::common;
  const EdsBank* multi = &test::multiturn_12_20;
  const EdsBank* rotary = &test::rotary_18;
  const EdsBank* linear = &test::linear_36;
  const EdsBank* cpw = &test::safety_cpw;
  const EdsBank* one = &test::one_channel;
  const EdsBank* two = &test::two_channels;
  const std::array wrong{
      Wrong{multi, bp3, "BP_VER", 0, version},
      Wrong{multi, bp3, "BP_VER", 2, version},
      Wrong{multi, bp3, "BP_LEN", 0, out_of_range},
      Wrong{multi, bp3, "BP_ID", 0x7222, profile},
      Wrong{multi, bp3, "BP_ID", 0x0000, profile},
      Wrong{multi, bp3, "BP_ID", 0x2814, profile},
      Wrong{multi, bp3, "BP_ID", 0x6022, version},
      Wrong{multi, bp3, "BP_ID", 0x6422, version},
      Wrong{multi, bp3, "BP_ID", 0x62A2, reserved_bit},
      Wrong{multi, bp3, "BP_ID", 0x6201, data_length},
      Wrong{multi, bp3, "BP_ID", 0x623A, data_length},
      Wrong{multi, bp3, "BP_ID", 0x6221, lengths},
      Wrong{multi, bp3, "BP_ID", 0x6322, length_reading},
      Wrong{cpw, bp3, "BP_ID", 0x631E, length_reading},
      Wrong{multi, bp3, "BP_ID", 0x2262, little_endian},
      Wrong{multi, bp3, "FB1", 0, out_of_range},
      Wrong{multi, bp3, "FB1", 2, out_of_range},
      Wrong{multi, bp3, "FB2", 1, out_of_range},
      Wrong{multi, bp3, "RES_07", 1, reserved_not_zero},
      Wrong{multi, bp3, "EN_TYP", 2, out_of_range},
      Wrong{multi, bp3, "POS_NUM", 0, out_of_range},
      Wrong{multi, bp3, "POS_NUM", 3, out_of_range},
      Wrong{multi, bp3, "MT_LEN", 58, out_of_range},
      Wrong{multi, bp3, "MT_LEN", 14, lengths},
      Wrong{multi, bp3, "MT_FMT", 1, alignment},
      Wrong{multi, bp3, "MT_FMT", 2, out_of_range},
      Wrong{multi, bp3, "CO_LEN", 7, lengths},
      Wrong{multi, bp3, "CO_FMT", 255, out_of_range},
      Wrong{multi, bp3, "FI_LEN", 13, lengths},
      Wrong{multi, bp3, "FI_FMT", 2, out_of_range},
      Wrong{multi, bp3, "MT_CNT", 4097, count_above_length},
      Wrong{multi, bp3, "MT_CNT", 0x00100000, little_endian},
      Wrong{multi, bp3, "SIP_CNT", 65, count_above_length},
      Wrong{multi, bp3, "SIP_CNT", 0x40000000, little_endian},
      Wrong{multi, bp3, "SIP_RES", 16385, count_above_length},
      Wrong{multi, bp3, "SIP_RES", 0x00400000, little_endian},
      Wrong{multi, bp3, "CPOLY", 0x43, polynomial_full_form},
      Wrong{multi, bp3, "CPOLY", 0x190D9, polynomial_full_form},
      Wrong{multi, bp3, "CPOLY", 0x11021, polynomial_full_form},
      Wrong{multi, bp3, "CPOLY", 0x8810, polynomial},
      Wrong{multi, bp3, "CPOLY", 0, polynomial},
      Wrong{multi, bp3, "CPOLY", 0x21000000, little_endian},
      Wrong{multi, bp3, "CSTART", 1, out_of_range},
      Wrong{multi, bp3, "TMP_MIN", 394, min_above_max},
      Wrong{multi, bp3, "TMP_MIN", 0xE900, little_endian},
      Wrong{multi, bp3, "TMP_MAX", 0x8901, little_endian},
      Wrong{multi, bp3, "VLT_MIN", 5501, min_above_max},
      Wrong{multi, bp3, "RES_3A", 0xFF, reserved_not_zero},
      Wrong{multi, bp3, "RES_3E", 1, reserved_not_zero},
      Wrong{rotary, bp3, "MT_CNT", 2, count_above_length},
      Wrong{rotary, bp3, "FI_LEN", 17, lengths},
      Wrong{&test::longest_55, bp3, "FI_FMT", 0, alignment},
      Wrong{rotary, bp3, "SIP_RES", 4097, count_above_length},
      Wrong{linear, bp3, "MT_CNT", 5'000'000, count_above_length},
      Wrong{linear, bp3, "EN_TYP", 0, count_above_length},
      Wrong{one, common, "EDS_VER", 0, out_of_range},
      Wrong{one, common, "EDS_LEN", 0, out_of_range},
      Wrong{one, common, "EDS_LEN", 1, too_few_banks},
      Wrong{one, common, "USR_STA", 10, min_above_max},
      Wrong{one, common, "USR_END", 4, min_above_max},
      Wrong{one, common, "TMA", 0, out_of_range},
      Wrong{one, common, "TO_MIN", 121, min_above_max},
      Wrong{one, common, "TOS_MAX", 19, min_above_max},
      Wrong{one, common, "TCLK_MIN", 21, min_above_max},
      Wrong{one, common, "BUSY_S", 9, out_of_range},
      Wrong{one, common, "DC_NUM", 0, channel_count},
      Wrong{one, common, "DC_NUM", 2, channel_count},
      Wrong{one, common, "DC_NUM", 9, out_of_range},
      Wrong{one, common, "SL_NUM", 0, out_of_range},
      Wrong{one, common, "SL_OFF", 1, slave_offset},
      Wrong{one, common, "SL_OFF", 8, out_of_range},
      Wrong{one, common, "BANK_0", 0, bank_outside},
      Wrong{one, common, "BANK_0", 7, bank_in_user_area},
      Wrong{one, common, "DLEN_0", 0, out_of_range},
      Wrong{one, common, "DLEN_0", 65, out_of_range},
      Wrong{one, common, "DLEN_3", 66, out_of_range},
      Wrong{one, common, "FORMAT_4", 1, channel_unused},
      Wrong{one, common, "BANK_7", 4, channel_unused},
      Wrong{one, common, "CPOLY_0", 0x43, polynomial_full_form},
      Wrong{one, common, "CPOLY_0", 1, polynomial},
      Wrong{one, common, "RES_35", 1, reserved_not_zero},
      Wrong{one, common, "RES_3E", 0x80, reserved_not_zero},
      Wrong{two, common, "BANK_1", 6, bank_shared},
      Wrong{two, common, "SL_NUM", 1, slave_offset},
  };
  for (std::size_t i = 0; i < wrong.size(); ++i) {
    const Wrong& each = wrong[i];
    const EdsBank bank = with(*each.bank, each.part, each.symbol, each.value);
    const Findings found = check_of(each.part, bank);
    BISS_EXPECT_EQ(found.count, 1U) << "wrong bank " << i;
    const bool is_pair = each.problem == min_above_max || each.problem == lengths ||
                         each.problem == slave_offset || each.problem == count_above_length;
    const EdsFinding& first = found.list[0];
    BISS_EXPECT_EQ(first.problem, each.problem) << "wrong bank " << i;
    BISS_EXPECT(first.symbol == each.symbol || (is_pair && first.against == each.symbol) ||
                each.symbol == "EN_TYP")
        << "wrong bank " << i;
    BISS_EXPECT(first.part == each.part);
  }
}

BISS_TEST(EdsCheck, ZerosInTheSingleturnValue_MayOnlyTrail) {
  struct Case {
    std::uint8_t co_fmt;
    std::uint8_t fi_fmt;
    std::uint32_t sip_cnt;
    std::uint32_t sip_res;
    std::string_view symbol;
  };
  constexpr std::array cases{
      Case{1, 1, 256, 4096, ""},       Case{0, 0, 256, 4096, "FI_FMT"},
      Case{1, 0, 256, 4096, "FI_FMT"}, Case{0, 1, 256, 4096, "CO_FMT"},
      Case{0, 1, 1024, 4096, ""},      Case{0, 0, 1024, 16384, ""},
      Case{0, 0, 0, 4096, ""},         Case{0, 0, 0xFFFF'FFFF, 4096, ""},
  };
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const Case& each = cases[i];
    const Findings found =
        check_of(EdsPart::bp3, sealed(build_bank(Bp3Part{.bp_id = 0x621A,
                                                         .co_len = 10,
                                                         .co_fmt = each.co_fmt,
                                                         .fi_len = 14,
                                                         .fi_fmt = each.fi_fmt,
                                                         .sip_cnt = each.sip_cnt,
                                                         .sip_res = each.sip_res})));
    if (each.symbol.empty()) {
      BISS_EXPECT_EQ(found.count, 0U) << i;
    } else {
      BISS_EXPECT(found.only(each.symbol, EdsProblem::alignment, 0)) << i;
    }
  }
}

BISS_TEST(EdsCheck, EmptyAndErasedBanks_AreSaidOnce) {
  EdsBank zero{};
  EdsBank ones{};
  ones.fill(0xFF);
  BISS_EXPECT(check_of(EdsPart::bp3, zero).only("BP_VER", EdsProblem::all_zero, 0));
  BISS_EXPECT(check_of(EdsPart::bp3, ones).only("BP_VER", EdsProblem::all_ones, 0xFF));
  BISS_EXPECT(check_of(EdsPart::common, zero).only("EDS_VER", EdsProblem::all_zero, 0));
  BISS_EXPECT(check_of(EdsPart::common, ones).only("EDS_VER", EdsProblem::all_ones, 0xFF));
  zero[63] = 1;
  BISS_EXPECT(check_of(EdsPart::common, zero).has("CHKSUM", EdsProblem::checksum));
}

BISS_TEST(EdsCheck, AbsentValues_AreAnOption) {
  const EdsCheckOptions strict{.zero_is_absent = false, .ones_are_absent = false};
  const Findings zeros = check_of(EdsPart::bp3, test::rotary_18, strict);
  BISS_EXPECT_EQ(zeros.count, 13U);  // PON_PDL, MT_CNT and the eleven of 16 bits
  BISS_EXPECT(zeros.has("PON_PDL", EdsProblem::out_of_range));
  BISS_EXPECT(zeros.has("ABS_ACU", EdsProblem::out_of_range));
  const EdsCheckOptions no_ones{.ones_are_absent = false};
  const Findings ones = check_of(EdsPart::bp3, test::multiturn_odd, no_ones);
  BISS_EXPECT_EQ(ones.count, 8U);
  BISS_EXPECT(ones.has("ACC_MAX", EdsProblem::out_of_range));
}

BISS_TEST(EdsCheck, UnnamedBits_AreOnlyJudgedWhenAsked) {
  constexpr EdsCheckOptions asked{.unnamed_zero = true};
  constexpr std::array<std::string_view, 3> symbols{"RES_13", "FORMAT_0", "BC_OFF"};
  constexpr std::array<std::uint32_t, 3> values{1, 0x10, 0x20};
  for (std::size_t i = 0; i < symbols.size(); ++i) {
    const EdsBank bank = with(test::one_channel, EdsPart::common, symbols[i], values[i]);
    BISS_EXPECT_EQ(check_of(EdsPart::common, bank).count, 0U) << i;
    BISS_EXPECT(check_of(EdsPart::common, bank, asked)
                    .only(symbols[i], EdsProblem::unnamed_not_zero, values[i]))
        << i;
  }
}

BISS_TEST(EdsCheck, AllCountsLittleEndian_AreAllNamed) {
  EdsBank bank = test::multiturn_12_20;
  for (const EdsField& field : bp3_fields) {
    if (field.bytes == 1) continue;
    BISS_ASSERT(set_field(bank, field, bytes_swapped(field_value(bank, field), field.bytes)));
  }
  const Findings found = check_of(EdsPart::bp3, bank);  // the sum of the bytes is unchanged
  for (const std::string_view symbol :
       {"BP_ID", "MT_CNT", "SIP_CNT", "SIP_RES", "CPOLY", "TMP_MIN", "TMP_MAX"}) {
    BISS_EXPECT(found.has(symbol, EdsProblem::little_endian));
  }
  BISS_EXPECT(!found.has("CHKSUM", EdsProblem::checksum));
}

BISS_TEST(EdsCheck, WrongType_IsToldByTheChecksum) {
  EdsBank bank = test::linear_36;
  bank[8] = 0;
  const Findings found = check_of(EdsPart::bp3, bank);
  BISS_EXPECT(found.has("EN_TYP", EdsProblem::encoder_type));
  BISS_EXPECT(found.has("CHKSUM", EdsProblem::checksum));
  BISS_EXPECT_EQ(found.count, 2U);
}

// Whether a finding may concern this field.
bool concerns(const EdsFinding& finding, std::string_view symbol) {
  const auto any_of = [&](std::initializer_list<std::string_view> symbols) {
    for (const std::string_view each : symbols) {
      if (each == symbol) return true;
    }
    return false;
  };
  if (finding.symbol == symbol || finding.against == symbol) return true;
  if (finding.problem == EdsProblem::lengths || finding.problem == EdsProblem::length_reading)
    return any_of({"BP_ID", "MT_LEN", "CO_LEN", "FI_LEN"});
  if (finding.problem == EdsProblem::alignment)
    return any_of({"EN_TYP", "MT_CNT", "SIP_CNT", "SIP_RES"});
  if (finding.problem == EdsProblem::bank_in_user_area) return any_of({"USR_STA", "USR_END"});
  return false;
}

struct Sweep {
  std::uint32_t banks = 0;
  std::uint32_t by_symbol = 0;
};

// Every byte is set to every other value. The checksum always reports the change, and every other
// finding concerns that byte.
template <class Check>
Sweep sweep(const EdsBank& good, EdsPart part, Check check) {
  Sweep result;
  std::string_view symbol;
  for (std::size_t address = 0; address < good.size(); ++address) {
    for (const EdsField& field : fields_of(part)) {
      if (field.address == address) symbol = field.symbol;
    }
    for (unsigned change = 1; change <= 255; ++change) {
      EdsBank bank = good;
      bank[address] = static_cast<std::uint8_t>(bank[address] ^ change);
      bool sum = false;
      bool named = false;
      check(bank, [&](const EdsFinding& finding) {
        const bool own = finding.part == part;
        if (own && finding.symbol == "CHKSUM") {
          sum = finding.problem == EdsProblem::checksum;
        } else {
          named = named || (own && finding.symbol == symbol);
          BISS_EXPECT(concerns(finding, symbol)) << address << " to " << +bank[address];
        }
      });
      BISS_EXPECT(sum) << address << " to " << +bank[address];
      ++result.banks;
      if (named || address == eds_checksum_address) ++result.by_symbol;
    }
  }
  return result;
}

BISS_TEST(EdsCheck, EverySingleByteCorruption_IsReportedUnderItsFieldOrTheChecksum) {
  for (const EdsBank* good : good_bp3) {
    const Sweep result = sweep(
        *good, EdsPart::bp3, [](const EdsBank& bank, auto&& sink) { check_bp3_part(bank, sink); });
    BISS_EXPECT(result.by_symbol * 2U > result.banks) << result.by_symbol;
  }
  for (const EdsBank* good : good_common) {
    const Sweep result = sweep(*good, EdsPart::common, [](const EdsBank& bank, auto&& sink) {
      check_common_part(bank, sink);
    });
    BISS_EXPECT(result.by_symbol * 2U > result.banks) << result.by_symbol;
  }
}

BISS_TEST(EdsCheck, CorruptionBesideTheOtherPart_IsReportedUnderItsField) {
  EdsImage image{.common = &test::one_channel,
                 .profiles = {&test::multiturn_12_20},
                 .identifiers = {0x6222},
                 .eds_bank = 2};
  Findings none;
  check_eds(image, none);
  BISS_ASSERT_EQ(none.count, 0U);
  const Sweep profile =
      sweep(test::multiturn_12_20, EdsPart::bp3, [&](const EdsBank& bank, auto&& sink) {
        EdsImage damaged = image;
        damaged.profiles[0] = &bank;
        check_eds(damaged, sink);
      });
  const Sweep common =
      sweep(test::one_channel, EdsPart::common, [&](const EdsBank& bank, auto&& sink) {
        EdsImage damaged = image;
        damaged.common = &bank;
        check_eds(damaged, sink);
      });
  BISS_EXPECT(profile.by_symbol * 2U > profile.banks) << profile.by_symbol;
  BISS_EXPECT(common.by_symbol * 3U > common.banks * 2U) << common.by_symbol;
}

}  // namespace biss::eds_check_test
