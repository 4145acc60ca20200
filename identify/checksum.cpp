#include "identify/checksum.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <map>
#include <random>
#include <utility>

#include "identify/coding.hpp"

namespace biss::identify {

namespace {

// Of all frames, the share in which a checksum must be right to be tried, and the share in which the
// bits after a frame must be as after its end.
constexpr double least_share = 0.35;
constexpr double least_end_share = 0.8;
// Differences of two frames; a generator must divide this share of them.
constexpr std::size_t differences = 48;
constexpr double least_agreeing = 0.45;
// Channels that are followed after the same bit, and chains up to the same bit.
constexpr std::size_t most_followed = 40;
constexpr std::size_t most_open = 10;
constexpr double most_worse = 80;
// A frame with a wrong checksum, roughly.
constexpr double misfit_cost = 8;
constexpr unsigned longest_channel = max_data_bits + max_crc_bits;

// ---- What a choice costs, in bits

double width_cost(unsigned width) {
  constexpr std::array<double, 9> costs{7, 7, 7, 7, 7, 4.5, 0.5, 8, 6};
  return width == 16 ? 2.5 : width < costs.size() ? costs[width] : 7;
}

// x^k + 1 divides the difference of any two words that hold the same value twice.
bool repeats(std::uint32_t generator) { return (generator & (generator - 1U)) == 1U; }

bool is_usual(std::uint32_t generator) {
  return default_polynomial(static_cast<unsigned>(degree(generator))) == generator;
}

// Generators that other protocols use.
constexpr std::array<std::uint32_t, 12> other_generators{
    0x107, 0x11D, 0x131, 0x19B, 0x197, 0x59, 0x61, 0x35, 0x19, 0x11021, 0x18005, 0x13D65};

double generator_cost(std::uint32_t generator) {
  const auto width = static_cast<unsigned>(degree(generator));
  const bool other = std::find(other_generators.begin(), other_generators.end(), generator) !=
                     other_generators.end();
  const double cost = is_usual(generator) ? 0.3 : other ? 5 : 3.0 + width;
  return width_cost(width) + cost + (repeats(generator) ? 20.0 : 0.0);
}

// The start value and the inversion are one number: see spec_of().
double constant_cost(const CrcSpec& spec) {
  if (spec.start != 0) return spec.width_bits + 3.0;
  return spec.inverted ? 0.2 : 4.0;
}

double channel_cost(const ChannelLayout& channel) {
  if (!channel.crc.present()) return 20;
  return generator_cost(channel.crc.polynomial) + constant_cost(channel.crc) +
         (channel.crc.deviates() ? 12 : 0);
}

// Of one channel more.
double further_channel_cost(std::size_t channels) {
  constexpr std::array<double, 4> costs{0.3, 2.7, 4, 3};
  return costs[std::min(channels, costs.size() - 1)];
}

// How much likelier any other checksum is than this one, which fits by chance.
double unknown_share(const ChannelLayout& channel, bool still_begin) {
  const double own = channel_cost(channel);
  double share = 0;
  for (unsigned width = min_crc_bits; width <= max_crc_bits; ++width) {
    share += std::exp2(own - width_cost(width) - 4.0 - (channel.crc.start != 0 ? 3.0 : 0.2) -
                       data_weight * width * (channel.rank + 1.0));
  }
  // A channel that stands still in front of this one looks the same as a start value.
  if (channel.crc.start != 0 && still_begin) share += std::exp2(channel.crc.width_bits - 6.0);
  return share;
}

// ---- Checksums

// The start value that gives this checksum of 0 for data of this length; see CrcBitwise.
std::uint16_t start_for(std::uint32_t generator, unsigned width, unsigned data_bits,
                        std::uint32_t checksum) {
  // The register is shifted once a bit; backwards each step can be undone.
  std::uint32_t reg = checksum;
  for (unsigned i = 0; i < data_bits; ++i) {
    const bool fed_back = (reg & 1U) != 0;
    if (fed_back) reg ^= generator;
    reg >>= 1U;
    if (fed_back) reg |= 1U << (width - 1U);
  }
  return static_cast<std::uint16_t>(reg);
}

// How many bits differ, among the first `length`.
unsigned distance(const Sample& a, const Sample& b, unsigned length) {
  unsigned bits = 0;
  for (unsigned at = 0; at < length; at += 64) {
    const unsigned now = std::min(length - at, 64U);
    bits += static_cast<unsigned>(
        std::popcount(a.bits.view().word(at, now) ^ b.bits.view().word(at, now)));
  }
  return bits;
}

// S(e) of many words: a row for each number of bits.
class SumTable {
 public:
  SumTable(std::span<const Sample* const> samples, unsigned length)
      : words_(samples.size()), length_(length), bits_(words_ * length) {
    for (std::size_t w = 0; w < words_; ++w) {
      const BitView bits = samples[w]->bits.view();
      for (unsigned i = 0; i < length; ++i) bits_[i * words_ + w] = bits[i] ? 0xFFFFU : 0U;
    }
  }

