#include "identify/fields.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <map>
#include <tuple>

#include "biss/base/bits.hpp"
#include "biss/catalogue/catalogue.hpp"

namespace biss::identify {

namespace {

constexpr unsigned most_zeros = 12;
constexpr unsigned least_turn_bits = 4;
constexpr unsigned least_split = 8;
// Positions for which the rarer codings are tried.
constexpr std::size_t most_coded = 4;
// Frames that jump show no order of the bits: below this share of the cost, a difference between
// two codings is chance.
constexpr double least_difference = 0.10;

// ---- Choices, and their cost in bits

struct FlagKind {
  double cost;
  unsigned bits;
  // n: low-active, a: high-active, blank: none.
  char error;
  char warning;
};
constexpr std::array<FlagKind, 9> flag_kinds{{{0.15, 2, 'n', 'n'},
                                              {4.5, 2, 'a', 'n'},
                                              {5.5, 2, 'a', 'a'},
                                              {8, 2, 'n', 'a'},
                                              {5.5, 2, 'n', ' '},
                                              {7, 2, ' ', ' '},
                                              {8.2, 1, 'n', ' '},
                                              {12.5, 1, 'a', ' '},
                                              {13, 0, ' ', ' '}}};

double coding_cost(Coding coding) {
  constexpr std::array<double, 7> costs{0, 6, 12, 13, 9, 12, 20};
  return costs[static_cast<std::size_t>(coding)];
}

// The cost of the width of a position: the widths in the catalogue are likelier.
double position_width_cost(unsigned bits) {
  static const std::array<double, max_data_bits + 1> costs = [] {
    std::array<double, max_data_bits + 1> counts{};
    double all = 0;
    for (const CatalogueEntry& entry : catalogue) {
      const FrameFormat format = entry.frame_format();
      for (const ChannelFormat& channel : format.channels()) {
        ++counts[channel.position_bits()];
        ++all;
      }
    }
    for (double& each : counts) {
      each = each == 0 ? 7.7 : std::clamp(-std::log2(each / all), 3.0, 6.5);
    }
    return counts;
  }();
  return costs[bits];
}

double life_cost(const ChannelLayout& layout, const Field& life) {
  const bool safety = layout.crc.width_bits == 16;
  if (!life.present()) return safety ? 1 : 0.05;
  const double width = life.bits == safety_counter_bits ? (safety ? 1.2 : 7) : 16;
  return width + (life.shift == 0 ? 0 : 4);
}

Field field_of(unsigned shift, unsigned bits) {
  return {static_cast<std::uint8_t>(shift), static_cast<std::uint8_t>(bits)};
}

// Makes these bits the position, in this coding.
void set_position(ChannelFormat& channel, const Field& place, Coding coding, unsigned split) {
  using enum Coding;
  channel.position = split == 0 ? place : Field{};
  channel.position_gray = coding == gray;
  channel.position_lsb = coding == lsb_first;
  if (split == 0) return;
  channel.singleturn = field_of(place.shift, split);
  channel.multiturn = field_of(place.shift + split, place.bits - split);
  channel.singleturn_gray = coding == singleturn_gray || coding == both_gray;
  channel.multiturn_gray = coding == multiturn_gray || coding == both_gray;
}

class FieldSearch {
 public:
  FieldSearch(const ChannelWords& words, const Timeline& timeline, const ChannelLayout& layout)
      : words_(words), timeline_(timeline), layout_(layout), bits_(layout.data_bits) {
    for (const std::uint64_t data : words.data) moved_ |= data ^ words.data.front();
    for (unsigned bit = 0; bit < bits_; ++bit) bit_costs_.push_back(costs_of_bit(bit));
  }

  std::vector<Fields> find() {
    divide();
    for (const Fields& each : divisions_) {
      for (const Coding coding : {Coding::binary, Coding::gray, Coding::lsb_first}) {
        add(each, coding, 0);
      }
    }
    sort();
    std::vector<Field> places;
    for (const Fields& each : all_) {
      const Field& place = each.channel.position;
      if (std::find(places.begin(), places.end(), place) == places.end()) places.push_back(place);
      if (places.size() == most_coded) break;
    }
    for (const Field& place : places) add_rare_codings(place);
    doubt_counters();
    sort();
    return std::move(all_);
  }

 private:
  void sort() {
    std::stable_sort(all_.begin(), all_.end(),
                     [](const Fields& a, const Fields& b) { return a.cost < b.cost; });
  }

  // ---- Divisions of the bits

  // The cost of a bit as a flag of each polarity, or as padding.
  struct BitCosts {
    double low_active = 0;
    double high_active = 0;
    double padding = 0;
    bool random = false;
  };

