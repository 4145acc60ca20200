// The quick way through a capture: cycles that are clean are read from arrays of edges, many edges
// at once. The decoder reads all others edge by edge, and both give the same rows.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "biss/frame/codec.hpp"
#include "biss/timing/device_timing.hpp"
#include "decode/clean_measure.hpp"
#include "decode/cycle_reader.hpp"
#include "wire/edge.hpp"

namespace biss::decode {

using wire::LineRun;

/// A place in a run: the next change of each line.
struct RunPlace {
  std::size_t ma = 0;
  std::size_t slo = 0;

  bool operator==(const RunPlace&) const = default;
};

/// A stretch of a capture: no change of either line is missing between the first and the last.
struct PairRun {
  LineRun ma;
  LineRun slo;

  RunPlace end() const { return {ma.times.size(), slo.times.size()}; }
};

/// A cycle that was found in a run, and its place: from the falling edge of MA that begins it to
/// the edge that begins the next request.
struct CleanCycle {
  RunPlace begin;
  RunPlace end;
  CycleReading reading;
};

/// Finds the clean cycles of a run: the cycles that the Decoder reads in the same way after any
/// other cycles, if it waits for a request when they begin.
class CleanCycleFinder {
 public:
  /// Without a format, as CycleReader. Nothing is clean for a master without compensation; if
  /// Cycle::signal is requested, no cycle with a pulse is clean.
  CleanCycleFinder(const std::optional<FrameFormat>& format, const DeviceTiming& timing,
                   const MarginSetup& margin);

  /// False: nothing will be found.
  bool may_find() const { return margin_.compensated; }

  /// The clean cycles in order.
  /// \param found is emptied first; its memory is used again
  /// \param ahead memory that is read next; it is fetched into the cache during the search
  void find(const PairRun& run, std::vector<CleanCycle>& found,
            std::span<const std::uint8_t> ahead = {});

 private:
  void fetch_ahead();
  bool read(CleanCycle& cycle, const CleanLines& lines);
  bool read_frame(CycleReading& reading);
  bool read_payload(std::size_t start_bit, Cycle& cycle) const;
  void measure_times(CycleReading& reading) const;
  std::optional<Picoseconds> release(std::size_t last_bit) const;
  bool measure_signal(const CleanLines& lines, std::int64_t high_since, Cycle& cycle) const;
  LineSignal::Changes measure_changes(const CleanLines& lines, std::size_t rises) const;

  std::optional<FrameCodec<>> codec_;
  // The same as CycleReader::needs_next().
  bool needs_next_ = false;
  DeviceTiming timing_;
  MarginSetup margin_;
  CleanSetup setup_;
  CleanMeasure measured_;
  CleanScratch scratch_;
  std::span<const std::uint8_t> ahead_;
};

}  // namespace biss::decode
