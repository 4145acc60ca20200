// Valid captures as seeds: request cycles of BiSS frames with a good CRC, some of them damaged.
#pragma once

#include "biss/base/units.hpp"
#include "biss/frame/encode.hpp"
#include "biss/frame/format_text.hpp"
#include "capture/bytes.hpp"
#include "capture/dsl.hpp"
#include "capture/event_csv.hpp"
#include "capture/little_endian.hpp"
#include "capture/saleae_binary.hpp"
#include "capture/samples.hpp"
#include "capture/sr.hpp"
#include "capture/test_compressed.hpp"
#include "capture/test_fst.hpp"
#include "capture/test_scope.hpp"
#include "capture/vcd.hpp"
#include "fuzz/mutate.hpp"
#include "wire/edge.hpp"

namespace biss::fuzz {

/// The format that the cycles of fuzzed captures are read with: short, so that many captures are
/// read in a second.
inline constexpr std::string_view capture_format = "pos5,nE,nW,crc4";

/// The levels of SLO in a request cycle. Every fourth seed has another format than the one that
/// cycles are read with, every eighth a damaged bit.
inline FrameBits frame_bits(std::uint64_t seed, SplitMix& random) {
  static constexpr std::array<std::string_view, 3> others{"pos1,crc3", "pos8", "pos12,nE,nW,crc6"};
  const auto text = seed % 4 == 3 ? others[random() % others.size()] : capture_format;
  const PlainCodec codec(*parse_format(text));
  Frame frame;
  frame.channel_count = 1;
  frame.lead_clocks = 1;
  frame.ack_clocks = static_cast<std::uint16_t>(1 + random() % 4);
  frame.channel_list[0].position =
      random() & low_mask(codec.format().channel_list[0].position_bits());
  FrameBits bits = *encode_frame(frame, codec);
  if (seed % 8 == 5) bits.flip(1 + random() % (bits.size_bits() - 1));
  return bits;
}

/// Half a clock period of the cycles of this seed, in steps of 50 ns.
inline std::uint32_t half_period_steps(std::uint64_t seed) {
  return 1U + static_cast<std::uint32_t>(SplitMix{seed}() % 10);
}

/// Edges of `cycles` request cycles: MA is line 0, SLO is line 1. Clock, line delay, ACK and
/// position follow from `seed`. Edges come in time order.
inline std::vector<wire::Edge> cycle_edges(std::uint64_t seed, unsigned cycles) {
  SplitMix random{~seed};
  const Picoseconds half = nanoseconds(50) * static_cast<std::int64_t>(half_period_steps(seed));
  const Picoseconds delay = half * static_cast<std::int64_t>(random() % 5) + nanoseconds(5);
  std::vector<wire::Edge> edges{{{}, 0, wire::Level::high}, {{}, 1, wire::Level::high}};
  Picoseconds now = 6 * half;
  for (unsigned cycle = 0; cycle < cycles; ++cycle) {
    const FrameBits bits = frame_bits(seed, random);
    for (std::size_t i = 0; i < bits.size_bits(); ++i) {
      const bool bit = bits.view()[i];
      edges.push_back({now, 0, wire::Level::low});
      edges.push_back({now + half, 0, wire::Level::high});
      if (i != 0 && bit != bits.view()[i - 1]) {
        edges.push_back({now + half + delay, 1, bit ? wire::Level::high : wire::Level::low});
      }
      now += 2 * half;
    }
    edges.push_back({now + delay + 4 * half, 1, wire::Level::high});
    now += delay + 8 * half;
  }
  std::stable_sort(edges.begin(), edges.end(),
                   [](const wire::Edge& a, const wire::Edge& b) { return a.time < b.time; });
  return edges;
}

/// The cycles of most seeds: one, two or three.
inline unsigned cycles_of(std::uint64_t seed) {
  return seed % 8 == 2 ? 3 : 1 + static_cast<unsigned>(seed % 2);
}

/// A capture of one to three cycles, written by a writer of capture/. `make` creates the writer
/// from the names of the lines and the sink.
template <class MakeWriter>
std::string seed_capture(std::uint64_t seed, MakeWriter make) {
  std::string text;
  capture::StringSink sink(text);
  auto writer = make(std::vector<std::string>{"MA", "SLO"}, sink);
  const std::vector<wire::Edge> edges = cycle_edges(seed, cycles_of(seed));
  if (!writer.write(edges).ok() || !writer.finish(edges.back().time).ok()) return {};
  return text;
}

template <class Writer>
std::string seed_text(std::uint64_t seed) {
  return seed_capture(seed, [](auto names, auto& sink) { return Writer(std::move(names), sink); });
}

/// The same in the dialect of Saleae Logic.
inline std::string saleae_seed(std::uint64_t seed) {
  return seed_capture(seed, [](auto names, auto& sink) {
    return capture::EventCsvWriter(std::move(names), sink, capture::CsvDialect::saleae);
  });
}

/// Enough samples to separate both halves of a clock, few enough for many executions per second.
/// The sample rate divides the clock for some seeds and does not for others.
inline capture::RawLayout sampled_layout(std::uint64_t seed) {
  const Hertz rate{(seed % 2 == 0 ? 60'000'000U : 73'000'000U) / half_period_steps(seed)};
  return capture::packed_layout({"MA", "SLO"}, rate);
}

/// The same as a sigrok session or a DSLogic capture.
template <class Writer>
std::string sampled_seed(std::uint64_t seed) {
  return seed_capture(seed, [seed](const auto& names, auto& sink) {
    return Writer(names, sampled_layout(seed).rate, sink);
  });
}

/// The same as raw samples.
inline std::string raw_samples(std::uint64_t seed) {
  return seed_capture(seed, [seed](const auto&, auto& sink) {
    return capture::RawWriter(sampled_layout(seed), sink);
  });
}

/// The sample rate, little end first; bytes per sample; the number of lines; the bit of each of the
/// first eight lines.
inline constexpr std::size_t raw_header_bytes = 4 + 1 + 1 + 8;

inline std::string raw_header(const capture::RawLayout& layout) {
  std::string header;
  for (unsigned i = 0; i < 4; ++i) header += static_cast<char>(layout.rate.count >> (8 * i));
  header += static_cast<char>(layout.unit_bytes);
  header += static_cast<char>(layout.lines.size());
  for (const capture::SampleLine& line : layout.lines) header += static_cast<char>(line.bit);
  header.resize(raw_header_bytes);
  return header;
}

inline std::string raw_seed(std::uint64_t seed) {
  return raw_header(sampled_layout(seed)) + raw_samples(seed);
}

/// Two files as one input: the size of the first in four bytes, then both.
inline constexpr std::size_t first_size_bytes = 4;

inline std::string joined_files(std::string_view first, std::string_view second) {
  std::string input;
  capture::put_number(input, first.size(), first_size_bytes);
  return input.append(first).append(second);
}

/// Both channels in the binary export of Saleae Logic. In every third seed the levels are unknown
/// for a time.
inline std::string saleae_binary_seed(std::uint64_t seed) {
  std::array<std::string, 2> files;
  for (const wire::LineIndex line : {0U, 1U}) {
    capture::StringSink sink(files[line]);
    capture::SaleaeBinaryWriter writer({"line"}, sampled_layout(seed).rate, sink);
    const std::vector<wire::Edge> edges = cycle_edges(seed, cycles_of(seed));
    for (std::size_t i = 0; i < edges.size(); ++i) {
      wire::Edge edge = edges[i];
      if (edge.line != line) continue;
      edge.line = 0;
      if (seed % 3 == 1 && i + 8 > edges.size()) edge.level = wire::Level::unknown;
      if (!writer.write({&edge, 1}).ok()) return {};
    }
    if (!writer.finish(edges.back().time).ok()) return {};
  }
  return joined_files(files[0], files[1]);
}

/// Four samples in a clock period for some seeds, six for others.
inline Picoseconds scope_period(std::uint64_t seed) {
  const Picoseconds half = nanoseconds(50) * static_cast<std::int64_t>(half_period_steps(seed));
  return Picoseconds{half.count / (seed % 3 == 0 ? 3 : 2)};
}

inline std::vector<capture::ScopeSample> scope_seed_samples(std::uint64_t seed) {
  const std::vector<wire::Edge> edges = cycle_edges(seed, 1);
  const Picoseconds period = scope_period(seed);
  const auto count = static_cast<std::size_t>(edges.back().time.count / period.count + 8);
  return capture::scope_samples(edges, period, count, seed);
}

/// Text of an oscilloscope; the seed chooses the maker. Every eighth is a CSV of logic levels, as
/// DSView and sigrok write it.
inline std::string scope_seed(std::uint64_t seed) {
  const std::vector<capture::ScopeSample> samples = scope_seed_samples(seed);
  const Picoseconds period = scope_period(seed);
  if (seed % 8 != 3) {
    const std::size_t maker = seed % capture::scope_texts.size();
    return capture::scope_text(capture::scope_texts[maker], samples, period);
  }
  const bool sigrok = seed % 16 == 3;
  std::string text = "; CSV, generated by libsigrok4DSL 0.2.0\n; Channels (2/2)" +
                     std::string(sigrok ? ": MA, SLO" : "") +
                     "\n; Sample rate: " + std::to_string(1'000'000'000 / period.count) + " kHz\n";
  text += sigrok ? "logic,logic\n" : "Time(s), MA, SLO\n";
  for (const capture::ScopeSample& sample : samples) {
    if (!sigrok) text += std::to_string(sample.time.count) + "e-12,";
    text += sample.ma > 1.7 ? "1," : "0,";
    text += sample.slo > 1.7 ? "1\n" : "0\n";
  }
  return text;
}

/// Two analog binary exports of Saleae Logic 2: MA and SLO.
inline std::string saleae_analog_seed(std::uint64_t seed) {
  const std::vector<capture::ScopeSample> samples = scope_seed_samples(seed);
  const Picoseconds period = scope_period(seed);
  const std::uint32_t version = seed % 2 == 0 ? 0 : 1;
  return joined_files(capture::saleae_analog_text(samples, period, false, version),
                      capture::saleae_analog_text(samples, period, true, version));
}

/// The text in one or two members of either kind.
inline std::string compressed_in_parts(std::string_view text, SplitMix& random) {
  const bool gzip = random() % 2 == 0;
  const std::size_t first = random() % 4 == 0 ? random() % (text.size() + 1) : text.size();
  std::string bytes;
  for (const std::string_view part : {text.substr(0, first), text.substr(first)}) {
    if (part.empty() && !bytes.empty()) continue;
    const int level = static_cast<int>(random() % 2);
    bytes += gzip ? capture::gzip_of(part, {.level = level, .window_bits = 9, .memory_level = 1})
                  : capture::zstd_of(part, 1 - 6 * level);
  }
  return bytes;
}

/// A VCD or an event CSV of some cycles.
inline std::string text_seed(std::uint64_t seed) {
  return seed % 2 == 0 ? seed_text<capture::VcdWriter>(seed)
                       : seed_text<capture::EventCsvWriter>(seed);
}

/// The same, compressed.
inline std::string compressed_seed(std::uint64_t seed) {
  SplitMix random{seed};
  return compressed_in_parts(text_seed(seed), random);
}

/// Request cycles as an FST; with several blocks, blackouts or aliases for some seeds.
inline std::string fst_seed(std::uint64_t seed) {
  std::vector<wire::Edge> edges = cycle_edges(seed, cycles_of(seed));
  std::stable_sort(edges.begin(), edges.end(), [](const wire::Edge& a, const wire::Edge& b) {
    return std::pair(a.time, a.line) < std::pair(b.time, b.line);
  });
  capture::FstParts parts = capture::fst_parts_of({"MA", "SLO"}, edges);
  if (seed % 4 == 1) {
    const auto half = edges.begin() + static_cast<std::ptrdiff_t>(edges.size() / 2);
    const auto tick = static_cast<std::uint64_t>((half - 1)->time.count);
    parts.blocks = {capture::fst_block_of({edges.begin(), half}, 2, 0),
                    capture::fst_block_of({half, edges.end()}, 2, tick)};
  }
  if (seed % 8 == 2) parts.hierarchy += capture::fst_variable("copy", 1);
  if (seed % 8 == 3) {
    const auto end = static_cast<std::uint64_t>(edges.back().time.count);
    parts.blackouts = std::string("\2\0", 2);
    capture::put_varint(parts.blackouts, end - end / 4);
    parts.blackouts += std::string("\1\5", 2);
  }
  return capture::fst_of(parts);
}

inline std::string pairs_text_seed(std::uint64_t seed) {
  if (seed / 8 % 3 == 0) return saleae_seed(seed);
  return (seed / 8 % 3 == 1 ? seed_text<capture::VcdWriter>
                            : seed_text<capture::EventCsvWriter>)(seed);
}

inline std::string pairs_samples_seed(std::uint64_t seed) {
  if (seed % 3 == 0) return raw_seed(seed);
  return (seed % 3 == 1 ? sampled_seed<capture::SrWriter> : sampled_seed<capture::DslWriter>)(seed);
}

struct CaptureSeed {
  std::string_view target;
  std::string (*make)(std::uint64_t seed);
};

/// Of every target that reads captures.
inline constexpr CaptureSeed capture_seeds[] = {
    {"vcd", seed_text<capture::VcdWriter>},
    {"event_csv", seed_text<capture::EventCsvWriter>},
    {"pairs_text", pairs_text_seed},
    {"saleae", saleae_seed},
    {"sampled_csv", scope_seed},
    {"saleae_analog", saleae_analog_seed},
    {"sr", sampled_seed<capture::SrWriter>},
    {"raw", raw_seed},
    {"dsl", sampled_seed<capture::DslWriter>},
    {"pairs_samples", pairs_samples_seed},
    {"saleae_binary", saleae_binary_seed},
    {"compressed", compressed_seed},
    {"fst", fst_seed},
};

}  // namespace biss::fuzz
