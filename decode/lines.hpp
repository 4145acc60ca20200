// Which lines of a capture are MA and SLO: the lines given, else by name, else by behaviour.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "decode/decoder.hpp"

namespace biss::decode {

/// Why MA and SLO are not known.
enum class LineProblem : std::uint8_t {
  no_such_ma,       ///< no line of the capture has the name given for MA
  no_such_slo,      ///< no line of the capture has the name given for SLO
  same_line,        ///< one line cannot be both
  too_few_lines,    ///< fewer than two lines of the capture change
  nothing_behaves,  ///< no pair of lines looks like MA and SLO
  ambiguous,        ///< several pairs fit equally well and carry different data
};

struct LineError {
  LineProblem problem{};
  /// With `ambiguous`: the pairs that fit.
  std::vector<Lines> candidates = {};
  /// With `ambiguous`: `LineRequest::each` finds every pair.
  bool each_helps = false;
};

/// How MA and SLO were found.
enum class LineOrigin : std::uint8_t { given, by_name, by_behaviour };

struct FoundLines {
  Lines lines;
  LineOrigin origin = LineOrigin::given;
  /// No cycle can be read from these lines, but some can with the two exchanged.
  bool look_swapped = false;
  /// Names show further encoders in this capture.
  bool further_pairs = false;
};

/// The user's choice of lines; an empty name means that none is given.
struct LineRequest {
  std::string_view ma;
  std::string_view slo;
  /// Find every pair, not one.
  bool each = false;
};

/// Finds MA and SLO: one pair, or every pair when `request.each` is set.
///
/// A name given matches a whole name, or the end of one that begins after a dot or a colon, in
/// upper or lower case. Usual names (MA, SLO, CLK, DATA, …) may carry a number, a letter or a
/// prefix (MA1, MA_A, enc2_SLO). Pairs come from one scope and have the same number, letter or
/// prefix. Without names, all pairs of the busiest lines are tried with `reader`, and the one with
/// the best cycles is taken. If several pairs fit equally well, the data decides: pairs with the
/// same data are one encoder and the best of them is taken; otherwise the choice is `ambiguous`.
/// \param names the lines of the capture
/// \param beginning edges from the beginning of the capture
tl::expected<std::vector<FoundLines>, LineError> find_lines(const std::vector<std::string>& names,
                                                            std::span<const wire::Edge> beginning,
                                                            const LineRequest& request,
                                                            const CycleReader& reader);

/// Finds MA alone: by the name `ma` when it is not empty, else by the name MA, else the only line,
/// else by find_lines(). Candidates of an `ambiguous` error have `slo` equal to `ma`.
tl::expected<wire::LineIndex, LineError> find_ma(const std::vector<std::string>& names,
                                                 std::span<const wire::Edge> beginning,
                                                 std::string_view ma, const CycleReader& reader);

}  // namespace biss::decode
