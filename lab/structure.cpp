#include "lab/structure.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <vector>

#include "lab/equations.hpp"

namespace biss::lab {
namespace {

// Unknown bit k * max_data_bits + shift is a data bit of channel k.
constexpr std::size_t unknowns = max_channels * max_data_bits;
using LineBit = LinearBit<unknowns>;
using LineEquations = Equations<unknowns>;
using Bits = std::vector<LineBit>;

LineBit constant(bool level) { return LineBit().set(unknowns, level); }

std::uint64_t position_mask(const ChannelFormat& channel) {
  return channel.position.placed(~std::uint64_t{0}) | channel.multiturn.placed(~std::uint64_t{0}) |
         channel.singleturn.placed(~std::uint64_t{0});
}

// The checksum of data bits, the first bit first.
Bits checksum_of(const CrcSpec& spec, const LineBit* data, unsigned data_bits) {
  Bits reg(spec.width_bits);  // [i] is the bit of x^i
  for (unsigned i = 0; i < spec.width_bits; ++i) reg[i] = constant(((spec.start >> i) & 1U) != 0);
  for (unsigned k = 0; k < data_bits; ++k) {
    const LineBit feedback = reg.back() ^ data[k];
    for (std::size_t i = reg.size(); i-- > 1;) reg[i] = reg[i - 1];
    reg[0].reset();
    for (unsigned i = 0; i < spec.width_bits; ++i) {
      if (((spec.polynomial >> i) & 1U) != 0) reg[i] ^= feedback;
    }
  }
  std::reverse(reg.begin(), reg.end());
  for (LineBit& bit : reg) bit ^= constant(spec.inverted);
  return reg;
}

// How the encoder sends a frame.
struct Sending {
  bool cds = false;
  bool healthy_flags = true;
  // The first channels: their positions are the upper bits of the first channel's position.
  std::size_t aligned_channels = 1;
  // Bits of their positions that the first channel's position does not have: evenly distributed, or 0.
  bool extra_bits = true;
  // Before them the line is 1.
  unsigned ack_clocks = std::numeric_limits<std::uint16_t>::max();
};

// The bits on the line, and the checks of a reader that reads some other bits.
class Line {
 public:
  Line(const FrameFormat& format, const Sending& sending)
      : format_(format), sending_(sending), frame_bits_(format.payload_bits() + 3) {
    sent_.push_back(constant(true));
    sent_.push_back(constant(sending.cds));
    for (std::size_t k = 0; k < format.channel_count; ++k) send(k);
  }

  // START, CDS, payload, STOP.
  unsigned frame_bits() const { return frame_bits_; }

  LineBit sent(int place) const {
    if (place < 0) return constant(place < -static_cast<int>(sending_.ack_clocks));
    const auto at = static_cast<std::size_t>(place);
    return at < sent_.size() ? sent_[at] : constant(false);
  }

  // The frame as it is read if the 1 at this place is taken for START.
  Bits read_from(int place) const {
    Bits seen;
    for (unsigned at = 0; at < frame_bits_; ++at) {
      seen.push_back(sent(place + static_cast<int>(at)));
    }
    return seen;
  }

  void require_structure(LineEquations& equations, const Bits& seen) const {
    if (format_.cds0) equations.require(seen[1], false);
    equations.require(seen.back(), false);
  }

  void require_checksum(LineEquations& equations, const Bits& seen, std::size_t k) const {
    const ChannelFormat& channel = format_.channel_list[k];
    if (!channel.crc.present()) return;
    std::size_t at = starts_[k] + channel.data_bits;
    for (const LineBit& bit : checksum_of(channel.crc, &seen[starts_[k]], channel.data_bits)) {
      equations.require_zero(bit ^ seen[at++]);
    }
  }

  void require_word_as_sent(LineEquations& equations, const Bits& seen, std::size_t k) const {
    for (unsigned bit = 0; bit < format_.channel_list[k].total_bits(); ++bit) {
      equations.require_zero(seen[starts_[k] + bit] ^ sent_[starts_[k] + bit]);
    }
  }

  void require_no_error(LineEquations& equations, const Bits& seen) const {
    for (std::size_t k = 0; k < format_.channel_count; ++k) {
      const FlagField& error = format_.channel_list[k].error;
      if (error.present) equations.require(seen[place_of(k, error.shift)], !error.active_high);
    }
  }

  void require_as_sent(LineEquations& equations, const Bits& seen, std::size_t k,
                       std::uint64_t mask) const {
    for (unsigned shift = 0; shift < max_data_bits; ++shift) {
      if (((mask >> shift) & 1U) == 0) continue;
      const std::size_t at = place_of(k, shift);
      equations.require_zero(seen[at] ^ sent_[at]);
    }
  }

