// The values that one encoder sends: its position at the sampling moment, its flags, its sign of
// life, and the contents of its registers.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>

#include "biss/frame/codec.hpp"
#include "biss/slave/slave.hpp"
#include "biss/timing/device_timing.hpp"
#include "sim/encoder_registers.hpp"
#include "sim/motion.hpp"
#include "sim/random.hpp"
#include "sim/sign_of_life.hpp"
#include "sim/wrong_frames.hpp"

namespace biss::sim {

/// How much later than typical an encoder of this type takes the position of its request `number`,
/// negative: earlier. Drawn between the bounds of the type; the same for the same seed and number.
constexpr Picoseconds sampling_shift(const DeviceTiming& timing, std::uint64_t seed,
                                     std::uint64_t number) {
  if (timing.sampling_max <= timing.sampling_min) return {};
  const auto width =
      static_cast<std::uint64_t>((timing.sampling_max - timing.sampling_min).count) + 1U;
  const std::uint64_t drawn = Random(seed ^ scrambled(number)).next() % width;
  return timing.sampling_min - timing.sampling_typical +
         picoseconds(static_cast<std::int64_t>(drawn));
}

/// The channel with the position of the motion: the first channel with a position, or the first
/// channel if none has one.
inline const ChannelFormat& position_word(const FrameFormat& format) {
  const auto words = format.channels();
  const auto word = std::find_if(words.begin(), words.end(), [](const ChannelFormat& each) {
    return each.position_bits() != 0;
  });
  return word == words.end() ? words.front() : *word;
}

/// The source of a Slave.
class Encoder {
 public:
  /// \param format its own channels; not empty
  /// \param drift as in LineSetup
  Encoder(const FrameFormat& format, const Motion& motion, const SignOfLife& life = {},
          std::int32_t drift = 0)
      : format_(format),
        motion_(motion),
        position_bits_(motion.position_bits()),
        turns_alone_(singleturn_bits(position_word(format)) == 0),
        singleturn_bits_(turns_alone_ ? position_bits_ : singleturn_bits(position_word(format))),
        life_(life),
        drift_(drift) {
    meant_.channel_count = format.channel_count;
  }

  const Frame& sample(Picoseconds moment) {
    moment += shift_;
    if (!frozen_) take_position(moment);
    // The sign of life also counts the lost frames.
    const std::uint32_t steps = wrong_.take_lost() + (wrong_.holds_counter() ? 0U : 1U);
    frames_ += frames_ + steps == 0 ? 1 : steps;  // the first frame has the start value
    drifted_ += static_cast<std::uint64_t>(std::int64_t{drift_});
    moment_ = moment;
    const std::uint64_t sent = with_late_turns(position_);
    turns_were_late_ = sent != position_;
    meant_ = filled(sent, 0);
    reach(Progress::taken);
    if (wrong_.ahead() == 0) return wrong_.put(meant_);
    const std::uint64_t apart =
        position_bits_ == 0 ? 0 : wrong_.position_share() >> (64U - position_bits_);
    foreign_ = filled(position_ + apart, wrong_.ahead() + (wrong_.holds_counter() ? 1U : 0U));
    return foreign_;
  }
  bool cds(bool predecessor) { return control_ ? control_->cds(predecessor) : predecessor; }
  void cdm(bool bit) {
    if (control_) control_->cdm(bit);
  }

  /// Takes part in the control communication, as after power-up. Without registers the encoder is
  /// unidirectional.
  /// \param registers must outlive it
  void set_registers(EncoderRegisters& registers) { control_.emplace(RegistersAt{&registers}); }

  /// The position as of a moment, not wider than its word; empty: there is no valid position, and
  /// the frame means "no data", positions 0, nE and nW active.
  using Positions = std::optional<std::uint64_t> (*)(void* user, Picoseconds moment);
  /// From now on positions come from this function and not from the motion.
  void set_positions(Positions positions, void* user) {
    positions_ = positions;
    user_ = user;
  }

  /// From the next sample on. \param late_turns the turns change 1/64 of a turn after the zero
  void set_flags(bool nE, bool nW, bool frozen, bool late_turns) {
    nE_ = nE;
    nW_ = nW;
    frozen_ = frozen;
    late_turns_ = late_turns;
  }
  /// The turns of the last sample were late.
  bool has_late_turns() const { return turns_were_late_; }

  /// Stops the motion from now on. \param position not wider than the motion's position
  void hold(std::uint64_t position) { motion_.hold(position); }
  /// Another motion from now on, of the same word.
  void set_motion(const Motion& motion) { motion_ = motion; }
  /// The position of the motion at this time, whether or not it is sampled then.
  std::uint64_t position_at(Picoseconds moment) const { return motion_.at(moment); }

  /// Faults outside of the encoder have no effect. \param detail random bits of the fault
  void begin_fault(FaultKind kind, std::uint64_t detail) {
    wrong_.begin(kind, detail);
    if (kind == FaultKind::lc_restart) restart();
  }
  void end_fault(FaultKind kind) { wrong_.end(kind); }
  /// Sets the state after power-up: the signs of life start from their first values.
  void restart() { frames_ = 0; }

