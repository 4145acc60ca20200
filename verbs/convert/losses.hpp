// Losses by the format of the output, counted while a capture is converted.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "biss/base/units.hpp"
#include "capture/samples.hpp"
#include "report/summary.hpp"
#include "verbs/common/capture_output.hpp"
#include "wire/edge.hpp"

namespace biss::verbs {

/// More samples than this are a wrong rate or a wrong time, and would fill any disk.
inline constexpr std::uint64_t most_samples = 1'000'000'000'000;

/// The clock of the capture that is read.
struct CaptureClock {
  Hertz rate;          ///< 0 Hz if unknown
  Picoseconds period;  ///< 0 if the capture contains changes
};

class Losses {
 public:
  /// `rate` is the sample rate of the output. \pre it is not 0 Hz for a sampled format
  Losses(CaptureFormat format, const std::vector<std::string>& names, Hertz rate);

  /// An edge that is written, with the time that is written.
  void add(const wire::Edge& edge);
  /// The edge, or an end at that time, would make more than `most_samples`.
  bool too_many_samples(Picoseconds time) const;

  /// Adds a line for each kind of loss. \param path as the user calls the output
  void report(report::Summary& summary, const CaptureClock& input, std::string_view path) const;

 private:
  void report_samples(report::Summary& summary) const;
  void report_names(report::Summary& summary, std::string_view path) const;

  CaptureFormat format_;
  std::vector<std::string> names_;
  Hertz rate_;
  std::optional<capture::SampleClock> clock_;
  std::vector<std::optional<std::uint64_t>> last_sample_;  // of each line's last edge
  std::vector<bool> unknown_;                              // each line's last level
  std::uint64_t edges_ = 0;
  std::uint64_t moved_ = 0;
  std::uint64_t lost_ = 0;
  std::uint64_t unknown_edges_ = 0;
  std::uint64_t inexact_ = 0;
};

}  // namespace biss::verbs