  // The place of a data bit in the frame.
  std::size_t place_of(std::size_t k, unsigned shift) const {
    return starts_[k] + format_.channel_list[k].data_bits - 1U - shift;
  }

 private:
  void send(std::size_t k) {
    const ChannelFormat& channel = format_.channel_list[k];
    const std::size_t first = sent_.size();
    starts_[k] = first;
    std::vector<ComparedBit> aligned;
    std::uint64_t random = position_mask(channel) | channel.life_counter.placed(~std::uint64_t{0});
    if (k != 0 && k < sending_.aligned_channels) {
      aligned = compared_bits(format_.channel_list[0], channel);
      if (!sending_.extra_bits) random &= ~position_mask(channel);
      for (const ComparedBit& bit : aligned) random |= std::uint64_t{1} << bit.safety_shift;
    }
    if (!sending_.healthy_flags) {
      random |= channel.error.placed(!channel.error.active_high) |
                channel.warning.placed(!channel.warning.active_high);
    }
    const std::uint64_t flags = channel.error.placed(true) | channel.warning.placed(true);
    for (unsigned shift = channel.data_bits; shift-- > 0;) {
      const bool is_random = ((random >> shift) & 1U) != 0;
      LineBit bit = constant(!is_random && ((flags >> shift) & 1U) != 0);
      if (is_random) bit[unknown(k, shift, aligned)] = true;
      sent_.push_back(bit);
    }
    if (!channel.crc.present()) return;
    for (const LineBit& bit : checksum_of(channel.crc, &sent_[first], channel.data_bits)) {
      sent_.push_back(bit);
    }
  }

  static std::size_t unknown(std::size_t k, unsigned shift,
                             const std::vector<ComparedBit>& aligned) {
    for (const ComparedBit& bit : aligned) {
      if (bit.safety_shift == shift) return bit.control_shift;
    }
    return k * max_data_bits + shift;
  }

  const FrameFormat& format_;
  Sending sending_;
  unsigned frame_bits_;
  std::array<std::size_t, max_channels> starts_{};
  Bits sent_;
};

// The frames of a StructureModel with a fault, as they are read and checked.
class DamagedFrames {
 public:
  DamagedFrames(const FrameFormat& format, const StructureModel& model, bool extra_bits = true)
      : format_(format),
        model_(model),
        line_(format, {.cds = model.cds,
                       .aligned_channels = model.pair ? 2U : 1U,
                       .extra_bits = extra_bits}) {
    if (!model.pair) return;
    compared_ = compared_bits(format.channel_list[0], format.channel_list[1], model.comparison);
  }

  unsigned frame_bits() const { return line_.frame_bits(); }

  // The shares that pass with a wrong position.
  PassedShares passed(const FaultChoice& fault, int place) const {
    const Bits seen = read(fault, place);
    PassedShares shares;
    LineEquations equations = given(fault, place);
    line_.require_structure(equations, seen);
    line_.require_checksum(equations, seen, 0);
    shares.first_word = wrong_share(equations, seen);
    for (std::size_t k = 1; k < format_.channel_count; ++k) {
      line_.require_checksum(equations, seen, k);
    }
    shares.all_words = wrong_share(equations, seen);
    line_.require_no_error(equations, seen);
    shares.trusted = wrong_share(equations, seen);
    if (!model_.pair) return shares;
    for_each_agreement(equations, seen, [&](const LineEquations& agreeing) {
      shares.pair += wrong_share(agreeing, seen);
    });
    return shares;
  }

  // \param counter_zero only frames in which the counter is 0
  AcceptedShares accepted(const FaultChoice& fault, int place, bool counter_zero) const {
    const Bits seen = read(fault, place);
    LineEquations sent = given(fault, place);
    const Field& counter = format_.channel_list[1].life_counter;
    for (unsigned bit = 0; counter_zero && bit < counter.bits; ++bit) {
      sent.require(line_.sent(static_cast<int>(line_.place_of(1, counter.shift + bit))), false);
    }
    LineEquations cpw = sent;
    LineEquations spw = sent;
    line_.require_checksum(cpw, seen, 0);
    line_.require_checksum(spw, seen, 1);
    LineEquations both = cpw;
    line_.require_checksum(both, seen, 1);
    LineEquations cpw_as_sent = sent;
    LineEquations spw_as_sent = sent;
    line_.require_word_as_sent(cpw_as_sent, seen, 0);
    line_.require_word_as_sent(spw_as_sent, seen, 1);
    LineEquations as_sent = cpw_as_sent;
    line_.require_word_as_sent(as_sent, seen, 1);
    AcceptedShares shares{cpw.share() - cpw_as_sent.share(), spw.share() - spw_as_sent.share(),
                          both.share() - as_sent.share()};
    line_.require_structure(both, seen);
    line_.require_no_error(both, seen);
    for_each_agreement(both, seen, [&](const LineEquations& agreeing) {
      shares[3] += agreeing.share();
      shares[4] += wrong_share(agreeing, seen);
    });
    // A frame that is received as it was sent has no fault.
    as_sent.require_zero(seen.back());
    if (!is_around(fault.kind)) shares[3] -= as_sent.share();
    return shares;
  }

