#include "lab/sequence_frame.hpp"

#include <algorithm>

namespace biss::lab {
namespace {

constexpr std::size_t other_count = 9;
constexpr std::uint64_t other_seed = 0x0B155;

// A start value other than this one.
std::uint16_t other_start(const CrcSpec& crc, sim::Random& random) {
  const std::uint64_t apart = 1 + random.below(crc.mask());
  return static_cast<std::uint16_t>(crc.start ^ apart);
}

// Another polynomial of that degree that ends in 1.
std::uint32_t other_polynomial(const CrcSpec& crc, sim::Random& random) {
  const std::uint64_t apart = 1 + random.below(crc.mask() >> 1U);
  return crc.polynomial ^ static_cast<std::uint32_t>(apart << 1U);
}

std::vector<SequenceFrame::Codec> with_other_starts(const FrameFormat& format) {
  std::vector<SequenceFrame::Codec> codecs;
  sim::Random random(other_seed);
  for (std::size_t n = 0; n < other_count; ++n) {
    FrameFormat other = format;
    for (std::size_t k = 0; k < 2; ++k) {
      CrcSpec& crc = other.channel_list[k].crc;
      if (n % 3 != 1 - k) crc.start = other_start(crc, random);
    }
    codecs.emplace_back(other);
  }
  return codecs;
}

std::vector<SequenceFrame::Codec> with_other_polynomials(const FrameFormat& format) {
  std::vector<SequenceFrame::Codec> codecs;
  sim::Random random(other_seed);
  for (std::size_t n = 0; n < other_count; ++n) {
    FrameFormat other = format;
    CrcSpec& crc = other.channel_list[1].crc;
    crc.polynomial = other_polynomial(crc, random);
    codecs.emplace_back(other);
  }
  return codecs;
}

}  // namespace

std::optional<SequenceFrame> SequenceFrame::make(const FrameFormat& format, SafetySetup setup,
                                                 CounterMode counter, CounterMode encoder_counter) {
  setup.counter.mode = encoder_counter;
  const auto words = CampaignFrame::make(format, setup);
  setup.counter.mode = counter;
  if (!words || check_safety(format, setup)) return std::nullopt;
  Monitor ready{Plan(format, setup)};
  if (!ready.self_test()) return std::nullopt;
  return SequenceFrame(*words, ready);
}

SequenceFrame::SequenceFrame(const CampaignFrame& words, const Monitor& ready)
    : words_(words),
      ready_(ready),
      other_starts_(with_other_starts(words.format())),
      other_polynomials_(with_other_polynomials(words.format())),
      bits_(words.bits()) {
  constexpr std::uint16_t most = 16;
  const FrameBounds& bounds = setup().bounds;
  lead_min_ = std::max<std::uint16_t>(bounds.lead_min_clocks, 1);
  ack_min_ = std::max<std::uint16_t>(bounds.ack_min_clocks, 1);
  lead_choice_ = std::min<std::uint16_t>(
      most, static_cast<std::uint16_t>(1 + bounds.lead_max_clocks - lead_min_));
  ack_choice_ = std::min<std::uint16_t>(
      most, static_cast<std::uint16_t>(1 + bounds.ack_max_clocks - ack_min_));
}

Picoseconds SequenceFrame::cycle() const {
  return std::clamp(setup().cycle_min, setup().frame_gap_min, setup().frame_gap_max);
}

unsigned SequenceFrame::watchdog_cycles() const {
  const std::int64_t over = setup().frame_gap_max.count + 1 - cycle().count;
  return static_cast<unsigned>((over + cycle().count - 1) / cycle().count);
}

FrameBits SequenceFrame::encode(const SequenceWords& words, const Codec& codec,
                                sim::Random& random) const {
  const std::uint64_t drawn = random.next();
  BasicFrame<2> frame;
  frame.channel_count = 2;
  frame.lead_clocks =
      static_cast<std::uint16_t>(lead_min_ + ((drawn & 0xFFFFU) * lead_choice_ >> 16U));
  frame.ack_clocks = static_cast<std::uint16_t>(ack_min_ + ((drawn >> 48U) * ack_choice_ >> 16U));
  frame.channel_list[0] = {words.cpw, 0, true, words.cpw_nW};
  frame.channel_list[1] = {words.spw, words.life_counter, true, words.spw_nW};
  return encode_frame(frame, codec).value();
}

}  // namespace biss::lab
