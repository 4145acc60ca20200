// What one encoder has to say: its position at the sampling moment, its flags, its sign of life,
// and what is in its registers.
#pragma once

#include <cstdint>
#include <optional>

#include "biss/frame/codec.hpp"
#include "sim/encoder_registers.hpp"
#include "sim/motion.hpp"

namespace biss::sim {

/// The source of a Slave.
class Encoder {
 public:
  /// \param format its own channels; not empty
  Encoder(const FrameFormat& format, const Motion& motion)
      : format_(format), motion_(motion), position_bits_(motion.position_bits()) {
    sent_.channel_count = format.channel_count;
  }

  const Frame& sample(Picoseconds moment) {
    if (!frozen_) position_ = motion_.sample(moment);
    life_counter_ = life_counter_ % 63 + 1;
    sampled_ = true;
    fill();
    return sent_;
  }
  bool cds(bool predecessor) { return control_ ? control_->cds(predecessor) : predecessor; }
  void cdm(bool bit) {
    if (control_) control_->cdm(bit);
  }

  /// Takes part in the control communication, as after power-up; without, it is unidirectional.
  /// \param registers must outlive it
  void set_registers(EncoderRegisters& registers) { control_.emplace(RegistersAt{&registers}); }

  /// From the next sample on.
  void set_flags(bool nE, bool nW, bool frozen) {
    nE_ = nE;
    nW_ = nW;
    frozen_ = frozen;
  }

  /// A request cycle begins: nothing sampled yet.
  void begin_cycle() { sampled_ = false; }

  /// What it sampled last since begin_cycle(), else what it would have at this time.
  const Frame& meant(Picoseconds moment) {
    if (!sampled_) {
      if (!frozen_) position_ = motion_.at(moment);
      fill();
    }
    return sent_;
  }

 private:
  // Every word has the position with its own resolution, aligned at the top.
  void fill() {
    for (std::size_t k = 0; k < format_.channel_count; ++k) {
      const unsigned bits = format_.channel_list[k].position_bits();
      Channel& channel = sent_.channel_list[k];
      if (bits != 0) {
        channel.position = bits <= position_bits_ ? position_ >> (position_bits_ - bits)
                                                  : position_ << (bits - position_bits_);
      }
      channel.life_counter =
          life_counter_ &
          static_cast<std::uint32_t>(low_mask(format_.channel_list[k].life_counter.bits));
      channel.nE = nE_ || !format_.channel_list[k].error.present;
      channel.nW = nW_ || !format_.channel_list[k].warning.present;
    }
  }

  FrameFormat format_;
  Motion motion_;
  unsigned position_bits_;
  Frame sent_;
  std::optional<EncoderControl> control_;
  std::uint64_t position_ = 0;
  std::uint32_t life_counter_ = 0;
  bool nE_ = true;
  bool nW_ = true;
  bool frozen_ = false;
  bool sampled_ = false;
};

}  // namespace biss::sim
