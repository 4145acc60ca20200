// Lines made edge by edge for the tests of this room: a plain model of master and encoder that
// shares nothing with the decoder.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <random>
#include <string_view>
#include <vector>

#include "biss/frame/encode.hpp"
#include "biss/frame/format_text.hpp"
#include "decode/decoder.hpp"

namespace biss::decode::test {

inline constexpr std::string_view usual_format = "pos26,nE,nW,crc6";

/// The end of a cycle on MA.
enum class Ending : std::uint8_t {
  idle_high,          ///< CDM = 0
  low_until_timeout,  ///< CDM = 1
  low_until_next,     ///< CDM = 1, held
};

struct Shape {
  Picoseconds period = nanoseconds(1'000);
  int high_percent = 50;
  Picoseconds line_delay = nanoseconds(100);
  Picoseconds timeout = microseconds(20);
  /// From SLO's release, as the master sees it, to the next request.
  Picoseconds gap = microseconds(5);
  /// Clocks after STOP; -1: none for STOP.
  int extra_clocks = 0;
  std::uint16_t ack_clocks = 3;
  Ending ending = Ending::idle_high;
  /// Each edge of MA moves by up to this share of a period either way, in per cent.
  int jitter_percent = 0;
  /// The master pauses for this long before these clocks, counted from 0.
  std::vector<std::int64_t> pauses{};
  Picoseconds pause{};
};

inline LevelChange high_at(Picoseconds time) { return {time, wire::Level::high}; }
inline LevelChange low_at(Picoseconds time) { return {time, wire::Level::low}; }

/// LAT to STOP of a frame with this position in channel 1.
inline FrameBits bits_of(std::string_view format, std::uint64_t position,
                         std::uint16_t ack_clocks = 3) {
  const PlainCodec codec(*parse_format(format));
  Frame frame;
  frame.channel_count = codec.format().channel_count;
  frame.lead_clocks = 1;
  frame.ack_clocks = ack_clocks;
  for (std::size_t k = 0; k < frame.channel_count; ++k) {
    frame.channel_list[k].position =
        (position + k) & low_mask(codec.format().channel_list[k].position_bits());
  }
  return *encode_frame(frame, codec);
}

/// MA is line 0, SLO line 1; both are high from time 0 on.
class TestLine {
 public:
  std::vector<LevelChange> ma{high_at({})};
  std::vector<LevelChange> slo{high_at({})};
  /// When the next request begins.
  Picoseconds now = microseconds(50);
  /// Index of the first edge of MA of each request.
  std::vector<std::size_t> begins;

  explicit TestLine(std::uint64_t seed = 1) : random_(seed) {}

  /// One request, answered with these bits. \return when it began
  Picoseconds request(const Shape& shape, const FrameBits& bits) {
    begins.push_back(ma.size());
    const Picoseconds begin = now;
    const auto clocks = static_cast<std::int64_t>(bits.size_bits()) + shape.extra_clocks;
    const Picoseconds low = shape.period * (100 - shape.high_percent) / 100;
    Picoseconds rise{};
    bool level = true;
    Picoseconds paused{};
    for (std::int64_t i = 0; i < clocks; ++i) {
      paused += std::count(shape.pauses.begin(), shape.pauses.end(), i) * shape.pause;
      const Picoseconds fall = i == 0 ? begin : begin + paused + i * shape.period + jitter(shape);
      rise = begin + paused + i * shape.period + low + jitter(shape);
      ma.push_back(low_at(fall));
      ma.push_back(high_at(rise));
      const auto index = static_cast<std::size_t>(i);
      const bool bit = index < bits.size_bits() && bits.view()[index];
      if (bit == level) continue;
      level = bit;
      slo.push_back({rise + shape.line_delay, bit ? wire::Level::high : wire::Level::low});
    }
    finish(shape, rise, level);
    return begin;
  }

  Picoseconds request(const Shape& shape, std::uint64_t position,
                      std::string_view format = usual_format) {
    return request(shape, bits_of(format, position, shape.ack_clocks));
  }

