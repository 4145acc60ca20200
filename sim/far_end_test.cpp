#include "sim/far_end.hpp"

#include <gtest/gtest.h>

#include <set>
#include <string>

#include "biss/frame/format_text.hpp"
#include "biss/master/request.hpp"
#include "sim/fault_text.hpp"
#include "sim/line.hpp"

namespace biss::sim {
namespace far_end_test {

using Master = RequestCycle<FrameCodec<>>;

constexpr Picoseconds period = nanoseconds(200);

LineSetup line_setup(const char* format = "pos26,nE,nW,crc6") {
  LineSetup setup;
  setup.format = parse_format(format).value();
  setup.clock = megahertz(5);
  setup.ma_delay = nanoseconds(130);
  setup.slo_delay = nanoseconds(170);
  setup.internal_delay = nanoseconds(42);
  setup.interval = microseconds(100);
  setup.processing = microseconds(3);
  return setup;
}

FarEndSetup far_setup(const LineSetup& line) {
  return {.line = line, .processing_max = line.processing};
}

// A master of the core at the end of a FarEnd.
class Bench {
 public:
  Bench(FarEnd& far, const LineSetup& line, Picoseconds clock_period = period)
      : far_(far), master_(FrameCodec<>(line.format), setup_of(line, clock_period)) {}

  // A request at `begin`, whatever SLO is, as Line does; then until `end`.
  const Master::Reading& request(Picoseconds begin, Picoseconds end) {
    run(begin);
    const bool seen = out_.slo || !master_.ready_by_time(begin);
    StepOutput ma = master_.begin(begin, seen, false);
    if (out_.slo != seen) ma = master_.step(begin, out_.slo);
    out_ = far_.step(begin, ma.level, true);
    while (!master_.done()) {
      now_ = std::min(ma.deadline, out_.deadline);
      out_ = far_.step(now_, ma.level, true);
      ma = master_.step(now_, out_.slo);
      out_ = far_.step(now_, ma.level, true);
    }
    ma_ = ma.level;
    reading_ = master_.reading();
    faults_ = far_.cycle()->faults;
    run(end);
    sent_ = far_.cycle()->sent;
    return reading_;
  }
  const Master::Reading& reading() const { return reading_; }
  const Frame& sent() const { return sent_; }
  FaultSet faults() const { return faults_; }
  const FarEndOutput& out() const { return out_; }

 private:
  static MasterSetup setup_of(const LineSetup& line, Picoseconds clock_period) {
    MasterSetup setup;
    setup.period = clock_period;
    setup.timing = line.timing;
    setup.trust_cycle_time = true;
    setup.low_time = clock_period / 2;
    return setup;
  }
  void run(Picoseconds end) {
    while (out_.deadline < end) out_ = far_.step(out_.deadline, ma_, true);
  }

