// Compares, request by request, what the encoder sent with what the master read. One of them is the
// design under test, the other is simulated.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <string>
#include <vector>

#include "biss/frame/format.hpp"
#include "capi/biss_c.h"

namespace biss::simulators {

/// A channel as the design under test gives it, or as it was sent.
struct Value {
  biss_channel channel{};
  /// Otherwise the outcome has no such channel.
  bool given = false;
  /// No bit of the position is X or Z.
  bool known = true;
};

/// The outcome of one request.
struct Outcome {
  std::uint64_t request = 0;
  /// Since the start of the simulation.
  std::int64_t time_ps = 0;
  /// A name of biss_cause_name(). "fault" from the design that reads agrees with every cause of the
  /// encoder except "ok".
  std::string cause = "ok";
  std::array<Value, BISS_MAX_CHANNELS> values{};
};

/// A difference between the encoder and the master, or a rule of the line that was broken.
struct Mismatch {
  std::uint64_t request = 0;
  /// Since the start of the simulation.
  std::int64_t time_ps = 0;
  /// "position of channel 0", or the rule.
  std::string what;
  /// The value that the encoder sent, or the limit of the rule.
  std::string sent;
  /// The value that the master read, or the one that breaks the rule.
  std::string read;
};

class Scoreboard {
 public:
  static constexpr std::size_t listed_max = 100;
  static constexpr std::size_t waiting_max = 64;

  explicit Scoreboard(const FrameFormat& format) : format_(format) {}

  /// The expected outcome of a request, which waits for read(). If `waiting_max` requests wait
  /// already, the oldest is a mismatch and no longer waits.
  void sent(const Outcome& outcome);
  /// The outcome of the oldest waiting request. True if it is the expected one. If no request waits,
  /// it is a mismatch.
  bool read(const Outcome& outcome);
  /// The newest request is not compared, if it is this one: the simulation ended within it.
  void withdraw(std::uint64_t request);
  /// Waiting requests were not read: each is a mismatch, and no longer waits.
  void fail_waiting();
  /// A rule of the line was broken: a mismatch of `rule`, `limit` and `seen`, like "timeout",
  /// "12.5 to 40 µs" and "7 µs".
  void broken(std::uint64_t request, std::int64_t time_ps, std::string rule, std::string limit,
              std::string seen);

  /// Requests that were sent and read.
  std::uint64_t compared() const { return compared_; }
  /// All of them; a request may have several.
  std::uint64_t mismatches() const { return mismatches_; }
  /// The first mismatches, at most `listed_max`.
  const std::vector<Mismatch>& listed() const { return listed_; }

 private:
  void compare_channel(const Outcome& sent, const Outcome& read, std::size_t channel);
  void add(const Outcome& outcome, std::string what, std::string sent, std::string read);

  FrameFormat format_;
  std::deque<Outcome> waiting_;
  std::vector<Mismatch> listed_;
  std::uint64_t compared_ = 0;
  std::uint64_t mismatches_ = 0;
};

}  // namespace biss::simulators