  // The differences of neighbours take the place of the words.
  void pair_up() {
    for (unsigned i = 0; i < length_; ++i) {
      for (std::size_t w = 0; w < words_ / 2; ++w) {
        bits_[i * words_ / 2 + w] = bits_[i * words_ + 2 * w] ^ bits_[i * words_ + 2 * w + 1];
      }
    }
    words_ /= 2;
  }

  void sum(std::uint32_t generator) {
    sums_.assign((length_ + 1) * words_, 0);
    powers_.clear();
    std::uint32_t power = 1;
    for (unsigned i = 0; i < length_; ++i) {
      const std::uint16_t* const bits = bits_.data() + i * words_;
      const std::uint16_t* const from = sums_.data() + i * words_;
      std::uint16_t* const to = sums_.data() + (i + 1) * words_;
      const auto mask = static_cast<std::uint16_t>(power);
      powers_.push_back(power);
      for (std::size_t w = 0; w < words_; ++w) {
        to[w] = static_cast<std::uint16_t>(from[w] ^ (bits[w] & mask));
      }
      if ((power & 1U) != 0) power ^= generator;
      power >>= 1U;
    }
  }

  std::size_t words() const { return words_; }
  const std::uint16_t* row(unsigned bits) const { return sums_.data() + bits * words_; }
  bool bit(unsigned at, std::size_t word) const { return bits_[at * words_ + word] != 0; }
  // x^-power, with the generator of sum().
  std::uint32_t inverse(unsigned power) const { return powers_[power]; }

 private:
  std::size_t words_;
  unsigned length_;
  std::vector<std::uint16_t> bits_;
  std::vector<std::uint16_t> sums_;
  std::vector<std::uint32_t> powers_;
};

// x^power mod the generator.
std::uint32_t power_of_x(unsigned power, std::uint32_t generator) {
  const auto top = std::bit_floor(generator);
  std::uint32_t value = 1;
  for (unsigned i = 0; i < power; ++i) {
    value <<= 1U;
    if ((value & top) != 0) value ^= generator;
  }
  return value;
}

std::uint32_t product_mod(std::uint32_t a, std::uint32_t b, std::uint32_t generator) {
  return static_cast<std::uint32_t>(remainder(product(a, b), generator));
}

class LayoutSearch {
 public:
  explicit LayoutSearch(const FrameSet& frames)
      : frames_(frames),
        length_(frames.length),
        patterns_(frames.patterns),
        all_(static_cast<double>(frames.samples.size())) {
    draw_differences();
  }

  std::vector<Layout> find(std::size_t most) {
    candidates_.assign(length_ + 1, {});
    find_narrow();
    find_wide();
    std::vector<Layout> done;
    // Where no checksum ends with the frame, it may end at any bit that can be STOP.
    constexpr double least_evidence = 12;
    for (const bool loose : {false, true}) {
      const std::vector<bool> ends = is_end(loose ? 0.75 : least_end_share, loose);
      done = chains(ends, most);
      add_variants(ends, done);
      const bool won = std::any_of(done.begin(), done.end(),
                                   [](const Layout& each) { return each.score > least_evidence; });
      if (won) break;
    }
    done.push_back(unchecked());
    for (Layout& layout : done) complete(layout);
    return done;
  }

 private:
  struct Candidate {
    unsigned begin = 0;
    unsigned end = 0;
    CrcSpec crc;
    // By how many bits it is better than chance; the same, less the frames that do not fit.
    double evidence = 0;
    double rating = 0;

