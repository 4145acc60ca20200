// Damaged lines: each cause has its own status, no position is wrong, and the decoder
// resynchronizes.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "decode/test_line.hpp"

namespace biss::decode::test {
namespace decoder_damage_test {

using Edges = std::vector<wire::Edge>;

constexpr std::uint64_t first_position = 0x1234567;

// Three requests; faults are injected into the second.
TestLine three(const Shape& shape = {}, std::uint64_t position = first_position) {
  TestLine line;
  for (std::uint64_t k = 0; k < 3; ++k) line.request(shape, position + k);
  return line;
}

std::string_view status_of_second(const TestLine& line, std::string_view format = usual_format,
                                  const DeviceTiming& timing = {}) {
  const auto cycles = decode(line, format, timing);
  if (cycles.size() != 3) return "not three rows";
  if (cycles[0].status != CycleStatus::ok || cycles[2].status != CycleStatus::ok) {
    return "a neighbour is not ok";
  }
  return name_of(cycles[1].status);
}

// Every `ok` cycle has one of the sent positions.
void expect_no_wrong_position(const std::vector<Cycle>& cycles,
                              std::uint64_t position = first_position) {
  for (const Cycle& cycle : cycles) {
    if (cycle.status != CycleStatus::ok) continue;
    EXPECT_LT(cycle.frame->channel_list[0].position - position, 3U);
  }
}

std::size_t count_of(const std::vector<Cycle>& cycles, CycleStatus status) {
  return static_cast<std::size_t>(std::count_if(
      cycles.begin(), cycles.end(), [&](const Cycle& cycle) { return cycle.status == status; }));
}

// Three requests, the second with these bits on the line.
TestLine with_second(const FrameBits& bits, const Shape& shape = {}) {
  TestLine line;
  line.request(shape, first_position);
  line.request(shape, bits);
  line.request(shape, first_position + 2);
  return line;
}

FrameBits flipped(std::size_t index) {
  FrameBits bits = bits_of(usual_format, first_position + 1);
  bits.flip(index);
  return bits;
}

// Places of bits_of(): LAT 0, ACK 1…3, START 4, CDS 5, data 6…33, CRC 34…39, STOP 40.
constexpr std::size_t cds_at = 5;
constexpr std::size_t stop_at = 40;
constexpr std::size_t clocks = 41;

TEST(DecoderDamage, EveryBitOfDataAndCrc_GivesCrc) {
  for (std::size_t i = cds_at + 1; i < stop_at; ++i) {
    EXPECT_EQ(status_of_second(with_second(flipped(i))), "crc") << i;
  }
}

TEST(DecoderDamage, CdsOne_IsACauseOnlyWithCds0) {
  const TestLine line = with_second(flipped(cds_at));
  EXPECT_EQ(status_of_second(line, "pos26,nE,nW,crc6;cds0"), "cds");
  EXPECT_EQ(status_of_second(line), "ok");
}

TEST(DecoderDamage, StopOne_GivesStopBit) {
  EXPECT_EQ(status_of_second(with_second(flipped(stop_at))), "stop_bit");
}

TEST(DecoderDamage, NoAnswer_GivesNoResponse) {
  FrameBits bits;
  bits.append_run(true, clocks);
  EXPECT_EQ(status_of_second(with_second(bits)), "no_response");
}

TEST(DecoderDamage, AnswerBeyondLineDelay_GivesResponseRange) {
  FrameBits bits;
  bits.append_run(true, 60);
  bits.append_run(false, 3);
  EXPECT_EQ(status_of_second(with_second(bits)), "response_range");
}

TEST(DecoderDamage, AnswerBeforeItIsAsked_GivesResponseRange) {
  TestLine line = three();
  const Picoseconds begin = line.ma[line.begins[1]].time;
  for (LevelChange& change : line.slo) {
    if (change.time > begin && change.time < begin + nanoseconds(1'700)) {
      change.time = begin + nanoseconds(200);
    }
  }
  EXPECT_EQ(status_of_second(line), "response_range");
}

TEST(DecoderDamage, EncoderStillBusy_GivesNotReady) {
  TestLine line = three();
  const Picoseconds begin = line.ma[line.begins[1]].time;
  // SLO is not released after the first cycle, so the second begins low.
  std::erase_if(line.slo, [&](const LevelChange& change) {
    return change.time < begin && change.time > begin - microseconds(6);
  });
  EXPECT_EQ(status_of_second(line), "not_ready");
}

TEST(DecoderDamage, NothingButZeros_GivesNoStart) {
  FrameBits bits;
  bits.append(true);
  bits.append_run(false, clocks - 1);
  EXPECT_EQ(status_of_second(with_second(bits)), "no_start");
}

TEST(DecoderDamage, LostStart_IsNeverOkWithAWrongPosition) {
  // A later 1 is read as START. About one position in a hundred passes the CRC by chance, and is
  // detected because its last bits are missing.
  for (std::uint64_t k = 0; k < 500; ++k) {
    FrameBits bits = bits_of(usual_format, k * 0x9E3779B9U & low_mask(26));
    bits.flip(4);
    TestLine line;
    line.request({}, bits);
    EXPECT_NE(name_of(decode(line)[0].status), "ok") << k;
  }
}

TEST(DecoderDamage, AckBeyondTheDevicesBound_GivesAckRange) {
  const Shape slow{.ack_clocks = 30};
  TestLine line;
  line.request({}, first_position);
  line.request(slow, first_position + 1);
  line.request({}, first_position + 2);
  const DeviceTiming timing{.ack_max = microseconds(10)};
  EXPECT_EQ(status_of_second(line, usual_format, timing), "ack_range");
  EXPECT_EQ(status_of_second(line), "ok");
}

TEST(DecoderDamage, TooFewClocks_GivesTruncated) {
  for (const int missing : {2, 7, 20, 30}) {
    TestLine line;
    line.request({}, first_position);
    line.request({.extra_clocks = -missing}, first_position + 1);
    line.request({}, first_position + 2);
    EXPECT_EQ(status_of_second(line), "truncated") << missing;
  }
}

TEST(DecoderDamage, LostLowPulseOfMa_GivesMaClockAndTheNextCycleIsRight) {
  for (const Shape& shape :
       {Shape{}, Shape{.period = nanoseconds(100), .line_delay = nanoseconds(213)},
        Shape{.timeout = nanoseconds(1'500), .gap = nanoseconds(100)},
        Shape{.extra_clocks = 2, .ending = Ending::low_until_timeout}}) {
    for (std::size_t cycle = 0; cycle < 3; ++cycle) {
      for (std::size_t clock = 0; clock < clocks; ++clock) {
        SCOPED_TRACE("cycle " + std::to_string(cycle) + ", clock " + std::to_string(clock));
        TestLine line = three(shape);
        const auto at =
            line.ma.begin() + static_cast<std::ptrdiff_t>(line.begins[cycle] + 2 * clock);
        line.ma.erase(at, at + 2);
        const auto cycles = decode(line);
        expect_no_wrong_position(cycles);
        EXPECT_GE(count_of(cycles, CycleStatus::ok), 2U);
        // The first two are before SLO falls, the last one is the edge of STOP.
        if (clock < 2 || clock == clocks - 1) continue;
        // Two consecutive halves look like two cycles as long as no other cycle was seen.
        const bool tight = shape.timeout < 4 * shape.period;
        if (tight && cycle == 0 && clock + 1 >= clocks / 2 && clock <= clocks / 2 + 2) continue;
        EXPECT_EQ(cycles.size(), 3U);
        // A clock of ACK brings no bit: before any other frame, this is a pause.
        if (cycle == 0 && clock < 4) continue;
        EXPECT_EQ(count_of(cycles, CycleStatus::ma_clock), 1U);
      }
    }
  }
}

TEST(DecoderDamage, LostHighPulseOfMa_IsNeverAWrongPosition) {
  for (std::size_t clock = 0; clock + 1 < clocks; ++clock) {
    SCOPED_TRACE(clock);
    TestLine line = three();
    const auto at = line.ma.begin() + static_cast<std::ptrdiff_t>(line.begins[1] + 2 * clock + 1);
    line.ma.erase(at, at + 2);
    const auto cycles = decode(line);
    ASSERT_EQ(cycles.size(), 3U);
    expect_no_wrong_position(cycles);
    EXPECT_EQ(name_of(cycles[0].status), "ok");
    EXPECT_EQ(name_of(cycles[2].status), "ok");
    if (clock >= 2 && clock + 2 < clocks) {
      EXPECT_EQ(name_of(cycles[1].status), "ma_clock");
    }
  }
}

TEST(DecoderDamage, DoubledPulseOfMa_GivesMaClock) {
  for (const std::int64_t width_ns : {20, 100, 200}) {
    for (std::size_t edge = 0; edge < 2 * clocks; ++edge) {
      SCOPED_TRACE(std::to_string(width_ns) + " ns behind edge " + std::to_string(edge));
      TestLine line = three();
      const Picoseconds at = line.ma[line.begins[1] + edge].time + nanoseconds(150);
      TestLine::add_pulse(line.ma, at, nanoseconds(width_ns));
      const auto cycles = decode(line);
      ASSERT_EQ(cycles.size(), 3U);
      expect_no_wrong_position(cycles);
      EXPECT_EQ(name_of(cycles[0].status), "ok");
      EXPECT_EQ(name_of(cycles[2].status), "ok");
      // Edges after the last CRC bit are not counted.
      if (edge < 2 * stop_at - 2) {
        EXPECT_EQ(name_of(cycles[1].status), "ma_clock");
      }
    }
  }
}

TEST(DecoderDamage, GlitchOnMaInIdle_IsARowOfItsOwn) {
  for (const std::int64_t width_ns : {1, 50, 500}) {
    TestLine line = three();
    TestLine::add_pulse(line.ma, line.ma[line.begins[1]].time - microseconds(12),
                        nanoseconds(width_ns));
    const auto cycles = decode(line);
    ASSERT_EQ(cycles.size(), 4U);
    EXPECT_EQ(name_of(cycles[1].status), "ma_glitch");
    EXPECT_EQ(count_of(cycles, CycleStatus::ok), 3U);
    EXPECT_FALSE(cycles[1].frame);
  }
}

TEST(DecoderDamage, GlitchOnMaRightBeforeARequest_IsARowOfItsOwn) {
  TestLine line = three();
  TestLine::add_pulse(line.ma, line.ma[line.begins[1]].time - microseconds(2), nanoseconds(20));
  const auto cycles = decode(line);
  ASSERT_EQ(cycles.size(), 4U);
  EXPECT_EQ(name_of(cycles[1].status), "ma_glitch");
  EXPECT_EQ(count_of(cycles, CycleStatus::ok), 3U);
}

// The encoder takes the pulse for its first clock, and answers a clock early.
TEST(DecoderDamage, PulseThatIsTheFirstClock_LeavesTheLineDelayAsItWas) {
  Shape shape{.period = nanoseconds(400), .line_delay = nanoseconds(640)};
  TestLine line;
  line.request(shape, 1, usual_format);
  const auto answered_early = [&](std::uint64_t position) {
    TestLine::add_pulse(line.ma, line.now - microseconds(2), nanoseconds(40));
    Shape early = shape;
    early.line_delay = shape.line_delay - shape.period;
    line.request(early, position, usual_format);
  };
  answered_early(2);
  line.request(shape, 3, usual_format);
  // A pulse that the encoder does not see.
  TestLine::add_pulse(line.ma, line.now - microseconds(2), nanoseconds(40));
  line.request(shape, 4, usual_format);
  answered_early(5);
  const auto cycles = decode(line);
  ASSERT_EQ(cycles.size(), 8U);
  EXPECT_EQ(count_of(cycles, CycleStatus::ma_glitch), 3U);
  for (const Cycle& cycle : cycles) {
    if (cycle.status == CycleStatus::ma_glitch) continue;
    EXPECT_EQ(name_of(cycle.status), "ok");
    EXPECT_EQ(cycle.line_delay, shape.line_delay) << cycle.time.count;
  }
}

TEST(DecoderDamage, PulseBeforeTheFirstRequest_MakesTheLineDelayUnknown) {
  const Shape shape{.period = nanoseconds(400), .line_delay = nanoseconds(240)};
  TestLine line;
  TestLine::add_pulse(line.ma, line.now - microseconds(2), nanoseconds(40));
  line.request(shape, 1, usual_format);
  line.request(shape, 2, usual_format);
  const auto cycles = decode(line);
  ASSERT_EQ(cycles.size(), 3U);
  EXPECT_EQ(name_of(cycles[1].status), "ok");
  EXPECT_FALSE(cycles[1].line_delay);
  EXPECT_EQ(cycles[2].line_delay, shape.line_delay);
}

TEST(DecoderDamage, PulseOfMaJustBeforeARequest_ShiftsNothing) {
  const TestLine clean = three();
  const Cycle second = decode(clean)[1];
  for (const std::int64_t before_ns : {1, 10, 50, 300, 480, 500, 700, 1'000, 1'200, 1'249}) {
    for (const std::int64_t width_ps : {1, 20, 49'999}) {
      SCOPED_TRACE(std::to_string(width_ps) + " ps, " + std::to_string(before_ns) + " ns before");
      TestLine line = clean;
      TestLine::add_pulse(
          line.ma, clean.ma[clean.begins[1]].time - nanoseconds(before_ns) - picoseconds(width_ps),
          picoseconds(width_ps));
      const auto cycles = decode(line);
      ASSERT_EQ(cycles.size(), 4U);
      EXPECT_EQ(name_of(cycles[1].status), "ma_glitch");
      EXPECT_EQ(name_of(cycles[2].status), "ok");
      EXPECT_EQ(cycles[2].time, second.time);
      EXPECT_EQ(cycles[2].line_delay, second.line_delay);
      EXPECT_EQ(cycles[2].rising_edges, second.rising_edges);
    }
  }
}

// `$dumpoff` sets every line to x, `$dumpon` restores its level.
TEST(DecoderDamage, CaptureSwitchedOnJustBeforeARequest_TheRequestIsRead) {
  for (const std::int64_t before_ns : {1, 300, 500, 1'000, 1'249, 3'000}) {
    TestLine line = three();
    const Picoseconds begin = line.ma[line.begins[1]].time;
    const Picoseconds off = begin - microseconds(4);
    const Picoseconds width = microseconds(4) - nanoseconds(before_ns);
    TestLine::add_pulse(line.ma, off, width, wire::Level::unknown);
    TestLine::add_pulse(line.slo, off, width, wire::Level::unknown);
    const auto cycles = decode(line);
    ASSERT_EQ(cycles.size(), 4U) << before_ns;
    EXPECT_EQ(name_of(cycles[1].status), "unknown_level");
    EXPECT_EQ(name_of(cycles[2].status), "ok") << before_ns;
    EXPECT_EQ(cycles[2].time, begin);
    EXPECT_EQ(name_of(cycles[3].status), "ok");
  }
}

TEST(DecoderDamage, CaptureSwitchedOnInsideAFrame_IsUnknown) {
  const TestLine clean = three();
  for (std::size_t edge = 2; edge < 2 * clocks - 2; ++edge) {
    TestLine line = clean;
    const Picoseconds begin = clean.ma[clean.begins[1]].time;
    const Picoseconds on = clean.ma[clean.begins[1] + edge].time + nanoseconds(10);
    for (auto* changes : {&line.ma, &line.slo}) {
      TestLine::add_pulse(*changes, begin - microseconds(4), on - begin + microseconds(4),
                          wire::Level::unknown);
    }
    const auto cycles = decode(line);
    ASSERT_EQ(cycles.size(), 3U) << edge;
    EXPECT_EQ(name_of(cycles[1].status), "unknown_level") << edge;
  }
}

// The capture ends at the time of an edge that the file no longer contains.
TEST(DecoderDamage, CaptureThatEndsAtTheTimeOfTheNextEdge_GivesCutEnd) {
  for (const Shape& shape : {Shape{}, Shape{.period = nanoseconds(100)}}) {
    const Edges all = three(shape).edges();
    std::vector<Picoseconds> begins;
    for (const Cycle& cycle : decode(all, all.back().time)) begins.push_back(cycle.time);
    for (std::size_t cut = 2; cut + 1 < all.size(); ++cut) {
      SCOPED_TRACE(cut);
      const auto cycles = decode({all.begin(), all.begin() + static_cast<std::ptrdiff_t>(cut) + 1},
                                 all[cut + 1].time);
      for (std::size_t k = 0; k < cycles.size(); ++k) {
        const CycleStatus status = cycles[k].status;
        const bool may_be_cut = k + 1 == cycles.size();
        EXPECT_TRUE(status == CycleStatus::ok || (may_be_cut && status == CycleStatus::cut_end))
            << k << ": " << name_of(status);
      }
    }
  }
}

TEST(DecoderDamage, GlitchOnSloAwayFromTheSamples_ChangesNothing) {
  const TestLine clean = three();
  const Picoseconds begin = clean.ma[clean.begins[1]].time;
  for (std::int64_t ns = -3'000; ns < 45'000; ns += 37) {
    // Sampled at 1100 + k * 1000 ns after the begin, which includes 100 ns of line delay.
    const std::int64_t from_sample = ((ns - 1'100) % 1'000 + 1'000) % 1'000;
    if (from_sample < 30 || from_sample > 940) continue;
    SCOPED_TRACE(ns);
    TestLine line = clean;
    TestLine::add_pulse(line.slo, begin + nanoseconds(ns), nanoseconds(30));
    const bool over_first_edge = ns <= 0 && ns >= -30;
    if (over_first_edge) continue;
    ASSERT_EQ(status_of_second(line), "ok");
  }
}

TEST(DecoderDamage, PulseOnSloOverASample_IsNeverAWrongPosition) {
  const TestLine clean = three();
  const Picoseconds begin = clean.ma[clean.begins[1]].time;
  for (std::int64_t ns = 0; ns < 45'000; ns += 43) {
    SCOPED_TRACE(ns);
    TestLine line = clean;
    TestLine::add_pulse(line.slo, begin + nanoseconds(ns), nanoseconds(700));
    const auto cycles = decode(line);
    ASSERT_EQ(cycles.size(), 3U);
    expect_no_wrong_position(cycles);
    EXPECT_EQ(name_of(cycles[2].status), "ok");
  }
}

TEST(DecoderDamage, UnknownLevels_AreNamed) {
  for (const std::int64_t ns : {-500, 100, 900, 1'600, 3'000, 20'300, 39'000}) {
    SCOPED_TRACE(ns);
    TestLine line = three();
    const Picoseconds at = line.ma[line.begins[1]].time + nanoseconds(ns);
    TestLine::add_pulse(line.slo, at, nanoseconds(1'100), wire::Level::unknown);
    EXPECT_EQ(status_of_second(line), "unknown_level");
  }
  TestLine line = three();
  for (std::size_t edge = 0; edge < 2 * clocks; edge += 7) {
    TestLine on_ma = line;
    on_ma.ma[on_ma.begins[1] + edge].level = wire::Level::unknown;
    const auto cycles = decode(on_ma);
    expect_no_wrong_position(cycles);
    EXPECT_EQ(count_of(cycles, CycleStatus::unknown_level), 1U);
    EXPECT_EQ(count_of(cycles, CycleStatus::ok), 2U);
  }
}

TEST(DecoderDamage, SloStuckFromAnyPoint_IsNeverAWrongPosition) {
  // A CRC of 6 bits would pass one in 64 of these.
  constexpr std::string_view format = "pos26,nE,nW,crc16";
  for (const wire::Level stuck : {wire::Level::low, wire::Level::high}) {
    for (std::int64_t ns = 0; ns < 50'000; ns += 500) {
      SCOPED_TRACE(ns);
      TestLine line;
      for (std::uint64_t k = 0; k < 3; ++k) line.request({}, first_position + k, format);
      const Picoseconds from = line.ma[line.begins[1]].time + nanoseconds(ns);
      std::erase_if(line.slo, [&](const LevelChange& change) { return change.time >= from; });
      line.slo.push_back({from, stuck});
      const auto cycles = decode(line, format);
      ASSERT_EQ(cycles.size(), 3U);
      expect_no_wrong_position(cycles);
      EXPECT_EQ(name_of(cycles[2].status), stuck == wire::Level::low ? "not_ready" : "no_response");
    }
  }
}

std::size_t count_before(const std::vector<Picoseconds>& begins, Picoseconds time) {
  return static_cast<std::size_t>(std::count_if(begins.begin(), begins.end(),
                                                [&](Picoseconds begin) { return begin <= time; }));
}

// The capture ends with edge `cut`: all cycles but the last one are complete.
void expect_whole_before(const Edges& all, std::size_t cut,
                         const std::vector<Picoseconds>& begins) {
  const Picoseconds at = all[cut].time;
  const auto cycles = decode({all.begin(), all.begin() + static_cast<std::ptrdiff_t>(cut) + 1}, at);
  expect_no_wrong_position(cycles);
  const std::size_t begun = count_before(begins, at);
  ASSERT_LE(cycles.size(), begun);
  ASSERT_GE(cycles.size() + 1, begun);
  for (std::size_t k = 0; k < cycles.size(); ++k) {
    const CycleStatus status = cycles[k].status;
    const bool may_be_cut = k + 1 == begun;
    EXPECT_TRUE(status == CycleStatus::ok || (may_be_cut && status == CycleStatus::cut_end))
        << k << ": " << name_of(status);
  }
}

// The capture begins at edge `cut` with both lines' levels: every cycle that begins later is
// complete.
void expect_whole_behind(const Edges& all, std::size_t cut, const std::vector<Picoseconds>& begins,
                         Picoseconds idle) {
  const Picoseconds at = all[cut].time;
  Edges rest{{at, 0, wire::Level::high}, {at, 1, wire::Level::high}};
  for (std::size_t i = 0; i <= cut; ++i) rest[all[i].line].level = all[i].level;
  rest.insert(rest.end(), all.begin() + static_cast<std::ptrdiff_t>(cut) + 1, all.end());
  const auto cycles = decode(rest, all.back().time + milliseconds(1));
  expect_no_wrong_position(cycles);
  const std::size_t untouched = begins.size() - count_before(begins, at + idle);
  ASSERT_GE(cycles.size(), untouched);
  ASSERT_LE(cycles.size(), untouched + 1);
  for (std::size_t k = 0; k < cycles.size(); ++k) {
    const CycleStatus status = cycles[k].status;
    const bool may_be_cut = k + untouched < cycles.size();
    EXPECT_TRUE(status == CycleStatus::ok || (may_be_cut && status == CycleStatus::cut_start))
        << k << ": " << name_of(status);
  }
}

TEST(DecoderDamage, CaptureCutAtEveryEdge_NamesTheCutCycleAndReadsTheOthers) {
  for (const Shape& shape :
       {Shape{}, Shape{.timeout = nanoseconds(1'500), .gap = nanoseconds(100)},
        Shape{.period = nanoseconds(100), .line_delay = nanoseconds(450), .extra_clocks = 2},
        Shape{.extra_clocks = 1, .ending = Ending::low_until_timeout},
        Shape{.ending = Ending::low_until_next}}) {
    const Edges all = three(shape).edges();
    std::vector<Picoseconds> begins;
    for (const Cycle& cycle : decode(all, all.back().time)) begins.push_back(cycle.time);
    ASSERT_EQ(begins.size(), 3U);
    for (std::size_t cut = 2; cut < all.size(); ++cut) {
      SCOPED_TRACE(cut);
      expect_whole_before(all, cut, begins);
      expect_whole_behind(all, cut, begins, 2 * shape.period);
    }
  }
}

// 40 hours, in picoseconds times 100, do not fit into 64 bits.
TEST(DecoderDamage, MaThatStopsForDays_SpoilsThatCycleAlone) {
  const Edges all = three().edges();
  std::vector<Picoseconds> begins;
  for (const Cycle& cycle : decode(all, all.back().time)) begins.push_back(cycle.time);
  ASSERT_EQ(begins.size(), 3U);
  Edges edges;
  std::size_t falling = 0;
  bool stopped = false;
  for (wire::Edge edge : all) {
    if (edge.line == 0 && edge.level == wire::Level::low && edge.time > begins[1]) ++falling;
    if (stopped) edge.time = edge.time + 40LL * 3600 * 1000 * milliseconds(1);
    stopped = falling >= 12;
    edges.push_back(edge);
  }
  const auto cycles = decode(edges, edges.back().time);
  ASSERT_EQ(cycles.size(), 4U);
  EXPECT_EQ(cycles[0].status, CycleStatus::ok);
  EXPECT_FALSE(is_good(cycles[1].status)) << name_of(cycles[1].status);
  EXPECT_FALSE(is_good(cycles[2].status)) << name_of(cycles[2].status);
  EXPECT_EQ(cycles[3].status, CycleStatus::ok);
}

}  // namespace decoder_damage_test
}  // namespace biss::decode::test
