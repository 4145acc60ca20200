// The theory of faults other than flips. Each bit as read is an XOR of bits of the position, of
// random bits and of a constant, so the frames that pass a check are the solutions of linear
// equations.
#include <algorithm>
#include <array>
#include <bit>
#include <vector>

#include "lab/campaign_theory.hpp"
#include "lab/equations.hpp"
#include "lab/pair.hpp"

namespace biss::lab {
namespace {

// A bit of the line as an XOR of position bits, random bits and a constant.
constexpr std::size_t unknowns = 127;
using Sum = LinearBit<unknowns>;
using LineEquations = Equations<unknowns>;

Sum constant(bool level) { return constant_bit<unknowns>(level); }

Sum unknown(std::size_t number) {
  Sum sum;
  sum[number] = true;
  return sum;
}

// The bits of the line, the last one (STOP) first.
using LineSums = std::vector<Sum>;

// As sent with this counter; variable k is bit k of the position.
LineSums sent_sums(const CampaignFrame& frame, std::uint8_t counter) {
  LineSums sums(frame.bits() + 1U);
  const auto add = [&](std::uint64_t position, Sum variable, const WordPair& base) {
    const WordPair words = frame.encode({position, counter});
    const LineWord line =
        ((LineWord{words.cpw ^ base.cpw} << frame.spw_bits()) | (words.spw ^ base.spw)) << 1U;
    for (std::size_t bit = 0; bit < sums.size(); ++bit) {
      if (((line >> bit) & 1U) != 0) sums[bit] ^= variable;
    }
  };
  add(0, constant(true), {});
  const WordPair zero = frame.encode({0, counter});
  for (unsigned bit = 0; bit < frame.cpw_format().position_bits(); ++bit) {
    add(std::uint64_t{1} << bit, unknown(bit), zero);
  }
  return sums;
}

// damaged() for symbolic bits: the fault moves bits whatever their values.
LineSums damaged_sums(const CampaignFrame& frame, const LineSums& sent, const FaultChoice& fault,
                      unsigned place) {
  const auto size = static_cast<unsigned>(sent.size());
  const unsigned first = size - 1U - place;  // the place as an index
  const Sum level = constant(is_high(fault.kind));
  LineSums sums = sent;
  switch (fault.kind) {
    case FaultKind::stop_high:
      sums[0] = constant(true);
      break;
    case FaultKind::doubled_bit:
    case FaultKind::inserted_low:
    case FaultKind::inserted_high:
      for (unsigned bit = 0; bit < first; ++bit) sums[bit] = sent[bit + 1U];
      if (fault.kind != FaultKind::doubled_bit) sums[first] = level;
      break;
    case FaultKind::gap_low:
    case FaultKind::gap_high:
      for (unsigned n = 0; n < fault.length_bits && n <= first; ++n) {
        sums[first - n] = level;
      }
      break;
    case FaultKind::burst:
      for (unsigned n = 0; n < fault.length_bits; ++n) {
        const bool end = n == 0 || n + 1U == fault.length_bits;
        sums[first - n] ^= end ? constant(true) : unknown(frame.cpw_format().position_bits() + n);
      }
      break;
    case FaultKind::lost_bit:
      for (unsigned bit = 0; bit <= first; ++bit) sums[bit] = bit == 0 ? Sum() : sent[bit - 1U];
      break;
    case FaultKind::slo_low:
    case FaultKind::slo_high:
      for (unsigned bit = 0; bit <= first; ++bit) sums[bit] = level;
      break;
    default:
      break;
  }
  return sums;
}

// The line as the reader sees it.
struct ReadLine {
  LineSums bits;
  Sum cds{};
  // Sums that are 0 in this case.
  std::vector<Sum> given{};
  // The frame is never as it was sent.
  bool always_damaged = false;
};

// The frame as read if the bit `clocks` after START is taken for START; negative: before it.
ReadLine shifted(const LineSums& sent, int clocks) {
  const auto stop = static_cast<int>(sent.size()) + 1;  // clocks from START
  const auto at = [&](int clock) -> Sum {
    if (clock == 0) return constant(true);
    return clock < 2 || clock > stop ? Sum() : sent[static_cast<std::size_t>(stop - clock)];
  };
  ReadLine read{.bits = {}, .cds = at(clocks + 1), .always_damaged = true};
  for (int bit = 0; bit < static_cast<int>(sent.size()); ++bit) {
    read.bits.push_back(at(clocks + stop - bit));
  }
  for (int before = 1; before <= clocks; ++before) {
    read.given.push_back(before == clocks ? at(before) ^ constant(true) : at(before));
  }
  return read;
}

// All cases of a fault; they exclude each other.
std::vector<ReadLine> read_lines(const CampaignFrame& frame, const LineSums& sent,
                                 const FaultChoice& fault, unsigned place) {
  if (fault.kind == FaultKind::false_start) return {shifted(sent, -static_cast<int>(place) - 1)};
  if (fault.kind != FaultKind::lost_start) {
    ReadLine read{.bits = damaged_sums(frame, sent, fault, place)};
    read.always_damaged = is_around(fault.kind);
    if (fault.kind == FaultKind::cds_high) read.cds = constant(true);
    return {read};
  }
  std::vector<ReadLine> lines;
  const FrameBounds& bounds = frame.plan().setup().bounds;
  const int ack = std::max<int>(1, bounds.ack_min_clocks);
  for (int clocks = 1; clocks <= static_cast<int>(sent.size()) + 1; ++clocks) {
    if (ack + clocks <= bounds.ack_max_clocks) lines.push_back(shifted(sent, clocks));
  }
  return lines;
}

// One place and one counter: the line as sent and as read. Bits of a word count from its last bit.
class PlacedFault {
 public:
  PlacedFault(const CampaignFrame& frame, const LineSums& sent, const ReadLine& read)
      : frame_(frame), sent_(sent), read_(read) {
    for (const Sum& sum : read.given) given_.require_zero(sum);
  }

