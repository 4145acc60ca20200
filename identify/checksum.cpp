#include "identify/checksum.hpp"

#include <array>
#include <bit>
#include <cmath>
#include <map>
#include <random>
#include <utility>

#include "biss/crc/engines.hpp"
#include "biss/frame/codec.hpp"
#include "identify/coding.hpp"
#include "identify/log_gamma.hpp"

namespace biss::identify {

namespace {

// The share of all frames in which a checksum must be right to be tried, and the share in which the
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

// ---- The cost of a choice, in bits

double width_cost(unsigned width) {
  constexpr std::array<double, 9> costs{7, 7, 7, 7, 7, 4.5, 0.5, 8, 6};
  return width == 16 ? 2.5 : width < costs.size() ? costs[width] : 7;
}

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
  // x^k + 1 divides the difference of any two words that hold the same value twice.
  return width_cost(width) + cost + (std::popcount(generator) == 2 ? 20.0 : 0.0);
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

// The cost of one further channel.
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
  // A constant channel in front of this one looks the same as a start value.
  if (channel.crc.start != 0 && still_begin) share += std::exp2(channel.crc.width_bits - 6.0);
  return share;
}

// ---- Checksums

// value * x^by, and value * x^-by, modulo the generator.
std::uint32_t times_x(std::uint32_t value, unsigned by, std::uint32_t generator) {
  for (; by > 0; --by) {
    value <<= 1U;
    if ((value & std::bit_floor(generator)) != 0) value ^= generator;
  }
  return value;
}

std::uint32_t divided_by_x(std::uint32_t value, unsigned by, std::uint32_t generator) {
  for (; by > 0; --by) value = ((value & 1U) != 0 ? value ^ generator : value) >> 1U;
  return value;
}

// The checksum whose words, of one length, have this remainder. Start value and inversion cannot be
// separated: the result has no start value if possible; else it is inverted.
CrcSpec spec_of(std::uint32_t generator, unsigned data_bits, std::uint32_t rest) {
  CrcSpec spec{generator, 0, static_cast<std::uint8_t>(degree(generator)), rest != 0};
  if (rest != 0) {
    spec.start = static_cast<std::uint16_t>(divided_by_x(rest ^ spec.mask(), data_bits, generator));
  }
  return spec;
}

// Checks one channel of many frames.
class ChannelCheck {
 public:
  explicit ChannelCheck(const ChannelLayout& channel) : channel_(channel), crc_(channel.crc) {}

  // The checksum is right; false if the frame is too short.
  // \param before the frame before; null if it is not known
  bool is_right(const Sample& sample, const Sample* before) const {
    const CrcSpec& crc = channel_.crc;
    if (sample.bits.size_bits() < channel_.end()) return false;
    if (!crc.present() || (crc.of_previous && before == nullptr)) return true;
    std::uint64_t sent =
        sample.bits.view().word(channel_.begin + channel_.data_bits, crc.width_bits);
    if (crc.reversed) sent = frame_detail::bits_reversed(sent, crc.width_bits);
    // CDS is the first bit that is covered.
    if (crc.with_cds && sample.cds)
      sent ^= times_x(1, channel_.data_bits + crc.width_bits, crc.polynomial);
    const Sample& covered = crc.of_previous ? *before : sample;
    const std::uint64_t data = covered.bits.view().word(channel_.begin, channel_.data_bits);
    return sent == crc_(data >> channel_.flags, channel_.data_bits - channel_.flags);
  }

 private:
  ChannelLayout channel_;
  CrcTable<8> crc_;
};

// S(e) of many words: a row for each number of bits.
class SumTable {
 public:
  SumTable() = default;
  // \param bit whether a bit of a word is 1
  template <class Bit>
  SumTable(std::size_t words, unsigned length, Bit bit)
      : words_(words), length_(length), bits_(words * length) {
    for (std::size_t i = 0; i < bits_.size(); ++i) {
      bits_[i] = bit(i % words, i / words) ? 0xFFFFU : 0U;
    }
  }

  void sum(std::uint32_t generator) {
    sums_.assign((length_ + 1) * words_, 0);
    std::uint32_t power = 1;
    for (unsigned i = 0; i < length_; ++i) {
      const std::uint16_t* const bits = bits_.data() + i * words_;
      const std::uint16_t* const from = sums_.data() + i * words_;
      std::uint16_t* const to = sums_.data() + (i + 1) * words_;
      const auto mask = static_cast<std::uint16_t>(power);
      for (std::size_t w = 0; w < words_; ++w) {
        to[w] = static_cast<std::uint16_t>(from[w] ^ (bits[w] & mask));
      }
      power = divided_by_x(power, 1, generator);
    }
  }

