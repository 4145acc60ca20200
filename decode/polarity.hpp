// What the beginning of a capture shows before its format is known: inverted lines, and pauses of the
// clock within its requests.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "decode/decoder.hpp"

namespace biss::decode {

/// The first edges of MA and SLO, as many as a trial reads. Edges of other lines are left out.
std::vector<wire::Edge> first_edges(const Lines& lines, std::span<const wire::Edge> edges);

/// The same lines with the polarity that fits best.
///
/// MA is inverted where it rests low before most requests and the cycles read no worse that way.
/// SLO is inverted where most cycles are good only that way. What `lines` says already is kept.
/// \param beginning edges from the beginning of the capture
Lines find_polarity(const Lines& lines, std::span<const wire::Edge> beginning,
                    const CycleReader& reader);

/// The timeout of the encoder, estimated, if most cycles are good only if the master pauses its clock
/// for less than that within a request. Nothing for all other captures.
std::optional<Timeout> find_paused_timeout(const Lines& lines,
                                           std::span<const wire::Edge> beginning);

}  // namespace biss::decode
