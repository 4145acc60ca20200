// Millions of damaged buffers: as many are accepted with a wrong position as
// lab/reports/lost-start.md states.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <span>
#include <string_view>

#include "biss/frame/codec.hpp"
#include "biss/frame/encode.hpp"
#include "biss/frame/format_text.hpp"
#include "biss/master/spi_read.hpp"
#include "tests/core/random.hpp"
#include "tests/spi/effort.hpp"
#include "tests/spi/rates.hpp"

namespace biss::test::spi::damage_test {

/// Buffers per case; BISS_DAMAGED_BUFFERS changes the number.
std::uint64_t buffers(std::uint64_t usual) {
  const char* const wanted = std::getenv("BISS_DAMAGED_BUFFERS");
  if (wanted != nullptr) return std::strtoull(wanted, nullptr, 10);
  return slow_build ? usual / 100 : usual;
}

struct Case {
  std::string_view format;
  unsigned least_ack = 1;
  unsigned most_ack = 1;
  /// Clocks of line delay, 0…most.
  unsigned most_delay = 1;
  SpiTail tail = SpiTail::must_stay_low;
  bool cds = false;
  /// Further channels carry the top bits of the first one's position.
  bool aligned_words = false;
  /// SLO is low at first, as after a cable with an encoder of fixed cycle time. The number of zeros
  /// is the largest possible one, or less.
  bool late = false;
};

constexpr Picoseconds period = nanoseconds(100);

/// Frames of one case with a random position, ACK and line delay each.
template <std::size_t Channels>
class Bench {
  using Codec = FrameCodec<CrcFast, Channels>;

