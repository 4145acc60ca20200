// Which lines of a capture are MA and SLO: as told, else by name, else by behaviour.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "biss/base/result.hpp"
#include "decode/decoder.hpp"

namespace biss::decode {

/// Why MA and SLO are not known.
enum class LineProblem : std::uint8_t {
  no_such_ma,       ///< no line of the capture has the name given for MA
  no_such_slo,      ///< no line of the capture has the name given for SLO
  same_line,        ///< one line cannot be both
  too_few_lines,    ///< the capture has fewer than two lines that move
  nothing_behaves,  ///< no pair of lines looks like MA and SLO
};

enum class LineChoice : std::uint8_t { told, by_name, by_behaviour };

struct FoundLines {
  Lines lines;
  LineChoice how = LineChoice::told;
  /// As they are, no cycle reads; the other way round some do.
  bool look_swapped = false;
};

/// Finds the two lines.
///
/// Names are compared without regard to case and to the scope before the last dot. By behaviour: of
/// all pairs among the busiest lines the one is taken whose cycles decode best with this reader.
/// \param names the capture's lines
/// \param beginning edges from the front of the capture, as many as are at hand
/// \param ma,slo names that the user gave; empty where he gave none
Result<FoundLines, LineProblem> find_lines(const std::vector<std::string>& names,
                                           std::span<const wire::Edge> beginning,
                                           std::string_view ma, std::string_view slo,
                                           const CycleReader& reader);

}  // namespace biss::decode
