#include "sim/ideal_line.hpp"

#include <gtest/gtest.h>

#include "biss/frame/decode.hpp"
#include "biss/frame/format_parse.hpp"

namespace biss::sim {
namespace {

IdealLineSetup setup_of(std::string_view format) {
  IdealLineSetup setup;
  setup.format = *parse_format(format);
  setup.clock = megahertz(10);
  setup.line_delay = nanoseconds(242);
  return setup;
}

// SLO once a rising edge of MA, half a period after it, as a master with compensation samples it.
BitBuffer<2000> sampled(const SimulatedCycle& cycle, Picoseconds line_delay, Picoseconds period) {
  BitBuffer<2000> bits;
  for (const wire::Edge& edge : cycle.edges) {
    if (edge.line != ma_line || edge.level != wire::Level::high) continue;
    const Picoseconds at = edge.time + line_delay + period / 2;
    wire::Level level = wire::Level::high;
    for (const wire::Edge& slo : cycle.edges) {
      if (slo.line == slo_line && slo.time <= at) level = slo.level;
    }
    bits.append(level == wire::Level::high);
  }
  return bits;
}

TEST(IdealLine, EveryCycle_DecodesToWhatWasSent) {
  for (const char* format : {"pos26,nE,nW,crc6;cds0", "mt12,st20,nE,nW,lc6,crc16",
                             "pos36,nE,nW,crc6+pos28,nE,nW,lc6,crc16;cds0", "pos1,crc3"}) {
    const IdealLineSetup setup = setup_of(format);
    IdealLine line(setup);
    for (int i = 0; i < 100; ++i) {
      const SimulatedCycle cycle = line.next();
      const auto bits = sampled(cycle, setup.line_delay, nanoseconds(100));
      const auto frame = decode_frame(bits.view(), FrameCodec<>(setup.format));
      ASSERT_TRUE(frame.ok()) << format << ": " << name_of(frame.error().cause);
      EXPECT_EQ(frame->channel_list, cycle.sent.channel_list);
      EXPECT_TRUE(frame->stop_seen);
    }
  }
}

TEST(IdealLine, Edges_ComeInTimeOrderAcrossCycles) {
  IdealLine line(setup_of("pos18,nE,nW,crc6"));
  Picoseconds last{};
  for (int i = 0; i < 50; ++i) {
    for (const wire::Edge& edge : line.next().edges) {
      EXPECT_GE(edge.time, last);
      last = edge.time;
    }
  }
}

TEST(IdealLine, ShareOfFlips_SpoilsThatShareAndNothingElse) {
  IdealLineSetup setup = setup_of("pos18,nE,nW,crc6");
  setup.flip_share = std::uint64_t{1} << 31U;
  IdealLine spoiled(setup);
  setup.flip_share = 0;
  IdealLine clean(setup);
  int flips = 0;
  for (int i = 0; i < 1000; ++i) {
    const SimulatedCycle a = spoiled.next();
    const SimulatedCycle b = clean.next();
    EXPECT_EQ(a.sent.channel_list, b.sent.channel_list);
    const auto bits = sampled(a, setup.line_delay, nanoseconds(100));
    EXPECT_EQ(decode_frame(bits.view(), FrameCodec<>(setup.format)).ok(), !a.flipped);
    flips += a.flipped ? 1 : 0;
    EXPECT_FALSE(b.flipped);
  }
  EXPECT_GT(flips, 400);
  EXPECT_LT(flips, 600);
}

TEST(IdealLine, CycleTimeout_HoldsSloLowUntilItIsOver) {
  IdealLineSetup setup = setup_of("pos26,nE,nW,crc6");
  setup.timing.timeout = {TimeoutRule::cycle, nanoseconds(31'250)};
  IdealLine line(setup);
  const SimulatedCycle cycle = line.next();
  EXPECT_EQ(cycle.edges.back().time, cycle.time + nanoseconds(31'250) + setup.line_delay);
  EXPECT_EQ(cycle.edges.back().level, wire::Level::high);
}

TEST(Motion, Ramp_VisitsTheWholeRange) {
  Motion motion(MotionKind::ramp, 10, 3);
  std::uint64_t seen_min = UINT64_MAX;
  std::uint64_t seen_max = 0;
  for (int i = 0; i < 2000; ++i) {
    const std::uint64_t position = motion.next();
    seen_min = std::min(seen_min, position);
    seen_max = std::max(seen_max, position);
  }
  EXPECT_EQ(seen_min, 0U);
  EXPECT_EQ(seen_max, 1023U);
}

}  // namespace
}  // namespace biss::sim
