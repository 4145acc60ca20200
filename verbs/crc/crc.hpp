// `biss crc`: the frame for a position, or the frame in a buffer, bit by bit.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "biss/frame/codec.hpp"
#include "biss/frame/decode.hpp"
#include "verbs/common/format_option.hpp"
#include "verbs/common/word.hpp"

namespace biss::verbs {

/// A frame from START on, as on the line.
struct FrameWords {
  struct ChannelWord {
    std::uint64_t data = 0;
    std::uint16_t crc = 0;
  };
  std::optional<bool> cds = false;  // empty: neither START nor CDS was received
  std::array<ChannelWord, max_channels> channels{};
  std::optional<bool> stop = false;  // empty: not received
};

FrameWords frame_words(const FrameFormat& format, const Frame& frame, const PlainCodec& codec);
/// \pre the bits reach to the last one of the CRC
FrameWords frame_words(const FrameFormat& format, const BitView& bits, const FrameStart& start);

/// The frame found in a buffer.
struct Received {
  std::optional<FrameStart> start;
  std::optional<FrameWords> line;  // empty if the bits end before the last bit of the CRC
  std::optional<FrameFault> fault;
};

/// The frame bit by bit.
bool write_table(const FrameFormat& format, const FrameWords& line, const PlainCodec& codec,
                 report::TextSink& sink, const report::TableOptions& table_options);
/// The frame as JSON; without a line its values are null. `received` adds keys.
bool write_object(const FrameFormat& format, const std::optional<FrameWords>& line,
                  const PlainCodec& codec, const Received* received, report::TextSink& sink);

/// ` of channel 2`; empty if the format has one channel.
std::string channel_word(const FrameFormat& format, std::size_t k);

// ---- --read

struct BufferOptions {
  std::string text;
  WordReading reading;
  std::optional<Hertz> clock;
  report::Format to = report::Format::table;
  std::string output;
};

/// Prints the frame, or why there is none and which options read it.
ExitStatus show_buffer(const BufferOptions& options, const Device& device, Host& host);

}  // namespace biss::verbs
