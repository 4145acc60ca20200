// A master and a slave on two delay lines, one for MA and one for SLO.
#include "biss/catalogue/catalogue.hpp"
#include "biss/frame/fixed.hpp"
#include "biss/master/request.hpp"
#include "biss/slave/slave.hpp"
#include "tests/core/frames.hpp"
#include "tests/core/scripted_slo.hpp"
#include "tests/core/test.hpp"

namespace master_slave_test {

using namespace biss;

/// The position is the sampling time in steps of 25 ns.
struct Encoder {
  Picoseconds sampled{};
  bool next_cds = false;
  bool last_cdm = false;
  std::uint32_t frames = 0;

  static constexpr std::uint64_t position_at(Picoseconds time) {
    return static_cast<std::uint64_t>(time.count / 25'000) & low_mask(18);
  }
  BasicFrame<1> sample(Picoseconds moment) {
    sampled = moment;
    BasicFrame<1> frame;
    frame.channel_count = 1;
    frame.channel_list[0].position = position_at(moment);
    return frame;
  }
  bool cds(bool predecessor) { return predecessor || next_cds; }
  void cdm(bool bit) {
    last_cdm = bit;
    ++frames;
  }
};

constexpr FrameFormat format = test::format_of("pos18,nE,nW,crc6");
constexpr FrameFormat chain_format =
    test::format_of("pos18,nE,nW,crc6+pos18,nE,nW,crc6+pos18,nE,nW,crc6");
using Codec = FixedCodec<format>;
using ChainCodec = FixedCodec<chain_format>;
constexpr std::size_t chain_bits = 64;

/// A master, its cable, and slaves in a daisy chain; slave 0 is at the far end.
template <class MasterCodec, std::size_t Slaves>
struct Link {
  using Encoders = std::array<Slave<Codec, Encoder, Slaves == 1 ? 0 : chain_bits>, Slaves>;

  RequestCycle<MasterCodec> master;
  Encoders slaves;
  test::DelayLine way_out;
  test::DelayLine way_back;
  Picoseconds now{};
  StepOutput driven{};
  std::array<StepOutput, Slaves> answered{};

