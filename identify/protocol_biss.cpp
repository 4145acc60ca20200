// Judges whether the lines are BiSS C, by the structure and the checksum of the requests.
#include <fmt/format.h>

#include <cmath>

#include "biss/catalogue/catalogue.hpp"
#include "decode/decoder.hpp"
#include "decode/polarity.hpp"
#include "identify/checksum.hpp"
#include "identify/protocol_lines.hpp"

namespace biss::identify {

namespace {

using decode::Cycle;
using decode::Lines;

// Bits that agree by chance once in four thousand captures.
constexpr double certain_bits = 12;

// The whole requests of a pair of lines, read without a format.
std::vector<Cycle> read_requests(const Lines& lines, std::span<const wire::Edge> edges) {
  constexpr std::size_t fewest_clocks = 8;
  std::vector<Cycle> requests;
  DeviceTiming timing;
  timing.timeout = decode::find_paused_timeout(lines, edges).value_or(timing.timeout);
  decode::Decoder decoder(decode::CycleReader(std::nullopt, timing), [&](const Cycle& cycle) {
    if (!is_cut(cycle.status) && cycle.rising_edges >= fewest_clocks) requests.push_back(cycle);
  });
  decoder.push(edges, lines);
  decoder.finish(edges.empty() ? Picoseconds{} : edges.back().time);
  return requests;
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
  // The checksum of a type of the catalogue whose frame has just this length.
  constexpr double least_bits_of_a_type = 5;
  double bits = 0;
  for (const ChannelLayout& channel : layout.channels) {
    bits += channel.crc.width_bits * (1 + std::min(channel.rank, 3U));
  }
  // The frame of a type of the catalogue may end with its last clock.
  const bool exact = layout.end() + 1 >= length;
  return std::max(exact && bits >= least_bits_of_a_type ? certain_bits : bits, layout.score);
}

// The common structure of the good cycles.
struct Structure {
  // The bits after CDS in cycles with the usual delay and the usual ACK.
  std::vector<Sample> samples;
  FrameSet frames{{}, 0};
  // The share of the requests.
  double share = 0;
  std::int64_t clocks = 0;
  std::int64_t ack_clocks = 0;
  std::int64_t line_delay = 0;
  // SLO's release after the last edge of MA; 0 if it is not seen.
  std::int64_t release = 0;
  // The checksum that explains the frames best, and the bits for it.
  Layout checksum;
  double bits = 0;
};

// \param any_ack the length of ACK may change from request to request
Structure structure_of(const std::vector<Cycle>& requests, bool any_ack) {
  constexpr std::size_t enough_frames = 256;
  constexpr std::size_t most_tried = 16;
  std::vector<const Cycle*> alike;
  for (const Cycle& cycle : requests) {
    if (is_good(cycle.status) && cycle.ack && cycle.period && cycle.line_delay)
      alike.push_back(&cycle);
  }
  const auto all = [&](auto figure) {
    std::vector<std::int64_t> figures;
    for (const Cycle* cycle : alike) figures.push_back(figure(*cycle));
    return figures;
  };
  const auto ack_clocks = [](const Cycle& cycle) {
    return decode::periods_in(*cycle.ack, std::max(*cycle.period, picoseconds(1)));
  };
  Structure found;
  found.line_delay = median_of(all([](const Cycle& cycle) { return cycle.line_delay->count; }));
  found.ack_clocks = most_frequent(all(ack_clocks));
  const auto tolerance = median_of(all([](const Cycle& cycle) { return cycle.period->count; })) / 2;
  std::erase_if(alike, [&](const Cycle* cycle) {
    return std::abs(cycle->line_delay->count - found.line_delay) > tolerance ||
           (!any_ack && std::abs(ack_clocks(*cycle) - found.ack_clocks) > 1);
  });
  found.clocks = most_frequent(all([](const Cycle& cycle) { return cycle.rising_edges; }));
  found.share = share(alike.size(), requests.size());
  std::vector<std::int64_t> releases;
  for (const Cycle* cycle : alike) {
    if (cycle->release) releases.push_back(cycle->release->count);
    Sample& sample = found.samples.emplace_back();
    sample.cycle = found.samples.size() - 1;
    sample.time = cycle->time;
    sample.bits.append(cycle->raw.view().from(2));
  }
  found.release = median_of(releases);
  found.frames = FrameSet(found.samples, enough_frames);
  for (Layout& layout : find_layouts(found.frames, most_tried)) {
    if (!layout.checked() || layout.right_share < 0.6) continue;
    const double bits = agreeing_bits(layout, found.frames.length);
    if (bits <= found.bits) continue;
    found.bits = bits;
    found.checksum = std::move(layout);
  }
  return found;
}

// SSI with several words in a burst repeats its word.
bool repeats(const FrameSet& frames) {
  constexpr std::size_t overlap_min = 14;
  // First bits of 1 look like a line delay in clocks, and as many bits at the end no longer belong
  // to the word.
  constexpr std::size_t after_the_end = 6;
  for (std::size_t distance = 12; distance + overlap_min + after_the_end / 2 < frames.length;
       ++distance) {
    // Two words that are all zeros are not a repetition.
    bool varied = false;
    const double same = share_of(frames.patterns, [&](const FrameSet::Pattern& word) {
      const BitView view = word.sample->bits.view();
      bool alike = true;
      std::size_t changes = 0;
      for (std::size_t i = distance + 1; i + 1 < frames.length; ++i) {
        // The last bits of the word are not compared.
        alike = alike && (i + after_the_end >= frames.length || view[i] == view[i - distance]);
        changes += view[i] != view[i + 1] ? 1U : 0U;
      }
      varied = varied || changes >= 3;
      return alike;
    });
    if (varied && same >= 0.8) return true;
  }
  return false;
}

// The confidence that the words are BiSS C if no checksum proves it.
double confidence_of_structure(const Structure& structure, std::size_t pulses) {
  // More clocks than any SSI encoder sends: the longest word and its STOP.
  const bool long_for_ssi = pulses > 36;
  const bool bytes = pulses % 8 == 0;
  // The release fits the monoflop of an SSI encoder.
  const Picoseconds release{structure.release};
  const bool monoflop =
      release.count == 0 || (release > microseconds(8) && release < microseconds(40));
  return bytes || (monoflop && !long_for_ssi) ? 0.42 : 0.93;
}

BissTrial judge(const std::vector<Cycle>& requests, std::size_t pulses) {
  BissTrial trial;
  Structure structure = structure_of(requests, false);
  if (structure.share < 0.9) {
    // Without a checksum, an ACK that changes is not an ACK.
    Structure any = structure_of(requests, true);
    if (any.bits >= std::max(certain_bits, structure.bits)) structure = std::move(any);
  }
  const std::size_t alike = structure.samples.size();
  if (alike < 2 || structure.share < 0.4) return trial;
  const Layout& checksum = structure.checksum;
  const CrcSpec crc = checksum.channels.empty() ? CrcSpec{} : checksum.channels.front().crc;
  const bool certain = structure.bits >= certain_bits;
  const double clean = std::min(1.0, structure.share / 0.8);
  double confidence =
      certain ? 0.91 + 0.07 * clean : clean * confidence_of_structure(structure, pulses);
  // A clock in bytes that idles low, read from its second edge on.
  const bool one_less =
      pulses % 8 == 0 && structure.clocks + 1 == static_cast<std::int64_t>(pulses);
  const bool usual = certain && crc.polynomial == default_polynomial(crc.width_bits);
  if (one_less && !usual) confidence = std::min(confidence, 0.4);
  trial.repeats = repeats(structure.frames);
  if (trial.repeats) confidence = std::min(confidence, 0.2);
  trial.checked = certain && confidence >= 0.5;
  trial.guess.confidence = confidence * (alike < 8 ? 0.7 : 1);
  trial.guess.why = fmt::format(
      "{} of {} requests are answered in the same way: mostly {} clocks, ACK of {} clocks after "
      "{:.0f} ns; "
      "{}",
      alike, requests.size(), structure.clocks, structure.ack_clocks,
      static_cast<double>(structure.line_delay) / 1000,
      crc.present() ? fmt::format("a CRC of {} bits fits", crc.width_bits) : "no checksum seen");
  return trial;
}

}  // namespace

BissTrial try_biss(const Scene& scene) {
  constexpr std::size_t edges_of_a_trial = 12'000;
  BissTrial best;
  const decode::CycleReader reader(std::nullopt, {});
  for (const Trace& clock : scene.lines) {
    if (clock.clock.regular < damaged_clock_share || !clock.clock.pauses) continue;
    for (const Trace& data : scene.lines) {
      if (&clock == &data) continue;
      const Lines lines{clock.line, data.line};
      std::vector<wire::Edge> edges = decode::first_edges(lines, scene.edges);
      edges.resize(std::min(edges.size(), edges_of_a_trial));
      const BissTrial trial =
          judge(read_requests(decode::find_polarity(lines, edges, reader), edges),
                clock.clock.usual_pulses);
      if (trial.guess.confidence > best.guess.confidence) best = trial;
    }
  }
  return best;
}

}  // namespace biss::identify