  FarEnd& far_;
  Master master_;
  FarEndOutput out_{true, true, never};
  Picoseconds now_{};
  bool ma_ = true;
  Master::Reading reading_;
  Frame sent_;
  FaultSet faults_ = 0;
};

std::string text_of(const Master::Reading& reading) {
  if (!reading.frame.ok()) return std::string(name_of(reading.frame.error().cause));
  std::string text;
  for (const Channel& channel : reading.frame->channels()) {
    text += std::to_string(channel.position) + (channel.nE ? "" : " E") + (channel.nW ? "" : " W") +
            ' ' + std::to_string(channel.life_counter) + ';';
  }
  return text + std::to_string(reading.ack_clocks);
}

std::string text_of(const Frame& frame) {
  std::string text;
  for (const Channel& channel : frame.channels()) text += std::to_string(channel.position) + ';';
  return text;
}

// A clock that never rests, on a cable in which 4000 edges are on their way.
TEST(FarEnd, ThousandsOfEdgesOnTheirWay_ArriveInOrderAndOnTime) {
  LineSetup line = line_setup();
  line.ma_delay = nanoseconds(200'010);
  FarEnd far(far_setup(line));
  constexpr int in_flight = 4'001;
  for (int edge = 1; edge < 4 * in_flight; ++edge) {
    const bool ma = edge % 2 == 0;
    const FarEndOutput out = far.step(nanoseconds(50) * edge, ma, true);
    const int arrived = edge - in_flight;
    ASSERT_EQ(out.ma, arrived <= 0 || arrived % 2 == 0) << edge;
  }
}

// Both ways of simulating a line agree, with each kind of fault.
TEST(FarEnd, EachFault_GivesWhatTheLineGives) {
  std::size_t damaged = 0;
  for (std::size_t k = 0; k < simulated_fault_count; ++k) {
    LineSetup setup = line_setup("pos26,nE,nW,crc6+pos20,nE,nW,lc6,crc16");
    const FaultKind kind = fault_list[k].kind;
    setup.faults = {parse_fault(std::string(name_of(kind)) + ":0.3").value()};
    setup.seed = 7 + k;
    Line line(setup);
    FarEnd far(far_setup(setup));
    Bench bench(far, setup);
    std::set<std::string> faulty;
    for (int i = 0; i < 40; ++i) {
      const SimulatedCycle& cycle = line.next();
      const auto& reading = bench.request(cycle.time, line.end());
      ASSERT_EQ(text_of(reading), text_of(cycle.reading)) << name_of(kind) << ' ' << i;
      ASSERT_EQ(sim::text_of(far.cycle()->faults), sim::text_of(cycle.faults))
          << name_of(kind) << ' ' << i;
      ASSERT_EQ(far.cycle()->injected, cycle.injected) << name_of(kind) << ' ' << i;
      ASSERT_EQ(far.cycle()->sampled, cycle.sampled) << name_of(kind) << ' ' << i;
      if (cycle.sampled) {
        ASSERT_EQ(text_of(bench.sent()), text_of(cycle.sent)) << name_of(kind) << ' ' << i;
      }
      if (cycle.faults != 0) ++damaged;
    }
  }
  EXPECT_GT(damaged, 200U);
}

TEST(FarEnd, ProcessingTime_ChangesFromRequestToRequest) {
  const LineSetup setup = line_setup();
  FarEndSetup far_with = far_setup(setup);
  far_with.processing_max = microseconds(6);
  FarEnd far(far_with);
  Bench bench(far, setup);
  std::set<unsigned> acks;
  for (int i = 0; i < 60; ++i) {
    const auto& reading = bench.request(microseconds(10 + 100 * i), microseconds(100 + 100 * i));
    ASSERT_TRUE(reading.frame.ok());
    acks.insert(reading.ack_clocks);
  }
  // 3 to 6 us at 5 MHz, START at the next clock.
  EXPECT_GE(*acks.begin(), 15U);
  EXPECT_LE(*acks.rbegin(), 31U);
  EXPECT_GE(acks.size(), 12U);
}

TEST(FarEnd, FilterOfMa_DelaysEdgesAndSwallowsPulses) {
  LineSetup setup = line_setup();
  setup.faults = {parse_fault("extra_clock:1").value()};
  FarEndSetup far_with = far_setup(setup);
  Picoseconds delay{};
  unsigned read = 0;
  // Pulses of extra_clock take 2 % to 12 % of a period, 4 ns to 24 ns.
  for (const Picoseconds filter : {Picoseconds{}, nanoseconds(25)}) {
    far_with.ma_filter = filter;
    FarEnd far(far_with);
    Bench bench(far, setup);
    unsigned good = 0;
    for (int i = 0; i < 20; ++i) {
      const auto& reading = bench.request(microseconds(10 + 100 * i), microseconds(100 + 100 * i));
      if (!reading.frame.ok()) continue;
      ++good;
      delay = reading.line_delay.value();
    }
    if (filter.count == 0) {
      read = good;
    } else {
      EXPECT_LT(read, 15U);
      EXPECT_EQ(good, 20U);
      EXPECT_EQ(delay, nanoseconds(130 + 170 + 42 + 25));
    }
  }
}

TEST(FarEnd, GivenPositions_AreSentOrMeanNoData) {
  const LineSetup setup = line_setup();
  FarEnd far(far_setup(setup));
  std::optional<std::uint64_t> position = 0x123'4567;
  far.encoder().set_positions(
      [](void* user, Picoseconds) { return *static_cast<std::optional<std::uint64_t>*>(user); },
      &position);
  Bench bench(far, setup);
  EXPECT_EQ(text_of(bench.request(microseconds(10), microseconds(100))), "19088743 0;15");
  position.reset();
  EXPECT_EQ(text_of(bench.request(microseconds(110), microseconds(200))), "0 E W 0;15");
  position = 1;
  far.set_flags(true, false);
  EXPECT_EQ(text_of(bench.request(microseconds(210), microseconds(300))), "1 W 0;15");
}

// A master whose clock is not the clock of the setup, and requests that do not reach the encoder.
TEST(FarEnd, RequestsAtAnotherClock_AreCounted) {
  LineSetup setup = line_setup();
  setup.faults = {parse_fault("no_answer@4").value(), parse_fault("cut@6").value()};
  for (const Picoseconds clock_period : {nanoseconds(100), nanoseconds(330), nanoseconds(1'000)}) {
    FarEnd far(far_setup(setup));
    Bench bench(far, setup, clock_period);
    for (unsigned i = 0; i < 12; ++i) {
      bench.request(microseconds(10 + 100 * i), microseconds(100 + 100 * i));
      EXPECT_EQ(far.cycle()->number, i) << clock_period.count;
      if (i == 4) {
        EXPECT_FALSE(bench.reading().frame.ok());
      }
    }
  }
}

// The clock changes while the line runs.
TEST(FarEnd, ClockThatSlowsDown_MakesNoRequests) {
  LineSetup setup = line_setup();
  setup.faults = {parse_fault("no_answer@4").value()};
  for (const Picoseconds slower : {nanoseconds(250), nanoseconds(300), nanoseconds(1'000)}) {
    FarEnd far(far_setup(setup));
    Bench first(far, setup);
    for (unsigned i = 0; i < 4; ++i) {
      EXPECT_TRUE(
          first.request(microseconds(10 + 100 * i), microseconds(100 + 100 * i)).frame.ok());
    }
    Bench second(far, setup, slower);
    for (unsigned i = 4; i < 8; ++i) {
      const auto& reading = second.request(microseconds(10 + 100 * i), microseconds(100 + 100 * i));
      EXPECT_EQ(far.cycle()->number, i) << slower.count;
      EXPECT_EQ(reading.frame.ok(), i != 4) << slower.count;
    }
  }
}

// An SPI master with a gap between its bytes, in the frame and after it.
TEST(FarEnd, GapsBetweenBytes_MakeNoRequests) {
  for (const Picoseconds delay : {Picoseconds{}, nanoseconds(130), microseconds(2)}) {
    for (const Picoseconds gap : {nanoseconds(50), nanoseconds(400), microseconds(3)}) {
      LineSetup setup = line_setup();
      setup.clock = megahertz(10);
      setup.ma_delay = delay;
      setup.timing.timeout = {TimeoutRule::fixed, microseconds(20)};
      FarEnd far(far_setup(setup));
      Picoseconds now = microseconds(100);
      for (unsigned i = 0; i < 4; ++i) {
        const Picoseconds begin = now;
        for (unsigned clock = 0; clock < 96; ++clock) {
          if (clock != 0 && clock % 8 == 0) now = now + gap;
          far.step(now, false, true);
          far.step(now + nanoseconds(50), true, true);
          now = now + nanoseconds(100);
        }
        ASSERT_EQ(far.cycle()->number, i) << delay.count << ' ' << gap.count;
        EXPECT_EQ(far.cycle()->begin, begin);
        EXPECT_TRUE(far.cycle()->sampled);
        now = now + microseconds(40);
      }
    }
  }
}

// With the rule `cycle` an encoder ignores a request that comes too early, but it is one.
TEST(FarEnd, RequestBeforeTheCycleTimeIsOver_IsCounted) {
  LineSetup setup = line_setup();
  setup.timing.timeout = {TimeoutRule::cycle, microseconds(62)};
  FarEnd far(far_setup(setup));
  Bench bench(far, setup);
  EXPECT_TRUE(bench.request(microseconds(10), microseconds(40)).frame.ok());
  for (unsigned clock = 0; clock < 20; ++clock) {
    far.step(microseconds(40) + clock * period, false, true);
    far.step(microseconds(40) + clock * period + period / 2, true, true);
  }
  EXPECT_EQ(far.cycle()->number, 1U);
  EXPECT_FALSE(far.cycle()->sampled);
  EXPECT_EQ(far.state(), SlaveState::early_request);
}

// Without an answer to look at, the first clock of a request shows a slower clock.
TEST(FarEnd, ForeignEncoderAndClockThatSlowsDown_MakeNoRequests) {
  FarEndSetup setup = far_setup(line_setup());
  setup.foreign_encoder = true;
  FarEnd far(setup);
  Picoseconds now = microseconds(100);
  unsigned requests = 0;
  for (const int clock_ns : {200, 1'000, 330, 100, 200}) {
    for (unsigned clock = 0; clock < 20; ++clock) {
      far.step(now, false, true);
      far.step(now + nanoseconds(clock_ns) / 2, true, true);
      now = now + nanoseconds(clock_ns);
      ASSERT_EQ(far.cycle()->number, requests) << clock_ns << ' ' << clock;
    }
    ++requests;
    now = now + microseconds(40);
  }
}

TEST(FarEnd, LateSteps_CatchUpWithWhatWasDue) {
  const LineSetup setup = line_setup();
  FarEnd far(far_setup(setup));
  FarEndOutput out = far.step(microseconds(1), true, true);
  EXPECT_EQ(out.deadline, never);
  out = far.step(microseconds(2), false, true);
  EXPECT_EQ(out.deadline, microseconds(2) + nanoseconds(130));
  ASSERT_NE(far.cycle(), nullptr);
  EXPECT_EQ(far.cycle()->begin, microseconds(2));
  far.step(microseconds(2) + nanoseconds(100), true, true);
  far.step(microseconds(2) + nanoseconds(200), false, true);
  far.step(microseconds(2) + nanoseconds(300), true, true);
  // ACK's edge arrives after 430 ns, SLO falls 212 ns later; the encoder is idle again long before.
  out = far.step(milliseconds(1), true, true);
  EXPECT_TRUE(out.slo);
  EXPECT_EQ(far.state(), SlaveState::idle);
  EXPECT_EQ(out.deadline, never);
}

// An encoder of the caller (here the encoder of the core) on the same cable.
TEST(FarEnd, ForeignEncoder_IsReadThroughTheCableAndItsFaults) {
  LineSetup setup = line_setup();
  setup.faults = {parse_fault("cut@1").value(), parse_fault("swap_slo@3").value()};
  FarEndSetup far_with = far_setup(setup);
  far_with.foreign_encoder = true;
  FarEnd far(far_with);
  struct Source {
    BasicFrame<max_channels> sample(Picoseconds) const {
      BasicFrame<max_channels> frame;
      frame.channel_count = 1;
      frame.channel_list[0].position = 4711;
      return frame;
    }
    static bool cds(bool) { return false; }
    static void cdm(bool) {}
  };
  Slave<FrameCodec<>, Source> slave(FrameCodec<>(setup.format), SlaveTiming{}, Source{});
  MasterSetup master_setup;
  master_setup.period = period;
  master_setup.timing = setup.timing;
  Master master(FrameCodec<>(setup.format), master_setup);
  std::string causes;
  StepOutput slo;
  FarEndOutput out{true, true, never};
  for (int i = 0; i < 8; ++i) {
    Picoseconds now = microseconds(10 + 100 * i);
    StepOutput ma = master.begin(now, true, false);
    const auto exchange = [&] {
      for (int again = 0; again < 3; ++again) {
        out = far.step(now, ma.level, slo.level);
        slo = slave.step(now, out.ma, false);
      }
    };
    exchange();
    while (now < microseconds(90 + 100 * i)) {
      const Picoseconds master_due = master.done() ? never : ma.deadline;
      now = std::min({master_due, out.deadline, slo.deadline, microseconds(90 + 100 * i)});
      exchange();
      if (!master.done()) ma = master.step(now, out.slo);
      exchange();
    }
    EXPECT_EQ(far.cycle()->number, static_cast<std::uint64_t>(i));
    EXPECT_FALSE(far.cycle()->sampled);
    causes += master.reading().frame.ok()
                  ? std::to_string(master.reading().frame->channel_list[0].position)
                  : std::string(name_of(master.reading().frame.error().cause));
    causes += ' ';
  }
  EXPECT_EQ(causes.substr(0, 5), "4711 ");
  EXPECT_NE(causes.find("no_response"), std::string::npos) << causes;
  EXPECT_TRUE(causes.ends_with("4711 ")) << causes;
}

TEST(FarEnd, Registers_ComeBackWithTheSupply) {
  LineSetup setup = line_setup();
  setup.faults = {parse_fault("brown_out@2").value()};
  setup.registers.resize(1);
  setup.registers[0].put(0x48, 0x11, RegisterProtection::read_write);
  FarEnd far(far_setup(setup));
  Bench bench(far, setup);
  bench.request(microseconds(10), microseconds(100));
  far.registers().value(0x48) = 0x22;
  bench.request(microseconds(110), microseconds(200));
  EXPECT_EQ(far.registers().value(0x48), 0x22);
  for (int i = 2; i < 8; ++i)
    bench.request(microseconds(10 + 100 * i), microseconds(100 + 100 * i));
  EXPECT_EQ(far.registers().value(0x48), 0x11);
}

TEST(FarEnd, FaultsThatChange_ApplyFromTheNextRequestOn) {
  LineSetup setup = line_setup();
  setup.faults = {parse_fault("no_answer:1").value()};
  FarEnd far(far_setup(setup));
  Bench bench(far, setup);
  std::string seen;
  for (int i = 0; i < 6; ++i) {
    if (i == 1) far.set_faults({});
    if (i == 3) far.set_faults({parse_fault("nE@3").value()});
    bench.request(microseconds(10 + 100 * i), microseconds(100 + 100 * i));
    seen += sim::text_of(far.cycle()->faults) + (bench.reading().frame.ok() ? "+ " : "- ");
    if (i == 0) {
      EXPECT_EQ(far.previous(), nullptr);
    } else {
      EXPECT_EQ(far.previous()->number, static_cast<std::uint64_t>(i - 1));
    }
  }
  EXPECT_EQ(seen, "no_answer- + + nE+ + + ");
  EXPECT_EQ(far.requests(), 6U);
}

// A loss of supply that was drawn ends while the supply is off, and the plug is pulled twice.
TEST(FarEnd, LastingFault_LastsUntilItIsReleased) {
  LineSetup setup = line_setup();
  setup.faults = {parse_fault("brown_out@2").value()};
  FarEnd far(far_setup(setup));
  Bench bench(far, setup);
  std::string seen;
  for (int i = 0; i < 14; ++i) {
    const Picoseconds between = microseconds(5 + 100 * i);
    if (i == 1) far.set_lasting(FaultKind::brown_out, true, between);
    if (i == 8) far.set_lasting(FaultKind::brown_out, false, between);
    if (i == 10 || i == 11) far.set_lasting(FaultKind::cut, true, between);
    if (i == 12) far.set_lasting(FaultKind::cut, false, between);
    bench.request(microseconds(10 + 100 * i), microseconds(100 + 100 * i));
    seen += bench.reading().frame.ok() ? '+' : '-';
    EXPECT_EQ(far.cycle()->faults != 0, seen.back() == '-') << i;
  }
  EXPECT_EQ(seen, "+-------++--++");
}

TEST(FarEnd, MotionThatChanges_IsSent) {
  const LineSetup setup = line_setup();
  FarEnd far(far_setup(setup));
  Bench bench(far, setup);
  far.encoder().hold(42);
  EXPECT_EQ(text_of(bench.request(microseconds(10), microseconds(100))), "42 0;15");
  EXPECT_EQ(far.encoder().position_at(microseconds(90)), 42U);
  far.set_motion(MotionKind::ramp);
  bench.request(microseconds(110), microseconds(200));
  const std::uint64_t ramp = far.cycle()->sent.channel_list[0].position;
  EXPECT_EQ(far.encoder().position_at(far.cycle()->sampled.value()), ramp);
  EXPECT_NE(ramp, far.encoder().position_at(microseconds(10)));
}

TEST(FaultText, RulesAndMistakes_AreTold) {
  EXPECT_EQ(parse_fault("flip@0x10,bit=7")->cycle, 16U);
  EXPECT_EQ(parse_fault("flip:0.5")->share, std::uint64_t{1} << 31U);
  EXPECT_EQ(parse_fault("flip:0.50000000000000000000000")->share, std::uint64_t{1} << 31U);
  EXPECT_EQ(parse_fault("flip:1.0")->share, std::uint64_t{1} << 32U);
  EXPECT_EQ(parse_fault("flip:0.000")->share, 0U);
  EXPECT_EQ(parse_fault("flop:1").error(), FaultTextError::kind);
  EXPECT_EQ(parse_fault("flips:1").error(), FaultTextError::kind);
  for (const char* text :
       {"", "flip", "flip:", "flip:2", "flip@-1", "flip@1,", "flip@1,bit", "flip@1,bit=1.2345",
        "flip@1,bit=0x10", "flip@1,bit=0X10", "flip:1.1", "flip:1.", "flip:1.0000000000001",
        "flip:0.5x", "flip@18446744073709551616"}) {
    EXPECT_EQ(parse_fault(text).error(), FaultTextError::form) << text;
  }
}

}  // namespace far_end_test
}  // namespace biss::sim
