// `--raw-rate`, `--raw-bytes`, `--threshold` and `--differential`: the facts that a file of samples
// does not contain.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "biss/base/units.hpp"
#include "capture/analog.hpp"
#include "capture/samples.hpp"

namespace biss::verbs {

class Verb;

/// The options about samples.
struct RawSamples {
  /// The rate of raw samples. Empty: not given.
  std::optional<Hertz> rate;
  /// Size of a raw sample, 1 to 8.
  std::uint64_t bytes = 1;
  /// How voltages become levels.
  capture::AnalogOptions analog = {};
};

/// Declares the options. \pre raw outlives the parsing
void add_raw_options(Verb verb, RawSamples& raw);

/// The layout of one file. Bit k of a sample is the line `Dk`, bit 0 the lowest of the first byte.
/// If `ma` and `slo` both name such a line, all other bits are ignored; otherwise every bit is a
/// line.
/// \param ma,slo names of lines in this file; empty if unknown
/// \pre raw.rate is given
capture::RawLayout layout_of(const RawSamples& raw, const std::string& ma, const std::string& slo);

}  // namespace biss::verbs