    ChannelLayout channel() const { return {begin, end - begin - crc.width_bits, crc}; }
  };
  // Half of the frames by their number, half by their patterns: where most frames are alike, few of
  // the frames differ, and where many are damaged, few of the patterns are right.
  std::size_t draw_pattern(std::size_t draw) {
    return draw % 2 == 0 ? random_() % patterns_.size()
                         : frames_.pattern[random_() % frames_.pattern.size()];
  }

  void draw_differences() {
    std::vector<const Sample*> drawn;
    for (std::size_t i = 0; patterns_.size() > 1 && i < differences; ++i) {
      const std::size_t one = draw_pattern(i);
      std::size_t other = draw_pattern(i);
      for (unsigned k = 0; k < 8 && one == other; ++k) other = draw_pattern(i);
      if (one == other) other = (one + 1) % patterns_.size();
      drawn.push_back(patterns_[one].sample);
      drawn.push_back(patterns_[other].sample);
    }
    pairs_ = SumTable(drawn, length_);
    pairs_.pair_up();
    const std::size_t words = pairs_.words();
    ones_.assign((length_ + 1) * words, 0);
    for (std::size_t i = 0; i < length_ * words; ++i) {
      ones_[i + words] = static_cast<std::uint16_t>(
          ones_[i] + (pairs_.bit(static_cast<unsigned>(i / words), i % words) ? 1U : 0U));
    }
  }

  // A frame can end before a bit that is 0 (STOP) and is followed by zeros, and then ones after the
  // timeout; or with the last clock.
  std::vector<bool> is_end(double share, bool loose) const {
    std::vector<double> fits(length_ + 1, 0);
    fits[length_] = all_;
    for (const FrameSet::Pattern& pattern : patterns_) {
      const BitView bits = pattern.sample->bits.view();
      unsigned after = length_;
      while (!loose && after > 0 && bits[after - 1]) --after;
      unsigned first = after;
      while (!loose && first > 0 && !bits[first - 1]) --first;
      for (unsigned end = loose ? 0 : first; end < after; ++end) {
        fits[end] += bits[end] ? 0 : pattern.frames;
      }
    }
    std::vector<bool> ends(length_ + 1);
    for (unsigned end = 0; end <= length_; ++end) ends[end] = fits[end] >= share * all_;
    return ends;
  }

  // ---- The channels that may be anywhere

  void add(Candidate candidate, unsigned rank, double frames) {
    candidate.evidence =
        candidate.crc.width_bits * (1 + data_weight * rank) - channel_cost(candidate.channel());
    candidate.rating = candidate.evidence - data_weight * misfit_cost * (all_ - frames);
    candidates_[candidate.begin].push_back(candidate);
  }

  void find_narrow() {
    std::vector<const Sample*> words;
    for (const FrameSet::Pattern& pattern : patterns_) words.push_back(pattern.sample);
    table_ = SumTable(words, length_);
    for (std::uint32_t generator = 9; generator < 512; generator += 2) try_everywhere(generator);
    for (const std::uint32_t generator : other_generators) {
      if (generator > 512) try_everywhere(generator);
    }
    try_everywhere(default_polynomial(16));
    for (auto& list : candidates_) keep_best(list, most_followed);
  }

  void try_everywhere(std::uint32_t generator) {
    const auto width = static_cast<unsigned>(degree(generator));
    pairs_.sum(generator);
    table_.sum(generator);
    for (unsigned begin = 0; begin + width < length_; ++begin) {
      const unsigned last = std::min(length_, begin + max_data_bits + width);
      for (unsigned end = begin + width + 1; end <= last; ++end) {
        if (pairs_agree(begin, end)) {
          vote(begin, end, generator);
        } else if (is_usual(generator)) {
          try_usual(begin, end, generator);
        }
      }
    }
  }

  // Enough differences in these bits are multiples of the generator.
  bool pairs_agree(unsigned begin, unsigned end) const {
    const std::size_t words = pairs_.words();
    const std::uint16_t* const from = pairs_.row(begin);
    const std::uint16_t* const to = pairs_.row(end);
    const std::uint16_t* const ones_from = ones_.data() + begin * words;
    const std::uint16_t* const ones_to = ones_.data() + end * words;
    unsigned agree = 0;
    unsigned differ = 0;
    for (std::size_t w = 0; w < words; ++w) {
      const bool moved = ones_from[w] != ones_to[w];
      differ += moved ? 1U : 0U;
      agree += moved && from[w] == to[w] ? 1U : 0U;
    }
    return agree > 0 && agree >= least_agreeing * differ;
  }

