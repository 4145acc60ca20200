// `--raw-rate`, `--raw-bytes`, `--threshold` and `--differential`: what a file of samples does not
// say of itself.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "biss/base/units.hpp"
#include "capture/analog.hpp"
#include "capture/samples.hpp"

namespace biss::verbs {

class Verb;

/// What the user said of his samples.
struct RawSamples {
  /// Of raw samples. Nothing: he has none.
  std::optional<Hertz> rate;
  /// Of a raw sample, 1 to 8.
  std::uint64_t bytes = 1;
  /// How voltages become levels.
  capture::AnalogOptions analog = {};
};

/// Declares the options. \pre raw outlives the parsing
void add_raw_options(Verb verb, RawSamples& raw);

/// The layout of one file. Bit k of a sample is the line `Dk`, bit 0 the lowest of the first byte.
/// Where `ma` and `slo` both name such a line, no other bit is looked at; else every one is a line.
/// \param ma,slo names of lines in this file; empty where not known
/// \pre raw.rate is given
capture::RawLayout layout_of(const RawSamples& raw, const std::string& ma, const std::string& slo);

}  // namespace biss::verbs
