// Captures with known content, each as .vcd and as .csv.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace biss::verbs {

struct ReferenceFrame {
  double time_ns = 0;
  double ack_clocks = 1;
  std::uint64_t position = 0;
  std::string nE;
  std::string nW;
  bool good = true;  ///< the CRC is right on the line
};

struct ReferenceCapture {
  std::string path;  ///< without the extension
  std::string format;
  double line_delay_ns = 0;
  std::vector<ReferenceFrame> frames;
};

/// Three captures made by `biss simulate`. With the variable BISS_SHARED in the environment (see
/// `make test-shared`), the captures of hardware and of independent cores in that folder.
const std::vector<ReferenceCapture>& reference_captures();

}  // namespace biss::verbs
