#include "identify/checksum.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <map>
#include <random>
#include <set>
#include <unordered_map>
#include <utility>

namespace biss::identify {

namespace {

// Different frames that are looked at.
constexpr std::size_t most_patterns = 1024;
// A generator comes from this many frames. With one damaged frame in ten, a third of the draws
// have no damaged one.
constexpr std::size_t frames_a_draw = 10;
constexpr std::size_t draws = 48;
// Divisors that are tried of what a draw has in common.
constexpr std::size_t most_divisors = 64;
// Of all frames, the share in which the checksums of a layout must be right, and the bits after it
// must be as after the end of a frame.
constexpr double least_share = 0.6;
constexpr double least_end_share = 0.8;
// Layouts that are followed at the same time.
constexpr std::size_t most_open = 8;
// Channels that are tried after the same bit.
constexpr std::size_t most_followed = 24;
constexpr unsigned longest_channel = max_data_bits + max_crc_bits;

// ---- What a choice costs, in bits

double width_cost(unsigned width) {
  switch (width) {
    case 6:
      return 0.5;
    case 16:
      return 2.5;
    case 5:
      return 3.5;
    default:
      return 5;
  }
}

// x^k + 1 divides the difference of any two words that hold the same value twice.
bool repeats(std::uint32_t generator) { return (generator & (generator - 1U)) == 1U; }

double generator_cost(std::uint32_t generator) {
  const auto width = static_cast<unsigned>(degree(generator));
  const double usual = default_polynomial(width) == generator ? 0.5 : 3.0 + width;
  return width_cost(width) + usual + (repeats(generator) ? 20.0 : 0.0);
}

// The start value and the inversion are one number: see spec_of().
double constant_cost(const CrcSpec& spec) {
  if (spec.start != 0) return spec.width_bits + 3.0;
  return spec.inverted ? 0.2 : 4.0;
}

constexpr double further_channel_cost = 10;

// ---- Generators

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

// The checksum whose word has this remainder. Start value and inversion cannot be separated where
// all words have one length: without a start value where that is possible, else inverted.
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

// A remainder, and the frames that have it.
struct Vote {
  std::uint32_t rest = 0;
  double frames = 0;
};

// The remainder that most frames have.
Vote vote_on(std::vector<Vote>& votes) {
  std::sort(votes.begin(), votes.end(),
            [](const Vote& a, const Vote& b) { return a.rest < b.rest; });
  Vote best;
  for (std::size_t i = 0; i < votes.size();) {
    Vote sum = votes[i];
    while (++i < votes.size() && votes[i].rest == sum.rest) sum.frames += votes[i].frames;
    if (sum.frames > best.frames) best = sum;
  }
  return best;
}

// Frames with the same bits.
struct Pattern {
  const Sample* sample = nullptr;
  double frames = 0;
};

bool same_bits(const Sample& a, const Sample& b, unsigned length) {
  for (unsigned at = 0; at < length; at += 64) {
    const unsigned now = std::min(length - at, 64U);
    if (a.bits.view().word(at, now) != b.bits.view().word(at, now)) return false;
  }
  return true;
}

std::uint64_t hash_of(const Sample& sample, unsigned length) {
  std::uint64_t hash = 0;
  for (unsigned at = 0; at < length; at += 64) {
    const unsigned now = std::min(length - at, 64U);
    hash = (hash ^ sample.bits.view().word(at, now)) * 0x9E3779B97F4A7C15U;
    hash ^= hash >> 29U;
  }
  return hash;
}

class LayoutSearch {
 public:
  explicit LayoutSearch(std::span<const Sample> samples) {
    choose_length(samples);
    collect_patterns(samples);
    find_ends();
  }

  std::vector<Layout> find(std::size_t most) {
    if (patterns_.empty()) return {};
    std::vector<Open> open{{{}, std::vector<bool>(patterns_.size(), true)}};
    std::vector<Layout> done;
    for (std::size_t channel = 0; channel < max_channels && !open.empty(); ++channel) {
      std::vector<Open> next;
      for (const Open& each : open) extend(each, next, done);
      keep_best(next, most_open, [](const Open& each) { return each.layout.score; });
      open = std::move(next);
    }
    blame_misfits(done);
    done.push_back(unchecked());
    keep_best(done, most, [](const Layout& each) { return each.score; });
    return done;
  }

