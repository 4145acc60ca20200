// Samples of a BiSS line, and the least work that planes of them cost.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace biss::bench {

inline constexpr const char* sampled_format_text = "pos32,nE,nW,crc6";

/// Samples of the whole line, ten seconds.
inline constexpr std::size_t whole_samples = 1'000'000'000;
/// Samples of an archive, and the number of samples from request to request, of some 600.
inline constexpr std::size_t archive_samples = std::size_t{192} << 20U;
inline constexpr std::size_t request_period = 3'125;
inline constexpr const char* request_line = "a request each 31 us";
/// The row with the ceiling of an archive: `.sr, LINE` and this.
inline constexpr const char* inflate_row = ", inflate by libdeflate";
/// Limits as shares of the ceiling's time: without the checksums, and with them.
inline constexpr double inflate_share = 1 / 0.6;
inline constexpr double verified_share = 1 / 0.5;

/// Samples at 100 MS/s of one byte: MA in bit 0 at 9.83 MHz with jitter, SLO in bit 1.
struct SampledLine {
  std::vector<std::uint8_t> samples;
  std::uint64_t requests = 0;
  /// The number of undamaged frames, and the sum of their positions.
  std::uint64_t good = 0;
  std::uint64_t position_sum = 0;
};

/// Frames of random positions, ACK of 1 to 24 clocks, a line delay that varies, and one damaged frame
/// in 1000; a request every `period` samples; 0: none.
SampledLine sampled_line(std::size_t samples, std::size_t period);

/// The samples as a `.sr` with chunks of 4 MiB.
std::string sr_archive(std::span<const std::uint8_t> samples);

/// The whole line with a request each `request_period`, and its archive: made by the first call.
const SampledLine& whole_line();
const std::string& whole_archive();

/// Both planes of each 16384 samples into a small buffer, with the best vectors of this processor.
std::uint64_t plane_pass(std::span<const std::uint8_t> samples);
/// Reads the bytes with the same vectors.
std::uint64_t read_pass(std::span<const std::uint8_t> bytes);

}  // namespace biss::bench