 public:
  Bench(const Case& the_case, std::uint64_t seed)
      : case_(the_case),
        codec_(*parse_format(the_case.format)),
        reader_(codec_,
                {.period = period,
                 .line_delay = {{}, period * the_case.most_delay},
                 .tail = the_case.tail,
                 .no_error_flag = true},
                {.start_min = period * (the_case.least_ack + 1),
                 .ack_max = period * the_case.most_ack,
                 .timeout = {the_case.late ? TimeoutRule::cycle : TimeoutRule::fixed,
                             nanoseconds(31'250)}}),
        random_(seed),
        rates_(codec_.format(), {.cds = the_case.cds,
                                 .aligned_words = the_case.aligned_words,
                                 .tail_checked = the_case.tail == SpiTail::must_stay_low}) {}

  /// The number of accepted transfers, of `count` with START read as 0, is the computed one.
  void lose_start(std::uint64_t count) {
    run(count, "START lost", [this](const Transfer& transfer) {
      bits_.flip(transfer.lead_clocks + transfer.ack_clocks);
    });
    double expected = 0;
    each_transfer([&](const Transfer& transfer) { expected += rates_.lost_start(transfer); });
    check(count, expected);
  }

  /// The same with one bit inverted, anywhere in the buffer.
  void flip_any_bit(std::uint64_t count) {
    const auto buffer_bits = static_cast<std::uint32_t>(reader_.bytes() * 8);
    run(count, "one bit",
        [this, buffer_bits](const Transfer&) { bits_.flip(random_.below(buffer_bits)); });
    double expected = 0;
    each_transfer([&](const Transfer& transfer) {
      for (std::size_t i = 0; i < transfer.clocks; ++i) {
        expected += rates_.flipped(transfer, i) / buffer_bits;
      }
    });
    check(count, expected);
  }

 private:
  static constexpr std::size_t room_bits = 2048;

  template <class Visit>
  void each_transfer(Visit visit) {
    transfers_ = 0;
    for (unsigned delay = 0; delay < case_.most_delay; ++delay) {
      for (unsigned ack = case_.least_ack; ack <= case_.most_ack; ++ack) {
        visit(Transfer{2 + delay, ack, reader_.clocks(), reader_.bounds()});
        ++transfers_;
      }
    }
  }

  template <class Damage>
  void run(std::uint64_t count, const char* what, Damage damage) {
    std::printf("%.*s, %s: ", static_cast<int>(case_.format.size()), case_.format.data(), what);
    wrong_ = 0;
    for (std::uint64_t i = 0; i < count; ++i) {
      Transfer transfer;
      transfer.lead_clocks = 2 + random_.below(case_.most_delay);
      transfer.ack_clocks = case_.least_ack + random_.below(case_.most_ack - case_.least_ack + 1);
      write(transfer);
      damage(transfer);
      const auto frame = reader_.read(bits_.bytes(), reader_.clocks());
      if (!frame.ok()) continue;
      const unsigned start = transfer.lead_clocks + transfer.ack_clocks;
      if (unsigned{frame->lead_clocks} + frame->ack_clocks != start) ++wrong_;
    }
  }

  void write(const Transfer& transfer) {
    bits_.fill_front(transfer.lead_clocks);
    if (case_.late) {
      const unsigned most =
          std::min<unsigned>(transfer.lead_clocks - 1U, reader_.bounds().late_max_clocks);
      for (unsigned zeros = random_.below(most + 1U); zeros != 0; --zeros) bits_.flip(zeros - 1U);
    }
    std::size_t at = transfer.lead_clocks + transfer.ack_clocks;
    bits_.put(at, case_.cds ? 3 : 2, 2);
    at += 2;
    const FrameFormat& format = codec_.format();
    std::uint64_t first = 0;
    std::uint64_t position = 0;
    for (std::size_t k = 0; k < format.channel_count; ++k) {
      const ChannelFormat& channel = format.channel_list[k];
      if (k == 0 || !case_.aligned_words) {
        position = random_.bits(channel.position_bits());
      } else {
        position = first >> (format.channel_list[0].position_bits() - channel.position_bits());
      }
      if (k == 0) first = position;
      const auto counter = static_cast<std::uint32_t>(random_.bits(channel.life_counter.bits));
      const std::uint64_t data =
          biss::pack(channel, {.position = position, .life_counter = counter});
      bits_.put(at, data, channel.data_bits);
      at += channel.data_bits;
      bits_.put(at, codec_.crc(k, data, false), channel.crc.width_bits);
      at += channel.crc.width_bits;
    }
  }

  void check(std::uint64_t count, double expected_sum) {
    const double share = expected_sum / static_cast<double>(transfers_);
    const double expected = share * static_cast<double>(count);
    const double sigma = std::sqrt(expected * (1 - share));
    std::printf("%llu of %llu pass, %.1f +- %.1f computed\n",
                static_cast<unsigned long long>(wrong_), static_cast<unsigned long long>(count),
                expected, sigma);
    // Small expected counts are not Gaussian.
    const double margin = share == 0 ? 0 : std::max(5 * sigma, 5.0);
    EXPECT_LE(std::abs(static_cast<double>(wrong_) - expected), margin);
  }

  /// A buffer that is filled quickly.
  class Bits {
   public:
    void fill_front(std::size_t ones) {
      bytes_.fill(0);
      for (std::size_t i = 0; i < ones; ++i) flip(i);
    }
    void flip(std::size_t at) {
      bytes_[at / 8] = static_cast<std::uint8_t>(bytes_[at / 8] ^ (0x80U >> (at % 8)));
    }
    void put(std::size_t at, std::uint64_t value, unsigned count) {
      while (count > 0) {
        const auto take = std::min(count, static_cast<unsigned>(8 - at % 8));
        const std::uint64_t part = (value >> (count - take)) & low_mask(take);
        bytes_[at / 8] = static_cast<std::uint8_t>(bytes_[at / 8] | (part << (8 - at % 8 - take)));
        at += take;
        count -= take;
      }
    }
    std::span<const std::uint8_t> bytes() const { return bytes_; }

   private:
    std::array<std::uint8_t, room_bits / 8> bytes_{};
  };

  Case case_;
  Codec codec_;
  SpiReader<Codec> reader_;
  Random random_;
  Rates rates_;
  Bits bits_;
  std::uint64_t wrong_ = 0;
  std::uint64_t transfers_ = 0;
};

template <std::size_t Channels>
void damage(const Case& the_case, std::uint64_t seed, std::uint64_t count) {
  std::printf("seed 0x%llX\n", static_cast<unsigned long long>(seed));
  const auto bench = std::make_unique<Bench<Channels>>(the_case, seed);
  bench->lose_start(count);
  bench->flip_any_bit(count);
}

constexpr std::uint64_t ten_million = 10'000'000;
constexpr std::uint64_t million = 1'000'000;

TEST(SpiDamage, Renishaw18Bits_PassAtTheComputedRate) {
  damage<1>({"pos18,nE,nW,crc6;cds0", 32, 160, 3}, 0xDA18, buffers(ten_million));
}

TEST(SpiDamage, Renishaw18BitsBehindZeros_PassAtTheSameRate) {
  damage<1>({.format = "pos18,nE,nW,crc6;cds0",
             .least_ack = 32,
             .most_ack = 160,
             .most_delay = 8,
             .late = true},
            0xDA17, buffers(million));
}

TEST(SpiDamage, WidestAckTailIgnored_PassAtTheComputedRate) {
  damage<1>({"pos18,nE,nW,crc6", 1, 60, 8, SpiTail::ignored}, 0xDA19, buffers(million));
}

TEST(SpiDamage, LoneAckBit_PassesAtTheComputedRate) {
  // ACK of one clock: if it is lost, the leading ones extend into the data.
  damage<1>({"pos18,nE,nW,crc6;cds0", 1, 4, 6, SpiTail::ignored}, 0xDA1A, buffers(million));
  damage<1>({"pos12,nE,nW,crc4", 1, 4, 6, SpiTail::must_stay_low, true}, 0xDA1B, buffers(million));
}

TEST(SpiDamage, NarrowChecksums_PassAtTheComputedRate) {
  damage<1>({"pos24,nE,nW,crc3", 1, 40, 4, SpiTail::ignored}, 0xDA20, buffers(million));
  damage<1>({"pos24,crc4:0x13:plain", 1, 40, 4, SpiTail::ignored, true}, 0xDA21, buffers(million));
  damage<1>({"st22,nE,nW,crc5;cds0", 1, 40, 4}, 0xDA22, buffers(million));
  damage<1>({"mt12,st20,E,W,crc8:0x12F:0x5A", 1, 40, 4, SpiTail::ignored}, 0xDA23,
            buffers(million));
}

TEST(SpiDamage, WiderPositions_PassAtTheComputedRate) {
  damage<1>({"pos26,nE,nW,crc6;cds0", 32, 160, 2}, 0xDA26, buffers(million));
  damage<1>({"pos32,nE,nW,crc6;cds0", 32, 160, 2, SpiTail::ignored}, 0xDA32, buffers(million));
  damage<1>({"pos36,nE,nW,crc6", 32, 160, 2, SpiTail::ignored}, 0xDA36, buffers(million));
}

TEST(SpiDamage, SeveralChannels_PassAtTheComputedRate) {
  damage<2>({"pos28,nE,nW,crc6+pos24,nE,nW,lc6,crc16;cds0", 32, 160, 2}, 0xDA52, buffers(million));
  damage<2>({"pos8,nE,nW,crc3+pos7,nE,nW,crc3", 1, 30, 3, SpiTail::ignored}, 0xDA53,
            buffers(million));
}

TEST(SpiDamage, SafetyWordsOfOnePosition_PassAtTheComputedRate) {
  damage<2>(
      {"pos28,nE,nW,crc6+pos24,nE,nW,lc6,crc16;cds0", 32, 160, 2, SpiTail::ignored, false, true},
      0xDA54, buffers(million));
  damage<2>({"pos9,nE,nW,crc3+pos7,nE,nW,lc2,crc3", 1, 30, 3, SpiTail::ignored, false, true},
            0xDA55, buffers(million));
  damage<2>({"pos10,nE,nW,crc3+pos5,lc2,crc3", 1, 60, 3, SpiTail::must_stay_low, false, true},
            0xDA56, buffers(million));
}

}  // namespace biss::test::spi::damage_test
