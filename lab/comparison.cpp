#include "lab/comparison.hpp"

#include <algorithm>

namespace biss::lab {
namespace {

// v evenly distributed; how v + a and v + b differ from v in their bits, from the last bit on. The
// carries are all that is to be remembered.
class Sums {
 public:
  Sums(int a, int b, unsigned bits, long double share) : a_(a), b_(b), states_{{{}, share}} {
    for (unsigned i = 0; i < bits; ++i) step(i);
  }

  void add_to(std::map<MaskPair, long double>& shares) const {
    for (const auto& [state, share] : states_) shares[state.masks] += share;
  }

 private:
  struct State {
    MaskPair masks;
    bool carry_a = false;
    bool carry_b = false;

    auto operator<=>(const State&) const = default;
  };

  // Two's complement: bit i of a negative number, far up, is 1.
  static bool bit_of(int number, unsigned i) {
    return ((static_cast<std::int64_t>(number) >> std::min(i, 62U)) & 1) != 0;
  }

  static bool add(bool v, bool term, bool& carry, unsigned i, std::uint64_t& mask) {
    const int sum = int{v} + int{term} + int{carry};
    carry = sum > 1;
    const bool changed = (sum % 2 != 0) != v;
    mask |= std::uint64_t{changed} << i;
    return changed;
  }

  void step(unsigned i) {
    std::map<State, long double> next;
    for (const auto& [state, share] : states_) {
      for (const bool v : {false, true}) {
        State after = state;
        add(v, bit_of(a_, i), after.carry_a, i, after.masks.control);
        add(v, bit_of(b_, i), after.carry_b, i, after.masks.safety);
        next[after] += share / 2;
      }
    }
    states_ = std::move(next);
  }

  int a_;
  int b_;
  std::map<State, long double> states_;
};

}  // namespace

std::vector<ComparedBit> compared_bits(const ChannelFormat& control, const ChannelFormat& safety,
                                       unsigned singleturn_bits, bool turns) {
  const auto fine = [](const ChannelFormat& channel) {
    return channel.position.present() ? channel.position : channel.singleturn;
  };
  if (control.singleturn_gray || safety.singleturn_gray) return {};
  std::vector<ComparedBit> bits;
  const Field a = fine(control);
  const Field b = fine(safety);
  const unsigned both = std::min(a.bits, b.bits);
  const unsigned compared = singleturn_bits == 0 ? both : std::min(singleturn_bits, both);
  const unsigned turn_bits = turns ? std::min(control.multiturn.bits, safety.multiturn.bits) : 0U;
  const auto add = [&bits](unsigned control_shift, unsigned safety_shift) {
    bits.push_back(
        {static_cast<std::uint8_t>(control_shift), static_cast<std::uint8_t>(safety_shift)});
  };
  for (unsigned i = turn_bits; i-- > 0;) {
    add(control.multiturn.shift + i, safety.multiturn.shift + i);
  }
  for (unsigned i = 1; i <= compared; ++i) {
    add(unsigned{a.shift} + a.bits - i, unsigned{b.shift} + b.bits - i);
  }
  return bits;
}

std::map<std::uint64_t, long double> passing_masks(unsigned bits, unsigned tolerance) {
  std::map<MaskPair, long double> pairs;
  const int most = static_cast<int>(tolerance);
  for (int difference = -most; difference <= most; ++difference) {
    Sums(difference, 0, bits, 1).add_to(pairs);
  }
  std::map<std::uint64_t, long double> masks;
  for (const auto& [pair, share] : pairs) masks[pair.control] += share;
  return masks;
}

std::map<MaskPair, long double> harmless_masks(unsigned bits, unsigned tolerance) {
  std::map<MaskPair, long double> pairs;
  const int most = static_cast<int>(tolerance);
  for (int error = -most; error <= most; ++error) {
    for (int difference = -most; difference <= most; ++difference) {
      Sums(error, error + difference, bits, 1).add_to(pairs);
    }
  }
  return pairs;
}

}  // namespace biss::lab
