// The grammar of frame formats on hostile text.
#include "biss/frame/decode.hpp"
#include "biss/frame/encode.hpp"
#include "biss/frame/format_text.hpp"
#include "fuzz/target.hpp"

namespace {

using namespace biss;
using namespace biss::fuzz;

void check_limits(const FrameFormat& format) {
  require(format.channel_count >= 1 && format.channel_count <= max_channels);
  for (const ChannelFormat& channel : format.channels()) {
    require(channel.data_bits >= 1 && channel.data_bits <= max_data_bits);
    require(channel.position_bits() <= channel.data_bits);
    require(channel.crc.width_bits <= max_crc_bits);
  }
}

// Every accepted format works: the decoded values are the encoded ones.
void check_round_trip(const FrameFormat& format, std::string_view text) {
  const PlainCodec codec(format);
  Frame frame;
  frame.channel_count = format.channel_count;
  frame.lead_clocks = 1;
  frame.ack_clocks = 1;
  std::uint64_t mixed = text.size();
  for (std::size_t k = 0; k < format.channel_count; ++k) {
    const ChannelFormat& channel = format.channel_list[k];
    mixed = mixed * 6'364'136'223'846'793'005U + static_cast<unsigned char>(text[k]);
    frame.channel_list[k].position = mixed & low_mask(channel.position_bits());
    frame.channel_list[k].life_counter =
        static_cast<std::uint32_t>(mixed & low_mask(channel.life_counter.bits));
    frame.channel_list[k].nE = !channel.error.present || (mixed >> 40U & 1U) != 0;
    frame.channel_list[k].nW = !channel.warning.present || (mixed >> 41U & 1U) != 0;
  }
  const auto bits = encode_frame(frame, codec);
  require(bits.ok());
  const auto back = decode_frame(bits->view(), codec);
  require(back.ok() && back->channel_list == frame.channel_list);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto format = parse_format(text);
  if (!format.ok()) {
    require(format.error().at <= size);
    require(!text_of(format.error().mistake).empty());
    return 0;
  }
  check_limits(*format);
  const FormatText canonical = format_text(*format);
  const auto again = parse_format(canonical.view());
  require(again.ok() && *again == *format);
  require(format_text(*again).view() == canonical.view());
  check_round_trip(*format, text);
  return 0;
}
