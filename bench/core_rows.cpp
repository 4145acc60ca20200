// Format text, turns, and the machine itself.
#include <cstdint>
#include <cstring>
#include <string_view>
#include <vector>

#include "bench/measure.hpp"
#include "bench/pool.hpp"
#include "bench/rows.hpp"
#include "biss/frame/codec.hpp"
#include "biss/frame/format_text.hpp"
#include "biss/turns/turn_counter.hpp"

namespace biss::bench {

namespace {

void parse(benchmark::State& state, std::string_view text) {
  benchmark::DoNotOptimize(text);
  measure(state, 64, [&](std::size_t) {
    benchmark::ClobberMemory();
    return std::uint64_t{parse_format(text).value().channel_list[0].data_bits};
  });
}

void make_codec(benchmark::State& state) {
  FrameFormat format = parse_format("pos36,nE,nW,crc6").value();
  measure(state, 64, [&](std::size_t) {
    benchmark::DoNotOptimize(format);
    FrameCodec<CrcFast, 1> codec(format);
    benchmark::DoNotOptimize(codec);
    return std::uint64_t{codec.payload_bits()};
  });
}

// Steps of up to a quarter turn, zero crossed both ways.
void turns(benchmark::State& state) {
  Random random(pool_seed);
  std::vector<std::uint64_t> counts(pool_size);
  std::uint64_t count = 0;
  for (std::uint64_t& next : counts) {
    const std::uint64_t step = random.bits(24);
    count += random.bits(1) != 0 ? step : std::uint64_t{0} - step;
    next = count & low_mask(26);
  }
  TurnCounter counter(26);
  measure(state, pool_size, [&](std::size_t i) {
    counter.update(counts[i]);
    return static_cast<std::uint64_t>(counter.turns());
  });
}

// An addition that depends on the previous one takes one clock.
void one_clock(benchmark::State& state) {
  measure_chain(state, pool_size, [](std::size_t i, std::uint64_t before) {
    std::uint64_t sum = before + i;
    benchmark::DoNotOptimize(sum);
    return sum;
  });
}

void copy_memory(benchmark::State& state) {
  constexpr std::size_t size = std::size_t{64} << 20U;
  const std::vector<char> from(size, 1);
  std::vector<char> to(size);
  for ([[maybe_unused]] auto _ : state) {
    std::memcpy(to.data(), from.data(), size);
    benchmark::DoNotOptimize(to.data());
    benchmark::ClobberMemory();
  }
  state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(size));
}

}  // namespace

void add_core_rows(Table& table) {
  table.add({.name = "parse_format, pos22,nE,nW,crc6"},
            [](benchmark::State& state) { parse(state, "pos22,nE,nW,crc6"); });
  table.add({.name = "parse_format, safety 36 + 28 bits"}, [](benchmark::State& state) {
    parse(state, "pos36,nE,nW,crc6+pos28,nE,nW,lc6,crc16;cds0");
  });
  table.add({.name = "FrameCodec with its tables, one channel"}, make_codec);
  table.add({.name = "TurnCounter::update, 26 bits"}, turns);
  table.add({.name = "one addition after another: the clock"}, one_clock);
  table.add({.name = "memcpy of 64 MiB", .unit = Unit::megabytes}, copy_memory);
}

}  // namespace biss::bench
