#include "decode/check.hpp"

#include <gtest/gtest.h>

#include <string>
#include <string_view>

#include "biss/control/control_frame.hpp"
#include "biss/eds/bank.hpp"
#include "biss/frame/format_text.hpp"
#include "decode/test_line.hpp"
#include "decode/test_rules.hpp"

namespace biss::decode {
namespace check_test {

// The control frames that the protocol's rules give: reads of 0x42, 0x43, 0x7E, a write to 0x02.
constexpr std::string_view read_42[2] = {"11000100001001111010000000000000",
                                         "10000000000000001010110001001000"};
constexpr std::string_view read_43[2] = {"11000100001101001010000000000000",
                                         "10000000000000001010001111010110"};
constexpr std::string_view read_7e[2] = {"11000111111011111010000000000000",
                                         "10000000000000001010110100110100"};
constexpr std::string_view write_02[2] = {"11000000001000000110101010100100",
                                          "10000000000000000110101010100100"};

std::string bits(unsigned value, unsigned count) {
  std::string text;
  for (unsigned i = count; i-- > 0;) text += (value >> i & 1U) != 0 ? '1' : '0';
  return text;
}

std::string header_of(unsigned address) {
  const auto header = register_header(0, address);
  return "1" + bits(header, 11) + bits(header_crc(header), 4);
}

std::string with_flip(std::string_view text, std::size_t index) {
  std::string flipped(text);
  flipped[index] = flipped[index] == '0' ? '1' : '0';
  return flipped;
}

// A device at 1 MHz, requested every 100 us.
struct Bench {
  explicit Bench(std::string_view format = {}, const DeviceTiming& timing = {})
      : check({.format = format.empty() ? std::nullopt : std::optional(*parse_format(format)),
               .timing = timing}) {}

  Cycle cycle(bool cds = false, bool cdm = false) const {
    Cycle made;
    made.time = static_cast<std::int64_t>(number) * microseconds(100);
    made.period = microseconds(1);
    made.line_delay = nanoseconds(100);
    made.ack = microseconds(3);
    made.release = microseconds(20) + nanoseconds(100);
    made.rising_edges = 40;
    made.raw.append(true);
    made.raw.append(cds);
    made.cdm = cdm;
    return made;
  }
  void push(const Cycle& made) { check.push(number++, made); }
  void push_status(CycleStatus status) {
    Cycle made = cycle();
    made.status = status;
    push(made);
  }
  void zeros(unsigned count = 14) {
    for (unsigned i = 0; i < count; ++i) push(cycle());
  }
  // The CDS bit k comes one cycle after the CDM bit k.
  void access(std::string_view cdm, std::string_view cds) {
    for (std::size_t k = 0; k <= cds.size() || k < cdm.size(); ++k) {
      push(cycle(k >= 1 && k <= cds.size() && cds[k - 1] == '1', k < cdm.size() && cdm[k] == '1'));
    }
    zeros();
  }
  void access(const std::string_view (&both)[2]) { access(both[0], both[1]); }
  void read(unsigned address, unsigned value) {
    const auto data = static_cast<std::uint8_t>(value);
    access(header_of(address) + "101" + std::string(13, '0'),
           "1" + std::string(15, '0') + "101" + bits(data, 8) + bits(byte_crc(data), 4) + "0");
  }
  void write(unsigned address, unsigned value) {
    const auto data = static_cast<std::uint8_t>(value);
    const std::string tail = "011" + bits(data, 8) + bits(byte_crc(data), 4) + "0";
    access(header_of(address) + tail, "1" + std::string(15, '0') + tail);
  }
  std::string_view verdict(Rule rule) const { return name_of(check.result(rule).verdict); }
  std::string failing() const { return test::failing_rules(check); }