  CampaignTheory shares() const {
    const LineEquations cpw = both_good(true, false);
    const LineEquations spw = both_good(false, true);
    LineEquations whole = same(given_, cpw_at(), frame_.cpw_bits());
    const long double cpw_same = whole.share();
    const long double spw_same = same(given_, spw_at(), frame_.spw_bits()).share();
    whole = same(whole, spw_at(), frame_.spw_bits());
    LineEquations whole_stop = whole;
    whole_stop.require_zero(read_.bits[0]);
    const long double untouched = read_.always_damaged ? 0 : whole_stop.share();
    const long double safe = safe_share(false);
    return {cpw.share() - cpw_same, spw.share() - spw_same,
            both_good(true, true).share() - whole.share(), safe - untouched,
            safe - safe_share(true)};
  }

 private:
  unsigned spw_at() const { return 1; }
  unsigned cpw_at() const { return 1U + frame_.spw_bits(); }

  LineEquations both_good(bool cpw, bool spw) const {
    LineEquations equations = given_;
    if (cpw) require_crc(equations, cpw_at(), frame_.cpw_columns());
    if (spw) require_crc(equations, spw_at(), frame_.spw_columns());
    return equations;
  }

  // The sent word is good, so the difference must have the checksum 0.
  void require_crc(LineEquations& equations, unsigned at,
                   const std::vector<std::uint32_t>& columns) const {
    std::array<Sum, max_crc_bits> sums{};
    for (std::size_t bit = 0; bit < columns.size(); ++bit) {
      for (std::uint32_t left = columns[bit]; left != 0; left &= left - 1U) {
        sums[static_cast<std::size_t>(std::countr_zero(left))] ^=
            sent_[at + bit] ^ read_.bits[at + bit];
      }
    }
    for (const Sum& sum : sums) equations.require_zero(sum);
  }

  LineEquations same(LineEquations equations, unsigned at, unsigned bits) const {
    for (unsigned bit = at; bit < at + bits; ++bit)
      equations.require_zero(sent_[bit] ^ read_.bits[bit]);
    return equations;
  }

