// Slaves in a daisy chain: SLO of one is SLI of the next.
#include "biss/frame/decode.hpp"
#include "biss/slave/slave.hpp"
#include "tests/core/frames.hpp"
#include "tests/core/slave_bench.hpp"
#include "tests/core/test.hpp"

namespace biss::test::slave_chain_test {

struct Chain : SlaveChain<TestSlave, 3> {
  std::array<Log, 3> log{};
};

constexpr SlaveTiming chained(SlaveTiming timing) {
  timing.chained = true;
  return timing;
}

constexpr Timeout short_timeout{TimeoutRule::fixed, nanoseconds(12'500)};
constexpr Timeout long_timeout{TimeoutRule::fixed, microseconds(30)};

Chain chain_of(const SlaveTiming& first, const SlaveTiming& second, const SlaveTiming& third) {
  const TestCodec codec(format_of("pos5,nE,nW,crc6"));
  return {{{TestSlave(codec, first, {}), TestSlave(codec, chained(second), {}),
            TestSlave(codec, chained(third), {})}}};
}

void own(Chain& chain) {
  for (std::size_t k = 0; k < 3; ++k) {
    chain.slave[k].source().log = &chain.log[k];
    chain.log[k].position = 9 + k;
  }
}

/// The three channels as the master sees them, last slave first.
void expect_chain(const Chain& chain, unsigned ack_clocks) {
  const FrameCodec<CrcFast, 3> codec(format_of("pos5,nE,nW,crc6+pos5,nE,nW,crc6+pos5,nE,nW,crc6"));
  const auto frame = decode_frame(chain.bits.view(), codec, FrameBounds{});
  BISS_ASSERT(frame.ok()) << static_cast<int>(frame.error().cause);
  BISS_EXPECT_EQ(frame->ack_clocks, ack_clocks);
  for (std::size_t k = 0; k < 3; ++k) {
    BISS_EXPECT_EQ(frame->channel_list[k].position, 9 + 2 - k);
  }
}

BISS_TEST(SlaveChain, Three_HandStartOnAndSendLastFirst) {
  Chain chain =
      chain_of({.timeout = long_timeout}, {.timeout = short_timeout}, {.timeout = short_timeout});
  own(chain);
  chain.log[0].cds = true;
  chain.clock(5 + 2 + 3 * 13 + 3);
  expect_chain(chain, 3);
  BISS_EXPECT(chain.bits.view()[5]);  // CDS
  BISS_EXPECT(!chain.bits.view()[5 + 3 * 13 + 1]);
}

BISS_TEST(SlaveChain, LateFurtherSlave_KeepsItsPredecessorsBits) {
  for (const int clocks : {1, 4, 17, 80}) {
    Chain chain = chain_of({.timeout = long_timeout}, {.timeout = long_timeout},
                           {.ready = period * clocks, .timeout = long_timeout});
    own(chain);
    chain.clock(5 + 2 + 3 * 13 + 90);
    expect_chain(chain, static_cast<unsigned>(std::max(clocks, 3)));
  }
}

BISS_TEST(SlaveChain, SlaveWithoutChannels_LeavesNoGap) {
  for (std::size_t off = 0; off < 3; ++off) {
    Chain chain =
        chain_of({.timeout = long_timeout}, {.timeout = short_timeout}, {.timeout = short_timeout});
    own(chain);
    chain.slave[off].set_channels_active(false);
    chain.log[1].cds = true;
    chain.clock(5 + 2 + 2 * 13 + 3);
    const FrameCodec<CrcFast, 2> codec(format_of("pos5,nE,nW,crc6+pos5,nE,nW,crc6"));
    const auto frame = decode_frame(chain.bits.view(), codec, FrameBounds{});
    BISS_ASSERT(frame.ok()) << off;
    BISS_EXPECT(frame->cds);
    BISS_EXPECT_EQ(frame->ack_clocks, 3);
    BISS_EXPECT_EQ(frame->channel_list[0].position, off == 2 ? 10 : 11);
    BISS_EXPECT_EQ(frame->channel_list[1].position, off == 0 ? 10 : 9);
  }
}

BISS_TEST(SlaveChain, CdsOfThePredecessor_IsTheOwnersToPassOn) {
  struct Inverter {
    TestCodec::Frame sample(Picoseconds) const { return {}; }
    bool cds(bool predecessor) const { return !predecessor; }
    void cdm(bool) const {}
  };
  const TestCodec codec(format_of("pos5,nE,nW,crc6"));
  for (const bool sent : {false, true}) {
    Slave<TestCodec, Inverter> slave(codec, chained({}), {});
    std::uint32_t line = 0;
    for (unsigned i = 0; i < 6; ++i) {
      const Picoseconds now = period * (i + 1);
      slave.step(now, false, i == 3 || (i == 4 && sent));  // ACK, START, CDS
      line = line * 2 + slave.step(now + half, true, false).level;
    }
    BISS_EXPECT_EQ(line, sent ? 0b100100U : 0b100110U);
  }
}

BISS_TEST(SlaveChain, LastSlave_IsIdleOnlyBehindItsPredecessors) {
  Chain chain =
      chain_of({.timeout = long_timeout}, {.timeout = short_timeout}, {.timeout = short_timeout});
  own(chain);
  chain.clock(5 + 2 + 3 * 13 + 3);
  chain.wait(nanoseconds(12'500));
  BISS_EXPECT(chain.slave[2].state() == SlaveState::chain_busy);
  BISS_EXPECT(!chain.out[2].level);
  BISS_EXPECT_EQ(chain.log[2].cdm_count, 1);
  chain.wait(microseconds(30) - nanoseconds(12'500) - half);
  for (std::size_t k = 0; k < 3; ++k) {
    BISS_EXPECT(chain.slave[k].state() == SlaveState::idle) << k;
    BISS_EXPECT_EQ(chain.log[k].cdm_count, 1);
  }
  chain.bits.clear();
  chain.clock(5 + 2 + 3 * 13 + 3);
  expect_chain(chain, 3);
}

BISS_TEST(SlaveChain, RequestWhilePredecessorIsBusy_IsEarly) {
  Chain chain =
      chain_of({.timeout = long_timeout}, {.timeout = short_timeout}, {.timeout = short_timeout});
  own(chain);
  chain.clock(5 + 2 + 3 * 13 + 3);
  chain.wait(microseconds(15));
  BISS_EXPECT(chain.slave[2].state() == SlaveState::chain_busy);
  chain.bits.clear();
  chain.clock(60);
  BISS_EXPECT(chain.slave[2].state() == SlaveState::early_request);
  BISS_EXPECT_EQ(chain.bits.view().find(true, 0), 60);
  chain.wait(microseconds(31));
  BISS_EXPECT(chain.slave[2].state() == SlaveState::idle);
  BISS_EXPECT(chain.out[2].level);
}

}  // namespace biss::test::slave_chain_test
