// Timing model of encoder, cable and SPI peripheral. It is written from the protocol alone and does
// not use the aligner that it tests.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace biss::test::spi {

/// The edge of MA at which the peripheral samples.
enum class Edge : std::uint8_t { rising, falling };

/// Whether a change at exactly the sampling time is read.
enum class Tie : std::uint8_t { old_level, new_level };

/// MA falls at 0, T, 2 T, … and rises half a period later; times are picoseconds.
struct Clock {
  std::int64_t period = 100'000;
  Edge edge = Edge::rising;
  Tie tie = Tie::old_level;

  std::int64_t rise(std::size_t k) const {
    return static_cast<std::int64_t>(k) * period + period / 2;
  }
  std::int64_t sample(std::size_t k) const {
    return edge == Edge::rising ? rise(k) : static_cast<std::int64_t>(k) * period;
  }
};

/// Bits that the encoder puts on SLO with rising edge 0, 1, 2 … of MA; 0 after the last one.
using Output = std::vector<std::uint8_t>;

/// LAT, ACK, START, CDS.
inline void append_request(Output& out, unsigned ack_clocks, bool cds) {
  out.push_back(1);
  out.insert(out.end(), ack_clocks, 0);
  out.push_back(1);
  out.push_back(cds ? 1 : 0);
}

/// The lowest `count` bits, first on the line first.
inline void append_bits(Output& out, std::uint64_t value, unsigned count) {
  for (unsigned i = count; i-- > 0;) out.push_back((value >> i) & 1U);
}

/// The samples of the peripheral with `clocks` clocks when SLO comes `delay` after MA. The line is
/// 1 until the first bit arrives.
inline void sample(const Output& out, const Clock& clock, std::int64_t delay, std::size_t clocks,
                   std::vector<std::uint8_t>& samples) {
  samples.resize(clocks);
  std::size_t arrived = 0;
  for (std::size_t k = 0; k < clocks; ++k) {
    const std::int64_t now = clock.sample(k);
    while (clock.rise(arrived) + delay < now + (clock.tie == Tie::new_level ? 1 : 0)) ++arrived;
    if (arrived == 0) {
      samples[k] = 1;
    } else {
      samples[k] = arrived <= out.size() ? out[arrived - 1] : 0;
    }
  }
}

/// CRC as the data sheets describe it: start 0, inverted.
inline std::uint64_t checksum(std::uint64_t data, unsigned bits, std::uint64_t polynomial,
                              unsigned width) {
  std::uint64_t reg = 0;
  for (unsigned i = bits; i-- > 0;) {
    const std::uint64_t feedback = ((reg >> (width - 1)) ^ (data >> i)) & 1U;
    reg = (reg << 1U) ^ (feedback != 0 ? polynomial : 0);
    reg &= (std::uint64_t{1} << width) - 1;
  }
  return reg ^ ((std::uint64_t{1} << width) - 1);
}

/// Samples as the peripheral stores them: `first_bit` bits of `filler`, the samples, and `filler`
/// again up to the end of `bytes`.
inline void pack(const std::vector<std::uint8_t>& samples, std::size_t first_bit,
                 std::uint64_t filler, std::vector<std::uint8_t>& bytes) {
  bytes.assign((first_bit + samples.size() + 7) / 8 + 2, 0);
  for (std::size_t at = 0; at < bytes.size() * 8; ++at) {
    const bool outside = at < first_bit || at >= first_bit + samples.size();
    const std::uint64_t bit = outside ? (filler >> (at % 64)) & 1U : samples[at - first_bit];
    bytes[at / 8] = static_cast<std::uint8_t>(bytes[at / 8] | (bit << (7 - at % 8)));
  }
}

}  // namespace biss::test::spi
