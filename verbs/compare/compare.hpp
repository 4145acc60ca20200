// The parts of `biss compare`: the properties of a link that one capture shows, and the differences
// between two links with their effects. docs/compare.md explains each property and its effect.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "decode/check.hpp"
#include "decode/statistics.hpp"
#include "explain/diagnose.hpp"
#include "verbs/common/decoded_capture.hpp"

namespace biss::verbs {

struct Link {
  explain::Evidence evidence;
  explain::Context context;
  decode::Statistics statistics;
  /// By the limits of BiSS C, in the order of decode::Rule.
  std::array<decode::RuleResult, decode::rule_count> rules{};
  /// Names of MA and SLO, as read.
  std::string ma;
  std::string slo;
  /// As MarginSetup::resolution.
  Picoseconds resolution{};
  /// From the last edge of MA to the next request.
  decode::Distribution rest;
  /// The difference between the usual length of a level of MA and the shortest one in a cycle.
  decode::Distribution jitter_ma;
  /// The spread of the changes of SLO in a frame within a bit.
  decode::Distribution jitter_slo;
  /// From the sampling point to the nearest change of SLO, in thousandths of a period.
  decode::Distribution margin;
  /// Between two good frames in a row: counts, and counts per second.
  decode::Distribution step;
  decode::Distribution speed;
};

/// Reads a capture to its end. Empty if reading failed; input().error() then has the reason.
/// \pre next() was true and nothing has been read since
std::optional<Link> read_link(DecodedCapture& capture);

struct Difference {
  /// Words or a number.
  using Value = std::variant<std::string, double>;

  std::string property;
  /// Empty for words.
  std::string_view unit;
  Value good;
  Value bad;
  /// 0 to 1, two decimal places.
  double effect = 0;
};

/// All differences with an effect, the largest first. \pre both links have a request cycle
std::vector<Difference> differences(const Link& good, const Link& bad);

}  // namespace biss::verbs
