// Uses the installed core as another project would.
#include <cstdio>

#include "biss/base/units.hpp"
#include "biss/frame/codec.hpp"
#include "biss/frame/decode.hpp"
#include "biss/frame/encode.hpp"
#include "biss/frame/format_text.hpp"

namespace {

constexpr bool position_comes_back() {
  const auto format = biss::parse_format("pos26,nE,nW,crc6");
  if (!format.ok()) return false;
  const biss::PlainCodec codec(*format);
  biss::Frame frame;
  frame.channel_count = 1;
  frame.channel_list[0].position = 12'345'678;
  frame.lead_clocks = 1;
  frame.ack_clocks = 2;
  const auto bits = biss::encode_frame(frame, codec);
  if (!bits.ok()) return false;
  const auto back = biss::decode_frame(bits->view(), codec);
  return back.ok() && back->channels()[0].position == 12'345'678;
}

}  // namespace

int main() {
  static_assert(position_comes_back());
  static_assert(biss::period_of(biss::megahertz(10)) == biss::nanoseconds(100));
  const bool works = position_comes_back();
  std::puts(works ? "the installed core works" : "the installed core is wrong");
  return works ? 0 : 1;
}
