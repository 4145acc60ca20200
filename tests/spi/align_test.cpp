// Every bit offset × ACK × line delay × clock phase × width: the frame, or a cause.
#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include "biss/frame/codec.hpp"
#include "biss/frame/format_text.hpp"
#include "biss/master/spi_read.hpp"
#include "tests/core/random.hpp"
#include "tests/spi/effort.hpp"
#include "tests/spi/line_model.hpp"

namespace biss::test::spi::align_test {

using Codec = FrameCodec<CrcTable<4>, 1>;
using Reader = SpiReader<Codec>;

constexpr std::int64_t period = 100'000;
constexpr unsigned longest_ack = 160;
/// In hundredths of a period.
constexpr std::array<std::int64_t, 8> fractions{0, 1, 10, 25, 49, 50, 75, 99};
constexpr std::array<unsigned, 10> offsets{0, 1, 2, 3, 4, 5, 6, 7, 13, 64};
constexpr std::int64_t longest_delay_clocks = 8;

/// A channel has 64 data bits; the two widest positions leave no room for both flags.
constexpr unsigned widest = 64;
constexpr bool has_flags(unsigned width) { return width + 2 <= widest; }

FrameFormat format_of(unsigned width) {
  const char* const rest = has_flags(width) ? ",nE,nW,crc6;cds0" : ",crc6;cds0";
  return *parse_format("pos" + std::to_string(width) + rest);
}

std::vector<std::int64_t> delays() {
  std::vector<std::int64_t> list;
  for (std::int64_t clocks = 0; clocks < longest_delay_clocks; ++clocks) {
    for (const std::int64_t part : fractions) list.push_back((clocks * 100 + part) * period / 100);
  }
  list.push_back(longest_delay_clocks * period);
  return list;
}

SpiPhase phase_of(Edge edge) {
  return edge == Edge::rising ? SpiPhase::sample_on_rising : SpiPhase::sample_on_falling;
}

/// A device whose ACK lies within `least` and `most` clocks.
DeviceTiming acks(unsigned least, unsigned most) {
  return {.start_min = picoseconds(period * (least + 1)), .ack_max = picoseconds(period * most)};
}

SpiSetup setup_of(Edge edge, std::int64_t least, std::int64_t most, unsigned first_bit) {
  return {.period = picoseconds(period),
          .phase = phase_of(edge),
          .line_delay = {picoseconds(least), picoseconds(most)},
          .first_bit = static_cast<std::uint16_t>(first_bit),
          .no_error_flag = true};
}

/// One position of one width, encoded and sampled.
class Bench {
 public:
  explicit Bench(unsigned width, std::uint64_t seed)
      : width_(width), codec_(format_of(width)), random_(seed) {}

  const Codec& codec() const { return codec_; }

  /// A new position, sampled with the number of clocks of `reader`; bits outside are random.
  void send(const Reader& reader, const Clock& clock, unsigned ack, std::int64_t delay,
            unsigned first_bit) {
    position_ = random_.bits(width_);
    // Positions with few ones are those whose first 1 is far from START.
    if (random_.below(4) == 0) position_ &= 7;
    const unsigned data_bits = has_flags(width_) ? width_ + 2 : width_;
    const std::uint64_t data = has_flags(width_) ? (position_ << 2U) | 3U : position_;
    output_.clear();
    append_request(output_, ack, false);
    append_bits(output_, data, data_bits);
    append_bits(output_, checksum(data, data_bits, 0x43, 6), 6);
    sample(output_, clock, delay, reader.clocks(), samples_);
    pack(samples_, first_bit, random_.next(), bytes_);
    clocks_ = reader.clocks();
  }

  Result<Reader::Frame, FrameFault> read(const Reader& reader) const {
    return reader.read(bytes_, clocks_);
  }
  /// As if the clock had stopped too early.
  Result<Reader::Frame, FrameFault> read_first(const Reader& reader, std::size_t clocks) const {
    return reader.read(bytes_, clocks);
  }

  /// The frame is the one that was sent.
  bool right(const Reader& reader, unsigned ack) const {
    const auto frame = read(reader);
    return frame.ok() && frame->channel_list[0].position == position_ && frame->trusted() &&
           frame->ack_clocks == ack && frame->stop_seen;
  }

  std::optional<FrameError> cause(const Reader& reader) const {
    const auto frame = read(reader);
    if (frame.ok()) return std::nullopt;
    return frame.error().cause;
  }

