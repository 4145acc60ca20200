#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "biss/catalogue/catalogue.hpp"
#include "decode/decoder.hpp"
#include "decode/polarity.hpp"
#include "identify/checksum.hpp"
#include "identify/protocol_trials.hpp"

namespace biss::identify {

namespace {

using decode::Cycle;
using decode::Lines;

constexpr std::size_t edges_of_a_trial = 12'000;
constexpr std::size_t fewest_clocks = 8;
// Of clocks or pauses between clocks, what no SSI encoder sends: the longest word and its STOP.
constexpr std::uint32_t longest_ssi_clocks = 36;
// Bits that agree by chance once in four thousand captures.
constexpr double certain_bits = 12;
// The checksum of a type of the catalogue whose frame has just this length.
constexpr double least_bits_of_a_type = 5;

// The cycles of a pair of lines, read without a format.
struct Cycles {
  Lines lines;
  std::vector<Cycle> requests;
  std::size_t answered = 0;
};

Cycles read_cycles(const Lines& lines, std::span<const wire::Edge> edges) {
  Cycles cycles{.lines = lines, .requests = {}};
  DeviceTiming timing;
  timing.timeout = decode::find_paused_timeout(lines, edges).value_or(timing.timeout);
  decode::Decoder decoder(decode::CycleReader(std::nullopt, timing), [&](const Cycle& cycle) {
    const bool cut = cycle.status == decode::CycleStatus::cut_start ||
                     cycle.status == decode::CycleStatus::cut_end;
    if (cut || cycle.rising_edges < fewest_clocks) return;
    cycles.requests.push_back(cycle);
    if (decode::is_good(cycle.status)) ++cycles.answered;
  });
  decoder.push(edges, lines);
  decoder.finish(edges.empty() ? Picoseconds{} : edges.back().time);
  return cycles;
}

template <class Key>
Key most_frequent(const std::map<Key, std::size_t>& counts) {
  const auto most =
      std::max_element(counts.begin(), counts.end(),
                       [](const auto& a, const auto& b) { return a.second < b.second; });
  return most == counts.end() ? Key{} : most->first;
}

// What the good cycles have in common.
struct Structure {
  // Share of the requests that are answered with the usual delay and the usual ACK.
  double share = 0;
  std::size_t alike = 0;
  std::uint32_t clocks = 0;
  std::int64_t ack_clocks = 0;
  double period = 0;
  double line_delay = 0;
  // SLO's release after the last edge of MA; 0 where it is not seen.
  double release = 0;
  // Share of the frames with CDS 1.
  double cds_share = 0;
  // After CDS.
  std::vector<Sample> samples;
};

std::int64_t clocks_of_ack(const Cycle& cycle) {
  return (cycle.ack->count + cycle.period->count / 2) /
         std::max<std::int64_t>(cycle.period->count, 1);
}

// \param any_ack the length of ACK may change from request to request
Structure structure_of(const Cycles& cycles, bool any_ack) {
  Structure found;
  std::vector<double> delays;
  std::vector<double> periods;
  std::map<std::int64_t, std::size_t> acks;
  for (const Cycle& cycle : cycles.requests) {
    if (!decode::is_good(cycle.status) || !cycle.ack || !cycle.period || !cycle.line_delay)
      continue;
    delays.push_back(static_cast<double>(cycle.line_delay->count));
    periods.push_back(static_cast<double>(cycle.period->count));
    ++acks[clocks_of_ack(cycle)];
  }
  if (delays.empty()) return found;
  found.line_delay = median_of(delays);
  found.period = median_of(periods);
  found.ack_clocks = most_frequent(acks);
  std::map<std::uint32_t, std::size_t> clocks;
  std::vector<double> releases;
  double cds = 0;
  for (const Cycle& cycle : cycles.requests) {
    if (!decode::is_good(cycle.status) || !cycle.ack || !cycle.period || !cycle.line_delay)
      continue;
    const double delay = static_cast<double>(cycle.line_delay->count);
    if (std::abs(delay - found.line_delay) > 0.5 * found.period) continue;
    if (!any_ack && std::abs(clocks_of_ack(cycle) - found.ack_clocks) > 1) continue;
    ++found.alike;
    ++clocks[cycle.rising_edges];
    if (cycle.release) releases.push_back(static_cast<double>(cycle.release->count));
    cds += cycle.cds().value_or(false) ? 1 : 0;
    Sample sample{.cycle = found.samples.size(), .time = cycle.time, .cds = false, .bits = {}};
    if (cycle.raw.view().size_bits() > 2) sample.bits.append(cycle.raw.view().from(2));
    found.samples.push_back(sample);
  }
  found.clocks = most_frequent(clocks);
  found.release = median_of(releases);
  found.cds_share = found.alike == 0 ? 0 : cds / static_cast<double>(found.alike);
  found.share = static_cast<double>(found.alike) / static_cast<double>(cycles.requests.size());
  return found;
}

// SSI with several words in a burst repeats its word.
bool repeats(const std::vector<FrameSet::Pattern>& words, std::size_t bits) {
  constexpr std::size_t overlap_min = 14;
  // A first bit of 1 looks like a line delay of a clock, and as many bits at the end are no longer
  // of the word.
  constexpr std::size_t after_the_end = 6;
  for (std::size_t distance = 12; distance + overlap_min + after_the_end / 2 < bits; ++distance) {
    // The last bits of the word are not compared.
    const std::size_t begin = distance + 1;
    std::size_t same = 0;
    bool varied = false;
    for (const FrameSet::Pattern& word : words) {
      const BitView view = word.sample->bits.view();
      bool alike = true;
      std::size_t changes = 0;
      for (std::size_t i = begin; i + after_the_end < bits; ++i) {
        alike = alike && view[i] == view[i - distance];
      }
      for (std::size_t i = begin; i + 1 < bits; ++i) changes += view[i] != view[i + 1] ? 1U : 0U;
      same += alike ? 1U : 0U;
      // Two words of nothing but zeros are no repetition.
      varied = varied || changes >= 3;
    }
    if (varied && 10 * same >= 8 * words.size()) return true;
  }
  return false;
}

// Bits that change independently of each other.
std::size_t rank_of(const FrameSet& frames) {
  Basis basis;
  const Span bits{0, std::min(frames.length, 127U)};
  for (const FrameSet::Pattern& each : frames.patterns) {
    basis.add(polynomial_of(*each.sample, bits) ^ polynomial_of(*frames.patterns[0].sample, bits));
  }
  return basis.rank();
}

// What words of this many clocks, released after this time, may be as well.
bool may_be_ssi(std::size_t pulses, double release) {
  constexpr double microsecond = 1e6;
  const bool monoflop = release == 0 || (release > 8 * microsecond && release < 40 * microsecond);
  return pulses <= longest_ssi_clocks && monoflop;
}

// How sure the words are those of BiSS C where no checksum says so.
double confidence_of_structure(const Structure& structure, std::size_t pulses, std::size_t rank) {
  // Much has moved and no checksum with it.
  const bool too_long = pulses > longest_ssi_clocks && pulses % 8 != 0;
  if (rank >= 8) return too_long && structure.share > 0.95 && structure.alike >= 20 ? 0.45 : 0.3;
  if (may_be_ssi(pulses, structure.release) || pulses % 8 == 0) return 0.42;
  return 0.93;
}

// An encoder of the catalogue has these channels.
bool is_known(const Layout& layout) {
  return std::any_of(catalogue.begin(), catalogue.end(), [&](const CatalogueEntry& entry) {
    const FrameFormat format = entry.frame_format();
    const auto channels = format.channels();
    return std::equal(channels.begin(), channels.end(), layout.channels.begin(),
                      layout.channels.end(), [](const auto& known, const auto& seen) {
                        return known.data_bits == seen.data_bits && known.crc == seen.crc;
                      });
  });
}

// The bits of a layout's checksums that agree: of a type of the catalogue in the frames that differ
// and in the first one, else those that are more than chance.
double agreeing_bits(const Layout& layout, unsigned length) {
  if (!is_known(layout)) return layout.score;
  constexpr std::size_t most = 3;
  double bits = 0;
  for (const ChannelLayout& channel : layout.channels) {
    const auto frames = static_cast<double>(1 + std::min<std::size_t>(channel.rank, most));
    bits += channel.crc.width_bits * frames;
  }
  // The frame of a type of the catalogue may end with its last clock.
  const bool exact = layout.end() + 1 >= length;
  return std::max(exact && bits >= least_bits_of_a_type ? certain_bits : bits, layout.score);
}

// The checksum that explains the frames best, and the bits for it.
std::pair<Layout, double> best_layout(const FrameSet& frames) {
  constexpr double least_right = 0.6;
  constexpr std::size_t most_tried = 16;
  std::pair<Layout, double> best;
  for (Layout& layout : find_layouts(frames, most_tried)) {
    if (!layout.checked() || layout.right_share < least_right) continue;
    const double bits = agreeing_bits(layout, frames.length);
    if (bits > best.second) best = {std::move(layout), bits};
  }
  return best;
}

BissTrial judge(const Cycles& cycles, std::size_t pulses) {
  constexpr std::size_t enough_frames = 256;
  BissTrial trial;
  trial.guess.protocol = Protocol::biss_c;
  trial.guess.clock = cycles.lines.ma;
  trial.guess.data = cycles.lines.slo;
  trial.guess.has_clock = true;
  Structure structure = structure_of(cycles, false);
  FrameSet frames(structure.samples, enough_frames);
  auto [checksum, bits] = best_layout(frames);
  if (structure.share < 0.9) {
    // Without a checksum, an ACK that changes is no ACK.
    Structure any = structure_of(cycles, true);
    FrameSet other_frames(any.samples, enough_frames);
    auto [other, other_bits] = best_layout(other_frames);
    if (other_bits >= std::max(certain_bits, bits)) {
      structure = std::move(any);
      frames = std::move(other_frames);
      checksum = std::move(other);
      bits = other_bits;
    }
  }
  if (structure.alike < 2 || structure.share < 0.4) return trial;
  trial.of_catalogue = is_known(checksum);
  const bool certain = bits >= certain_bits;
  const std::string evidence =
      checksum.channels.empty()
          ? "no checksum seen"
          : fmt::format("a CRC of {} bits fits", checksum.channels.front().crc.width_bits);
  const double few = structure.alike < 8 ? 0.7 : 1;
  const double clean = std::min(1.0, structure.share / 0.8);
  double confidence = 0;
  if (certain) {
    trial.evidence = BissEvidence::checksum;
    confidence = 0.91 + 0.07 * clean;
  } else {
    trial.evidence = BissEvidence::structure;
    confidence = clean * confidence_of_structure(structure, pulses, rank_of(frames));
  }
  // CDS is 1 only now and then; the inverse of another protocol has it always.
  if (structure.cds_share > 0.95) confidence = std::min(confidence, 0.25);
  // A clock in bytes that idles low, read from its second edge on.
  const bool one_less = pulses % 8 == 0 && structure.clocks + 1U == pulses;
  const bool usual = certain && checksum.channels.front().crc.polynomial ==
                                    default_polynomial(checksum.channels.front().crc.width_bits);
  if (one_less && !usual) confidence = std::min(confidence, 0.4);
  if (repeats(frames.patterns, frames.length)) confidence = std::min(confidence, 0.2);
  if (confidence < 0.5) trial.evidence = BissEvidence::structure;
  trial.guess.confidence = confidence * few;
  trial.guess.why = fmt::format(
      "{} of {} requests are answered alike: {} clocks, ACK of {} clocks after {:.0f} ns; {}",
      structure.alike, cycles.requests.size(), structure.clocks, structure.ack_clocks,
      structure.line_delay / 1000, evidence);
  return trial;
}

std::vector<wire::Edge> edges_of(const Lines& lines, std::span<const wire::Edge> edges) {
  std::vector<wire::Edge> pair;
  for (const wire::Edge& edge : edges) {
    if (edge.line != lines.ma && edge.line != lines.slo) continue;
    pair.push_back(edge);
    if (pair.size() == edges_of_a_trial) break;
  }
  return pair;
}

}  // namespace

BissTrial try_biss(const Scene& scene) {
  BissTrial best;
  best.guess.protocol = Protocol::biss_c;
  const decode::CycleReader reader(std::nullopt, {});
  for (std::size_t c = 0; c < scene.traces.size(); ++c) {
    if (scene.clocks[c].regular < damaged_clock_share || !scene.clocks[c].pauses) continue;
    for (std::size_t d = 0; d < scene.traces.size(); ++d) {
      if (c == d) continue;
      const Lines lines{scene.traces[c].line, scene.traces[d].line};
      const std::vector<wire::Edge> edges = edges_of(lines, scene.edges);
      const BissTrial trial = judge(read_cycles(decode::find_polarity(lines, edges, reader), edges),
                                    usual_pulses(scene.clocks[c].bursts));
      if (trial.guess.confidence > best.guess.confidence) best = trial;
    }
  }
  return best;
}

}  // namespace biss::identify
