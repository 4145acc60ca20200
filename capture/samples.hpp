// Captures that hold samples: their layout and clock, reading, writing, and files of raw samples.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "biss/base/units.hpp"
#include "capture/buffer.hpp"
#include "capture/bytes.hpp"
#include "capture/edge_source.hpp"
#include "capture/edge_writer.hpp"
#include "capture/pair_source.hpp"

namespace biss::capture {

/// A sample is a little-endian number of at most this many bytes: 64 lines.
inline constexpr std::size_t max_unit_bytes = 8;

/// A line and its bit in the sample; bit 0 is the lowest of the first byte.
struct SampleLine {
  std::string name;
  unsigned bit = 0;
};

std::vector<std::string> names_of(std::span<const SampleLine> lines);

/// Raw samples do not describe themselves; this is their description. Bits without a line are
/// ignored.
struct RawLayout {
  Hertz rate;
  std::size_t unit_bytes = 1;
  std::vector<SampleLine> lines;
};

/// The fault of a layout, as static text with a description of a valid one; null if there is no
/// fault.
const char* fault_of(const RawLayout& layout);

/// The lines in this order on bits 0, 1, …, in as few bytes as hold them.
RawLayout packed_layout(const std::vector<std::string>& lines, Hertz rate);

/// Sample `i` is taken `i / rate` seconds after the first, rounded to the nearest picosecond. Each
/// time is computed from the index, so that rates whose period is not a whole number of picoseconds
/// (3 MHz, 48 MHz) do not drift.
class SampleClock {
 public:
  /// \pre rate is not 0 Hz
  constexpr explicit SampleClock(Hertz rate)
      : rate_(rate.count), step_(second % rate.count == 0 ? second / rate.count : 0) {}

  constexpr Hertz rate() const { return Hertz{static_cast<std::uint32_t>(rate_)}; }

  /// \pre index <= last_index()
  constexpr Picoseconds time_of(std::uint64_t index) const {
    return Picoseconds{static_cast<std::int64_t>(count_of(index))};
  }

  /// Picoseconds between two samples; 0 if the period is not a whole number of them, or 2^32 or
  /// more.
  constexpr std::uint32_t whole_step() const {
    return step_ > std::numeric_limits<std::uint32_t>::max() ? 0
                                                             : static_cast<std::uint32_t>(step_);
  }

  /// Samples counted from `first` on become their times: each one as time_of() gives it, at a
  /// fraction of its cost.
  /// \pre no sample is 4096 or more after `first`, or after last_index()
  void times_after(std::uint64_t first, std::span<std::int64_t> samples) const;

  /// The first sample that shows a change at `time`: its own time is `time` or later.
  /// \pre time is not negative
  constexpr std::uint64_t first_at_or_after(Picoseconds time) const {
    const auto wanted = static_cast<std::uint64_t>(time.count);
    std::uint64_t index = whole_periods(wanted);
    // Rounding moves a sample by half a picosecond at most.
    while (index > 0 && count_of(index - 1) >= wanted) --index;
    while (count_of(index) < wanted) ++index;
    return index;
  }

  /// The last sample whose time can be represented.
  constexpr std::uint64_t last_index() const {
    return whole_periods(std::numeric_limits<std::int64_t>::max());
  }

 private:
  static constexpr std::uint64_t second = picoseconds_per_second;
  // A second is a million times a million, so two steps of long division fit 64 bits.
  static constexpr std::uint64_t million = 1'000'000;

  constexpr std::uint64_t count_of(std::uint64_t index) const {
    if (step_ != 0) return index * step_;
    const std::uint64_t scaled = index % rate_ * million;
    const std::uint64_t rest = (scaled % rate_ * million + rate_ / 2) / rate_;
    return index / rate_ * second + scaled / rate_ * million + rest;
  }

  // How often the exact period fits into that many picoseconds.
  constexpr std::uint64_t whole_periods(std::uint64_t count) const {
    const std::uint64_t rest = count % second;
    const std::uint64_t scaled = rest / million * rate_;
    const std::uint64_t below = (scaled % million * million + rest % million * rate_) / second;
    return count / second * rate_ + scaled / million + below;
  }