 private:
  struct Candidate {
    Span span;
    CrcSpec crc;
  };
  struct Open {
    Layout layout;
    // Patterns in which the checksums of all channels are right.
    std::vector<bool> right;
  };

  // Three frames of four have this many bits after CDS.
  void choose_length(std::span<const Sample> samples) {
    std::vector<std::size_t> lengths;
    for (const Sample& sample : samples) lengths.push_back(sample.bits.size_bits());
    if (lengths.empty()) return;
    const auto rank = lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 4);
    std::nth_element(lengths.begin(), rank, lengths.end());
    length_ = static_cast<unsigned>(*rank);
  }

  void collect_patterns(std::span<const Sample> samples) {
    std::unordered_multimap<std::uint64_t, std::size_t> known;
    for (const Sample& sample : samples) {
      if (sample.bits.size_bits() < length_) continue;
      ++frames_;
      const std::uint64_t hash = hash_of(sample, length_);
      const auto [begin, end] = known.equal_range(hash);
      const auto same = std::find_if(begin, end, [&](const auto& each) {
        return same_bits(*patterns_[each.second].sample, sample, length_);
      });
      if (same != end) {
        ++patterns_[same->second].frames;
      } else {
        known.emplace(hash, patterns_.size());
        patterns_.push_back({&sample, 1});
      }
    }
    thin_out();
  }

  // Evenly from all of the capture.
  void thin_out() {
    if (patterns_.size() <= most_patterns) return;
    std::vector<Pattern> kept;
    frames_ = 0;
    for (std::size_t i = 0; i < most_patterns; ++i) {
      kept.push_back(patterns_[i * patterns_.size() / most_patterns]);
      frames_ += kept.back().frames;
    }
    patterns_ = std::move(kept);
  }

  // A frame can end before a bit that is 0 (STOP) and is followed by zeros, and then ones after the
  // timeout; or with the last clock.
  void find_ends() {
    std::vector<double> fits(length_ + 1, 0);
    fits[length_] = frames_;
    for (const Pattern& pattern : patterns_) {
      const BitView bits = pattern.sample->bits.view();
      unsigned after = length_;
      while (after > 0 && bits[after - 1]) --after;
      unsigned first = after;
      while (first > 0 && !bits[first - 1]) --first;
      for (unsigned end = first; end < after; ++end) fits[end] += pattern.frames;
    }
    double ends = 0;
    is_end_.resize(length_ + 1);
    for (unsigned end = 0; end <= length_; ++end) {
      is_end_[end] = fits[end] >= least_end_share * frames_;
      ends += is_end_[end] ? 1 : 0;
    }
    end_cost_ = std::log2(ends);
  }

  // ---- The channels that may begin at a bit

  using Found = std::map<std::pair<unsigned, std::uint32_t>, CrcSpec>;

  const std::vector<Candidate>& candidates(unsigned begin) {
    const auto known = candidates_.find(begin);
    if (known != candidates_.end()) return known->second;
    Found found;
    const unsigned last = std::min(length_, begin + longest_channel);
    for (unsigned end = begin + min_crc_bits + 1; end <= last; ++end) {
      for (unsigned width = min_crc_bits; width <= max_crc_bits; ++width) {
        const std::uint32_t usual = default_polynomial(width);
        if (usual != 0) try_generator({begin, end}, usual, true, found);
      }
    }
    tried_.clear();
    for (std::size_t draw = 0; draw < draws; ++draw) {
      draw_generators(begin, last, draw_patterns(draw % 2 == 0), found);
    }
    // Where little has moved, thousands fit: only the best ones are followed.
    std::vector<std::pair<double, Candidate>> weighed;
    for (const auto& [place, crc] : found) {
      const Candidate candidate{{begin, place.first}, crc};
      Open alone{{}, std::vector<bool>(patterns_.size(), true)};
      alone.layout.channels.push_back(channel_of(candidate));
      if (weigh(alone)) weighed.emplace_back(alone.layout.score, candidate);
    }
    keep_best(weighed, most_followed, [](const auto& each) { return each.first; });
    std::vector<Candidate>& list = candidates_[begin];
    for (const auto& each : weighed) list.push_back(each.second);
    return list;
  }

