// Captures without any fault, of random encoders of the catalogue, clocks, cables and analysers.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "biss/catalogue/catalogue.hpp"
#include "decode/check.hpp"
#include "sim/line_setup.hpp"
#include "wire/edge.hpp"

namespace biss::campaign {

struct CleanCapture {
  const CatalogueEntry* entry = nullptr;
  sim::LineSetup setup;
  std::uint64_t cycles = 0;
  /// The analyser records from the first share of the time to the second, in thousandths.
  std::int64_t from = 0;
  std::int64_t to = 1'000;
  /// Time between two samples of the analyser; 0: it records every edge.
  Picoseconds sample{};
  Picoseconds phase{};

  /// The values from which it can be made again.
  std::string name() const;
};

/// The capture of this number; the same on every machine.
CleanCapture clean_capture(std::uint64_t number);

/// The edges of MA and SLO as the analyser records them; the first ones give the initial levels.
std::vector<wire::Edge> edges_of(const CleanCapture& capture);

/// Names of the rules that fail, with their notes; empty when all is well.
std::string failing_rules(const CleanCapture& capture, const decode::CheckSetup& setup);
/// The capture compared with its own encoder.
decode::CheckSetup own_limits(const CleanCapture& capture);

}  // namespace biss::campaign