  BitCosts costs_of_bit(unsigned bit) const {
    std::vector<std::uint8_t> ones;
    std::vector<std::uint8_t> zeros;
    for (const std::uint64_t data : words_.data) {
      const bool one = ((data >> bit) & 1U) != 0;
      ones.push_back(one ? 1 : 0);
      zeros.push_back(one ? 0 : 1);
    }
    return {flag_cost(zeros), flag_cost(ones), padding_cost(ones), is_random(ones)};
  }

  void divide() {
    divide(Field{});
    for (unsigned count = 3; count <= 16 && count + 2 < bits_; ++count) {
      for (const unsigned shift : {0U, 1U, 2U, bits_ - count}) {
        const Field life = field_of(shift, count);
        if (counts(life)) divide(life);
      }
    }
  }

  // With this sign of life: below the flags, directly above them, or above the position.
  void divide(const Field& life) {
    const bool last = life.shift == 0;
    const bool first = !last && life.shift + unsigned{life.bits} == bits_;
    const unsigned base = last ? life.bits : 0;
    const unsigned top = first ? bits_ - life.bits : bits_;
    Fields fields;
    fields.channel.data_bits = static_cast<std::uint8_t>(bits_);
    fields.channel.life_counter = life;
    fields.cost = life_cost(layout_, life) + (life.present() ? life_cost_of(life) : 0);
    fields.moved = moved_;
    const bool without_flags = layout_.crc.without_flags;
    for (const FlagKind& kind : flag_kinds) {
      if (!last && !first && kind.bits != life.shift) continue;
      const unsigned flags = (kind.error == ' ' ? 0U : 1U) + (kind.warning == ' ' ? 0U : 1U);
      const bool left_out = flags == layout_.flags && flags == kind.bits && base == 0;
      if (without_flags && !left_out) continue;
      const unsigned low = kind.bits + (first ? 0U : life.bits);
      const unsigned still = still_bits(moved_, low);
      for (unsigned zeros = 0; zeros <= still && low + zeros < top; ++zeros) {
        divide(fields, kind, scale_cost(zeros), base, low + zeros, top);
      }
    }
    if (without_flags || !last) return;
    // Flags before the position, or followed by zeros.
    const unsigned still = still_bits(moved_, base);
    for (unsigned zeros = 0; zeros <= still && base + zeros + 3 <= top; ++zeros) {
      for (const std::size_t at : {0U, 2U, 6U}) {
        const FlagKind& kind = flag_kinds[at];
        divide(fields, kind, 12.5 + scale_cost(zeros), top - kind.bits, base + zeros,
               top - kind.bits);
      }
    }
    const unsigned zero = still_bits(moved_ | words_.data.front(), base);
    for (unsigned zeros = 1; zeros <= zero && base + zeros + 3 <= top; ++zeros) {
      divide(fields, flag_kinds[0], 9.0 + zeros, base + zeros, base + zeros + 2, top);
    }
  }

  // How many bits from `low` on are not among these.
  static unsigned still_bits(std::uint64_t bits, unsigned low) {
    return std::min(static_cast<unsigned>(std::countr_zero(bits >> low)), most_zeros);
  }

  static double scale_cost(unsigned zeros) { return zeros > 0 ? 4 + 0.5 * zeros : 0; }

  // \param flags_at the last bit of the flags
  // \param low and high the bits of the position
  void divide(Fields fields, const FlagKind& kind, double more, unsigned flags_at, unsigned low,
              unsigned high) {
    ChannelFormat& channel = fields.channel;
    channel.position = field_of(low, high - low);
    fields.position_moved = moved_ & mask_of(channel.position);
    fields.cost += kind.cost + more + position_width_cost(high - low);
    const auto flag = [&](char text, unsigned shift) -> FlagField {
      if (text == ' ') return {};
      const bool active_high = text == 'a';
      fields.cost += active_high ? bit_costs_[shift].high_active : bit_costs_[shift].low_active;
      return {static_cast<std::uint8_t>(shift), true, active_high};
    };
    channel.error = flag(kind.error, flags_at + kind.bits - 1);
    channel.warning = flag(kind.warning, flags_at);
    const std::uint64_t used =
        mask_of(channel.life_counter) | channel.flags_mask() | mask_of(channel.position);
    for (unsigned bit = 0; bit < bits_; ++bit) {
      if (((used >> bit) & 1U) == 0) fields.cost += bit_costs_[bit].padding;
    }
    divisions_.push_back(fields);
  }

