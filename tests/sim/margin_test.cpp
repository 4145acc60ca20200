// `marginal` as the simulated master reports it, and as the decoder reports it from the capture.
#include <gtest/gtest.h>

#include <vector>

#include "biss/catalogue/renishaw.hpp"
#include "decode/decoder.hpp"
#include "sim/line.hpp"
#include "tests/exhaustive/scale.hpp"

namespace biss::campaign::margin_test {

// 26 bits at 5 MHz: a period is 200 ns.
sim::LineSetup line_with_delay(Picoseconds delay, bool compensate) {
  sim::LineSetup setup;
  setup.format = renishaw_encoders[1].frame_format();
  setup.timing = renishaw_encoders[1].timing;
  setup.clock = megahertz(5);
  setup.slo_delay = delay;
  setup.compensate = compensate;
  setup.motion = sim::MotionKind::random;
  return setup;
}

struct Flags {
  std::vector<bool> master;
  std::vector<std::optional<bool>> decoder;
};

Flags run(const sim::LineSetup& setup, std::uint64_t cycles) {
  Flags flags;
  decode::Decoder decoder(
      decode::CycleReader(setup.format, setup.timing, {.compensated = setup.compensate}),
      [&](const decode::Cycle& cycle) { flags.decoder.push_back(cycle.marginal); });
  decoder.push_ma({{}, wire::Level::high});
  decoder.push_slo({{}, wire::Level::high});
  sim::Line line(setup);
  for (std::uint64_t i = 0; i < cycles; ++i) {
    const sim::SimulatedCycle& cycle = line.next();
    flags.master.push_back(cycle.reading.marginal);
    decoder.push(cycle.edges, {.ma = sim::ma_line, .slo = sim::slo_line});
  }
  decoder.finish(line.end());
  return flags;
}

void expect_all(const sim::LineSetup& setup, bool marginal) {
  constexpr std::size_t cycles = 20;
  const Flags flags = run(setup, cycles);
  EXPECT_EQ(flags.master, std::vector<bool>(cycles, marginal));
  EXPECT_EQ(flags.decoder, std::vector<std::optional<bool>>(cycles, marginal));
}

TEST(Margin, CableThatPutsTheChangeFivePercentFromTheSample_IsToldFromOneThatDoesNot) {
  for (const std::int64_t whole : {0, 1, 4}) {
    SCOPED_TRACE(whole);
    const Picoseconds sample = nanoseconds(200) * whole + nanoseconds(100);
    for (const std::int64_t side : {-1, 1}) {
      SCOPED_TRACE(side);
      // 4.9 % and 5.1 % of the period.
      expect_all(line_with_delay(sample + side * picoseconds(9'800), false), true);
      expect_all(line_with_delay(sample + side * picoseconds(10'200), false), false);
      // A master that compensates the delay is not affected.
      expect_all(line_with_delay(sample + side * picoseconds(9'800), true), false);
    }
  }
}

TEST(Margin, JitterAroundTheBound_MasterAndDecoderAgreeOnEveryCycle) {
  sim::LineSetup setup = line_with_delay(picoseconds(88'000), false);
  setup.slo_jitter = picoseconds(2'100);
  const std::uint64_t cycles = exhaustive::rounds(5'000);
  const Flags flags = run(setup, cycles);
  ASSERT_EQ(flags.decoder.size(), flags.master.size());
  std::uint64_t marginal = 0;
  for (std::size_t i = 0; i < flags.master.size(); ++i) {
    EXPECT_EQ(flags.decoder[i], flags.master[i]) << i;
    marginal += flags.master[i] ? 1U : 0U;
  }
  EXPECT_GT(marginal, cycles / 20);
  EXPECT_LT(marginal, cycles * 19 / 20);
}

}  // namespace biss::campaign::margin_test
