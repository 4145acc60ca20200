// Voltages as logic levels: samples of analog channels become edges by a threshold with hysteresis.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "biss/base/units.hpp"
#include "capture/edge_source.hpp"

namespace biss::capture {

/// A channel has no sample at this time (an empty cell): its level stays.
inline constexpr Nanovolts no_sample{std::numeric_limits<std::int64_t>::min()};
/// A channel's sample is not a number: its level is unknown.
inline constexpr Nanovolts bad_sample{std::numeric_limits<std::int64_t>::min() + 1};
/// A sample above the range of the instrument; below it, the negative of this. Larger voltages are
/// limited to it.
inline constexpr Nanovolts over_range{1'000'000'000'000'000};

/// A line rises when the voltage reaches centre + hysteresis / 2, and falls when the voltage
/// drops below centre - hysteresis / 2.
struct Threshold {
  Nanovolts centre;
  Nanovolts hysteresis;
};

/// Hysteresis of a threshold for which none is given.
inline constexpr Nanovolts default_hysteresis = millivolts(100);

/// Two channels that give one line: A - B. `pair` is the text `A-B`; names may contain `-`.
struct Differential {
  std::string pair;
  std::string name;
};

/// The user's settings for analog channels.
struct AnalogOptions {
  /// For every analog line. Nothing: measured for each line at the beginning of the capture.
  std::optional<Threshold> threshold = {};
  /// Their channels are not lines of their own.
  std::vector<Differential> differentials = {};

  bool given() const { return threshold.has_value() || !differentials.empty(); }
};

/// A column of samples. A logic channel has the samples 0 V and 1 V.
struct AnalogChannel {
  std::string name;
  bool logic = false;
};

/// Samples of all channels at successive times: row by row, `channels` values in a row.
struct SampleRows {
  std::vector<Picoseconds> times;
  std::vector<Nanovolts> values;

  void clear() {
    times.clear();
    values.clear();
  }
};

/// The steps between the times of samples.
struct SampleSteps {
  Picoseconds usual;     ///< the median
  Picoseconds longest;   ///< a longer step is a hole
  Picoseconds shortest;  ///< a shorter one is not a step of samples: the rows are changes
  /// At most a quarter of the steps differ from the usual one, and none is too short.
  bool constant = false;
};

/// \param digit the value of the last digit of a time: steps of rounded times differ by this value
SampleSteps steps_of(std::span<const Picoseconds> times, Picoseconds digit);

/// A capture of samples, read once from front to back.
class AnalogSamples {
 public:
  virtual ~AnalogSamples() = default;

  /// Constant. At least one, at most `max_analog_channels`.
  virtual const std::vector<AnalogChannel>& channels() const = 0;
  /// Puts the next rows, a bounded number, into the empty `rows`; none at the end. Times never
  /// fall. Rows before an error are delivered with it; it is the last call.
  virtual std::optional<CaptureError> next(SampleRows& rows) = 0;
  /// The time between two samples; 0 if the file does not give it.
  virtual Picoseconds sample_period() const { return {}; }
  /// The same as EdgeSource::sample_rate().
  virtual Hertz sample_rate() const { return {}; }
  /// The value of one unit in the last digit of a time, in the rows so far; nothing if no row can
  /// be missing.
  virtual std::optional<Picoseconds> time_digit() const { return std::nullopt; }
};

inline constexpr std::size_t max_analog_channels = 64;

/// The two levels of a signal.
struct SignalLevels {
  Nanovolts low;
  Nanovolts high;
};

/// The two levels of a signal, from its samples: the medians of the two classes into which a
/// threshold by Otsu's method divides them. Nothing if the samples do not form two levels: fewer
/// than 8 samples in a class, levels less than 100 mV apart, or classes as wide as their distance
/// (noise). Samples that are not voltages are ignored.
std::optional<SignalLevels> estimate_levels(std::span<const Nanovolts> samples);

/// Opens samples as edges.
///
/// If no threshold is given, it is measured for each line on the first 4096 rows, or on up to 2^20
/// samples if a line has not changed by then. It is the middle between both levels, with a
/// hysteresis of a fifth of their distance. A beginning in which no line changes is skipped,
/// whatever its length. An analog line without two levels takes the threshold of the analog line
/// with the largest swing; it must be clearly above or below, else its level is unknown.
///
/// The time of an edge is interpolated linearly between the two samples around the crossing. It is
/// the time of the first sample that shows it for a logic channel, after a missing sample, and for
/// a sample beyond the range.
///
/// Samples have a constant step. A line has a hole if its samples are missing for longer than one
/// and a half steps: its level is unknown from the last row before the hole up to its next sample.
/// Rows of logic channels alone may be changes.
///
/// Fails with `malformed` if voltages have no constant step, with `no_two_levels` if no line has
/// two levels, with `no_such_channel` for a differential that names other channels, and with the
/// errors of the samples.
Opened open_analog(std::unique_ptr<AnalogSamples> samples, const AnalogOptions& options);

}  // namespace biss::capture
