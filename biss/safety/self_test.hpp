// The power-up test of a safety monitor: every check is shown something that it must refuse.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <utility>

#include "biss/base/bits.hpp"
#include "biss/base/units.hpp"
#include "biss/frame/encode.hpp"
#include "biss/safety/judgement.hpp"
#include "biss/safety/setup.hpp"

namespace biss::safety_detail {

// Frames are made with the plan's own CRC engines: what is wrong with these, the second evaluation
// does not agree to.
template <class Monitor, class First, class Second>
class SelfTest {
 public:
  // \param starting a monitor that has not seen a frame; it is copied
  constexpr explicit SelfTest(const Monitor& starting)
      : starting_(starting), setup_(starting.plan().setup()), format_(starting.plan().format()) {}

  constexpr bool passes() {
    return reads_good_frame() && refuses_flips() && refuses_lines() && refuses_errors() &&
           compares() && judges_frames();
  }

 private:
  static constexpr std::uint64_t pattern = 0x5A5A'A5A5'3C3C'C3C3U;
  static constexpr std::uint8_t counter = 20;

  constexpr const ChannelFormat& cpw() const { return format_.channel_list[setup_.cpw]; }
  constexpr const ChannelFormat& spw() const { return format_.channel_list[setup_.spw]; }

  // Into bits_, which are empty where the codec refuses.
  constexpr void encode(std::uint64_t cpw_value, std::uint64_t spw_value, bool cpw_nE = true,
                        bool spw_nE = true) {
    Frame frame;
    frame.channel_count = format_.channel_count;
    frame.lead_clocks = std::max(setup_.bounds.lead_min_clocks, std::uint16_t{1});
    frame.ack_clocks = std::max(setup_.bounds.ack_min_clocks, std::uint16_t{1});
    frame.channel_list[setup_.cpw] = {cpw_value & low_mask(cpw().position_bits()), 0, cpw_nE, true};
    frame.channel_list[setup_.spw] = {spw_value & low_mask(spw().position_bits()), counter, spw_nE,
                                      true};
    payload_at_ = frame.lead_clocks + frame.ack_clocks + std::size_t{2};
    const auto encoded = encode_frame(frame, starting_.plan().codec());
    bits_ = encoded.ok() ? *encoded : FrameBits();
  }

  constexpr bool finds(SafetyVerdict cause, const BitView& bits) const {
    const SafetyFinding first = First::find(starting_.plan(), bits);
    return first.cause == cause && first == Second::find(starting_.plan(), bits);
  }
  constexpr bool finds(SafetyVerdict cause) const { return finds(cause, bits_.view()); }

  constexpr bool reads_good_frame() {
    const std::uint64_t position = pattern & low_mask(cpw().position_bits());
    encode(position, spw_position(cpw(), spw(), position));
    good_ = First::find(starting_.plan(), bits_.view());
    return finds(SafetyVerdict::safe) && good_.life_counter == counter &&
           good_.position == position;
  }

  // Every single bit that a CRC covers, and of the CRC.
  constexpr bool refuses_flips() {
    std::size_t at = payload_at_;
    for (std::uint8_t k = 0; k < format_.channel_count; ++k) {
      const SafetyVerdict cause = k == setup_.cpw   ? SafetyVerdict::cpw_crc
                                  : k == setup_.spw ? SafetyVerdict::spw_crc
                                                    : SafetyVerdict::no_frame;
      const ChannelFormat& channel = format_.channel_list[k];
      const std::size_t end = at + channel.total_bits();
      if (!channel.crc.present()) at = end;
      for (; at < end; ++at) {
        if (!finds_flipped(at, cause)) return false;
      }
    }
    return true;
  }

  constexpr bool finds_flipped(std::size_t at, SafetyVerdict cause) {
    bits_.flip(at);
    const bool found = finds(cause);
    bits_.flip(at);
    return found;
  }

