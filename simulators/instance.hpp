// The common part of an encoder and a master in a simulation.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <utility>

#include "simulators/coverage.hpp"
#include "simulators/scoreboard.hpp"
#include "simulators/settings.hpp"

namespace biss::simulators {

class Instance {
 public:
  Instance(Role role, std::string name, Settings settings)
      : role_(role),
        name_(std::move(name)),
        settings_(std::move(settings)),
        board_(settings_.format) {}
  virtual ~Instance() = default;
  Instance(const Instance&) = delete;
  Instance& operator=(const Instance&) = delete;

  Role role() const { return role_; }
  const std::string& name() const { return name_; }
  const Settings& settings() const { return settings_; }
  const Scoreboard& board() const { return board_; }
  const Coverage& coverage() const { return coverage_; }
  /// Requests that have ended.
  std::uint64_t requests() const { return requests_; }

  /// One more channel of the design's next outcome.
  void set_value(std::size_t channel, const Value& value) { staged_[channel] = value; }
  /// The design's outcome is complete. True unless a mismatch is found.
  virtual bool compare(const std::string& cause) = 0;
  /// The simulation is over.
  virtual void finish() = 0;

  virtual bool level() const = 0;

 protected:
  Outcome take_staged(std::uint64_t request, std::int64_t time_ps, const std::string& cause) {
    Outcome outcome{request, time_ps, cause, staged_};
    staged_ = {};
    return outcome;
  }

  // For derived classes, which fill them.
  Scoreboard& board() { return board_; }
  Coverage& coverage() { return coverage_; }
  void count_request() { ++requests_; }

 private:
  Role role_;
  std::string name_;
  Settings settings_;
  Scoreboard board_;
  Coverage coverage_;
  std::array<Value, BISS_MAX_CHANNELS> staged_{};
  std::uint64_t requests_ = 0;
};

}  // namespace biss::simulators
