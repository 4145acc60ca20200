// Sampled captures on their way to the changes of two lines, next to the limits of the machine.
#include <hwy/highway.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "bench/measure.hpp"
#include "bench/rows.hpp"
#include "bench/samples.hpp"
#include "biss/frame/format_text.hpp"
#include "capture/dsl.hpp"
#include "capture/edge_pairs.hpp"
#include "capture/pair_source.hpp"
#include "capture/samples.hpp"
#include "capture/zip.hpp"
#include "decode/statistics.hpp"
#include "flow/cycle_flow.hpp"

namespace biss::bench {

namespace {

// The same as request_period: one line that rests little, one that rests most of the time.
constexpr std::size_t busy_period = 1'000;
constexpr std::size_t idle_period = 60'000;

using Samples = std::vector<std::uint8_t>;

const Samples& line_in_memory() { return whole_line().samples; }

const Samples& rest_in_memory() {
  static const SampledLine line = sampled_line(whole_samples / 2, 0);
  return line.samples;
}

// The line without its samples, and they as an archive.
struct Archive {
  SampledLine line;
  std::string bytes;
};

const Archive& archive_of(std::size_t period) {
  static std::map<std::size_t, Archive> archives;
  Archive& archive = archives[period];
  if (archive.bytes.empty()) {
    archive.line = sampled_line(archive_samples, period);
    archive.bytes = sr_archive(std::exchange(archive.line.samples, {}));
  }
  return archive;
}

// Decodes the capture to its request cycles and their statistics; false if a position is wrong.
bool decode_all(capture::Opened opened, const SampledLine& line, unsigned threads) {
  if (!opened) return false;
  const auto format = parse_format(sampled_format_text).value();
  const decode::MarginSetup margin{.resolution = (*opened)->sample_period()};
  decode::Statistics statistics;
  std::uint64_t sum = 0;
  decode::Decoder decoder(decode::CycleReader(format, {}, margin), [&](const decode::Cycle& cycle) {
    statistics.add(cycle);
    if (cycle.frame) sum += cycle.frame->channel_list[0].position;
  });
  const auto pairs = capture::pairs_of({}, **opened, 0, 1);
  flow::CycleFlow flow(*pairs, decode::CleanCycleFinder(format, {}, margin), {0, 1}, decoder);
  flow.run(threads, {});
  flow.flush();
  decoder.finish(pairs->end_time());
  return !pairs->error() && statistics.good() == line.good && sum == line.position_sum;
}

void decode_memory(benchmark::State& state, unsigned threads) {
  const SampledLine& line = whole_line();
  const capture::RawLayout layout = capture::packed_layout({"MA", "SLO"}, megahertz(100));
  const std::string_view text(reinterpret_cast<const char*>(line.samples.data()),
                              line.samples.size());
  for ([[maybe_unused]] auto _ : state) {
    const auto begin = std::chrono::steady_clock::now();
    if (!decode_all(capture::open_raw(capture::memory_bytes(text), layout), line, threads)) {
      return state.SkipWithError("a wrong position");
    }
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
    state.SetIterationTime(took.count());
  }
  state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(text.size()));
}

void decode_archive(benchmark::State& state, std::size_t period, bool verify) {
  const Archive& archive = archive_of(period);
  for ([[maybe_unused]] auto _ : state) {
    if (!decode_all(capture::open_zip(capture::memory_bytes(archive.bytes), {.verify = verify}),
                    archive.line, 1)) {
      return state.SkipWithError("a wrong position");
    }
  }
  state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(archive_samples));
}

// Fetches and expands all pieces; returns the number of changes, 0 after an error.
std::uint64_t changes_in(capture::Opened opened) {
  if (!opened) return 0;
  const auto pairs = (*opened)->pairs(0, 1);
  std::uint64_t changes = 0;
  std::unique_ptr<capture::PairPiece> used;
  while (auto piece = pairs->fetch(std::move(used))) {
    piece->expand();
    if (!pairs->settle(*piece, {})) return 0;
    changes += piece->ma.times.size() + piece->slo.times.size();
    used = std::move(piece);
  }
  return changes;
}

void pass(benchmark::State& state, const Samples& samples,
          std::uint64_t (*work)(std::span<const std::uint8_t>)) {
  for ([[maybe_unused]] auto _ : state) benchmark::DoNotOptimize(work(samples));
  state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(samples.size()));
}

void expand_memory(benchmark::State& state, const Samples& samples) {
  const capture::RawLayout layout = capture::packed_layout({"MA", "SLO"}, megahertz(100));
  const std::string_view text(reinterpret_cast<const char*>(samples.data()), samples.size());
  for ([[maybe_unused]] auto _ : state) {
    if (changes_in(capture::open_raw(capture::memory_bytes(text), layout)) == 0) {
      return state.SkipWithError("the samples could not be read");
    }
  }
  state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(samples.size()));
}

