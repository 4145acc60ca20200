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
constexpr unsigned least_gray_bits = 6;
constexpr unsigned least_turn_bits = 4;
constexpr unsigned least_track_bits = 8;
// Positions for which the rarer codings are tried.
constexpr std::size_t most_coded = 4;
// Bits of a position that never move below others that do are unlikely by this much at most: a scale
// explains them.
constexpr double most_scale_cost = 5;
// Frames that jump show no order of the bits: below this share of the cost, a difference between
// two codings is luck.
constexpr double least_difference = 0.15;

// ---- Choices, and what they cost in bits

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
                                              {9, 1, 'n', ' '},
                                              {12.5, 1, 'a', ' '},
                                              {8.5, 0, ' ', ' '}}};

double coding_cost(Coding coding) {
  constexpr std::array<double, 7> costs{0, 6, 10, 12, 12, 12, 20};
  return costs[static_cast<std::size_t>(coding)];
}

// The width of a position: those of the catalogue are likelier.
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

double life_cost(const ChannelLayout& layout, const Field& life, bool last) {
  const bool safety = layout.crc.width_bits == 16;
  if (!life.present()) return safety ? 1 : 0.05;
  const double width = life.bits == safety_counter_bits ? (safety ? 1.2 : 7) : 16;
  return width + (last ? 0 : 4);
}

// The bits of a position, from `low` to below `high`.
struct Place {
  unsigned low = 0;
  unsigned high = 0;

  unsigned bits() const { return high - low; }
  auto operator<=>(const Place&) const = default;
};

// A division of the bits, with the cost of all but the position.
struct Division {
  ChannelFormat channel;
  Place position;
  double cost = 0;
};

class FieldSearch {
 public:
  FieldSearch(const ChannelWords& words, const Timeline& timeline, const ChannelLayout& layout)
      : words_(words), timeline_(timeline), layout_(layout), bits_(layout.data_bits) {
    for (const std::uint64_t data : words.data) moved_ |= data ^ words.data.front();
  }

  std::vector<Fields> find() {
    divide();
    std::map<Place, double> places;
    for (const Division& each : divisions_) {
      for (const Coding coding : {Coding::binary, Coding::gray, Coding::lsb_first}) {
        add(each, coding, 0);
        const auto [at, made] = places.try_emplace(each.position, all_.back().cost);
        at->second = std::min(at->second, all_.back().cost);
      }
    }
    std::vector<std::pair<double, Place>> best;
    for (const auto& [place, cost] : places) best.emplace_back(cost, place);
    std::sort(best.begin(), best.end());
    if (best.size() > most_coded) best.resize(most_coded);
    for (const auto& [cost, place] : best) add_rare_codings(place);
    doubt_counters();
    std::stable_sort(all_.begin(), all_.end(),
                     [](const Fields& a, const Fields& b) { return a.cost < b.cost; });
    return std::move(all_);
  }

 private:
  bool is_moved(unsigned bit) const { return ((moved_ >> bit) & 1U) != 0; }

  // ---- Divisions

  void divide() {
    divide({}, true);
    const auto at = [](unsigned shift, unsigned count) {
      return Field{static_cast<std::uint8_t>(shift), static_cast<std::uint8_t>(count)};
    };
    for (unsigned count = 3; count <= 16 && count + 2 < bits_; ++count) {
      if (counts(at(0, count))) divide(at(0, count), true);
      for (const unsigned flags : {1U, 2U}) {
        if (counts(at(flags, count))) divide(at(flags, count), false);
      }
      if (counts(at(bits_ - count, count))) divide(at(bits_ - count, count), false);
    }
  }

