// Frames, SPI buffers and checksums through the C interface.
#include "capi/biss_c_frame.h"

#include <gtest/gtest.h>

#include <array>
#include <climits>
#include <cstring>
#include <memory>
#include <string>
#include <tuple>
#include <vector>

#include "capi/test_handles.hpp"

namespace biss::capi {
namespace frame_test {

using CodecHandle = Handle<biss_codec>;

CodecHandle open_codec(const char* text) { return opened(biss_codec_init, *named(text)); }

using Bytes = std::vector<std::uint8_t>;

struct Encoded {
  Bytes bytes;
  std::size_t bits = 0;

  void set(std::size_t bit, bool level) {
    const auto mask = static_cast<std::uint8_t>(0x80U >> (bit % 8));
    bytes[bit / 8] =
        static_cast<std::uint8_t>(level ? bytes[bit / 8] | mask : bytes[bit / 8] & ~unsigned{mask});
  }
  void flip(std::size_t bit) { bytes[bit / 8] ^= static_cast<std::uint8_t>(0x80U >> (bit % 8)); }
};

Encoded encode(const biss_codec* codec, const biss_frame& frame) {
  Encoded encoded{Bytes(BISS_FRAME_BYTES_MAX)};
  EXPECT_EQ(
      biss_frame_encode(codec, &frame, encoded.bytes.data(), encoded.bytes.size(), &encoded.bits),
      BISS_OK);
  return encoded;
}

biss_frame decode(const biss_codec* codec, const Encoded& from,
                  const biss_bounds* bounds = nullptr) {
  biss_frame frame;
  EXPECT_EQ(
      biss_frame_decode(codec, from.bytes.data(), from.bytes.size(), 0, from.bits, bounds, &frame),
      BISS_OK);
  return frame;
}

biss_frame frame_of(const biss_codec* codec) {
  biss_frame frame;
  EXPECT_EQ(biss_frame_defaults(codec, &frame), BISS_OK);
  return frame;
}

TEST(CFormat, NamesAndTexts_GiveTheirFields) {
  const biss_format& format = *named("mt12,st20,nE,W,lc6,crc16+pos30,crc6:0x43:0x15;cds0");
  EXPECT_EQ(format.channel_count, 2U);
  EXPECT_TRUE(format.cds0);
  const biss_channel_format& first = format.channels[0];
  EXPECT_EQ(first.data_bits, 40U);
  EXPECT_EQ(first.position.bits, 0U);
  EXPECT_EQ(first.multiturn.bits, 12U);
  EXPECT_EQ(first.multiturn.shift, 28U);
  EXPECT_EQ(first.singleturn.bits, 20U);
  EXPECT_EQ(first.life_counter.bits, 6U);
  EXPECT_TRUE(first.error.present && !first.error.active_high);
  EXPECT_TRUE(first.warning.present && first.warning.active_high);
  EXPECT_EQ(first.crc.polynomial, 0x190D9U);
  const biss_channel_format& second = format.channels[1];
  EXPECT_EQ(second.position.bits, 30U);
  EXPECT_EQ(second.crc.start, 0x15U);
  EXPECT_FALSE(second.error.present || second.warning.present);
}

TEST(CFormat, TextOfAFormat_IsItsText) {
  EXPECT_EQ(text_of(*named("resolute-26")), "pos26,nE,nW,crc6;cds0");
  for (const char* text :
       {"pad3,pos26:gray,E,W,lc6,crc6", "mt12:lsb,pad1,st20:gray,nE,pad2,crc16:0x190D9:0x1234",
        "pos64", "lc6,nE,pos12,crc5:raw,crc6"}) {
    const std::string whole = text_of(*named(text));
    EXPECT_EQ(text_of(*named(whole)), whole) << text;
  }
  for (std::size_t i = 0; i < biss_encoder_count(); ++i) {
    const std::string whole = text_of(*named(biss_encoder_name(i)));
    EXPECT_EQ(text_of(*named(whole)), whole);
  }
  std::array<char, BISS_FORMAT_TEXT_MAX> text{};
  std::size_t length = 0;
  const biss_format* format = named("resolute-26");
  ASSERT_EQ(biss_format_text(format, text.data(), text.size(), &length), BISS_OK);
  EXPECT_EQ(length, std::strlen(text.data()));
  text.fill('x');
  EXPECT_EQ(biss_format_text(format, text.data(), length, &length), BISS_NO_ROOM);
  EXPECT_EQ(text[0], 'x');
  EXPECT_EQ(biss_format_text(format, text.data(), length + 1, nullptr), BISS_OK);
  EXPECT_EQ(biss_format_text(format, nullptr, 0, nullptr), BISS_NULL_ARGUMENT);
  EXPECT_EQ(biss_format_text(nullptr, text.data(), text.size(), nullptr), BISS_NULL_ARGUMENT);
}

// What a program without texts writes.
TEST(CFormat, PlainData_AreTheFormatOfTheText) {
  biss_format format = biss_format_defaults();
  format.channel_count = 1;
  format.cds0 = true;
  format.channels[0].data_bits = 28;
  format.channels[0].position = {2, 26};
  format.channels[0].error = {1, true, false};
  format.channels[0].warning = {0, true, false};
  format.channels[0].crc = biss_crc_defaults(6);
  EXPECT_EQ(text_of(format), "pos26,nE,nW,crc6;cds0");
  EXPECT_EQ(format.timing.timeout.time_ps, named("pos8,crc5")->timing.timeout.time_ps);
}

TEST(CFormat, DataThatAreNoFormat_AreRefused) {
  using F = biss_format;
  using C = biss_channel_format;
  const std::vector<void (*)(F&, C&)> spoilers{
      [](F& f, C&) { f.channel_count = 0; },
      [](F& f, C&) { f.channel_count = 9; },
      [](F& f, C&) { f.channel_count = 2; },  // the second one is empty
      [](F&, C& c) { c.data_bits = 0; },
      [](F&, C& c) { c.data_bits = 65; },
      [](F&, C& c) {
        c.position = {0, 65};
      },
      [](F&, C& c) {
        c.position = {64, 1};
      },
      [](F&, C& c) {
        c.position = {17, 26};
      },
      [](F&, C& c) { c.multiturn.bits = 1; },
      [](F&, C& c) { c.singleturn.bits = 1; },
      [](F&, C& c) {
        c.position = {}, c.life_counter = {0, 33};
      },
      [](F&, C& c) {
        c.error = {16, true, false};
      },
      [](F&, C& c) {
        c.warning = {60, true, false};
      },
      [](F&, C& c) { c.crc.width_bits = 17; },
      [](F&, C& c) { c.crc.start = 64; }};
  const auto codec = std::make_unique<biss_codec>();
  const F good = *named("pos26,pad16,crc6");
  ASSERT_EQ(biss_codec_init(codec.get(), &good), BISS_OK);
  for (std::size_t i = 0; i < spoilers.size(); ++i) {
    F format = good;
    spoilers[i](format, format.channels[0]);
    EXPECT_EQ(biss_codec_init(codec.get(), &format), BISS_BAD_FORMAT) << i;
  }
  F format = good;
  format.timing.ack_clocks = 401;
  EXPECT_EQ(biss_codec_init(codec.get(), &format), BISS_BAD_TIMING);
  EXPECT_EQ(biss_format_parse("pos26,crc", &format), BISS_BAD_FORMAT);
}

TEST(CFrame, EncodedFrame_DecodesToItself) {
  const CodecHandle codec = open_codec("mt4,st20,nE,nW,lc6,crc16+pos64,crc5");
  biss_frame frame = frame_of(codec.get());
  frame.channels[0] = {0xABCDEF, 63, true, false};
  frame.channels[1] = {0xFEDC'BA98'7654'3210, 0, true, true};
  frame.cds = true;
  frame.lead_clocks = 3;
  frame.ack_clocks = 17;
  const biss_frame read = decode(codec.get(), encode(codec.get(), frame));
  EXPECT_EQ(read.cause, BISS_CAUSE_OK);
  EXPECT_EQ(read.channel_count, 2U);
  EXPECT_EQ(read.channels[0].position, 0xABCDEFU);
  EXPECT_EQ(read.channels[0].life_counter, 63U);
  EXPECT_FALSE(read.channels[0].nW);
  EXPECT_EQ(read.channels[1].position, 0xFEDC'BA98'7654'3210U);
  EXPECT_TRUE(read.cds && read.stop_seen);
  EXPECT_EQ(read.lead_clocks, 3U);
  EXPECT_EQ(read.ack_clocks, 17U);
  // The second channel has no nE. Without this word, both are trusted.
  EXPECT_TRUE(read.no_error_flag);
  EXPECT_FALSE(biss_frame_trusted(&read));
  biss_frame with_word = read;
  with_word.no_error_flag = false;
  EXPECT_TRUE(biss_frame_trusted(&with_word));
}

// Each way in which the bits can be no frame.
TEST(CFrame, DamagedBits_HaveEachCause) {
  const CodecHandle codec = open_codec("pos12,nE,nW,crc6+pos8,crc5;cds0");
  biss_frame frame = frame_of(codec.get());
  frame.lead_clocks = 2;
  frame.ack_clocks = 4;  // START is bit 6, CDS bit 7
  frame.channels[0].position = 0x5A5;
  const Encoded good = encode(codec.get(), frame);
  ASSERT_EQ(good.bits, 8U + 20 + 13 + 1);
  ASSERT_EQ(decode(codec.get(), good).cause, BISS_CAUSE_OK);
  const biss_bounds narrow{2, 3, 4, 6, 0};
  struct Case {
    biss_cause cause;
    std::uint32_t channel;
    Encoded bits;
    biss_bounds bounds;
  };
  std::vector<Case> cases;
  const auto add = [&](biss_cause cause, std::uint32_t channel) -> Encoded& {
    cases.push_back({cause, channel, good, narrow});
    return cases.back().bits;
  };
  for (std::uint8_t& byte : add(BISS_CAUSE_NO_RESPONSE, 0).bytes) byte = 0xFF;
  add(BISS_CAUSE_NOT_READY, 0).set(0, false);
  add(BISS_CAUSE_RESPONSE_RANGE, 0).set(1, false);
  for (std::uint8_t& byte : add(BISS_CAUSE_NO_START, 0).bytes)
    byte = &byte == &cases.back().bits.bytes[0] ? 0xC0 : 0;
  add(BISS_CAUSE_ACK_RANGE, 0).set(4, true);
  add(BISS_CAUSE_TRUNCATED, 0).bits = 8 + 20 + 12;
  add(BISS_CAUSE_CDS, 0).set(7, true);
  add(BISS_CAUSE_CRC, 0).flip(10);
  add(BISS_CAUSE_CRC, 1).flip(30);
  add(BISS_CAUSE_STOP_BIT, 0).set(41, true);
  for (const Case& each : cases) {
    const biss_frame read = decode(codec.get(), each.bits, &each.bounds);
    EXPECT_STREQ(biss_cause_name(read.cause), biss_cause_name(each.cause));
    EXPECT_EQ(read.cause_channel, each.channel);
    EXPECT_EQ(read.channel_count, 0U);
    EXPECT_EQ(read.channels[0].position, 0U);
    EXPECT_FALSE(biss_frame_trusted(&read));
  }
}

TEST(CFrame, FrameWithAnError_IsNotTrusted) {
  const CodecHandle codec = open_codec("pos8,nE,crc5+pos8,nE,crc5");
  biss_frame frame = frame_of(codec.get());
  frame.channels[1].nE = false;
  const biss_frame read = decode(codec.get(), encode(codec.get(), frame));
  EXPECT_EQ(read.cause, BISS_CAUSE_OK);
  EXPECT_FALSE(biss_frame_trusted(&read));
  EXPECT_FALSE(biss_frame_trusted(nullptr));
}

TEST(CFrame, ValuesThatDoNotFit_AreRefusedByTheirCause) {
  const CodecHandle codec = open_codec("pos12,nE,nW,lc6,crc6");
  Bytes bytes(BISS_FRAME_BYTES_MAX, 0xAA);
  const auto status = [&](auto change, std::size_t room = BISS_FRAME_BYTES_MAX) {
    biss_frame frame = frame_of(codec.get());
    change(frame);
    std::size_t bits = 0;
    const biss_status result = biss_frame_encode(codec.get(), &frame, bytes.data(), room, &bits);
    if (result == BISS_NO_ROOM) {
      EXPECT_EQ(bits, 2U + 2 + 20 + 6 + 1);
    }
    return result;
  };
  EXPECT_EQ(status([](biss_frame& f) { f.channel_count = 2; }), BISS_CHANNEL_COUNT);
  EXPECT_EQ(status([](biss_frame& f) { f.channel_count = 257; }), BISS_CHANNEL_COUNT);
  EXPECT_EQ(status([](biss_frame& f) { f.channels[0].position = 4096; }), BISS_VALUE_RANGE);
  EXPECT_EQ(status([](biss_frame& f) { f.channels[0].life_counter = 64; }), BISS_VALUE_RANGE);
  EXPECT_EQ(status([](biss_frame& f) { f.ack_clocks = 0; }), BISS_CLOCK_RANGE);
  EXPECT_EQ(status([](biss_frame& f) { f.ack_clocks = 401; }), BISS_CLOCK_RANGE);
  EXPECT_EQ(status([](biss_frame& f) { f.ack_clocks = 65'537; }), BISS_CLOCK_RANGE);
  EXPECT_EQ(status([](biss_frame& f) { f.lead_clocks = 403; }), BISS_CLOCK_RANGE);
  EXPECT_EQ(status([](biss_frame& f) { f.lead_clocks = 65'537; }), BISS_CLOCK_RANGE);
  EXPECT_EQ(status([](biss_frame&) {}, 3), BISS_NO_ROOM);
  EXPECT_EQ(bytes, Bytes(BISS_FRAME_BYTES_MAX, 0xAA));
  EXPECT_EQ(status([](biss_frame&) {}, 4), BISS_OK);
}

TEST(CFrame, BoundsOutOfRange_AreRefused) {
  const CodecHandle codec = open_codec("pos12,crc6");
  biss_frame frame;
  for (const biss_bounds& bounds :
       {biss_bounds{0, 2, 1, 2, 0}, biss_bounds{1, 403, 1, 2, 0}, biss_bounds{3, 2, 1, 2, 0},
        biss_bounds{1, 2, 0, 2, 0}, biss_bounds{1, 2, 1, 401, 0}, biss_bounds{1, 2, 3, 2, 0},
        biss_bounds{1, 2, 1, 2, 403}}) {
    EXPECT_EQ(biss_frame_decode(codec.get(), nullptr, 0, 0, 0, &bounds, &frame), BISS_BAD_SETUP);
  }
  const biss_bounds widest = biss_bounds_defaults();
  EXPECT_EQ(biss_frame_decode(codec.get(), nullptr, 0, SIZE_MAX, SIZE_MAX, &widest, &frame),
            BISS_OK);
  EXPECT_EQ(frame.cause, BISS_CAUSE_NO_RESPONSE);
}

// ---- SPI

using SpiHandle = Handle<biss_spi>;

SpiHandle open_spi(const biss_spi_setup& setup) { return opened(biss_spi_init, setup); }

// The example of docs/spi.md.
constexpr std::array<std::uint8_t, 9> buffer{0xF0, 0x00, 0x00, 0x00, 0x01, 0x24, 0x68, 0xB9, 0xA0};

biss_spi_setup example_setup() {
  biss_spi_setup setup = biss_spi_defaults(named("resolute-18"), 100'000);
  setup.line_delay_max_ps = 242'500;
  return setup;
}

TEST(CSpi, ExampleOfTheDocument_IsRead) {
  const SpiHandle spi = open_spi(example_setup());
  biss_spi_size size;
  ASSERT_EQ(biss_spi_size_of(spi.get(), &size), BISS_OK);
  EXPECT_EQ(size.clocks, 193U);
  EXPECT_EQ(size.bytes, 25U);
  EXPECT_EQ(size.bounds.lead_min_clocks, 2U);
  EXPECT_EQ(size.bounds.lead_max_clocks, 4U);
  biss_frame frame;
  ASSERT_EQ(biss_spi_read(spi.get(), buffer.data(), buffer.size(), SIZE_MAX, &frame), BISS_OK);
  EXPECT_EQ(frame.cause, BISS_CAUSE_OK);
  EXPECT_EQ(frame.channels[0].position, 0x12345U);
  EXPECT_EQ(frame.lead_clocks, 4U);
  EXPECT_EQ(frame.ack_clocks, 35U);
  std::int64_t least = 0;
  std::int64_t most = 0;
  ASSERT_EQ(biss_spi_line_delay(spi.get(), &frame, &least, &most), BISS_OK);
  EXPECT_EQ(least, 200'000);
  EXPECT_EQ(most, 300'000);
}

TEST(CSpi, ReaderLives_WhenItsFormatIsGone) {
  biss_format format = *named("resolute-18");
  biss_spi_setup setup = example_setup();
  setup.format = &format;
  const SpiHandle spi = open_spi(setup);
  format = {};
  biss_frame frame;
  ASSERT_EQ(biss_spi_read(spi.get(), buffer.data(), buffer.size(), SIZE_MAX, &frame), BISS_OK);
  EXPECT_EQ(frame.channels[0].position, 0x12345U);
}

TEST(CSpi, ClocksTailAndPadding_AreRespected) {
  biss_spi_setup setup = example_setup();
  const auto cause = [&](Bytes bytes, std::size_t clocks) {
    biss_frame frame;
    const SpiHandle spi = open_spi(setup);
    EXPECT_EQ(biss_spi_read(spi.get(), bytes.data(), bytes.size(), clocks, &frame), BISS_OK);
    return frame.cause;
  };
  const Bytes good(buffer.begin(), buffer.end());
  EXPECT_EQ(cause(good, 66), BISS_CAUSE_TRUNCATED);
  EXPECT_EQ(cause({}, SIZE_MAX), BISS_CAUSE_NO_RESPONSE);
  Bytes tail = good;
  tail.back() |= 1U;
  EXPECT_EQ(cause(tail, SIZE_MAX), BISS_CAUSE_STOP_BIT);
  EXPECT_EQ(cause(tail, 71), BISS_CAUSE_OK);
  setup.ignore_tail = true;
  EXPECT_EQ(cause(tail, SIZE_MAX), BISS_CAUSE_OK);
  setup.first_bit = 8;
  Bytes padded{0x00};
  padded.insert(padded.end(), good.begin(), good.end());
  EXPECT_EQ(cause(padded, SIZE_MAX), BISS_CAUSE_OK);
  setup.line_delay_max_ps = 99'000;
  EXPECT_EQ(cause(padded, SIZE_MAX), BISS_CAUSE_RESPONSE_RANGE);
}

TEST(CSpi, Setup_RefusedByItsCause) {
  const auto status = [&](auto change) {
    biss_spi_setup setup = example_setup();
    change(setup);
    const auto spi = std::make_unique<biss_spi>();
    biss_spi_size size;
    const biss_status result = biss_spi_init(spi.get(), &setup);
    EXPECT_EQ(biss_spi_size_of(spi.get(), &size) == BISS_BAD_HANDLE, result != BISS_OK);
    return result;
  };
  biss_format format = *named("resolute-18");
  EXPECT_EQ(status([&](biss_spi_setup& s) { s.format = &format; }), BISS_OK);
  format.timing.timeout.rule = 9;
  EXPECT_EQ(status([&](biss_spi_setup& s) { s.format = &format; }), BISS_BAD_TIMING);
  EXPECT_EQ(status([](biss_spi_setup& s) { s.format = named("what"); }), BISS_BAD_FORMAT);
  EXPECT_EQ(status([](biss_spi_setup& s) { s.format = named("pos8,nE,crc5:previous"); }),
            BISS_BAD_FORMAT);
  EXPECT_EQ(status([](biss_spi_setup& s) { s.format = nullptr; }), BISS_NULL_ARGUMENT);
  EXPECT_EQ(status([](biss_spi_setup& s) { s.period_ps = 31; }), BISS_BAD_SETUP);
  EXPECT_EQ(status([](biss_spi_setup& s) { s.period_ps = INT64_MAX; }), BISS_BAD_SETUP);
  EXPECT_EQ(status([](biss_spi_setup& s) { s.line_delay_min_ps = -1; }), BISS_BAD_SETUP);
  EXPECT_EQ(status([](biss_spi_setup& s) { s.line_delay_min_ps = s.line_delay_max_ps + 1; }),
            BISS_BAD_SETUP);
  EXPECT_EQ(status([](biss_spi_setup& s) { s.first_bit = 65'536; }), BISS_BAD_SETUP);
  EXPECT_EQ(status([](biss_spi_setup& s) { s.period_ps = 25'000; }), BISS_CLOCK_MAX);
  format = *named("resolute-18");
  format.timing.clock_max_hz = 5'000'000;
  EXPECT_EQ(status([&](biss_spi_setup& s) { s.format = &format; }), BISS_CLOCK_MAX);
}

TEST(CSpi, FormatWithoutErrorFlagOrChecksum_NeedsTheWord) {
  const auto status = [](const char* text, bool no_error_flag, bool unchecked) {
    biss_spi_setup setup = biss_spi_defaults(named(text), 100'000);
    setup.no_error_flag = no_error_flag;
    setup.unchecked = unchecked;
    return biss_spi_init(std::make_unique<biss_spi>().get(), &setup);
  };
  EXPECT_EQ(status("pos24,crc6", false, true), BISS_NO_ERROR_FLAG);
  EXPECT_EQ(status("pos24,crc6", true, false), BISS_OK);
  EXPECT_EQ(status("pos24,nE,nW", true, false), BISS_NO_CRC);
  EXPECT_EQ(status("pos24,nE,nW", false, true), BISS_OK);
  EXPECT_EQ(status("pos24", true, true), BISS_OK);
}

// What no one has accepted is in the frame, and it is not trusted.
TEST(CFrame, FormatWithoutErrorFlagOrChecksum_IsDecodedAndNotTrusted) {
  const auto decoded = [](const char* text) {
    const CodecHandle codec = open_codec(text);
    biss_frame frame{};
    EXPECT_EQ(biss_frame_defaults(codec.get(), &frame), BISS_OK);
    frame.channels[0].position = 1234;
    std::array<std::uint8_t, BISS_FRAME_BYTES_MAX> bytes{};
    std::size_t bits = 0;
    EXPECT_EQ(biss_frame_encode(codec.get(), &frame, bytes.data(), bytes.size(), &bits), BISS_OK);
    EXPECT_EQ(biss_frame_decode(codec.get(), bytes.data(), bytes.size(), 0, bits, nullptr, &frame),
              BISS_OK);
    EXPECT_EQ(frame.cause, BISS_CAUSE_OK);
    EXPECT_EQ(frame.channels[0].position, 1234U);
    return frame;
  };
  const auto reports = [&](const char* text, bool no_error_flag, bool unchecked) {
    const biss_frame frame = decoded(text);
    EXPECT_EQ(frame.no_error_flag, no_error_flag) << text;
    EXPECT_EQ(frame.unchecked, unchecked) << text;
    EXPECT_EQ(biss_frame_trusted(&frame), !no_error_flag && !unchecked) << text;
  };
  reports("pos24,nE,nW,crc6", false, false);
  reports("pos24,crc6", true, false);
  reports("pos24,nE,nW", false, true);
  reports("pos24", true, true);
  reports("pos24,nE,crc6+pos24,crc6", true, false);
  reports("pos24,nE,crc6+pad8", false, true);
}

// The setup has accepted it.
TEST(CSpi, FrameOfAReaderWithTheWords_IsTrusted) {
  const CodecHandle codec = open_codec("pos24");
  biss_frame frame{};
  ASSERT_EQ(biss_frame_defaults(codec.get(), &frame), BISS_OK);
  frame.lead_clocks = 2;
  std::array<std::uint8_t, BISS_FRAME_BYTES_MAX> bytes{};
  std::size_t bits = 0;
  ASSERT_EQ(biss_frame_encode(codec.get(), &frame, bytes.data(), bytes.size(), &bits), BISS_OK);
  biss_spi_setup setup = biss_spi_defaults(named("pos24"), 100'000);
  setup.no_error_flag = setup.unchecked = true;
  const SpiHandle spi = open_spi(setup);
  ASSERT_EQ(biss_spi_read(spi.get(), bytes.data(), bytes.size(), bits, &frame), BISS_OK);
  EXPECT_TRUE(biss_frame_trusted(&frame));
}

TEST(CSpi, LineDelayOfAForeignFrame_IsRefused) {
  const SpiHandle spi = open_spi(example_setup());
  biss_frame frame{};
  std::int64_t delay = 0;
  frame.cause = BISS_CAUSE_CRC;
  EXPECT_EQ(biss_spi_line_delay(spi.get(), &frame, &delay, &delay), BISS_NO_READING);
  frame.cause = BISS_CAUSE_OK;
  for (const std::uint32_t lead : {0U, 1U, 5U, 65'538U}) {
    frame.lead_clocks = lead;
    EXPECT_EQ(biss_spi_line_delay(spi.get(), &frame, &delay, &delay), BISS_CLOCK_RANGE) << lead;
  }
}

// ---- Checksums

// Of Renishaw's data sheets: an error and a warning at position 0.
TEST(CCrc, KnownChecksums_AreComputed) {
  const biss_crc crc6 = biss_crc_defaults(6);
  EXPECT_EQ(crc6.polynomial, 0x43U);
  EXPECT_TRUE(crc6.inverted);
  std::uint32_t value = 0;
  // The frame of docs/spi.md: 18 bits of position, nE, nW.
  ASSERT_EQ(biss_crc_of(&crc6, std::uint64_t{0x12345} << 2U | 3U, 20, &value), BISS_OK);
  EXPECT_EQ(value, (0xB9A0U >> 5U) & 0x3FU);
  ASSERT_EQ(biss_crc_of(&crc6, 0, 64, &value), BISS_OK);
  EXPECT_EQ(value, 0x3FU);
  EXPECT_EQ(biss_crc_defaults(16).polynomial, 0x190D9U);
  EXPECT_EQ(biss_crc_defaults(9).polynomial, 0U);
  EXPECT_EQ(biss_crc_defaults(UINT_MAX).polynomial, 0U);
}

TEST(CCrc, WhatIsNoChecksum_IsRefused) {
  std::uint32_t value = 0;
  const auto refused = [&value](const auto& change) {
    biss_crc crc = biss_crc_defaults(6);
    change(crc);
    EXPECT_EQ(biss_crc_of(&crc, 0, 8, &value), BISS_BAD_CRC);
  };
  struct Wrong {
    std::uint32_t polynomial;
    std::uint16_t start;
    std::uint8_t width;
  };
  for (const Wrong& each : {Wrong{0x43, 0, 5}, Wrong{0x42, 0, 6}, Wrong{0, 0, 6}, Wrong{7, 0, 2},
                            Wrong{0x20001, 0, 17}, Wrong{0x43, 0x40, 6}, Wrong{0x43, 0, 255}}) {
    refused([&each](biss_crc& crc) {
      crc.polynomial = each.polynomial;
      crc.start = each.start;
      crc.width_bits = each.width;
    });
  }
  refused([](biss_crc& crc) { crc = biss_crc_defaults(9); });
  refused([](biss_crc& crc) { crc.reversed = true; });
  refused([](biss_crc& crc) { crc.without_flags = true; });
  refused([](biss_crc& crc) { crc.with_cds = true; });
  refused([](biss_crc& crc) { crc.of_previous = true; });
  const biss_crc crc = biss_crc_defaults(6);
  EXPECT_EQ(biss_crc_of(&crc, 0, 0, &value), BISS_BIT_COUNT);
  EXPECT_EQ(biss_crc_of(&crc, 0, 65, &value), BISS_BIT_COUNT);
  EXPECT_EQ(biss_crc_of(&crc, 256, 8, &value), BISS_VALUE_RANGE);
}

// ---- Turns

TEST(CTurns, Steps_AreCountedAcrossZeroAndUntilTheyAreAmbiguous) {
  biss_turns turns;
  biss_turns_value value;
  ASSERT_EQ(biss_turns_init(&turns, 8, 0), BISS_OK);
  const auto now = [&value] { return std::tuple(value.state, value.turns, value.position); };
  ASSERT_EQ(biss_turns_position(&turns, &value), BISS_OK);
  EXPECT_EQ(now(), std::tuple(BISS_TURNS_EMPTY, 0, 0));
  EXPECT_FALSE(value.has_position);
  EXPECT_EQ(biss_turns_update(&turns, 10, 0, &value), BISS_OK);
  EXPECT_EQ(now(), std::tuple(BISS_TURNS_FIRST, 0, 10));
  EXPECT_EQ(biss_turns_update(&turns, 250, 0, &value), BISS_OK);
  EXPECT_EQ(now(), std::tuple(BISS_TURNS_TRACKED, -1, -6));
  EXPECT_TRUE(value.has_position);
  EXPECT_EQ(biss_turns_update(&turns, 256 + 5, 0, &value), BISS_OK);
  EXPECT_EQ(now(), std::tuple(BISS_TURNS_TRACKED, 0, 5));
  EXPECT_EQ(biss_turns_update(&turns, 5, 1, &value), BISS_OK);
  EXPECT_EQ(value.state, BISS_TURNS_AMBIGUOUS);
  EXPECT_EQ(biss_turns_resynchronise(&turns, 7, &value), BISS_OK);
  EXPECT_EQ(now(), std::tuple(BISS_TURNS_TRACKED, 7, 7 * 256 + 5));
  ASSERT_EQ(biss_turns_init(&turns, 8, 10), BISS_OK);
  biss_turns_update(&turns, 0, 0, &value);
  biss_turns_update(&turns, 11, 0, &value);
  EXPECT_EQ(value.state, BISS_TURNS_AMBIGUOUS);
  EXPECT_EQ(biss_turns_resynchronise(&turns, INT64_MAX, &value), BISS_OK);
  EXPECT_FALSE(value.has_position);
  EXPECT_EQ(value.position, 0);
}

TEST(CTurns, WrongCalls_AreRefusedByTheirCause) {
  biss_turns turns;
  biss_turns_value value;
  EXPECT_EQ(biss_turns_init(nullptr, 8, 0), BISS_NULL_ARGUMENT);
  EXPECT_EQ(biss_turns_init(&turns, 0, 0), BISS_BIT_COUNT);
  EXPECT_EQ(biss_turns_init(&turns, 65, 0), BISS_BIT_COUNT);
  EXPECT_EQ(biss_turns_init(&turns, 64, 0), BISS_OK);
  EXPECT_EQ(biss_turns_update(&turns, 0, 0, nullptr), BISS_NULL_ARGUMENT);
  expect_refusals(&turns, [&value](biss_turns* each) {
    return std::vector{biss_turns_update(each, 0, 0, &value),
                       biss_turns_resynchronise(each, 0, &value),
                       biss_turns_position(each, &value)};
  });
}

TEST(CFrame, NullPointersAndMemoryThatIsNoObject_AreNamedEverywhere) {
  const CodecHandle codec = open_codec("pos12,crc6");
  biss_spi_setup setup = biss_spi_defaults(named("pos12,crc6"), 100'000);
  setup.no_error_flag = true;
  const SpiHandle spi = open_spi(setup);
  biss_frame frame{};
  biss_spi_size spi_size;
  std::uint8_t byte = 0;
  std::size_t bits = 0;
  std::int64_t delay = 0;
  const biss_codec* c = codec.get();
  EXPECT_EQ(biss_frame_decode(c, nullptr, 1, 0, 8, nullptr, &frame), BISS_NULL_ARGUMENT);
  EXPECT_EQ(biss_frame_decode(c, &byte, 1, 0, 8, nullptr, nullptr), BISS_NULL_ARGUMENT);
  EXPECT_EQ(biss_frame_encode(c, nullptr, &byte, 1, &bits), BISS_NULL_ARGUMENT);
  EXPECT_EQ(biss_frame_encode(c, &frame, nullptr, 1, &bits), BISS_NULL_ARGUMENT);
  EXPECT_EQ(biss_frame_encode(c, &frame, &byte, 1, nullptr), BISS_NULL_ARGUMENT);
  EXPECT_EQ(biss_spi_read(spi.get(), nullptr, 1, 8, &frame), BISS_NULL_ARGUMENT);
  EXPECT_EQ(biss_spi_init(nullptr, &setup), BISS_NULL_ARGUMENT);
  EXPECT_EQ(biss_codec_init(nullptr, named("pos8")), BISS_NULL_ARGUMENT);
  EXPECT_EQ(biss_crc_of(nullptr, 0, 8, nullptr), BISS_NULL_ARGUMENT);
  expect_refusals(codec.get(), [&](const biss_codec* each) {
    return std::vector{biss_frame_decode(each, &byte, 1, 0, 8, nullptr, &frame),
                       biss_frame_defaults(each, &frame),
                       biss_frame_encode(each, &frame, &byte, 1, &bits)};
  });
  expect_refusals(spi.get(), [&](const biss_spi* each) {
    return std::vector{biss_spi_size_of(each, &spi_size), biss_spi_read(each, &byte, 1, 8, &frame),
                       biss_spi_line_delay(each, &frame, &delay, &delay)};
  });
  EXPECT_EQ(biss_codec_init(codec.get(), nullptr), BISS_NULL_ARGUMENT);
}

}  // namespace frame_test
}  // namespace biss::capi
