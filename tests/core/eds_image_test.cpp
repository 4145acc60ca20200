// Complete data sheets: the parts compared with the registers.
#include "biss/eds/check.hpp"
#include "tests/core/eds_banks.hpp"
#include "tests/core/test.hpp"

namespace biss::eds_image_test {

// One data sheet with its own banks, and the findings of its check.
struct Sheet {
  EdsBank common = test::one_channel;
  std::array<EdsBank, 2> profiles{test::multiturn_12_20, test::multiturn_12_20};
  std::array<std::optional<std::uint16_t>, 2> identifiers{0x6222, std::nullopt};
  std::optional<std::uint8_t> eds_bank = 2;
  std::size_t parts = 1;

  EdsImage image() const {
    EdsImage all{.common = &common, .eds_bank = eds_bank};
    for (std::size_t i = 0; i < parts; ++i) {
      all.profiles[i] = &profiles[i];
      all.identifiers[i] = identifiers[i];
    }
    return all;
  }
  void set_common(std::string_view symbol, std::uint32_t value) {
    BISS_EXPECT(set_field(common, *find_field(common_fields, symbol), value));
    common = sealed(common);
  }
  void set_bp3(std::size_t i, std::string_view symbol, std::uint32_t value) {
    BISS_EXPECT(set_field(profiles[i], *find_field(bp3_fields, symbol), value));
    profiles[i] = sealed(profiles[i]);
  }
};

struct Only {
  std::size_t count = 0;
  EdsFinding last{};
  void operator()(const EdsFinding& finding) {
    ++count;
    last = finding;
  }
};

bool says_only(const Sheet& sheet, EdsPart part, std::string_view symbol, EdsProblem problem,
               const EdsCheckOptions& options = {}) {
  Only only;
  check_eds(sheet.image(), only, options);
  return only.count == 1 && only.last.part == part && only.last.symbol == symbol &&
         only.last.problem == problem;
}

bool is_good(const Sheet& sheet, const EdsCheckOptions& options = {}) {
  Only only;
  check_eds(sheet.image(), only, options);
  return only.count == 0;
}

// CPW (C = 1) from channel 1, SPW from channel 0, as in two_channels.
Sheet safety_sheet() {
  Sheet sheet{.common = test::two_channels, .identifiers = {}, .eds_bank = 4, .parts = 2};
  sheet.profiles[0] = EdsBank{1, 1, 0x73, 0x3A};
  sheet.profiles[0] = sealed(sheet.profiles[0]);
  sheet.profiles[1] = test::safety_cpw;
  return sheet;
}

BISS_TEST(EdsImage, GoodSheets_GiveNoFinding) {
  BISS_EXPECT(is_good({}));
  BISS_EXPECT(is_good(safety_sheet()));
  BISS_EXPECT_EQ(channel_count(Sheet{}.image()), 1U);
  BISS_EXPECT_EQ(channel_count(safety_sheet().image()), 2U);
  Only none;
  check_eds({}, none);
  BISS_EXPECT_EQ(none.count, 0U);
  BISS_EXPECT_EQ(channel_count({}), 0U);
  EdsImage registers_only;
  registers_only.identifiers[2] = 0x621E;
  BISS_EXPECT_EQ(channel_count(registers_only), 3U);
}

BISS_TEST(EdsImage, Registers_AgreeWithThePart) {
  Sheet sheet;
  sheet.identifiers[0] = 0x6223;
  sheet.set_common("DLEN_0", 35);  // the registers' length
  BISS_EXPECT(says_only(sheet, EdsPart::bp3, "BP_ID", EdsProblem::identifier));
  sheet.set_common("DLEN_0", 34);
  Only found;
  check_eds(sheet.image(), found);
  BISS_EXPECT_EQ(found.count, 1U);
  BISS_EXPECT(found.last.symbol == "BP_ID" && found.last.problem == EdsProblem::identifier);
  BISS_EXPECT_EQ(found.last.value, 0x6222);
  BISS_EXPECT_EQ(found.last.expected, 0x6223);
  sheet.identifiers[0] = 0x7222;
  BISS_EXPECT(says_only(sheet, EdsPart::bp3, "BP_ID", EdsProblem::identifier));
  sheet = {};
  sheet.set_bp3(0, "BP_ID", 0x7222);
  BISS_EXPECT(says_only(sheet, EdsPart::bp3, "BP_ID", EdsProblem::identifier));
  sheet.set_bp3(0, "BP_ID", 0x2262);
  sheet.identifiers[0] = std::nullopt;
  BISS_EXPECT(says_only(sheet, EdsPart::bp3, "BP_ID", EdsProblem::little_endian));
  sheet.identifiers[0] = 0x6222;
  BISS_EXPECT(says_only(sheet, EdsPart::bp3, "BP_ID", EdsProblem::little_endian));
}

BISS_TEST(EdsImage, TwoAgainstOne_TellsWhichLengthIsWrong) {
  Sheet sheet;
  sheet.set_common("DLEN_0", 33);
  BISS_EXPECT(says_only(sheet, EdsPart::common, "DLEN_0", EdsProblem::data_length_differs));
  sheet = {};
  sheet.identifiers[0] = std::nullopt;
  sheet.set_bp3(0, "BP_ID", 0x6223);
  BISS_EXPECT(says_only(sheet, EdsPart::bp3, "BP_ID", EdsProblem::lengths));
  sheet = {};
  sheet.set_bp3(0, "CO_LEN", 5);
  BISS_EXPECT(says_only(sheet, EdsPart::bp3, "CO_LEN", EdsProblem::lengths));
  // DLEN_i and the lengths outvote the identifier, even where a count leaves unused bits.
  sheet = {};
  sheet.identifiers[0] = std::nullopt;
  sheet.set_bp3(0, "MT_CNT", 1000);
  sheet.set_bp3(0, "BP_ID", 0x6223);
  BISS_EXPECT(says_only(sheet, EdsPart::bp3, "BP_ID", EdsProblem::lengths));
  // Without counts as evidence, no length is more suspect than the other.
  sheet = {};
  sheet.profiles[0] = test::shortest_0;
  sheet.set_bp3(0, "BP_ID", 0x6222);
  BISS_EXPECT(says_only(sheet, EdsPart::bp3, "FI_LEN", EdsProblem::lengths));
}

BISS_TEST(EdsImage, CommonPart_AgreesWithTheProfile) {
  Sheet sheet;
  sheet.set_common("CPOLY_0", 0x12);
  BISS_EXPECT(says_only(sheet, EdsPart::common, "CPOLY_0", EdsProblem::polynomial_differs));
  sheet.set_common("CPOLY_0", 0);
  BISS_EXPECT(says_only(sheet, EdsPart::common, "CPOLY_0", EdsProblem::polynomial_differs));
  sheet.set_common("CPOLY_0", 0x43);
  BISS_EXPECT(says_only(sheet, EdsPart::common, "CPOLY_0", EdsProblem::polynomial_full_form));
  sheet = {};
  sheet.set_common("FORMAT_0", 1);
  BISS_EXPECT(says_only(sheet, EdsPart::common, "FORMAT_0", EdsProblem::actuator));
  sheet = {};
  sheet.parts = 0;
  BISS_EXPECT(is_good(sheet));
  EdsImage image = sheet.image();
  image.identifiers[0] = 0x6224;  // the part was not read, the registers were
  Only found;
  check_eds(image, found);
  BISS_EXPECT_EQ(found.count, 1U);
  BISS_EXPECT(found.last.symbol == "DLEN_0");
}

BISS_TEST(EdsImage, CrcAsData_MayBeCountedEitherWayByTheCommonPart) {
  Sheet sheet = safety_sheet();
  for (const std::uint32_t length : {30U, 36U}) {
    sheet.set_common("DLEN_1", length);
    BISS_EXPECT(is_good(sheet)) << length;
  }
  sheet.set_common("DLEN_1", 31);
  BISS_EXPECT(says_only(sheet, EdsPart::common, "DLEN_1", EdsProblem::data_length_differs));
  sheet.set_common("DLEN_1", 30);
  sheet.set_common("CPOLY_1", 0);
  BISS_EXPECT(is_good(sheet));
  sheet.set_bp3(1, "CPOLY", 0);
  BISS_EXPECT(is_good(sheet));
  sheet.set_bp3(1, "BP_ID", 0x631E);
  BISS_EXPECT(!is_good(sheet));
}

BISS_TEST(EdsImage, ControlWordWithoutC_IsWrongBesideASafetyWord) {
  Sheet sheet = safety_sheet();
  sheet.set_bp3(1, "BP_ID", 0x621E);
  BISS_EXPECT(says_only(sheet, EdsPart::bp3, "BP_ID", EdsProblem::crc_bit));
  sheet.profiles[0] = EdsBank{1, 1, 0x28, 0x14};
  sheet.profiles[0] = sealed(sheet.profiles[0]);
  BISS_EXPECT(is_good(sheet));
}

BISS_TEST(EdsImage, SafetyWordWithoutC_IsWrong) {
  Sheet sheet = safety_sheet();
  sheet.profiles[0] = sealed(EdsBank{1, 1, 0x72, 0x2A});
  BISS_EXPECT(says_only(sheet, EdsPart::raw, "BP_ID", EdsProblem::crc_bit));
  sheet.identifiers[0] = 0x7330;  // the registers take precedence
  BISS_EXPECT(is_good(sheet));
}

BISS_TEST(EdsImage, StandardEncoderWithC_IsWrong) {
  Sheet sheet;
  sheet.profiles[0] = test::safety_cpw;
  sheet.set_common("DLEN_0", 30);
  for (const std::uint16_t registers : {std::uint16_t{0x6324}, std::uint16_t{0}}) {
    sheet.identifiers[0] = registers;
    if (registers == 0) sheet.identifiers[0].reset();
    BISS_EXPECT(says_only(sheet, EdsPart::bp3, "BP_ID", EdsProblem::crc_bit));
  }
  // The device may have a safety word that was not read.
  sheet.set_common("SL_NUM", 2);
  BISS_EXPECT(is_good(sheet));
  Sheet two = safety_sheet();
  two.parts = 2;
  EdsImage image = two.image();
  image.profiles[0] = nullptr;
  Only found;
  check_eds(image, found);
  BISS_EXPECT_EQ(found.count, 0U);
  image.identifiers[0] = 0x2814;
  check_eds(image, found);
  BISS_EXPECT(found.count == 1 && found.last.problem == EdsProblem::crc_bit);
  // A part alone does not show to which encoder it belongs.
  check_bp3_part(test::safety_cpw, found = {});
  BISS_EXPECT_EQ(found.count, 0U);
}

BISS_TEST(EdsImage, UnknownProfiles_AreJudgedByTheirChecksumOnly) {
  Sheet sheet = safety_sheet();
  sheet.profiles[0][20] ^= 1U;
  BISS_EXPECT(says_only(sheet, EdsPart::raw, "CHKSUM", EdsProblem::checksum));
  sheet.profiles[0] = EdsBank{};
  sheet.identifiers[0] = 0x7330;
  BISS_EXPECT(says_only(sheet, EdsPart::raw, "BP_VER", EdsProblem::all_zero));
}

BISS_TEST(EdsImage, BankPointers_StayInsideAndOutOfLoops) {
  Sheet sheet = safety_sheet();  // banks 4, 5, 6
  sheet.set_common("BANK_0", 4);
  BISS_EXPECT(says_only(sheet, EdsPart::common, "BANK_0", EdsProblem::bank_is_common));
  sheet.set_common("BANK_0", 7);
  BISS_EXPECT(says_only(sheet, EdsPart::common, "BANK_0", EdsProblem::bank_outside));
  sheet.set_common("BANK_0", 3);
  BISS_EXPECT(says_only(sheet, EdsPart::common, "BANK_0", EdsProblem::bank_outside));
  sheet.set_common("BANK_0", 5);
  BISS_EXPECT(says_only(sheet, EdsPart::common, "BANK_1", EdsProblem::bank_shared));
  sheet = safety_sheet();
  sheet.set_common("EDS_LEN", 2);
  BISS_EXPECT(says_only(sheet, EdsPart::common, "EDS_LEN", EdsProblem::too_few_banks));
  sheet = safety_sheet();
  sheet.set_common("EDS_LEN", 253);
  BISS_EXPECT(says_only(sheet, EdsPart::common, "EDS_LEN", EdsProblem::too_few_banks));
  sheet = safety_sheet();
  sheet.set_common("USR_STA", 4);
  sheet.set_common("USR_END", 4);
  BISS_EXPECT(says_only(sheet, EdsPart::common, "USR_STA", EdsProblem::bank_in_user_area));
}

// A good BP3 part of random values.
Bp3Part random_part(test::Random& random) {
  Bp3Part part;
  const bool data = random.flip();
  part.mt_len = static_cast<std::uint8_t>(random.below(25));
  part.co_len = static_cast<std::uint8_t>(random.below(16));
  part.fi_len = static_cast<std::uint8_t>(random.below(16));
  part.bp_id = static_cast<std::uint16_t>((data ? 0x6300U : 0x6200U) + part.position_bits() + 2U +
                                          (data ? 6U : 0U));
  part.en_typ = random.flip();
  part.pos_num = static_cast<std::uint8_t>(1 + random.below(2));
  part.co_fmt = part.fi_fmt = 1;
  part.pon_pdl = static_cast<std::uint8_t>(random.bits(8));
  const auto count_of = [&](unsigned bits) { return 1U + random.below(std::uint32_t{1} << bits); };
  part.mt_cnt = count_of(part.mt_len);
  part.sip_cnt = count_of(part.co_len);
  part.sip_res = count_of(part.fi_len);
  if (part.linear()) part.sip_cnt = static_cast<std::uint32_t>(random.bits(32));
  for (BigEndian<std::uint16_t>* value :
       {&part.abs_acu, &part.rel_acu, &part.spd_acu, &part.hyst, &part.spd_max, &part.acc_max,
        &part.vlt_max, &part.cur_max}) {
    *value = static_cast<std::uint16_t>(random.bits(16));
  }
  part.vlt_min = static_cast<std::uint16_t>(random.below(part.vlt_max + 1U));
  part.tmp_min = static_cast<std::uint16_t>(200 + random.below(100));
  part.tmp_max = static_cast<std::uint16_t>(300 + random.below(200));
  return part;
}

BISS_TEST(EdsImage, RandomGoodParts_AreGood) {
  BISS_RANDOM(random, 0x600D);
  for (std::uint64_t round = test::rounds(100'000, 300); round-- > 0;) {
    const Bp3Part part = random_part(random);
    const EdsBank bank = sealed(build_bank(part));
    Only found;
    check_bp3_part(bank, found);
    BISS_ASSERT_EQ(found.count, 0U) << found.last.value;
  }
}

}  // namespace biss::eds_image_test
