// A capture of which one or two lines are used, as `simulate` takes it.
#pragma once

#include <span>
#include <string>

#include "cli/common/capture_input.hpp"
#include "cli/common/exit_status.hpp"
#include "decode/decoder.hpp"

namespace biss::cli {

/// The capture, and what was found at its front.
class RecordedLine {
 public:
  /// Opens it and finds MA, and SLO where `needs_slo`; says on stderr why not.
  ExitStatus open(const std::string& file, const std::string& ma, const std::string& slo,
                  const RawSamples& raw, bool needs_slo);

  CaptureInput& input() { return input_; }
  const decode::Lines& lines() const { return lines_; }
  /// A guess by the shortest pulse of MA at the front: for the sample rate; 80 kHz to 10 MHz.
  Hertz clock() const { return clock_; }

 private:
  bool find_ma(const std::string& ma);
  void guess_clock(std::span<const wire::Edge> beginning);

  CaptureInput input_;
  decode::Lines lines_;
  Hertz clock_;
};

}  // namespace biss::cli