// The same with the vectors of an older processor, or without vectors.
template <class Run>
void run_at(std::int64_t target, Run run) {
  hwy::SetSupportedTargetsForTest(target | HWY_STATIC_TARGET);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  run();
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

void inflate(benchmark::State& state, std::size_t period) {
  const auto archive = capture::ZipArchive::open(capture::memory_bytes(archive_of(period).bytes));
  if (!archive) return state.SkipWithError("the archive could not be opened");
  std::vector<std::pair<Samples, std::uint64_t>> members;
  std::uint64_t most_bytes = 0;
  for (std::size_t k = 1;; ++k) {
    const auto member = (*archive)->find("logic-1-" + std::to_string(k));
    if (!member) break;
    Samples deflated(static_cast<std::size_t>(member->compressed_bytes));
    if (!(*archive)->read_compressed(*member, deflated)) break;
    members.emplace_back(std::move(deflated), member->size_bytes);
    most_bytes = std::max(most_bytes, member->size_bytes);
  }
  capture::Inflater inflater;
  Samples samples(static_cast<std::size_t>(most_bytes));
  for ([[maybe_unused]] auto _ : state) {
    for (const auto& [deflated, size_bytes] : members) {
      const auto into = std::span(samples).first(static_cast<std::size_t>(size_bytes));
      if (!inflater.inflate(deflated, into)) return state.SkipWithError("does not inflate");
      benchmark::DoNotOptimize(samples.data());
    }
  }
  state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(archive_samples));
}

void expand_archive(benchmark::State& state, std::size_t period, bool verify) {
  const std::string& archive = archive_of(period).bytes;
  for ([[maybe_unused]] auto _ : state) {
    const auto changes =
        changes_in(capture::open_zip(capture::memory_bytes(archive), {.verify = verify}));
    if (changes == 0) return state.SkipWithError("the archive could not be read");
  }
  state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(archive_samples));
}

// \param share of the reference's speed, at the least
void add_level_rows(Table& table, const std::string& reference, const std::string& name,
                    std::int64_t level, double share) {
  if ((hwy::SupportedTargets() & level) == 0 && level != HWY_STATIC_TARGET) return;
  table.add({.name = "samples in memory, to changes of MA and SLO, " + name,
             .unit = Unit::megabytes,
             .reference = reference},
            [=](benchmark::State& state) {
              run_at(level, [&] { expand_memory(state, line_in_memory()); });
            });
  table.add({.name = "samples in memory, to request cycles, " + name,
             .unit = Unit::megabytes,
             .reference = reference,
             .share = 1 / share,
             .own_time = true},
            [=](benchmark::State& state) { run_at(level, [&] { decode_memory(state, 1); }); });
}

void add_archive_rows(Table& table, const std::string& line, std::size_t period) {
  const std::string ceiling = ".sr, " + line + inflate_row;
  table.add({.name = ceiling, .unit = Unit::megabytes},
            [=](benchmark::State& state) { inflate(state, period); });
  for (const bool verify : {false, true}) {
    const std::string checksums = verify ? "" : ", no checksums";
    table.add({.name = ".sr, " + line + ", to changes" + checksums,
               .unit = Unit::megabytes,
               .reference = ceiling},
              [=](benchmark::State& state) { expand_archive(state, period, verify); });
    table.add({.name = ".sr, " + line + ", to request cycles" + checksums,
               .unit = Unit::megabytes,
               .reference = ceiling,
               .share = verify ? verified_share : inflate_share},
              [=](benchmark::State& state) { decode_archive(state, period, verify); });
  }
}

}  // namespace

void add_samples_rows(Table& table) {
  const std::string reading = "samples in memory, read";
  const std::string planes = "samples in memory, plane pass";
  table.add({.name = reading, .unit = Unit::megabytes},
            [](benchmark::State& state) { pass(state, line_in_memory(), read_pass); });
  table.add({.name = planes, .unit = Unit::megabytes, .reference = reading},
            [](benchmark::State& state) { pass(state, line_in_memory(), plane_pass); });
  table.add({.name = "samples in memory, to changes of MA and SLO",
             .unit = Unit::megabytes,
             .reference = planes},
            [](benchmark::State& state) { expand_memory(state, line_in_memory()); });
  const std::string one = "samples in memory, to request cycles, 1 thread";
  table.add({.name = one,
             .unit = Unit::megabytes,
             .reference = planes,
             .share = 1 / 0.5,
             .own_time = true},
            [](benchmark::State& state) { decode_memory(state, 1); });
  table.add({.name = "samples in memory, to request cycles, 2 threads",
             .unit = Unit::megabytes,
             .reference = one,
             .share = 1 / 1.7,
             .own_time = true},
            [](benchmark::State& state) { decode_memory(state, 2); });
  add_level_rows(table, planes, "AVX2", HWY_AVX2, 0.5);
  add_level_rows(table, planes, "no vectors", HWY_STATIC_TARGET, 0.1);
  table.add({.name = "samples in memory, a rest line to changes",
             .unit = Unit::megabytes,
             .reference = reading},
            [](benchmark::State& state) { expand_memory(state, rest_in_memory()); });
  add_archive_rows(table, request_line, request_period);
  add_archive_rows(table, "a busy line", busy_period);
  add_archive_rows(table, "a mostly idle line", idle_period);
}

}  // namespace biss::bench
