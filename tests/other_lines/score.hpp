// Runs recognise_protocol() on captures of every protocol and counts what it takes them for.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "identify/protocol.hpp"
#include "tests/other_lines/drawing.hpp"

namespace biss::other_lines {

/// A kind of capture, how many there are in a thousand, and the expected name.
struct Kind {
  std::string_view name;
  unsigned share = 0;
  identify::Protocol protocol{};
  Drawing (*draw)(Dice&) = nullptr;
};

extern const std::array<Kind, 14> kinds;

/// A capture of the simulator: any encoder of the catalogue, any clock and cable it permits, ACK of
/// up to 40 us, up to a tenth of the cycles damaged.
Capture biss_capture(Dice& dice);

struct Row {
  std::string_view name;
  identify::Protocol protocol{};
  std::array<unsigned, identify::protocol_count> counts{};
  unsigned all = 0;
  /// Called BiSS C with a confidence of 0.5 or more.
  unsigned taken_for_biss = 0;
  /// Least confidence in BiSS C.
  double least_biss = 1;

  unsigned right() const { return counts[static_cast<std::size_t>(protocol)]; }
};

struct Score {
  /// One row for each kind, then BiSS C.
  std::vector<Row> rows;
  /// One line for each capture that is wrong.
  std::string wrong;

  Row row(std::string_view name) const;
};

/// The captures of a seed: `others` of other protocols, `biss` of BiSS C. No two seeds below 2^16
/// share a capture.
Score score(std::uint64_t seed, unsigned others, unsigned biss);

/// The confusion table of lab/reports/identify.md, a row for each kind.
std::string table_of(const Score& score);

}  // namespace biss::other_lines
