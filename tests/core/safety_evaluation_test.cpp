// The two evaluations of one frame: published and derived words, fields, flags, the comparison, and
// their agreement on any bits.
#include "biss/safety/field_evaluation.hpp"
#include "biss/safety/line_evaluation.hpp"
#include "tests/core/safety_bench.hpp"
#include "tests/core/test.hpp"

namespace biss::safety_evaluation_test {

using enum SafetyVerdict;
using test::Findings;
using test::format_of;
using test::RunPlan;
using test::SafetyWords;

RunPlan plan_of(std::string_view format, const SafetySetup& setup = {}) {
  return {format_of(format), UnratedSafetySetup(setup)};
}

// Ones, ACK, START, CDS and the payload: numbers and their widths, then STOP.
struct Piece {
  std::uint64_t value;
  unsigned bits;
};
template <std::size_t Count>
test::LineBits line_of(const std::array<Piece, Count>& pieces) {
  test::LineBits line = test::line_of("11");
  line.append_run(false, test::ack_clocks);
  line.append(0b10, 2);
  for (const Piece& piece : pieces) line.append(piece.value, piece.bits);
  line.append(false);
  return line;
}

BISS_TEST(SafetyWords, PublishedSpwOfAn21_IsTakenAndMade) {
  // iC-Haus AN21: D9 CF E0 C0 DA, CRC 0x5F29. The CPW has the same position and its own CRC.
  const RunPlan plan = plan_of("mt12,st20,nE,nW,crc6+mt12,st20,nE,nW,lc6,crc16");
  const std::uint64_t cpw = 0xD9CFE0C0U * 4ULL + 3U;
  const test::LineBits line =
      line_of(std::array{Piece{cpw, 34}, Piece{plan.codec().crc(0, cpw, false), 6},
                         Piece{0xD9CFE0C0DAU, 40}, Piece{0x5F29, 16}});
  const Findings findings(plan, line.view());
  BISS_EXPECT(findings.are(safe));
  BISS_EXPECT_EQ(findings.first.cpw_position, 0xD9CFE0C0U);
  BISS_EXPECT_EQ(findings.first.life_counter, 26);
  BISS_EXPECT_EQ(findings.first.difference_lsb, 0);
  BISS_EXPECT(findings.first.cpw_nW() && findings.first.spw_nW());
  const FrameBits made =
      test::bits_of(plan, {.cpw = 0xD9CFE0C0U, .spw = 0xD9CFE0C0U, .life_counter = 26});
  for (std::size_t i = 0; i < line.size_bits(); ++i) {
    BISS_EXPECT_EQ(made.view()[i], line.view()[i]) << i;
  }
}

BISS_TEST(SafetyWords, PublishedCaptureOfTi_IsTakenAndMade) {
  // TI motor-control-sdk: turns 65535 of 16 bits, 2924 of 12 bits, e_w = 1 (nE 0), LC 57, 0xD79F.
  // Its CPW is not published. The CPW of the same value has nE = 1 here, so that the nE of the SPW
  // decides.
  const RunPlan plan = plan_of("mt16,st12,nE,nW,crc6+mt16,st12,nE,nW,lc6,crc16");
  const std::uint64_t place = 65535U * 4096ULL + 2924U;
  const std::uint64_t cpw = place * 4U + 3U;
  const auto line = [&](std::uint64_t life, std::uint64_t crc) {
    return line_of(std::array{Piece{cpw, 30}, Piece{plan.codec().crc(0, cpw, false), 6},
                              Piece{place, 28}, Piece{1, 2}, Piece{life, 6}, Piece{crc, 16}});
  };
  const Findings findings(plan, line(57, 0xD79F).view());
  BISS_EXPECT(findings.are(spw_error));
  BISS_EXPECT_EQ(findings.first.life_counter, 57);
  BISS_EXPECT_EQ(findings.first.cpw_position, place);
  BISS_EXPECT(Findings(plan, line(58, 0xD79F).view()).are(spw_crc));
  BISS_EXPECT(Findings(plan, line(57, 0xD79E).view()).are(spw_crc));
  const FrameBits made =
      test::bits_of(plan, {.cpw = place, .spw = place, .life_counter = 57, .spw_nE = false});
  BISS_EXPECT(made.view().word(made.size_bits() - 17U, 16) == 0xD79F);
  // TI's console, 12 bits: 0xC00 with e_w = 1 has 0x2D, 1406 with e_w = 3 has 0x36.
  const RunPlan small = plan_of("st12,nE,nW,crc6+st12,nE,nW,lc6,crc16");
  const auto small_line = [&](std::uint64_t data, std::uint64_t crc) {
    const std::uint64_t spw = (data >> 2U) << 8U | 0xC0U | 5U;
    return line_of(std::array{Piece{data, 14}, Piece{crc, 6}, Piece{spw, 20},
                              Piece{small.codec().crc(1, spw, false), 16}});
  };
  BISS_EXPECT(Findings(small, small_line(0xC00U * 4U + 1U, 0x2D).view()).are(cpw_error));
  BISS_EXPECT(Findings(small, small_line(1406U * 4U + 3U, 0x36).view()).are(safe));
  BISS_EXPECT(Findings(small, small_line(1406U * 4U + 3U, 0x35).view()).are(cpw_crc));
}

BISS_TEST(SafetyWords, DerivedSpws_AreTakenAndMadeWithBothStartValues) {
  struct Case {
    const char* name;
    std::uint64_t cpw;
    std::uint32_t life_counter;
    std::uint16_t start;
    std::uint16_t crc;
  };
  constexpr Case cases[] = {
      {"fs-28-24", 0x1234567, 1, 0, 0x1CBF},    {"fs-28-24", 0x1234567, 1, 1, 0x24CD},
      {"fs-36-28", 0x123456789, 1, 0, 0xE49E},  {"fs-36-28", 0x123456789, 1, 1, 0x420C},
      {"fs-36-28", 0x123456789, 63, 0, 0x7976}, {"fs-36-28", 0x123456789, 63, 1, 0xDFE4},
      {"fs-32-32", 0x12345678, 0, 0, 0x2498},   {"fs-32-32", 0x12345678, 0, 1, 0x8814},
      {"fs-32-32", 0x12345678, 1, 0, 0xB441},   {"fs-32-32", 0x12345678, 1, 1, 0x18CD},
  };
  for (const Case& each : cases) {
    FrameFormat format = find_safety_configuration(each.name)->frame_format();
    format.channel_list[1].crc.start = each.start;
    const RunPlan plan(format, UnratedSafetySetup());
    const unsigned cpw_bits = format.channel_list[0].position.bits;
    const unsigned spw_bits = format.channel_list[1].position.bits;
    const std::uint64_t spw = each.cpw >> (cpw_bits - spw_bits);
    const std::uint64_t cpw_data = each.cpw * 4U + 3U;
    const test::LineBits line = line_of(std::array{
        Piece{cpw_data, cpw_bits + 2U}, Piece{plan.codec().crc(0, cpw_data, false), 6},
        Piece{spw, spw_bits}, Piece{3, 2}, Piece{each.life_counter, 6}, Piece{each.crc, 16}});
    const Findings findings(plan, line.view());
    BISS_EXPECT(findings.are(safe)) << each.name << " " << each.crc;
    BISS_EXPECT_EQ(findings.first.cpw_position, each.cpw);
    BISS_EXPECT_EQ(findings.first.life_counter, each.life_counter);
    const FrameBits made =
        test::bits_of(plan, {.cpw = each.cpw, .spw = spw, .life_counter = each.life_counter});
    BISS_EXPECT_EQ(made.view().word(line.size_bits() - 17U, 16), each.crc);
    // The frame of the other encoder, where the start values differ.
    format.channel_list[1].crc.start = static_cast<std::uint16_t>(1U - each.start);
    BISS_EXPECT(Findings(RunPlan(format, UnratedSafetySetup()), line.view()).are(spw_crc));
  }
  // PROTOCOL 8: CRC6 0x34 of 36 bits, 0x05 of 32 bits.
  BISS_EXPECT_EQ(test::plan_of("fs-36-28").codec().crc(0, 0x123456789U * 4ULL + 3U, false), 0x34);
  BISS_EXPECT_EQ(test::plan_of("fs-32-32").codec().crc(0, 0x12345678U * 4ULL + 3U, false), 0x05);
}

// The comparison, computed by a search over every offset.
BISS_TEST(SafetyComparison, EveryDistance_IsMeasuredTheShortWayRound) {
  // 6 bits against 4: all positions of both.
  for (const std::uint8_t bits : {std::uint8_t{0}, std::uint8_t{3}, std::uint8_t{4}}) {
    for (const std::uint8_t tolerance : {std::uint8_t{0}, std::uint8_t{1}, std::uint8_t{2}}) {
      SafetySetup setup;
      setup.comparison = {.compare_bits = bits, .tolerance_lsb = tolerance};
      const RunPlan plan = plan_of("pos6,nE,nW,crc6+pos4,nE,nW,lc6,crc16", setup);
      const unsigned width = bits == 0 ? 4 : bits;
      const int range = 1 << width;
      for (std::uint64_t cpw = 0; cpw < 64; ++cpw) {
        for (std::uint64_t spw = 0; spw < 16; ++spw) {
          const Findings findings(plan, test::bits_of(plan, {.cpw = cpw, .spw = spw}).view());
          int apart = static_cast<int>(cpw >> (6U - width)) - static_cast<int>(spw >> (4U - width));
          while (apart >= range / 2) apart -= range;
          while (apart < -range / 2) apart += range;
          BISS_EXPECT_EQ(findings.first.difference_lsb, apart) << cpw << " " << spw;
          const bool near = apart <= tolerance && apart >= -tolerance;
          BISS_EXPECT(findings.are(near ? safe : comparison)) << cpw << " " << spw << " " << apart;
        }
      }
    }
  }
}

BISS_TEST(SafetyComparison, TurnsAreOneNumberWithTheSingleturnOrIgnored) {
  for (const MultiturnRule rule : {MultiturnRule::with_carry, MultiturnRule::ignored}) {
    const RunPlan plan =
        test::plan_of("rsm", [&](SafetySetup& setup) { setup.comparison.multiturn = rule; });
    const bool carry = rule == MultiturnRule::with_carry;
    const auto verdict = [&](std::uint64_t cpw, std::uint64_t spw) {
      const Findings findings(plan, test::bits_of(plan, {.cpw = cpw, .spw = spw}).view());
      BISS_EXPECT(findings.agree());
      return findings.first.cause;
    };
    // CPW 12 + 16 bits, SPW 12 + 12, 9 bits compared: an LSB is 128 counts of CPW, 8 of SPW.
    BISS_EXPECT_EQ(verdict(0x123'0000, 0x123'000), safe);
    BISS_EXPECT_EQ(verdict(0x123'0000, 0x122'FFF), safe);  // just below zero: a carry, one count
    BISS_EXPECT_EQ(verdict(0x123'0000, 0x123'FFF), carry ? comparison : safe);
    BISS_EXPECT_EQ(verdict(0x123'0000, 0x124'000), carry ? comparison : safe);
    BISS_EXPECT_EQ(verdict(0x123'0000, 0x122'FF0), carry ? comparison : comparison);
    BISS_EXPECT_EQ(verdict(0x000'0000, 0xFFF'FFF), safe);  // the end of the last turn is next to 0
    BISS_EXPECT_EQ(verdict(0xFFF'FFFF, 0x000'000), safe);
    BISS_EXPECT_EQ(verdict(0x000'0000, 0xFFF'000), carry ? comparison : safe);
  }
}

BISS_TEST(SafetyComparison, SpwWithoutTurns_IsComparedWithinTheTurn) {
  const RunPlan plan = test::plan_of("rum");
  const auto cause = [&](std::uint64_t cpw, std::uint64_t spw) {
    const Findings findings(plan, test::bits_of(plan, {.cpw = cpw, .spw = spw}).view());
    BISS_EXPECT_EQ(findings.first.cpw_position, cpw);
    return findings.agree() ? findings.first.cause : disagreement;
  };
  BISS_EXPECT_EQ(cause(0x123'8000, 0x800), safe);
  BISS_EXPECT_EQ(cause(0x124'8000, 0x800), safe);
  BISS_EXPECT_EQ(cause(0x124'0000, 0xFFF), safe);
  BISS_EXPECT_EQ(cause(0x124'8000, 0x810), comparison);
}

BISS_TEST(SafetyComparison, SpwWithMoreTurns_IsComparedInTheTurnsOfTheCpw) {
  const RunPlan plan = plan_of("mt4,st8,nE,nW,crc6+mt6,st8,nE,nW,lc6,crc16");
  const auto cause = [&](std::uint64_t cpw, std::uint64_t spw) {
    const Findings findings(plan, test::bits_of(plan, {.cpw = cpw, .spw = spw}).view());
    return findings.agree() ? findings.first.cause : disagreement;
  };
  BISS_EXPECT_EQ(cause(0x380, 0x380), safe);
  BISS_EXPECT_EQ(cause(0x380, 0x3380), safe);
  BISS_EXPECT_EQ(cause(0x000, 0x0FFF), safe);
  BISS_EXPECT_EQ(cause(0x380, 0x280), comparison);
}

BISS_TEST(SafetyComparison, WideWords_HoldTheDifferenceAtItsLimits) {
  // 48 bits are compared: more than the difference's type holds.
  const RunPlan plan = plan_of("mt24,st24,nE,nW,crc6+mt24,st16,nE,nW,lc6,crc16");
  const auto difference = [&](std::uint64_t cpw, std::uint64_t spw) {
    const Findings findings(plan, test::bits_of(plan, {.cpw = cpw, .spw = spw}).view());
    BISS_EXPECT(findings.are(comparison));
    return findings.first.difference_lsb;
  };
  BISS_EXPECT_EQ(difference(low_mask(47), 0), INT32_MAX);
  BISS_EXPECT_EQ(difference(std::uint64_t{1} << 47U, 0), -INT32_MAX);
  BISS_EXPECT_EQ(difference(std::uint64_t{1000} << 8U, 3), 997);
}

BISS_TEST(SafetyFinding, OfACoarserCpwOrWordsInTheOtherOrder_IsFoundToo) {
  SafetySetup setup{.cpw = 1, .spw = 0};
  setup.comparison.tolerance_lsb = 0;
  const RunPlan plan = plan_of(
      "pad3,pos20,W,E,lc6,crc16:0x190D9:0x0001+pos12,E,pad2,nW,crc6:0x43:0x3F:plain", setup);
  const ChannelFormat& cpw = plan.format().channel_list[1];
  const ChannelFormat& spw = plan.format().channel_list[0];
  BISS_RANDOM(random, 0x5AFE'0001);
  for (int i = 0; i < 200; ++i) {
    SafetyWords words{.cpw = random.bits(12), .life_counter = random.below(64)};
    words.spw = spw_position(cpw, spw, words.cpw) + random.below(256);
    BISS_EXPECT_EQ(spw_position(spw, cpw, words.spw), words.cpw);
    words.cpw_nW = random.flip();
    words.spw_nW = random.flip();
    words.cpw_nE = random.below(4) != 0;
    words.spw_nE = random.below(4) != 0;
    const Findings findings(plan, test::bits_of(plan, words).view());
    BISS_EXPECT(findings.are(!words.cpw_nE ? cpw_error : !words.spw_nE ? spw_error : safe));
    BISS_EXPECT_EQ(findings.first.cpw_position, words.cpw);
    BISS_EXPECT_EQ(findings.first.life_counter, words.life_counter);
    BISS_EXPECT_EQ(findings.first.cpw_nW(), words.cpw_nW);
    BISS_EXPECT_EQ(findings.first.spw_nW(), words.spw_nW);
  }
}

// Bits whose last byte is the last one of their storage. A read beyond the end stops the compiler
// in a constant expression, and is a finding of the sanitizer at run time.
class TightLine {
 public:
  constexpr explicit TightLine(const BitView& bits)
      : size_(bits.stored().size()),
        first_bit_(bits.first_bit_of_stored()),
        size_bits_(bits.size_bits()) {
    std::copy_n(bits.stored().begin(), size_, bytes_.end() - static_cast<std::ptrdiff_t>(size_));
  }
  constexpr BitView view() const {
    return {std::span<const std::uint8_t>(bytes_).last(size_), first_bit_, size_bits_};
  }

 private:
  std::array<std::uint8_t, test::LineBits::capacity_bits / 8U> bytes_{};
  std::size_t size_;
  unsigned first_bit_;
  std::size_t size_bits_;
};

// The shortest frame, complete and cut, in a plan with room for the longest ones.
constexpr bool reads_nothing_behind_the_end() {
  const SafetyConfiguration& type = *find_safety_configuration("rxm");
  const SafetyPlan<2, CrcBitwise> plan(type.frame_format(), type.setup);
  const FrameBits made = test::bits_of(plan, {.cpw = 0x1234, .spw = 0x123, .life_counter = 5});
  const std::size_t frame_bits = made.size_bits();
  for (std::size_t less = 0; less < 9; ++less) {
    const TightLine line(made.view().first(frame_bits - less));
    const SafetyVerdict cause =
        LineEvaluation<SafetyPlan<2, CrcBitwise>>::find(plan, line.view()).cause;
    // The first bit that may be missing is STOP.
    if (cause != (less < 2 ? safe : no_frame)) return false;
  }
  return true;
}
static_assert(reads_nothing_behind_the_end());

// Nearly valid frames and random lines, cut at any place and with any bounds, give equal findings.
template <class Plan>
void expect_one_finding(const Plan& plan, test::Random& random, std::uint64_t rounds) {
  test::LineBits line;
  for (std::uint64_t round = 0; round < rounds; ++round) {
    line.clear();
    const std::uint32_t kind = random.below(4);
    if (kind == 0) {
      for (int i = 0; i < 8; ++i) line.append(random.next(), 64);
    } else {
      line.append_run(false, kind == 1 ? random.below(6) : 0);
      line.append_run(true, 1U + random.below(random.below(8) == 0 ? 70 : 6));
      line.append_run(false, 1U + random.below(random.below(8) == 0 ? 150 : 12));
      line.append(true);
      line.append(random.below(8) == 0);
      for (std::size_t k = 0; k < plan.format().channel_count; ++k) {
        const ChannelFormat& channel = plan.format().channel_list[k];
        const std::uint64_t data = random.bits(channel.data_bits);
        line.append(data, channel.data_bits);
        if (channel.crc.present())
          line.append(plan.codec().crc(k, data, false), channel.crc.width_bits);
      }
      line.append_run(random.below(8) == 0, random.below(4));
      if (kind == 2) line.flip(random.below(static_cast<std::uint32_t>(line.size_bits())));
    }
    if (random.below(4) == 0)
      line.truncate(random.below(static_cast<std::uint32_t>(line.size_bits())));
    const std::uint32_t begin = random.below(4) == 0 ? random.below(9) : 0;
    const TightLine tight(line.view().from(begin));
    const Findings findings(plan, tight.view());
    BISS_ASSERT(findings.agree()) << "round " << round;
    BISS_ASSERT(findings.first.cause == safe || findings.first.cause >= no_frame);
    const bool read = decode_frame(line.view().from(begin), plan.codec(), plan.setup().bounds).ok();
    BISS_ASSERT_EQ(findings.first.cause == safe || findings.first.cause == cpw_error ||
                       findings.first.cause == spw_error || findings.first.cause == comparison,
                   read);
  }
}

BISS_TEST(SafetyFinding, OfLinesThatNeverBegin_IsNoFrame) {
  SafetySetup setup;
  setup.bounds = {.lead_min_clocks = 3, .late_max_clocks = 3};
  const RunPlan plan = plan_of("pos36,nE,nW,crc6+pos28,nE,nW,lc6,crc16", setup);
  for (const std::string_view levels :
       {"", "0", "1", "00000", "11111", "001111", "00110000", "010011",
        "1111111111111111111111111111111111", "000000000000000000000000000000000000",
        "0000000000000000000000000000000000000000000001",
        "001111111111111111111111111111111111111111111111111111111111111111111111111111111"}) {
    BISS_EXPECT(Findings(plan, test::line_of(levels).view()).are(no_frame));
  }
}

BISS_TEST(SafetyFinding, OfAnyLine_IsTheSameInBothEvaluations) {
  BISS_RANDOM(random, 0x5AFE'0002);
  const std::uint64_t rounds = test::rounds(4'000, 100);
  constexpr FrameBounds narrow{.lead_min_clocks = 2,
                               .lead_max_clocks = 5,
                               .ack_min_clocks = 3,
                               .ack_max_clocks = 9,
                               .late_max_clocks = 3};
  for (const SafetyConfiguration& each : safety_configurations) {
    SafetySetup setup = each.setup;
    expect_one_finding(RunPlan(each.frame_format(), UnratedSafetySetup(setup)), random, rounds);
    setup.bounds = narrow;
    expect_one_finding(RunPlan(each.frame_format(), UnratedSafetySetup(setup)), random, rounds);
  }
  // The longest words, a third and a fourth channel, one of them without a CRC.
  const auto wide = [&](std::string_view text, SafetySetup setup) {
    expect_one_finding(SafetyPlan<4>(format_of(text), UnratedSafetySetup(setup)), random, rounds);
  };
  wide("pos62,nE,nW,crc16+pos56,nE,nW,lc6,crc16:0x190D9:0xFFFF:plain;cds0", {});
  wide("pos10,nE,nW,crc3+pos10,nE,nW,lc6,crc16+pos20,crc6+pad12", {});
  wide("pad7+pos20,crc6+mt12,st19,pad5,nW,E,crc8+st7,mt1,nE,lc6,crc5", {.cpw = 2, .spw = 3});
  wide("pos30,nE,crc6+pos30,nE,lc6,crc16+pad30,crc6", {.cpw = 1, .spw = 0});
}

constexpr SafetySetup bounded = [] {
  SafetySetup setup;
  setup.bounds = {.lead_max_clocks = 40, .ack_max_clocks = 60, .late_max_clocks = 2};
  return setup;
}();

BISS_TEST(SafetyFinding, WithAPlanKnownWhileCompiling_IsTheSameToo) {
  BISS_RANDOM(random, 0x5AFE'0003);
  constexpr FrameFormat format = find_safety_configuration("fs-36-28")->frame_format();
  using Fixed = FixedSafetyPlan<format, bounded, CrcBitwise>;
  expect_one_finding(Fixed(), random, test::rounds(20'000, 300));
}

// ---- The safe position

struct Positions {
  SafePosition first;
  SafePosition second;
};
Positions positions_of(const RunPlan& plan, const test::SafetyWords& words) {
  const FrameBits bits = test::bits_of(plan, words);
  const test::Findings<RunPlan> findings(plan, bits.view());
  BISS_EXPECT(findings.agree());
  return {FieldEvaluation<RunPlan>::safe_position(plan, findings.first),
          LineEvaluation<RunPlan>::safe_position(plan, findings.second)};
}

BISS_TEST(SafePosition, HasTheResolutionOfTheSpwAndNamesWhatOnlyTheCpwHas) {
  const RunPlan plan = plan_of("pos36,nE,nW,crc6+pos28,nE,nW,lc6,crc16");
  const auto [first, second] = positions_of(plan, {.cpw = 0x1'2345'6789U, .spw = 0x123'4568U});
  BISS_EXPECT(first == second);
  BISS_EXPECT_EQ(first.value, 0x123'4568U);
  BISS_EXPECT_EQ(first.low, 0x123'4567U);
  BISS_EXPECT_EQ(first.high, 0x123'4569U);
  BISS_EXPECT_EQ(first.cpw_only_offset, 0x89 - 0x100);
  BISS_EXPECT_EQ(first.cpw_only_turns, 0);
  BISS_EXPECT_EQ(control_position(plan, first), 0x1'2345'6789U);
}

BISS_TEST(SafePosition, BitsThatAreNotCompared_WidenTheBounds) {
  const SafetySetup setup{.comparison = {.compare_bits = 9}};
  const RunPlan plan = plan_of("mt12,st16,nE,nW,crc6+st12,nE,nW,lc6,crc16", setup);
  // Turn 0x9AB, of which the SPW has nothing; at the end of the turn.
  const auto [first, second] = positions_of(plan, {.cpw = 0x9AB'FFF7U, .spw = 0xFFE});
  BISS_EXPECT(first == second);
  BISS_EXPECT_EQ(first.value, 0xFFE);
  BISS_EXPECT_EQ(first.low, 0xFF0);
  BISS_EXPECT_EQ(first.high, 0x007);
  BISS_EXPECT_EQ(first.cpw_only_turns, 0x9AB);
  BISS_EXPECT_EQ(control_position(plan, first), 0x9AB'FFF7U);
}

BISS_TEST(SafePosition, WithOneOtherMember_IsAnother) {
  using Change = void (*)(SafePosition&);
  constexpr Change changes[] = {
      [](SafePosition& p) { p.value ^= 1U; },
      [](SafePosition& p) { p.low ^= 1U; },
      [](SafePosition& p) { p.high ^= 1U; },
      [](SafePosition& p) { p.cpw_only_offset = -p.cpw_only_offset; },
      [](SafePosition& p) { p.cpw_only_turns ^= std::uint64_t{1} << 40U; },
  };
  const SafePosition whole{.value = 5, .low = 4, .high = 6, .cpw_only_offset = 3};
  for (const Change change : changes) {
    SafePosition other = whole;
    BISS_EXPECT(other == whole);
    change(other);
    BISS_EXPECT(!(other == whole));
  }
}

BISS_TEST(SafePosition, OfAFinerSpw_HasItsResolutionToo) {
  const RunPlan plan = plan_of("pos12,nE,nW,crc6+pos20,nE,nW,lc6,crc16");
  const auto [first, second] = positions_of(plan, {.cpw = 0x123, .spw = 0x124'56});
  BISS_EXPECT(first == second);
  BISS_EXPECT_EQ(first.value, 0x124'56U);
  BISS_EXPECT_EQ(first.low, 0x123'00U);
  BISS_EXPECT_EQ(first.high, 0x125'FFU);
  BISS_EXPECT_EQ(first.cpw_only_offset, -1);
  BISS_EXPECT_EQ(control_position(plan, first), 0x123U);
}

// Whichever word has the bits that are wrong but accepted: the true position is within the bounds.
BISS_TEST(SafePosition, TruePosition_IsWithinTheBoundsIfOneWordIsRight) {
  BISS_RANDOM(random, 0x5AFE'0020);
  for (const std::uint8_t compare : {std::uint8_t{0}, std::uint8_t{7}, std::uint8_t{10}}) {
    const SafetySetup setup{.comparison = {.compare_bits = compare}};
    const RunPlan plan = plan_of("mt3,st14,nE,nW,crc6+mt3,st10,nE,nW,lc6,crc16", setup);
    const ChannelFormat& cpw = plan.format().channel_list[0];
    const ChannelFormat& spw = plan.format().channel_list[1];
    for (std::uint64_t left = test::rounds(20'000, 2'000); left != 0; --left) {
      const std::uint64_t place = random.bits(17);
      test::SafetyWords words{.cpw = place, .spw = spw_position(cpw, spw, place)};
      // One word is somewhere else.
      (random.flip() ? words.cpw : words.spw) = random.bits(13);
      const FrameBits bits = test::bits_of(plan, words);
      const test::Findings<RunPlan> findings(plan, bits.view());
      if (findings.first.cause != safe) continue;
      const auto [first, second] = positions_of(plan, words);
      BISS_EXPECT(first == second);
      const std::uint64_t truth = spw_position(cpw, spw, place);
      const bool wraps = first.low > first.high;
      const bool from_low = truth >= first.low;
      const bool to_high = truth <= first.high;
      BISS_EXPECT(wraps ? from_low || to_high : from_low && to_high) << place;
      BISS_EXPECT_EQ(control_position(plan, first), words.cpw);
    }
  }
}

}  // namespace biss::safety_evaluation_test