  unsigned rank_of_pairs(unsigned begin, unsigned end, unsigned width) const {
    Basis basis;
    for (std::size_t w = 0; w < pairs_.words(); ++w) {
      if (pairs_.row(begin)[w] != pairs_.row(end)[w]) continue;
      Polynomial data = 0;
      for (unsigned i = begin; i < end - width; ++i) data = data << 1U | (pairs_.bit(i, w) ? 1 : 0);
      basis.add(data);
    }
    return basis.rank();
  }

  // The remainder that most frames have.
  void vote(unsigned begin, unsigned end, std::uint32_t generator) {
    const auto width = static_cast<unsigned>(degree(generator));
    const std::uint16_t* const from = table_.row(begin);
    const std::uint16_t* const to = table_.row(end);
    const unsigned rank = rank_of_pairs(begin, end, width);
    if (!is_usual(generator) && width * (1 + data_weight * rank) < generator_cost(generator))
      return;
    votes_.assign(std::size_t{1} << width, 0);
    std::size_t best = 0;
    for (std::size_t i = 0; i < patterns_.size(); ++i) {
      const auto value = static_cast<std::size_t>(from[i] ^ to[i]);
      votes_[value] += static_cast<float>(patterns_[i].frames);
      if (votes_[value] > votes_[best]) best = value;
    }
    if (votes_[best] < least_share * all_) return;
    const auto rest =
        product_mod(static_cast<std::uint32_t>(best), power_of_x(end - 1, generator), generator);
    const Candidate candidate{begin, end, spec_of(generator, end - begin - width, rest)};
    add(candidate, rank, votes_[best]);
  }

  // With the usual remainder, which needs no motion.
  void try_usual(unsigned begin, unsigned end, std::uint32_t generator) {
    const auto width = static_cast<unsigned>(degree(generator));
    const CrcSpec usual{generator, 0, static_cast<std::uint8_t>(width), true};
    const std::uint16_t* const from = table_.row(begin);
    const std::uint16_t* const to = table_.row(end);
    const auto value =
        static_cast<std::uint16_t>(product_mod(usual.mask(), table_.inverse(end - 1), generator));
    double wrong = 0;
    for (std::size_t i = 0; i < patterns_.size(); ++i) {
      if ((from[i] ^ to[i]) != value) wrong += patterns_[i].frames;
      if (wrong > (1 - least_share) * all_) return;
    }
    add({begin, end, usual}, rank_of_pairs(begin, end, width), all_ - wrong);
  }

  // Any generator of up to 16 bits, from what differences have in common: only for ends of the
  // frame, and of channels before another one.
  void find_wide() {
    constexpr double strong = 15;
    constexpr std::size_t most_begins = 8;
    std::vector<unsigned> begins{0};
    std::vector<bool> ends = is_end(least_end_share, false);
    for (unsigned begin = 0; begin < length_; ++begin) {
      const bool from_here = std::find(begins.begin(), begins.end(), begin) != begins.end();
      for (const Candidate& each : candidates_[begin]) {
        if (each.evidence < strong) continue;
        ends[begin] = true;
        const bool known = std::find(begins.begin(), begins.end(), each.end) != begins.end();
        if (from_here && !known && begins.size() < most_begins) begins.push_back(each.end);
      }
    }
    if (patterns_.size() < 3) return;
    for (const unsigned begin : begins) {
      for (unsigned end = begin + 10; end <= std::min(length_, begin + longest_channel); ++end) {
        if (ends[end]) draw_generators(begin, end);
      }
      keep_best(candidates_[begin], most_followed);
    }
  }