  void step(Picoseconds time) {
    now = time;
    const bool ma = way_out.level(now);
    bool sli = false;
    for (std::size_t k = 0; k < Slaves; ++k) {
      answered[k] = slaves[k].step(now, ma, sli);
      sli = answered[k].level;
    }
    way_back.put(now, sli);
    drive(master.step(now, way_back.level(now)));
  }
  void drive(StepOutput output) {
    driven = output;
    way_out.put(now, driven.level);
  }
  Picoseconds next() const {
    Picoseconds first = std::min(driven.deadline, std::min(way_out.next(), way_back.next()));
    for (const StepOutput& slave : answered) first = std::min(first, slave.deadline);
    return first;
  }
  void rest_until(Picoseconds time) {
    while (next() < time) step(next());
    now = time;
  }
  /// Makes a request at the earliest permitted time.
  const auto& request(bool cdm = false) {
    rest_until(std::max(now, master.earliest()));
    drive(master.begin(now, way_back.level(now), cdm));
    for (std::uint32_t i = 0; i < 10'000 && !master.done(); ++i) step(next());
    BISS_EXPECT(master.done());
    return master.reading();
  }
};

using Pair = Link<Codec, 1>;

Pair pair(const MasterSetup& setup, const SlaveTiming& timing, Picoseconds delay) {
  return {.master{Codec{}, setup},
          .slaves{{{Codec{}, timing, Encoder{}}}},
          .way_out{test::DelayLine(delay / 2)},
          .way_back{test::DelayLine(delay - delay / 2)}};
}

constexpr DeviceTiming resolute = catalogue_encoder("resolute-18").timing;

std::uint64_t position_of(const auto& reading, std::size_t channel = 0) {
  return reading.frame.ok() ? reading.frame->channel_list[channel].position : ~std::uint64_t{0};
}

BISS_TEST(MasterAndSlave, AnyClockAndDelay_EveryPositionIsRead) {
  for (const std::uint32_t clock : {250'000U, 1'000'000U, 2'000'000U, 5'000'000U, 10'000'000U}) {
    const Picoseconds period = period_of(hertz(clock));
    for (const std::int64_t delay : {0, 42, 500, 1'000, 1'042, 3'333, 9'999}) {
      const MasterSetup setup{.period = period, .timing = resolute};
      Pair link = pair(setup, slave_timing(resolute, microseconds(9)), nanoseconds(delay));
      Encoder& encoder = link.slaves[0].source();
      for (std::uint32_t i = 0; i < 3; ++i) {
        const auto& reading = link.request();
        BISS_ASSERT_EQ(position_of(reading), Encoder::position_at(encoder.sampled))
            << "clock " << clock << ", delay " << delay;
        BISS_ASSERT(reading.line_delay == nanoseconds(delay));
        // 3.25 us after the first rising edge as it arrives.
        BISS_ASSERT(encoder.sampled == reading.begin + period / 2 + nanoseconds(delay) / 2 +
                                           resolute.sampling_typical);
        BISS_ASSERT(!reading.marginal && reading.ready);
        BISS_ASSERT_EQ(reading.ack_clocks, clocks_to_cover(microseconds(9), period));
      }
    }
  }
}

BISS_TEST(MasterAndSlave, HighestRate_IsTheDevices) {
  Pair link = pair({.period = nanoseconds(100), .timing = resolute},
                   slave_timing(resolute, microseconds(16)), nanoseconds(520));
  constexpr std::int64_t requests = 20;
  for (std::int64_t i = 0; i < requests; ++i) BISS_ASSERT(link.request().frame.ok());
  // Each request begins when SLO has risen: the line delay after the encoder is ready.
  const Picoseconds cycle = resolute.cycle_min + nanoseconds(520);
  BISS_EXPECT(link.master.reading().begin == (requests - 1) * cycle);
}

BISS_TEST(MasterAndSlave, FixedCycleTimeTrusted_IsReachedBehindAnyCable) {
  for (const std::int64_t delay : {0, 42, 99, 100, 520, 1'042, 9'999}) {
    Pair link = pair({.period = nanoseconds(100), .timing = resolute, .trust_cycle_time = true},
                     slave_timing(resolute, microseconds(9)), nanoseconds(delay));
    Encoder& encoder = link.slaves[0].source();
    for (std::int64_t i = 0; i < 20; ++i) {
      const auto& reading = link.request();
      BISS_ASSERT(reading.begin == i * resolute.cycle_min);
      BISS_ASSERT_EQ(position_of(reading), Encoder::position_at(encoder.sampled));
      BISS_ASSERT(reading.line_delay == nanoseconds(delay));
      BISS_ASSERT(reading.ready && !reading.marginal);
    }
  }
}

BISS_TEST(MasterAndSlave, FixedCycleTimeTrusted_WaitsBehindAFrameThatOutlastsIt) {
  Pair link = pair({.period = microseconds(4), .timing = resolute, .trust_cycle_time = true},
                   slave_timing(resolute, microseconds(16)), nanoseconds(1'042));
  for (std::int64_t i = 0; i < 5; ++i) BISS_ASSERT(link.request().frame.ok());
  // 18 bits with 4 clocks of ACK: 34 clocks, the last edge half a clock sooner, 1.5 periods.
  const Picoseconds cycle = microseconds(4 * 35) + nanoseconds(1'042);
  BISS_EXPECT(link.master.reading().begin == 4 * cycle);
}

BISS_TEST(MasterAndSlave, CdmAndCds_Arrive) {
  for (const TimeoutRule rule : {TimeoutRule::adaptive, TimeoutRule::fixed, TimeoutRule::cycle}) {
    const DeviceTiming timing{.ack_max = microseconds(2), .timeout = {rule, microseconds(13)}};
    for (const std::int64_t delay : {0, 700, 6'100}) {
      Pair link = pair({.period = nanoseconds(200), .timing = timing},
                       slave_timing(timing, microseconds(1)), nanoseconds(delay));
      test::Random random(0x3C00);
      Encoder& encoder = link.slaves[0].source();
      for (std::uint32_t i = 1; i < 12; ++i) {
        const bool cdm = random.flip();
        encoder.next_cds = random.flip();
        const auto& reading = link.request(cdm);
        BISS_ASSERT_EQ(position_of(reading), Encoder::position_at(encoder.sampled));
        BISS_ASSERT_EQ(reading.frame->cds, encoder.next_cds);
        BISS_ASSERT_EQ(encoder.last_cdm, cdm)
            << "rule " << static_cast<int>(rule) << ", delay " << delay << ", frame " << i;
        BISS_ASSERT_EQ(encoder.frames, i);
      }
    }
  }
}

BISS_TEST(MasterAndSlave, BusyEncoder_IsGivenUpAndReadTheNextTime) {
  for (const TimeoutRule rule : {TimeoutRule::adaptive, TimeoutRule::fixed, TimeoutRule::cycle}) {
    const DeviceTiming timing{.ack_max = microseconds(2), .timeout = {rule, microseconds(13)}};
    SlaveTiming busy = slave_timing(timing);
    busy.ready = microseconds(5);
    Pair link = pair({.period = nanoseconds(200), .timing = timing}, busy, nanoseconds(300));
    const auto& reading = link.request();
    BISS_ASSERT(!reading.frame.ok());
    BISS_EXPECT(reading.frame.error().cause == FrameError::no_start);
    BISS_EXPECT(reading.ready);
    link.slaves[0].set_timing(slave_timing(timing, microseconds(1)));
    BISS_EXPECT(link.request().frame.ok());
  }
}

BISS_TEST(MasterAndSlave, BusyS_IsTakenWhereItIsExpected) {
  const DeviceTiming timing{.ack_max = microseconds(1)};
  SlaveTiming slow = slave_timing(timing, microseconds(1));
  slow.busy_s_clocks = 8;
  for (const std::uint8_t expected : {std::uint8_t{8}, std::uint8_t{7}}) {
    Pair link =
        pair({.period = nanoseconds(100), .timing = timing, .busy_s_clocks = expected}, slow, {});
    BISS_EXPECT_EQ(link.request().frame.ok(), expected == 8);
  }
}

BISS_TEST(MasterAndSlave, ChainOfThree_IsReadNearestFirst) {
  const DeviceTiming timing{.ack_max = microseconds(1),
                            .timeout = {TimeoutRule::fixed, nanoseconds(12'500)}};
  SlaveTiming first = slave_timing(timing, microseconds(1));
  SlaveTiming further = first;
  further.chained = true;
  further.ready = {};
  for (const std::int64_t delay : {0, 330, 4'870}) {
    Link<ChainCodec, 3> link{
        .master{ChainCodec{}, {.period = nanoseconds(100), .timing = timing, .slaves = 3}},
        .slaves{{{Codec{}, first, Encoder{}},
                 {Codec{}, further, Encoder{}},
                 {Codec{}, further, Encoder{}}}},
        .way_out{test::DelayLine(nanoseconds(delay) / 2)},
        .way_back{test::DelayLine(nanoseconds(delay) / 2)}};
    link.slaves[1].set_timing([&] {
      SlaveTiming later = further;
      later.sampling = nanoseconds(150);
      return later;
    }());
    for (int i = 0; i < 5; ++i) {
      const auto& reading = link.request(i % 2 == 1);
      BISS_ASSERT(reading.frame.ok()) << "delay " << delay;
      BISS_EXPECT(reading.ready);
      BISS_EXPECT_EQ(reading.ack_clocks, 12);
      for (std::size_t k = 0; k < 3; ++k) {
        Encoder& encoder = link.slaves[k].source();
        BISS_ASSERT_EQ(position_of(reading, 2 - k), Encoder::position_at(encoder.sampled));
        BISS_EXPECT_EQ(encoder.last_cdm, i % 2 == 1);
      }
      BISS_EXPECT(position_of(reading, 1) != position_of(reading, 0));
    }
  }
}

}  // namespace master_slave_test
