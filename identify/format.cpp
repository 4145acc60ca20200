#include "identify/format.hpp"

#include <algorithm>
#include <cmath>

#include "biss/catalogue/catalogue.hpp"
#include "biss/frame/codec.hpp"
#include "biss/safety/configurations.hpp"

namespace biss::identify {

namespace {

constexpr std::size_t most_candidates = 5;
// The motion of an axis is not random, so that its frames agree with a wrong checksum more often
// than chance says. These bits of the evidence are therefore not counted.
constexpr double reserve_bits = 10;
// More ones of CDS than in this share of the frames are no damage.
constexpr double most_damage = 0.1;
// Where the meaning of the bits is doubtful, however sure the checksum is.
constexpr double doubtful_confidence = 0.8;

// The time from request to request, as far as the frames show it.
Picoseconds usual_interval(const std::vector<const Sample*>& samples) {
  std::vector<Picoseconds> intervals;
  for (std::size_t i = 1; i < samples.size(); ++i) {
    if (samples[i]->cycle - samples[i - 1]->cycle != 1) continue;
    intervals.push_back(samples[i]->time - samples[i - 1]->time);
  }
  if (intervals.empty()) return {};
  const auto middle = intervals.begin() + static_cast<std::ptrdiff_t>(intervals.size() / 2);
  std::nth_element(intervals.begin(), middle, intervals.end());
  return *middle;
}

std::vector<DataWord> words_of(const std::vector<const Sample*>& samples,
                               const ChannelLayout& channel) {
  const Picoseconds interval = usual_interval(samples);
  std::vector<DataWord> words;
  const Sample* before = nullptr;
  for (const Sample* sample : samples) {
    DataWord word{sample->bits.view().word(channel.begin, channel.data_bits), sample->cycle, 0};
    if (before != nullptr && interval.count > 0) {
      word.requests = static_cast<std::uint64_t>(
          (sample->time - before->time + interval / 2).count / interval.count);
    }
    words.push_back(word);
    before = sample;
  }
  return words;
}

// Damaged frames whose checksums happen to be right.
double strays(const Layout& layout, std::size_t frames) {
  double pass = 1;
  for (const ChannelLayout& channel : layout.channels) {
    pass = std::min(pass, std::pow(2.0, -static_cast<double>(channel.crc.width_bits)));
  }
  return static_cast<double>(frames) * (1 - layout.right_share) * pass;
}

// The encoder answers on CDS. It does so only where the master asks, and then with two ones or more;
// other ones are damage, as long as they are rare.
bool answers_on_cds(const std::vector<const Sample*>& samples) {
  std::size_t ones = 0;
  std::size_t answers = 0;
  for (const Sample* sample : samples) {
    ones += sample->cds ? 1U : 0U;
    answers += sample->cds && sample->asked ? 1U : 0U;
  }
  return answers >= 2 ||
         static_cast<double>(ones) > most_damage * static_cast<double>(samples.size());
}

// ---- The catalogue

std::uint64_t mask_of(const Field& field) { return low_mask(field.bits) << field.shift; }
std::uint64_t mask_of(const FlagField& flag) {
  return flag.present ? std::uint64_t{1} << flag.shift : 0;
}

// A flag that moved has the same place and level.
bool same_level(const FlagField& known, const FlagField& seen, std::uint64_t moved) {
  return (mask_of(seen) & moved) == 0 || known == seen;
}

// The bits that moved have a meaning in `known` that fits how they moved.
bool explains(const ChannelFormat& known, const Fields& seen) {
  if (known.data_bits != seen.channel.data_bits || known.crc != seen.channel.crc) return false;
  const std::uint64_t position =
      mask_of(known.position) | mask_of(known.multiturn) | mask_of(known.singleturn);
  const std::uint64_t flags = mask_of(known.error) | mask_of(known.warning);
  const std::uint64_t counter = mask_of(known.life_counter);
  const std::uint64_t counted = mask_of(seen.channel.life_counter) & seen.moved;
  if ((seen.moved & ~(position | flags | counter)) != 0) return false;
  if ((seen.position_moved & flags) != 0 || (seen.flags_moved & ~flags) != 0) return false;
  if (!same_level(known.error, seen.channel.error, seen.moved) ||
      !same_level(known.warning, seen.channel.warning, seen.moved)) {
    return false;
  }
  if ((counted & ~counter) != 0 || (seen.moved & counter & ~counted) != 0) return false;
  const bool order_seen =
      std::find(seen.doubts.begin(), seen.doubts.end(), Doubt::order) == seen.doubts.end();
  if (seen.channel.singleturn_gray || order_seen) {
    return known.singleturn_gray == seen.channel.singleturn_gray;
  }
  return true;
}

bool explains(const FrameFormat& known, const FormatCandidate& candidate) {
  if (known.channel_count != candidate.format.channel_count) return false;
  for (std::size_t k = 0; k < known.channel_count; ++k) {
    if (!explains(known.channel_list[k], candidate.fields[k])) return false;
  }
  return true;
}

// Flags that most frames show as active.
unsigned active_flags(const FrameFormat& format, const std::vector<std::vector<DataWord>>& words) {
  unsigned active = 0;
  for (std::size_t k = 0; k < format.channel_count; ++k) {
    const ChannelFormat& channel = format.channel_list[k];
    for (const FlagField* flag : {&channel.error, &channel.warning}) {
      std::size_t low = 0;
      for (const DataWord& word : words[k]) low += flag->low_active(word.data) ? 0U : 1U;
      active += 2 * low > words[k].size() ? 1U : 0U;
    }
  }
  return active;
}

struct KnownFormat {
  FrameFormat format;
  std::vector<std::string_view> names;
  unsigned active = 0;
};

std::vector<KnownFormat> known_formats(const FormatCandidate& candidate,
                                       const std::vector<std::vector<DataWord>>& words, bool cds) {
  std::vector<KnownFormat> known;
  const auto add = [&](const FrameFormat& format, std::string_view name) {
    if ((format.cds0 && cds) || !explains(format, candidate)) return;
    const auto same = std::find_if(known.begin(), known.end(),
                                   [&](const KnownFormat& each) { return each.format == format; });
    if (same != known.end()) {
      same->names.push_back(name);
    } else {
      known.push_back({format, {name}, active_flags(format, words)});
    }
  };
  for (const CatalogueEntry& entry : catalogue) add(entry.frame_format(), entry.name);
  for (const SafetyConfiguration& each : safety_configurations) {
    if (find_encoder(each.name) == nullptr) add(each.frame_format(), each.name);
  }
  std::stable_sort(known.begin(), known.end(), [](const KnownFormat& a, const KnownFormat& b) {
    return a.active != b.active ? a.active < b.active : a.names.size() > b.names.size();
  });
  return known;
}

void drop(std::vector<Doubt>& doubts, std::initializer_list<Doubt> settled) {
  std::erase_if(doubts, [&](Doubt doubt) {
    return std::find(settled.begin(), settled.end(), doubt) != settled.end();
  });
}

// A catalogue format gives the meaning of what the motion does not show.
void compare_with_catalogue(FormatCandidate& candidate,
                            const std::vector<std::vector<DataWord>>& words, bool cds) {
  const std::vector<KnownFormat> known = known_formats(candidate, words, cds);
  if (known.empty()) return;
  candidate.format = known.front().format;
  for (const KnownFormat& each : known) {
    if (each.format != candidate.format) candidate.equal.push_back(each.format);
    if (each.active != known.front().active) continue;
    candidate.encoders.insert(candidate.encoders.end(), each.names.begin(), each.names.end());
  }
  for (Fields& each : candidate.fields) {
    drop(each.doubts, {Doubt::order, Doubt::flag_place});
    if (known.front().active == 0) drop(each.doubts, {Doubt::flag_level});
  }
}

FormatCandidate candidate_of(std::span<const Sample> samples, const Layout& layout) {
  FormatCandidate candidate;
  candidate.layout = layout;
  std::vector<std::vector<DataWord>> words;
  const std::vector<const Sample*> right = right_samples(layout, samples);
  for (const ChannelLayout& channel : layout.channels) {
    words.push_back(words_of(right, channel));
    candidate.fields.push_back(
        find_fields(words.back(), channel.data_bits, strays(layout, samples.size())));
    candidate.fields.back().channel.crc = channel.crc;
    candidate.format.channel_list[candidate.format.channel_count++] =
        candidate.fields.back().channel;
  }
  compare_with_catalogue(candidate, words, answers_on_cds(right));
  return candidate;
}

// The share of a layout among all, by one kind of score.
double share_of(const std::vector<Layout>& layouts, std::size_t which, double Layout::*score) {
  double others = 0;
  for (std::size_t i = 0; i < layouts.size(); ++i) {
    if (i == which) continue;
    others += std::pow(2.0, std::min(64.0, layouts[i].*score - layouts[which].*score));
  }
  const double wrong = others * std::pow(2.0, reserve_bits);
  return wrong < 0.5 ? 1 - wrong : 0.5 / (1 + others);
}

bool is_usual(const Layout& layout) {
  return std::all_of(layout.channels.begin(), layout.channels.end(), [](const ChannelLayout& each) {
    const CrcSpec usual{default_polynomial(each.crc.width_bits), 0, each.crc.width_bits, true};
    return each.crc.present() && each.crc == usual;
  });
}

// Another checksum hardly looks like a usual one. One that is not usual has to be shown without the
// help of what is likely.
double confidence_of(const std::vector<Layout>& layouts, std::size_t which) {
  if (is_usual(layouts[which])) return share_of(layouts, which, &Layout::score);
  return std::min(share_of(layouts, which, &Layout::score),
                  share_of(layouts, which, &Layout::evidence));
}

bool checksums_right(const FrameCodec<>& codec, const Sample& sample) {
  const FrameFormat& format = codec.format();
  if (sample.bits.size_bits() < format.payload_bits()) return false;
  std::size_t at = 0;
  for (std::size_t k = 0; k < format.channel_count; ++k) {
    const ChannelFormat& channel = format.channel_list[k];
    const std::uint64_t data = sample.bits.view().word(at, channel.data_bits);
    at += channel.data_bits;
    if (sample.bits.view().word(at, channel.crc.width_bits) !=
        (channel.crc.present() ? codec.crc(k, data, false) : 0)) {
      return false;
    }
    at += channel.crc.width_bits;
  }
  return true;
}

// Where the frame of this format ends, STOP is 0, as far as the sample goes.
bool stops(const FrameFormat& format, const Sample& sample) {
  const std::size_t end = format.payload_bits();
  return sample.bits.size_bits() <= end || !sample.bits.view()[end];
}

}  // namespace

bool FormatCandidate::has(Doubt doubt) const {
  return std::any_of(fields.begin(), fields.end(), [doubt](const Fields& each) {
    return std::find(each.doubts.begin(), each.doubts.end(), doubt) != each.doubts.end();
  });
}

const FormatCandidate* FormatFinding::sure() const {
  if (still || candidates.empty() || candidates.front().confidence < sure_confidence)
    return nullptr;
  return &candidates.front();
}

bool same_verdicts(const FrameFormat& a, const FrameFormat& b, std::span<const Sample> samples) {
  const FrameCodec<> codec_a(a);
  const FrameCodec<> codec_b(b);
  std::size_t right = 0;
  for (const Sample& sample : samples) {
    const bool in_a = checksums_right(codec_a, sample);
    const bool in_b = checksums_right(codec_b, sample);
    if ((in_a && stops(a, sample)) != (in_b && stops(b, sample))) return false;
    right += in_a ? 1U : 0U;
  }
  return right != 0;
}

FormatFinding find_format(std::span<const Sample> samples) {
  FormatFinding finding;
  const std::vector<Layout> layouts = find_layouts(samples, 16 * most_candidates);
  for (std::size_t i = 0; i < layouts.size() && i < most_candidates; ++i) {
    if (layouts[i].channels.front().data_bits == 0) continue;
    FormatCandidate candidate = candidate_of(samples, layouts[i]);
    candidate.confidence = confidence_of(layouts, i);
    const bool doubtful = std::any_of(candidate.fields.begin(), candidate.fields.end(),
                                      [](const Fields& each) { return !each.doubts.empty(); });
    const bool unchecked =
        std::any_of(layouts[i].channels.begin(), layouts[i].channels.end(),
                    [](const ChannelLayout& each) { return !each.crc.present(); });
    if (doubtful || unchecked) {
      candidate.confidence = std::min(candidate.confidence, doubtful_confidence);
    }
    finding.candidates.push_back(std::move(candidate));
  }
  finding.still = !finding.candidates.empty() &&
                  std::all_of(finding.candidates.front().fields.begin(),
                              finding.candidates.front().fields.end(),
                              [](const Fields& each) { return each.position_moved == 0; });
  return finding;
}

}  // namespace biss::identify
