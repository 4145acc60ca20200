// The slave's side of a request, clock by clock.
#include "biss/slave/slave.hpp"
#include "biss/catalogue/catalogue.hpp"
#include "biss/frame/decode.hpp"
#include "tests/core/frames.hpp"
#include "tests/core/slave_bench.hpp"
#include "tests/core/test.hpp"

namespace biss::test::slave_test {

using Codec = TestCodec;

constexpr FrameFormat format = format_of("pos26,nE,nW,crc6");
constexpr unsigned frame_clocks = 5 + 34;

/// One slave and its log.
struct Bench : SlaveChain<TestSlave, 1> {
  constexpr explicit Bench(const SlaveTiming& timing, const FrameFormat& frame_format = format)
      : SlaveChain{{TestSlave(Codec(frame_format), timing, {&log})}} {}

  constexpr Picoseconds time_to_idle() {
    const Picoseconds begin = now;
    for (int i = 0; i < 4 && out[0].has_deadline(); ++i) wait(out[0].deadline - now);
    return now - begin + half;
  }

  Log log{};
};

constexpr Result<Codec::Frame, FrameFault> read(const Bench& bench, const FrameFormat& f = format) {
  return decode_frame(bench.bits.view(), Codec(f), FrameBounds{});
}

BISS_TEST(Slave, WholeRequest_IsTheEncodedFrame) {
  Bench bench({});
  bench.log.position = 0x1234567;
  bench.log.cds = true;
  bench.clock(frame_clocks);
  BISS_EXPECT(bench.slave[0].state() == SlaveState::stop);
  const auto frame = read(bench);
  BISS_ASSERT(frame.ok());
  BISS_EXPECT_EQ(frame->channel_list[0].position, 0x1234567);
  BISS_EXPECT(frame->cds);
  BISS_EXPECT(frame->stop_seen);
  BISS_EXPECT_EQ(frame->lead_clocks, 1);
  BISS_EXPECT_EQ(frame->ack_clocks, 1);
  BISS_EXPECT_EQ(bench.log.samples, 1);
  BISS_EXPECT_EQ(bench.log.sampled_at.count, (microseconds(5) + half).count);
}

BISS_TEST(Slave, EveryFormatOfTheCatalogue_SendsWhatWasSampled) {
  BISS_RANDOM(random, 0x51A7E);
  for (const CatalogueEntry& entry : catalogue) {
    const FrameFormat entry_format = entry.frame_format();
    if (entry_format.channel_count > 2) continue;
    Bench bench(slave_timing(entry.timing), entry_format);
    unsigned least_bits = 64;
    for (const ChannelFormat& channel : entry_format.channels()) {
      least_bits = std::min(least_bits, channel.position_bits());
    }
    bench.log.position = random.bits(least_bits);
    bench.clock(8 + entry_format.payload_bits());
    const auto frame = read(bench, entry_format);
    BISS_ASSERT(frame.ok()) << static_cast<int>(frame.error().cause);
    for (const Channel& channel : frame->channels()) {
      BISS_EXPECT_EQ(channel.position, bench.log.position);
    }
  }
}

BISS_TEST(Slave, Busy_HoldsAckUntilItIsReady) {
  for (const int tenths : {0, 1, 9, 10, 11, 29, 30, 31, 100}) {
    Bench bench({.ready = period * tenths / 10});
    bench.clock(frame_clocks + 12);
    const auto frame = read(bench);
    BISS_ASSERT(frame.ok());
    BISS_EXPECT_EQ(frame->ack_clocks, std::max((tenths + 9) / 10, 1));
  }
}

BISS_TEST(Slave, SamplingMoment_IsBeforeStart) {
  for (const int tenths : {1, 10, 19, 20, 21, 30, 32, 40}) {
    Bench bench({.sampling = period * tenths / 10});
    bench.clock(frame_clocks + 12);
    const auto frame = read(bench);
    BISS_ASSERT(frame.ok());
    BISS_EXPECT_EQ(frame->ack_clocks, std::max((tenths + 9) / 10 - 1, 1));
    BISS_EXPECT_EQ(bench.log.sampled_at.count,
                   (microseconds(5) + half + period * tenths / 10).count);
  }
}

BISS_TEST(Slave, FixedAckAndBusyS_CountClocks) {
  for (const std::uint8_t ack : std::array<std::uint8_t, 3>{1, 4, 9}) {
    Bench bench({.ready = period * 20, .ack_clocks = ack});
    bench.clock(frame_clocks + 12);
    const auto frame = read(bench);
    BISS_ASSERT(frame.ok());
    BISS_EXPECT_EQ(frame->ack_clocks, ack);
    Bench late({.busy_s_clocks = ack});
    late.clock(frame_clocks + 12);
    const auto late_frame = read(late);
    BISS_ASSERT(late_frame.ok());
    BISS_EXPECT_EQ(late_frame->ack_clocks, ack + 1);
  }
}

BISS_TEST(Slave, Timeout_FollowsItsRule) {
  Bench fixed({.timeout = {TimeoutRule::fixed, nanoseconds(12'500)}});
  fixed.clock(frame_clocks);
  BISS_EXPECT_EQ(fixed.time_to_idle().count, nanoseconds(12'500).count);
  Bench adaptive({.timeout = {TimeoutRule::adaptive, nanoseconds(200)}});
  adaptive.clock(frame_clocks);
  BISS_EXPECT_EQ(adaptive.time_to_idle().count, nanoseconds(1'700).count);
  // Begun at 5 us, the last edge at 5 us + 38.5 us.
  Bench cycle({.timeout = {TimeoutRule::cycle, microseconds(60)}});
  cycle.clock(frame_clocks);
  BISS_EXPECT_EQ(cycle.time_to_idle().count, nanoseconds(60'000 - 38'500).count);
  Bench over({.timeout = {TimeoutRule::cycle, nanoseconds(31'250)}});
  over.clock(frame_clocks);
  BISS_EXPECT_EQ(over.time_to_idle().count, nanoseconds(1'500).count);
  for (const std::uint8_t halves : std::array<std::uint8_t, 4>{2, 3, 4, 255}) {
    const Timeout timeout{TimeoutRule::cycle, nanoseconds(31'250), halves};
    Bench other({.timeout = timeout});
    other.clock(frame_clocks);
    BISS_EXPECT(other.time_to_idle() == release_time(timeout, period));
  }
}

BISS_TEST(Slave, ClockStoppedAnywhere_IsIdleAfterTheTimeoutAndAnswersTheNext) {
  for (unsigned clocks = 1; clocks < frame_clocks + 3; ++clocks) {
    Bench bench({.timeout = {TimeoutRule::fixed, microseconds(20)}});
    bench.clock(clocks);
    bench.wait(microseconds(20) - half - picoseconds(1));
    BISS_EXPECT(bench.slave[0].state() != SlaveState::idle) << clocks;
    bench.wait(picoseconds(1));
    BISS_EXPECT(bench.slave[0].state() == SlaveState::idle) << clocks;
    BISS_EXPECT(bench.out[0].level);
    BISS_EXPECT_EQ(bench.log.cdm_count, clocks < 2 ? 0 : 1) << clocks;
    bench.bits.clear();
    bench.log.position = 0x2AAAAAA;
    bench.clock(frame_clocks);
    const auto frame = read(bench);
    BISS_ASSERT(frame.ok());
    BISS_EXPECT_EQ(frame->channel_list[0].position, 0x2AAAAAA);
  }
}

BISS_TEST(Slave, Cdm_IsTheInverseOfMaAtTheEnd) {
  Bench bench({.timeout = {TimeoutRule::fixed, microseconds(20)}});
  bench.clock(frame_clocks);
  bench.wait(microseconds(30));
  BISS_EXPECT(!bench.log.cdm);
  bench.clock(frame_clocks);
  bench.put(false);
  bench.wait(microseconds(20));
  BISS_EXPECT_EQ(bench.log.cdm_count, 2);
  BISS_EXPECT(bench.log.cdm);
  BISS_EXPECT(bench.out[0].level);
  // A held CDM: MA rises just before the next request.
  bench.put(true);
  bench.wait(nanoseconds(100));
  bench.bits.clear();
  bench.clock(frame_clocks);
  BISS_EXPECT(read(bench).ok());
}

BISS_TEST(Slave, CdmOfACutFrame_IsToldToo) {
  // Reduced, without START, without CDS, short, cut in the data: the bit and its time are the same.
  for (const unsigned clocks : {2U, 3U, 4U, 5U, 20U}) {
    for (const bool bit : {false, true}) {
      Bench bench({.timeout = {TimeoutRule::fixed, microseconds(20)}});
      bench.log.cdm = !bit;
      bench.clock(clocks);
      bench.put(!bit);
      bench.wait(microseconds(20) - (bit ? picoseconds(1) : half + picoseconds(1)));
      BISS_EXPECT_EQ(bench.log.cdm_count, 0) << clocks;
      bench.wait(picoseconds(1));
      BISS_EXPECT_EQ(bench.log.cdm_count, 1) << clocks;
      BISS_EXPECT_EQ(bench.log.cdm, bit) << clocks;
      BISS_EXPECT(bench.slave[0].state() == SlaveState::idle);
    }
  }
}

BISS_TEST(Slave, WithoutChannels_SendsFiveBits) {
  Bench bench({.sampling = period * 9, .start_min = period * 9, .ready = period * 20});
  bench.slave[0].set_channels_active(false);
  BISS_EXPECT(!bench.slave[0].channels_active());
  bench.log.position = 0x1234567;
  bench.log.cds = true;
  bench.clock(8);
  BISS_EXPECT_EQ(bench.bits.bytes()[0], 0b1011'0000);
  BISS_EXPECT(bench.slave[0].state() == SlaveState::stop);
  BISS_EXPECT_EQ(bench.log.samples, 0);
  bench.wait(microseconds(41));
  BISS_EXPECT_EQ(bench.log.cdm_count, 1);

  // No sampling in the middle of a frame.
  bench.bits.clear();
  bench.clock(2);
  bench.slave[0].set_channels_active(true);
  bench.clock(3);
  BISS_EXPECT_EQ(bench.bits.bytes()[0], 0b1011'0000);
  BISS_EXPECT(bench.slave[0].state() == SlaveState::stop);
  bench.wait(microseconds(41));
  bench.bits.clear();
  bench.clock(10);
  bench.slave[0].set_channels_active(false);
  bench.clock(frame_clocks + 20);
  const auto frame = read(bench);
  BISS_ASSERT(frame.ok());
  BISS_EXPECT_EQ(frame->channel_list[0].position, 0x1234567);
}

BISS_TEST(Slave, WithoutChannels_KeepsTheClocksItAlwaysTakes) {
  Bench fixed({.ack_clocks = 4});
  fixed.slave[0].set_channels_active(false);
  fixed.clock(8);
  BISS_EXPECT_EQ(fixed.bits.bytes()[0], 0b1000'0100);
  Bench late({.busy_s_clocks = 2});
  late.slave[0].set_channels_active(false);
  late.clock(8);
  BISS_EXPECT_EQ(late.bits.bytes()[0], 0b1000'1000);
}

BISS_TEST(Slave, ExtraClocks_AreZeros) {
  Bench bench({});
  bench.clock(frame_clocks + 20);
  const BitView bits = bench.bits.view();
  for (std::size_t i = frame_clocks - 1; i < bits.size_bits(); ++i) {
    BISS_EXPECT(!bits[i]) << i;
  }
  BISS_EXPECT(bench.slave[0].state() == SlaveState::stop);
}

BISS_TEST(Slave, EarlyRequest_IsNotAnsweredUntilAWholeTimeout) {
  for (const TimeoutRule rule : {TimeoutRule::fixed, TimeoutRule::cycle}) {
    Bench bench({.timeout = {rule, microseconds(100)}});
    bench.clock(frame_clocks);
    bench.wait(microseconds(3));
    const Picoseconds begin = bench.now;
    bench.bits.clear();
    bench.clock(frame_clocks);
    BISS_EXPECT(bench.slave[0].state() == SlaveState::early_request);
    BISS_EXPECT_EQ(bench.bits.view().find(true, 0), frame_clocks);
    BISS_EXPECT_EQ(bench.log.samples, 1);
    bench.time_to_idle();
    const Picoseconds last_edge = begin + period * frame_clocks - half;
    const Picoseconds counted_from = rule == TimeoutRule::cycle ? begin : last_edge;
    BISS_EXPECT_EQ((bench.now - counted_from).count, microseconds(100).count);
    bench.bits.clear();
    bench.clock(frame_clocks);
    BISS_EXPECT(read(bench).ok());
  }
}

BISS_TEST(Slave, GlitchOnMa_EndsAtTheStaticTimeout) {
  Bench bench({.timeout = {TimeoutRule::adaptive, {}}, .static_timeout = microseconds(15)});
  bench.put(false);
  bench.wait(nanoseconds(5));
  bench.put(true);
  BISS_EXPECT(bench.slave[0].state() == SlaveState::latched);
  BISS_EXPECT_EQ((bench.out[0].deadline - bench.now).count, microseconds(15).count);
  bench.wait(microseconds(15));
  BISS_EXPECT(bench.slave[0].state() == SlaveState::idle);
  BISS_EXPECT_EQ(bench.log.cdm_count, 0);
}

BISS_TEST(Slave, StepsBetweenTheEdges_ChangeNothing) {
  Bench bench({.sampling = nanoseconds(3'250), .timeout = {TimeoutRule::adaptive, {}}});
  Bench other = bench;
  other.slave[0].source().log = &other.log;
  bench.log.position = other.log.position = 0x155'5555;
  bench.clock(frame_clocks + 5);
  for (unsigned i = 0; i < frame_clocks + 5; ++i) {
    for (const bool ma : {false, true}) {
      other.put(ma);
      for (int part = 0; part < 5; ++part) {
        other.wait(half / 5);
        other.put(ma);
      }
    }
    other.bits.append(other.out[0].level);
  }
  BISS_EXPECT(std::ranges::equal(bench.bits.bytes(), other.bits.bytes()));
  BISS_EXPECT_EQ(bench.log.samples, other.log.samples);
}

BISS_TEST(Slave, StateNames_AreTheEnumerators) {
  BISS_EXPECT(name_of(SlaveState::idle) == "idle");
  BISS_EXPECT(name_of(SlaveState::early_request) == "early_request");
  BISS_EXPECT(name_of(SlaveState::chain_busy) == "chain_busy");
}

// The slave in a constant expression, and the optional parts of its owner.
constexpr bool first_bits_are_right() {
  Bench bench({});
  bench.clock(4);
  return bench.bits.bytes()[0] == 0b1010'0000;
}
static_assert(first_bits_are_right());
struct NoCdm {
  Codec::Frame sample(Picoseconds);
  bool cds(bool);
};
static_assert(!SlaveSource<NoCdm, Codec>);

}  // namespace biss::test::slave_test