  // Bits that count the frames may be a position at constant speed, unless they are where a safety
  // word has them.
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
    if (with == HUGE_VAL || without == HUGE_VAL || with >= without - 1) return;
    for (Fields& each : all_) {
      if (is_doubtful(each)) each.cost += without - 1 - with;
    }
  }

  bool is_safety(const Field& life) const {
    return layout_.crc.width_bits == 16 && life.bits == safety_counter_bits;
  }

  // It counts on in most frames; with the checksum of a safety word, some may be lost or come again.
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

  void divide(const Field& life, bool last) {
    const bool first = life.present() && !last && life.shift + unsigned{life.bits} == bits_;
    const unsigned base = life.present() && last ? life.bits : 0;
    const unsigned top = first ? bits_ - life.bits : bits_;
    for (const FlagKind& kind : flag_kinds) {
      // Flags below the sign of life, or directly above it.
      const bool between = life.present() && !last && !first;
      if (between && kind.bits != life.shift) continue;
      const unsigned low = between ? life.shift + unsigned{life.bits} : base + kind.bits;
      if (layout_.crc.without_flags &&
          (base != 0 || kind.bits != layout_.flags || kind.error == ' ' ||
           (kind.bits == 2 && kind.warning == ' '))) {
        continue;
      }
      add_with_zeros(life, last, kind, base, low, top);
    }
    if (layout_.crc.without_flags) return;
    if (top >= base + 3) divide_flags_first(life, last, base, top);
    // The flags are followed by zeros.
    for (unsigned zeros = 1; zeros <= most_zeros && base + zeros + 3 <= top; ++zeros) {
      if (is_moved(base + zeros - 1) || one_at(base + zeros - 1)) break;
      FlagKind kind = flag_kinds[0];
      kind.cost = 9.0 + zeros;
      add(life, last, kind, base + zeros, {base + zeros + 2, top}, base);
    }
  }

  void add_with_zeros(const Field& life, bool last, const FlagKind& kind, unsigned base,
                      unsigned low, unsigned top) {
    for (unsigned zeros = 0; zeros <= most_zeros && low + zeros < top; ++zeros) {
      if (zeros > 0 && is_moved(low + zeros - 1)) break;
      FlagKind with_zeros = kind;
      if (zeros > 0) with_zeros.cost += 4 + 0.5 * zeros;
      add(life, last, with_zeros, base, {low + zeros, top}, base);
    }
  }

  void divide_flags_first(const Field& life, bool last, unsigned base, unsigned top) {
    if (life.present() && !last) return;
    for (unsigned zeros = 0; zeros <= most_zeros && base + zeros + 3 <= top; ++zeros) {
      if (zeros > 0 && is_moved(base + zeros - 1)) break;
      for (FlagKind kind : {flag_kinds[0], flag_kinds[2]}) {
        kind.cost += 9 + (zeros > 0 ? 4 + 0.5 * zeros : 0.0);
        add(life, last, kind, top - 2, {base + zeros, top - 2}, base);
      }
    }
  }

  // \param flags_at the last bit of the flags
  // \param base bits below it are no padding
  void add(const Field& life, bool last, const FlagKind& kind, unsigned flags_at,
           const Place& position, unsigned base) {
    Division division;
    division.channel.data_bits = static_cast<std::uint8_t>(bits_);
    division.channel.life_counter = life;
    division.position = position;
    division.cost =
        kind.cost + life_cost(layout_, life, last) + position_width_cost(position.bits());
    if (kind.error != ' ') {
      const unsigned shift = flags_at + kind.bits - 1;
      division.channel.error = {static_cast<std::uint8_t>(shift), true, kind.error == 'a'};
    }
    if (kind.warning != ' ') {
      division.channel.warning = {static_cast<std::uint8_t>(flags_at), true, kind.warning == 'a'};
    }
    for (const FlagField* flag : {&division.channel.error, &division.channel.warning}) {
      if (flag->present) division.cost += flag_cost(bit_of(flag->shift, !flag->active_high));
    }
    if (life.present()) division.cost += life_cost_of(life);
    const std::uint64_t used = mask_of(life) | mask_of(division.channel.error) |
                               mask_of(division.channel.warning) |
                               low_mask(position.bits()) << position.low;
    for (unsigned bit = base; bit < bits_; ++bit) {
      if (((used >> bit) & 1U) == 0) division.cost += padding_cost(bit_of(bit, false));
    }
    divisions_.push_back(division);
  }

  bool one_at(unsigned bit) const { return ((words_.data.front() >> bit) & 1U) != 0; }

  std::vector<std::uint8_t> bit_of(unsigned bit, bool inverted) const {
    std::vector<std::uint8_t> values;
    for (const std::uint64_t data : words_.data) {
      values.push_back(static_cast<std::uint8_t>(((data >> bit) & 1U) ^ (inverted ? 1U : 0U)));
    }
    return values;
  }

  double life_cost_of(const Field& life) const {
    std::vector<CounterValue> values;
    std::uint64_t repeats = 0;
    const bool safety_word = is_safety(life) && life.shift == 0;
    for (std::size_t i = 0; i < words_.data.size(); ++i) {
      // A frame that comes again says no more about the counter than about the position.
      const bool again = safety_word && i > 0 && words_.data[i] == words_.data[i - 1];
      if (!again) values.push_back({life.of(words_.data[i]), words_.cycles[i], repeats});
      repeats = again ? repeats + 1 : 0;
    }
    return counter_cost(values, life.bits);
  }

  // ---- Positions

  void add(const Division& division, Coding coding, unsigned split) {
    Fields fields;
    fields.channel = division.channel;
    fields.coding = coding;
    fields.split = split;
    fields.cost = division.cost + position_cost(division.position, coding, split);
    const Place& place = division.position;
    const Field whole{static_cast<std::uint8_t>(place.low),
                      static_cast<std::uint8_t>(place.bits())};
    if (split == 0) {
      fields.channel.position = whole;
    } else {
      fields.channel.singleturn = {whole.shift, static_cast<std::uint8_t>(split)};
      fields.channel.multiturn = {static_cast<std::uint8_t>(whole.shift + split),
                                  static_cast<std::uint8_t>(whole.bits - split)};
    }
    fields.moved = moved_;
    fields.position_moved = moved_ & mask_of(whole);
    fields.flags_moved = moved_ & (mask_of(fields.channel.error) | mask_of(fields.channel.warning));
    all_.push_back(fields);
  }

  // Those that make the motion smoother.
  void add_rare_codings(const Place& place) {
    using enum Coding;
    const std::uint64_t seen = (moved_ >> place.low) & low_mask(place.bits());
    const auto top = static_cast<unsigned>(std::bit_width(seen));
    const double least = Timeline::rough_cost(numbers(place, binary, 0), top);
    for (unsigned split = least_turn_bits; split + 1 < top; ++split) {
      for (const Coding coding : {singleturn_gray, multiturn_gray, both_gray, two_tracks}) {
        const bool gray_below = coding == singleturn_gray || coding == both_gray;
        if (gray_below && split < least_gray_bits) continue;
        if (coding != singleturn_gray && split + least_turn_bits > top) continue;
        const bool too_short = split < least_track_bits || split + least_track_bits > top;
        if (coding == two_tracks && too_short) continue;
        std::vector<std::uint64_t> values = numbers(place, coding, split);
        double rough = Timeline::rough_cost(values, coding == two_tracks ? split : top);
        if (coding == two_tracks) {
          for (std::uint64_t& each : values) each >>= split;
          rough += Timeline::rough_cost(values, top - split);
        }
        if (rough > 0.9 * least) continue;
        // A lower track that is noise is no track, nor is one that carries.
        const double noise = 0.6 * data_weight * split * static_cast<double>(words_.data.size());
        if (coding == two_tracks &&
            (number_cost({place.low, place.low + split}, binary, 0) > noise ||
             is_carried(numbers(place, binary, 0), split, top))) {
          continue;
        }
        for (const Division& each : divisions_) {
          if (each.position == place) add(each, coding, split);
        }
      }
    }
  }

  // Where the bits below `split` go over their end, the speed of the bits above changes.
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

  double position_cost(const Place& place, Coding coding, unsigned split) {
    const double binary = number_cost(place, Coding::binary, 0);
    if (coding == Coding::binary) return binary;
    const double cost = coding == Coding::two_tracks
                            ? number_cost({place.low, place.low + split}, Coding::binary, 0) +
                                  number_cost({place.low + split, place.high}, Coding::binary, 0)
                            : number_cost(place, coding, split);
    double gain = binary - cost;
    const double share = binary <= 0 ? 0 : std::abs(gain) / binary;
    if (share < least_difference) gain *= share / least_difference;
    return binary - gain + coding_cost(coding);
  }

  double number_cost(const Place& place, Coding coding, unsigned split) {
    const auto key = std::tuple(place, coding, split);
    const auto known = number_costs_.find(key);
    if (known != number_costs_.end()) return known->second;
    std::vector<std::uint64_t> values = numbers(place, coding, split);
    std::uint64_t seen = 0;
    for (const std::uint64_t value : values) seen |= value ^ values.front();
    double cost = place.bits();
    if (seen != 0) {
      const auto low = static_cast<unsigned>(std::countr_zero(seen));
      const auto bits = static_cast<unsigned>(std::bit_width(seen)) - low;
      std::vector<std::uint64_t> moving;
      for (const std::uint64_t each : values) moving.push_back(each >> low & low_mask(bits));
      const double moved = timeline_.cost(moving, bits) - bits;
      cost += moved;
      // The lowest bits of a position that moves stand still by its scale, which is as it is.
      if (low != 0) {
        for (std::uint64_t& each : values) each &= low_mask(low + bits);
        const double scaled = timeline_.cost(values, low + bits) - low - bits;
        cost += std::clamp(scaled - moved, 0.0, most_scale_cost);
      }
    }
    number_costs_[key] = cost;
    return cost;
  }

  std::vector<std::uint64_t> numbers(const Place& place, Coding coding, unsigned split) const {
    std::vector<std::uint64_t> values;
    for (const std::uint64_t data : words_.data) {
      const std::uint64_t bits = data >> place.low & low_mask(place.bits());
      values.push_back(number(bits, place.bits(), coding, split));
    }
    return values;
  }

  static std::uint64_t number(std::uint64_t value, unsigned bits, Coding coding, unsigned split) {
    const std::uint64_t below = value & low_mask(split);
    const std::uint64_t above = value >> split;
    switch (coding) {
      case Coding::gray:
        return frame_detail::gray_to_binary(value);
      case Coding::singleturn_gray:
        return above << split | frame_detail::gray_to_binary(below);
      case Coding::multiturn_gray:
        return frame_detail::gray_to_binary(above) << split | below;
      case Coding::both_gray:
        return frame_detail::gray_to_binary(above) << split | frame_detail::gray_to_binary(below);
      case Coding::lsb_first:
        return frame_detail::bits_reversed(value, bits);
      case Coding::binary:
      case Coding::two_tracks:
        break;
    }
    return value;
  }

  const ChannelWords& words_;
  const Timeline& timeline_;
  const ChannelLayout& layout_;
  unsigned bits_;
  std::uint64_t moved_ = 0;
  std::vector<Division> divisions_;
  std::vector<Fields> all_;
  std::map<std::tuple<Place, Coding, unsigned>, double> number_costs_;
};

}  // namespace

std::vector<Fields> find_fields(const ChannelWords& words, const Timeline& timeline,
                                const ChannelLayout& layout) {
  if (words.data.empty() || layout.data_bits == 0) return {};
  return FieldSearch(words, timeline, layout).find();
}

}  // namespace biss::identify
