#include "lab/structure.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "lab/frame_line.hpp"

namespace biss::lab {
namespace {

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
    const LinearBits seen = read(fault, place);
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
    const LinearBits seen = read(fault, place);
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
  LinearBits read(const FaultChoice& fault, int place) const {
    LinearBits seen;
    for (unsigned at = 0; at < frame_bits(); ++at) {
      seen.push_back(bit_of(fault, place, static_cast<int>(at)));
    }
    if (fault.kind == FaultKind::cds_high) seen[1] = level_bit(true);
    if (fault.kind == FaultKind::stop_high) seen.back() = level_bit(true);
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
        if (at == place) return level_bit(fault.kind == FaultKind::inserted_high);
        return line_.sent(at < place ? at : at - 1);
      case FaultKind::slo_low:
      case FaultKind::slo_high:
        return at < place ? line_.sent(at) : level_bit(fault.kind == FaultKind::slo_high);
      case FaultKind::gap_low:
      case FaultKind::gap_high:
        return at < place || at >= place + static_cast<int>(fault.length_bits)
                   ? line_.sent(at)
                   : level_bit(fault.kind == FaultKind::gap_high);
      case FaultKind::burst: {
        const int after = at - place;
        const auto last = static_cast<int>(fault.length_bits) - 1;
        if (after < 0 || after > last) return line_.sent(at);
        LineBit wrong = level_bit(after == 0 || after == last);
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
  long double wrong_share(LineEquations equations, const LinearBits& seen) const {
    const long double all = equations.share();
    if (all == 0) return 0;
    line_.require_as_sent(equations, seen, 0, position_mask(format_.channel_list[0]));
    return all - equations.share();
  }

  LineBit control_bit(const LinearBits& seen, std::size_t i) const {
    return seen[line_.place_of(0, compared_[i].control_shift)];
  }
  LineBit safety_bit(const LinearBits& seen, std::size_t i) const {
    return seen[line_.place_of(1, compared_[i].safety_shift)];
  }

  // Calls visit(equations) for each case in which counter and comparison pass. The comparison is not
  // linear, but divides into linear cases that exclude each other: the values are equal, or one is
  // the other plus one and the carry ends at a certain bit.
  template <class Visit>
  void for_each_agreement(LineEquations equations, const LinearBits& seen,
                          const Visit& visit) const {
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
  FrameLine line_;
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

}  // namespace biss::lab
