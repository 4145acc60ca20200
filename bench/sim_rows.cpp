// The line model: master, cable and encoder in picoseconds.
#include <algorithm>
#include <chrono>
#include <memory>
#include <thread>
#include <vector>

#include "bench/rows.hpp"
#include "biss/catalogue/catalogue.hpp"
#include "sim/line.hpp"

namespace biss::bench {

namespace {

constexpr std::size_t encoders = 1000;
constexpr int cycles_each = 50;

sim::LineSetup resolute(std::uint64_t seed) {
  const CatalogueEntry& entry = *find_encoder("resolute-26");
  sim::LineSetup setup;
  setup.format = entry.frame_format();
  setup.timing = entry.timing;
  setup.clock = megahertz(10);
  setup.internal_delay = entry.timing.internal_delay_max;
  setup.ma_delay = setup.slo_delay = nanoseconds(250);
  setup.seed = seed;
  return setup;
}

bool good(const sim::SimulatedCycle& cycle) {
  return cycle.reading.frame.ok() &&
         cycle.reading.frame->channel_list[0] == cycle.sent.channel_list[0];
}

void one_encoder(benchmark::State& state) {
  sim::Line line(resolute(1));
  std::int64_t right = 0;
  for ([[maybe_unused]] auto _ : state) right += good(line.next()) ? 1 : 0;
  if (right != state.iterations()) return state.SkipWithError("a cycle was read wrong");
  state.SetItemsProcessed(state.iterations());
}

// Each core has its share of the encoders. The time is the wall-clock time of all of them.
void many_encoders(benchmark::State& state) {
  std::vector<std::unique_ptr<sim::Line>> lines;
  for (std::size_t i = 0; i < encoders; ++i) {
    sim::LineSetup setup = resolute(i + 1);
    setup.interval = milliseconds(1);
    lines.push_back(std::make_unique<sim::Line>(setup));
  }
  const std::size_t cores = std::max(1U, std::thread::hardware_concurrency());
  std::vector<std::int64_t> right(cores);
  for ([[maybe_unused]] auto _ : state) {
    const auto begin = std::chrono::steady_clock::now();
    std::vector<std::thread> threads;
    for (std::size_t core = 0; core < cores; ++core) {
      threads.emplace_back([&, core] {
        std::int64_t count = 0;
        for (std::size_t i = core; i < encoders; i += cores) {
          for (int n = 0; n < cycles_each; ++n) count += good(lines[i]->next()) ? 1 : 0;
        }
        right[core] += count;
      });
    }
    for (std::thread& thread : threads) thread.join();
    state.SetIterationTime(
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
  }
  const std::int64_t all = state.iterations() * static_cast<std::int64_t>(encoders) * cycles_each;
  std::int64_t sum = 0;
  for (const std::int64_t count : right) sum += count;
  if (sum != all) return state.SkipWithError("a cycle was read wrong");
  state.SetItemsProcessed(all);
}

}  // namespace

void add_sim_rows(Table& table) {
  // A tenth of 1/32 kHz.
  table.add(
      {.name = "line model, a cycle of 26 bits at 10 MHz, 50 m", .reference = {}, .target = 3125},
      one_encoder);
  // 1000 encoders at 1 kHz: a million cycles a second.
  table.add({.name = "the same, of 1000 encoders on all cores, on the wall",
             .reference = {},
             .target = 1000,
             .own_time = true},
            many_encoders);
}

}  // namespace biss::bench
