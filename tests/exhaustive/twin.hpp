// One format in the core and in the oracle, and the comparisons of both.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "biss/base/bit_buffer.hpp"
#include "biss/base/bits.hpp"
#include "biss/frame/codec.hpp"
#include "biss/frame/decode.hpp"
#include "biss/frame/encode.hpp"
#include "biss/frame/format.hpp"
#include "biss/frame/frame.hpp"
#include "tests/core/random.hpp"
#include "tests/oracle/oracle.hpp"

namespace exhaustive {

struct Twin {
  oracle::Description description;
  std::string text;
  biss::FrameFormat format;
};

/// The core's format is made from the text, so its parser is tested too. Throws if the core does
/// not accept the text, or does not parse its canonical text back.
Twin twin_of(const oracle::Description& description);

/// A polynomial for every width from 3 to 16, in the oracle's form.
oracle::Checksum checksum_of(unsigned width, bool inverted, std::uint64_t start);

/// The content of a frame, without its format.
struct Sent {
  std::vector<oracle::Values> values;
  std::size_t lead = 1;
  std::size_t ack = 1;
  bool cds = false;
};

/// Random values within the ranges, sometimes all ones or all zeros.
Sent random_sent(const oracle::Description& description, biss::test::Random& random);

biss::Frame frame_of(const Sent& sent);
oracle::Bits bits_of(const biss::BitView& view);
/// A line of the oracle in the core's type.
using Line = biss::BitBuffer<2048>;
Line line_of(const oracle::Bits& bits);

oracle::Limits limits_of(const biss::FrameBounds& bounds);
/// The difference between the two results; empty if they are equal.
std::string difference(const biss::Result<biss::Frame, biss::FrameFault>& core,
                       const oracle::Reading& judge);
/// The same for a codec with room for fewer channels.
template <std::size_t Channels>
std::string difference(const biss::Result<biss::BasicFrame<Channels>, biss::FrameFault>& core,
                       const oracle::Reading& judge) {
  if (!core.ok()) {
    return difference(biss::Result<biss::Frame, biss::FrameFault>(biss::failure(core.error())),
                      judge);
  }
  biss::Frame wide{.channel_count = core->channel_count,
                   .cds = core->cds,
                   .stop_seen = core->stop_seen,
                   .lead_clocks = core->lead_clocks,
                   .ack_clocks = core->ack_clocks};
  std::copy_n(core->channel_list.begin(), Channels, wide.channel_list.begin());
  return difference(biss::Result<biss::Frame, biss::FrameFault>(wide), judge);
}
/// The difference between a reading and the sent values.
std::string difference(const oracle::Reading& judge, const Sent& sent);

/// Encodes and decodes with both; all results must agree with the sent values.
/// \return the first disagreement, empty when there is none
template <class Codec>
std::string judge_frame(const Twin& twin, const Codec& codec, const Sent& sent) {
  const auto bits = biss::encode_frame(frame_of(sent), codec);
  if (!bits.ok()) return twin.text + ": does not encode";
  const oracle::Bits line =
      oracle::encode(twin.description, sent.values, sent.lead, sent.ack, sent.cds);
  if (bits_of(bits->view()) != line) return twin.text + ": encoders differ";
  const oracle::Reading reading = oracle::decode(twin.description, {}, line);
  std::string what = difference(reading, sent);
  if (what.empty()) what = difference(biss::decode_frame(bits->view(), codec), reading);
  return what.empty() ? what : twin.text + ": " + what;
}

/// Decodes any line with both.
/// \return the disagreement, empty when there is none
template <class Codec>
std::string judge_line(const Twin& twin, const Codec& codec, const oracle::Bits& line,
                       const biss::FrameBounds& bounds = {}) {
  const oracle::Reading reading = oracle::decode(twin.description, limits_of(bounds), line);
  const std::string what =
      difference(biss::decode_frame(line_of(line).view(), codec, bounds), reading);
  return what.empty() ? what : twin.text + ": damaged line: " + what;
}

/// Flips a bit, cuts the line, drops or doubles a bit.
oracle::Bits damaged(oracle::Bits line, biss::test::Random& random);

/// A random channel that the grammar allows.
oracle::ChannelDescription random_channel(biss::test::Random& random);

}  // namespace exhaustive
