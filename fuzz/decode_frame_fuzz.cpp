// Hostile bits read as frames.
//
// Input: the format's number in frame_formats, the longest ACK in clocks (0: the widest bounds),
// the number of unused bits in the last byte; then the bits.
#include "biss/frame/decode.hpp"
#include "biss/frame/encode.hpp"
#include "biss/frame/format_text.hpp"
#include "fuzz/frame_formats.hpp"
#include "fuzz/target.hpp"

namespace {

using namespace biss;
using namespace biss::fuzz;

// Bits outside all items are not encoded again.
bool has_padding(const FrameFormat& format) {
  for (const ChannelFormat& channel : format.channels()) {
    const unsigned claimed = channel.position_bits() + channel.life_counter.bits +
                             unsigned{channel.error.present} + unsigned{channel.warning.present};
    if (claimed != channel.data_bits) return true;
  }
  return false;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 3) return 0;
  const auto& fast = codec_of<FrameCodec<>>(data[0]);
  const auto& plain = codec_of<PlainCodec>(data[0]);
  FrameBounds bounds;
  if (data[1] != 0) bounds.ack_max_clocks = data[1];
  const std::span<const std::uint8_t> bytes(data + 3, size - 3);
  const std::size_t cut = bytes.empty() ? 0 : data[2] % 8U;
  const BitView bits(bytes, 0, bytes.size() * 8 - cut);

  const auto frame = decode_frame(bits, fast, bounds);
  const auto judge = decode_frame(bits, plain, bounds);
  require(frame.ok() == judge.ok());
  if (!frame.ok()) {
    require(frame.error() == judge.error());
    require(!name_of(frame.error().cause).empty());
    return 0;
  }
  require(frame->channel_list == judge->channel_list);
  require(frame->ack_clocks <= bounds.ack_max_clocks);
  if (!has_padding(plain.format())) check_given_back(*frame, bits, 0, plain);
  const std::size_t needed = frame->lead_clocks + frame->ack_clocks + 2U + plain.payload_bits();
  const auto shorter = decode_frame(bits.first(needed - 1), fast, bounds);
  require(!shorter.ok() && shorter.error().cause == FrameError::truncated);
  return 0;
}