  static ChannelLayout channel_of(const Candidate& candidate) {
    const unsigned width = candidate.crc.width_bits;
    return {candidate.span.begin, candidate.span.bits() - width, candidate.crc, 0};
  }

  // Where most frames are alike, few of the frames drawn differ; where many are damaged, few of the
  // patterns are right.
  std::vector<const Sample*> draw_patterns(bool by_frames) {
    std::vector<const Sample*> drawn;
    std::uniform_real_distribution<double> place(0, by_frames ? frames_ : 1.0);
    for (std::size_t i = 0; i < frames_a_draw; ++i) {
      if (!by_frames) {
        drawn.push_back(patterns_[random_() % patterns_.size()].sample);
        continue;
      }
      double left = place(random_);
      std::size_t at = 0;
      while (at + 1 < patterns_.size() && left >= patterns_[at].frames) {
        left -= patterns_[at++].frames;
      }
      drawn.push_back(patterns_[at].sample);
    }
    return drawn;
  }

  // Divisors of the differences of a few frames, for every end of the channel.
  void draw_generators(unsigned begin, unsigned last, const std::vector<const Sample*>& drawn,
                       Found& found) {
    for (unsigned end = begin + min_crc_bits + 1; end <= last; ++end) {
      const Span span{begin, end};
      const Polynomial first = polynomial_of(*drawn[0], span);
      Polynomial common = 0;
      // Any divisor of a single difference would do.
      std::size_t different = 0;
      for (const Sample* each : drawn) {
        const Polynomial divisor = common_divisor(common, first ^ polynomial_of(*each, span));
        different += divisor != common ? 1U : 0U;
        common = without_x(divisor);
        if (common != 0 && degree(common) < static_cast<int>(min_crc_bits)) break;
      }
      if (different < 2 || degree(common) < static_cast<int>(min_crc_bits)) {
        continue;
      }
      if (!tried_.emplace(end, common).second) continue;
      for (const std::uint32_t generator :
           divisors(common, min_crc_bits, max_crc_bits, most_divisors)) {
        try_generator(span, generator, false, found);
      }
    }
  }

  // \param as_usual with the usual start value and inversion, which need no motion
  void try_generator(Span span, std::uint32_t generator, bool as_usual, Found& found) {
    const auto width = static_cast<unsigned>(degree(generator));
    if (span.bits() <= width || span.bits() - width > max_data_bits) return;
    const auto place = std::pair(span.end, generator);
    if (found.contains(place)) return;
    votes_.clear();
    const auto usual = static_cast<std::uint32_t>((1U << width) - 1U);
    double left = frames_;
    for (const Pattern& pattern : patterns_) {
      const auto rest =
          static_cast<std::uint32_t>(remainder(polynomial_of(*pattern.sample, span), generator));
      if (as_usual && rest != usual) {
        left -= pattern.frames;
        if (left < least_share * frames_) return;
      }
      votes_.push_back({rest, pattern.frames});
    }
    const Vote vote = vote_on(votes_);
    if (vote.frames < least_share * frames_) return;
    found[place] = spec_of(generator, span.bits() - width, vote.rest);
  }

  // ---- Layouts

  void extend(const Open& open, std::vector<Open>& next, std::vector<Layout>& done) {
    for (const Candidate& candidate : candidates(open.layout.end())) {
      Open longer = open;
      longer.layout.channels.push_back(channel_of(candidate));
      if (!weigh(longer)) continue;
      const unsigned end = longer.layout.end();
      if (is_end_[end]) {
        done.push_back(longer.layout);
        done.back().score -= end_cost_;
        done.back().evidence -= end_cost_;
      }
      if (end < length_) next.push_back(std::move(longer));
    }
  }

