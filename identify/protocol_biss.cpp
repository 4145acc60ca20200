#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string_view>

#include "biss/catalogue/catalogue.hpp"
#include "biss/frame/codec.hpp"
#include "biss/frame/decode.hpp"
#include "decode/decoder.hpp"
#include "decode/polarity.hpp"
#include "identify/checksum.hpp"
#include "identify/protocol_checksum.hpp"
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
  decode::Decoder decoder(decode::CycleReader(std::nullopt, {}), [&](const Cycle& cycle) {
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
  // START to the last clock, of the usual length.
  std::vector<decode::RawBits> frames;
  // The same of any length, without START and CDS.
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
  std::map<std::size_t, std::size_t> lengths;
  for (const Cycle& cycle : cycles.requests) {
    if (!decode::is_good(cycle.status) || !cycle.ack || !cycle.period || !cycle.line_delay)
      continue;
    delays.push_back(static_cast<double>(cycle.line_delay->count));
    periods.push_back(static_cast<double>(cycle.period->count));
    ++acks[clocks_of_ack(cycle)];
    ++lengths[cycle.raw.view().size_bits()];
  }
  if (delays.empty()) return found;
  found.line_delay = median_of(delays);
  found.period = median_of(periods);
  found.ack_clocks = most_frequent(acks);
  const std::size_t usual_length = most_frequent(lengths);
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
    if (cycle.raw.view().size_bits() == usual_length) found.frames.push_back(cycle.raw);
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

// The bits after START, each word once.
std::vector<Word> distinct_words(const Structure& structure, std::size_t& bits) {
  std::vector<Word> words;
  std::set<Word> seen;
  for (const decode::RawBits& raw : structure.frames) {
    const BitView view = raw.view();
    if (view.size_bits() < 2 || view.size_bits() > word_bits_max) continue;
    bits = view.size_bits() - 2;
    Word word{};
    for (std::size_t i = 2; i < view.size_bits(); ++i) append(word, view[i]);
    if (seen.insert(word).second) words.push_back(word);
  }
  return words;
}

// The catalogue's formats that read nearly every frame, and how surely that is no chance.
struct CatalogueFit {
  std::string_view name;
  double bits = 0;
  // No clock follows STOP.
  bool exact = false;
};

// The part of a frame from CDS to STOP, as a word.
Word payload_of(BitView raw, std::size_t payload_bits) {
  Word word{};
  for (std::size_t i = 1; i < payload_bits && i < word_bits_max; ++i) append(word, raw[i]);
  return word;
}

// STOP is 0, and so is everything after it.
bool rests_low(BitView raw, std::size_t payload_bits) {
  return raw.find(true, payload_bits - 1) == raw.size_bits();
}

CatalogueFit fit_of(const Structure& structure, const CatalogueEntry& entry) {
  const FrameCodec<> codec(entry.frame_format());
  const std::size_t payload_bits = codec.payload_bits() + 3U;
  const std::size_t received = structure.frames.front().view().size_bits();
  if (payload_bits > received || received > payload_bits + 16) return {};
  unsigned width_bits = 0;
  for (const ChannelFormat& channel : codec.format().channels()) {
    width_bits += channel.crc.width_bits;
  }
  std::vector<Word> good;
  for (const decode::RawBits& raw : structure.frames) {
    const BitView view = raw.view();
    const bool fits =
        rests_low(view, payload_bits) && decode_payload(view, FrameStart{0, 1, 1}, codec).ok();
    if (fits) good.push_back(payload_of(view, payload_bits));
  }
  if (10 * good.size() < 6 * structure.frames.size()) return {};
  const double rank = std::min(3.0, static_cast<double>(rank_of_differences(good)));
  return {entry.name, width_bits * (1 + rank), payload_bits == received};
}

CatalogueFit best_of_catalogue(const Structure& structure) {
  CatalogueFit best;
  std::set<std::string_view> tried;
  for (const CatalogueEntry& entry : catalogue) {
    if (structure.frames.empty() || !tried.insert(entry.format).second) continue;
    const CatalogueFit fit = fit_of(structure, entry);
    if (fit.bits > best.bits) best = fit;
  }
  return best;
}

// SSI with several words in a burst repeats its word.
bool repeats(const std::vector<Word>& words, std::size_t bits) {
  const auto bit = [](const Word& word, std::size_t at) {
    return word.has(static_cast<unsigned>(at));
  };
  // Two words of nothing but zeros are no repetition.
  const auto changes = [&](const Word& word, std::size_t count) {
    std::size_t found = 0;
    for (std::size_t i = 1; i < count; ++i) found += bit(word, i) != bit(word, i - 1) ? 1U : 0U;
    return found;
  };
  constexpr std::size_t overlap_min = 14;
  // A first bit of 1 looks like a line delay of a clock, and as many bits at the end are no longer
  // of the word.
  constexpr std::size_t after_the_end = 6;
  for (std::size_t distance = 12; distance + overlap_min + after_the_end / 2 < bits; ++distance) {
    const std::size_t overlap = bits - distance - 1;
    const auto same = std::count_if(words.begin(), words.end(), [&](const Word& word) {
      for (std::size_t i = after_the_end; i < overlap; ++i) {
        if (bit(word, i) != bit(word, i + distance)) return false;
      }
      return true;
    });
    const bool varied = std::any_of(words.begin(), words.end(),
                                    [&](const Word& word) { return changes(word, overlap) >= 3; });
    if (varied && 10 * static_cast<std::size_t>(same) >= 8 * words.size()) return true;
  }
  return false;
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
  if (rank >= 8) return too_long && structure.share > 0.95 && structure.alike >= 20 ? 0.7 : 0.3;
  if (may_be_ssi(pulses, structure.release) || pulses % 8 == 0) return 0.42;
  return 0.93;
}

// The checksum that explains the frames best, by how many bits it is better than chance.
Layout best_layout(const Structure& structure) {
  constexpr std::size_t enough_frames = 256;
  constexpr double least_right = 0.6;
  Layout best;
  if (structure.alike < 2) return best;
  for (Layout& layout : find_layouts(FrameSet(structure.samples, enough_frames), 4)) {
    const bool fits = layout.checked() && layout.right_share >= least_right;
    if (fits && layout.score > best.score) best = std::move(layout);
  }
  return best;
}

BissTrial judge(const Cycles& cycles, std::size_t pulses) {
  BissTrial trial;
  trial.guess.protocol = Protocol::biss_c;
  trial.guess.clock = cycles.lines.ma;
  trial.guess.data = cycles.lines.slo;
  trial.guess.has_clock = true;
  Structure structure = structure_of(cycles, false);
  Layout checksum = best_layout(structure);
  if (checksum.score < certain_bits && structure.share < 0.9) {
    // Without a checksum, an ACK that changes is no ACK.
    Structure any = structure_of(cycles, true);
    Layout other = best_layout(any);
    if (other.score >= certain_bits) {
      structure = std::move(any);
      checksum = std::move(other);
    }
  }
  if (structure.alike < 2 || structure.share < 0.4) return trial;
  std::size_t bits = 0;
  const std::vector<Word> words = distinct_words(structure, bits);
  std::string evidence = "no checksum seen";
  bool certain = checksum.score >= certain_bits;
  if (!checksum.channels.empty()) {
    evidence = fmt::format("a CRC of {} bits fits", checksum.channels.front().crc.width_bits);
  }
  const CatalogueFit fit = best_of_catalogue(structure);
  trial.of_catalogue = fit.bits != 0;
  if (!certain) {
    if (trial.of_catalogue) evidence = fmt::format("the checksums of {} fit", fit.name);
    certain = fit.bits >= certain_bits || (fit.exact && fit.bits >= least_bits_of_a_type);
  }
  const double few = structure.alike < 8 ? 0.7 : 1;
  const double clean = std::min(1.0, structure.share / 0.8);
  double confidence = 0;
  if (certain) {
    trial.evidence = BissEvidence::checksum;
    confidence = 0.91 + 0.07 * clean;
  } else {
    trial.evidence = BissEvidence::structure;
    confidence = clean * confidence_of_structure(structure, pulses, rank_of_differences(words));
  }
  // CDS is 1 only now and then; the inverse of another protocol has it always.
  if (structure.cds_share > 0.95) confidence = std::min(confidence, 0.25);
  // A clock in bytes that idles low, read from its second edge on.
  const bool one_less = pulses % 8 == 0 && structure.clocks + 1U == pulses;
  if (one_less) confidence = std::min(confidence, 0.4);
  if (repeats(words, bits)) confidence = std::min(confidence, 0.2);
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
