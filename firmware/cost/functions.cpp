// The measured functions and nothing else, so that an image of one of them shows its size.
#include <cstdint>

#include "firmware/cost/sample.hpp"

namespace cost {
namespace {

inline std::uint64_t position_of(const biss::Result<biss::Frame, biss::FrameFault>& frame) {
  return frame.ok() ? frame->channel_list[0].position : ~std::uint64_t{0};
}

inline std::uint64_t encoded(const Sample& s) {
  biss::Frame frame;
  frame.channel_count = 1;
  frame.lead_clocks = 2;
  frame.ack_clocks = static_cast<std::uint16_t>(s.index);
  frame.channel_list[0].position = s.value;
  const auto bits = biss::encode_frame(frame, fixed_codec);
  return bits.ok() ? bits->size_bits() : 0;
}

// The counter was prepared with the sample before.
inline std::uint64_t turns_after(const Sample& s) {
  s.counter->update(s.value);
  return static_cast<std::uint64_t>(s.counter->turns());
}

}  // namespace

extern "C" {

#define BISS_ROW(name, title, sample, ...)    \
  std::uint64_t cost_##name(const Sample& s); \
  std::uint64_t cost_##name(const Sample& s) { return static_cast<std::uint64_t>(__VA_ARGS__); }
#include "firmware/cost/rows.inc"
#undef BISS_ROW

}  // extern "C"

}  // namespace cost
