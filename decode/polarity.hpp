// Properties of a capture that its beginning shows before the format is known: inverted lines, and
// pauses of the clock within requests.
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
/// MA is inverted if it rests low before most requests and the cycles read no worse that way. SLO
/// is inverted if most cycles are good only that way. Inversions already set in `lines` are kept.
/// \param beginning edges from the beginning of the capture
Lines find_polarity(const Lines& lines, std::span<const wire::Edge> beginning,
                    const CycleReader& reader);

/// The estimated timeout of the encoder, if most cycles are good only with pauses of the clock
/// within a request that are shorter than this timeout. Nothing for all other captures.
std::optional<Timeout> find_paused_timeout(const Lines& lines,
                                           std::span<const wire::Edge> beginning);

}  // namespace biss::decode
