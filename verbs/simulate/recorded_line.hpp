// A capture of which `simulate` uses one or two lines.
#pragma once

#include <span>
#include <string>

#include "decode/decoder.hpp"
#include "verbs/common/capture_input.hpp"
#include "verbs/common/exit_status.hpp"

namespace biss::verbs {

/// The capture, and the properties that its beginning shows.
class RecordedLine {
 public:
  explicit RecordedLine(Host& host) : host_(host), input_(host) {}

  /// Opens it and finds MA, and SLO if `needs_slo`. Prints why it cannot.
  ExitStatus open(const std::string& file, const std::string& ma, const std::string& slo,
                  const RawSamples& raw, bool needs_slo);

  CaptureInput& input() { return input_; }
  const decode::Lines& lines() const { return lines_; }
  /// An estimate from the shortest pulse of MA at the beginning, for the sample rate; 80 kHz to
  /// 10 MHz.
  Hertz clock() const { return clock_; }

 private:
  void guess_clock(std::span<const wire::Edge> beginning);

  Host& host_;
  CaptureInput input_;
  decode::Lines lines_;
  Hertz clock_;
};

}  // namespace biss::verbs