  // Bits that count the frames may be a position at constant speed, unless they are at the place of
  // the counter in a safety word.
  void doubt_counters() {
    double with = HUGE_VAL;
    double without = HUGE_VAL;
    const auto is_doubtful = [this](const Fields& each) {
      const Field& life = each.channel.life_counter;
      const bool usual = life.bits == safety_counter_bits && life.shift == 0;
      return life.present() && !usual && !is_safety(life);
    };
    for (const Fields& each : all_) {
      double& least = is_doubtful(each) ? with : without;
      if (is_doubtful(each) || !each.channel.life_counter.present()) {
        least = std::min(least, each.cost);
      }
    }
    const double more = without - 1 - with;
    for (Fields& each : all_) {
      if (more > 0 && more < HUGE_VAL && is_doubtful(each)) each.cost += more;
    }
  }

  bool is_safety(const Field& life) const {
    return layout_.crc.width_bits == 16 && life.bits == safety_counter_bits;
  }

  // It increases by 1 in most frames; with the checksum of a safety word, some may be lost or
  // repeated.
  bool counts(const Field& life) const {
    double seen = 0;
    double follow = 0;
    for (std::size_t i = 1; i < words_.data.size(); ++i) {
      if (words_.cycles[i] != words_.cycles[i - 1] + 1) continue;
      const std::uint64_t next = life.of(words_.data[i]);
      const std::uint64_t expected = (life.of(words_.data[i - 1]) + 1) & low_mask(life.bits);
      ++seen;
      follow += next == expected || (expected == 0 && next == 1) ? 1 : 0;
    }
    return follow > 3 && follow > (is_safety(life) ? 0.3 : 0.7) * seen;
  }

  double life_cost_of(const Field& life) const {
    std::vector<CounterValue> values;
    std::uint64_t repeats = 0;
    const bool safety_word = is_safety(life) && life.shift == 0;
    for (std::size_t i = 0; i < words_.data.size(); ++i) {
      // A repeated frame is not new evidence of the counter or of the position.
      const bool again = safety_word && i > 0 && words_.data[i] == words_.data[i - 1];
      if (!again) values.push_back({life.of(words_.data[i]), words_.cycles[i], repeats});
      repeats = again ? repeats + 1 : 0;
    }
    return counter_cost(values, life.bits);
  }

  // ---- Positions

  void add(Fields fields, Coding coding, unsigned split) {
    const Field place = fields.channel.position;
    fields.cost += position_cost(place, coding, split) + doubt_of_bits(fields, coding, split);
    fields.coding = coding;
    fields.split = split;
    set_position(fields.channel, place, coding, split);
    all_.push_back(fields);
  }

  // The additional cost of flags and padding that are as random as the lowest bit of a position.
  // Next to the position they are equally likely to be that bit, unless it makes the position far
  // more expensive: every coder is a little worse with one bit more.
  double doubt_of_bits(const Fields& fields, Coding coding, unsigned split) {
    constexpr double least_doubt = 3;
    const ChannelFormat& channel = fields.channel;
    const Field& place = channel.position;
    const std::uint64_t used = mask_of(channel.life_counter) | mask_of(place);
    const auto is_doubtful = [&](unsigned bit) {
      return ((used >> bit) & 1U) == 0 && bit_costs_[bit].random;
    };
    const auto cost_of = [&](unsigned bit) {
      for (const FlagField& flag : {channel.error, channel.warning}) {
        if (!flag.present || flag.shift != bit) continue;
        return flag.active_high ? bit_costs_[bit].high_active : bit_costs_[bit].low_active;
      }
      return bit_costs_[bit].padding;
    };
    double doubt = 0;
    for (unsigned bit = 0; bit < bits_; ++bit) doubt += is_doubtful(bit) ? least_doubt : 0;
    unsigned bits = 0;
    double below = 0;
    while (bits < place.shift && is_doubtful(place.shift - bits - 1)) {
      below += cost_of(place.shift - ++bits);
    }
    if (bits == 0) return doubt;
    const double one_less = channel.error.present && channel.warning.present ? 9 : 5.8;
    const Field with = field_of(place.shift - bits, place.bits + bits);
    const double gain = position_cost(with, coding, split == 0 ? 0 : split + bits) +
                        position_width_cost(with.bits) - position_cost(place, coding, split) -
                        position_width_cost(place.bits) - below;
    return std::min(doubt + std::clamp(gain, 0.0, least_difference * below),
                    gain + bits * one_less);
  }

