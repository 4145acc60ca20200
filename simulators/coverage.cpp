#include "simulators/coverage.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace biss::simulators {

namespace {

constexpr std::array<std::string_view, 8> line_delay_cases{
    "none",
    "below half a period",
    "half a period",
    "above half a period",
    "just below a whole period",
    "just above a whole period",
    "a period and a half",
    "more than two periods",
};

// A delay within a sixteenth of a period of a boundary is at the boundary.
std::string_view line_delay_case(Picoseconds line_delay, Picoseconds period) {
  const std::int64_t near = period.count / 16;
  const std::int64_t delay = line_delay.count;
  const std::int64_t phase = delay % period.count;
  if (delay == 0) return line_delay_cases[0];
  if (delay > 2 * period.count + near) return line_delay_cases[7];
  if (phase >= period.count - near) return line_delay_cases[4];
  if (delay >= period.count && phase <= near) return line_delay_cases[5];
  const bool at_half = phase >= period.count / 2 - near && phase <= period.count / 2 + near;
  if (at_half) return line_delay_cases[delay < period.count ? 2 : 6];
  return line_delay_cases[phase < period.count / 2 ? 1 : 3];
}

std::string_view flags_case(const biss_channel& channel) {
  if (!channel.nE) return channel.nW ? "error" : "error and warning";
  return channel.nW ? "neither" : "warning";
}

}  // namespace

Case& Coverage::find(std::string_view group, std::string_view name) {
  const auto found = std::find_if(cases_.begin(), cases_.end(), [&](const Case& one) {
    return one.group == group && one.name == name;
  });
  if (found != cases_.end()) return *found;
  cases_.push_back({std::string(group), std::string(name), 0});
  return cases_.back();
}

void Coverage::expect_values(const FrameFormat& format) {
  bool error = false;
  bool warning = false;
  for (const ChannelFormat& channel : format.channels()) {
    error = error || channel.error.present;
    warning = warning || channel.warning.present;
  }
  expect("flags", "neither");
  if (error) expect("flags", "error");
  if (warning) expect("flags", "warning");
  if (error && warning) expect("flags", "error and warning");
  for (const std::string_view name : {"0", "all bits 1", "other"}) expect("position", name);
  for (std::size_t k = 0; k < format.channel_count; ++k) {
    for (unsigned bit = 0; bit < format.channel_list[k].position_bits(); ++bit) {
      expect("position bit 0 and 1", fmt::format("channel {} bit {}: 0", k, bit));
      expect("position bit 0 and 1", fmt::format("channel {} bit {}: 1", k, bit));
    }
  }
}

void Coverage::hit_values(const FrameFormat& format, const Outcome& sent) {
  for (std::size_t k = 0; k < format.channel_count; ++k) {
    const biss_channel& channel = sent.values[k].channel;
    const unsigned bits = format.channel_list[k].position_bits();
    hit("flags", flags_case(channel));
    if (bits == 0) continue;
    const bool ones = channel.position == low_mask(bits);
    hit("position", channel.position == 0 ? "0" : ones ? "all bits 1" : "other");
    for (unsigned bit = 0; bit < bits; ++bit) {
      hit("position bit 0 and 1",
          fmt::format("channel {} bit {}: {}", k, bit, channel.position >> bit & 1U));
    }
  }
}

void Coverage::expect_line() {
  for (const std::string_view name : line_delay_cases) expect("line delay", name);
  for (const std::string_view name : {"lowest", "between", "highest"}) expect("clock", name);
}

void Coverage::hit_line(Picoseconds line_delay, Picoseconds period, const biss_timing& timing) {
  if (period.count <= 0) return;
  hit("line delay", line_delay_case(line_delay, period));
  const std::uint64_t rate = rate_of(period).count;
  const bool low = rate * 100 <= std::uint64_t{timing.clock_min_hz} * 102;
  const bool high = rate * 100 >= std::uint64_t{timing.clock_max_hz} * 98;
  hit("clock", low ? "lowest" : high ? "highest" : "between");
}

void Coverage::expect_ack() {
  for (const std::string_view name : {"one clock", "two clocks", "more clocks"})
    expect("ACK", name);
}

void Coverage::hit_ack(std::int64_t clocks) {
  hit("ACK", clocks <= 1 ? "one clock" : clocks == 2 ? "two clocks" : "more clocks");
}

std::size_t Coverage::hit_count() const {
  return static_cast<std::size_t>(
      std::count_if(cases_.begin(), cases_.end(), [](const Case& one) { return one.hits != 0; }));
}

}  // namespace biss::simulators
