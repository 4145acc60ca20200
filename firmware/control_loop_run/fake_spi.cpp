#include "firmware/control_loop_run/fake_spi.hpp"

#include <algorithm>

namespace control_loop_run {
namespace {

constexpr unsigned word_bits = codec.payload_bits();

// Software pends the interrupt in place of the DMA controller, by NVIC_ISPR0.
void raise_dma_interrupt() { *reinterpret_cast<volatile std::uint32_t*>(0xE000'E200U) = 1; }

biss::FrameBits answer(const Axis& axis, Damage damage, std::uint64_t random) {
  biss::Frame frame;
  frame.channel_count = 1;
  frame.lead_clocks = static_cast<std::uint16_t>(2U + random % 5U);
  frame.ack_clocks = static_cast<std::uint16_t>(33U + (random >> 8U) % 100U);
  frame.channel_list[0].position = static_cast<std::uint64_t>(axis.position) & biss::low_mask(26);
  frame.channel_list[0].nE = damage != Damage::error_bit;
  return biss::encode_frame(frame, codec).value();
}

void spoil(biss::FrameBits& bits, Damage damage, std::uint64_t random) {
  const std::size_t word = bits.size_bits() - 1U - word_bits;
  const auto first = static_cast<std::size_t>((random >> 16U) % word_bits);
  const auto second = static_cast<std::size_t>((random >> 24U) % word_bits);
  if (damage == Damage::flips) {
    bits.flip(word + first);
    if (second != first) bits.flip(word + second);
  }
  if (damage == Damage::pulled) {
    bits.truncate(word + first);
    bits.append_run(true, 400);
  }
}

}  // namespace

void Axis::step() {
  position += speed;
  speed += upwards ? acceleration : -acceleration;
  if (speed >= top_speed) upwards = false;
  if (speed <= -top_speed) upwards = true;
}

bool FakeSpi::start(std::span<std::uint8_t> receive) {
  if (!receive_.empty()) return false;
  receive_ = receive;
  return true;
}

void FakeSpi::finish_transfer(const Axis& axis, Damage damage, std::uint64_t random) {
  if (receive_.empty()) return;
  auto bits = answer(axis, damage, random);
  spoil(bits, damage, random);
  const auto bytes = bits.bytes().first(std::min(bits.bytes().size(), receive_.size()));
  const std::uint8_t rest = damage == Damage::unplugged ? 0xFF : 0;
  std::fill(receive_.begin(), receive_.end(), rest);
  const bool answers = damage != Damage::unplugged && damage != Damage::stuck_low;
  if (answers) std::copy(bytes.begin(), bytes.end(), receive_.begin());
  receive_ = {};
  raise_dma_interrupt();
}

}  // namespace control_loop_run
