// A capture read down to its request cycles, for the verbs that look at all of them.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "decode/cycle.hpp"
#include "decode/decoder.hpp"
#include "tools/capture_input.hpp"
#include "tools/exit_status.hpp"
#include "tools/format_option.hpp"
#include "tools/verb.hpp"

namespace biss::tools {

/// What the command line says of a capture and of the device in it.
struct CaptureArguments {
  std::vector<std::string> files;
  FormatArguments device;
  RawSamples raw;
  std::string ma;
  std::string slo;
};

/// FILE…, -f, --ma, --slo, the timing and the raw options.
void add_capture_options(CLI::App& verb, CaptureArguments& arguments);

class DecodedCapture {
 public:
  using OnCycle = std::function<void(std::uint64_t number, const decode::Cycle& cycle)>;

  /// Opens the files and finds MA and SLO. Says on stderr why not.
  ExitStatus open(const CaptureArguments& arguments);
  /// Reads to the end. Without a request cycle, or where reading fails, it says so on stderr; the
  /// cycles until then were told all the same.
  ExitStatus read(const OnCycle& on_cycle);

  /// Empty where none was given: frames are then judged by their structure alone.
  const std::optional<FrameFormat>& format() const { return format_; }
  const DeviceTiming& timing() const { return timing_; }
  const CaptureInput& input() const { return input_; }

 private:
  std::optional<FrameFormat> format_;
  DeviceTiming timing_;
  CaptureInput input_;
  decode::Lines lines_;
};

}  // namespace biss::tools
