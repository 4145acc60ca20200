#include "lab/sequence_frame.hpp"

#include <algorithm>
#include <memory>
#include <utility>

namespace biss::lab {
namespace {

constexpr std::size_t other_count = 9;
constexpr std::uint64_t other_seed = 0x0B155;

// Encoders of this type that `change(format, random, n)` makes different.
template <class Change>
std::vector<SequenceFrame::Codec> other_codecs(const FrameFormat& format, const Change& change) {
  std::vector<SequenceFrame::Codec> codecs;
  sim::Random random(other_seed);
  for (std::size_t n = 0; n < other_count; ++n) {
    FrameFormat other = format;
    change(other, random, n);
    codecs.emplace_back(other);
  }
  return codecs;
}

void change_starts(FrameFormat& format, sim::Random& random, std::size_t n) {
  for (std::size_t k = 0; k < 2; ++k) {
    CrcSpec& crc = format.channel_list[k].crc;
    if (n % 3 == 1 - k) continue;
    crc.start = static_cast<std::uint16_t>(crc.start ^ (1 + random.below(crc.mask())));
  }
}

// The lowest coefficient stays 1.
void change_polynomial(FrameFormat& format, sim::Random& random, std::size_t /*n*/) {
  CrcSpec& crc = format.channel_list[1].crc;
  crc.polynomial ^= static_cast<std::uint32_t>((1 + random.below(crc.mask() >> 1U)) << 1U);
}

// At least 1. \param share in parts of 2^16
std::uint16_t drawn_clocks(std::uint16_t min, std::uint16_t max, std::uint64_t share) {
  const unsigned least = std::max<unsigned>(min, 1);
  const unsigned choice = std::min(16U, 1U + max - least);
  return static_cast<std::uint16_t>(least + (share * choice >> 16U));
}

constexpr unsigned one_way = 256;

std::uint64_t negative(std::uint64_t value) { return std::uint64_t{0} - value; }

}  // namespace

std::optional<SequenceFrame> SequenceFrame::make(const FrameFormat& format, SafetySetup setup,
                                                 CounterMode counter, CounterMode encoder_counter) {
  setup.counter.mode = encoder_counter;
  const auto words = CampaignFrame::make(format, setup);
  setup.counter.mode = counter;
  const UnratedSafetySetup unrated(setup);
  if (!words || check_safety(format, unrated)) return std::nullopt;
  SequenceFrame frame(*words, std::make_shared<const Plan>(format, unrated));
  if (!Monitor(frame.plan()).self_test()) return std::nullopt;
  return frame;
}

SequenceFrame::SequenceFrame(const CampaignFrame& words, std::shared_ptr<const Plan> plan)
    : words_(words),
      plan_(std::move(plan)),
      other_starts_(other_codecs(words.format(), change_starts)),
      other_polynomials_(other_codecs(words.format(), change_polynomial)) {}

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
  const FrameBounds& bounds = setup().bounds;
  frame.lead_clocks = drawn_clocks(bounds.lead_min_clocks, bounds.lead_max_clocks, drawn & 0xFFFFU);
  frame.ack_clocks = drawn_clocks(bounds.ack_min_clocks, bounds.ack_max_clocks, drawn >> 48U);
  frame.channel_list[0] = {words.cpw, 0, true, words.cpw_nW};
  frame.channel_list[1] = {words.spw, words.life_counter, true, words.spw_nW};
  return encode_frame(frame, codec).value();
}

SequenceEncoder::SequenceEncoder(const SequenceFrame& frame, CounterMode counter,
                                 SequenceMotion motion, WordRule rule, std::uint64_t seed)
    : cpw_(frame.words().cpw_format()),
      spw_(frame.words().spw_format()),
      motion_(motion),
      random_(seed),
      position_bits_(cpw_.position_bits()),
      off_(rule == WordRule::truncated ? 0
                                       : std::uint64_t{frame.setup().comparison.tolerance_lsb}
                                             << frame.plan().alignment().spw_shift) {
  life_.first = counter == CounterMode::count_0_63 ? 0 : 1;
  put_elsewhere();
}

void SequenceEncoder::put_elsewhere() {
  frames_ = random_.below(life_.period());
  in_stretch_ = 0;
}

// Just below half a turn.
std::uint64_t SequenceEncoder::full_speed() {
  const unsigned turn_bits = cpw_.position.present() ? position_bits_ : cpw_.singleturn.bits;
  const std::uint64_t half_turn = std::uint64_t{1} << (63U - (position_bits_ - turn_bits));
  const std::uint64_t count = std::uint64_t{1} << (64U - position_bits_);
  const std::uint64_t room = half_turn / 16;
  return half_turn - count - (room != 0 ? random_.next() % room : 0);
}

// Every magnitude equally often, down to a count.
std::uint64_t SequenceEncoder::any_speed() {
  const std::uint64_t top = (random_.next() | (std::uint64_t{1} << 63U)) >> 1U;
  return top >> random_.below(position_bits_);
}

void SequenceEncoder::begin_stretch() {
  const bool at_zero = stretches_++ % 2 == 1;
  if (motion_ == SequenceMotion::creep) {
    // Near a multiple of any power of two, so that carries of every length occur.
    const std::uint64_t at = random_.next() << random_.below(position_bits_);
    speed_ = 0;
    place_ = at_zero ? 0 : at << (64U - position_bits_);
    return;
  }
  speed_ = motion_ == SequenceMotion::max ? full_speed() : any_speed();
  if ((random_.next() >> 63U) != 0) speed_ = negative(speed_);
  place_ = at_zero ? negative(speed_ * (1 + random_.below(one_way - 1))) : random_.next();
}

void SequenceEncoder::move() {
  if (in_stretch_ == 0) {
    begin_stretch();
  } else {
    std::uint64_t step = in_stretch_ < one_way ? speed_ : negative(speed_);
    if (motion_ == SequenceMotion::creep) {
      const std::uint64_t counts = random_.below(5) - 2U;
      step = counts << (64U - position_bits_);
    }
    const std::uint64_t before = place_;
    place_ += step;
    const bool forwards = (step >> 63U) == 0;
    if (forwards ? place_ < before : place_ > before) ++position_wraps_;
  }
  in_stretch_ = (in_stretch_ + 1U) % (2 * one_way);
}

std::uint64_t SequenceEncoder::spw_of(std::uint64_t position) {
  std::uint64_t spw = spw_position(cpw_, spw_, position);
  if (off_ != 0) spw += random_.below(2 * off_ + 1) - off_;
  return spw & low_mask(spw_.position_bits());
}

SequenceWords SequenceEncoder::next() {
  move();
  const std::uint32_t before = life_counter_;
  life_counter_ = life_.value(1, frames_++, safety_counter_bits);
  if (life_counter_ < before) ++counter_wraps_;
  const std::uint64_t at = position();
  SequenceWords words{
      .cpw = at, .spw = spw_of(at), .life_counter = static_cast<std::uint8_t>(life_counter_)};
  if (warns_) {
    const std::uint64_t drawn = random_.next();
    words.cpw_nW = !cpw_.warning.present || (drawn & 0x3FU) != 0;
    words.spw_nW = !spw_.warning.present || (drawn & 0xFC0U) != 0;
  }
  return words;
}

SequenceWords SequenceEncoder::foreign(sim::Random& random) const {
  const std::uint64_t at = random.next() >> (64U - position_bits_);
  return {.cpw = at,
          .spw = spw_position(cpw_, spw_, at) & low_mask(spw_.position_bits()),
          .life_counter = static_cast<std::uint8_t>(life_.first + random.below(life_.period()))};
}

}  // namespace biss::lab