  // The common divisor of a few differences is the generator, times what has not moved.
  void draw_generators(unsigned begin, unsigned end) {
    constexpr std::size_t draws = 16;
    constexpr std::size_t frames_a_draw = 10;
    std::vector<std::uint32_t> tried;
    for (std::size_t draw = 0; draw < draws; ++draw) {
      Polynomial common = 0;
      Polynomial first = 0;
      std::size_t different = 0;
      for (std::size_t k = 0; k < frames_a_draw; ++k) {
        const Polynomial word = polynomial_of(*patterns_[draw_pattern(draw)].sample, {begin, end});
        if (k == 0) first = word;
        const Polynomial divisor = without_x(common_divisor(common, first ^ word));
        different += divisor != common ? 1U : 0U;
        common = divisor;
        if (common != 0 && degree(common) < 9) break;
      }
      // Any divisor of a single difference would do.
      if (different < 2 || degree(common) < 9 || degree(common) > 16) continue;
      const auto generator = static_cast<std::uint32_t>(common);
      const auto width = static_cast<unsigned>(degree(common));
      // The usual ones have been tried.
      const bool known = std::find(tried.begin(), tried.end(), generator) != tried.end() ||
                         generator_cost(generator) < 3.0 + width;
      if (known || end - begin <= width || end - begin - width > max_data_bits) continue;
      tried.push_back(generator);
      pairs_.sum(generator);
      table_.sum(generator);
      vote(begin, end, generator);
    }
  }

  // ---- Chains of channels

  std::vector<Layout> chains(const std::vector<bool>& ends, std::size_t most) const {
    std::vector<std::vector<Layout>> open(length_ + 1);
    open[0].emplace_back();
    std::vector<Layout> done;
    for (unsigned begin = 0; begin <= length_; ++begin) {
      keep_best(open[begin], most_open);
      if (begin > 0 && ends[begin]) done.insert(done.end(), open[begin].begin(), open[begin].end());
      for (const Layout& each : open[begin]) {
        if (each.channels.size() == max_channels) continue;
        for (const Candidate& candidate : candidates_[begin]) {
          Layout longer = each;
          longer.channels.push_back(candidate.channel());
          longer.rating += candidate.rating - further_channel_cost(each.channels.size());
          longer.score += candidate.evidence - further_channel_cost(each.channels.size());
          open[candidate.end].push_back(std::move(longer));
        }
      }
    }
    keep_best(done, most);
    std::erase_if(
        done, [&](const Layout& each) { return each.rating < done.front().rating - most_worse; });
    for (Layout& layout : done) layout.cost = end_cost(ends);
    return done;
  }

  static double end_cost(const std::vector<bool>& ends) {
    return std::log2(static_cast<double>(std::count(ends.begin(), ends.end(), true)));
  }

  template <class Item>
  static void keep_best(std::vector<Item>& items, std::size_t most) {
    std::stable_sort(items.begin(), items.end(),
                     [](const Item& a, const Item& b) { return a.rating > b.rating; });
    if (items.size() > most) items.resize(most);
  }

  // Errors of makers, in frames of one channel with a usual checksum.
  void add_variants(const std::vector<bool>& ends, std::vector<Layout>& done) const {
    for (unsigned end = 8; end <= std::min(length_, longest_channel); ++end) {
      if (!ends[end]) continue;
      for (unsigned width = min_crc_bits; width <= max_crc_bits; ++width) {
        const std::uint32_t generator = default_polynomial(width);
        if (generator == 0 || end < width + 4 || end - width > max_data_bits) continue;
        std::array<ChannelLayout, 5> variants;
        variants.fill({0, end - width, {generator, 0, static_cast<std::uint8_t>(width), true}});
        variants[0].crc.reversed = true;
        variants[1].crc.with_cds = true;
        variants[2].crc.of_previous = true;
        variants[3].crc.without_flags = true;
        variants[3].flags = 1;
        variants[4].crc.without_flags = true;
        variants[4].flags = 2;
        for (const ChannelLayout& each : variants) add_variant(each, end_cost(ends), done);
      }
    }
  }

  void add_variant(const ChannelLayout& channel, double cost, std::vector<Layout>& done) const {
    const ChannelCheck usual({channel.begin,
                              channel.data_bits,
                              {channel.crc.polynomial, 0, channel.crc.width_bits, true}});
    const ChannelCheck check(channel);
    double right = 0;
    double usual_right = 0;
    double known = 0;
    Basis basis;
    for (std::size_t i = 0; i < frames_.samples.size(); ++i) {
      if (channel.crc.of_previous && frames_.before[i] == nullptr) continue;
      const Sample& sample = *frames_.samples[i];
      // Most are wrong soon.
      if (++known == 65 && right < 12) return;
      usual_right += usual.is_right(sample, nullptr) ? 1 : 0;
      if (!check.is_right(sample, frames_.before[i])) continue;
      ++right;
      basis.add(polynomial_of(sample, channel.data()) ^
                polynomial_of(*frames_.samples[0], channel.data()));
    }
    if (right < least_share * all_ || right < 2 || usual_right >= right) return;
    done.emplace_back();
    done.back().channels = {channel};
    done.back().score =
        channel.crc.width_bits * (1 + data_weight * basis.rank()) - channel_cost(channel);
    done.back().cost = cost;
  }

