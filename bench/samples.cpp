#include "bench/samples.hpp"

#include <algorithm>
#include <string_view>
#include <utility>

#include "bench/pool.hpp"
#include "capture/samples.hpp"
#include "capture/sr.hpp"
#include "capture/zip.hpp"

namespace biss::bench {

namespace {

constexpr std::uint8_t ma_bit = 1;
constexpr std::uint8_t slo_bit = 2;
constexpr double samples_per_clock = 100 / 9.83;
constexpr std::size_t position_frame_bits = 2 + 32 + 2 + 6;  // start and CDS, position, nE nW, CRC

// Times of the changes of both lines in a request cycle.
struct Cycle {
  std::vector<double> ma;
  std::vector<double> slo;
};

double fraction(Random& random) { return static_cast<double>(random.bits(16)) / 65'536; }

Cycle random_cycle(Random& random, double begin) {
  Cycle cycle;
  const std::size_t ack_clocks = 1 + random.below(24);
  const std::size_t clocks = 2 + ack_clocks + position_frame_bits;
  const double delay = 8 + 3 * fraction(random);
  bool slo_high = true;
  const auto set_slo = [&](std::size_t clock, bool high) {
    if (high == slo_high) return;
    slo_high = high;
    cycle.slo.push_back(begin + (static_cast<double>(clock) + 0.5) * samples_per_clock + delay);
  };
  for (std::size_t clock = 0; clock < clocks; ++clock) {
    for (const double half : {0.0, 0.5}) {
      const double jitter = 0.4 * (fraction(random) - 0.5);
      cycle.ma.push_back(begin + (static_cast<double>(clock) + half) * samples_per_clock + jitter);
    }
    const bool is_ack = clock > 0 && clock <= ack_clocks;
    set_slo(clock, clock == 0 || (!is_ack && (clock == ack_clocks + 1 || random.bits(1) != 0)));
  }
  set_slo(clocks, false);
  set_slo(clocks + 20, true);
  return cycle;
}

// The first sample at or after each of these times inverts the bit, from there to the end.
void put(std::span<std::uint8_t> samples, std::uint8_t bit, std::span<const double> times) {
  for (std::size_t i = 0; i + 1 < times.size(); i += 2) {
    const auto low = static_cast<std::size_t>(times[i]) + 1;
    const auto high = static_cast<std::size_t>(times[i + 1]) + 1;
    for (std::size_t k = low; k < high && k < samples.size(); ++k) {
      samples[k] = static_cast<std::uint8_t>(samples[k] & ~bit);
    }
  }
}

}  // namespace

std::vector<std::uint8_t> sampled_line(std::size_t samples, std::size_t period) {
  std::vector<std::uint8_t> line(samples, ma_bit | slo_bit);
  Random random(pool_seed);
  for (std::size_t at = 0; period != 0 && at + period <= samples; at += period) {
    const Cycle cycle = random_cycle(random, 100 + fraction(random));
    put(std::span(line).subspan(at), ma_bit, cycle.ma);
    put(std::span(line).subspan(at), slo_bit, cycle.slo);
  }
  return line;
}

std::string sr_archive(std::span<const std::uint8_t> samples) {
  constexpr std::size_t chunk_bytes = std::size_t{4} << 20U;
  const capture::RawLayout layout = capture::packed_layout({"MA", "SLO"}, megahertz(100));
  capture::ZipWriter archive;
  std::string out;
  archive.add("version", std::string_view("2"), out);
  archive.add("metadata", capture::sr_metadata_text(layout), out);
  for (std::size_t k = 1; !samples.empty(); ++k) {
    const auto chunk = samples.first(std::min(chunk_bytes, samples.size()));
    archive.add("logic-1-" + std::to_string(k), chunk, out);
    samples = samples.subspan(chunk.size());
  }
  archive.finish(out);
  return out;
}

}  // namespace biss::bench
