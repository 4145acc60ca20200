#include "bench/samples.hpp"

#include <algorithm>

#include "bench/pool.hpp"
#include "biss/frame/encode.hpp"
#include "biss/frame/format_text.hpp"
#include "capture/samples.hpp"
#include "capture/sr.hpp"
#include "capture/zip.hpp"

namespace biss::bench {

namespace {

constexpr std::uint8_t ma_bit = 1;
constexpr std::uint8_t slo_bit = 2;
constexpr double samples_per_clock = 100 / 9.83;

// Times of the changes of both lines in a request cycle.
struct Cycle {
  std::vector<double> ma;
  std::vector<double> slo;
};

double fraction(Random& random) { return static_cast<double>(random.bits(16)) / 65'536; }

Cycle random_cycle(Random& random, double begin, BitView bits) {
  Cycle cycle;
  const double delay = 8 + 3 * fraction(random);
  bool slo_high = true;
  const auto set_slo = [&](std::size_t clock, bool high) {
    if (high == slo_high) return;
    slo_high = high;
    cycle.slo.push_back(begin + (static_cast<double>(clock) + 0.5) * samples_per_clock + delay);
  };
  for (std::size_t clock = 0; clock < bits.size_bits(); ++clock) {
    for (const double half : {0.0, 0.5}) {
      const double jitter = 0.4 * (fraction(random) - 0.5);
      cycle.ma.push_back(begin + (static_cast<double>(clock) + half) * samples_per_clock + jitter);
    }
    set_slo(clock, bits[clock]);
  }
  set_slo(bits.size_bits() + 20, true);
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

SampledLine sampled_line(std::size_t samples, std::size_t period) {
  SampledLine line{.samples = std::vector<std::uint8_t>(samples, ma_bit | slo_bit)};
  const FrameCodec<CrcFast, 1> codec(parse_format(sampled_format_text).value());
  Random random(pool_seed);
  for (std::size_t at = 0; period != 0 && at + period <= samples; at += period) {
    FrameCodec<CrcFast, 1>::Frame frame;
    frame.channel_count = 1;
    frame.lead_clocks = 1;
    frame.ack_clocks = static_cast<std::uint16_t>(1 + random.below(24));
    frame.channel_list[0].position = random.bits(32);
    FrameBits bits = encode_frame(frame, codec).value();
    const bool damaged = random.below(1000) == 0;
    // A bit of the position: the checksum shows it.
    if (damaged) bits.flip(bits.size_bits() - 12);
    const Cycle cycle = random_cycle(random, 100 + fraction(random), bits.view());
    put(std::span(line.samples).subspan(at), ma_bit, cycle.ma);
    put(std::span(line.samples).subspan(at), slo_bit, cycle.slo);
    ++line.requests;
    line.good += damaged ? 0 : 1;
    line.position_sum += damaged ? 0 : frame.channel_list[0].position;
  }
  return line;
}

std::string sr_archive(std::span<const std::uint8_t> samples) {
  constexpr std::size_t chunk_bytes = std::size_t{4} << 20U;
  const capture::RawLayout layout = capture::packed_layout({"MA", "SLO"}, megahertz(100));
  capture::ZipWriter archive;
  std::string out;
  archive.add("version", "2", out);
  archive.add("metadata", capture::sr_metadata_text(layout), out);
  for (std::size_t k = 1; !samples.empty(); ++k) {
    const auto chunk = samples.first(std::min(chunk_bytes, samples.size()));
    archive.add("logic-1-" + std::to_string(k),
                {reinterpret_cast<const char*>(chunk.data()), chunk.size()}, out);
    samples = samples.subspan(chunk.size());
  }
  archive.finish(out);
  return out;
}

const SampledLine& whole_line() {
  static const SampledLine line = sampled_line(whole_samples, request_period);
  return line;
}

const std::string& whole_archive() {
  static const std::string archive = sr_archive(whole_line().samples);
  return archive;
}

}  // namespace biss::bench
