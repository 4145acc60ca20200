// The cases that a simulation has tried, each with its count.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "biss/base/units.hpp"
#include "biss/frame/format.hpp"
#include "simulators/scoreboard.hpp"

namespace biss::simulators {

struct Case {
  std::string group;
  std::string name;
  std::uint64_t hits = 0;
};

class Coverage {
 public:
  /// Lists a case that should come.
  void expect(std::string_view group, std::string_view name) { find(group, name); }
  void hit(std::string_view group, std::string_view name) { ++find(group, name).hits; }

  /// The cases of flags and of position bits in a frame of this format.
  void expect_values(const FrameFormat& format);
  void hit_values(const FrameFormat& format, const Outcome& sent);
  /// The line delay against the clock: at and around whole and half periods, at which a sampling
  /// point goes wrong first. And the clock, against the limits of the device.
  void expect_line();
  void hit_line(Picoseconds line_delay, Picoseconds period, const biss_timing& timing);
  /// The length of ACK, in clocks.
  void expect_ack();
  void hit_ack(std::int64_t clocks);

  const std::vector<Case>& cases() const { return cases_; }
  std::size_t hit_count() const;

 private:
  Case& find(std::string_view group, std::string_view name);

  std::vector<Case> cases_;
};

}  // namespace biss::simulators