  std::size_t words() const { return words_; }
  const std::uint16_t* row(unsigned bits) const { return sums_.data() + bits * words_; }
  bool bit(unsigned at, std::size_t word) const { return bits_[at * words_ + word] != 0; }

 private:
  std::size_t words_ = 0;
  unsigned length_ = 0;
  std::vector<std::uint16_t> bits_;
  std::vector<std::uint16_t> sums_;
};

class LayoutSearch {
 public:
  explicit LayoutSearch(const FrameSet& frames)
      : frames_(frames),
        length_(frames.length),
        patterns_(frames.patterns),
        all_(static_cast<double>(frames.samples.size())),
        candidates_(length_ + 1) {
    draw_differences();
    find_ends();
  }

  std::vector<Layout> find(std::size_t most) {
    find_narrow();
    find_wide();
    std::vector<Layout> done = chains(most);
    add_variants(done);
    done.push_back(unchecked());
    for (Layout& layout : done) complete(layout);
    return done;
  }

 private:
  struct Candidate {
    ChannelLayout channel;
    // By how many bits it is better than chance; the same, less the frames that do not fit.
    double score = 0;
    double rating = 0;
  };

  // Half of the frames by their number, half by their patterns. If most frames are equal, few of
  // the frames differ; if many are damaged, few of the patterns are right.
  std::size_t draw_pattern(std::size_t draw) {
    return draw % 2 == 0 ? random_() % patterns_.size()
                         : frames_.pattern[random_() % frames_.pattern.size()];
  }

  void draw_differences() {
    std::vector<std::pair<BitView, BitView>> drawn;
    for (std::size_t i = 0; patterns_.size() > 1 && i < differences; ++i) {
      const std::size_t one = draw_pattern(i);
      std::size_t other = draw_pattern(i);
      for (unsigned k = 0; k < 8 && one == other; ++k) other = draw_pattern(i);
      if (one == other) other = (one + 1) % patterns_.size();
      drawn.emplace_back(patterns_[one].sample->bits.view(), patterns_[other].sample->bits.view());
    }
    const std::size_t words = drawn.size();
    pairs_ = SumTable(words, length_, [&](std::size_t word, std::size_t bit) {
      return drawn[word].first[bit] != drawn[word].second[bit];
    });
    last_moved_.assign((length_ + 1) * words, 0);
    for (std::size_t i = 0; i < length_ * words; ++i) {
      const auto bit = static_cast<unsigned>(i / words);
      last_moved_[i + words] =
          pairs_.bit(bit, i % words) ? static_cast<std::uint16_t>(bit + 1) : last_moved_[i];
    }
  }

  // A frame can end before a bit that is 0 (STOP) and is followed by zeros, and then ones after the
  // timeout; or with the last clock.
  void find_ends() {
    std::vector<double> fits(length_ + 1, 0);
    fits[length_] = all_;
    for (const FrameSet::Pattern& pattern : patterns_) {
      const BitView bits = pattern.sample->bits.view();
      unsigned end = length_;
      while (end > 0 && bits[end - 1]) --end;
      while (end > 0 && !bits[end - 1]) fits[--end] += pattern.frames;
    }
    for (const double frames : fits) ends_.push_back(frames >= least_end_share * all_);
  }

  // ---- The channels that may be anywhere

