// Every rule on requests, frames, signals and sequences, by a capture that breaks just this one.
#include "decode/rules.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <set>
#include <string>
#include <vector>

#include "biss/timing/renishaw.hpp"
#include "decode/check.hpp"
#include "decode/frame_rules.hpp"
#include "decode/sequence_rules.hpp"
#include "decode/test_line.hpp"
#include "decode/test_rules.hpp"

namespace biss::decode {
namespace rules_test {

using test::failing_rules;

constexpr std::string_view safety_format = "pos26,nE,nW,lc6,crc16";

void judge(Check& check, const std::vector<wire::Edge>& edges, const CheckSetup& setup) {
  std::uint64_t number = 0;
  Decoder decoder(
      CycleReader(
          setup.format, setup.timing,
          {.compensated = setup.compensated, .resolution = setup.resolution, .signal = true}),
      [&](const Cycle& cycle) { check.push(number++, cycle); });
  decoder.push(edges, {0, 1});
  decoder.finish(edges.back().time + milliseconds(1));
  check.finish();
}

CheckSetup setup_of(std::string_view format = test::usual_format, const DeviceTiming& timing = {}) {
  return {.format = *parse_format(format), .timing = timing};
}

// 10 requests, as alike as a rule needs them. `each` may change the shape of request k.
test::TestLine requests(const test::Shape& shape,
                        const std::function<void(int, test::Shape&, test::TestLine&)>& each = {}) {
  test::TestLine line;
  for (int k = 0; k < 10; ++k) {
    test::Shape changed = shape;
    if (each) each(k, changed, line);
    line.request(changed, 0x1234567);
  }
  return line;
}

// A frame with everything that may be wrong in it.
FrameBits frame_of(std::string_view format, const Channel& channel, bool cds = false) {
  const PlainCodec codec(*parse_format(format));
  Frame frame;
  frame.channel_count = 1;
  frame.lead_clocks = 1;
  frame.ack_clocks = 3;
  frame.cds = cds;
  frame.channel_list[0] = channel;
  return *encode_frame(frame, codec);
}

FrameBits with_last(FrameBits bits, bool last) {
  FrameBits changed;
  for (std::size_t i = 0; i + 1 < bits.size_bits(); ++i) changed.append(bits.view()[i]);
  changed.append(last);
  return changed;
}

// 10 requests; request 5 is answered with `bits`.
test::TestLine with_frame(const FrameBits& bits) {
  test::TestLine line;
  const test::Shape shape{};
  for (int k = 0; k < 10; ++k) {
    if (k == 5) {
      line.request(shape, bits);
    } else {
      line.request(shape, 77);
    }
  }
  return line;
}

// Moves the changes of SLO within each frame by what `late` returns for the change of this number.
void move_changes(test::TestLine& line, Picoseconds period,
                  const std::function<Picoseconds(int)>& late) {
  for (std::size_t r = 0; r < line.begins.size(); ++r) {
    const Picoseconds begin = line.ma[line.begins[r]].time;
    const Picoseconds end = begin + 39 * period;
    int number = 0;
    for (LevelChange& change : line.slo) {
      if (change.time > begin && change.time < end) change.time += late(number++);
    }
  }
}

// Renishaw's limits at 1 MHz, at which a frame takes longer than 31.25 us.
const test::Shape slow_renishaw{.timeout = nanoseconds(1'500), .ack_clocks = 4};

struct Breach {
  std::string fails;
  CheckSetup setup;
  std::function<test::TestLine()> line;
};

CheckSetup renishaw() {
  CheckSetup setup = setup_of(test::usual_format, renishaw_timing);
  setup.unidirectional = true;
  setup.renishaw_cables = true;
  return setup;
}

test::TestLine speeds(std::uint64_t step) {
  test::TestLine line;
  for (std::uint64_t k = 0; k < 10; ++k)
    line.request(test::Shape{}, k * 1'000 + (k >= 5 ? step : 0));
  return line;
}

test::TestLine lives(std::uint64_t wrong) {
  test::TestLine line;
  for (std::uint64_t k = 0; k < 100; ++k) {
    Channel channel;
    channel.position = k;
    channel.life_counter = static_cast<std::uint32_t>((k + (k >= 50 ? wrong : 0)) % 64);
    line.request(test::Shape{}, frame_of(safety_format, channel));
  }
  return line;
}

test::TestLine without_start() {
  FrameBits bits;
  bits.append(true);
  for (int i = 0; i < 40; ++i) bits.append(false);
  return with_frame(bits);
}

test::TestLine pulse_on(bool ma) {
  test::TestLine line = requests({});
  auto& levels = ma ? line.ma : line.slo;
  test::TestLine::add_pulse(levels, line.ma[line.begins[6]].time - microseconds(3),
                            nanoseconds(50));
  return line;
}

test::TestLine drifting() {
  return requests({}, [](int k, test::Shape& shape, test::TestLine&) {
    shape.line_delay = nanoseconds(k < 5 ? 100 : 700);
  });
}

test::TestLine moved(const std::function<Picoseconds(int)>& late) {
  test::TestLine line = requests({.line_delay = nanoseconds(300)});
  move_changes(line, microseconds(1), late);
  return line;
}

// The clock is half as fast again from the middle of each frame on.
test::TestLine faster() {
  test::TestLine line = requests(slow_renishaw);
  const auto warp = [&](std::vector<LevelChange>& changes, const std::vector<LevelChange>& ma) {
    for (LevelChange& change : changes) {
      Picoseconds begin{};
      for (const std::size_t first : line.begins) {
        if (ma[first].time <= change.time) begin = ma[first].time;
      }
      const Picoseconds late = change.time - begin - nanoseconds(20'750);
      if (begin.count != 0 && late.count > 0) change.time -= late / 3;
    }
  };
  const std::vector<LevelChange> ma = line.ma;
  warp(line.ma, ma);
  warp(line.slo, ma);
  return line;
}

// SLO falls while it is idle, and stays low; the master waits long enough before each request.
test::TestLine stuck_low() {
  test::TestLine line = requests({.gap = microseconds(150)});
  const Picoseconds fall = line.ma[line.begins[6]].time - microseconds(3);
  std::erase_if(line.slo, [&](const LevelChange& change) { return change.time >= fall; });
  line.slo.push_back(test::low_at(fall));
  return line;
}

std::vector<Breach> breaches() {
  using test::Shape;
  const CheckSetup usual = setup_of();
  CheckSetup uncompensated = usual;
  uncompensated.compensated = false;
  CheckSetup slow = usual;
  slow.speed_max = 100'000'000;
  CheckSetup one_way = usual;
  one_way.unidirectional = true;
  CheckSetup long_cycle = usual;
  long_cycle.timing.cycle_min = microseconds(80);
  const Channel good{};
  Channel in_error;
  in_error.nE = false;
  const auto with = [](const Shape& shape) { return [shape] { return requests(shape); }; };
  return {
      {"", usual, with({})},
      {"", renishaw(), with(slow_renishaw)},
      {"", setup_of(safety_format), [] { return lives(0); }},
      {"", slow, [] { return speeds(2'000); }},
      // Backwards, across zero.
      {"", slow, [] { return speeds((std::uint64_t{1} << 26U) - 6'000); }},
      {"speed", slow, [] { return speeds((std::uint64_t{1} << 26U) - 16'000); }},
      {"clock_max", usual, with({.period = nanoseconds(95), .line_delay = nanoseconds(20)})},
      {"clock_min", usual, with({.period = nanoseconds(12'700), .timeout = microseconds(25)})},
      {"cycle_min", long_cycle, with({})},
      {"clock_change", renishaw(), faster},
      {"duty", renishaw(), with([] {
         Shape shape = slow_renishaw;
         shape.high_percent = 35;
         return shape;
       }())},
      {"ma_level", usual, with({.high_percent = 3})},
      {"slo_idle", usual, stuck_low},
      {"ready", usual, with({.gap = nanoseconds(-1'000)})},
      {"ack_shortest", renishaw(), with([] {
         Shape shape = slow_renishaw;
         shape.ack_clocks = 2;
         return shape;
       }())},
      {"ack_longest", renishaw(), with([] {
         Shape shape = slow_renishaw;
         shape.ack_clocks = 18;
         return shape;
       }())},
      {"timeout_shortest", usual, with({.timeout = nanoseconds(1'100)})},
      {"timeout_longest", usual, with({.timeout = microseconds(42)})},
      {"line_delay", usual, with({.line_delay = microseconds(41)})},
      {"extra_clocks", renishaw(),
       with({.period = nanoseconds(200),
             .line_delay = nanoseconds(50),
             .timeout = nanoseconds(300),
             .extra_clocks = 120,
             .ack_clocks = 18})},
      {"missing_request", usual,
       [] {
         return requests({}, [](int k, Shape&, test::TestLine& line) {
           if (k == 7) line.now += line.ma[line.begins[6]].time - line.ma[line.begins[5]].time;
         });
       }},
      {"frame_structure start", usual, without_start},
      {"cds_zero", one_way, [=] { return with_frame(frame_of(test::usual_format, good, true)); }},
      {"frame_structure cds_zero", setup_of("pos26,nE,nW,crc6;cds0"),
       [=] { return with_frame(frame_of(test::usual_format, good, true)); }},
      {"frame_structure stop", usual,
       [=] { return with_frame(with_last(frame_of(test::usual_format, good), true)); }},
      {"line_delay_jitter", usual,
       [] { return moved([](int k) { return nanoseconds(k % 2 == 0 ? 0 : 280); }); }},
      {"sampling_margin", usual,
       [] { return moved([](int k) {
              return nanoseconds(k == 0 ? 0 : k == 5 ? -90 : 220);
            }); }},
      {"line_delay_drift", usual, drifting},
      {"cable", renishaw(), with([] {
         Shape shape = slow_renishaw;
         shape.line_delay = nanoseconds(1'350);
         return shape;
       }())},
      {"sampling_uncompensated", uncompensated, with({.line_delay = nanoseconds(400)})},
      {"glitch_ma", usual, [] { return pulse_on(true); }},
      {"glitch_slo", usual, [] { return pulse_on(false); }},
      {"nE", usual, [=] { return with_frame(frame_of(test::usual_format, in_error)); }},
      {"sign_of_life", setup_of(safety_format), [] { return lives(1); }},
      {"speed", slow, [] { return speeds(10'000); }},
  };
}

TEST(Rules, CapturesThatBreakOne_FailJustThis) {
  for (const Breach& breach : breaches()) {
    SCOPED_TRACE(breach.fails);
    Check check(breach.setup);
    judge(check, breach.line().edges(), breach.setup);
    EXPECT_EQ(failing_rules(check), breach.fails);
  }
}

// The rules on control communication and registers are broken in check_test.cpp.
TEST(Rules, OnRequestsFramesAndSignals_AreAllBroken) {
  std::set<std::string> broken;
  for (const Breach& breach : breaches()) {
    std::string names = breach.fails;
    for (std::size_t space = names.find(' '); space != std::string::npos; space = names.find(' ')) {
      broken.insert(names.substr(0, space));
      names.erase(0, space + 1);
    }
    broken.insert(names);
  }
  for (std::size_t i = 0; i < rule_count; ++i) {
    const auto rule = static_cast<Rule>(i);
    const bool of_control = rule >= Rule::slo_idle && rule <= Rule::control_reset;
    // Warnings, and broken in the tests of Check and of the command.
    const bool elsewhere = rule == Rule::nW || rule == Rule::frame_crc || rule >= Rule::stop_clock;
    if (of_control || elsewhere) continue;
    EXPECT_TRUE(broken.contains(std::string(text_of(rule).name))) << text_of(rule).name;
  }
}

TEST(Rules, Warning_IsMarginal) {
  Channel channel;
  channel.nW = false;
  const CheckSetup setup = setup_of();
  Check check(setup);
  judge(check, with_frame(frame_of(test::usual_format, channel)).edges(), setup);
  EXPECT_EQ(failing_rules(check), "");
  const RuleResult result = check.result(Rule::nW);
  EXPECT_EQ(result.verdict, Verdict::marginal);
  EXPECT_EQ(result.faults, 1U);
  EXPECT_EQ(result.cycle, 5U);
}

// With compensation a long cable is not a fault.
TEST(Rules, CableThatNeedsCompensation_IsMarginalForAMasterWithIt) {
  const CheckSetup setup = setup_of();
  Check check(setup);
  judge(check, requests({.line_delay = nanoseconds(400)}).edges(), setup);
  const RuleResult result = check.result(Rule::sampling_uncompensated);
  EXPECT_EQ(result.verdict, Verdict::marginal);
  ASSERT_TRUE(result.measured);
  EXPECT_EQ(result.measured->limit, 25'000);
  EXPECT_EQ(result.measured->worst, 10'000);
  EXPECT_EQ(result.measured->margin, -15'000);
}

// Captures of the same line, as analysers see it.
TEST(Rules, CoarseCapture_IsNotJudgedAndSaysWhatIsNeeded) {
  test::TestLine line = pulse_on(false);
  const auto verdict = [&](Picoseconds sample) {
    CheckSetup setup = setup_of();
    setup.resolution = sample;
    Check check(setup);
    test::TestLine seen = line;
    seen.ma = test::sampled(line.ma, sample);
    seen.slo = test::sampled(line.slo, sample);
    judge(check, seen.edges(), setup);
    const RuleResult result = check.result(Rule::glitch_slo);
    return std::string(name_of(result.verdict)) + ": " + result.note;
  };
  EXPECT_EQ(verdict(nanoseconds(20)), "fail: a level of SLO is too short for a bit");
  EXPECT_TRUE(verdict(nanoseconds(150))
                  .starts_with("not_judged: the capture is too coarse: its resolution is 150 ns, "
                               "needed are 12"))
      << verdict(nanoseconds(150));
}

// Two samples in a period: bits may be wrong, and that is not a fault of the encoder.
TEST(Rules, WrongBitsInACoarseCapture_AreNotJudged) {
  FrameBits bits = frame_of(test::usual_format, {});
  FrameBits damaged;
  for (std::size_t i = 0; i < bits.size_bits(); ++i) damaged.append(bits.view()[i] != (i == 20));
  const test::TestLine line = with_frame(damaged);
  for (const bool coarse : {false, true}) {
    CheckSetup setup = setup_of();
    setup.resolution = coarse ? nanoseconds(400) : nanoseconds(100);
    Check check(setup);
    judge(check, line.edges(), setup);
    EXPECT_EQ(check.result(Rule::frame_crc).verdict, coarse ? Verdict::not_judged : Verdict::fail);
  }
}

TEST(Tallies, ValueBeyondTheLimitByLessThanItsDoubt_IsMarginalWhateverElseWasSeen) {
  for (const bool first : {false, true}) {
    Tallies tallies({});
    const auto beyond = [&] { tallies.measure(Rule::ready, {100, 90, -10}, 20, 7); };
    if (first) beyond();
    tallies.measure(Rule::ready, {100, 105, 5}, 0, 3);
    if (!first) beyond();
    const RuleResult result = tallies.result(Rule::ready);
    EXPECT_EQ(result.verdict, Verdict::marginal);
    EXPECT_EQ(result.measured.value_or(Measured{}).worst, 90);
    EXPECT_EQ(result.cycle, 7U);
  }
}

TEST(Tallies, FaultAmongDoubtfulValues_IsTheOneReported) {
  Tallies tallies({});
  tallies.measure(Rule::ready, {100, 90, -10}, 20, 1);
  tallies.measure(Rule::ready, {100, 95, -5}, 0, 2);
  tallies.measure(Rule::ready, {100, 85, -15}, 20, 3);
  const RuleResult result = tallies.result(Rule::ready);
  EXPECT_EQ(result.verdict, Verdict::fail);
  EXPECT_EQ(result.faults, 1U);
  EXPECT_EQ(result.measured.value_or(Measured{}).margin, -5);
  EXPECT_EQ(result.cycle, 2U);
}

// The line delays of a good cycle and of one in which SLO falls at a wrong time.
RuleResult line_delay_beside(std::optional<Picoseconds> early) {
  Tallies tallies({});
  FrameRules rules(CheckSetup{}, tallies);
  Cycle cycle;
  cycle.period = microseconds(1);
  cycle.rising_edges = 40;
  cycle.line_delay = nanoseconds(50);
  rules.push(0, cycle);
  cycle.status = CycleStatus::response_range;
  cycle.line_delay.reset();
  cycle.early = early;
  rules.push(1, cycle);
  cycle.status = CycleStatus::ok;
  cycle.early.reset();
  cycle.line_delay = nanoseconds(40);
  rules.push(2, cycle);
  return tallies.result(Rule::line_delay);
}

TEST(Rules, SloThatFallsTooEarly_FailsWithItsTime) {
  const RuleResult result = line_delay_beside(nanoseconds(450));
  EXPECT_EQ(result.verdict, Verdict::fail);
  EXPECT_EQ(result.cycle, 1U);
  const Measured measured = result.measured.value_or(Measured{});
  EXPECT_EQ(measured.limit, 0);
  EXPECT_EQ(measured.worst, -450'000);
  EXPECT_EQ(measured.margin, -450'000);
}

TEST(Rules, SloThatFallsAtATimeThatIsNotKnown_FailsWithoutTheTimeOfAnotherCycle) {
  const RuleResult result = line_delay_beside({});
  EXPECT_EQ(result.verdict, Verdict::fail);
  EXPECT_EQ(result.cycle, 1U);
  EXPECT_FALSE(result.measured);
  EXPECT_EQ(result.note, "SLO falls too late");
}

TEST(RequestGaps, MultipleOfARegularInterval_IsCounted) {
  RequestGaps gaps;
  std::uint64_t missing = 0;
  for (const int interval : {100, 100, 101, 100, 100, 300, 100, 100, 199, 100}) {
    missing += gaps.push(microseconds(interval), {}).value_or(0);
  }
  EXPECT_EQ(missing, 3U);
}

// A master that changes its rate, or has none, leaves out nothing.
TEST(RequestGaps, OtherRateAndNoRate_AreNoGap) {
  for (const std::vector<int>& intervals :
       {std::vector<int>{100, 100, 100, 100, 100, 200, 200, 200, 200, 200},
        std::vector<int>{100, 200, 100, 200, 100, 200, 100, 200},
        std::vector<int>{100, 100, 100, 100, 100, 250, 100, 100},
        std::vector<int>{100, 100, 100, 100, 100, 1'100, 100, 100},
        std::vector<int>{100, 150, 220, 100, 90, 300, 100, 80}}) {
    RequestGaps gaps;
    for (const int interval : intervals) {
      EXPECT_EQ(gaps.push(microseconds(interval), {}).value_or(0), 0U);
    }
  }
}

// 100 ns low and high; a pulse of 10 ns leaves 30 and 60 ns of a level, which are not levels of MA.
TEST(LineSignal, PulseInALevelOfMa_IsOneAndNoLevel) {
  std::vector<LevelChange> ma;
  Picoseconds now = microseconds(1);
  bool high = false;
  for (const int level : {100, 100, 30, 10, 60, 100, 100, 100}) {
    ma.push_back({now, high ? wire::Level::high : wire::Level::low});
    high = !high;
    now += nanoseconds(level);
  }
  LineHistory slo;
  slo.push(test::high_at({}));
  const LineSignal signal =
      measure_signal({.ma = ma, .limit = now, .period = nanoseconds(200)}, slo);
  EXPECT_EQ(signal.pulse_max, nanoseconds(50));
  EXPECT_EQ(signal.ma_pulses, 1U);
  EXPECT_EQ(signal.ma_shortest, nanoseconds(100));
  EXPECT_FALSE(signal.ready) << "SLO was high from the beginning";
}

TEST(Rules, Names_AreDifferent) {
  std::set<std::string_view> names;
  for (std::size_t i = 0; i < rule_count; ++i) names.insert(text_of(static_cast<Rule>(i)).name);
  EXPECT_EQ(names.size(), rule_count);
}

}  // namespace rules_test
}  // namespace biss::decode
