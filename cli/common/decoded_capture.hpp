// A capture read down to its request cycles, for the verbs that look at all of them.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "cli/common/capture_input.hpp"
#include "cli/common/exit_status.hpp"
#include "cli/common/format_option.hpp"
#include "cli/common/found_lines.hpp"
#include "cli/common/verb.hpp"
#include "decode/cycle.hpp"
#include "decode/cycle_reader.hpp"

namespace biss::cli {

/// What the command line says of a capture and of the device in it.
struct CaptureArguments {
  std::vector<std::string> files;
  FormatArguments device;
  RawSamples raw;
  std::string ma;
  std::string slo;
  /// The capture shows the inverse of the line. Where it is not given, the polarity is measured.
  bool invert_ma = false;
  bool invert_slo = false;
  /// When not given, the sample period of the capture, or 0.
  std::optional<Picoseconds> resolution;
};

/// FILE…, -f, --ma, --slo, --invert-ma, --invert-slo, --resolution, the timing and the raw options.
void add_capture_options(Verb verb, CaptureArguments& arguments);

/// How `marginal` is judged.
struct MarginArguments {
  bool no_compensation = false;
};

class DecodedCapture {
 public:
  /// False ends the reading.
  using OnCycle = std::function<bool(std::uint64_t number, const decode::Cycle& cycle)>;

  /// Opens the files and finds MA and SLO. Says on stderr why not.
  /// \param outputs what the verb will write; the capture itself is refused
  ExitStatus open(const CaptureArguments& arguments, const std::vector<std::string>& outputs,
                  const MarginArguments& margin = {});

  /// Reads to the end.
  /// \return false where reading failed, and input().error() says why; the cycles until then were
  ///   told all the same
  bool read(const OnCycle& on_cycle);
  /// For the one who saw no cycle: says it on stderr, and what to look for.
  ExitStatus no_request() const;

  /// Empty where none was given: frames are then judged by their structure alone.
  const std::optional<FrameFormat>& format() const { return format_; }
  const DeviceTiming& timing() const { return timing_; }
  const decode::MarginSetup& margin() const { return margin_; }
  const CaptureInput& input() const { return input_; }
  const decode::FoundLines& lines() const { return lines_.found; }
  /// The time from request to request at the capture's beginning, the median; 0 where there is
  /// none. To be asked before read().
  Picoseconds interval() const;

 private:
  decode::CycleReader reader() const { return decode::CycleReader(format_, timing_, margin_); }

  std::optional<FrameFormat> format_;
  DeviceTiming timing_;
  decode::MarginSetup margin_;
  CaptureInput input_;
  LinesFound lines_;
};

}  // namespace biss::cli
