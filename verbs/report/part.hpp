// A part of a capture that is too large for a page, and the overview of the whole capture.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "verbs/common/page.hpp"
#include "verbs/decode/decode_run.hpp"

namespace biss::verbs {

/// Bytes as text of a page: base64 of gzip; the same bytes give the same text.
std::string packed(std::string_view bytes);

struct CapturePart {
  /// A VCD and the JSON object of view/src/core/report.ts, as packed() gives them.
  std::string capture;
  std::string report;
  PageSettings settings;
  /// The contents of the part and the omissions, one sentence each.
  std::vector<std::string> notes;
};

/// \param options the options of `run`, which has opened its capture
/// \param given the options of the command line
/// \param room the most characters of both texts
/// \return the status if there is no part; the reason has been printed
tl::expected<CapturePart, ExitStatus> part_of_capture(DecodeOptions& options, DecodeRun& run,
                                                      const std::vector<const Option*>& given,
                                                      std::string_view name, std::size_t room);

}  // namespace biss::verbs
