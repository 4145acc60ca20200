#include "explain/reading.hpp"

#include <vector>

#include "decode/polarity.hpp"

namespace biss::explain {

namespace {

// How many cycles read well, in per cent of all.
struct Readable {
  std::size_t cycles = 0;
  std::size_t good = 0;
  // ACK in time, START, and even clocks.
  std::size_t answered = 0;

  bool well() const { return cycles >= 3 && 10 * answered >= 7 * cycles; }
  bool hardly() const { return 4 * answered <= cycles && 10 * good <= cycles; }
};

Readable read(const decode::Lines& lines, std::span<const wire::Edge> edges,
              const decode::CycleReader& reader) {
  Readable readable;
  decode::Decoder decoder(reader, [&](const decode::Cycle& cycle) {
    if (cycle.status == CycleStatus::cut_start || cycle.status == CycleStatus::cut_end) return;
    ++readable.cycles;
    if (is_good(cycle.status)) ++readable.good;
    const bool even = cycle.status != CycleStatus::ma_clock && cycle.rising_edges >= 8;
    if (cycle.ack && even) ++readable.answered;
  });
  decoder.push(edges, lines);
  decoder.finish(edges.empty() ? Picoseconds{} : edges.back().time);
  return readable;
}

}  // namespace

Reading choose_reading(const decode::Lines& lines, std::span<const wire::Edge> beginning,
                       const decode::CycleReader& reader) {
  const std::vector<wire::Edge> edges = decode::first_edges(lines, beginning);
  Reading reading{.lines = decode::find_polarity(lines, edges, reader)};
  if (read(reading.lines, edges, reader).hardly()) {
    const decode::Lines other =
        decode::find_polarity({.ma = lines.slo, .slo = lines.ma}, edges, reader);
    reading.swapped = read(other, edges, reader).well();
    if (reading.swapped) reading.lines = other;
  }
  reading.ma_inverted = reading.lines.ma_inverted && !lines.ma_inverted;
  reading.slo_inverted = reading.lines.slo_inverted && !lines.slo_inverted;
  return reading;
}

}  // namespace biss::explain