  // All bits up to the first possible end, without a checksum.
  Layout unchecked() const {
    const std::vector<bool> ends = is_end(least_end_share, false);
    unsigned end = 0;
    while (end < length_ && !ends[end]) ++end;
    Layout layout;
    layout.channels.push_back({0, std::min(end, max_data_bits), {}});
    return layout;
  }

  // ---- What is left of the account

  void complete(Layout& layout) const {
    const std::vector<ChannelCheck> checks(layout.channels.begin(), layout.channels.end());
    double right = 0;
    for (std::size_t i = 0; i < frames_.samples.size(); ++i) {
      layout.right.push_back(std::all_of(checks.begin(), checks.end(), [&](const auto& each) {
        return each.is_right(*frames_.samples[i], frames_.before[i]);
      }));
      right += layout.right.back() ? 1 : 0;
    }
    layout.right_share = all_ > 0 ? right / all_ : 0;
    for (std::size_t k = 0; k < layout.channels.size(); ++k) {
      ChannelLayout& channel = layout.channels[k];
      find_rank(layout, channel);
      layout.cost += channel_cost(channel) + further_channel_cost(k);
      if (channel.crc.present()) layout.unknown += unknown_share(channel, begins_still(channel));
    }
    layout.cost += data_weight * events_cost(all_ - right, all_, 0.3, 3);
    const Sample* near = nullptr;
    for (std::size_t i = 0; i < frames_.samples.size(); ++i) {
      if (layout.right[i]) {
        near = frames_.samples[i];
      } else {
        layout.cost += data_weight * damage_cost(*frames_.samples[i], near, layout.end());
      }
    }
    layout.cost += tail_cost(layout);
  }

  void find_rank(const Layout& layout, ChannelLayout& channel) const {
    Basis basis;
    std::vector<bool> seen(patterns_.size());
    const Sample* first = nullptr;
    for (std::size_t i = 0; i < frames_.samples.size(); ++i) {
      if (!layout.right[i] || seen[frames_.pattern[i]]) continue;
      seen[frames_.pattern[i]] = true;
      if (first == nullptr) first = frames_.samples[i];
      basis.add(polynomial_of(*frames_.samples[i], channel.data()) ^
                polynomial_of(*first, channel.data()));
    }
    channel.rank = basis.rank();
  }

  bool begins_still(const ChannelLayout& channel) const {
    const unsigned count = std::min(channel.data_bits, 10U);
    const auto word = [&](const FrameSet::Pattern& each) {
      return each.sample->bits.view().word(channel.begin, count);
    };
    double same = 0;
    for (const auto& each : patterns_) same += word(each) == word(patterns_[0]) ? each.frames : 0;
    return same > 0.5 * all_;
  }

  // Which bits differ from a frame that is right, or all of them.
  static double damage_cost(const Sample& sample, const Sample* near, unsigned bits) {
    if (near == nullptr) return bits;
    const double wrong = distance(sample, *near, bits);
    const double choice =
        std::lgamma(bits + 1.0) - std::lgamma(wrong + 1.0) - std::lgamma(bits - wrong + 1.0);
    return std::min<double>(bits, choice / std::log(2.0) + std::log2(bits + 1.0));
  }

  // Zeros after STOP cost nothing.
  double tail_cost(const Layout& layout) const {
    const unsigned bits = std::min(length_ - layout.end(), 63U);
    std::vector<std::uint64_t> tails;
    bool zeros = true;
    for (std::size_t i = 0; bits > 0 && i < frames_.samples.size(); ++i) {
      if (!layout.right[i]) continue;
      tails.push_back(frames_.samples[i]->bits.view().word(layout.end(), bits));
      zeros = zeros && tails.back() == 0;
    }
    return zeros ? 0 : 8 + word_cost(tails, bits);
  }