 private:
  unsigned width_;
  Codec codec_;
  Random random_;
  std::uint64_t position_ = 0;
  Output output_;
  std::vector<std::uint8_t> samples_;
  std::vector<std::uint8_t> bytes_;
  std::size_t clocks_ = 0;
};

constexpr unsigned width_step = slow_build ? 23 : 1;

/// Wide bounds: every frame within them is read.
TEST(SpiAlign, EveryOffsetAckDelayPhaseWidth_GivesTheFrame) {
  std::printf("seed 0xA11, widths 18 to 64 by %u\n", width_step);
  std::uint64_t frames = 0;
  const std::vector<std::int64_t> delay_list = delays();
  for (unsigned width = 18; width <= widest; width += width_step) {
    Bench bench(width, 0xA11 + width);
    for (const Edge edge : {Edge::rising, Edge::falling}) {
      for (const unsigned first_bit : offsets) {
        const Reader reader(bench.codec(),
                            setup_of(edge, 0, longest_delay_clocks * period, first_bit),
                            acks(1, longest_ack));
        for (const std::int64_t delay : delay_list) {
          const Clock clock{.period = period, .edge = edge};
          for (unsigned ack = 1; ack <= longest_ack; ack += slow_build ? 7 : 1) {
            bench.send(reader, clock, ack, delay, first_bit);
            ASSERT_TRUE(bench.right(reader, ack)) << "width " << width << " offset " << first_bit
                                                  << " delay " << delay << " ACK " << ack;
            ++frames;
          }
        }
      }
    }
  }
  std::printf("%llu frames\n", static_cast<unsigned long long>(frames));
}

/// Bounds that fit the line exactly accept it, whatever a tie reads; bounds that are wrong by one
/// step give the cause.
TEST(SpiAlign, BoundsOfOneDelayAndOneAck_AcceptThatAndNothingElse) {
  for (unsigned width = 18; width <= widest; width += slow_build ? 23 : 4) {
    Bench bench(width, 0xB0 + width);
    for (const Edge edge : {Edge::rising, Edge::falling}) {
      for (const std::int64_t delay : delays()) {
        for (const unsigned ack : {2U, 3U, 33U, 160U}) {
          for (const Tie tie : {Tie::old_level, Tie::new_level}) {
            // No line has a delay of 0: a sampling edge cannot read the change that it causes.
            if (delay == 0 && edge == Edge::rising && tie == Tie::new_level) continue;
            const Clock clock{.period = period, .edge = edge, .tie = tie};
            const Reader exact(bench.codec(), setup_of(edge, delay, delay, 3), acks(ack, ack));
            bench.send(exact, clock, ack, delay, 3);
            ASSERT_TRUE(bench.right(exact, ack)) << delay << ' ' << ack;
            const Reader longer(bench.codec(),
                                setup_of(edge, delay + 2 * period, delay + 3 * period, 3),
                                acks(ack, ack));
            EXPECT_EQ(bench.cause(longer), FrameError::response_range) << delay << ' ' << ack;
            const Reader slower(bench.codec(), setup_of(edge, delay, delay, 3),
                                acks(ack + 1, ack + 9));
            EXPECT_EQ(bench.cause(slower), FrameError::ack_range) << delay << ' ' << ack;
            const Reader faster(bench.codec(), setup_of(edge, delay, delay, 3), acks(1, ack - 1));
            EXPECT_EQ(bench.cause(faster), FrameError::ack_range) << delay << ' ' << ack;
            if (delay < 2 * period) continue;
            const Reader shorter(bench.codec(), setup_of(edge, 0, delay - 2 * period, 3),
                                 acks(ack, ack));
            EXPECT_EQ(bench.cause(shorter), FrameError::response_range) << delay << ' ' << ack;
          }
        }
      }
    }
  }
}

/// The delay range of a frame contains the delay of the line.
TEST(SpiAlign, ObservedLineDelay_HoldsTheDelayOfTheLine) {
  Bench bench(26, 0xDE1A);
  for (const Edge edge : {Edge::rising, Edge::falling}) {
    const SpiSetup setup = setup_of(edge, 0, longest_delay_clocks * period, 0);
    const Reader reader(bench.codec(), setup, acks(1, 40));
    for (const std::int64_t delay : delays()) {
      bench.send(reader, Clock{.period = period, .edge = edge}, 17, delay, 0);
      const auto frame = bench.read(reader);
      ASSERT_TRUE(frame.ok());
      const LineDelayRange seen = observed_line_delay(*frame, setup);
      EXPECT_LE(seen.min.count, delay);
      EXPECT_GE(seen.max.count, delay);
    }
  }
}

/// Fewer clocks than the frame needs never give a position.
TEST(SpiAlign, EveryPrefix_GivesACauseUntilTheLastCrcBit) {
  for (unsigned width = 18; width <= widest; width += slow_build ? 23 : 1) {
    Bench bench(width, 0x7A0 + width);
    const Reader reader(bench.codec(), setup_of(Edge::rising, 0, 3 * period, 5), acks(1, 60));
    for (const unsigned ack : {1U, 33U, 60U}) {
      const std::int64_t delay = period * 3 / 2;
      bench.send(reader, Clock{.period = period}, ack, delay, 5);
      const std::size_t last_crc = 3 + ack + 2 + width + (has_flags(width) ? 8 : 6);
      for (std::size_t clocks = 0; clocks < last_crc; ++clocks) {
        const auto frame = bench.read_first(reader, clocks);
        ASSERT_FALSE(frame.ok());
        if (clocks > 3 + ack) {
          EXPECT_EQ(frame.error().cause, FrameError::truncated);
        }
      }
      EXPECT_TRUE(bench.read_first(reader, last_crc).ok());
    }
  }
}

}  // namespace biss::test::spi::align_test
