#include "sim/line.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <optional>
#include <utility>
#include <vector>

#include "biss/catalogue/catalogue.hpp"
#include "biss/frame/format_text.hpp"

namespace biss::sim {
namespace line_test {

LineSetup setup_of(std::string_view format) {
  LineSetup setup;
  setup.format = *parse_format(format);
  setup.clock = megahertz(10);
  setup.ma_delay = nanoseconds(90);
  setup.slo_delay = nanoseconds(110);
  setup.internal_delay = picoseconds(42'500);
  return setup;
}

TEST(Line, EveryCycleWithoutFaults_ReadsWhatWasSent) {
  for (const char* format :
       {"pos26,nE,nW,crc6;cds0", "mt12,st20,nE,nW,lc6,crc16",
        "pos36,nE,nW,crc6+pos28,nE,nW,lc6,crc16;cds0", "pos1,crc3", "pad5,crc3+pos64,crc16"}) {
    Line line(setup_of(format));
    for (int i = 0; i < 100; ++i) {
      const SimulatedCycle& cycle = line.next();
      ASSERT_TRUE(cycle.reading.frame.ok()) << format;
      EXPECT_EQ(cycle.reading.frame->channel_list, cycle.sent.channel_list);
      EXPECT_EQ(cycle.reading.line_delay, picoseconds(242'500));
      EXPECT_EQ(cycle.faults, 0U);
    }
  }
}

// Each request has its own moment between the bounds of the type, the same for the same seed.
TEST(Line, SamplingMoment_IsDrawnBetweenTheBoundsOfTheType) {
  LineSetup setup = setup_of("pos36,nE,nW,crc6;cds0");
  setup.timing = find_encoder("fortis-36")->timing;
  setup.motion = MotionKind::max;
  const Motion motion(setup.motion, setup.format.channel_list[0], Line(setup).interval(),
                      setup.seed);
  const auto moments = [&](std::uint64_t seed) {
    setup.seed = seed;
    Line line(setup);
    std::vector<Picoseconds> after_lat;
    for (int i = 0; i < 300; ++i) {
      const SimulatedCycle& cycle = line.next();
      const Picoseconds lat = cycle.time + period_of(setup.clock) / 2 + setup.ma_delay;
      after_lat.push_back(cycle.sampled.value_or(Picoseconds{}) - lat);
      EXPECT_TRUE(cycle.reading.frame.ok());
      EXPECT_EQ(cycle.reading.frame->channel_list, cycle.sent.channel_list);
      if (seed != 1) continue;
      EXPECT_EQ(cycle.sent.channel_list[0].position, motion.at(*cycle.sampled));
    }
    return after_lat;
  };
  const auto first = moments(1);
  const auto [earliest, latest] = std::minmax_element(first.begin(), first.end());
  EXPECT_GE(*earliest, nanoseconds(3'225));
  EXPECT_LT(*earliest, nanoseconds(3'228));
  EXPECT_LE(*latest, nanoseconds(3'275));
  EXPECT_GT(*latest, nanoseconds(3'272));
  EXPECT_EQ(moments(1), first);
  EXPECT_NE(moments(2), first);
}

// Without bounds it is LAT, and the truth of a cycle without an answer has none.
TEST(Line, SamplingMomentWithoutBounds_IsThatOfTheType) {
  LineSetup setup = setup_of("pos26,nE,nW,crc6");
  setup.faults = {{.kind = FaultKind::no_answer, .cycle = 1}};
  Line line(setup);
  const SimulatedCycle& cycle = line.next();
  EXPECT_EQ(cycle.sampled, cycle.time + nanoseconds(50) + setup.ma_delay);
  EXPECT_EQ(line.next().sampled, std::nullopt);
}

// Singleturn at its top, turns at their bottom; a word without turns shows the place in the turn.
TEST(Line, WordsOfOneEncoder_LieOnEachOther) {
  const auto second_of = [](std::string_view format, const auto& expected) {
    LineSetup setup = setup_of(format);
    setup.motion = MotionKind::random;
    Line line(setup);
    for (int i = 0; i < 50; ++i) {
      const auto& words = line.next().sent.channel_list;
      ASSERT_EQ(words[1].position, expected(words[0].position)) << format << ", cycle " << i;
    }
  };
  using Value = std::uint64_t;
  second_of("pos36,crc6+pos28,crc16", [](Value p) { return p >> 8U; });
  second_of("pos20,crc6+pos28,crc16", [](Value p) { return p << 8U; });
  second_of("mt12,st24,crc6+mt12,st16,crc16", [](Value p) { return p >> 8U; });
  second_of("mt12,st16,crc6+st12,crc16", [](Value p) { return (p >> 4U) & 0xFFFU; });
  second_of("mt12,st16,crc6+mt4,st20,crc16", [](Value p) { return (p << 4U) & 0xFFFFFFU; });
  second_of("mt12,st16,crc6+mt8,crc16", [](Value p) { return (p >> 16U) & 0xFFU; });
  second_of("mt12,crc6+mt8,crc16", [](Value p) { return p >> 4U; });
}

// At the shortest interval the encoder becomes idle just when the request arrives.
TEST(Line, LateStart_ComesAtEveryInterval) {
  const CatalogueEntry* entry = find_encoder("fs-36-28");
  ASSERT_NE(entry, nullptr);
  for (const Picoseconds interval : {picoseconds(0), nanoseconds(31'250), nanoseconds(40'000)}) {
    LineSetup setup = setup_of(entry->format);
    setup.timing = entry->timing;
    setup.interval = interval;
    setup.faults = {{.kind = FaultKind::late_start, .share = std::uint64_t{1} << 29U}};
    Line line(setup);
    int late = 0;
    for (int i = 0; i < 400; ++i) {
      const SimulatedCycle& cycle = line.next();
      late += cycle.faults != 0 ? 1 : 0;
      EXPECT_EQ(cycle.reading.frame.ok(), cycle.faults == 0) << interval.count << ", cycle " << i;
    }
    EXPECT_GT(late, 20) << interval.count;
  }
}

TEST(Line, Edges_ComeInTimeOrderAcrossCycles) {
  LineSetup setup = setup_of("pos18,nE,nW,crc6");
  setup.ma_jitter = nanoseconds(10);
  setup.slo_jitter = nanoseconds(10);
  setup.record_at_slave = true;
  Line line(setup);
  Picoseconds last{};
  for (int i = 0; i < 50; ++i) {
    const SimulatedCycle& cycle = line.next();
    EXPECT_TRUE(cycle.reading.frame.ok());
    for (const wire::Edge& edge : cycle.edges) {
      EXPECT_GE(edge.time, last);
      last = edge.time;
    }
    EXPECT_LE(last, line.end());
  }
}

// The places of faults in cycle 3, which the rule names.
std::vector<InjectedFault> places_with(LineSetup setup, const FaultRule& rule) {
  setup.faults = {rule};
  Line line(setup);
  std::vector<InjectedFault> places;
  for (int i = 0; i < 4; ++i) {
    const SimulatedCycle& cycle = line.next();
    places = cycle.injected;
    EXPECT_EQ(places.empty(), i != 3 || !has_place(rule.kind));
    EXPECT_EQ(cycle.faults, i == 3 ? set_of(rule.kind) : 0U) << name_of(rule.kind);
  }
  return places;
}

void expect_places_reported(const LineSetup& setup, FaultKind kind, PlaceUnit unit) {
  const FaultPlaces places = places_of(kind, unit, Line(setup).nominal());
  if (places.empty()) return;
  for (const std::uint64_t whole : {places.first, (places.first + places.last) / 2, places.last}) {
    const FaultPlace place{unit, 1000 * whole + (places.whole ? 0U : 375U)};
    ASSERT_TRUE(places.contains(place));
    const auto reported = places_with(setup, {.kind = kind, .cycle = 3, .place = place});
    EXPECT_EQ(reported, (std::vector<InjectedFault>{{kind, place}}))
        << name_of(kind) << ' ' << whole;
  }
  EXPECT_FALSE(places.contains({unit, 1000 * (places.last + 1)}));
  EXPECT_EQ(places.contains({unit, 1000 * places.last + 1}), !places.whole);
}

TEST(Line, EveryKindAtItsPlaces_ReportsThem) {
  LineSetup one = setup_of("pos26,nE,nW,crc6;cds0");
  LineSetup chain = setup_of("pos36,nE,nW,crc6+pos28,nE,nW,lc6,crc16;cds0");
  chain.slaves = 2;
  chain.clock = megahertz(1);
  for (const LineSetup& setup : {one, chain}) {
    for (std::size_t k = 0; k < simulated_fault_count; ++k) {
      const auto kind = static_cast<FaultKind>(k);
      expect_places_reported(setup, kind, PlaceUnit::bit);
      expect_places_reported(setup, kind, PlaceUnit::clock);
      const auto drawn = places_with(setup, {.kind = kind, .cycle = 3});
      EXPECT_EQ(drawn.size(), has_place(kind) ? 1U : 0U);
    }
  }
}

// The bits that the master gets differ from those sent at the place and nowhere else.
TEST(Line, FlipAtABitOfAChain_IsThatBitOfThatChannel) {
  LineSetup setup = setup_of("pos8+pos8,nE,nW+pos16");
  setup.slaves = 3;
  for (std::uint64_t bit = 0; bit < 34; ++bit) {
    setup.faults = {{.kind = FaultKind::flip, .cycle = 3, .place = {{PlaceUnit::bit, bit * 1000}}}};
    Line line(setup);
    for (int i = 0; i < 3; ++i) line.next();
    const SimulatedCycle& cycle = line.next();
    ASSERT_TRUE(cycle.reading.frame.ok()) << bit;
    std::uint64_t sent = 0;
    std::uint64_t got = 0;
    const auto append = [](std::uint64_t& bits, const Channel& channel, unsigned width) {
      bits = bits << width | channel.position;
    };
    constexpr std::array<unsigned, 3> widths{8, 8, 16};
    for (std::size_t k = 0; k < 3; ++k) {
      append(sent, cycle.sent.channel_list[k], widths[k]);
      append(got, cycle.reading.frame->channel_list[k], widths[k]);
      if (k != 1) continue;
      const auto flags = [](const Channel& c) { return (c.nE ? 2U : 0U) | (c.nW ? 1U : 0U); };
      sent = sent << 2U | flags(cycle.sent.channel_list[k]);
      got = got << 2U | flags(cycle.reading.frame->channel_list[k]);
    }
    EXPECT_EQ(sent ^ got, std::uint64_t{1} << (33U - bit)) << bit;
  }
}

// The clock of a cycle's edges: its first period, and the high time of MA in it.
struct Clock {
  Picoseconds period;
  Picoseconds high;
};

Clock clock_of(const LineSetup& setup) {
  Line line(setup);
  std::vector<Picoseconds> times;
  for (const wire::Edge& edge : line.next().edges) {
    if (edge.line == ma_line) times.push_back(edge.time);
  }
  return {times[2] - times[0], times[2] - times[1]};
}

TEST(Line, ClockErrorAndDuty_ShowOnMa) {
  LineSetup setup = setup_of("pos26,nE,nW,crc6");
  EXPECT_EQ(clock_of(setup).period, nanoseconds(100));
  EXPECT_EQ(clock_of(setup).high, nanoseconds(50));
  setup.clock_error_ppm = 200;
  setup.duty_per_mille = 445;
  EXPECT_EQ(clock_of(setup).period, picoseconds(99'980));
  EXPECT_NEAR(static_cast<double>(clock_of(setup).high.count), 44'491, 1);
  setup.clock_error_ppm = 100'000;
  EXPECT_EQ(clock_of(setup).period, picoseconds(90'909));
  setup.clock_error_ppm = -100'000;
  EXPECT_EQ(clock_of(setup).period, picoseconds(111'111));
}

TEST(Line, CycleTimeout_HoldsSloLowUntilItIsOver) {
  LineSetup setup = setup_of("pos26,nE,nW,crc6");
  setup.timing.timeout = {TimeoutRule::cycle, nanoseconds(31'250)};
  Line line(setup);
  const SimulatedCycle& cycle = line.next();
  EXPECT_EQ(cycle.edges.back().time, cycle.time + nanoseconds(31'250) + picoseconds(242'500));
  EXPECT_EQ(cycle.edges.back().line, slo_line);
  EXPECT_EQ(cycle.edges.back().level, wire::Level::high);
}

TEST(Line, FlippedBits_SpoilThatShareOfCyclesAndNothingElse) {
  LineSetup setup = setup_of("pos18,nE,nW,crc6");
  setup.motion = MotionKind::random;
  Line clean(setup);
  setup.faults = {{.kind = FaultKind::flip, .share = std::uint64_t{1} << 31U}};
  Line spoiled(setup);
  int flips = 0;
  for (int i = 0; i < 1000; ++i) {
    const SimulatedCycle& a = spoiled.next();
    EXPECT_EQ(a.sent.channel_list, clean.next().sent.channel_list);
    EXPECT_EQ(a.reading.frame.ok(), a.faults == 0);
    flips += a.faults != 0 ? 1 : 0;
  }
  EXPECT_GT(flips, 400);
  EXPECT_LT(flips, 600);
}

// With a checksum of 16 bits no damaged frame of these seeds is good by chance. After some faults
// the encoder takes several positions in a cycle, or sends the position of the previous cycle.
TEST(Line, GoodFrameOfACycleWithAnyFault_IsTheSentOne) {
  const Timeout timeouts[] = {{TimeoutRule::adaptive, nanoseconds(200)},
                              {TimeoutRule::fixed, microseconds(20)},
                              {TimeoutRule::cycle, nanoseconds(31'250)}};
  std::size_t good = 0;
  for (std::size_t k = 0; k < fault_kind_count; ++k) {
    if (k == line_fault_kind_count) k = line_only_fault_first;
    const FaultKind kind = fault_list[k].kind;
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
      LineSetup setup =
          setup_of(seed % 4 == 0 ? "pos20,nE,nW,crc16+pos12,nE,nW,crc16" : "pos36,nE,nW,crc16");
      setup.timing.timeout = timeouts[seed % 3];
      setup.slaves = seed % 4 == 0 ? 2 : 1;
      setup.compensate = seed % 2 == 0;
      setup.ma_delay = setup.slo_delay = nanoseconds(seed % 2 == 0 ? 100 : 500);
      setup.ma_jitter = setup.slo_jitter = nanoseconds(5);
      setup.motion = seed % 2 == 0 ? MotionKind::random : MotionKind::sine;
      setup.seed = 1000 * k + seed;
      setup.faults = {{.kind = kind, .share = std::uint64_t{1} << 31U}};
      Line line(setup);
      for (int i = 0; i < 80; ++i) {
        const SimulatedCycle& cycle = line.next();
        if (!cycle.reading.frame.ok()) continue;
        ++good;
        ASSERT_TRUE(cycle.sampled) << name_of(kind) << ", seed " << seed << ", cycle " << i;
        ASSERT_EQ(cycle.reading.frame->channel_list, cycle.sent.channel_list)
            << name_of(kind) << ", seed " << seed << ", cycle " << i;
      }
    }
  }
  EXPECT_GT(good, 12U * 80U * line_fault_kind_count / 4);
}

TEST(Line, PausesOfMa_AreReadUpToTheTimeoutOfTheEncoder) {
  for (const std::int64_t pause_us : {1, 15, 25}) {
    LineSetup setup = setup_of("pos26,nE,nW,crc6");
    setup.timing.timeout = {TimeoutRule::fixed, microseconds(20)};
    setup.ma_delay = setup.slo_delay = nanoseconds(20);
    setup.pause = microseconds(pause_us);
    setup.pause_clocks = 8;
    Line line(setup);
    for (int i = 0; i < 5; ++i) {
      const SimulatedCycle& cycle = line.next();
      EXPECT_EQ(cycle.reading.frame.ok(), pause_us < 20) << pause_us;
      EXPECT_EQ(text_of(cycle.faults), "ma_pause");
      std::size_t pauses = 0;
      std::size_t rises = 0;
      std::optional<Picoseconds> last;
      for (const wire::Edge& edge : cycle.edges) {
        if (edge.line != ma_line) continue;
        if (last && edge.time - *last >= setup.pause) {
          ++pauses;
          EXPECT_EQ(rises % 8U, 0U);
          EXPECT_EQ(edge.level, wire::Level::low);
        }
        if (edge.level == wire::Level::high) ++rises;
        last = edge.time;
      }
      EXPECT_GE(pauses, pause_us < 20 ? 4U : 1U);
    }
  }
}

TEST(Line, ShortAndReducedFrames_EndAfterStopAndAck) {
  for (const auto& [kind, clocks] :
       {std::pair{FaultKind::short_frame, 5U}, std::pair{FaultKind::reduced_frame, 2U}}) {
    LineSetup setup = setup_of("pos26,nE,nW,crc6");
    setup.ma_delay = setup.slo_delay = nanoseconds(5);
    setup.faults = {{.kind = kind, .cycle = 1}};
    Line line(setup);
    for (int i = 0; i < 4; ++i) {
      const SimulatedCycle& cycle = line.next();
      EXPECT_EQ(cycle.reading.frame.ok(), i != 1);
      EXPECT_EQ(cycle.faults, i == 1 ? set_of(kind) : 0U);
      if (i != 1) continue;
      // A delay of the line can add clocks to a short frame.
      EXPECT_GE(cycle.reading.clocks, clocks);
      EXPECT_LE(cycle.reading.clocks, kind == FaultKind::short_frame ? 8U : 2U);
      EXPECT_EQ(cycle.reading.cds.has_value(), kind == FaultKind::short_frame);
    }
  }
}

TEST(Line, LateTurns_FallByOneTurnAfterTheZeroAndAreNamedThere) {
  LineSetup setup = setup_of("mt8,st10,nE,nW,crc6");
  setup.motion = MotionKind::sine;
  setup.faults = {{.kind = FaultKind::late_turns, .share = std::uint64_t{1} << 32U}};
  Line late(setup);
  setup.faults.clear();
  Line right(setup);
  std::size_t named = 0;
  for (int i = 0; i < 2000; ++i) {
    const SimulatedCycle& cycle = late.next();
    const std::uint64_t position = right.next().sent.channel_list[0].position;
    const std::uint64_t sent = cycle.sent.channel_list[0].position;
    ASSERT_EQ(cycle.faults != 0, (position & 1023U) < 15U) << position;
    ASSERT_EQ(sent, cycle.faults == 0 ? position : (position - 1024U) & 0x3FFFFU);
    if (cycle.faults != 0) ++named;
  }
  EXPECT_GT(named, 5U);
}

TEST(Line, IntervalLongerThanNeeded_IsKept) {
  LineSetup setup = setup_of("pos18,nE,nW,crc6");
  setup.interval = microseconds(500);
  Line line(setup);
  const Picoseconds first = line.next().time;
  EXPECT_EQ(line.next().time - first, microseconds(500));
}

TEST(Line, Chain_DeliversTheNearestEncoderFirst) {
  LineSetup setup = setup_of("pos18,nE,nW,crc6+pos12,crc5+mt4,st9,nE,nW,lc6,crc16");
  setup.internal_delay = nanoseconds(20);
  setup.slaves = 3;
  setup.motion = MotionKind::random;
  Line line(setup);
  for (int i = 0; i < 100; ++i) {
    const SimulatedCycle& cycle = line.next();
    ASSERT_TRUE(cycle.reading.frame.ok()) << name_of(cycle.reading.frame.error().cause);
    EXPECT_EQ(cycle.reading.frame->channel_list, cycle.sent.channel_list);
  }
}

}  // namespace line_test
}  // namespace biss::sim