  // Those that make the motion smoother.
  void add_rare_codings(const Field& place) {
    using enum Coding;
    const auto top = static_cast<unsigned>(std::bit_width(place.of(moved_)));
    const double least = Timeline::rough_cost(numbers(place, binary, 0), top);
    for (unsigned split = least_split; split < top; ++split) {
      for (const Coding coding : {singleturn_gray, multiturn_gray, both_gray, two_tracks}) {
        // If few turns were seen, they are assumed to be in Gray code if the singleturn is.
        const unsigned above = top - split;
        if (coding == multiturn_gray && above < least_turn_bits) continue;
        if (coding == two_tracks && above < least_split) continue;
        std::vector<std::uint64_t> values = numbers(place, coding, split);
        double rough = Timeline::rough_cost(values, coding == two_tracks ? split : top);
        if (coding == two_tracks) {
          for (std::uint64_t& each : values) each >>= split;
          rough += Timeline::rough_cost(values, top - split);
        }
        if (rough > 0.9 * least) continue;
        // A lower track of noise is not a track. Neither is a lower track with a carry to the upper
        // one.
        const double noise = 0.6 * data_weight * split * static_cast<double>(words_.data.size());
        if (coding == two_tracks && (number_cost(field_of(place.shift, split), binary, 0) > noise ||
                                     is_carried(numbers(place, binary, 0), split, top))) {
          continue;
        }
        for (const Fields& each : divisions_) {
          if (each.channel.position == place) add(each, coding, split);
        }
      }
    }
  }

  // Whether the speed of the bits above changes when the bits below `split` wrap around.
  static bool is_carried(const std::vector<std::uint64_t>& values, unsigned split, unsigned top) {
    std::array<double, 2> seen{};
    std::array<double, 2> changed{};
    for (std::size_t i = 2; i < values.size(); ++i) {
      const std::uint64_t below = values[i] & low_mask(split);
      const std::uint64_t before = values[i - 1] & low_mask(split);
      const bool rises = ((below - before) & low_mask(split)) >> (split - 1) == 0;
      const std::size_t over = (rises ? below < before : below > before) ? 1 : 0;
      const std::uint64_t change =
          (values[i] >> split) - 2 * (values[i - 1] >> split) + (values[i - 2] >> split);
      ++seen[over];
      changed[over] += (change & low_mask(top - split)) != 0 ? 1 : 0;
    }
    return seen[1] < 3 || changed[1] / seen[1] > 0.3 + changed[0] / std::max(1.0, seen[0]);
  }

  double position_cost(const Field& place, Coding coding, unsigned split) {
    const double binary = number_cost(place, Coding::binary, 0);
    if (coding == Coding::binary) return binary;
    const double cost =
        coding == Coding::two_tracks
            ? number_cost(field_of(place.shift, split), Coding::binary, 0) +
                  number_cost(field_of(place.shift + split, place.bits - split), Coding::binary, 0)
            : number_cost(place, coding, split);
    double gain = binary - cost;
    const double share = binary <= 0 ? 0 : std::abs(gain) / binary;
    if (share < least_difference) gain *= share / least_difference;
    return binary - gain + coding_cost(coding);
  }

  double number_cost(const Field& place, Coding coding, unsigned split) {
    const auto key = std::tuple(place.shift, place.bits, coding, split);
    const auto known = number_costs_.find(key);
    if (known != number_costs_.end()) return known->second;
    std::vector<std::uint64_t> values = numbers(place, coding, split);
    std::uint64_t seen = 0;
    for (const std::uint64_t value : values) seen |= value ^ values.front();
    double cost = place.bits;
    if (seen != 0) {
      const auto low = static_cast<unsigned>(std::countr_zero(seen));
      const auto bits = static_cast<unsigned>(std::bit_width(seen)) - low;
      std::vector<std::uint64_t> moving;
      for (const std::uint64_t each : values) moving.push_back(each >> low & low_mask(bits));
      const double moved = timeline_.cost(moving, bits) - bits;
      cost += moved;
      // The lowest bits of a position that moves may be constant because of its scale.
      if (low != 0) {
        for (std::uint64_t& each : values) each &= low_mask(low + bits);
        const double scaled = timeline_.cost(values, low + bits) - low - bits;
        cost += std::clamp(scaled - moved, 0.0, scale_cost(low));
      }
    }
    number_costs_[key] = cost;
    return cost;
  }

  std::vector<std::uint64_t> numbers(const Field& place, Coding coding, unsigned split) const {
    ChannelFormat channel;
    set_position(channel, place, coding, split);
    std::vector<std::uint64_t> values;
    for (const std::uint64_t data : words_.data) {
      values.push_back(frame_detail::position_of(channel, data));
    }
    return values;
  }

  const ChannelWords& words_;
  const Timeline& timeline_;
  const ChannelLayout& layout_;
  unsigned bits_;
  std::uint64_t moved_ = 0;
  std::vector<BitCosts> bit_costs_;
  // With a binary position.
  std::vector<Fields> divisions_;
  std::vector<Fields> all_;
  std::map<std::tuple<std::uint8_t, std::uint8_t, Coding, unsigned>, double> number_costs_;
};

}  // namespace

std::vector<Fields> find_fields(const ChannelWords& words, const Timeline& timeline,
                                const ChannelLayout& layout) {
  if (words.data.empty() || layout.data_bits == 0) return {};
  return FieldSearch(words, timeline, layout).find();
}

}  // namespace biss::identify
