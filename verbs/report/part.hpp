// A part of a capture that is too large for a page, and what the page shows of the whole.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "verbs/common/page_settings.hpp"
#include "verbs/decode/decode_run.hpp"

namespace biss::verbs {

struct CapturePart {
  /// A VCD and the JSON object of view/src/core/report.ts, as packed() gives them.
  std::string capture;
  std::string report;
  PageSettings settings;
  /// What the part contains and what was left out, a sentence each.
  std::vector<std::string> notes;
};

/// Reads the capture once; other verbs judge what it reads.
/// \param options those of `run`, which has gone to its capture
/// \param settings of the command line
/// \param room the most characters of both texts
/// \return why there is none; it has been printed
tl::expected<CapturePart, ExitStatus> part_of_capture(DecodeOptions& options, DecodeRun& run,
                                                      const PageSettings& settings,
                                                      std::string_view name, std::size_t room);

}  // namespace biss::verbs
