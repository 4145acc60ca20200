// Faults that move bits, hold the line or shift START: each bit as read is a sum of bits of the
// position, of random bits and of a constant, so what passes a check is the solutions of linear
// equations.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <vector>

#include "lab/campaign_damage.hpp"
#include "lab/campaign_theory.hpp"
#include "lab/comparison.hpp"
#include "lab/pair_checks.hpp"

namespace biss::lab {
namespace {

// A sum of variables; the highest bit is the constant.
using Sum = LineWord;
constexpr Sum one = Sum{1} << 127U;

unsigned lowest_bit(Sum sum) {
  const auto low = static_cast<std::uint64_t>(sum);
  if (low != 0) return static_cast<unsigned>(std::countr_zero(low));
  return 64U + static_cast<unsigned>(std::countr_zero(static_cast<std::uint64_t>(sum >> 64U)));
}

// Sums that have to be 0. The share of all values of the variables for which they are.
class Equations {
 public:
  void require_zero(Sum sum) {
    for (const Row& row : rows_) {
      if (((sum >> row.pivot) & 1U) != 0) sum ^= row.sum;
    }
    if ((sum & ~one) != 0) {
      rows_.push_back({lowest_bit(sum), sum});
    } else if (sum == one) {
      impossible_ = true;
    }
  }
  void require(Sum sum, bool value) { require_zero(value ? sum ^ one : sum); }
  bool impossible() const { return impossible_; }
  long double share() const {
    return impossible_ ? 0 : std::ldexp(1.0L, -static_cast<int>(rows_.size()));
  }

