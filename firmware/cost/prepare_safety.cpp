// Frames for the safety monitor: good frames, damaged frames, and frames that no encoder sends.
#include <algorithm>
#include <cstdint>

#include "firmware/cost/prepare.hpp"

namespace cost::prepare {
namespace {

using Plan = biss::FixedSafetyPlan<safety_format, safety_setup>;

struct Sent {
  std::uint64_t position = 0;
  std::uint64_t safety_position = 0;
  std::uint32_t life_counter = 0;
  bool cpw_nE = true;
  bool spw_nE = true;
  std::uint16_t ack = 33;
};

void put(Sample& sample, const Sent& sent, Random& random) {
  biss::BasicFrame<2> frame;
  frame.channel_count = 2;
  frame.lead_clocks = static_cast<std::uint16_t>(2U + random.below(7));
  frame.ack_clocks = sent.ack;
  frame.channel_list[0] = {sent.position, 0, sent.cpw_nE, random.flip()};
  frame.channel_list[1] = {sent.safety_position, sent.life_counter, sent.spw_nE, random.flip()};
  const biss::FrameBits bits = biss::encode_frame(frame, Plan::codec()).value();
  sample.bytes = {};
  const std::size_t size = std::min(bits.bytes().size(), sample.bytes.size());
  std::copy_n(bits.bytes().begin(), size, sample.bytes.begin());
  sample.size_bytes = static_cast<std::uint32_t>(sample.bytes.size());
}

// Faults of an encoder, chosen at random.
void change(Sent& sent, Random& random) {
  switch (random.below(5)) {
    case 0:
      sent.life_counter = random.below(64);
      break;
    case 1:
      sent.safety_position = random.bits(28);
      break;
    case 2:
      sent.cpw_nE = random.flip();
      sent.spw_nE = random.flip();
      break;
    case 3:
      // The whole buffer is ACK, or nearly so.
      sent.ack = static_cast<std::uint16_t>(200U + random.below(170));
      break;
    default:
      sent.ack = static_cast<std::uint16_t>(1U + random.below(40));
  }
}

void damage(Sample& sample, Random& random) {
  const std::uint32_t bits = sample.size_bytes * 8U;
  switch (random.below(4)) {
    case 0:
      for (std::uint32_t flips = 1U + random.below(8); flips != 0; --flips) {
        const std::uint32_t at = random.below(bits);
        sample.bytes[at / 8U] =
            static_cast<std::uint8_t>(sample.bytes[at / 8U] ^ (0x80U >> at % 8U));
      }
      break;
    case 1:
      for (auto& byte : sample.bytes) byte = static_cast<std::uint8_t>(random.bits(8));
      break;
    case 2:
      sample.bytes.fill(random.flip() ? 0xFF : 0x00);
      break;
    default:
      sample.size_bytes = random.below(sample.size_bytes + 1U);
  }
}

// In the safe state, the last counter `last` at the time 0.
void make_safe(SafetyMonitor& monitor, std::uint32_t last) {
  biss::SafetyFinding finding;
  finding.cause = biss::SafetyVerdict::safe;
  for (std::uint32_t left = safety_setup.start_frames; left-- != 0;) {
    const std::uint32_t value = (last + 62U - left) % 63U + 1U;
    finding.life_counter = static_cast<std::uint8_t>(value);
    monitor.step(clocks_at(biss::nanoseconds(31'250).count * -std::int64_t{left}), finding,
                 finding);
  }
}

}  // namespace

void safety_frame(Sample& sample, Random& random) {
  const std::uint32_t last = 1U + random.below(63);
  sample.tested->put_into(*sample.safety);
  make_safe(*sample.safety, last);
  Sent sent;
  sent.position = random.bits(36);
  sent.safety_position = sent.position >> 8U;
  sent.life_counter = last % 63U + 1U;
  sent.ack = static_cast<std::uint16_t>(33U + random.below(128));
  const std::uint32_t kind = random.below(4);
  if (kind == 1) change(sent, random);
  put(sample, sent, random);
  if (kind == 2) damage(sample, random);
  const biss::Picoseconds now = biss::nanoseconds(random.below(8) == 0 ? 61'250 : 31'250);
  sample.value = static_cast<std::uint64_t>(now.count);
  const MonitorBytes here(*sample.safety);
  const biss::SafetyJudgement judgement = sample.safety->step(clocks_at(now.count), sample.bits());
  here.put_into(*sample.safety);
  sample.expected = result_of(judgement);
  const bool good = kind == 0 && now <= safety_setup.frame_gap_max;
  if (good && control_position(Plan(), *judgement.position) != sent.position)
    sample.expected = ~sample.expected;
}

}  // namespace cost::prepare
