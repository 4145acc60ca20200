// Texts for users about the identified format.
#pragma once

#include <string>
#include <vector>

#include "identify/format.hpp"
#include "report/summary.hpp"

namespace biss::verbs {

class DecodedCapture;

/// The text of `-f` for a candidate.
std::string text_of(const FrameFormat& format);

/// Names of encoders with the format of the candidate, separated by commas; at most `most`, then
/// dots.
std::string encoders_text(const identify::FormatCandidate& candidate, std::size_t most);

/// Why no format is certain and what to capture instead; empty if one is certain. One sentence
/// each.
std::vector<std::string> what_is_missing(const identify::FormatFinding& finding);

/// Bits that have not moved: `6 of the 26 bits of the position, nE, nW`; empty if all have.
std::string what_is_still(const identify::FormatCandidate& candidate);

/// Lines `format` of a summary: the format and how to give it; or what is missing, and the
/// candidates.
void add_identified(report::Summary& summary, const identify::FormatFinding& finding, bool used);

/// Lines `format` of a summary: the format by which the frames of the capture are judged, or that
/// there is none.
/// \param given the command line gives the format; otherwise the lines are the same as from
/// add_identified()
void add_used_format(report::Summary& summary, const DecodedCapture& capture, bool given);

}  // namespace biss::verbs
