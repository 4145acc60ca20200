#include "lab/sequence_fault.hpp"

#include <algorithm>
#include <array>
#include <numeric>
#include <utility>

#include "lab/campaign_fault.hpp"
#include "lab/sequence_rig.hpp"

namespace biss::lab {
namespace {

constexpr unsigned most_repeats = 8;
constexpr unsigned most_exchanged = 8;
constexpr unsigned most_lost = 62;
constexpr unsigned most_periods = 4;
constexpr unsigned most_foreign = 64;

// Events of one row.
class FaultRun {
 public:
  FaultRun(SequenceRig& rig, const SequenceRow& row)
      : rig_(rig), row_(row), name_(row.variant_name()) {
    if (row.kind == TransmissionError::corruption) corruption_ = *parse_fault(name_);
  }

  // One event. \pre the monitor is safe and the next request is due now
  void commit() {
    switch (row_.kind) {
      case TransmissionError::corruption:
        return corrupt();
      case TransmissionError::repetition:
        return repeat();
      case TransmissionError::sequence:
        return exchange();
      case TransmissionError::loss:
        return lose();
      case TransmissionError::delay:
        return delay();
      case TransmissionError::insertion:
        return insert();
      case TransmissionError::masquerade:
        return masquerade();
      case TransmissionError::addressing:
        return address();
    }
  }

 private:
  std::uint64_t below(std::uint64_t limit) { return rig_.random().below(limit); }
  // first…last
  unsigned any_of(unsigned first, unsigned last) {
    return first + static_cast<unsigned>(below(last - first + 1U));
  }
  FrameBits bits_of(const SequenceWords& words) {
    return rig_.frame().encode(words, rig_.random());
  }
  FrameBits bits_of(const SequenceWords& words, const std::vector<SequenceFrame::Codec>& others) {
    return rig_.frame().encode(words, others[below(others.size())], rig_.random());
  }
  Picoseconds cycle() const { return rig_.frame().cycle(); }
  void show(const FrameBits& bits, const SequenceWords& meant) {
    rig_.fault_begins();
    rig_.show(bits, meant);
  }

  void corrupt() {
    const SequenceWords meant = rig_.own();
    FrameBits bits = bits_of(meant);
    if (corruption_.kind == CampaignFault::burst) {
      flip_burst(bits);
    } else {
      while (!flip_some(bits)) {
      }
    }
    show(bits, meant);
  }
  // False: none was to be flipped.
  bool flip_some(FrameBits& bits) {
    bool any = false;
    for (std::size_t at = rig_.frame().payload_at(bits); at + 1 < bits.size_bits(); ++at) {
      if ((rig_.random().next() >> 32U) >= corruption_.rate) continue;
      bits.flip(at);
      any = true;
    }
    return any;
  }
  void flip_burst(FrameBits& bits) {
    const std::size_t payload = rig_.frame().payload_at(bits);
    const unsigned length = corruption_.length_bits;
    const std::size_t first = payload + below(bits.size_bits() - payload - length);
    const std::uint64_t pattern = rig_.random().next();
    for (unsigned k = 0; k < length; ++k) {
      if (k == 0 || k + 1 == length || ((pattern >> k) & 1U) != 0) bits.flip(first + k);
    }
  }

  void repeat() {
    const unsigned period = row_.period();
    const unsigned age = name_ == "previous" ? 1
                         : name_ == "older"  ? any_of(2, period - 1)
                                             : any_of(1, most_periods * period);
    rig_.own();
    const FrameBits old = bits_of(rig_.past(age));
    for (unsigned left = any_of(1, most_repeats); left != 0; --left) {
      show(old, rig_.past(0));
      if (left == 1) break;
      rig_.pass(cycle());
      rig_.own();
    }
  }

  void exchange() {
    const unsigned count = any_of(2, most_exchanged);
    std::array<SequenceWords, most_exchanged> frames;
    std::array<std::uint8_t, most_exchanged> order{};
    for (unsigned n = 0; n < count; ++n) frames[n] = rig_.own();
    mix(order, count);
    bool begun = false;
    for (unsigned n = 0; n < count; ++n) {
      if (n != 0) rig_.pass(cycle());
      begun = begun || order[n] != n;
      if (begun) {
        show(bits_of(frames[order[n]]), frames[n]);
      } else {
        rig_.good(frames[n], false);
      }
    }
  }
  // Any order but the right one.
  void mix(std::array<std::uint8_t, most_exchanged>& order, unsigned count) {
    const auto end = order.begin() + count;
    std::iota(order.begin(), end, std::uint8_t{0});
    if (name_ == "overtaken") {
      std::rotate(order.begin(), order.begin() + 1, end);
    } else if (name_ == "exchanged") {
      const unsigned one = any_of(0, count - 2);
      std::swap(order[one], order[any_of(one + 1, count - 1)]);
    } else {
      while (std::is_sorted(order.begin(), end)) {
        for (unsigned n = count - 1; n != 0; --n) std::swap(order[n], order[any_of(0, n)]);
      }
    }
  }

  void lose() {
    if (name_ == "no_answer") {
      miss(any_of(1, most_lost));
    } else if (name_ == "passed_over") {
      for (unsigned left = any_of(1, row_.period() - 1); left != 0; --left) rig_.own();
    } else {
      const unsigned period = row_.period();
      const unsigned count =
          name_ == "unheard" ? any_of(1, period - 1) : period * any_of(1, most_periods);
      rig_.fault_begins();
      for (unsigned left = count; left != 0; --left) {
        rig_.own();
        rig_.pass_watched(cycle());
      }
    }
    const SequenceWords meant = rig_.own();
    show(bits_of(meant), meant);
  }
  // Requests without answer; the encoder may have counted them or not.
  void miss(unsigned count) {
    const bool counts = below(2) != 0;
    for (unsigned left = count; left != 0; --left) {
      if (counts) rig_.own();
      rig_.fault_begins();
      rig_.silence(rig_.past(0));
      rig_.pass(cycle());
    }
  }