  void find_narrow() {
    table_ = SumTable(patterns_.size(), length_, [&](std::size_t word, std::size_t bit) {
      return patterns_[word].sample->bits.view()[bit];
    });
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
        const bool agree = pairs_agree(begin, end);
        if (agree || is_usual(generator)) add_candidate(begin, end, generator, agree);
      }
    }
  }

  // Enough differences in these bits are multiples of the generator.
  bool pairs_agree(unsigned begin, unsigned end) const {
    if (pairs_.words() != differences) return false;
    const std::uint16_t* const from = pairs_.row(begin);
    const std::uint16_t* const to = pairs_.row(end);
    const std::uint16_t* const last_moved = last_moved_.data() + end * differences;
    // Without branches and with a fixed number of rounds, so that the compiler vectorises the loop.
    std::uint16_t agree = 0;
    std::uint16_t differ = 0;
    for (std::size_t w = 0; w < differences; ++w) {
      const auto moved = static_cast<std::uint16_t>(last_moved[w] > begin);
      differ = static_cast<std::uint16_t>(differ + moved);
      agree = static_cast<std::uint16_t>(agree + (from[w] == to[w] ? moved : 0));
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

  // With the most frequent remainder, or with the usual one: this needs no motion of the encoder.
  void add_candidate(unsigned begin, unsigned end, std::uint32_t generator, bool agree) {
    const auto width = static_cast<unsigned>(degree(generator));
    const unsigned rank = rank_of_pairs(begin, end, width);
    const double bits = width * (1 + data_weight * rank);
    if (!is_usual(generator) && bits < generator_cost(generator)) return;
    const std::uint16_t* const from = table_.row(begin);
    const std::uint16_t* const to = table_.row(end);
    std::size_t value = divided_by_x((1U << width) - 1, end - 1, generator);
    votes_.assign(std::size_t{1} << width, 0);
    for (std::size_t i = 0; i < patterns_.size(); ++i) {
      const auto here = static_cast<std::size_t>(from[i] ^ to[i]);
      votes_[here] += static_cast<float>(patterns_[i].frames);
      if (agree && votes_[here] > votes_[value]) value = here;
    }
    const double frames = votes_[value];
    if (frames < least_share * all_) return;
    const unsigned data_bits = end - begin - width;
    const auto rest = times_x(static_cast<std::uint32_t>(value), end - 1, generator);
    Candidate candidate{{begin, data_bits, spec_of(generator, data_bits, rest)}};
    candidate.score = bits - channel_cost(candidate.channel);
    candidate.rating = candidate.score - data_weight * misfit_cost * (all_ - frames);
    candidates_[begin].push_back(candidate);
  }

  // Any generator of up to 16 bits, from the common factor of differences: only for ends of the
  // frame, and of channels before another one.
  void find_wide() {
    constexpr double strong = 15;
    constexpr std::size_t most_begins = 8;
    std::vector<unsigned> begins{0};
    std::vector<bool> ends = ends_;
    const auto is_begin = [&](unsigned bit) {
      return std::find(begins.begin(), begins.end(), bit) != begins.end();
    };
    for (unsigned begin = 0; begin < length_; ++begin) {
      for (const Candidate& each : candidates_[begin]) {
        if (each.score < strong) continue;
        ends[begin] = true;
        const unsigned end = each.channel.end();
        if (is_begin(begin) && !is_begin(end) && begins.size() < most_begins) begins.push_back(end);
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

  // The common divisor of a few differences is the generator, times a factor of the bits that have
  // not moved.
  void draw_generators(unsigned begin, unsigned end) {
    constexpr std::size_t draws = 16;
    constexpr std::size_t frames_a_draw = 10;
    std::vector<std::uint32_t> tried;
    for (std::size_t draw = 0; draw < draws; ++draw) {
      Polynomial common = 0;
      Polynomial first = 0;
      std::size_t different = 0;
      for (std::size_t k = 0; k < frames_a_draw; ++k) {
        const Sample& sample = *patterns_[draw_pattern(draw)].sample;
        const Polynomial word = polynomial_of(sample, begin, end - begin);
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
      add_candidate(begin, end, generator, true);
    }
  }

  // ---- Chains of channels

  std::vector<Layout> chains(std::size_t most) const {
    std::vector<std::vector<Layout>> open(length_ + 1);
    open[0].emplace_back();
    std::vector<Layout> done;
    for (unsigned begin = 0; begin <= length_; ++begin) {
      keep_best(open[begin], most_open);
      if (begin > 0 && ends_[begin])
        done.insert(done.end(), open[begin].begin(), open[begin].end());
      for (const Layout& each : open[begin]) {
        if (each.channels.size() == max_channels) continue;
        for (const Candidate& candidate : candidates_[begin]) {
          Layout longer = each;
          longer.channels.push_back(candidate.channel);
          longer.rating += candidate.rating - further_channel_cost(each.channels.size());
          longer.score += candidate.score - further_channel_cost(each.channels.size());
          open[candidate.channel.end()].push_back(std::move(longer));
        }
      }
    }
    keep_best(done, most);
    std::erase_if(
        done, [&](const Layout& each) { return each.rating < done.front().rating - most_worse; });
    return done;
  }

  template <class Item>
  static void keep_best(std::vector<Item>& items, std::size_t most) {
    std::stable_sort(items.begin(), items.end(),
                     [](const Item& a, const Item& b) { return a.rating > b.rating; });
    if (items.size() > most) items.resize(most);
  }

  // Errors of makers, in frames of one channel with a usual checksum.
  void add_variants(std::vector<Layout>& done) const {
    for (unsigned end = 8; end <= std::min(length_, longest_channel); ++end) {
      for (unsigned width = min_crc_bits; width <= max_crc_bits && ends_[end]; ++width) {
        const std::uint32_t generator = default_polynomial(width);
        if (generator == 0 || end < width + 4 || end - width > max_data_bits) continue;
        const CrcSpec usual = spec_of(generator, end - width, (1U << width) - 1);
        std::array<ChannelLayout, 5> variants;
        variants.fill({0, end - width, usual});
        variants[0].crc.reversed = true;
        variants[1].crc.with_cds = true;
        variants[2].crc.of_previous = true;
        for (const unsigned flags : {1U, 2U}) {
          variants[2 + flags].crc.without_flags = true;
          variants[2 + flags].flags = flags;
        }
        for (const ChannelLayout& each : variants) add_variant(each, usual, done);
      }
    }
  }

  void add_variant(const ChannelLayout& channel, const CrcSpec& usual,
                   std::vector<Layout>& done) const {
    const ChannelCheck check(channel);
    const ChannelCheck usual_check({channel.begin, channel.data_bits, usual});
    std::vector<bool> right;
    double count = 0;
    double usual_count = 0;
    for (std::size_t i = 0; i < frames_.samples.size(); ++i) {
      const Sample& sample = *frames_.samples[i];
      const Sample* const before = frames_.before[i];
      const bool known = !channel.crc.of_previous || before != nullptr;
      right.push_back(known && check.is_right(sample, before));
      count += right[i] ? 1 : 0;
      usual_count += known && usual_check.is_right(sample, nullptr) ? 1 : 0;
      // Most fail early.
      if (i == 64 && count < 12) return;
    }
    if (count < least_share * all_ || count < 2 || usual_count >= count) return;
    Layout& layout = done.emplace_back();
    layout.channels = {channel};
    layout.score = channel.crc.width_bits * (1 + data_weight * rank_of(right, channel)) -
                   channel_cost(channel);
  }

  // All bits up to the first possible end, without a checksum.
  Layout unchecked() const {
    const auto end =
        static_cast<unsigned>(std::find(ends_.begin(), ends_.end(), true) - ends_.begin());
    return {.channels = {{0, std::min(end, max_data_bits), {}}}, .right = {}};
  }

  // ---- The rest of the account

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
    const auto ends = static_cast<double>(std::count(ends_.begin(), ends_.end(), true));
    layout.cost = layout.checked() ? std::log2(ends) : 0;
    for (std::size_t k = 0; k < layout.channels.size(); ++k) {
      ChannelLayout& channel = layout.channels[k];
      channel.rank = rank_of(layout.right, channel);
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

  // The bits that differ from the bits of a correct frame, or all bits.
  static double damage_cost(const Sample& sample, const Sample* near, unsigned bits) {
    if (near == nullptr) return bits;
    double wrong = 0;
    for (unsigned at = 0; at < bits; at += 64) {
      const unsigned now = std::min(bits - at, 64U);
      wrong += std::popcount(sample.bits.view().word(at, now) ^ near->bits.view().word(at, now));
    }
    const double choice =
        log_gamma(bits + 1.0) - log_gamma(wrong + 1.0) - log_gamma(bits - wrong + 1.0);
    return std::min<double>(bits, choice / std::log(2.0) + std::log2(bits + 1.0));
  }

  // How many differences of the data are independent, in the frames that are right.
  unsigned rank_of(const std::vector<bool>& right, const ChannelLayout& channel) const {
    Basis basis;
    const auto first =
        static_cast<std::size_t>(std::find(right.begin(), right.end(), true) - right.begin());
    const auto data = [&](std::size_t i) {
      return polynomial_of(*frames_.samples[i], channel.begin, channel.data_bits);
    };
    for (std::size_t i = first; i < right.size(); ++i) {
      if (right[i]) basis.add(data(i) ^ data(first));
    }
    return basis.rank();
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

  // Zeros after STOP cost nothing.
  double tail_cost(const Layout& layout) const {
    const unsigned bits = std::min(length_ - layout.end(), 63U);
    std::vector<std::uint64_t> tails;
    for (std::size_t i = 0; bits > 0 && i < frames_.samples.size(); ++i) {
      if (!layout.right[i]) continue;
      tails.push_back(frames_.samples[i]->bits.view().word(layout.end(), bits));
    }
    const bool zeros = std::count(tails.begin(), tails.end(), 0U) == std::ssize(tails);
    return zeros ? 0 : 8 + word_cost(tails, bits);
  }

  const FrameSet& frames_;
  unsigned length_;
  const std::vector<FrameSet::Pattern>& patterns_;
  double all_;
  // The bits after which a frame can end.
  std::vector<bool> ends_;
  SumTable pairs_;
  SumTable table_;
  // For each difference, the number of its bits up to the last one that is 1.
  std::vector<std::uint16_t> last_moved_;
  std::vector<float> votes_;
  // By their first bit.
  std::vector<std::vector<Candidate>> candidates_;
  std::minstd_rand random_{1};
};

// The greatest length that a fifth of the frames reach; frames that are too short for a position
// count only among themselves.
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

std::vector<Layout> find_layouts(const FrameSet& frames, std::size_t most) {
  if (frames.samples.empty()) return {};
  return LayoutSearch(frames).find(most);
}

}  // namespace biss::identify
