// An encoder with a fixed cycle time, requested exactly when it is ready: the buffer begins while
// SLO is still low. A frame is read if and only if it would be read after leading ones.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <vector>

#include "biss/catalogue/catalogue.hpp"
#include "biss/frame/codec.hpp"
#include "biss/frame/encode.hpp"
#include "biss/frame/format_text.hpp"
#include "biss/master/spi_read.hpp"
#include "tests/core/random.hpp"
#include "tests/spi/effort.hpp"
#include "tests/spi/line_model.hpp"

namespace biss::test::spi::late_test {

using Codec = FrameCodec<CrcTable<4>, 1>;
using Reader = SpiReader<Codec>;
using Read = Result<Reader::Frame, FrameFault>;
using Samples = std::vector<std::uint8_t>;

constexpr DeviceTiming renishaw = catalogue_encoder("resolute-18").timing;

/// The same device with another timeout rule, which never permits leading zeros.
constexpr DeviceTiming without_cycle_time(DeviceTiming timing) {
  timing.timeout = {TimeoutRule::fixed, timing.timeout.time};
  return timing;
}

Samples samples_of(const Clock& clock, std::uint64_t position, unsigned ack, std::int64_t delay,
                   std::size_t clocks) {
  Output output;
  append_request(output, ack, false);
  const std::uint64_t data = (position << 2U) | 3U;
  append_bits(output, data, 20);
  append_bits(output, checksum(data, 20, 0x43, 6), 6);
  Samples samples;
  sample(output, clock, delay, clocks, samples);
  return samples;
}

/// SLO was low until `rise` after the request, as seen by the master.
std::size_t keep_low(Samples& samples, const Clock& clock, std::int64_t rise) {
  std::size_t zeros = 0;
  while (clock.sample(zeros) < rise + (clock.tie == Tie::old_level ? 1 : 0)) samples[zeros++] = 0;
  return zeros;
}

Read read(const Reader& reader, const Samples& samples) {
  std::vector<std::uint8_t> bytes;
  pack(samples, 0, 0, bytes);
  return reader.read(bytes, samples.size());
}

bool is(const Read& frame, FrameError cause) { return !frame.ok() && frame.error().cause == cause; }

SpiSetup setup_of(const Clock& clock, std::int64_t delay_max) {
  return {.period = picoseconds(clock.period),
          .phase =
              clock.edge == Edge::rising ? SpiPhase::sample_on_rising : SpiPhase::sample_on_falling,
          .line_delay = {{}, picoseconds(delay_max)}};
}

/// The leading zeros replaced by ones.
Samples with_ones(Samples samples) {
  std::fill(samples.begin(), std::find(samples.begin(), samples.end(), 1), std::uint8_t{1});
  return samples;
}

bool same(const Read& a, const Read& b) {
  if (a.ok() != b.ok()) return false;
  if (a.ok()) {
    return a->channel_list == b->channel_list && a->lead_clocks == b->lead_clocks &&
           a->ack_clocks == b->ack_clocks && a->stop_seen == b->stop_seen;
  }
  return a.error().cause == b.error().cause && a.error().channel == b.error().channel;
}

/// At each clock rate, with each cable, with either phase and any reading of a tie, SLO rises at
/// any time up to the line delay.
TEST(SpiLate, EncoderReadyJustAsTheRequestComes_IsRead) {
  const Codec codec(*parse_format("pos18,nE,nW,crc6;cds0"));
  Random random(0x1A7E);
  std::uint64_t frames = 0;
  std::uint64_t late_frames = 0;
  for (const std::int64_t period : {100'000, 200'000, 500'000, 1'000'000, 4'000'000}) {
    for (const Edge edge : {Edge::rising, Edge::falling}) {
      for (const Tie tie : {Tie::old_level, Tie::new_level}) {
        const Clock clock{.period = period, .edge = edge, .tie = tie};
        const std::int64_t longest = 1'042'500;
        const Reader reader(codec, setup_of(clock, longest), renishaw);
        const Reader strict(codec, setup_of(clock, longest), without_cycle_time(renishaw));
        const AckBounds ack = ack_bounds(renishaw, picoseconds(period));
        for (std::int64_t delay = 2'500; delay <= longest; delay += 20'000) {
          for (std::int64_t rise = 0; rise <= delay; rise += slow_build ? 170'000 : 10'000) {
            const std::uint64_t position = random.bits(18);
            const unsigned clocks_of_ack =
                ack.min_clocks + random.below(ack.max_clocks - ack.min_clocks + 1U);
            Samples samples = samples_of(clock, position, clocks_of_ack, delay, reader.clocks());
            const std::size_t zeros = keep_low(samples, clock, rise);
            const Read frame = read(reader, samples);
            ASSERT_TRUE(frame.ok() && frame->channel_list[0].position == position)
                << period << ' ' << delay << ' ' << rise;
            ASSERT_EQ(frame->ack_clocks, clocks_of_ack);
            const LineDelayRange seen = observed_line_delay(*frame, setup_of(clock, longest));
            ASSERT_LE(seen.min.count, delay);
            ASSERT_GE(seen.max.count, delay);
            ASSERT_LE(zeros, reader.bounds().late_max_clocks);
            ++frames;
            if (zeros == 0) continue;
            ASSERT_TRUE(is(read(strict, samples), FrameError::not_ready));
            ++late_frames;
          }
        }
      }
    }
  }
  std::printf("%llu frames, %llu of them after zeros\n", static_cast<unsigned long long>(frames),
              static_cast<unsigned long long>(late_frames));
  EXPECT_GT(late_frames, frames / 3);
}

/// After a rise later than the permitted line delay, or than that of any cable, no frame is
/// accepted.
TEST(SpiLate, SloLowForLonger_IsNotReady) {
  const Codec codec(*parse_format("pos18,nE,nW,crc6;cds0"));
  for (const std::int64_t permitted : {0, 42'500, 250'000, 1'042'500, 40'000'000}) {
    for (const Edge edge : {Edge::rising, Edge::falling}) {
      const Clock clock{.period = 100'000, .edge = edge};
      const Reader reader(codec, setup_of(clock, permitted), renishaw);
      const std::int64_t longest = std::min<std::int64_t>(permitted, 1'042'500);
      for (std::size_t zeros = 1; zeros < 40; ++zeros) {
        const bool within = clock.sample(zeros - 1) <= longest;
        EXPECT_EQ(within, zeros <= reader.bounds().late_max_clocks) << permitted << ' ' << zeros;
        // The longest line, or one that leaves a 1 after the zeros.
        const std::size_t lead = std::max<std::size_t>(reader.bounds().lead_max_clocks, zeros + 1);
        const auto delay = static_cast<std::int64_t>(lead - 2) * 100'000;
        Samples samples = samples_of({.period = 100'000}, 0x2ABCD, 40, delay, 600);
        std::fill_n(samples.begin(), zeros, std::uint8_t{0});
        EXPECT_EQ(is(read(reader, samples), FrameError::not_ready), !within) << zeros;
      }
      EXPECT_TRUE(is(read(reader, Samples(300, 0)), FrameError::not_ready));
    }
  }
}

/// Zeros, ones, and no ACK in time: the encoder was not ready and did not receive the request.
TEST(SpiLate, SloThatRisesAndStays_IsNotReady) {
  const Codec codec(*parse_format("pos18,nE,nW,crc6;cds0"));
  const Reader reader(codec, setup_of({}, 1'042'500), renishaw);
  for (std::size_t zeros = 1; zeros <= reader.bounds().late_max_clocks; ++zeros) {
    Samples samples(reader.clocks(), 1);
    std::fill_n(samples.begin(), zeros, std::uint8_t{0});
    EXPECT_TRUE(is(read(reader, samples), FrameError::not_ready)) << zeros;
    std::fill(samples.begin() + 60, samples.end(), std::uint8_t{0});
    EXPECT_TRUE(is(read(reader, samples), FrameError::not_ready)) << zeros;
  }
}

/// In any buffer, leading zeros have the same effect as leading ones: every accepted frame would
/// also be accepted after ones, with the same position.
TEST(SpiLate, AnyBuffer_IsReadAsIfItBeganWithOnes) {
  Random random(0x1A7F);
  std::uint64_t read_late = 0;
  std::uint64_t not_ready = 0;
  for (const char* const format :
       {"pos18,nE,nW,crc6;cds0", "pos12,nE,nW,crc4", "pos24,nE,nW,crc3"}) {
    const Codec codec(*parse_format(format));
    for (std::uint64_t round = 0; round < (slow_build ? 20'000U : 2'000'000U); ++round) {
      const Clock clock{.edge = random.flip() ? Edge::rising : Edge::falling};
      DeviceTiming timing = renishaw;
      timing.start_min = nanoseconds(100 * random.below(8));
      timing.ack_max = nanoseconds(1'000);
      SpiSetup setup = setup_of(clock, 100'000 * random.below(9));
      setup.tail = SpiTail::ignored;
      const Reader reader(codec, setup, timing);
      const Reader strict(codec, setup, without_cycle_time(timing));
      Samples samples(reader.clocks());
      std::size_t at = random.below(5);  // zeros
      for (std::size_t ones = 1 + random.below(4); ones != 0 && at < samples.size(); --ones) {
        samples[at++] = 1;
      }
      at += random.below(12);
      for (; at < samples.size(); ++at) samples[at] = random.flip() ? 1 : 0;
      const auto zeros =
          static_cast<std::size_t>(std::find(samples.begin(), samples.end(), 1) - samples.begin());
      const Read frame = read(reader, samples);
      Read expected =
          read(strict, zeros <= reader.bounds().late_max_clocks ? with_ones(samples) : samples);
      if (zeros != 0 &&
          (is(expected, FrameError::no_response) || is(expected, FrameError::response_range))) {
        expected = failure(FrameFault{FrameError::not_ready});
      }
      ASSERT_TRUE(same(frame, expected)) << format << ' ' << round;
      if (zeros != 0 && frame.ok()) ++read_late;
      if (zeros != 0 && is(frame, FrameError::not_ready)) ++not_ready;
    }
  }
  std::printf("%llu read after zeros, %llu not ready\n", static_cast<unsigned long long>(read_late),
              static_cast<unsigned long long>(not_ready));
  EXPECT_GT(read_late, 0U);
  EXPECT_GT(not_ready, 0U);
}

/// One or two wrong samples anywhere in a frame of any device that began with ones. If it is
/// accepted only because leading zeros are permitted, START is where the encoder sent it.
TEST(SpiLate, OneOrTwoWrongSamples_NeverMakeAnotherStartPassThroughThis) {
  const FrameFormat format = *parse_format("pos12,nE,nW,crc4");
  const Codec codec(format);
  Random random(0x1A80);
  std::uint64_t through_this = 0;
  for (unsigned least_ack = 1; least_ack <= 33; least_ack += 8) {
    for (const Edge edge : {Edge::rising, Edge::falling}) {
      const Clock clock{.edge = edge};
      DeviceTiming timing = renishaw;
      timing.start_min = nanoseconds(100) * (least_ack + 1);
      timing.ack_max = nanoseconds(100) * (least_ack + 4);
      SpiSetup setup = setup_of(clock, 700'000);
      setup.tail = SpiTail::ignored;
      const Reader reader(codec, setup, timing);
      const Reader strict(codec, setup, without_cycle_time(timing));
      for (unsigned round = 0; round < (slow_build ? 100U : 4'000U); ++round) {
        const unsigned lead = 2 + random.below(reader.bounds().lead_max_clocks - 1U);
        const unsigned ack = least_ack + random.below(4);
        BasicFrame<1> sent;
        sent.channel_count = 1;
        sent.lead_clocks = static_cast<std::uint16_t>(lead);
        sent.ack_clocks = static_cast<std::uint16_t>(ack);
        sent.channel_list[0].position = random.bits(12);
        const auto bits = encode_frame(sent, codec);
        Samples whole(reader.clocks(), 0);
        for (std::size_t i = 0; i < bits->size_bits(); ++i) whole[i] = bits->view()[i] ? 1 : 0;
        // The first sample is wrong, or zeros would not come first.
        for (std::size_t second = 0; second < whole.size(); ++second) {
          Samples damaged = whole;
          damaged[0] = 0;
          if (second != 0) damaged[second] ^= 1U;
          const Read frame = read(reader, damaged);
          if (!frame.ok()) continue;
          ++through_this;
          // START was not read as a leading one.
          ASSERT_LT(std::find(damaged.begin(), damaged.end(), 1) - damaged.begin(), lead);
          // The zeros are equivalent to ones. If that leaves one wrong sample elsewhere, it is
          // accepted as rarely as without zeros.
          if (with_ones(damaged) != whole) {
            ASSERT_TRUE(read(strict, with_ones(damaged)).ok());
            continue;
          }
          ASSERT_EQ(unsigned{frame->lead_clocks} + frame->ack_clocks, lead + ack) << second;
          ASSERT_EQ(frame->channel_list[0].position, sent.channel_list[0].position);
        }
      }
    }
  }
  EXPECT_GT(through_this, 1'000U);
}

/// The same for a frame that did begin with zeros: one wrong sample among the zeros or the ones
/// never moves START.
TEST(SpiLate, WrongSampleBeforeAck_NeverMovesStart) {
  const Codec codec(*parse_format("pos18,nE,nW,crc6;cds0"));
  Random random(0x1A81);
  for (const std::int64_t period : {100'000, 200'000, 500'000, 1'000'000, 4'000'000}) {
    for (const Edge edge : {Edge::rising, Edge::falling}) {
      const Clock clock{.period = period, .edge = edge};
      const Reader reader(codec, setup_of(clock, 1'042'500), renishaw);
      const AckBounds ack = ack_bounds(renishaw, picoseconds(period));
      for (unsigned round = 0; round < (slow_build ? 200U : 20'000U); ++round) {
        const std::int64_t delay = 1 + random.below(1'042'500);
        const unsigned clocks_of_ack =
            ack.min_clocks + random.below(ack.max_clocks - ack.min_clocks + 1U);
        const std::uint64_t position = random.bits(18);
        Samples samples = samples_of(clock, position, clocks_of_ack, delay, reader.clocks());
        const auto lead = static_cast<std::size_t>(std::find(samples.begin(), samples.end(), 0) -
                                                   samples.begin());
        keep_low(samples, clock, delay);
        for (std::size_t at = 0; at < lead; ++at) {
          Samples damaged = samples;
          damaged[at] ^= 1U;
          const Read frame = read(reader, damaged);
          if (!frame.ok()) continue;
          ASSERT_EQ(frame->channel_list[0].position, position) << period << ' ' << delay;
          ASSERT_EQ(frame->lead_clocks + std::size_t{frame->ack_clocks}, lead + clocks_of_ack);
        }
      }
    }
  }
}

}  // namespace biss::test::spi::late_test