  void delay() {
    if (name_ == "stored") {
      // From now on every frame comes so many cycles late.
      const unsigned late = any_of(1, most_lost);
      for (unsigned n = 0; n < late + 3; ++n) {
        const SequenceWords meant = rig_.own();
        rig_.fault_begins();
        if (n < late) {
          rig_.silence(meant);
        } else {
          rig_.show(bits_of(rig_.past(late)), meant);
        }
        rig_.pass(cycle());
      }
      return;
    }
    const Picoseconds least = rig_.frame().setup().frame_gap_max - cycle() + picoseconds(1);
    if (name_ == "watched") {
      rig_.fault_begins();
      rig_.pass_watched(least + longer());
    } else {
      rig_.pass(least + longer());
    }
    const SequenceWords meant = rig_.own();
    show(bits_of(meant), meant);
  }
  // Nothing at all, or up to 128 cycles, every magnitude as often.
  Picoseconds longer() {
    if (below(4) == 0) return {};
    const std::uint64_t share = rig_.random().next() >> 44U;
    return sim::part_of(cycle() * 128 / (std::int64_t{1} << below(20)), share);
  }

  void insert() {
    rig_.pass(-(cycle() / 2));  // between two requests
    const SequenceWords& last = rig_.past(0);
    const SequenceWords inserted = name_ == "stale" ? rig_.past(below(row_.period() - 1))
                                                    : rig_.encoder().foreign(rig_.random());
    show(bits_of(inserted), last);
  }

  void masquerade() {
    const SequenceWords meant = rig_.own();
    if (name_ == "start_value") return show(bits_of(meant, rig_.frame().other_starts()), meant);
    if (name_ == "polynomial") return show(bits_of(meant, rig_.frame().other_polynomials()), meant);
    FrameBits bits = bits_of(meant);
    const std::size_t payload = rig_.frame().payload_at(bits);
    const std::size_t word = payload + rig_.frame().words().cpw_bits();
    for (std::size_t at = name_ == "noise" ? payload : word; at + 1 < bits.size_bits(); ++at) {
      const bool turned =
          name_ == "standard" ? bits.view()[at] : (rig_.random().next() >> 63U) != 0;
      if (turned) bits.flip(at);
    }
    show(bits, meant);
  }

  void address() {
    const unsigned count = name_ == "for_good" ? any_of(2, most_foreign) : 1;
    SequenceWords other = rig_.encoder().foreign(rig_.random());
    for (unsigned n = 0; n < count; ++n) {
      if (n != 0) rig_.pass(cycle());
      const SequenceWords meant = rig_.own();
      show(name_ == "start_value" ? bits_of(other, rig_.frame().other_starts()) : bits_of(other),
           meant);
      // It stands still and counts.
      other.life_counter = other.life_counter == 63
                               ? static_cast<std::uint8_t>(64 - row_.period())
                               : static_cast<std::uint8_t>(other.life_counter + 1);
    }
  }

  SequenceRig& rig_;
  const SequenceRow& row_;
  std::string_view name_;
  FaultChoice corruption_{};
};

// Whether the fault needs a long past.
bool looks_back(const SequenceRow& row) {
  return row.kind == TransmissionError::repetition || row.kind == TransmissionError::insertion;
}

}  // namespace

SequenceCounts count_faults(const SequenceFrame& frame, const SequenceRow& row, std::uint64_t seed,
                            std::uint64_t block, const SequenceWatcher& watcher,
                            unsigned start_up) {
  SequenceRig rig(frame, row, seed, block, WordRule::truncated, watcher);
  rig.encoder().warn(false);
  FaultRun run(rig, row);
  const SafetyMeasure& measure = safety_measures[static_cast<std::size_t>(row.kind)];
  const unsigned again = frame.setup().start_frames - 1U;
  const bool learns = row.counter == CounterMode::learned;
  const std::uint64_t first = row.blocks().first_of(block);
  const std::uint64_t size = row.blocks().size_of(block);
  for (std::uint64_t n = 0; n < size; ++n) {
    rig.begin(first + n);
    rig.settle(!learns && rig.random().below(2) != 0);
    rig.encoder().put_elsewhere();
    // While nobody listens the encoder goes on.
    for (unsigned unheard = looks_back(row) ? 256 : 0; unheard != 0; --unheard) rig.own();
    const unsigned starting = n == 0 ? start_up : again;
    const unsigned good = starting + 1U + static_cast<unsigned>(rig.random().below(8));
    for (unsigned k = 0; k < good; ++k) {
      rig.pass(frame.cycle());
      rig.good(k < starting);
    }
    rig.pass(frame.cycle());
    run.commit();
    rig.close_event(reaction_bound(frame, row),
                    [&](SafetyVerdict told) { return measure.may_be(told); });
  }
  return rig.counts();
}

unsigned reaction_bound(const SequenceFrame& frame, const SequenceRow& row) {
  const std::string_view name = row.variant_name();
  const bool stays_away = name == "unheard" || name == "whole_period" || name == "watched";
  return stays_away ? frame.watchdog_cycles() : 0;
}

}  // namespace biss::lab
