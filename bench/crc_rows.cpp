// The CRC engines: throughput, and the latency of a single CRC.
#include <cstdint>
#include <string>
#include <vector>

#include "bench/measure.hpp"
#include "bench/pool.hpp"
#include "bench/rows.hpp"
#include "biss/crc/engines.hpp"

namespace biss::bench {

namespace {

std::vector<std::uint64_t> words(unsigned bits) {
  Random random(pool_seed);
  std::vector<std::uint64_t> words(pool_size);
  for (std::uint64_t& word : words) word = random.bits(bits);
  return words;
}

// The compiler must not see the specification as a constant.
template <class Engine>
Engine hidden(const CrcSpec& spec) {
  Engine engine(spec);
  benchmark::DoNotOptimize(engine);
  return engine;
}

template <class Engine>
void throughput(benchmark::State& state, const CrcSpec& spec, unsigned bits) {
  const auto engine = hidden<Engine>(spec);
  benchmark::DoNotOptimize(bits);
  const auto data = words(bits);
  measure(state, data.size(), [&](std::size_t i) { return engine(data[i], bits); });
}

template <class Engine>
void latency(benchmark::State& state, const CrcSpec& spec, unsigned bits) {
  const auto engine = hidden<Engine>(spec);
  benchmark::DoNotOptimize(bits);
  const auto data = words(bits);
  measure_chain(state, data.size(), [&](std::size_t i, std::uint64_t before) {
    return std::uint64_t{engine(data[i] ^ before, bits)};
  });
}

template <class Engine>
void constant(benchmark::State& state) {
  static constexpr Engine engine(crc6);
  const auto data = words(38);
  measure(state, data.size(), [&](std::size_t i) { return engine(data[i], 38); });
}

void add_engines(Table& table, const std::string& what, const CrcSpec& spec, unsigned bits,
                 double target) {
  const std::string bitwise = what + ", CrcBitwise";
  const auto add = [&](const char* engine, bool first, auto run) {
    table.add({.name = what + engine, .reference = bitwise, .target = first ? target : 0},
              [=](benchmark::State& state) { run(state, spec, bits); });
  };
  add(", CrcSliced", true, throughput<CrcSliced>);
  add(", CrcTable<8>", false, throughput<CrcTable<8>>);
  add(", CrcTable<4>", false, throughput<CrcTable<4>>);
  table.add({.name = bitwise},
            [=](benchmark::State& state) { throughput<CrcBitwise>(state, spec, bits); });
}

}  // namespace

void add_crc_rows(Table& table) {
  add_engines(table, "CRC6 of 38 bits", crc6, 38, 1);
  table.add({.name = "CRC6 of 38 bits, CrcSliced at compile time",
             .reference = "CRC6 of 38 bits, CrcBitwise",
             .target = 1},
            constant<CrcSliced>);
  table.add({.name = "CRC6 of 38 bits, dependent calls, CrcSliced",
             .reference = "CRC6 of 38 bits, dependent calls, CrcBitwise",
             .target = 3},
            [](benchmark::State& state) { latency<CrcSliced>(state, crc6, 38); });
  table.add({.name = "CRC6 of 38 bits, dependent calls, CrcBitwise"},
            [](benchmark::State& state) { latency<CrcBitwise>(state, crc6, 38); });
  add_engines(table, "CRC16 of 36 bits", crc16, 36, 0);
  add_engines(table, "CRC16 of 40 bits", crc16, 40, 0);
  add_engines(table, "CRC16 of 64 bits", crc16, 64, 0);
}

}  // namespace biss::bench