  // Adds the last channel to the score. False where the layout does not fit most frames.
  bool weigh(Open& open) const {
    Layout& layout = open.layout;
    ChannelLayout& channel = layout.channels.back();
    const Span check{channel.data().end, channel.end()};
    Basis<Polynomial> data;
    Polynomial first_data = 0;
    std::array<std::size_t, max_crc_bits> ones{};
    std::size_t patterns = 0;
    double frames = 0;
    const ChannelCheck check_of(channel);
    for (std::size_t i = 0; i < patterns_.size(); ++i) {
      const Sample& sample = *patterns_[i].sample;
      open.right[i] = open.right[i] && check_of.is_right(sample);
      if (!open.right[i]) continue;
      const Polynomial this_data = polynomial_of(sample, channel.data());
      const std::uint64_t this_check = sample.bits.view().word(check.begin, check.bits());
      if (frames == 0) first_data = this_data;
      frames += patterns_[i].frames;
      ++patterns;
      data.add(this_data ^ first_data);
      for (unsigned bit = 0; bit < check.bits(); ++bit) ones[bit] += (this_check >> bit) & 1U;
    }
    if (frames < least_share * frames_) return false;
    channel.rank = data.rank();
    layout.right_share = frames / frames_;
    const unsigned width = channel.crc.width_bits;
    // A bit of a checksum moves in half of the independent differences. A few damaged frames may be
    // right by chance, where a clock is lost.
    const auto still = std::count_if(ones.begin(), ones.begin() + width, [&](std::size_t count) {
      return 20 * std::min(count, patterns - count) < patterns;
    });
    const double gain = static_cast<double>(width) * (channel.rank + 1.0) -
                        static_cast<double>(still) * channel.rank -
                        (layout.channels.size() > 1 ? further_channel_cost : 0.0);
    layout.score += gain - generator_cost(channel.crc.polynomial) - constant_cost(channel.crc);
    layout.evidence += gain - 2.0 * width - (repeats(channel.crc.polynomial) ? 20.0 : 0.0);
    return true;
  }

  template <class Item, class Score>
  static void keep_best(std::vector<Item>& items, std::size_t most, Score score) {
    std::stable_sort(items.begin(), items.end(),
                     [&](const Item& a, const Item& b) { return score(a) > score(b); });
    if (items.size() > most) items.resize(most);
  }

  // Frames that fit another layout are not damaged: not to fit them speaks against a layout.
  void blame_misfits(std::vector<Layout>& layouts) const {
    constexpr double a_frame = 3;
    double best = 0;
    for (const Layout& layout : layouts) {
      if (layout.score > 20) best = std::max(best, layout.right_share);
    }
    for (Layout& layout : layouts) {
      const double misfit = a_frame * frames_ * std::max(0.0, best - layout.right_share);
      layout.score -= misfit;
      layout.evidence -= misfit;
    }
  }

  // All bits up to the first possible end, without a checksum.
  Layout unchecked() const {
    unsigned end = 0;
    while (end < length_ && !is_end_[end]) ++end;
    Layout layout;
    layout.channels.push_back({0, std::min(end, max_data_bits), {}, 0});
    layout.right_share = 1;
    return layout;
  }

  unsigned length_ = 0;
  std::vector<Pattern> patterns_;
  double frames_ = 0;
  std::vector<bool> is_end_;
  double end_cost_ = 0;
  std::map<unsigned, std::vector<Candidate>> candidates_;
  std::set<std::pair<unsigned, Polynomial>> tried_;
  std::vector<Vote> votes_;
  std::minstd_rand random_{1};
};

}  // namespace

std::vector<Layout> find_layouts(std::span<const Sample> samples, std::size_t most) {
  return LayoutSearch(samples).find(most);
}

ChannelCheck::ChannelCheck(const ChannelLayout& channel) : channel_(channel), crc_(channel.crc) {}

bool ChannelCheck::is_right(const Sample& sample) const {
  if (sample.bits.size_bits() < channel_.end()) return false;
  if (!channel_.crc.present()) return true;
  const BitView bits = sample.bits.view();
  return bits.word(channel_.data().end, channel_.crc.width_bits) ==
         crc_(bits.word(channel_.begin, channel_.data_bits), channel_.data_bits);
}

std::vector<const Sample*> right_samples(const Layout& layout, std::span<const Sample> samples) {
  const std::vector<ChannelCheck> checks(layout.channels.begin(), layout.channels.end());
  std::vector<const Sample*> right;
  for (const Sample& sample : samples) {
    if (std::all_of(checks.begin(), checks.end(),
                    [&](const ChannelCheck& each) { return each.is_right(sample); })) {
      right.push_back(&sample);
    }
  }
  return right;
}

}  // namespace biss::identify
