#include "lab/structure.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

#include "biss/crc/engines.hpp"
#include "lab/comparison.hpp"
#include "lab/equations.hpp"

namespace biss::lab {
namespace {

using Bits = std::vector<LinearBit>;

std::uint64_t position_mask(const ChannelFormat& channel) {
  return channel.position.placed(~std::uint64_t{0}) | channel.multiturn.placed(~std::uint64_t{0}) |
         channel.singleturn.placed(~std::uint64_t{0});
}

// The checksum of data given as bits, first one first.
Bits checksum_of(const CrcSpec& spec, const LinearBit* data, unsigned data_bits) {
  Bits reg(spec.width_bits);  // [i] is the bit of x^i
  for (unsigned i = 0; i < spec.width_bits; ++i) {
    reg[i] = constant_bit(((spec.start >> i) & 1U) != 0);
  }
  for (unsigned k = 0; k < data_bits; ++k) {
    const LinearBit feedback = reg.back() ^ data[k];
    for (std::size_t i = reg.size(); i-- > 1;) reg[i] = reg[i - 1];
    reg[0].reset();
    for (unsigned i = 0; i < spec.width_bits; ++i) {
      if (((spec.polynomial >> i) & 1U) != 0) reg[i] ^= feedback;
    }
  }
  std::reverse(reg.begin(), reg.end());
  for (LinearBit& bit : reg) bit ^= constant_bit(spec.inverted);
  return reg;
}

// What the encoder sends, and the same seen through a fault.
class Line {
 public:
  Line(const FrameFormat& format, const StructureModel& model)
      : format_(format), model_(model), frame_bits_(format.payload_bits() + 3) {
    if (model.pair) {
      compared_ = compared_bits(format.channel_list[0], format.channel_list[1],
                                model.checks.compare_bits, model.checks.compare_turns);
      aligned_ = compared_bits(format.channel_list[0], format.channel_list[1], 0, true);
    }
    sent_.push_back(constant_bit(true));
    sent_.push_back(constant_bit(model.cds));
    for (std::size_t k = 0; k < format.channel_count; ++k) send(k);
  }

  // START, CDS, payload, STOP.
  unsigned frame_bits() const { return frame_bits_; }

  LinearBit sent(int place) const {
    const bool inside = place >= 0 && place < static_cast<int>(sent_.size());
    return inside ? sent_[static_cast<std::size_t>(place)] : constant_bit(false);
  }

  // Bit `at` of the frame as read.
  LinearBit read(StructuralFault fault, int place, int at) const {
    switch (fault) {
      case StructuralFault::lost_bit:
        return sent(at < place ? at : at + 1);
      case StructuralFault::doubled_bit:
        return sent(at <= place ? at : at - 1);
      case StructuralFault::inserted_low:
      case StructuralFault::inserted_high:
        if (at == place) return constant_bit(fault == StructuralFault::inserted_high);
        return sent(at < place ? at : at - 1);
      case StructuralFault::stuck_low:
      case StructuralFault::stuck_high:
        return at < place ? sent(at) : constant_bit(fault == StructuralFault::stuck_high);
      case StructuralFault::gap_low:
      case StructuralFault::gap_high:
        return at < place || at >= place + static_cast<int>(model_.gap_bits)
                   ? sent(at)
                   : constant_bit(fault == StructuralFault::gap_high);
      case StructuralFault::late_start:
        return sent(at + place);
      case StructuralFault::early_start:
        return sent(at - place);
    }
    return {};
  }

  PassedShares passed(StructuralFault fault, int place) const {
    Bits seen;
    for (unsigned at = 0; at < frame_bits_; ++at) {
      seen.push_back(read(fault, place, static_cast<int>(at)));
    }
    PassedShares shares;
    Equations equations;
    if (fault == StructuralFault::late_start) {
      for (int at = 1; at <= place; ++at) equations.require(sent(at), at == place);
    }
    if (format_.cds0) equations.require(seen[1], false);
    equations.require(seen.back(), false);
    require_checksum(equations, seen, 0);
    shares.first_word = wrong_share(equations, seen);
    for (std::size_t k = 1; k < format_.channel_count; ++k) require_checksum(equations, seen, k);
    shares.all_words = wrong_share(equations, seen);
    for (std::size_t k = 0; k < format_.channel_count; ++k) require_no_error(equations, seen, k);
    shares.trusted = wrong_share(equations, seen);
    if (model_.pair) shares.pair = compared_share(equations, seen);
    return shares;
  }

 private:
  void send(std::size_t k) {
    const ChannelFormat& channel = format_.channel_list[k];
    const std::size_t first = sent_.size();
    starts_[k] = first;
    const std::uint64_t random =
        position_mask(channel) | channel.life_counter.placed(~std::uint64_t{0});
    const std::uint64_t flags = channel.error.placed(true) | channel.warning.placed(true);
    for (unsigned shift = channel.data_bits; shift-- > 0;) {
      LinearBit bit = constant_bit(((flags >> shift) & 1U) != 0);
      if (((random >> shift) & 1U) != 0) bit[unknown(k, shift)] = true;
      sent_.push_back(bit);
    }
    if (!channel.crc.present()) return;
    for (const LinearBit& bit : checksum_of(channel.crc, &sent_[first], channel.data_bits)) {
      sent_.push_back(bit);
    }
  }

  std::size_t unknown(std::size_t k, unsigned shift) const {
    if (k == 1) {
      for (const ComparedBit& bit : aligned_) {
        if (bit.safety_shift == shift) return bit.control_shift;
      }
    }
    return k * max_data_bits + shift;
  }

