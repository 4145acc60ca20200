#include "firmware/cost/row.hpp"

namespace {

constexpr cost::Codec codec{cost::format};

}  // namespace

BISS_ROW(encode, "encode_frame, 26 bits, ACK 33 to 160 clocks", position) {
  biss::Frame frame;
  frame.channel_count = 1;
  frame.lead_clocks = 2;
  frame.ack_clocks = static_cast<std::uint16_t>(s.index);
  frame.channel_list[0].position = s.value;
  const auto bits = biss::encode_frame(frame, codec);
  return bits.ok() ? bits->size_bits() : 0;
}
