#include "biss/base/bit_buffer.hpp"
#include "biss/base/bits.hpp"
#include "biss/base/result.hpp"
#include "biss/base/units.hpp"
#include "biss/base/wrapping_time.hpp"
#include "biss/master/request_setup.hpp"
#include "biss/master/spi_read.hpp"
#include "biss/safety/monitor.hpp"
#include "biss/timing/device_timing.hpp"
#include "tests/core/test.hpp"

namespace biss::base_test {

enum class Cause : std::uint8_t { none, small, large };

constexpr Result<int, Cause> half(int value) {
  if (value < 0) return failure(Cause::small);
  if (value > 100) return failure(Cause::large);
  return value / 2;
}

static_assert(half(10).ok() && *half(10) == 5);
static_assert(half(-1).error() == Cause::small);

/// The contract of word(), computed bit by bit.
std::uint64_t plain_word(const BitView& view, std::size_t index, unsigned count) {
  std::uint64_t value = 0;
  for (unsigned i = 0; i < count; ++i) value = (value << 1U) | (view[index + i] ? 1U : 0U);
  return value;
}

/// The contract of find(), computed bit by bit.
std::size_t plain_find(const BitView& view, bool level, std::size_t from) {
  for (std::size_t i = from; i < view.size_bits(); ++i) {
    if (view[i] == level) return i;
  }
  return view.size_bits();
}

template <std::size_t N>
std::array<std::uint8_t, N> random_bytes(test::Random& random) {
  std::array<std::uint8_t, N> bytes{};
  for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random.bits(8));
  return bytes;
}

constexpr std::array<std::uint8_t, 9> sample{0xA5, 0x0F, 0x00, 0xFF, 0x12, 0x34, 0x56, 0x78, 0x9A};

static_assert(BitView(sample).word(0, 8) == 0xA5);
static_assert(BitView(sample).word(4, 64) == 0x50F00FF123456789);
static_assert(BitView(sample).find(true, 12) == 12 && BitView(sample).find(true, 16) == 24);

