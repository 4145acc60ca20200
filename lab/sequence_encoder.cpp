#include "lab/sequence_encoder.hpp"

namespace biss::lab {
namespace {

constexpr unsigned one_way = 256;

std::uint64_t negative(std::uint64_t value) { return std::uint64_t{0} - value; }

}  // namespace

SequenceEncoder::SequenceEncoder(const SequenceFrame& frame, CounterMode counter,
                                 SequenceMotion motion, WordRule rule, std::uint64_t seed)
    : cpw_(frame.words().cpw_format()),
      spw_(frame.words().spw_format()),
      motion_(motion),
      random_(seed),
      position_bits_(cpw_.position_bits()),
      off_(rule == WordRule::truncated ? 0
                                       : std::uint64_t{frame.setup().comparison.tolerance_lsb}
                                             << frame.ready().plan().alignment().spw_shift) {
  life_.first = counter == CounterMode::count_0_63 ? 0 : 1;
  put_elsewhere();
}

void SequenceEncoder::put_elsewhere() {
  frames_ = random_.below(life_.period());
  in_stretch_ = 0;
}

// Just less than half a turn.
std::uint64_t SequenceEncoder::full_speed() {
  const unsigned turn_bits = cpw_.position.present() ? position_bits_ : cpw_.singleturn.bits;
  const std::uint64_t half_turn = std::uint64_t{1} << (63U - (position_bits_ - turn_bits));
  const std::uint64_t count = std::uint64_t{1} << (64U - position_bits_);
  const std::uint64_t room = half_turn / 16;
  return half_turn - count - (room != 0 ? random_.next() % room : 0);
}

// Every magnitude as often, down to a count.
std::uint64_t SequenceEncoder::any_speed() {
  const std::uint64_t top = (random_.next() | (std::uint64_t{1} << 63U)) >> 1U;
  return top >> random_.below(position_bits_);
}

void SequenceEncoder::begin_stretch() {
  const bool at_zero = stretches_++ % 2 == 1;
  if (motion_ == SequenceMotion::creep) {
    // About a multiple of any power of two, so that carries of every length come.
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