  // No answer, no START, cut short, STOP = 1, CDS = 1 where it must be 0.
  constexpr bool refuses_lines() {
    const BitView line = bits_.view();
    for (const std::size_t size : {std::size_t{0}, std::size_t{1}, payload_at_ - 2U,
                                   payload_at_ - 1U, line.size_bits() - 2U}) {
      if (!finds(SafetyVerdict::no_frame, line.first(size))) return false;
    }
    if (!finds_flipped(line.size_bits() - 1U, SafetyVerdict::no_frame)) return false;
    return !format_.cds0 || finds_flipped(payload_at_ - 1U, SafetyVerdict::no_frame);
  }

  constexpr bool refuses_errors() {
    encode(0, 0, false, true);
    if (!finds(SafetyVerdict::cpw_error)) return false;
    encode(0, 0, true, false);
    return finds(SafetyVerdict::spw_error);
  }

  // Across the wrap-around, both ways.
  constexpr bool compares() {
    const unsigned shift = starting_.plan().alignment().spw_shift;
    const std::uint64_t near = setup_.comparison.tolerance_lsb;
    for (const std::uint64_t sign : {std::uint64_t{1}, ~std::uint64_t{0}}) {
      encode(0, (near * sign) << shift);
      if (!finds(SafetyVerdict::safe)) return false;
      encode(0, ((near + 1U) * sign) << shift);
      if (!finds(SafetyVerdict::comparison)) return false;
    }
    return true;
  }

  // A monitor that is safe and has just taken `counter`, at the time 0.
  constexpr bool reach_safe(Monitor& monitor) const {
    const unsigned rounds = setup_.counter.learn_rollovers + 2U + setup_.start_frames / 63U;
    const unsigned frames = (64U - lowest()) * rounds;
    for (unsigned left = frames; left != 0; --left) {
      const unsigned back = left % (64U - lowest());
      const unsigned value =
          counter >= back + lowest() ? counter - back : counter + 64U - lowest() - back;
      step(monitor, value, setup_.frame_gap_max * -std::int64_t{left});
    }
    return step(monitor, counter, {}).verdict == SafetyVerdict::safe;
  }
  constexpr SafetyJudgement step(Monitor& monitor, unsigned value, Picoseconds now) const {
    SafetyFinding finding = good_;
    finding.life_counter = static_cast<std::uint8_t>(value);
    return monitor.step(now, finding, finding);
  }
  constexpr std::uint8_t lowest() const {
    return setup_.counter.mode == CounterMode::count_0_63 ? 0 : 1;
  }

  // Every value of the counter; late and early, with a frame and without; that a fault holds; and
  // two evaluations that differ.
  constexpr bool judges_frames() const {
    Monitor monitor = starting_;
    if (!reach_safe(monitor)) return false;
    for (unsigned value = 0; value < 64; ++value) {
      const SafetyVerdict told = next_of(monitor, value, setup_.frame_gap_max);
      if (told == SafetyVerdict::disagreement) return false;
      if (is_fault(told) == (value == counter + 1U)) return false;
    }
    const Picoseconds late = setup_.frame_gap_max + picoseconds(1);
    const Picoseconds soon = setup_.frame_gap_min - picoseconds(1);
    // Without a shortest gap that is before the last good frame.
    const auto early = soon < Picoseconds{} ? SafetyVerdict::watchdog : SafetyVerdict::early;
    if (next_of(monitor, counter + 1U, soon) != early) return false;
    if (Monitor(monitor).watch(late).verdict != SafetyVerdict::watchdog) return false;
    SafetyFinding other = good_;
    other.position ^= 1U;
    if (Monitor(monitor).step({}, good_, other).verdict != SafetyVerdict::disagreement) {
      return false;
    }
    if (step(monitor, counter + 1U, late).verdict != SafetyVerdict::watchdog) return false;
    return !setup_.latch || step(monitor, counter + 2U, late).verdict == SafetyVerdict::latched;
  }
  constexpr SafetyVerdict next_of(Monitor monitor, unsigned value, Picoseconds now) const {
    return step(monitor, value, now).verdict;
  }

  using Frame = typename std::remove_cvref_t<decltype(std::declval<Monitor>().plan())>::Frame;

  const Monitor& starting_;
  const SafetySetup& setup_;
  const FrameFormat& format_;
  FrameBits bits_;
  std::size_t payload_at_ = 0;
  SafetyFinding good_;
};

}  // namespace biss::safety_detail
