// Edges to samples: what the writers of sampled formats share, and raw samples.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "capture/edge_writer.hpp"
#include "capture/sample_clock.hpp"
#include "capture/sample_layout.hpp"

namespace biss::capture {

/// Samples the lines at a rate, the first sample at time 0, the last at the end of the capture or
/// just behind it. A sample shows what has happened up to its own time, so what is shorter than a
/// sample may be lost. A line is low until its first edge, and where its level is unknown. Times
/// before zero cannot be written.
class SampledWriter : public EdgeWriter {
 protected:
  /// Line k of the writer is layout.lines[k]. With more than 64 lines every call fails with
  /// `too_many_lines`. \pre otherwise fault_of(layout) is null
  SampledWriter(const RawLayout& layout, ByteSink& sink);

  /// The bytes of the next samples, whole ones, at most 64 KiB at a time; calls flush_full().
  virtual bool put_samples(std::string_view bytes) = 0;
  /// The last sample has been put.
  virtual void put_close() = 0;

 private:
  void put(const wire::Edge& edge, bool new_time) final;
  void put_end(Picoseconds end_time, bool later) final;
  bool negative_times() const final { return false; }
  void put_until(std::uint64_t index);

  SampleClock clock_;
  std::size_t unit_bytes_;
  std::vector<unsigned> bits_;
  std::uint64_t levels_ = 0;
  std::uint64_t next_ = 0;
  Picoseconds last_time_;
  // Copies of the sample that stands now, made when they are needed.
  std::string copies_;
};

/// Writes the samples and nothing else.
class RawWriter final : public SampledWriter {
 public:
  RawWriter(const RawLayout& layout, ByteSink& sink) : SampledWriter(layout, sink) {}

 private:
  bool put_samples(std::string_view bytes) override;
  void put_close() override {}
};

}  // namespace biss::capture
