// The changes of two lines as arrays: the quick way from a capture to the decoder. Pieces are fetched
// one after the other, expanded by any thread, and settled in their order.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "capture/buffer.hpp"
#include "capture/edge_source.hpp"
#include "wire/edge.hpp"

namespace biss::capture {

/// Bytes of a piece, if the file itself is not divided.
inline constexpr std::size_t default_piece_bytes = std::size_t{1} << 18U;

/// The changes of one line in a piece of a capture.
struct LineChanges {
  /// The level from the first change on; each further change inverts it. The level at the end of
  /// the piece before is not known here. If it is the same, the first change is not a change.
  bool first_high = false;
  /// In picoseconds, never falling.
  std::vector<std::int64_t, Unfilled<std::int64_t>> times;

  wire::LineRun run(bool inverted = false) const { return {times, first_high != inverted}; }

  void clear() {
    first_high = false;
    times.clear();
  }
};

/// A stretch of a capture, on its way from the bytes of the file to the changes of two lines.
class PairPiece {
 public:
  virtual ~PairPiece() = default;

  /// Reads the bytes into `ma` and `slo`. Any thread may do this, once, between fetch() and
  /// settle(); it does not look at the source.
  virtual void expand() = 0;

  /// Memory that expand() of a later piece will read, with this number of pieces between the two;
  /// nothing if it is not known.
  virtual std::span<const std::uint8_t> ahead(std::size_t between) const {
    static_cast<void>(between);
    return {};
  }

  LineChanges ma;
  LineChanges slo;
};

/// The rest of a capture in pieces, for one pair of lines. fetch() and settle() may run at the same
/// time in two threads; each of them is called by one thread at a time.
class PairSource {
 public:
  using OnEdges = std::function<void(std::span<const wire::Edge>)>;

  virtual ~PairSource() = default;

  /// The next piece; null at the end, and if reading failed.
  /// \param used a piece of this source that was settled, whose memory may be used again; or null
  virtual std::unique_ptr<PairPiece> fetch(std::unique_ptr<PairPiece> used) = 0;

  /// Takes the pieces in the order in which they were fetched, each after expand().
  /// \return true: `ma` and `slo` are the changes of the piece. False: the piece holds something
  ///   that arrays cannot represent (an unknown level), or something is wrong. Its edges, also of
  ///   other lines, were delivered to `on_edges`, and `ma` and `slo` are not valid.
  virtual bool settle(PairPiece& piece, const OnEdges& on_edges) = 0;

  /// The last time in the settled pieces.
  virtual Picoseconds end_time() const = 0;
  /// Why reading ended before the end of the capture, once settle() has reached that place: no
  /// piece after that one counts. The same error as next_block() would give.
  virtual const std::optional<CaptureError>& error() const = 0;
};

}  // namespace biss::capture
