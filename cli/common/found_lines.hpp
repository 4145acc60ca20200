// MA and SLO among the lines of a capture, for every verb that reads one.
#pragma once

#include <span>
#include <string>

#include "cli/common/capture_input.hpp"
#include "cli/common/exit_status.hpp"
#include "decode/cycle_reader.hpp"
#include "decode/lines.hpp"

namespace biss::cli {

/// So much of a capture's beginning is looked at to find MA and SLO, and how fast requests come.
inline constexpr std::size_t edges_at_beginning = std::size_t{1} << 18U;

struct LinesFound {
  /// Meaningful where `status` is done.
  decode::FoundLines found;
  /// The capture's first edges, valid until CaptureInput::next().
  std::span<const wire::Edge> beginning;
  ExitStatus status = ExitStatus::done;
  /// One line that says why there are none.
  std::string problem;
};

/// \param ma,slo as the user named them, empty where he did not
/// \return usage for a name that the capture does not have, data_failed where no two lines look
///   like MA and SLO, io where reading failed
LinesFound find_capture_lines(CaptureInput& input, const std::string& ma, const std::string& slo,
                              const decode::CycleReader& reader);

}  // namespace biss::cli