  Check check;
  std::uint64_t number = 0;
};

TEST(Check, NothingSeen_NothingJudged) {
  Bench bench;
  bench.check.finish();
  for (std::size_t i = 0; i < rule_count; ++i) {
    EXPECT_EQ(bench.verdict(static_cast<Rule>(i)), "not_judged") << i;
  }
}

TEST(Check, GoodAccesses_PassTheirRules) {
  Bench bench;
  bench.zeros();
  bench.access(read_42);
  bench.access(read_43);
  bench.access(read_7e);
  bench.read(0x7F, 0x43);
  bench.access(write_02);
  EXPECT_EQ(bench.failing(), "");
  for (const Rule rule :
       {Rule::frame_structure, Rule::ack_shortest, Rule::ack_longest, Rule::timeout_shortest,
        Rule::timeout_longest, Rule::line_delay, Rule::slo_idle, Rule::cds_idle, Rule::id_answer,
        Rule::id_pattern, Rule::rw_pattern, Rule::data_crc, Rule::write_start, Rule::write_echo,
        Rule::busy, Rule::next_register, Rule::manufacturer}) {
    EXPECT_EQ(bench.verdict(rule), "pass") << text_of(rule).name;
  }
  for (const Rule rule : {Rule::frame_crc, Rule::header_damaged, Rule::refusal, Rule::profile,
                          Rule::data_sheet, Rule::control_reset}) {
    EXPECT_EQ(bench.verdict(rule), "not_judged") << text_of(rule).name;
  }
}

TEST(Check, OneManufacturerByte_IsNotJudged) {
  Bench bench;
  bench.zeros();
  bench.access(read_7e);
  EXPECT_EQ(bench.verdict(Rule::manufacturer), "not_judged");
}

TEST(Check, CdsBesideAnAccess_FailsInThatCycle) {
  Bench bench;
  bench.zeros(20);
  bench.push(bench.cycle(true));
  EXPECT_EQ(bench.failing(), "cds_idle");
  EXPECT_EQ(bench.check.result(Rule::cds_idle).cycle, 20U);
}

TEST(Check, CdsBeforeFourteenZeros_MayBelongToAnAccess) {
  Bench bench;
  bench.zeros(5);
  bench.push(bench.cycle(true));
  EXPECT_EQ(bench.failing(), "");
}

// Bit `k` of CDS in a good access is inverted; `fails` is the rule that reports it.
struct Turned {
  const std::string_view (&access)[2];
  std::size_t k;
  std::string_view fails;
};

class CheckTurned : public testing::TestWithParam<std::size_t> {};
const Turned turned[] = {
    {read_42, 0, "id_answer"},    {read_42, 4, "id_pattern"}, {read_42, 16, "refusal"},
    {write_02, 16, "rw_pattern"}, {read_42, 20, "data_crc"},  {write_02, 18, "write_start"},
    {write_02, 22, "write_echo"},
};
TEST_P(CheckTurned, Bit_FailsItsRule) {
  const Turned& each = turned[GetParam()];
  Bench bench;
  bench.zeros();
  bench.access(each.access[0], with_flip(each.access[1], each.k));
  EXPECT_EQ(bench.failing(), each.fails);
  for (std::size_t i = 0; i < rule_count; ++i) {
    const RuleResult result = bench.check.result(static_cast<Rule>(i));
    if (result.verdict != Verdict::fail) continue;
    EXPECT_EQ(result.cycle, 14U);
  }
}
INSTANTIATE_TEST_SUITE_P(Bits, CheckTurned, testing::Range(std::size_t{0}, std::size(turned)));

TEST(Check, ProperRefusals_Pass) {
  Bench bench;
  bench.zeros();
  bench.access(header_of(0x20) + "101" + std::string(13, '0'), "1" + std::string(15, '0') + "110");
  bench.access(header_of(0x20) + "011" + std::string(13, '0'), "1" + std::string(15, '0') + "000");
  bench.access(read_42);
  EXPECT_EQ(bench.failing(), "");
  EXPECT_EQ(bench.check.result(Rule::refusal).cases, 2U);
  EXPECT_EQ(bench.verdict(Rule::control_reset), "pass");
}

TEST(Check, MandatoryRegisterRefused_Fails) {
  Bench bench;
  bench.zeros();
  bench.access(header_of(0x7E) + "101" + std::string(13, '0'), "1" + std::string(15, '0') + "110");
  EXPECT_EQ(bench.failing(), "manufacturer");
}

TEST(Check, DamagedHeader_SilenceIsRight_AnAnswerIsNot) {
  for (const bool answers : {false, true}) {
    Bench bench;
    bench.zeros();
    bench.access(with_flip(read_42[0], 7), "1" + std::string(15, '0') + (answers ? "10" : "00"));
    bench.access(read_42);
    EXPECT_EQ(bench.verdict(Rule::header_damaged), answers ? "fail" : "pass");
    EXPECT_EQ(bench.failing(), answers ? "header_damaged" : "");
  }
}

TEST(Check, NoAnswerBehindABrokenAccess_FailsTheReset) {
  Bench bench;
  bench.zeros();
  bench.access(read_42);
  bench.access(with_flip(read_42[0], 7), "1");
  bench.access(read_42[0], "");
  EXPECT_EQ(bench.failing(), "id_answer control_reset");
}

TEST(Check, RefusedBehindPZero_Fails) {
  Bench bench;
  bench.zeros();
  bench.access(read_42);
  bench.access(header_of(0x43) + "101" + std::string(13, '0'), "1" + std::string(15, '0') + "110");
  EXPECT_EQ(bench.failing(), "next_register");
}

TEST(Check, BusyBeyondTwentyMilliseconds_Fails) {
  for (const std::size_t late : {199U, 200U, 201U}) {
    Bench bench;
    bench.zeros();
    bench.access(header_of(0x42) + "10" + std::string(late + 1, '1') + std::string(13, '0'),
                 "1" + std::string(15, '0') + "10" + std::string(late, '0') +
                     std::string(read_42[1].substr(18)));
    EXPECT_EQ(bench.failing(), late > 200 ? "busy" : "") << late;
    const auto result = bench.check.result(Rule::busy);
    ASSERT_TRUE(result.measured);
    EXPECT_EQ(result.measured->worst, (static_cast<std::int64_t>(late) * microseconds(100)).count);
    EXPECT_EQ(result.measured->limit, milliseconds(20).count);
  }
}

TEST(Check, Timeout_IsJudgedByTheRuleOfTheDevice) {
  DeviceTiming adaptive;
  adaptive.timeout = {.rule = TimeoutRule::adaptive, .time = nanoseconds(300)};
  DeviceTiming fixed;
  fixed.timeout = {.rule = TimeoutRule::fixed, .time = microseconds(20)};
  struct Case {
    DeviceTiming timing;
    std::int64_t timeout_ns;
    std::string_view shortest, longest;
  };
  const Case cases[] = {
      {{}, 1'500, "pass", "pass"},           {{}, 1'400, "marginal", "pass"},
      {{}, 1'000, "fail", "pass"},           {{}, 40'000, "pass", "pass"},
      {{}, 41'000, "pass", "fail"},          {adaptive, 1'500, "pass", "pass"},
      {adaptive, 1'900, "pass", "marginal"}, {adaptive, 20'000, "pass", "fail"},
      {fixed, 12'000, "fail", "pass"},       {fixed, 20'000, "pass", "pass"},
      {fixed, 20'300, "pass", "fail"},
  };
  for (const Case& each : cases) {
    Bench bench({}, each.timing);
    Cycle cycle = bench.cycle();
    cycle.release = nanoseconds(each.timeout_ns) + *cycle.line_delay;
    bench.push(cycle);
    EXPECT_EQ(bench.verdict(Rule::timeout_shortest), each.shortest) << each.timeout_ns;
    EXPECT_EQ(bench.verdict(Rule::timeout_longest), each.longest) << each.timeout_ns;
  }
}

TEST(Check, Ack_IsOneClockToFortyMicroseconds) {
  const auto verdicts = [](std::int64_t ack_ns) {
    Bench bench;
    Cycle cycle = bench.cycle();
    cycle.ack = nanoseconds(ack_ns);
    bench.push(cycle);
    return std::string(bench.verdict(Rule::ack_shortest)) + " " +
           std::string(bench.verdict(Rule::ack_longest));
  };
  EXPECT_EQ(verdicts(1'000), "pass pass");
  EXPECT_EQ(verdicts(800), "marginal pass");
  EXPECT_EQ(verdicts(500), "fail pass");
  EXPECT_EQ(verdicts(40'000), "pass pass");
  EXPECT_EQ(verdicts(40'200), "pass marginal");
  EXPECT_EQ(verdicts(41'000), "pass fail");
}

TEST(Check, StatusOfFrames_FailsItsRule) {
  const auto failing = [](CycleStatus status) {
    Bench bench;
    bench.zeros(2);
    bench.push_status(status);
    return bench.failing();
  };
  EXPECT_EQ(failing(CycleStatus::stop_bit), "frame_structure");
  EXPECT_EQ(failing(CycleStatus::cds), "frame_structure");
  EXPECT_EQ(failing(CycleStatus::no_start), "frame_structure start");
  EXPECT_EQ(failing(CycleStatus::no_response), "frame_structure start");
  EXPECT_EQ(failing(CycleStatus::response_range), "line_delay");
  EXPECT_EQ(failing(CycleStatus::not_ready), "");  // 60 us after the last edge is too early
  for (const CycleStatus status : {CycleStatus::truncated, CycleStatus::cut_end,
                                   CycleStatus::ma_clock, CycleStatus::unknown_level}) {
    EXPECT_EQ(failing(status), "") << name_of(status);
  }
}

TEST(Check, NoRequestHasStart_FailsStart) {
  for (const CycleStatus status : {CycleStatus::no_response, CycleStatus::no_start}) {
    Bench bench("pos26,nE,nW,crc6");
    for (int i = 0; i < 3; ++i) bench.push_status(status);
    EXPECT_EQ(bench.failing(), "");
    bench.check.finish();
    EXPECT_EQ(bench.failing(), "frame_structure start");
    const RuleResult start = bench.check.result(Rule::start);
    EXPECT_EQ(start.cases, 3U);
    EXPECT_EQ(start.cycle, 0U);
    EXPECT_EQ(start.note, name_of(status));
    EXPECT_EQ(bench.check.result(Rule::ack_longest).verdict, Verdict::not_judged);
  }
}

TEST(Check, RequestWithoutStartBesideLongerOnes_MayBeTooShort) {
  for (const CycleStatus answered : {CycleStatus::unchecked, CycleStatus::truncated}) {
    Bench bench;
    Cycle shorter = bench.cycle();
    shorter.status = CycleStatus::no_start;
    shorter.rising_edges = 4;
    bench.push(shorter);
    bench.push_status(answered);
    bench.check.finish();
    EXPECT_EQ(bench.failing(), "") << name_of(answered);
  }
}

TEST(Check, NoFrameJudged_NotesSayWhy) {
  const auto notes = [](CycleStatus status) {
    Bench bench("pos26,nE,nW,crc6");
    bench.push_status(status);
    bench.check.finish();
    EXPECT_EQ(bench.check.result(Rule::sign_of_life).note, "the format has no sign of life");
    EXPECT_EQ(bench.check.result(Rule::id_answer).note, "no case");
    EXPECT_EQ(bench.check.result(Rule::nE).note, bench.check.result(Rule::start).note);
    return bench.check.result(Rule::frame_structure).note;
  };
  EXPECT_EQ(notes(CycleStatus::truncated), "every request ends before the last bit of the frame");
  EXPECT_EQ(notes(CycleStatus::ma_clock), "no request shows a frame");
}

TEST(Check, WrongCrc_FailsItsRule) {
  Bench bench("pos26,nE,nW,crc6");
  Cycle cycle = bench.cycle();
  cycle.crc_ok[0] = true;
  bench.push(cycle);
  EXPECT_EQ(bench.verdict(Rule::frame_crc), "pass");
  cycle.crc_ok[0] = false;
  cycle.status = CycleStatus::crc;
  bench.push(cycle);
  EXPECT_EQ(bench.failing(), "frame_crc");
  EXPECT_EQ(bench.check.result(Rule::frame_crc).cycle, 1U);
}

TEST(Check, SloStaysLow_FailsOnceItHadTime) {
  Bench bench;
  bench.zeros(2);
  bench.number += 2;
  bench.push_status(CycleStatus::not_ready);
  EXPECT_EQ(bench.failing(), "slo_idle");
}

TEST(Check, ProfileIdentifier_IsHeldAgainstTheFormat) {
  for (const bool same : {true, false}) {
    Bench bench(same ? "pos28,nE,nW,crc6" : "pos26,nE,nW,crc6");
    bench.zeros();
    bench.access(read_42);
    EXPECT_EQ(bench.verdict(Rule::profile), "not_judged");
    bench.access(read_43);
    EXPECT_EQ(bench.verdict(Rule::profile), same ? "pass" : "fail");
  }
}

TEST(Check, ProfileIdentifier_WithoutFormatIsHeldAgainstTheFrames) {
  for (const bool same : {true, false}) {
    Bench bench;
    bench.zeros();
    bench.access(read_42);
    bench.access(read_43);
    const std::string_view sent = same ? "pos28,nE,nW,crc6" : "pos30,nE,nW,crc6";
    for (const Cycle& cycle : [&] {
           test::TestLine line;
           line.request({}, 0x123456, sent);
           return test::decode(line, {});
         }()) {
      bench.push(cycle);
    }
    EXPECT_EQ(bench.verdict(Rule::profile), same ? "pass" : "fail");
  }
}

TEST(Check, DataSheetWithWrongSum_HasOneFindingMore) {
  std::uint64_t findings[2]{};
  for (const unsigned wrong : {0U, 1U}) {
    EdsBank bank{};
    bank[0] = 1;
    bank[1] = 1;
    bank[0x11] = 1;
    bank[0x3F] = static_cast<std::uint8_t>(eds_checksum(bank) + wrong);
    Bench bench;
    bench.zeros();
    bench.read(0x41, 2);
    bench.write(0x40, 2);
    for (unsigned i = 0; i < 63; ++i) bench.read(i, bank[i]);
    EXPECT_EQ(bench.verdict(Rule::data_sheet), "not_judged");
    bench.read(63, bank[63]);
    const RuleResult result = bench.check.result(Rule::data_sheet);
    EXPECT_EQ(bench.failing(), "data_sheet");
    EXPECT_NE(result.note, "");
    findings[wrong] = result.faults;
  }
  EXPECT_EQ(findings[1], findings[0] + 1);
}

TEST(Check, DataSheetInABankOfWhichBselIsReadLater_IsJudgedFromThen) {
  Bench bench;
  bench.zeros();
  bench.read(0x41, 2);
  for (unsigned i = 0; i < 64; ++i) bench.read(i, 0x55);
  EXPECT_EQ(bench.verdict(Rule::data_sheet), "not_judged");
  bench.read(0x40, 2);
  EXPECT_EQ(bench.verdict(Rule::data_sheet), "fail");
}

TEST(CycleRelease, IsTheTimeoutAndTheLineDelay) {
  test::TestLine line;
  for (const auto ending :
       {test::Ending::idle_high, test::Ending::low_until_timeout, test::Ending::low_until_next}) {
    line.request({.timeout = nanoseconds(13'500), .ending = ending}, 77);
  }
  const auto cycles = test::decode(line);
  ASSERT_EQ(cycles.size(), 3U);
  for (const Cycle& cycle : cycles) {
    EXPECT_EQ(cycle.release, nanoseconds(13'600)) << name_of(cycle.status);
  }
}

TEST(Check, RightFrameWithoutTheClockOfStop_FailsStopClock) {
  for (const bool stop : {true, false}) {
    Bench bench("pos26,nE,nW,crc6");
    Cycle made = bench.cycle();
    made.crc_ok[0] = true;
    made.frame.emplace();
    made.frame->channel_count = 1;
    made.frame->stop_seen = stop;
    bench.push(made);
    bench.push(bench.cycle());
    EXPECT_EQ(bench.failing(), stop ? "" : "stop_clock");
    EXPECT_EQ(bench.verdict(Rule::stop), stop ? "pass" : "not_judged");
  }
}

DeviceTiming with_cycle_timeout() {
  DeviceTiming timing;
  timing.timeout = {TimeoutRule::cycle, nanoseconds(31'250)};
  timing.cycle_min = nanoseconds(31'250);
  return timing;
}

// A whole request takes 40 us here.
TEST(Check, RequestSoonAfterAnAbortedOne_FailsReset) {
  for (const std::int64_t after : {12, 35, 39, 40, 60}) {
    Bench bench({}, with_cycle_timeout());
    bench.push(bench.cycle());
    Cycle aborted = bench.cycle();
    aborted.status = CycleStatus::truncated;
    aborted.rising_edges = 10;
    bench.push(aborted);
    Cycle next = bench.cycle();
    next.time = aborted.time + microseconds(after);
    bench.push(next);
    EXPECT_EQ(bench.verdict(Rule::reset), after < 40 ? "fail" : "pass") << after;
    EXPECT_EQ(bench.check.result(Rule::reset).cycle, 1U);
  }
}

TEST(Check, MaLowAfterAnAbortedRequest_FailsReset) {
  Bench bench({}, with_cycle_timeout());
  bench.push(bench.cycle());
  Cycle aborted = bench.cycle(false, true);
  aborted.status = CycleStatus::no_start;
  aborted.rising_edges = 3;
  bench.push(aborted);
  EXPECT_EQ(bench.verdict(Rule::reset), "fail");
}

// At 80 kHz a whole request takes longer than 80 us: the encoder may be busy for so long.
TEST(Check, SloLowAfterACutRequest_IsNotTheFaultOfTheDevice) {
  for (const bool cut : {true, false}) {
    Bench bench;
    const auto slow = [&](std::int64_t time, CycleStatus status, std::uint32_t edges) {
      Cycle made = bench.cycle();
      made.time = microseconds(time);
      made.period = nanoseconds(12'500);
      made.status = status;
      made.rising_edges = edges;
      bench.push(made);
    };
    slow(0, CycleStatus::unchecked, 40);
    slow(1'000, cut ? CycleStatus::truncated : CycleStatus::unchecked, cut ? 5 : 40);
    slow(cut ? 1'150 : 1'700, CycleStatus::not_ready, 40);
    EXPECT_EQ(bench.verdict(Rule::slo_idle), cut ? "pass" : "fail");
  }
}

std::string_view counter_verdict(bool renishaw, std::uint64_t after_63) {
  CheckSetup setup;
  setup.format = parse_format("pos28,nE,nW,lc6,crc16").value();
  setup.renishaw_cables = renishaw;
  Check check(setup);
  std::uint64_t number = 0;
  for (const std::uint64_t counter : {std::uint64_t{62}, std::uint64_t{63}, after_63}) {
    Cycle made = Bench().cycle();
    made.time = static_cast<std::int64_t>(number) * microseconds(100);
    made.frame.emplace();
    made.frame->channel_count = 1;
    made.frame->channel_list[0].life_counter = static_cast<std::uint8_t>(counter);
    check.push(number++, made);
  }
  return name_of(check.result(Rule::counter_values).verdict);
}

TEST(Check, SixtyFourValuesOfTheSignOfLife_AreMarginalForRenishaw) {
  EXPECT_EQ(counter_verdict(true, 0), "marginal");
  EXPECT_EQ(counter_verdict(true, 1), "pass");
  EXPECT_EQ(counter_verdict(false, 0), "not_judged");
}

}  // namespace check_test
}  // namespace biss::decode