  const FrameSet& frames_;
  unsigned length_;
  const std::vector<FrameSet::Pattern>& patterns_;
  double all_;
  SumTable pairs_{{}, 0};
  SumTable table_{{}, 0};
  // Of each difference, the ones among its first bits.
  std::vector<std::uint16_t> ones_;
  std::vector<float> votes_;
  std::vector<std::vector<Candidate>> candidates_;
  std::minstd_rand random_{1};
};

// The longest that a fifth of the frames have; frames that are too short for a position count only
// among themselves.
unsigned length_of(std::span<const Sample> samples) {
  constexpr std::size_t short_bits = 9;
  constexpr std::size_t few = 8;
  std::map<std::size_t, std::size_t> lengths;
  std::size_t frames = 0;
  for (const Sample& sample : samples) {
    ++lengths[sample.bits.size_bits()];
    frames += sample.bits.size_bits() >= short_bits ? 1U : 0U;
  }
  if (frames < few) frames = samples.size();
  std::size_t longer = 0;
  for (auto each = lengths.rbegin(); each != lengths.rend(); ++each) {
    longer += each->second;
    if (5 * each->second >= frames || 2 * longer >= frames)
      return static_cast<unsigned>(each->first);
  }
  return 0;
}

}  // namespace

FrameSet::FrameSet(std::span<const Sample> all, std::size_t most) : length(length_of(all)) {
  std::vector<const Sample*> whole;
  for (const Sample& sample : all) {
    if (sample.bits.size_bits() >= length) whole.push_back(&sample);
  }
  constexpr std::size_t block = 64;
  const std::size_t blocks = most / 2 / block;
  for (std::size_t i = 0; i < whole.size(); ++i) {
    const std::size_t rest = whole.size() - std::min(whole.size(), most / 2);
    const bool taken =
        whole.size() <= most || i < most / 2 || (i - most / 2) % (rest / blocks) < block;
    if (taken) samples.push_back(whole[i]);
  }
  std::map<std::vector<std::uint8_t>, std::size_t> known;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const bool follows = i > 0 && samples[i]->cycle == samples[i - 1]->cycle + 1;
    before.push_back(follows ? samples[i - 1] : nullptr);
    auto bits = samples[i]->bits;
    bits.truncate(length);
    const auto [same, made] =
        known.try_emplace({bits.bytes().begin(), bits.bytes().end()}, patterns.size());
    pattern.push_back(same->second);
    if (made) patterns.push_back({samples[i], 0});
    ++patterns[same->second].frames;
  }
}

bool Layout::checked() const {
  return std::all_of(channels.begin(), channels.end(),
                     [](const ChannelLayout& each) { return each.crc.present(); });
}

CrcSpec spec_of(std::uint32_t generator, unsigned data_bits, std::uint32_t rest) {
  const auto width = static_cast<unsigned>(degree(generator));
  CrcSpec spec{generator, 0, static_cast<std::uint8_t>(width), true};
  if (rest == spec.mask()) return spec;
  if (rest == 0) {
    spec.inverted = false;
    return spec;
  }
  spec.start = start_for(generator, width, data_bits, rest ^ spec.mask());
  return spec;
}

std::vector<Layout> find_layouts(const FrameSet& frames, std::size_t most) {
  if (frames.samples.empty()) return {};
  return LayoutSearch(frames).find(most);
}

ChannelCheck::ChannelCheck(const ChannelLayout& channel) : channel_(channel), crc_(channel.crc) {}

bool ChannelCheck::is_right(const Sample& sample, const Sample* before) const {
  if (sample.bits.size_bits() < channel_.end()) return false;
  if (!channel_.crc.present()) return true;
  const CrcSpec& crc = channel_.crc;
  if (crc.of_previous && before == nullptr) return true;
  const BitView bits = sample.bits.view();
  std::uint64_t sent = bits.word(channel_.data().end, crc.width_bits);
  const BitView covered = crc.of_previous ? before->bits.view() : bits;
  const std::uint64_t data = covered.word(channel_.begin, channel_.data_bits);
  if (crc.reversed) sent = frame_detail::bits_reversed(sent, crc.width_bits);
  // CDS is the first bit that is covered.
  if (crc.with_cds && sample.cds)
    sent ^= power_of_x(channel_.data_bits + crc.width_bits, crc.polynomial);
  return sent == crc_(data >> channel_.flags, channel_.data_bits - channel_.flags);
}

}  // namespace biss::identify