 private:
  // The frame as it is read.
  Bits read(const FaultChoice& fault, int place) const {
    Bits seen;
    for (unsigned at = 0; at < frame_bits(); ++at) {
      seen.push_back(bit_of(fault, place, static_cast<int>(at)));
    }
    if (fault.kind == FaultKind::cds_high) seen[1] = constant(true);
    if (fault.kind == FaultKind::stop_high) seen.back() = constant(true);
    return seen;
  }

  // The condition for START to be at this place.
  LineEquations given(const FaultChoice& fault, int place) const {
    LineEquations equations;
    for (int at = 1; fault.kind == FaultKind::lost_start && at <= place; ++at) {
      equations.require(line_.sent(at), at == place);
    }
    return equations;
  }

  // Bit `at` of the frame as read.
  LineBit bit_of(const FaultChoice& fault, int place, int at) const {
    switch (fault.kind) {
      case FaultKind::lost_bit:
        return line_.sent(at < place ? at : at + 1);
      case FaultKind::doubled_bit:
        return line_.sent(at <= place ? at : at - 1);
      case FaultKind::inserted_low:
      case FaultKind::inserted_high:
        if (at == place) return constant(fault.kind == FaultKind::inserted_high);
        return line_.sent(at < place ? at : at - 1);
      case FaultKind::slo_low:
      case FaultKind::slo_high:
        return at < place ? line_.sent(at) : constant(fault.kind == FaultKind::slo_high);
      case FaultKind::gap_low:
      case FaultKind::gap_high:
        return at < place || at >= place + static_cast<int>(fault.length_bits)
                   ? line_.sent(at)
                   : constant(fault.kind == FaultKind::gap_high);
      case FaultKind::burst: {
        const int after = at - place;
        const auto last = static_cast<int>(fault.length_bits) - 1;
        if (after < 0 || after > last) return line_.sent(at);
        LineBit wrong = constant(after == 0 || after == last);
        // Unknown bits of a third channel, which no safety frame has.
        if (after != 0 && after != last)
          wrong[2 * max_data_bits + static_cast<unsigned>(after)] = true;
        return line_.sent(at) ^ wrong;
      }
      case FaultKind::lost_start:
        return line_.sent(at + place);
      case FaultKind::false_start:
        return line_.sent(at - place);
      default:
        return line_.sent(at);
    }
  }

  // The share that satisfies the equations, without the share whose first position is right.
  long double wrong_share(LineEquations equations, const Bits& seen) const {
    const long double all = equations.share();
    if (all == 0) return 0;
    line_.require_as_sent(equations, seen, 0, position_mask(format_.channel_list[0]));
    return all - equations.share();
  }

  LineBit control_bit(const Bits& seen, std::size_t i) const {
    return seen[line_.place_of(0, compared_[i].control_shift)];
  }
  LineBit safety_bit(const Bits& seen, std::size_t i) const {
    return seen[line_.place_of(1, compared_[i].safety_shift)];
  }

  // Calls visit(equations) for each case in which counter and comparison pass. The comparison is not
  // linear, but divides into linear cases that exclude each other: the values are equal, or one is
  // the other plus one and the carry ends at a certain bit.
  template <class Visit>
  void for_each_agreement(LineEquations equations, const Bits& seen, const Visit& visit) const {
    line_.require_as_sent(equations, seen, 1,
                          format_.channel_list[1].life_counter.placed(~std::uint64_t{0}));
    if (!equations.possible()) return;
    const std::size_t bits = compared_.size();
    LineEquations equal = equations;
    for (std::size_t i = 0; i < bits; ++i) {
      equal.require_zero(control_bit(seen, i) ^ safety_bit(seen, i));
    }
    visit(equal);
    if (model_.comparison.tolerance_lsb == 0) return;
    for (const bool control_higher : {false, true}) {
      // `agreeing` upper bits are equal, then the carry ends; if all are, the values wrap around.
      LineEquations above = equations;
      for (std::size_t agreeing = 0; agreeing <= bits; ++agreeing) {
        LineEquations below = above;
        const bool wraps = agreeing == bits;
        if (wraps) below = equations;
        for (std::size_t i = wraps ? 0 : agreeing; i < bits; ++i) {
          const bool control = (!wraps && i == agreeing) == control_higher;
          below.require(control_bit(seen, i), control);
          below.require(safety_bit(seen, i), !control);
        }
        visit(below);
        if (!wraps) above.require_zero(control_bit(seen, agreeing) ^ safety_bit(seen, agreeing));
      }
    }
  }

