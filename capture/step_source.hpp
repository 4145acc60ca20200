// What the readers of simulators' binary files share: edges are read in steps.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "capture/edge_source.hpp"

namespace biss::capture {

/// An EdgeSource that a format completes by step().
class StepSource : public EdgeSource {
 public:
  const std::vector<std::string>& lines() const final { return lines_; }
  Picoseconds end_time() const final { return now_; }
  Result<std::span<const wire::Edge>, CaptureError> next_block() final;

 protected:
  explicit StepSource(std::vector<std::string> lines) : lines_(std::move(lines)) {}

  /// Pushes at most one edge a line, or calls finish() or fail().
  virtual void step() = 0;

  void finish() { state_ = State::ended; }
  /// Ends reading with an error, to be returned after the edges that came before it.
  void fail(const CaptureError& error) {
    error_ = error;
    state_ = State::failed;
  }
  bool failed() const { return state_ == State::failed; }

  EdgeBlock block_;
  Picoseconds now_;

 private:
  enum class State : std::uint8_t { reading, ended, failed };

  std::vector<std::string> lines_;
  State state_ = State::reading;
  CaptureError error_;
};

}  // namespace biss::capture
