// A master that reads the design's encoder: biss_master with a cable.
#pragma once

#include <cstdint>
#include <string>

#include "capi/biss_c.h"
#include "sim/random.hpp"
#include "simulators/cable.hpp"
#include "simulators/instance.hpp"

namespace biss::simulators {

class Master final : public Instance {
 public:
  Master(std::string name, Settings settings);

  /// Call it at each change of SLO or of `request` and at the time returned.
  std::int64_t step(std::int64_t now, bool slo, bool request);
  bool level() const override { return ma_.received(); }
  /// First rising edges of MA at the design so far.
  std::uint64_t latches() const { return latches_; }
  /// Compares with the values that the design was given at LAT.
  bool compare(const std::string& cause) override;
  void finish() override;

 private:
  void open_master(Picoseconds period);
  void advance(std::int64_t now);
  void begin(std::int64_t now);
  void end(std::int64_t now);
  void check_release(std::int64_t now, std::uint32_t clocks);
  std::int64_t deadline() const;

  biss_master master_{};
  Picoseconds period_{};
  biss_output output_{true, BISS_NEVER};
  Cable ma_;
  Cable slo_;
  sim::Random jitter_;
  Picoseconds line_delay_{};
  std::int64_t now_ = 0;
  bool request_ = false;
  bool slo_sent_ = true;
  /// MA rests for a timeout before the first request.
  bool started_ = false;
  std::int64_t not_before_ = 0;

  // The request that is running.
  bool running_ = false;
  std::uint64_t latches_ = 0;
  std::uint32_t clocks_ = 0;
  std::int64_t last_edge_ = 0;
  // The last rising edge of SLO: its number of clocks, and its time after the last edge of MA.
  struct Rise {
    std::uint32_t clocks = 0;
    std::int64_t low = 0;
  };
  Rise rise_{};
};

}  // namespace biss::simulators
