// What a control session is told and tells: CDS, options, and how an access ended.
#pragma once

#include <cstdint>
#include <optional>

#include "biss/base/units.hpp"
#include "biss/control/control_error.hpp"
#include "biss/control/control_frame.hpp"

namespace biss {

/// What a BiSS frame brought as CDS.
enum class CdsBit : std::uint8_t {
  zero,
  one,
  missing,  ///< no frame that may be believed (no answer, no START, cut short), or a reduced one
};

/// When a command to addressed slaves is executed.
enum class ExecuteIf : std::uint8_t {
  all_accept,   ///< all of them, and nobody else, said that they accept
  any_accepts,  ///< at least one of them, and nobody else, said so
  always,       ///< without looking at what they say, as long as one of them is there
};

struct ControlOptions {
  /// The longest that a slave may delay S of a byte, from the frame in which S could have come. 0:
  /// not at all. S in the first frame behind it still counts: it may have been ready in time.
  Picoseconds busy_max = register_busy_max;
  /// So many times an access that failed is tried again where worth_retrying() says so; a broadcast
  /// never is. A sequential access goes on with the first byte that is not yet done. A byte of a
  /// write whose echo was wrong may so be written twice: leave this 0 for registers that mind.
  std::uint8_t retries = 0;
};

/// How an access ended, or how far it is.
struct ControlOutcome {
  /// The longest that a slave delayed S of a byte; 0 where it never did. An S whose 1 was damaged
  /// on CDS looks like a delay too. What is read then is always found to be wrong. Not so a byte
  /// that is written behind another one: master and slave are a bit apart, and the echo agrees for
  /// half of all values though nothing was written. Read back what was written with a delay, or
  /// write such registers in accesses of their own, where the protocol allows no delay.
  Picoseconds longest_busy{};
  /// Frames since the access began, this one included.
  std::uint32_t frames = 0;
  /// Bytes read with a good CRC, or written with a good echo; the first ones of the request.
  std::uint8_t bytes_done = 0;
  /// Bit k: a slave took ID k in the last try. 0 for a broadcast.
  std::uint8_t slaves_present = 0;
  /// There are slaves beyond the eight with an ID (IDL8).
  bool more_slaves = false;
  /// Command: bit k for a slave with ID k that accepted (IDA).
  std::uint8_t accepted = 0;
  /// Control frames begun or to begin: 1, and one more for every retry.
  std::uint16_t tries = 0;
  /// Why not all was done that was asked; the last try's cause.
  std::optional<ControlError> error;
  /// Why there was a retry, the last time.
  std::optional<ControlError> retried;
};

}  // namespace biss
