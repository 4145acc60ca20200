// How a capture has to be read: as it is, inverted, or with MA and SLO exchanged.
#pragma once

#include <span>

#include "decode/decoder.hpp"

namespace biss::explain {

/// The lines with which the cycles read best, and the changes that this needs.
struct Reading {
  decode::Lines lines;
  bool swapped = false;
  bool ma_inverted = false;
  bool slo_inverted = false;
};

/// Chooses polarity as decode::find_polarity(), and exchanges MA and SLO if the capture reads well
/// that way and hardly at all with `lines`.
/// \param lines as named by the user or the capture; an inversion there stays and is not a change
/// \param beginning edges from the beginning of the capture
Reading choose_reading(const decode::Lines& lines, std::span<const wire::Edge> beginning,
                       const decode::CycleReader& reader);

}  // namespace biss::explain