  std::uint64_t rate_;
  std::uint64_t step_;  // the period if it is a whole number of picoseconds, else 0
};

/// The period of a rate, rounded up to the picosecond. \pre rate is not 0 Hz
Picoseconds longest_period(Hertz rate);

/// How the samples of a capture are read.
struct SampleReading {
  /// Bytes of a piece if the samples of the file are not divided. The changes found in a piece fit
  /// into a second-level cache too.
  std::size_t piece_bytes = 2 * default_piece_bytes;
  /// The checksums of compressed samples are verified.
  bool verify = true;
};

/// A member of an archive after inflating, as described in the directory of the archive.
struct DeflatedSamples {
  std::uint64_t size_bytes = 0;
  std::uint32_t checksum = 0;
  CaptureError damaged;  ///< the error if this is not true, without `expected`
};

/// Memory of a piece has room for the beginning of a sample before the bytes.
inline constexpr std::size_t begun_room = max_unit_bytes;

/// The bytes of samples on their way to the thread that expands them.
struct PackedSamples {
  /// Holds the bytes, after `begun_room` bytes that are free, unless they lie elsewhere.
  Buffer memory;
  std::span<const std::uint8_t> bytes;
  /// The bytes after them that are already in memory.
  std::span<const std::uint8_t> ahead;
  std::optional<DeflatedSamples> deflated;  ///< nothing if `bytes` are the samples

  /// Memory for `count` bytes, which are not the bytes yet.
  std::span<std::uint8_t> room(std::size_t count) {
    return memory.take(begun_room + count).subspan(begun_room);
  }
  /// Puts the beginning of a sample before the bytes. \pre they are in the memory
  void prepend(std::span<const std::uint8_t> begun);
};

/// The wanted properties of a piece.
struct FetchWish {
  std::size_t piece_bytes = 0;
  std::size_t unit_bytes = 1;
  /// The last piece ended with a whole sample. Otherwise the bytes are in the memory of the piece and
  /// not deflated.
  bool at_sample = true;
};

/// The bytes of all samples, in order, in pieces of any length.
class SamplePieces {
 public:
  virtual ~SamplePieces() = default;

  /// The next bytes as a piece, which keeps them; false at the end. Deflated bytes hold whole samples
  /// and are not looked at here. Not called again after an error.
  virtual Result<bool, CaptureError> fetch(PackedSamples& piece, const FetchWish& wish) = 0;
};

/// The samples as edges. A capture without a whole sample is `empty`; one that ends inside a sample
/// is `truncated`, after its edges; samples beyond 106 days are `time_out_of_range`. An impossible
/// layout fails immediately with `bad_layout`.
Opened open_samples(const RawLayout& layout, std::unique_ptr<SamplePieces> pieces,
                    const SampleReading& reading = {}, bool is_raw = false);

/// Opens raw samples with this layout. Fails with `bad_layout`, `empty`, `read_failed`,
/// `time_out_of_range`, and with `truncated` when the last sample is incomplete.
Opened open_raw(std::unique_ptr<ByteSource> bytes, const RawLayout& layout,
                const SampleReading& reading = {});

/// Samples the lines at a rate, the first sample at time 0, the last at the end of the capture or
/// just after it. A sample shows the level at its own time, so a pulse shorter than a sample may be
/// lost. A line is low until its first edge, and while its level is unknown. Times before zero
/// cannot be written.
class SampledWriter : public EdgeWriter {
 protected:
  /// Line k of the writer is layout.lines[k]. With more than 64 lines every call fails with
  /// `too_many_lines`. \pre otherwise fault_of(layout) is null
  SampledWriter(const RawLayout& layout, ByteSink& sink);

  /// The bytes of the next samples, whole ones and all equal, at most 64 KiB at a time; calls
  /// flush_full().
  virtual bool put_samples(std::string_view bytes) = 0;
  /// The last sample has been put.
  virtual void put_close() = 0;

 private:
  void put(const wire::Edge& edge, bool new_time) final;
  void put_end(Picoseconds end_time, bool later) final;
  bool negative_times() const final { return false; }
  void put_until(std::uint64_t index);

  SampleClock clock_;
  std::size_t unit_bytes_;
  std::vector<unsigned> bits_;
  std::uint64_t levels_ = 0;
  std::uint64_t next_ = 0;
  Picoseconds last_time_;
  // Copies of the present sample, made when they are needed.
  std::string copies_;
};

/// Writes the samples and nothing else.
class RawWriter final : public SampledWriter {
 public:
  RawWriter(const RawLayout& layout, ByteSink& sink) : SampledWriter(layout, sink) {}

 private:
  bool put_samples(std::string_view bytes) override;
  void put_close() override {}
};

}  // namespace biss::capture