  /// A request cycle begins: nothing sent yet.
  /// \param shift sampling_shift() of this cycle
  void begin_cycle(Picoseconds shift = {}) {
    sampled_.reset();
    sent_progress_ = Progress::none;
    if (progress_ == Progress::begun) progress_ = Progress::none;
    shift_ = shift;
  }
  /// Call it after each step of the slave if a fault may end a frame early.
  void follow(SlaveState state) {
    if (state == SlaveState::requested) progress_ = Progress::none;
    if (state == SlaveState::start && progress_ == Progress::taken) reach(Progress::begun);
    if (state == SlaveState::stop && progress_ == Progress::begun) reach(Progress::whole);
  }
  /// The frame that was sent since begin_cycle(), without the effect of faults. After a fault the
  /// encoder may take several positions: this is the first frame that was sent completely, else the
  /// first frame that was begun, else the first one. \pre sampled()
  const Frame& sent() const { return sent_; }
  /// The time at which its position was sampled; empty if there is no such frame.
  std::optional<Picoseconds> sampled() const { return sampled_; }

 private:
  // How far a frame has come.
  enum class Progress : std::uint8_t { none, taken, begun, whole };

  void reach(Progress progress) {
    progress_ = progress;
    if (progress <= sent_progress_) return;
    sent_progress_ = progress;
    sent_ = meant_;
    sampled_ = moment_;
  }

  void take_position(Picoseconds moment) {
    if (positions_ == nullptr) {
      position_ = motion_.sample(moment);
      return;
    }
    const auto given = positions_(user_, moment);
    no_data_ = !given;
    position_ = given.value_or(0);
  }

  std::uint64_t with_late_turns(std::uint64_t position) {
    if (!late_turns_ || turns_alone_ || singleturn_bits_ >= position_bits_) return position;
    const std::uint64_t late = std::max<std::uint64_t>(low_mask(singleturn_bits_) >> 6U, 1);
    const std::uint64_t within = low_mask(singleturn_bits_);
    return (((position - late) & ~within) | (position & within)) & low_mask(position_bits_);
  }

  // 0: turns alone.
  static unsigned singleturn_bits(const ChannelFormat& word) {
    return word.position.present() ? word.position.bits : word.singleturn.bits;
  }

  // The singleturn value with the word's resolution, aligned at the top, and turns at the bottom
  // (PROTOCOL 5.3): a word without turns shows the place within the turn.
  std::uint64_t of_word(const ChannelFormat& word, std::uint64_t position) const {
    const unsigned bits = turns_alone_ ? word.position_bits() : singleturn_bits(word);
    const std::uint64_t aligned = bits <= singleturn_bits_ ? position >> (singleturn_bits_ - bits)
                                                           : position << (bits - singleturn_bits_);
    return aligned & low_mask(word.position_bits());
  }

  Frame filled(std::uint64_t position, std::uint64_t frames_ahead) const {
    Frame frame;
    frame.channel_count = format_.channel_count;
    const std::uint64_t count = (frames_ == 0 ? 0 : frames_ - 1U) + frames_ahead;
    for (std::size_t k = 0; k < format_.channel_count; ++k) {
      const ChannelFormat& format = format_.channel_list[k];
      const unsigned bits = format.position_bits();
      Channel& channel = frame.channel_list[k];
      if (bits != 0 && !no_data_) {
        const std::uint64_t shown = (position + (k == 0 ? 0 : drifted_)) & low_mask(position_bits_);
        channel.position = of_word(format, shown);
      }
      channel.life_counter = life_.value(k, count, format.life_counter.bits);
      channel.nE = (nE_ && !no_data_) || !format.error.present;
      channel.nW = (nW_ && !no_data_) || !format.warning.present;
    }
    return frame;
  }

  FrameFormat format_;
  Motion motion_;
  unsigned position_bits_;
  bool turns_alone_;
  unsigned singleturn_bits_;
  SignOfLife life_;
  std::int32_t drift_;
  Frame meant_;
  Frame foreign_;
  WrongFrames wrong_;
  std::optional<EncoderControl> control_;
  std::uint64_t position_ = 0;
  std::uint64_t frames_ = 0;   // counted since power-up, this one included
  std::uint64_t drifted_ = 0;  // in counts of the position, modulo its range
  bool nE_ = true;
  bool nW_ = true;
  bool frozen_ = false;
  bool no_data_ = false;
  bool late_turns_ = false;
  bool turns_were_late_ = false;
  Positions positions_ = nullptr;
  void* user_ = nullptr;
  Progress progress_ = Progress::none;  // of meant_
  Picoseconds moment_{};                // of meant_
  Progress sent_progress_ = Progress::none;
  Frame sent_;
  std::optional<Picoseconds> sampled_;
  Picoseconds shift_{};
};

}  // namespace biss::sim
