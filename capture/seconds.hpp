// Seconds as floating point numbers, as logic analysers store them, and picoseconds.
#pragma once

#include "biss/base/result.hpp"
#include "biss/base/units.hpp"
#include "capture/edge_source.hpp"

namespace biss::capture {

/// The exact value of the number, rounded once to the picosecond, halves away from zero. Fails with
/// `malformed` (not a number, or infinite) and `time_out_of_range` (beyond ±106 days).
Result<Picoseconds, CaptureCause> picoseconds_of(double seconds);

/// The period of a rate, rounded up; a second at most, which is longer than anything a period
/// decides. \pre rate > 0
Picoseconds period_of_rate(double rate);

/// The rate if it is a whole number of hertz, else 0 Hz.
Hertz whole_rate(double rate);

/// The nearest number of seconds. picoseconds_of() gives the same time back up to ±75 minutes;
/// beyond, a double is coarser than a picosecond.
double seconds_of(Picoseconds time);

}  // namespace biss::capture
