// Compares the values sent with the values read, request by request.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <string>
#include <string_view>
#include <vector>

#include "biss/frame/format.hpp"
#include "capi/biss_c.h"

namespace biss::simulators {

/// A channel as the design under test gives it, or as it was sent.
struct Value {
  biss_channel channel{};
  bool given = false;
  /// The position has only bits that are 0 or 1.
  bool known = true;
};

/// The outcome of one request.
struct Outcome {
  std::uint64_t request = 0;
  std::int64_t time_ps = 0;
  /// A name of biss_cause_name(), or "fault": some cause other than ok.
  std::string cause = "ok";
  std::array<Value, BISS_MAX_CHANNELS> values{};
};

struct Mismatch {
  std::uint64_t request = 0;
  std::int64_t time_ps = 0;
  /// "position of channel 0"
  std::string what;
  std::string sent;
  std::string read;
};

class Scoreboard {
 public:
  explicit Scoreboard(const FrameFormat& format) : format_(format) {}

  /// The expected outcome of a request. At most `waiting_max` are kept.
  void sent(const Outcome& outcome);
  /// The outcome of the oldest waiting request. True if it is the expected one.
  bool read(const Outcome& outcome);
  /// The newest request is not compared, if it is this one: the simulation ended within it.
  void withdraw(std::uint64_t request);
  /// Waiting requests were not read: each is a mismatch.
  void drop_waiting();
  /// A rule of the line was broken.
  void broken(std::uint64_t request, std::int64_t time_ps, std::string rule, std::string limit,
              std::string seen);

  bool waits() const { return !waiting_.empty(); }
  std::uint64_t compared() const { return compared_; }
  std::uint64_t mismatches() const { return mismatches_; }
  /// The first ones, at most `listed_max`.
  const std::vector<Mismatch>& listed() const { return listed_; }

  static constexpr std::size_t listed_max = 100;
  static constexpr std::size_t waiting_max = 64;

 private:
  void compare_channel(const Outcome& sent, const Outcome& read, std::size_t k);
  void add(const Outcome& outcome, std::string what, std::string sent, std::string read);

  FrameFormat format_;
  std::deque<Outcome> waiting_;
  std::vector<Mismatch> listed_;
  std::uint64_t compared_ = 0;
  std::uint64_t mismatches_ = 0;
};

}  // namespace biss::simulators
