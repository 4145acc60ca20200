// Requests at a constant rate to a real line, and their results.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "biss/base/units.hpp"
#include "decode/distribution.hpp"
#include "live/spi_port.hpp"

namespace biss::live {

/// A transfer that succeeded.
struct Transfer {
  Picoseconds time{};  ///< its begin, since the first request was due
  std::span<const std::uint8_t> bytes;
};

/// The results of all requests.
struct ReadCounts {
  std::uint64_t requests = 0;
  /// Requests that were not made: when they were due, this program did not run, or the encoder was
  /// not ready yet.
  std::uint64_t late = 0;
  std::array<std::uint64_t, port_fault_count> faults{};
  /// The errno of the last fault.
  int last_error = 0;
};

class LineReader {
 public:
  /// A port that is gone, or that has failed ten times in a row, is tried again after this time. The
  /// requests in between are not made and not counted.
  static constexpr Picoseconds pause_after_faults = milliseconds(100);

  /// \param cycle from one request to the next
  /// \param least no request comes earlier than this after the one before
  /// \param rest nor earlier than this after its end
  LineReader(SpiPort port, Picoseconds cycle, Picoseconds least, Picoseconds rest)
      : port_(std::move(port)), cycle_(cycle), least_(least), rest_(rest), due_(rest) {}

  void set_bytes(std::size_t bytes) { buffer_.resize(bytes); }

  /// Waits until the next request is due, and makes it. A port that is gone is opened again.
  /// \param on_fault called for each transfer that fails
  /// \param go_on asked before each request
  /// \return nothing when go_on() is false. The bytes are valid until the next call
  std::optional<Transfer> next(const std::function<void(PortFault, Picoseconds)>& on_fault,
                               const std::function<bool(Picoseconds)>& go_on);

  const ReadCounts& counts() const { return counts_; }
  /// How much later than due the requests began, in nanoseconds.
  const decode::Distribution& lateness() const { return lateness_; }
  SpiPort& port() { return port_; }

 private:
  SpiPort port_;
  Picoseconds cycle_;
  Picoseconds least_;
  Picoseconds rest_;
  std::vector<std::uint8_t> buffer_;
  ReadCounts counts_;
  decode::Distribution lateness_;
  std::optional<std::int64_t> began_;  // nanoseconds of the clock
  Picoseconds due_;
  unsigned faults_in_a_row_ = 0;
};

}  // namespace biss::live
