// Short notations for formats, lines and frames, for the tests of the frame codec.
#pragma once

#include <cstdint>
#include <string_view>

#include "biss/base/bit_buffer.hpp"
#include "biss/base/bits.hpp"
#include "biss/frame/format_text.hpp"
#include "biss/frame/frame.hpp"

namespace biss::test {

/// \pre the text is a format
constexpr FrameFormat format_of(std::string_view text) { return *parse_format(text); }

using LineBits = BitBuffer<512>;

/// Levels written as 1 and 0; spaces are for the reader.
constexpr LineBits line_of(std::string_view levels) {
  LineBits line;
  for (const char c : levels) {
    if (c != ' ') line.append(c == '1');
  }
  return line;
}

/// One channel after 2 leading ones and 3 clocks of ACK.
constexpr Frame frame_of(std::uint64_t position, bool nE = true, bool nW = true) {
  Frame frame;
  frame.channel_count = 1;
  frame.channel_list[0] = {position, 0, nE, nW};
  frame.lead_clocks = 2;
  frame.ack_clocks = 3;
  return frame;
}

}  // namespace biss::test