  std::size_t place_of(std::size_t k, unsigned shift) const {
    return starts_[k] + format_.channel_list[k].data_bits - 1U - shift;
  }

  void require_checksum(Equations& equations, const Bits& seen, std::size_t k) const {
    const ChannelFormat& channel = format_.channel_list[k];
    if (!channel.crc.present()) return;
    std::size_t at = starts_[k] + channel.data_bits;
    for (const LinearBit& bit : checksum_of(channel.crc, &seen[starts_[k]], channel.data_bits)) {
      equations.require_zero(bit ^ seen[at++]);
    }
  }

  void require_no_error(Equations& equations, const Bits& seen, std::size_t k) const {
    const FlagField& error = format_.channel_list[k].error;
    if (error.present) equations.require(seen[place_of(k, error.shift)], !error.active_high);
  }

  void require_as_sent(Equations& equations, const Bits& seen, std::size_t k,
                       std::uint64_t mask) const {
    for (unsigned shift = 0; shift < max_data_bits; ++shift) {
      if (((mask >> shift) & 1U) == 0) continue;
      const std::size_t at = place_of(k, shift);
      equations.require_zero(seen[at] ^ sent_[at]);
    }
  }

  // Those that satisfy the equations, without those for which the first position is right.
  long double wrong_share(Equations equations, const Bits& seen) const {
    const long double all = equations.share();
    if (all == 0) return 0;
    require_as_sent(equations, seen, 0, position_mask(format_.channel_list[0]));
    return all - equations.share();
  }

  LinearBit control_bit(const Bits& seen, std::size_t i) const {
    return seen[place_of(0, compared_[i].control_shift)];
  }
  LinearBit safety_bit(const Bits& seen, std::size_t i) const {
    return seen[place_of(1, compared_[i].safety_shift)];
  }

  // The comparison is not linear, but splits into cases that are: the values are equal, or one is
  // the other plus one, where the carry ends at a certain bit. The cases exclude each other.
  long double compared_share(Equations equations, const Bits& seen) const {
    if (model_.checks.counter) {
      require_as_sent(equations, seen, 1,
                      format_.channel_list[1].life_counter.placed(~std::uint64_t{0}));
    }
    if (!equations.possible()) return 0;
    const std::size_t bits = compared_.size();
    Equations equal = equations;
    for (std::size_t i = 0; i < bits; ++i) {
      equal.require_zero(control_bit(seen, i) ^ safety_bit(seen, i));
    }
    long double sum = wrong_share(equal, seen);
    if (model_.checks.tolerance_lsb == 0) return sum;
    for (const bool control_higher : {false, true}) {
      // `agreeing` bits from the top are equal, then the carry ends; none: the values wrap around.
      Equations above = equations;
      for (std::size_t agreeing = 0; agreeing <= bits; ++agreeing) {
        Equations below = above;
        const bool wraps = agreeing == bits;
        if (wraps) below = equations;
        for (std::size_t i = wraps ? 0 : agreeing; i < bits; ++i) {
          const bool control = (!wraps && i == agreeing) == control_higher;
          below.require(control_bit(seen, i), control);
          below.require(safety_bit(seen, i), !control);
        }
        sum += wrong_share(below, seen);
        if (!wraps) above.require_zero(control_bit(seen, agreeing) ^ safety_bit(seen, agreeing));
      }
    }
    return sum;
  }

  const FrameFormat& format_;
  const StructureModel& model_;
  unsigned frame_bits_;
  std::array<std::size_t, max_channels> starts_{};
  std::vector<ComparedBit> compared_;
  std::vector<ComparedBit> aligned_;
  Bits sent_;
};

void raise(PassedShares& worst, const PassedShares& shares) {
  worst.first_word = std::max(worst.first_word, shares.first_word);
  worst.all_words = std::max(worst.all_words, shares.all_words);
  worst.trusted = std::max(worst.trusted, shares.trusted);
  worst.pair = std::max(worst.pair, shares.pair);
}

void add(PassedShares& sum, const PassedShares& shares) {
  sum.first_word += shares.first_word;
  sum.all_words += shares.all_words;
  sum.trusted += shares.trusted;
  sum.pair += shares.pair;
}

}  // namespace

std::string_view name_of(StructuralFault fault) {
  constexpr std::array<std::string_view, 10> names{
      "lost_bit",   "doubled_bit", "inserted_low", "inserted_high", "stuck_low",
      "stuck_high", "gap_low",     "gap_high",     "late_start",    "early_start"};
  return names[static_cast<std::size_t>(fault)];
}

PassedShares passed_shares(const FrameFormat& format, StructuralFault fault, unsigned place,
                           const StructureModel& model) {
  return Line(format, model).passed(fault, static_cast<int>(place));
}

StructureRow structure_row(const FrameFormat& format, StructuralFault fault,
                           const StructureModel& model) {
  const Line line(format, model);
  StructureRow row;
  row.fault = fault;
  // From CDS to the last CRC bit; of ACK so many clocks that a frame's worth of zeros is seen.
  for (unsigned place = 1; place + 1 < line.frame_bits(); ++place) {
    const PassedShares shares = line.passed(fault, static_cast<int>(place));
    if (row.places++ == 0 || shares.first_word > row.worst.first_word) row.worst_place = place;
    add(row.sum, shares);
    raise(row.worst, shares);
  }
  return row;
}

}  // namespace biss::lab
