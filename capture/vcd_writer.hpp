// Edges as a value change dump.
#pragma once

#include <string>
#include <vector>

#include "capture/edge_writer.hpp"

namespace biss::capture {

/// Writes a VCD with a time scale of 1 ps and a one-bit wire a line; only changes. White space and
/// control characters in names become `_`. Times before zero cannot be written.
class VcdWriter final : public EdgeWriter {
 public:
  VcdWriter(std::vector<std::string> lines, ByteSink& sink);

 private:
  void put(const wire::Edge& edge, bool new_time) override;
  void put_end(Picoseconds end_time, bool later) override;
  bool negative_times() const override { return false; }
  void put_header();
  void put_time(Picoseconds time);

  std::vector<std::string> ids_;
};

}  // namespace biss::capture
