// Hostile bits read as frames.
//
// Input: the format's number in frame_formats, the longest ACK in clocks (0: the widest bounds),
// the number of unused bits in the last byte; then the bits.
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "biss/frame/decode.hpp"
#include "biss/frame/encode.hpp"
#include "biss/frame/format_text.hpp"
#include "fuzz/frame_formats.hpp"
#include "fuzz/require.hpp"

namespace {

using biss::fuzz::require;

struct Codecs {
  biss::FrameCodec<> fast;
  biss::PlainCodec plain;
  bool padded;
};

// Bits outside all items are not encoded again.
bool has_padding(const biss::FrameFormat& format) {
  for (const biss::ChannelFormat& channel : format.channels()) {
    const unsigned claimed = channel.position_bits() + channel.life_counter.bits +
                             unsigned{channel.error.present} + unsigned{channel.warning.present};
    if (claimed != channel.data_bits) return true;
  }
  return false;
}

const std::vector<Codecs>& all_codecs() {
  static const std::vector<Codecs> codecs = [] {
    std::vector<Codecs> made;
    for (const std::string_view text : biss::fuzz::frame_formats) {
      const biss::FrameFormat format = *biss::parse_format(text);
      made.push_back({biss::FrameCodec<>(format), biss::PlainCodec(format), has_padding(format)});
    }
    return made;
  }();
  return codecs;
}

// Encoding the decoded values gives the same bits.
void check_given_back(const biss::Frame& frame, biss::BitView bits, const Codecs& codecs) {
  const auto sent = encode_frame(frame, codecs.plain);
  require(sent.ok());
  const std::size_t size = sent->size_bits() - (frame.stop_seen ? 0U : 1U);
  require(size <= bits.size_bits());
  for (std::size_t i = 0; i < size; ++i) require(sent->view()[i] == bits[i]);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 3) return 0;
  const Codecs& codecs = all_codecs()[data[0] % all_codecs().size()];
  biss::FrameBounds bounds;
  if (data[1] != 0) bounds.ack_max_clocks = data[1];
  const std::span<const std::uint8_t> bytes(data + 3, size - 3);
  const std::size_t cut = bytes.empty() ? 0 : data[2] % 8U;
  const biss::BitView bits(bytes, 0, bytes.size() * 8 - cut);

  const auto frame = decode_frame(bits, codecs.fast, bounds);
  const auto judge = decode_frame(bits, codecs.plain, bounds);
  require(frame.ok() == judge.ok());
  if (!frame.ok()) {
    require(frame.error() == judge.error());
    require(!name_of(frame.error().cause).empty());
    return 0;
  }
  require(frame->channel_list == judge->channel_list);
  require(frame->ack_clocks <= bounds.ack_max_clocks);
  if (!codecs.padded) check_given_back(*frame, bits, codecs);
  const std::size_t needed =
      frame->lead_clocks + frame->ack_clocks + 2U + codecs.plain.payload_bits();
  const auto shorter = decode_frame(bits.first(needed - 1), codecs.fast, bounds);
  require(!shorter.ok() && shorter.error().cause == biss::FrameError::truncated);
  return 0;
}