  /// A pulse of the other level on a line, over all other changes there.
  static void add_pulse(std::vector<LevelChange>& line, Picoseconds from, Picoseconds width,
                        std::optional<wire::Level> level = {}) {
    const auto later = [&](Picoseconds time) {
      return std::find_if(line.begin(), line.end(),
                          [&](const LevelChange& change) { return change.time > time; });
    };
    const wire::Level was = (later(from) - 1)->level;
    const wire::Level then = (later(from + width) - 1)->level;
    const wire::Level other = was == wire::Level::low ? wire::Level::high : wire::Level::low;
    const auto at = line.erase(later(from), later(from + width));
    line.insert(at, {{from, level.value_or(other)}, {from + width, then}});
    line.erase(
        std::unique(line.begin(), line.end(),
                    [](const LevelChange& a, const LevelChange& b) { return a.level == b.level; }),
        line.end());
  }

  Picoseconds last_time() const {
    return slo.empty() ? ma.back().time : std::max(ma.back().time, slo.back().time);
  }

  /// Both lines as a capture delivers them. SLO comes first if both change at the same time.
  std::vector<wire::Edge> edges() const {
    std::vector<wire::Edge> all;
    for (const LevelChange& change : slo) all.push_back({change.time, 1, change.level});
    for (const LevelChange& change : ma) all.push_back({change.time, 0, change.level});
    std::stable_sort(all.begin(), all.end(),
                     [](const wire::Edge& a, const wire::Edge& b) { return a.time < b.time; });
    return all;
  }

 private:
  Picoseconds jitter(const Shape& shape) {
    if (shape.jitter_percent == 0) return {};
    const std::int64_t most = shape.period.count * shape.jitter_percent / 100;
    return Picoseconds{
        static_cast<std::int64_t>(random_() % static_cast<std::uint64_t>(2 * most + 1)) - most};
  }

  void finish(const Shape& shape, Picoseconds last, bool level) {
    if (shape.ending != Ending::idle_high) {
      last += shape.period * shape.high_percent / 100;
      ma.push_back(low_at(last));
    }
    const Picoseconds release = last + shape.timeout + shape.line_delay;
    if (!level) slo.push_back(high_at(release));
    now = release + shape.gap;
    if (shape.ending == Ending::low_until_timeout) ma.push_back(high_at(release + picoseconds(1)));
    if (shape.ending == Ending::low_until_next) ma.push_back(high_at(now - shape.period / 10));
  }

  std::mt19937_64 random_;
};

/// The edges as an analyser with this sample period sees them: at the next sample. Pulses
/// between samples are lost.
inline std::vector<LevelChange> sampled(const std::vector<LevelChange>& line, Picoseconds sample,
                                        Picoseconds phase = {}) {
  std::vector<LevelChange> seen;
  for (const LevelChange& change : line) {
    const std::int64_t k = (change.time - phase).count / sample.count + 1;
    const Picoseconds at = k * sample + phase;
    while (!seen.empty() && seen.back().time == at) seen.pop_back();
    if (seen.empty() || seen.back().level != change.level) seen.push_back({at, change.level});
  }
  return seen;
}

inline std::vector<Cycle> decode(const std::vector<wire::Edge>& edges, Picoseconds end,
                                 std::string_view format = usual_format,
                                 const DeviceTiming& timing = {}, const MarginSetup& margin = {}) {
  std::vector<Cycle> cycles;
  std::optional<FrameFormat> parsed;
  if (!format.empty()) parsed = *parse_format(format);
  Decoder decoder(CycleReader(parsed, timing, margin),
                  [&](const Cycle& cycle) { cycles.push_back(cycle); });
  decoder.push(edges, {0, 1});
  decoder.finish(end);
  return cycles;
}

inline std::vector<Cycle> decode(const TestLine& line, std::string_view format = usual_format,
                                 const DeviceTiming& timing = {}) {
  return decode(line.edges(), line.last_time() + milliseconds(1), format, timing);
}

}  // namespace biss::decode::test
