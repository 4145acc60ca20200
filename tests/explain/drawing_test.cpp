// Every kind of fault, drawn: the lines, the samples, the bits and the checksum are those of the
// line that the simulator made.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "biss/frame/encode.hpp"
#include "biss/frame/format_text.hpp"
#include "decode/test_line.hpp"
#include "draw/cycle_drawing.hpp"
#include "draw/text.hpp"
#include "sim/line.hpp"

namespace biss::draw::drawing_test {

using sim::FaultKind;
using testing::Contains;
using testing::HasSubstr;
using wire::Edge;
using wire::Level;

constexpr std::string_view format_of_line = "pos26,nE,nW,lc6,crc16";
constexpr std::uint64_t spoiled_cycle = 5;

sim::LineSetup clean_line() {
  sim::LineSetup setup;
  setup.format = *parse_format(format_of_line);
  setup.clock = megahertz(2);
  setup.ma_delay = setup.slo_delay = nanoseconds(70);
  setup.processing = microseconds(2);
  setup.motion = sim::MotionKind::random;
  setup.timing.timeout = {.rule = TimeoutRule::fixed, .time = microseconds(13)};
  return setup;
}

struct Recording {
  std::vector<Edge> edges{{{}, 0, Level::high}, {{}, 1, Level::high}};
  std::vector<sim::SimulatedCycle> cycles;
  Picoseconds end{};
};

Recording record(const sim::LineSetup& setup) {
  Recording recording;
  sim::Line line(setup);
  for (std::uint64_t i = 0; i < 7; ++i) {
    recording.cycles.push_back(line.next());
    const auto& edges = recording.cycles.back().edges;
    recording.edges.insert(recording.edges.end(), edges.begin(), edges.end());
  }
  recording.end = line.end() + microseconds(50);
  return recording;
}

std::vector<CycleDrawing> draw_all(const std::vector<Edge>& edges, Picoseconds end,
                                   const FrameFormat& format, const DeviceTiming& timing = {}) {
  std::vector<CycleDrawing> drawings;
  decode::CycleEdgeReader reader(decode::CycleReader(format, timing), {.ma = 0, .slo = 1},
                                 [&](const decode::CycleEdges& cycle) {
                                   drawings.push_back(draw_cycle(cycle, format, timing));
                                 });
  reader.push(edges);
  reader.finish(end);
  return drawings;
}

Level level_of(const std::vector<Edge>& edges, wire::LineIndex line, Picoseconds time) {
  auto at = std::upper_bound(edges.begin(), edges.end(), time,
                             [](Picoseconds t, const Edge& edge) { return t < edge.time; });
  while (at != edges.begin()) {
    if ((--at)->line == line) return at->level;
  }
  return Level::unknown;
}

// The drawing says nothing that the recorded edges do not.
void expect_as_recorded(const CycleDrawing& drawing, const std::vector<Edge>& edges,
                        const FrameFormat& format) {
  const auto count = [&](wire::LineIndex line) {
    return static_cast<std::size_t>(std::count_if(edges.begin(), edges.end(), [&](const Edge& e) {
      return e.line == line && e.time >= drawing.cycle.time && e.time <= drawing.end;
    }));
  };
  EXPECT_EQ(drawing.ma.size(), count(0));
  EXPECT_EQ(drawing.slo.size(), count(1));
  for (const DrawnBit& bit : drawing.bits) {
    EXPECT_EQ(level_of(edges, 0, bit.time), Level::high);
    EXPECT_EQ(level_of(edges, 0, bit.time - picoseconds(1)), Level::low);
    if (!bit.sampled_at || bit.clock < 2 || !bit.level) continue;
    EXPECT_EQ(level_of(edges, 1, *bit.sampled_at), *bit.level ? Level::high : Level::low)
        << bit.clock;
  }
  // The bits of the frame, in the order of the format, with the checksum of an independent codec.
  const BitView raw = drawing.cycle.raw.view();
  std::vector<std::string> names;
  for (const DrawnBit& bit : drawing.bits) {
    if (!bit.payload_bit) continue;
    EXPECT_EQ(bit.level, raw[*bit.payload_bit + 2]) << bit.name;
    names.push_back(bit.name);
  }
  if (raw.size_bits() >= format.payload_bits() + 2U) {
    EXPECT_EQ(names.size(), format.payload_bits());
    ASSERT_EQ(drawing.checks.size(), 1U);
    const unsigned data_bits = format.channel_list[0].data_bits;
    const PlainCodec codec(format);
    EXPECT_EQ(drawing.checks[0].expected, codec.crc(0, raw.word(2, data_bits), false));
    EXPECT_EQ(drawing.checks[0].right(),
              drawing.cycle.status != CycleStatus::crc && drawing.cycle.crc_ok[0].value_or(true));
    std::size_t at = data_bits;
    for (const DrawnBit& bit : drawing.bits) {
      if (bit.payload_bit != at) continue;
      const unsigned shift = static_cast<unsigned>(format.payload_bits() - 1U - at);
      EXPECT_EQ(bit.expected, ((drawing.checks[0].expected >> shift) & 1U) != 0) << bit.name;
      ++at;
    }
    EXPECT_EQ(at, format.payload_bits());
  }
}

const CycleDrawing* drawing_at(const std::vector<CycleDrawing>& drawings, Picoseconds time,
                               Picoseconds period) {
  for (const CycleDrawing& drawing : drawings) {
    const Picoseconds off = drawing.cycle.time - time;
    if (2 * std::max(off, -off) < period) return &drawing;
  }
  return nullptr;
}

bool has_pulse(const std::vector<decode::LevelChange>& line, Picoseconds from, Picoseconds to,
               Picoseconds period) {
  for (std::size_t i = 0; i + 1 < line.size(); ++i) {
    const Picoseconds width = line[i + 1].time - line[i].time;
    if (line[i].time >= from && line[i].time <= to && 8 * width < period) return true;
  }
  return false;
}

TEST(CycleDrawing, EveryFaultOfTheLine_IsDrawnAsRecorded) {
  for (std::size_t k = 0; k < sim::simulated_fault_count; ++k) {
    const auto kind = static_cast<FaultKind>(k);
    SCOPED_TRACE(sim::name_of(kind));
    for (std::uint64_t seed = 1; seed <= 2; ++seed) {
      sim::LineSetup setup = clean_line();
      setup.seed = seed;
      setup.faults.push_back({.kind = kind, .cycle = spoiled_cycle});
      const Recording recording = record(setup);
      const auto drawings = draw_all(recording.edges, recording.end, setup.format, setup.timing);
      EXPECT_GE(drawings.size(), 4U);
      for (const CycleDrawing& drawing : drawings) {
        SCOPED_TRACE(drawing.number);
        expect_as_recorded(drawing, recording.edges, setup.format);
        const std::string text = drawing_text(drawing);
        if (drawing.cycle.status == CycleStatus::ok) {
          EXPECT_THAT(text, HasSubstr("START  CDS  pos25"));
        }
        EXPECT_THAT(text, HasSubstr("MA "));
      }
    }
  }
}

TEST(CycleDrawing, PulseOfAFault_IsDrawnWhereTheSimulatorMadeIt) {
  for (const FaultKind kind : {FaultKind::glitch_ma, FaultKind::glitch_slo}) {
    for (std::uint64_t clock = 6; clock < 50; clock += 6) {
      sim::LineSetup setup = clean_line();
      // In the middle of a level, so that the pulse does not move an edge.
      setup.faults.push_back({.kind = kind,
                              .cycle = spoiled_cycle,
                              .place = sim::FaultPlace{sim::PlaceUnit::clock, clock * 1000 + 740}});
      const Recording recording = record(setup);
      const auto& spoiled = recording.cycles[spoiled_cycle];
      const Picoseconds period = period_of(setup.clock);
      const auto drawings = draw_all(recording.edges, recording.end, setup.format, setup.timing);
      const CycleDrawing* drawing = drawing_at(drawings, spoiled.time, period);
      ASSERT_NE(drawing, nullptr);
      ASSERT_EQ(spoiled.injected.size(), 1U);
      const Picoseconds at =
          spoiled.time +
          period * static_cast<std::int64_t>(spoiled.injected[0].place.thousandths) / 1000;
      const auto& line = kind == FaultKind::glitch_ma ? drawing->ma : drawing->slo;
      EXPECT_TRUE(has_pulse(line, at - period / 50, at + period / 50, period))
          << sim::name_of(kind) << " at clock " << clock;
    }
  }
}

TEST(CycleDrawing, FlipOfAnyBit_IsTheOneThatMendsTheFrame) {
  sim::LineSetup setup = clean_line();
  for (unsigned bit = 0; bit < setup.format.payload_bits(); bit += 3) {
    setup.faults = {{.kind = FaultKind::flip,
                     .cycle = spoiled_cycle,
                     .place = sim::FaultPlace{sim::PlaceUnit::bit, bit * 1000U}}};
    const Recording recording = record(setup);
    const auto drawings = draw_all(recording.edges, recording.end, setup.format, setup.timing);
    const CycleDrawing& drawing = drawings.at(spoiled_cycle);
    ASSERT_EQ(drawing.cycle.status, CycleStatus::crc);
    ASSERT_EQ(recording.cycles[spoiled_cycle].injected.at(0).place.whole(), bit);
    // A CRC of 16 bits finds the one bit.
    EXPECT_EQ(drawing.checks.at(0).singles, std::vector<Flips>{{bit}});
    const auto sent = *encode_frame(
        [&] {
          Frame frame = recording.cycles[spoiled_cycle].sent;
          frame.lead_clocks = 1;
          frame.ack_clocks = 3;
          return frame;
        }(),
        PlainCodec(setup.format));
    // LAT, ACK, START and CDS come before.
    for (const DrawnBit& drawn : drawing.bits) {
      if (!drawn.payload_bit) continue;
      const bool as_sent = sent.view()[1 + 3 + 2 + *drawn.payload_bit];
      EXPECT_EQ(*drawn.level == as_sent, *drawn.payload_bit != bit) << drawn.name;
    }
    EXPECT_THAT(drawing_text(drawing),
                HasSubstr("  flip that mends it  " + std::string(drawing.name_of(bit)) + " (bit " +
                          std::to_string(bit) + ")"));
  }
}

TEST(CycleDrawing, Burst_BeginsAtThePlaceOfTheSimulator) {
  for (unsigned bit = 0; bit + 1 < 50; bit += 7) {
    sim::LineSetup setup = clean_line();
    setup.faults = {{.kind = FaultKind::burst,
                     .cycle = spoiled_cycle,
                     .place = sim::FaultPlace{sim::PlaceUnit::bit, bit * 1000U}}};
    const Recording clean = record(clean_line());
    const Recording recording = record(setup);
    const auto good = draw_all(clean.edges, clean.end, setup.format, setup.timing);
    const auto bad = draw_all(recording.edges, recording.end, setup.format, setup.timing);
    const BitView sent = good.at(spoiled_cycle).cycle.raw.view();
    const BitView received = bad.at(spoiled_cycle).cycle.raw.view();
    std::size_t first = 0;
    while (first < sent.size_bits() && sent[first] == received[first]) ++first;
    EXPECT_EQ(first, bit + 2U);
  }
}

// A double flip is among the pairs, and all pairs are counted.
TEST(CycleDrawing, TwoFlips_AreAmongThePairsThatMend) {
  const FrameFormat format = *parse_format("pos26,nE,nW,crc6");
  FrameBits bits = decode::test::bits_of("pos26,nE,nW,crc6", 0x2AB'CDEF);
  FrameBits spoiled;
  constexpr std::size_t first = 1 + 3 + 2;
  for (std::size_t i = 0; i < bits.size_bits(); ++i) {
    spoiled.append(bits.view()[i] != (i == first + 4 || i == first + 19));
  }
  decode::test::TestLine line;
  line.request({}, spoiled);
  const auto drawings = draw_all(line.edges(), line.last_time() + milliseconds(1), format);
  const DrawnCheck& check = drawings.at(0).checks.at(0);
  EXPECT_FALSE(check.right());
  std::size_t pairs = 0;
  bool found = false;
  const PlainCodec codec(format);
  const BitView raw = drawings[0].cycle.raw.view();
  for (std::size_t i = 0; i < 34; ++i) {
    for (std::size_t j = i + 1; j < 34; ++j) {
      FrameBits mended;
      for (std::size_t at = 2; at < raw.size_bits(); ++at) {
        mended.append(raw[at] != (at == i + 2 || at == j + 2));
      }
      const BitView view = mended.view();
      if (view.word(28, 6) != codec.crc(0, view.word(0, 28), false)) continue;
      ++pairs;
      found = found || (i == 4 && j == 19);
    }
  }
  EXPECT_TRUE(found);
  EXPECT_EQ(check.pair_count, pairs);
}

// The errors in received bits, which the line model does not make.
TEST(CycleDrawing, ErrorsInReceivedBits_AreDrawnAsReceived) {
  const FrameFormat format = *parse_format("pos26,nE,nW,crc6");
  const FrameBits sent = decode::test::bits_of("pos26,nE,nW,crc6", 0x155'0F3C);
  const BitView view = sent.view();
  const std::size_t start = 4;
  for (std::size_t k = sim::simulated_fault_count; k < sim::fault_kind_count; ++k) {
    const auto kind = static_cast<FaultKind>(k);
    SCOPED_TRACE(sim::name_of(kind));
    FrameBits bits;
    for (std::size_t i = 0; i < view.size_bits(); ++i) {
      bool bit = view[i];
      const bool middle = i == 15;
      const bool gap = i >= 15 && i < 20;
      if (kind == FaultKind::flips && (i == 9 || i == 21 || i == 30)) bit = !bit;
      if (kind == FaultKind::lost_bit && middle) continue;
      if (kind == FaultKind::doubled_bit && middle) bits.append(bit);
      if (kind == FaultKind::inserted_low && middle) bits.append(false);
      if (kind == FaultKind::inserted_high && middle) bits.append(true);
      if (kind == FaultKind::gap_low && gap) bit = false;
      if (kind == FaultKind::gap_high && gap) bit = true;
      if (kind == FaultKind::lost_start && i == start) bit = false;
      if (kind == FaultKind::false_start && i == start - 1) bit = true;
      if (kind == FaultKind::cds_high && i == start + 1) bit = true;
      if (kind == FaultKind::stop_high && i + 1 == view.size_bits()) bit = true;
      bits.append(bit);
    }
    decode::test::TestLine line;
    line.request({}, bits);
    const auto drawings = draw_all(line.edges(), line.last_time() + milliseconds(1), format);
    ASSERT_EQ(drawings.size(), 1U);
    expect_as_recorded(drawings[0], line.edges(), format);
    ASSERT_EQ(drawings[0].bits.size(), bits.size_bits());
    for (const DrawnBit& bit : drawings[0].bits) {
      EXPECT_EQ(bit.level, bits.view()[bit.clock]) << bit.clock;
    }
  }
}

TEST(CycleDrawing, SeveralChannels_HaveTheirNumberInTheNames) {
  const FrameFormat format = *parse_format("mt4,st8:gray,pad2,E,W,crc5+pos7,nE,lc3,crc4");
  decode::test::TestLine line;
  line.request({}, 0x5A, "mt4,st8:gray,pad2,E,W,crc5+pos7,nE,lc3,crc4");
  const auto drawings = draw_all(line.edges(), line.last_time() + milliseconds(1), format);
  std::vector<std::string> names;
  for (const DrawnBit& bit : drawings.at(0).bits) names.push_back(bit.name);
  const std::vector<std::string> expected{
      "LAT",    "ACK",    "ACK",    "ACK",    "START",  "CDS",    "mt3",    "mt2",  "mt1",
      "mt0",    "st7",    "st6",    "st5",    "st4",    "st3",    "st2",    "st1",  "st0",
      "pad",    "pad",    "E",      "W",      "crc4",   "crc3",   "crc2",   "crc1", "crc0",
      "pos6.2", "pos5.2", "pos4.2", "pos3.2", "pos2.2", "pos1.2", "pos0.2", "nE.2", "lc2.2",
      "lc1.2",  "lc0.2",  "crc3.2", "crc2.2", "crc1.2", "crc0.2", "STOP"};
  EXPECT_EQ(names, expected);
  EXPECT_EQ(drawings[0].checks.size(), 2U);
}

TEST(DrawingText, WideFrame_IsWrappedAtTheColumnsGiven) {
  const FrameFormat format = *parse_format("pos36,nE,nW,crc6+pos28,nE,nW,lc6,crc16");
  decode::test::TestLine line;
  line.request({}, 12345, "pos36,nE,nW,crc6+pos28,nE,nW,lc6,crc16");
  const auto drawings = draw_all(line.edges(), line.last_time() + milliseconds(1), format);
  for (const std::size_t columns : {60U, 80U, 132U}) {
    const std::string text = drawing_text(drawings.at(0), columns);
    std::size_t width = 0;
    for (const char c : text) {
      const bool continues = (static_cast<unsigned char>(c) & 0xC0U) == 0x80;
      width = c == '\n' ? 0 : width + (continues ? 0 : 1);
      ASSERT_LE(width, columns) << text;
    }
    // No word is split.
    for (const char* const name : {"pos35", "pos0.2", "crc15.2", "STOP"}) {
      EXPECT_THAT(text, HasSubstr(name));
    }
  }
}

TEST(DrawingText, NoAnswer_HasNoSamples) {
  sim::LineSetup setup = clean_line();
  setup.faults = {{.kind = FaultKind::no_answer, .cycle = spoiled_cycle}};
  const Recording recording = record(setup);
  const auto drawings = draw_all(recording.edges, recording.end, setup.format, setup.timing);
  const CycleDrawing& drawing = drawings.at(spoiled_cycle);
  EXPECT_EQ(drawing.cycle.status, CycleStatus::no_response);
  for (const DrawnBit& bit : drawing.bits) EXPECT_FALSE(bit.sampled_at);
  EXPECT_THAT(drawing_text(drawing), testing::Not(HasSubstr("sample")));
}

}  // namespace biss::draw::drawing_test