  const FrameFormat& format_;
  StructureModel model_;
  Line line_;
  std::vector<ComparedBit> compared_;
};

constexpr std::array share_members{&PassedShares::first_word, &PassedShares::all_words,
                                   &PassedShares::trusted, &PassedShares::pair};

}  // namespace

PassedShares passed_shares(const FrameFormat& format, FaultKind fault, unsigned place,
                           const StructureModel& model) {
  return DamagedFrames(format, model)
      .passed({.kind = fault, .length_bits = model.gap_bits}, static_cast<int>(place));
}

AcceptedShares accepted_shares(const FrameFormat& format, const SafetySetup& setup,
                               const FaultChoice& fault) {
  const DamagedFrames frames(format, {.pair = true, .comparison = setup.comparison}, false);
  const auto bits = static_cast<int>(format.payload_bits());
  const auto places = places_of(fault, format.payload_bits());
  // Places of a fault count from the first data bit, places of false_start from the last clock of
  // ACK.
  int first = fault.kind == FaultKind::false_start ? 1 : 2;
  int last = first + static_cast<int>(places) - 1;
  if (fault.place) first = last = first + static_cast<int>(*fault.place);
  if (fault.kind == FaultKind::lost_start) {
    const FrameBounds& bounds = setup.bounds;
    first = 1;
    last = std::min(bits + 1, bounds.ack_max_clocks - std::max<int>(1, bounds.ack_min_clocks));
  }
  const bool counts_zero = setup.counter.mode == CounterMode::count_0_63;
  AcceptedShares sum{};
  for (int place = first; place <= last; ++place) {
    const AcceptedShares all = frames.accepted(fault, place, false);
    const AcceptedShares zero =
        counts_zero ? AcceptedShares{} : frames.accepted(fault, place, true);
    for (std::size_t what = 0; what < sum.size(); ++what) sum[what] += all[what] - zero[what];
  }
  const long double averaged = fault.place ? 1 : places;
  for (long double& share : sum) share = share * 64 / (averaged * (counts_zero ? 64 : 63));
  return sum;
}

StructureRow structure_row(const FrameFormat& format, FaultKind fault,
                           const StructureModel& model) {
  const DamagedFrames frames(format, model);
  StructureRow row;
  row.fault = fault;
  // From CDS to the last CRC bit; for false_start as many clocks of ACK.
  for (unsigned place = 1; place + 1 < frames.frame_bits(); ++place) {
    const PassedShares shares =
        frames.passed({.kind = fault, .length_bits = model.gap_bits}, static_cast<int>(place));
    if (row.places++ == 0 || shares.first_word > row.worst.first_word) row.worst_place = place;
    for (const auto member : share_members) {
      row.sum.*member += shares.*member;
      row.worst.*member = std::max(row.worst.*member, shares.*member);
    }
  }
  return row;
}

std::optional<unsigned> slip_conditions(const FrameFormat& format, const Slip& slip,
                                        const SlipModel& model) {
  const Line line(format, {.cds = model.cds,
                           .healthy_flags = model.healthy_flags,
                           .aligned_channels = model.aligned_words ? max_channels : 1U,
                           .ack_clocks = slip.ack_clocks});
  const Bits seen = line.read_from(slip.place);
  LineEquations equations;
  for (int at = 1; at <= slip.place; ++at) {
    equations.require(line.sent(at), at <= int{slip.ones_clocks} || at == slip.place);
  }
  line.require_structure(equations, seen);
  const int stop = static_cast<int>(line.frame_bits()) - 1;
  for (int at = slip.place + stop + 1; model.tail_checked && at < stop; ++at) {
    equations.require(line.sent(at), false);
  }
  if (model.trusted_only) line.require_no_error(equations, seen);
  for (std::size_t k = 0; k < format.channel_count; ++k) {
    line.require_checksum(equations, seen, k);
  }
  return equations.possible() ? std::optional(equations.rank()) : std::nullopt;
}

}  // namespace biss::lab