BISS_TEST(Units, Constructors_CountPicoseconds) {
  BISS_EXPECT_EQ(picoseconds(7).count, 7);
  BISS_EXPECT_EQ(nanoseconds(-3).count, -3'000);
  BISS_EXPECT_EQ(microseconds(40).count, 40'000'000);
  BISS_EXPECT_EQ(milliseconds(20).count, 20'000'000'000);
}

BISS_TEST(Units, Arithmetic_KeepsSignAndOrder) {
  Picoseconds t = microseconds(1);
  t += nanoseconds(5);
  t -= nanoseconds(10);
  BISS_EXPECT_EQ(t.count, 995'000);
  BISS_EXPECT_EQ((-t).count, -995'000);
  BISS_EXPECT(-t < t);
  BISS_EXPECT_EQ(t + t, t * 2);
  BISS_EXPECT_EQ(t - t, Picoseconds{});
  BISS_EXPECT_EQ(3 * t, t * 3);
  BISS_EXPECT_EQ((nanoseconds(10) / 4).count, 2'500);
}

BISS_TEST(Units, PeriodOfRate_RoundsToNearestPicosecond) {
  BISS_EXPECT_EQ(period_of(megahertz(10)).count, 100'000);
  BISS_EXPECT_EQ(period_of(hertz(3)).count, 333'333'333'333);
  BISS_EXPECT_EQ(period_of(hertz(3'000'000)).count, 333'333);
  BISS_EXPECT_EQ(period_of(hertz(7'000'000)).count, 142'857);
  BISS_EXPECT_EQ(period_of(kilohertz(1'500)).count, 666'667);
  BISS_EXPECT_EQ(period_of(Hertz{}).count, 0);
  BISS_EXPECT_EQ(period_of(hertz(UINT32_MAX)).count, 233);
}

BISS_TEST(Units, RateOfPeriod_RoundsAndSaturates) {
  BISS_EXPECT_EQ(rate_of(microseconds(4)).count, 250'000);
  BISS_EXPECT_EQ(rate_of(picoseconds(666'667)).count, 1'499'999);
  BISS_EXPECT_EQ(rate_of(Picoseconds{}).count, 0);
  BISS_EXPECT_EQ(rate_of(picoseconds(-5)).count, 0);
  BISS_EXPECT_EQ(rate_of(picoseconds(1)).count, UINT32_MAX);
  BISS_EXPECT_EQ(rate_of(picoseconds(233)).count, 4'291'845'494U);
}

// A constant expression has no overflow: the compiler would refuse it.
static_assert(megahertz(4'294) == hertz(4'294'000'000) && megahertz(5'000) == hertz_max);
static_assert(kilohertz(4'294'967) < hertz_max && kilohertz(4'294'968) == hertz_max);
static_assert(rate_of(Picoseconds{std::numeric_limits<std::int64_t>::max()}) == hertz(0));
static_assert(clocks_to_cover(Picoseconds{std::numeric_limits<std::int64_t>::max()},
                              picoseconds(2)) == std::int64_t{1} << 62U);

// A bare number is not a time, rate or length: neither by conversion nor by the braces of an
// aggregate around it, which initialise the first member of an aggregate inside.
template <class Unit>
inline constexpr bool is_named_only =
    !std::is_aggregate_v<Unit> && !std::is_convertible_v<int, Unit> &&
    !std::is_convertible_v<std::int64_t, Unit> && !std::is_convertible_v<double, Unit>;
static_assert(is_named_only<Picoseconds> && is_named_only<Hertz> && is_named_only<Millimetres> &&
              is_named_only<Nanovolts>);
static_assert(std::is_trivially_copyable_v<Picoseconds> && std::is_trivially_copyable_v<Hertz>);

template <class T>
concept TakesABarePeriod = requires {
  T{.period = 100};
}
|| requires { T{.period = {100}}; };
template <class T>
concept TakesBareLimits = requires {
  T{.clock_max = 10};
}
|| requires { T{.cycle_min = 31}; };
template <class T>
concept TakesABareTime = requires {
  T{TimeoutRule::fixed, 31};
};
template <class T>
concept TakesTwoBareNumbers = requires {
  T{1, 2};
}
|| requires { T{{1}, {2}}; };

BISS_TEST(Units, BareNumberInAnAggregate_DoesNotCompile) {
  BISS_EXPECT(!TakesABarePeriod<SpiSetup> && !TakesABarePeriod<MasterSetup>);
  BISS_EXPECT(!TakesBareLimits<DeviceTiming> && !TakesBareLimits<SafetySetup>);
  BISS_EXPECT(!TakesTwoBareNumbers<LineDelayRange> && !TakesTwoBareNumbers<TwoClocks>);
  BISS_EXPECT(!TakesABareTime<Timeout>);
  BISS_EXPECT_EQ(SpiSetup{.period = nanoseconds(100)}.period.count, 100'000);
}

BISS_TEST(Units, RateAboveTheHighest_IsTheHighest) {
  const std::uint32_t most = hertz_max.count;
  for (const std::uint32_t number : {std::uint32_t{4'295}, std::uint32_t{5'000}, most}) {
    BISS_EXPECT(megahertz(number) == hertz_max) << number;
  }
  BISS_EXPECT(kilohertz(most) == hertz_max);
}

BISS_TEST(Units, ClocksToCover_RoundsUp) {
  const Picoseconds period = nanoseconds(100);
  BISS_EXPECT_EQ(clocks_to_cover(nanoseconds(1'000), period), 10);
  BISS_EXPECT_EQ(clocks_to_cover(nanoseconds(1'001), period), 11);
  BISS_EXPECT_EQ(clocks_to_cover(picoseconds(1), period), 1);
  BISS_EXPECT_EQ(clocks_to_cover(Picoseconds{}, period), 0);
  BISS_EXPECT_EQ(clocks_to_cover(nanoseconds(-1), period), 0);
}

BISS_TEST(WrappingTime, TimesOnBothSidesOfTheWrap_AreAsFarApartAsOnTheClock) {
  constexpr Picoseconds last{std::numeric_limits<std::int64_t>::max()};
  constexpr Picoseconds first{std::numeric_limits<std::int64_t>::min()};
  static_assert(wrapping_later(last, picoseconds(1)) == first);
  static_assert(wrapping_later(first, picoseconds(-1)) == last);
  static_assert(wrapping_elapsed(last, first) == picoseconds(1));
  static_assert(wrapping_elapsed(first, last) == picoseconds(-1));
  for (const Picoseconds from : {first, picoseconds(-5), Picoseconds{}, last}) {
    for (const Picoseconds by : {-milliseconds(1), Picoseconds{}, milliseconds(1), last}) {
      BISS_EXPECT_EQ(wrapping_elapsed(from, wrapping_later(from, by)).count, by.count);
    }
  }
}

BISS_TEST(Result, Value_IsOkAndReads) {
  const auto result = half(42);
  BISS_ASSERT(result.ok());
  BISS_EXPECT(static_cast<bool>(result));
  BISS_EXPECT_EQ(*result, 21);
  BISS_EXPECT_EQ(result.value(), 21);
}

BISS_TEST(Result, Failure_KeepsItsCause) {
  BISS_ASSERT(!half(-1).ok());
  BISS_EXPECT_EQ(half(-1).error(), Cause::small);
  BISS_EXPECT_EQ(half(101).error(), Cause::large);
}

BISS_TEST(Result, ArrowAndCopy_ReachTheValue) {
  const Result<Hertz, Cause> result = megahertz(2);
  const auto copy = result;  // NOLINT(performance-unnecessary-copy-initialization)
  BISS_EXPECT_EQ(copy->count, 2'000'000);
  static_assert(std::is_trivially_copyable_v<Result<Hertz, Cause>>);
}

BISS_TEST(Bits, LowMask_CoversNoneToAll) {
  BISS_EXPECT_EQ(low_mask(0), 0);
  BISS_EXPECT_EQ(low_mask(1), 1);
  BISS_EXPECT_EQ(low_mask(63), UINT64_MAX >> 1U);
  BISS_EXPECT_EQ(low_mask(64), UINT64_MAX);
}

BISS_TEST(Bits, EmptyView_FindsNothing) {
  const BitView view;
  BISS_EXPECT(view.empty());
  BISS_EXPECT_EQ(view.find(true, 0), 0);
  BISS_EXPECT_EQ(view.find(false, 5), 0);
  BISS_EXPECT_EQ(view.word(0, 0), 0);
  BISS_EXPECT(view.from(3).empty());
  BISS_EXPECT(view.first(3).empty());
}

BISS_TEST(Bits, ViewPastTheBytes_IsCutOff) {
  const std::span<const std::uint8_t> bytes(sample);
  BISS_EXPECT_EQ(BitView(bytes, 0, 1'000).size_bits(), 72);
  BISS_EXPECT_EQ(BitView(bytes, 70, 8).size_bits(), 2);
  BISS_EXPECT_EQ(BitView(bytes, 72, 1).size_bits(), 0);
  BISS_EXPECT_EQ(BitView(bytes, SIZE_MAX, SIZE_MAX).size_bits(), 0);
  BISS_EXPECT_EQ(BitView(bytes, 5, SIZE_MAX).size_bits(), 67);
}

BISS_TEST(Bits, FromAndFirst_CutTheView) {
  const BitView view(std::span<const std::uint8_t>(sample), 4, 24);
  BISS_EXPECT_EQ(view.from(4).word(0, 8), 0x0F);
  BISS_EXPECT_EQ(view.from(4).size_bits(), 20);
  BISS_EXPECT_EQ(view.from(25).size_bits(), 0);
  BISS_EXPECT_EQ(view.first(9).size_bits(), 9);
  BISS_EXPECT_EQ(view.first(99).size_bits(), 24);
  BISS_EXPECT_EQ(view.first(9).from(4).word(0, 5), 1);
}

// Each view lies in a buffer of exactly its bytes, so that a sanitizer sees a read past the end.
BISS_TEST(Bits, WordAtEveryAlignmentAndCount_EqualsBitByBit) {
  BISS_RANDOM(random, 0xB155'0001);
  const auto bytes = random_bytes<21>(random);
  for (std::size_t size = 0; size <= bytes.size(); ++size) {
    const auto part = std::span<const std::uint8_t>(bytes).last(size);
    for (std::size_t first = 0; first <= 8U && first <= size * 8U; ++first) {
      const std::size_t rest = size * 8U - first;
      const BitView view(part, first, rest - std::min<std::size_t>(rest, first % 3U));
      for (std::size_t index = 0; index <= view.size_bits(); ++index) {
        for (unsigned count = 0; count <= 64U && index + count <= view.size_bits(); ++count) {
          BISS_ASSERT_EQ(view.word(index, count), plain_word(view, index, count))
              << "size " << size << " first " << first << " index " << index << " count " << count;
        }
      }
    }
  }
}

BISS_TEST(Bits, FindInSparseAndDenseBits_EqualsBitByBit) {
  BISS_RANDOM(random, 0xB155'0002);
  const std::uint64_t rounds = test::rounds(20'000, 1'000);
  for (std::uint64_t round = 0; round < rounds; ++round) {
    std::array<std::uint8_t, 40> bytes{};
    bytes.fill(random.flip() ? std::uint8_t{0xFF} : std::uint8_t{0});
    for (std::uint32_t flips = random.below(4); flips > 0; --flips) {
      auto& byte = bytes[random.below(40)];
      byte = static_cast<std::uint8_t>(byte ^ (1U << random.below(8)));
    }
    const auto part = std::span<const std::uint8_t>(bytes).last(random.below(41));
    const BitView view(part, random.below(20), random.below(330));
    const bool level = random.flip();
    const std::size_t from = random.below(340);
    BISS_ASSERT_EQ(view.find(level, from), plain_find(view, level, from))
        << "round " << round << " size " << view.size_bits() << " from " << from;
  }
}

BISS_TEST(Bits, FindWithMatchOnlyPastTheEnd_ReportsTheSize) {
  const std::array<std::uint8_t, 12> bytes{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xFF};
  for (std::size_t size = 0; size <= 88; ++size) {
    const BitView view(std::span<const std::uint8_t>(bytes), 0, size);
    BISS_EXPECT_EQ(view.find(true, 0), size);
  }
  BISS_EXPECT_EQ(BitView(bytes).find(true, 0), 88);
  BISS_EXPECT_EQ(BitView(bytes).find(true, 95), 95);
  BISS_EXPECT_EQ(BitView(bytes).find(false, 88), 96);
}

BISS_TEST(BitBuffer, AppendedWords_ReadBackInOrder) {
  BISS_RANDOM(random, 0xB155'0003);
  BitBuffer<512> buffer;
  std::array<std::uint64_t, 16> words{};
  std::array<unsigned, 16> counts{};
  for (std::size_t i = 0; i < words.size(); ++i) {
    counts[i] = static_cast<unsigned>(random.below(33));
    words[i] = random.bits(counts[i]);
    buffer.append(words[i], counts[i]);
  }
  std::size_t at = 0;
  for (std::size_t i = 0; i < words.size(); at += counts[i++]) {
    BISS_EXPECT_EQ(buffer.view().word(at, counts[i]), words[i]) << "word " << i;
  }
  BISS_EXPECT_EQ(buffer.size_bits(), at);
  BISS_EXPECT(!buffer.overflowed());
}

BISS_TEST(BitBuffer, AppendPastCapacity_KeepsWhatFitsAndSaysSo) {
  BitBuffer<13> buffer;
  buffer.append(0x1A5B, 13);
  BISS_EXPECT(!buffer.overflowed());
  buffer.append(0x7, 3);
  BISS_EXPECT(buffer.overflowed());
  BISS_EXPECT_EQ(buffer.size_bits(), 13);
  BISS_EXPECT_EQ(buffer.view().word(0, 13), 0x1A5B);
  BISS_EXPECT_EQ(buffer.bytes().size(), 2);
  BISS_EXPECT_EQ(buffer.bytes()[1], 0xD8);
  buffer.clear();
  BISS_EXPECT(!buffer.overflowed());
  BISS_EXPECT_EQ(buffer.size_bits(), 0);
}

BISS_TEST(BitBuffer, RunFlipAndTruncate_ChangeOnlyTheirBits) {
  BitBuffer<64> buffer;
  buffer.append_run(true, 20);
  buffer.append_run(false, 10);
  buffer.flip(3);
  buffer.flip(25);
  BISS_EXPECT_EQ(buffer.view().word(0, 30), 0x3BFF'FC10U);
  buffer.truncate(26);
  BISS_EXPECT_EQ(buffer.size_bits(), 26);
  buffer.append_run(false, 4);
  BISS_EXPECT_EQ(buffer.view().word(0, 30), 0x3BFF'FC10U);
  buffer.truncate(2);
  BISS_EXPECT_EQ(buffer.bytes()[0], 0xC0);
  buffer.append_run(true, 100);
  BISS_EXPECT(buffer.overflowed());
  BISS_EXPECT_EQ(buffer.size_bits(), 64);
}

}  // namespace biss::base_test