 private:
  struct Row {
    unsigned pivot;
    Sum sum;
  };
  std::vector<Row> rows_;
  bool impossible_ = false;
};

// A bit of the line each, the last one (STOP) first.
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
  add(0, one, {});
  const WordPair zero = frame.encode({0, counter});
  for (unsigned bit = 0; bit < frame.cpw_format().position_bits(); ++bit) {
    add(std::uint64_t{1} << bit, Sum{1} << bit, zero);
  }
  return sums;
}

// damaged() of each variable by itself: the fault moves bits, it does not look at them.
LineSums damaged_sums(const CampaignFrame& frame, const LineSums& sent, const FaultChoice& fault,
                      unsigned place) {
  const auto size = static_cast<unsigned>(sent.size());
  const unsigned first = size - 1U - place;  // the place as an index
  const Sum level = is_high(fault.kind) ? one : 0;
  LineSums sums = sent;
  switch (fault.kind) {
    case CampaignFault::flips:
    case CampaignFault::late_start:
    case CampaignFault::early_start:
    case CampaignFault::cds_high:
      break;
    case CampaignFault::stop_high:
      sums[0] = one;
      break;
    case CampaignFault::double_clock:
    case CampaignFault::inserted_low:
    case CampaignFault::inserted_high:
      for (unsigned bit = 0; bit < first; ++bit) sums[bit] = sent[bit + 1U];
      if (fault.kind != CampaignFault::double_clock) sums[first] = level;
      break;
    case CampaignFault::gap_low:
    case CampaignFault::gap_high:
      for (unsigned n = 0; n < fault.length_bits && n <= first; ++n) {
        sums[first - n] = level;
      }
      break;
    case CampaignFault::burst:
      for (unsigned n = 0; n < fault.length_bits; ++n) {
        const bool end = n == 0 || n + 1U == fault.length_bits;
        sums[first - n] ^= end ? one : Sum{1} << (frame.cpw_format().position_bits() + n);
      }
      break;
    case CampaignFault::lost_clock:
      for (unsigned bit = 0; bit <= first; ++bit) sums[bit] = bit == 0 ? 0 : sent[bit - 1U];
      break;
    case CampaignFault::slo_low:
    case CampaignFault::slo_high:
      for (unsigned bit = 0; bit <= first; ++bit) sums[bit] = level;
      break;
  }
  return sums;
}

// What the reader sees.
struct ReadLine {
  LineSums bits;
  Sum cds = 0;
  // Sums that are 0 where it comes to this.
  std::vector<Sum> given{};
  // Never what was sent.
  bool always_damaged = false;
};

// Read from `clocks` behind START on, as if that were START; before it where negative.
ReadLine shifted(const LineSums& sent, int clocks) {
  const auto stop = static_cast<int>(sent.size()) + 1;  // clocks from START
  const auto at = [&](int clock) -> Sum {
    if (clock == 0) return one;
    return clock < 2 || clock > stop ? 0 : sent[static_cast<std::size_t>(stop - clock)];
  };
  ReadLine read{.bits = {}, .cds = at(clocks + 1), .always_damaged = true};
  for (int bit = 0; bit < static_cast<int>(sent.size()); ++bit) {
    read.bits.push_back(at(clocks + stop - bit));
  }
  for (int before = 1; before <= clocks; ++before) {
    read.given.push_back(before == clocks ? at(before) ^ one : at(before));
  }
  return read;
}

// All that a fault can come to, which exclude each other.
std::vector<ReadLine> read_lines(const CampaignFrame& frame, const LineSums& sent,
                                 const FaultChoice& fault, unsigned place) {
  if (fault.kind == CampaignFault::early_start)
    return {shifted(sent, -static_cast<int>(place) - 1)};
  if (fault.kind != CampaignFault::late_start) {
    ReadLine read{.bits = damaged_sums(frame, sent, fault, place)};
    read.always_damaged = is_around(fault.kind);
    if (fault.kind == CampaignFault::cds_high) read.cds = one;
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

// One place, one counter: the line as sent and as read, from the last bit of a word on.
class PlacedFault {
 public:
  PlacedFault(const CampaignFrame& frame, const LineSums& sent, const ReadLine& read)
      : frame_(frame), sent_(sent), read_(read) {
    for (const Sum sum : read.given) given_.require_zero(sum);
  }

  CampaignTheory shares() const {
    const Equations cpw = both_good(true, false);
    const Equations spw = both_good(false, true);
    Equations whole = same(given_, cpw_at(), frame_.cpw_bits());
    const long double cpw_same = whole.share();
    const long double spw_same = same(given_, spw_at(), frame_.spw_bits()).share();
    whole = same(whole, spw_at(), frame_.spw_bits());
    Equations whole_stop = whole;
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

  Equations both_good(bool cpw, bool spw) const {
    Equations equations = given_;
    if (cpw) require_crc(equations, cpw_at(), frame_.cpw_columns());
    if (spw) require_crc(equations, spw_at(), frame_.spw_columns());
    return equations;
  }

  // What was sent is good, so the difference must have the checksum 0.
  void require_crc(Equations& equations, unsigned at,
                   const std::vector<std::uint32_t>& columns) const {
    std::array<Sum, max_crc_bits> sums{};
    for (std::size_t bit = 0; bit < columns.size(); ++bit) {
      for (std::uint32_t left = columns[bit]; left != 0; left &= left - 1U) {
        sums[static_cast<std::size_t>(std::countr_zero(left))] ^=
            sent_[at + bit] ^ read_.bits[at + bit];
      }
    }
    for (const Sum sum : sums) equations.require_zero(sum);
  }

  Equations same(Equations equations, unsigned at, unsigned bits) const {
    for (unsigned bit = at; bit < at + bits; ++bit)
      equations.require_zero(sent_[bit] ^ read_.bits[bit]);
    return equations;
  }

  // The monitor says safe; with the position that was sent, where that is asked for.
  long double safe_share(bool position_kept) const {
    const ChannelFormat& cpw = frame_.cpw_format();
    const ChannelFormat& spw = frame_.spw_format();
    Equations base = both_good(true, true);
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
    if (base.impossible()) return 0;
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

  // The lowest `differing` bits are unlike, the others equal, and the values are neighbours.
  static long double compared_share(Equations equations, const LineSums& a, const LineSums& b,
                                    unsigned differing) {
    const auto bits = static_cast<unsigned>(a.size());
    for (unsigned bit = 0; bit < bits; ++bit) equations.require(a[bit] ^ b[bit], bit < differing);
    if (differing <= 1 || equations.impossible()) return equations.share();
    const auto pattern = [&](bool top, bool rest) {
      Equations one_pattern = equations;
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
  Equations given_;
};

}  // namespace

CampaignTheory placed_theory(const CampaignFrame& frame, const FaultChoice& fault) {
  CampaignTheory sum{};
  const unsigned places = fault.place ? 1 : places_of(fault, frame.bits());
  // What a burst does to a checksum is the same whatever was sent.
  const unsigned last = fault.kind == CampaignFault::burst ? frame.first_counter() : 63U;
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
