#include "biss/base/bit_buffer.hpp"
#include "biss/base/bits.hpp"
#include "biss/base/units.hpp"
#include "biss/frame/codec.hpp"
#include "biss/frame/encode.hpp"
#include "biss/frame/format_text.hpp"
#include "biss/frame/frame.hpp"
#include "biss/master/spi_read.hpp"
#include "biss/timing/device_timing.hpp"
#include "tests/core/test.hpp"

namespace biss::spi_test {

using Codec = FrameCodec<CrcTable<4>, 1>;
using Reader = SpiReader<Codec>;

constexpr Picoseconds period = nanoseconds(100);
constexpr FrameFormat format = *parse_format("pos18,nE,nW,crc6;cds0");
constexpr Codec codec(format);
/// ACK of 4…6 clocks; a timeout that does not expire while MA runs.
constexpr DeviceTiming timing{.start_min = nanoseconds(500), .ack_max = nanoseconds(600)};
constexpr SpiSetup up_to_2_clocks{.period = period, .line_delay = {{}, nanoseconds(200)}};
constexpr Reader reader(codec, up_to_2_clocks, timing);

constexpr FrameBounds bounds_of(SpiPhase phase, std::int64_t min_ns, std::int64_t max_ns) {
  return spi_bounds(
      {.period = period, .phase = phase, .line_delay = {nanoseconds(min_ns), nanoseconds(max_ns)}},
      timing);
}

constexpr bool leads(SpiPhase phase, std::int64_t min_ns, std::int64_t max_ns, unsigned least,
                     unsigned most) {
  const FrameBounds bounds = bounds_of(phase, min_ns, max_ns);
  return bounds.lead_min_clocks == least && bounds.lead_max_clocks == most;
}

constexpr SpiPhase rising = SpiPhase::sample_on_rising;
constexpr SpiPhase falling = SpiPhase::sample_on_falling;
static_assert(leads(rising, 0, 0, 2, 2) && leads(rising, 0, 99, 2, 2));
static_assert(leads(rising, 1, 100, 2, 3) && leads(rising, 100, 100, 2, 3));
static_assert(leads(rising, 101, 799, 3, 9) && leads(rising, 0, 40'000, 2, 402));
static_assert(leads(falling, 0, 49, 2, 2) && leads(falling, 0, 50, 2, 3));
static_assert(leads(falling, 51, 149, 3, 3) && leads(falling, 50, 150, 2, 4));
static_assert(leads(falling, 0, 40'000, 2, 402));
// A value above the limit of BiSS is cut to the limit.
static_assert(leads(rising, 0, 90'000, 2, 402) && leads(rising, 50'000, 90'000, 402, 402));
static_assert(bounds_of(rising, 0, 0).ack_min_clocks == 4 &&
              bounds_of(rising, 0, 0).ack_max_clocks == 6);

// 2 ones and 2 clocks of delay, 6 of ACK, START, CDS, 18 + 2 + 6, STOP.
static_assert(reader.clocks() == 4 + 6 + 2 + 26 + 1 && reader.bytes() == 5);
static_assert(spi_clocks(format, up_to_2_clocks, timing) == 39);
static_assert(spi_bytes(format, up_to_2_clocks, timing) == 5);

using Buffer = BitBuffer<256>;

/// `padding` zeros, then a frame of `position` as sampled, then zeros up to 256 bits.
constexpr Buffer sampled(std::uint64_t position, unsigned lead, unsigned ack,
                         unsigned padding = 0) {
  Frame frame;
  frame.channel_count = 1;
  frame.lead_clocks = static_cast<std::uint16_t>(lead);
  frame.ack_clocks = static_cast<std::uint16_t>(ack);
  frame.channel_list[0].position = position;
  const auto bits = encode_frame(frame, codec);
  Buffer buffer;
  buffer.append_run(false, padding);
  for (std::size_t i = 0; i < bits->size_bits(); ++i) buffer.append(bits->view()[i]);
  buffer.append_run(false, Buffer::capacity_bits - buffer.size_bits());
  return buffer;
}

constexpr auto good = reader.read(sampled(0x2ABCD, 3, 5).bytes(), reader.clocks());
static_assert(good.ok() && good->channel_list[0].position == 0x2ABCD && good->stop_seen);
static_assert(line_delay_clocks(*good) == 1);

FrameError cause_of(const Reader& from, const Buffer& buffer, std::size_t clocks) {
  const auto frame = from.read(buffer.bytes(), clocks);
  return frame.ok() ? static_cast<FrameError>(255) : frame.error().cause;
}

Reader reader_of(SpiTail tail, Timeout timeout) {
  SpiSetup setup = up_to_2_clocks;
  setup.tail = tail;
  DeviceTiming device = timing;
  device.timeout = timeout;
  return Reader(codec, setup, device);
}

BISS_TEST(SpiReader, EveryBitOffset_GivesTheFrame) {
  BISS_RANDOM(random, 0x5A11);
  for (unsigned padding = 0; padding < 40; ++padding) {
    SpiSetup setup = up_to_2_clocks;
    setup.first_bit = static_cast<std::uint16_t>(padding);
    const Reader padded(codec, setup, timing);
    BISS_EXPECT_EQ(padded.bytes(), (padding + 39 + 7) / 8);
    BISS_EXPECT_EQ(spi_bytes(format, setup, timing), padded.bytes());
    const std::uint64_t position = random.bits(18);
    const unsigned lead = 2 + padding % 3;
    const unsigned ack = 4 + padding % 3;
    const Buffer buffer = sampled(position, lead, ack, padding);
    const auto frame = padded.read(buffer.bytes().first(padded.bytes()), padded.clocks());
    BISS_ASSERT(frame.ok());
    BISS_EXPECT_EQ(frame->channel_list[0].position, position);
    BISS_EXPECT_EQ(frame->lead_clocks, lead);
    BISS_EXPECT_EQ(frame->ack_clocks, ack);
    BISS_EXPECT(frame->stop_seen);
    BISS_EXPECT(padded.read(buffer.bytes()).ok());
  }
}

BISS_TEST(SpiReader, SampledOnTheFallingEdge_ComesHalfAPeriodEarlier) {
  // Up to half a period both phases read the same; then the falling edge reads one more 1.
  for (const SpiPhase phase : {rising, falling}) {
    const SpiSetup setup{
        .period = period, .phase = phase, .line_delay = {nanoseconds(60), nanoseconds(90)}};
    const Reader phased(codec, setup, timing);
    const unsigned lead = phase == falling ? 3 : 2;
    BISS_EXPECT(phased.read(sampled(0x2ABCD, lead, 5).bytes()).ok());
    BISS_EXPECT_EQ(cause_of(phased, sampled(0x2ABCD, 5 - lead, 5), 250),
                   FrameError::response_range);
  }
}

BISS_TEST(SpiReader, LeadOutsideTheLineDelay_ReportsResponseRange) {
  BISS_EXPECT_EQ(cause_of(reader, sampled(1, 1, 5), 250), FrameError::response_range);
  BISS_EXPECT_EQ(cause_of(reader, sampled(1, 5, 5), 250), FrameError::response_range);
}

BISS_TEST(SpiReader, AckOutsideTheDevicesTiming_ReportsAckRange) {
  BISS_EXPECT_EQ(cause_of(reader, sampled(1, 2, 3), 250), FrameError::ack_range);
  BISS_EXPECT_EQ(cause_of(reader, sampled(1, 2, 7), 250), FrameError::ack_range);
}

BISS_TEST(SpiReader, SilentLine_IsToldFromABusyOne) {
  Buffer high;
  high.append_run(true, 256);
  BISS_EXPECT_EQ(cause_of(reader, high, 39), FrameError::no_response);
  BISS_EXPECT_EQ(cause_of(reader, Buffer{}, 39), FrameError::no_response);
  BISS_EXPECT_EQ(cause_of(reader, sampled(1, 0, 9), 250), FrameError::not_ready);
  Buffer no_start;
  no_start.append_run(true, 2);
  no_start.append_run(false, 100);
  BISS_EXPECT_EQ(cause_of(reader, no_start, 39), FrameError::no_start);
}

BISS_TEST(SpiReader, BitsBeyondTheClocksSent_AreNoSamples) {
  const Buffer buffer = sampled(0x3FFFF, 2, 5);
  const std::size_t last_crc = 2 + 5 + 2 + 26;
  for (std::size_t clocks = 0; clocks < last_crc; ++clocks) {
    const FrameError expected = clocks < 3   ? FrameError::no_response
                                : clocks < 8 ? FrameError::no_start
                                             : FrameError::truncated;
    BISS_EXPECT_EQ(cause_of(reader, buffer, clocks), expected) << " at " << clocks;
  }
  const auto without_stop = reader.read(buffer.bytes(), last_crc);
  BISS_ASSERT(without_stop.ok());
  BISS_EXPECT(!without_stop->stop_seen);
}

BISS_TEST(SpiReader, BufferShorterThanItsClocks_ReportsTruncated) {
  const Buffer buffer = sampled(0x3FFFF, 4, 6);
  const auto frame = reader.read(buffer.bytes().first(4), reader.clocks());
  BISS_ASSERT(!frame.ok());
  BISS_EXPECT_EQ(frame.error().cause, FrameError::truncated);
  const auto nothing = reader.read({}, reader.clocks());
  BISS_ASSERT(!nothing.ok());
  BISS_EXPECT_EQ(nothing.error().cause, FrameError::no_response);
}

BISS_TEST(SpiReader, OneBehindStop_ReportsStopBit) {
  const std::size_t stop = 2 + 5 + 2 + 26;
  for (std::size_t at = stop; at < 120; ++at) {
    Buffer buffer = sampled(0x12345, 2, 5);
    buffer.flip(at);
    BISS_EXPECT_EQ(cause_of(reader, buffer, 120), FrameError::stop_bit) << " at " << at;
    BISS_EXPECT_EQ(reader.read(buffer.bytes(), at).ok(), true) << " at " << at;
  }
}

BISS_TEST(SpiReader, OneBehindStopOfAWrongFrame_ReportsTheFirstCause) {
  Buffer buffer = sampled(0x12345, 2, 5);
  buffer.flip(60);
  buffer.flip(12);
  BISS_EXPECT_EQ(cause_of(reader, buffer, 120), FrameError::crc);
}

BISS_TEST(SpiReader, TailIgnored_LooksAtStopOnly) {
  const Reader lenient = reader_of(SpiTail::ignored, {});
  Buffer buffer = sampled(0x12345, 2, 5);
  buffer.flip(36);
  BISS_EXPECT(lenient.read(buffer.bytes(), 120).ok());
  buffer.flip(35);
  BISS_EXPECT_EQ(cause_of(lenient, buffer, 120), FrameError::stop_bit);
}

BISS_TEST(SpiReader, TimeoutFromTheStartOfTheRequest_EndsTheTail) {
  const Reader cycle = reader_of(SpiTail::must_stay_low, {TimeoutRule::cycle, nanoseconds(8'050)});
  Buffer before = sampled(0x12345, 2, 5);
  before.flip(79);
  BISS_EXPECT_EQ(cause_of(cycle, before, 200), FrameError::stop_bit);
  Buffer after = sampled(0x12345, 2, 5);
  for (std::size_t at = 80; at < 200; ++at) after.flip(at);
  BISS_EXPECT(cycle.read(after.bytes(), 200).ok());
  const Reader adaptive = reader_of(SpiTail::must_stay_low, {TimeoutRule::adaptive, {}});
  BISS_EXPECT_EQ(cause_of(adaptive, after, 200), FrameError::stop_bit);
}

BISS_TEST(SpiReader, ZerosBeforeTheLeadingOnes_AreReadWithAFixedCycleTimeOnly) {
  const Reader by_time = reader_of(SpiTail::must_stay_low, {TimeoutRule::cycle, microseconds(31)});
  BISS_EXPECT_EQ(by_time.bounds().late_max_clocks, 2);
  BISS_EXPECT_EQ(reader.bounds().late_max_clocks, 0);
  for (unsigned zeros = 1; zeros < 4; ++zeros) {
    Buffer buffer = sampled(0x2ABCD, 4, 5);
    for (unsigned at = 0; at < zeros; ++at) buffer.flip(at);
    const auto frame = by_time.read(buffer.bytes(), by_time.clocks());
    BISS_EXPECT_EQ(frame.ok(), zeros <= 2);
    if (frame.ok()) {
      BISS_EXPECT_EQ(frame->channel_list[0].position, 0x2ABCDU);
      BISS_EXPECT_EQ(frame->lead_clocks, 4);
      BISS_EXPECT_EQ(frame->ack_clocks, 5);
    } else {
      BISS_EXPECT_EQ(cause_of(by_time, buffer, 39), FrameError::not_ready);
    }
    BISS_EXPECT_EQ(cause_of(reader, buffer, 39), FrameError::not_ready);
    buffer.flip(30);
    BISS_EXPECT_EQ(cause_of(by_time, buffer, 39),
                   zeros <= 2 ? FrameError::crc : FrameError::not_ready);
  }
}

BISS_TEST(SpiReader, ObservedLineDelay_IsAPeriodWide) {
  Frame frame;
  for (std::uint16_t clocks = 0; clocks < 5; ++clocks) {
    frame.lead_clocks = static_cast<std::uint16_t>(2 + clocks);
    SpiSetup setup{.period = period};
    BISS_EXPECT_EQ(line_delay_clocks(frame), clocks);
    BISS_EXPECT(observed_line_delay(frame, setup) ==
                LineDelayRange{period * clocks, period * (clocks + 1)});
    setup.phase = falling;
    const Picoseconds from = clocks == 0 ? Picoseconds{} : period * clocks - period / 2;
    BISS_EXPECT(observed_line_delay(frame, setup) ==
                LineDelayRange{from, period * clocks + period / 2});
  }
}

// ---- Setups that are refused

constexpr SpiSetup with_words(bool no_error_flag, bool unchecked) {
  return {.period = period, .no_error_flag = no_error_flag, .unchecked = unchecked};
}

constexpr std::optional<SpiSetupError> check_text(const char* text, const SpiSetup& setup) {
  return check_spi(*parse_format(text), setup, timing);
}

static_assert(!check_text("pos18,nE,nW,crc6;cds0", with_words(false, false)));
static_assert(!check_text("pos18,E,W,crc6", with_words(false, false)));
static_assert(check_text("pos18,crc6", with_words(false, true)) == SpiSetupError::error_flag);
static_assert(!check_text("pos18,crc6", with_words(true, false)));
static_assert(check_text("pos18,nE,nW", with_words(true, false)) == SpiSetupError::crc);
static_assert(!check_text("pos18,nE,nW", with_words(false, true)));
static_assert(!check_text("pos18", with_words(true, true)));
// Each position needs a flag of its own; a value that is not a position needs none.
static_assert(check_text("pos18,nE,crc6+pos18,crc6", with_words(false, false)) ==
              SpiSetupError::error_flag);
static_assert(!check_text("pos18,nE,crc6+pad8,crc6", with_words(false, false)));
static_assert(check_text("pos18,nE,crc6:previous", with_words(true, true)) ==
              SpiSetupError::previous);
static_assert(!check_text("pos18,nE,crc6:reversed", with_words(false, false)));
static_assert(check_text("pos18,nE,crc6+pad8", with_words(false, false)) == SpiSetupError::crc);

struct Refused {
  SpiSetup setup;
  DeviceTiming device;
  SpiSetupError error;
};

/// Every cause, of a reader for `format`.
constexpr std::array refused_setups{
    Refused{{}, timing, SpiSetupError::period},
    Refused{{.period = -period}, timing, SpiSetupError::period},
    Refused{{.period = period, .line_delay = {period, {}}}, timing, SpiSetupError::line_delay},
    Refused{{.period = period, .line_delay = {-period, {}}}, timing, SpiSetupError::line_delay},
    Refused{{.period = nanoseconds(25)}, timing, SpiSetupError::clock},
    Refused{{.period = period - picoseconds(1)}, timing, SpiSetupError::clock},
    Refused{{.period = period}, {.clock_max = megahertz(5)}, SpiSetupError::clock}};

BISS_TEST(SpiReader, SetupThatIsRefused_HasItsCauseAndReadsNoFrame) {
  const Buffer buffer = sampled(0x2ABCD, 3, 5);
  BISS_ASSERT(reader.read(buffer.bytes()).ok());
  for (const Refused& refused : refused_setups) {
    const Reader none(codec, refused.setup, refused.device);
    BISS_ASSERT(none.error());
    BISS_EXPECT(*none.error() == refused.error);
    BISS_EXPECT_EQ(none.bytes(), 0U);
    BISS_EXPECT_EQ(none.clocks(), 0U);
    BISS_EXPECT_EQ(cause_of(none, buffer, 250), FrameError::response_range);
    for (unsigned lead = 1; lead < 80; ++lead) {
      BISS_EXPECT(!none.read(sampled(0x2ABCD, lead, 5).bytes()).ok()) << lead;
    }
  }
  const Codec bare(*parse_format("pos18,crc6"));
  BISS_EXPECT(Reader(bare, up_to_2_clocks, timing).error() == SpiSetupError::error_flag);
}

BISS_TEST(SpiReader, ClockAtTheEncodersLimit_IsAccepted) {
  for (const std::uint32_t limit : {80'000U, 250'000U, 6'666'667U, 9'999'999U, 10'000'000U}) {
    const DeviceTiming device{.clock_max = hertz(limit)};
    BISS_EXPECT(!Reader(codec, {.period = period_of(hertz(limit))}, device).error()) << limit;
    BISS_EXPECT(Reader(codec, {.period = period_of(hertz(limit + limit / 100))}, device).error() ==
                SpiSetupError::clock)
        << limit;
  }
}

BISS_TEST(SpiReader, AnyBuffer_IsReadInsideItsBytes) {
  BISS_RANDOM(random, 0xB0FF);
  std::array<std::uint8_t, 24> bytes{};
  unsigned frames = 0;
  for (std::uint64_t round = 0; round < test::rounds(20'000, 500); ++round) {
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random.next());
    const std::size_t size = random.below(25);
    const std::size_t clocks = random.below(256);
    SpiSetup setup = up_to_2_clocks;
    setup.first_bit = static_cast<std::uint16_t>(random.below(9));
    const Reader any(codec, setup, timing);
    const auto frame = any.read(std::span(bytes).first(size), clocks);
    if (frame.ok()) ++frames;
  }
  BISS_EXPECT(frames < 20);
}

}  // namespace biss::spi_test
