// The readers of captures, and the decoder that uses them.
#include <span>
#include <string>
#include <utility>

#include "bench/line.hpp"
#include "bench/measure.hpp"
#include "bench/rows.hpp"
#include "capture/bytes.hpp"
#include "capture/edge_pairs.hpp"
#include "capture/open.hpp"
#include "capture/pair_source.hpp"
#include "decode/clean_cycles.hpp"
#include "decode/decoder.hpp"

namespace biss::bench {

namespace {

// Their arrays fit into the second-level cache, as the pieces of a capture do.
constexpr std::size_t cycles = 500;

void read(benchmark::State& state, const std::string& text, const char* path) {
  if (text.empty()) return state.SkipWithError("the capture could not be written");
  std::size_t edges = 0;
  for ([[maybe_unused]] auto _ : state) {
    auto opened = capture::open_capture(capture::memory_bytes(text), path);
    if (!opened) return state.SkipWithError("the capture could not be opened");
    for (auto block = (*opened)->next_block();; block = (*opened)->next_block()) {
      if (!block.ok()) return state.SkipWithError("the capture could not be read");
      if ((*block).empty()) break;
      edges += (*block).size();
    }
  }
  benchmark::DoNotOptimize(edges);
  state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(text.size()));
}

// fetch(), expand() and settle() in one thread.
void read_pairs(benchmark::State& state, const std::string& text, const char* path) {
  if (text.empty()) return state.SkipWithError("the capture could not be written");
  std::size_t changes = 0;
  for ([[maybe_unused]] auto _ : state) {
    const auto opened = capture::open_capture(capture::memory_bytes(text), path);
    if (!opened) return state.SkipWithError("the capture could not be opened");
    const auto pairs = (*opened)->pairs(0, 1);
    if (!pairs) return state.SkipWithError("the capture has no pairs");
    for (auto piece = pairs->fetch(nullptr); piece; piece = pairs->fetch(std::move(piece))) {
      piece->expand();
      const auto count = [&](std::span<const wire::Edge> edges) { changes += edges.size(); };
      if (pairs->settle(*piece, count)) {
        changes += piece->ma.times.size() + piece->slo.times.size();
      }
    }
    if (pairs->error()) return state.SkipWithError("the capture could not be read");
  }
  benchmark::DoNotOptimize(changes);
  state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(text.size()));
}

void decode_edges(benchmark::State& state) {
  const Line line = make_line(cycles);
  std::uint64_t sum = 0;
  std::int64_t good = 0;
  for ([[maybe_unused]] auto _ : state) {
    decode::Decoder decoder(decode::CycleReader(line.format, DeviceTiming{}),
                            [&](const decode::Cycle& cycle) {
                              if (!cycle.frame) return;
                              ++good;
                              sum += cycle.frame->channel_list[0].position;
                            });
    decoder.push(line.edges, {.ma = 0, .slo = 1});
    decoder.finish(line.end);
  }
  benchmark::DoNotOptimize(sum);
  const auto all = state.iterations() * static_cast<std::int64_t>(line.cycles);
  if (good != all) return state.SkipWithError("a cycle was lost");
  state.SetItemsProcessed(all);
}

// The same from arrays, as a reader delivers them.
void decode_arrays(benchmark::State& state) {
  const Line line = make_line(cycles);
  capture::LineChanges ma;
  capture::LineChanges slo;
  capture::take_changes(line.edges, 0, 1, ma, slo);
  const decode::PairRun run{{ma.times, ma.first_high}, {slo.times, slo.first_high}};
  decode::CleanCycleFinder finder(line.format, {}, {});
  std::vector<decode::CleanCycle> clean;
  std::int64_t good = 0;
  for ([[maybe_unused]] auto _ : state) {
    decode::Decoder decoder(decode::CycleReader(line.format, DeviceTiming{}),
                            [&](const decode::Cycle& cycle) { good += cycle.frame ? 1 : 0; });
    finder.find(run, clean);
    decoder.push(run, clean);
    decoder.finish(line.end);
  }
  const auto all = state.iterations() * static_cast<std::int64_t>(line.cycles);
  if (good != all) return state.SkipWithError("a cycle was lost");
  state.SetItemsProcessed(all);
}

}  // namespace

void add_capture_rows(Table& table) {
  const std::string memory = "memcpy of 64 MiB";
  table.add({.name = "read a VCD", .unit = Unit::megabytes, .reference = memory},
            [](benchmark::State& state) { read(state, vcd_text(make_line(cycles)), "x.vcd"); });
  table.add({.name = "read an event CSV", .unit = Unit::megabytes, .reference = memory},
            [](benchmark::State& state) { read(state, csv_text(make_line(cycles)), "x.csv"); });
  table.add(
      {.name = "read a VCD, two lines as arrays", .unit = Unit::megabytes, .reference = memory},
      [](benchmark::State& state) { read_pairs(state, vcd_text(make_line(cycles)), "x.vcd"); });
  table.add(
      {.name = "read an event CSV, two lines as arrays",
       .unit = Unit::megabytes,
       .reference = memory},
      [](benchmark::State& state) { read_pairs(state, csv_text(make_line(cycles)), "x.csv"); });
  table.add({.name = "edges to frames, cycles of 26 bits", .unit = Unit::million_a_second},
            decode_edges);
  table.add({.name = "arrays of edges to frames, cycles of 26 bits",
             .unit = Unit::million_a_second,
             .reference = "edges to frames, cycles of 26 bits",
             .target = 200},
            decode_arrays);
}

}  // namespace biss::bench