  // The monitor says `safe`; with the sent position if position_kept.
  long double safe_share(bool position_kept) const {
    const ChannelFormat& cpw = frame_.cpw_format();
    const ChannelFormat& spw = frame_.spw_format();
    LineEquations base = both_good(true, true);
    base.require_zero(read_.bits[0]);
    if (frame_.format().cds0) base.require_zero(read_.cds);
    const unsigned cpw_error = cpw_at() + cpw.crc.width_bits + cpw.error.shift;
    const unsigned spw_error = spw_at() + spw.crc.width_bits + spw.error.shift;
    base = same(base, cpw_error, 1);
    base = same(base, spw_error, 1);
    base =
        same(base, spw_at() + spw.crc.width_bits + spw.life_counter.shift, spw.life_counter.bits);
    const std::uint64_t position =
        pack(cpw, {.position = low_mask(cpw.position_bits())}) ^ pack(cpw, {});
    for (unsigned bit = 0; position_kept && bit < cpw.data_bits; ++bit) {
      if (((position >> bit) & 1U) != 0) base = same(base, cpw_at() + cpw.crc.width_bits + bit, 1);
    }
    if (!base.possible()) return 0;
    const PairChecks checks = pair_checks_of(frame_.plan().setup());
    LineSums a;
    LineSums b;
    for (const ComparedBit& bit :
         compared_bits(cpw, spw, checks.compare_bits, checks.compare_turns)) {
      a.insert(a.begin(), read_.bits[cpw_at() + cpw.crc.width_bits + bit.control_shift]);
      b.insert(b.begin(), read_.bits[spw_at() + spw.crc.width_bits + bit.safety_shift]);
    }
    long double share = 0;
    const auto most = checks.tolerance_lsb == 0 ? 0U : static_cast<unsigned>(a.size());
    for (unsigned differing = 0; differing <= most; ++differing) {
      share += compared_share(base, a, b, differing);
    }
    return share;
  }

  // The lowest `differing` bits differ, the others are equal, and the values are neighbours.
  static long double compared_share(LineEquations equations, const LineSums& a, const LineSums& b,
                                    unsigned differing) {
    const auto bits = static_cast<unsigned>(a.size());
    for (unsigned bit = 0; bit < bits; ++bit) equations.require(a[bit] ^ b[bit], bit < differing);
    if (differing <= 1 || !equations.possible()) return equations.share();
    const auto pattern = [&](bool top, bool rest) {
      LineEquations one_pattern = equations;
      for (unsigned bit = 0; bit < differing; ++bit) {
        one_pattern.require(a[bit], bit + 1U == differing ? top : rest);
      }
      return one_pattern.share();
    };
    long double share = pattern(false, true) + pattern(true, false);
    if (differing == bits) share += pattern(false, false) + pattern(true, true);
    return share;
  }

  const CampaignFrame& frame_;
  const LineSums& sent_;
  const ReadLine& read_;
  LineEquations given_;
};

}  // namespace

CampaignTheory placed_theory(const CampaignFrame& frame, const FaultChoice& fault) {
  CampaignTheory sum{};
  const unsigned places = fault.place ? 1 : places_of(fault, frame.bits());
  // A burst changes a checksum in the same way for all frames.
  const unsigned last = fault.kind == FaultKind::burst ? frame.first_counter() : 63U;
  for (unsigned counter = frame.first_counter(); counter <= last; ++counter) {
    const LineSums sent = sent_sums(frame, static_cast<std::uint8_t>(counter));
    for (unsigned n = 0; n < places; ++n) {
      for (const ReadLine& read : read_lines(frame, sent, fault, fault.place.value_or(n))) {
        const CampaignTheory shares = PlacedFault(frame, sent, read).shares();
        for (std::size_t what = 0; what < sum.size(); ++what) sum[what] += shares[what];
      }
    }
  }
  const unsigned counters = last - frame.first_counter() + 1U;
  for (long double& share : sum) share /= static_cast<long double>(places) * counters;
  return sum;
}

}  // namespace biss::lab
