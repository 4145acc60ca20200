#include "biss/axis/counters.hpp"
#include "biss/axis/freshness.hpp"
#include "biss/frame/fixed.hpp"
#include "biss/frame/format_text.hpp"
#include "biss/frame/frame.hpp"
#include "biss/master/spi_read.hpp"
#include "biss/safety/verdict.hpp"
#include "tests/core/test.hpp"

namespace biss::axis_test {

// ---- Counters

static_assert(CauseCounts<FrameError>::size == frame_error_count);
static_assert(CauseCounts<SafetyVerdict>::size == safety_verdict_count);

BISS_TEST(CauseCounts, EveryVerdict_HasItsOwnCounter) {
  struct {
    std::array<std::uint32_t, 16> before{};
    CauseCounts<SafetyVerdict> counts;
    std::array<std::uint32_t, 16> after{};
  } memory;
  for (std::size_t i = 0; i < safety_verdict_count; ++i) {
    for (std::size_t n = 0; n <= i; ++n) memory.counts.add(verdict_of(i));
  }
  for (std::size_t i = 0; i < safety_verdict_count; ++i) {
    BISS_EXPECT_EQ(memory.counts[verdict_of(i)], i + 1);
  }
  for (const std::uint32_t word : memory.before) BISS_EXPECT_EQ(word, 0U);
  for (const std::uint32_t word : memory.after) BISS_EXPECT_EQ(word, 0U);
}

// The same as after a fault of the memory.
BISS_TEST(CauseCounts, EveryValueOfTheType_IsCountedInside) {
  CauseCounts<SafetyVerdict> verdicts;
  std::uint32_t no_cause = 0;
  for (std::uint32_t value = 0; value <= 0xFFFF; ++value) {
    const auto verdict = static_cast<SafetyVerdict>(value);
    if (index_of(verdict) == safety_verdict_count) ++no_cause;
    verdicts.add(verdict);
  }
  BISS_EXPECT_EQ(verdicts[static_cast<SafetyVerdict>(0)], no_cause);
  BISS_EXPECT_EQ(no_cause, 0x10000U - safety_verdict_count);
  BISS_EXPECT_EQ(verdicts[SafetyVerdict::stimulus], 1U);

  CauseCounts<FrameError> errors;
  for (std::uint32_t value = 0; value <= 0xFF; ++value) errors.add(static_cast<FrameError>(value));
  BISS_EXPECT_EQ(errors[FrameError::stop_bit], 1U);
  BISS_EXPECT_EQ(errors[static_cast<FrameError>(0xFF)], 0x100U - frame_error_count);
}

// ---- Freshness

constexpr FrameFormat format = frame_format("pos24,nE,nW,crc6");
constexpr SpiReader reader(FixedCodec<format>{}, SpiSetup{.period = nanoseconds(100)},
                           DeviceTiming{});
using Buffer = FreshBuffer<reader.bytes()>;

constexpr auto refuse = [](std::span<std::uint8_t>) { return false; };
constexpr auto accept = [](std::span<std::uint8_t>) { return true; };

BISS_TEST(FreshBuffer, BytesThatAreNotWritten_AreNoResponse) {
  Buffer buffer;
  for (int i = 0; i < 4; ++i) {
    std::span<std::uint8_t> receive;
    const bool started = buffer.begin(reader.bytes(), [&receive](std::span<std::uint8_t> into) {
      receive = into;
      return true;
    });
    BISS_ASSERT(started);
    if (i < 2) std::fill(receive.begin(), receive.end(), std::uint8_t{0x5A});
    const auto received = buffer.end();
    BISS_ASSERT(received);
    BISS_EXPECT_EQ(received->size(), reader.bytes());
    const auto frame = reader.read(*received);
    BISS_ASSERT(!frame.ok());
    BISS_EXPECT_EQ(frame.error().cause == FrameError::no_response, i >= 2) << i;
  }
}

BISS_TEST(FreshBuffer, EndThatNothingWaitsFor_HasNoBytes) {
  Buffer buffer;
  BISS_EXPECT(!buffer.end());
  BISS_EXPECT(!buffer.begin(reader.bytes(), refuse));
  BISS_EXPECT(!buffer.end());
  BISS_EXPECT_EQ(buffer.number(), 0U);
  BISS_EXPECT(buffer.begin(reader.bytes(), accept));
  BISS_EXPECT(buffer.waits());
  BISS_EXPECT_EQ(buffer.number(), 1U);
  BISS_EXPECT(buffer.end().has_value());
  BISS_EXPECT(!buffer.end());
}

// What the DMA still writes to is not filled.
BISS_TEST(FreshBuffer, RequestThatIsRefused_LeavesTheRunningOneAlone) {
  Buffer buffer;
  std::span<std::uint8_t> running;
  BISS_ASSERT(buffer.begin(3, [&running](std::span<std::uint8_t> into) {
    running = into;
    return true;
  }));
  running[0] = 0x12;
  BISS_EXPECT(!buffer.begin(reader.bytes(), refuse));
  running[1] = 0x34;
  const auto received = buffer.end();
  BISS_ASSERT(received);
  BISS_EXPECT_EQ(received->size(), 3U);
  BISS_EXPECT_EQ((*received)[0], 0x12);
  BISS_EXPECT_EQ((*received)[1], 0x34);
  BISS_EXPECT_EQ((*received)[2], 0xFF);
  BISS_EXPECT_EQ(buffer.number(), 1U);
}

BISS_TEST(FreshBuffer, MoreBytesThanItHas_AreRefused) {
  Buffer buffer;
  bool asked = false;
  const auto note = [&asked](std::span<std::uint8_t>) { return asked = true; };
  BISS_EXPECT(!buffer.begin(0, note));
  BISS_EXPECT(!buffer.begin(reader.bytes() + 1, note));
  BISS_EXPECT(!buffer.begin(std::numeric_limits<std::size_t>::max(), note));
  BISS_EXPECT(!asked);
  BISS_EXPECT(!buffer.waits());
  BISS_EXPECT(buffer.begin(reader.bytes(), note));
}

}  // namespace biss::axis_test
