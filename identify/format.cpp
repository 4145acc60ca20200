#include "identify/format.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "biss/catalogue/catalogue.hpp"
#include "biss/frame/codec.hpp"
#include "biss/frame/decode.hpp"
#include "biss/safety/configurations.hpp"

namespace biss::identify {

namespace {

constexpr std::size_t most_frames = 640;
constexpr std::size_t most_layouts = 24;
constexpr std::size_t most_candidates = 5;
// Meanings of a channel that are followed.
constexpr std::size_t most_meanings = 6;

// ---- The account of the frames under one layout

// When each frame was requested, in requests, as far as the frames show it.
std::vector<double> requests_of(const FrameSet& frames) {
  const auto interval = [&](std::size_t i) {
    return static_cast<double>((frames.samples[i]->time - frames.samples[i - 1]->time).count);
  };
  std::vector<double> intervals;
  for (std::size_t i = 1; i < frames.samples.size(); ++i) {
    if (frames.before[i] != nullptr) intervals.push_back(interval(i));
  }
  const auto middle = intervals.begin() + static_cast<std::ptrdiff_t>(intervals.size() / 2);
  if (!intervals.empty()) std::nth_element(intervals.begin(), middle, intervals.end());
  std::vector<double> requests(frames.samples.size());
  for (std::size_t i = 1; i < requests.size(); ++i) {
    double step = static_cast<double>(frames.samples[i]->cycle - frames.samples[i - 1]->cycle);
    if (!intervals.empty() && *middle > 0) step = interval(i) / *middle;
    if (std::abs(step - std::round(step)) < 0.25) step = std::round(step);
    requests[i] = requests[i - 1] + std::max(step, 0.05);
  }
  return requests;
}

ChannelWords words_of(const FrameSet& frames, const Layout& layout, const ChannelLayout& channel) {
  ChannelWords words;
  for (std::size_t i = 0; i < frames.samples.size(); ++i) {
    if (!layout.right[i]) continue;
    words.data.push_back(frames.samples[i]->bits.view().word(channel.begin, channel.data_bits));
    words.cycles.push_back(frames.samples[i]->cycle);
  }
  return words;
}

// A complete account of the frames.
struct Hypothesis {
  std::size_t layout = 0;
  std::vector<Fields> fields;
  double cost = 0;
};

// Each channel has its most likely meaning, except one.
void add_hypotheses(std::size_t layout, double cost, const std::vector<std::vector<Fields>>& all,
                    std::vector<Hypothesis>& hypotheses) {
  Hypothesis best{layout, {}, cost};
  for (const auto& meanings : all) {
    best.fields.push_back(meanings.front());
    best.cost += meanings.front().cost;
  }
  hypotheses.push_back(best);
  for (std::size_t k = 0; k < all.size(); ++k) {
    for (std::size_t i = 1; i < std::min(all[k].size(), most_meanings); ++i) {
      Hypothesis other = best;
      other.fields[k] = all[k][i];
      other.cost += all[k][i].cost - all[k].front().cost;
      hypotheses.push_back(std::move(other));
    }
  }
}

double cost_of_any(const std::vector<Fields>& meanings) {
  std::vector<double> costs;
  for (const Fields& each : meanings) costs.push_back(each.cost);
  return identify::cost_of_any(costs);
}

// ---- The catalogue

std::uint64_t position_of(const ChannelFormat& channel) {
  return mask_of(channel.position) | mask_of(channel.multiturn) | mask_of(channel.singleturn);
}

// Both read these frames in the same way; a bit that has not moved may have another meaning.
bool fits(const ChannelFormat& known, const Fields& seen) {
  const auto same_flag = [&](const FlagField& a, const FlagField& b) {
    return ((mask_of(a) | mask_of(b)) & seen.moved) == 0 || a == b;
  };
  return known.data_bits == seen.channel.data_bits && known.crc == seen.channel.crc &&
         (seen.coding == Coding::binary) &&
         (position_of(known) & seen.moved) == seen.position_moved &&
         (mask_of(known.life_counter) & seen.moved) ==
             (mask_of(seen.channel.life_counter) & seen.moved) &&
         same_flag(known.error, seen.channel.error) &&
         same_flag(known.warning, seen.channel.warning);
}

// The same, and they read later flags in the same way too.
bool is_alike(const ChannelFormat& known, const Fields& seen) {
  return fits(known, seen) && known.error == seen.channel.error &&
         known.warning == seen.channel.warning && known.life_counter == seen.channel.life_counter &&
         std::countr_zero(position_of(known)) == std::countr_zero(position_of(seen.channel));
}

// The encoder answers on CDS. It does so only if the master requests it, and then with two ones or
// more; other ones are damage, as long as they are rare.
bool answers_on_cds(const FrameSet& frames, const Layout& layout) {
  constexpr double most_damage = 0.1;
  std::size_t ones = 0;
  std::size_t answers = 0;
  for (std::size_t i = 0; i < frames.samples.size(); ++i) {
    if (!layout.right[i] || !frames.samples[i]->cds) continue;
    ++ones;
    answers += frames.samples[i]->asked ? 1U : 0U;
  }
  return answers >= 2 ||
         static_cast<double>(ones) > most_damage * static_cast<double>(frames.samples.size());
}

// Adds the names of the encoders. If an encoder reads the frames in the same way, its format gives
// the names of the bits.
void compare_with_catalogue(FormatCandidate& candidate, bool cds) {
  struct Known {
    FrameFormat format;
    bool alike = false;
    std::vector<std::string_view> names;
  };
  std::vector<Known> all;
  const auto all_channels = [&](const FrameFormat& format, const auto& test) {
    const auto channels = format.channels();
    return std::equal(channels.begin(), channels.end(), candidate.fields.begin(),
                      candidate.fields.end(), test);
  };
  const auto add = [&](const FrameFormat& format, std::string_view name) {
    if ((format.cds0 && cds) || !all_channels(format, fits)) return;
    auto same = std::find_if(all.begin(), all.end(),
                             [&](const Known& each) { return each.format == format; });
    if (same == all.end()) {
      same = all.insert(same, {format, all_channels(format, is_alike), {}});
    }
    same->names.push_back(name);
  };
  for (const CatalogueEntry& entry : catalogue) add(entry.frame_format(), entry.name);
  for (const SafetyConfiguration& each : safety_configurations) {
    if (find_encoder(each.name) == nullptr) add(each.frame_format(), each.name);
  }
  std::stable_sort(all.begin(), all.end(), [](const Known& a, const Known& b) {
    return std::pair(a.alike, a.names.size()) > std::pair(b.alike, b.names.size());
  });
  if (!all.empty() && all.front().alike) candidate.format = all.front().format;
  for (const Known& each : all) {
    if (each.format != candidate.format) candidate.equal.push_back(each.format);
    if (!each.alike) continue;
    candidate.encoders.insert(candidate.encoders.end(), each.names.begin(), each.names.end());
  }
}

FormatCandidate candidate_of(Hypothesis& hypothesis, const Layout& layout, const FrameSet& frames) {
  FormatCandidate candidate;
  candidate.layout = layout;
  candidate.fields = std::move(hypothesis.fields);
  for (std::size_t k = 0; k < layout.channels.size(); ++k) {
    ChannelFormat& channel = candidate.fields[k].channel;
    channel.crc = layout.channels[k].crc;
    candidate.format.channel_list[candidate.format.channel_count++] = channel;
  }
  compare_with_catalogue(candidate, answers_on_cds(frames, layout));
  return candidate;
}

// The checksums and STOP are right.
bool reads(const FrameCodec<>& codec, const Sample& sample) {
  BitBuffer<max_payload_bits + 3> raw;
  raw.append(true);
  raw.append(sample.cds);
  raw.append(sample.bits.view());
  return decode_payload(raw.view(), FrameStart{0, 1, 1}, codec).ok();
}

// The format is certain, and reads more than half of these frames.
bool reads_most(const FormatFinding& finding, std::span<const Sample> samples) {
  if (finding.sure() == nullptr) return false;
  const FrameCodec<> codec(finding.sure()->format);
  const auto read = std::count_if(samples.begin(), samples.end(),
                                  [&](const Sample& each) { return reads(codec, each); });
  return 2 * static_cast<std::size_t>(read) > samples.size();
}

}  // namespace

const FormatCandidate* FormatFinding::sure() const {
  if (still || candidates.empty() || candidates.front().confidence < sure_confidence)
    return nullptr;
  return &candidates.front();
}

bool same_verdicts(FrameFormat a, FrameFormat b, std::span<const Sample> samples) {
  a.cds0 = b.cds0 = false;
  const FrameCodec<> codec_a(a);
  const FrameCodec<> codec_b(b);
  std::size_t right = 0;
  for (const Sample& sample : samples) {
    const bool in_a = reads(codec_a, sample);
    if (in_a != reads(codec_b, sample)) return false;
    right += in_a ? 1U : 0U;
  }
  return right != 0;
}

FormatFinding find_format(std::span<const Sample> samples) {
  FormatFinding finding;
  const FrameSet frames(samples, most_frames);
  const std::vector<Layout> layouts = find_layouts(frames, most_layouts);
  const std::vector<double> requests = requests_of(frames);
  std::vector<Hypothesis> hypotheses;
  // The costs of all layouts, and for each layout the cost that its checksum fits by chance.
  std::vector<double> costs;
  for (std::size_t i = 0; i < layouts.size(); ++i) {
    const Layout& layout = layouts[i];
    std::vector<double> right_requests;
    for (std::size_t k = 0; k < requests.size(); ++k) {
      if (layout.right[k]) right_requests.push_back(requests[k]);
    }
    const Timeline timeline(right_requests);
    std::vector<std::vector<Fields>> meanings;
    double cost = layout.cost;
    for (const ChannelLayout& channel : layout.channels) {
      meanings.push_back(find_fields(words_of(frames, layout, channel), timeline, channel));
      if (meanings.back().empty()) break;
      cost += cost_of_any(meanings.back());
    }
    if (meanings.back().empty()) continue;
    costs.push_back(cost);
    if (layout.unknown > 0) costs.push_back(cost - std::log2(layout.unknown));
    add_hypotheses(i, layout.cost, meanings, hypotheses);
  }
  std::stable_sort(hypotheses.begin(), hypotheses.end(),
                   [&](const Hypothesis& a, const Hypothesis& b) {
                     const bool a_checked = layouts[a.layout].checked();
                     const bool b_checked = layouts[b.layout].checked();
                     return a_checked != b_checked ? a_checked : a.cost < b.cost;
                   });
  for (Hypothesis& each : hypotheses) {
    if (finding.candidates.size() == most_candidates) break;
    const Layout& layout = layouts[each.layout];
    // Without a checksum nothing is known.
    const double share = std::exp2(identify::cost_of_any(costs) - each.cost);
    finding.candidates.push_back(candidate_of(each, layout, frames));
    finding.candidates.back().confidence = layout.checked() ? share : 0;
  }
  finding.still = !finding.candidates.empty() &&
                  std::all_of(finding.candidates.front().fields.begin(),
                              finding.candidates.front().fields.end(),
                              [](const Fields& each) { return each.position_moved == 0; });
  return finding;
}

std::vector<FormatPart> find_parts(std::span<const Sample> samples) {
  constexpr std::size_t least_frames = 8;
  constexpr std::size_t least_bits = 9;
  constexpr std::size_t most_parts = 8;
  std::map<std::size_t, std::size_t> lengths;
  for (const Sample& sample : samples) ++lengths[sample.bits.size_bits()];
  struct Run {
    std::size_t first = 0;
    std::size_t last = 0;
    std::size_t frames() const { return last - first + 1; }
  };
  const auto frames_of = [&](const Run& run) { return samples.subspan(run.first, run.frames()); };
  const auto bits_of = [&](const Run& run) { return samples[run.last].bits.size_bits(); };
  std::vector<Run> runs;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const std::size_t bits = samples[i].bits.size_bits();
    const std::size_t frames = lengths[bits];
    if (bits < least_bits || frames < least_frames || 20 * frames < samples.size()) continue;
    if (runs.empty() || bits_of(runs.back()) != bits) runs.push_back({i, i});
    runs.back().last = i;
  }
  // A few frames of a different length are damaged ones.
  std::size_t stray = 0;
  std::vector<Run> long_runs;
  for (const Run& run : runs) {
    if (run.frames() < least_frames) {
      stray += run.frames();
    } else if (!long_runs.empty() && bits_of(long_runs.back()) == bits_of(run)) {
      long_runs.back().last = run.last;
    } else {
      long_runs.push_back(run);
    }
  }
  const bool parted =
      long_runs.size() > 1 && long_runs.size() <= most_parts && 20 * stray <= samples.size();
  std::vector<FormatPart> parts;
  if (!parted) long_runs.assign(samples.empty() ? 0 : 1, {0, samples.size() - 1});
  for (const Run& run : long_runs) {
    FormatPart part{samples[run.first].cycle, samples[run.last].cycle,
                    static_cast<unsigned>(bits_of(run)), find_format(frames_of(run))};
    // A format that reads the frames of its neighbour as well has not changed.
    if (!parts.empty() && reads_most(parts.back().finding, frames_of(run))) {
      parts.back().to_cycle = part.to_cycle;
    } else if (!parts.empty() && reads_most(part.finding, frames_of((&run)[-1]))) {
      part.from_cycle = parts.back().from_cycle;
      parts.back() = std::move(part);
    } else {
      parts.push_back(std::move(part));
    }
  }
  return parts;
}

}  // namespace biss::identify
