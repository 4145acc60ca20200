// Valid captures as seeds: request cycles of BiSS frames with a good CRC, some of them damaged.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "biss/base/units.hpp"
#include "biss/frame/encode.hpp"
#include "biss/frame/format_text.hpp"
#include "capture/bytes.hpp"
#include "capture/dsl.hpp"
#include "capture/event_csv.hpp"
#include "capture/saleae_binary.hpp"
#include "capture/samples.hpp"
#include "capture/sr.hpp"
#include "fuzz/cycles.hpp"
#include "fuzz/two_files.hpp"
#include "wire/edge.hpp"

namespace biss::fuzz {

/// SplitMix64: numbers that look random, from any seed, without a large state to set up.
struct SplitMix {
  std::uint64_t state;

  std::uint64_t operator()() {
    state += 0x9E37'79B9'7F4A'7C15U;
    std::uint64_t z = state;
    z = (z ^ (z >> 30U)) * 0xBF58'476D'1CE4'E5B9U;
    z = (z ^ (z >> 27U)) * 0x94D0'49BB'1331'11EBU;
    return z ^ (z >> 31U);
  }
};

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

/// The same as a sigrok session.
inline std::string sr_seed(std::uint64_t seed) {
  return seed_capture(seed, [seed](const auto& names, auto& sink) {
    return capture::SrWriter(names, sampled_layout(seed).rate, sink);
  });
}

/// The same as raw samples.
inline std::string raw_seed(std::uint64_t seed) {
  return seed_capture(seed, [seed](const auto&, auto& sink) {
    return capture::RawWriter(sampled_layout(seed), sink);
  });
}

/// The same as a DSLogic capture.
inline std::string dsl_seed(std::uint64_t seed) {
  return seed_capture(seed, [seed](const auto& names, auto& sink) {
    return capture::DslWriter(names, sampled_layout(seed).rate, sink);
  });
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
  return joined_files({files[0], files[1]});
}

}  // namespace biss::fuzz
