// An FST without its values: blocks, time scale, declarations, and when dumping was off.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "capture/bytes.hpp"
#include "capture/declared_lines.hpp"
#include "capture/edge_source.hpp"
#include "capture/gather.hpp"
#include "capture/timescale.hpp"
#include "capture/unpack.hpp"

namespace biss::capture {

/// Reads numbers of a block in memory. After the end of the memory, failed() is true and every
/// number is 0.
class FstCursor {
 public:
  explicit FstCursor(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  std::uint8_t byte() {
    if (at_ != bytes_.size()) return bytes_[at_++];
    failed_ = true;
    return 0;
  }
  /// Seven bits a byte, the lowest first; the last byte is below 128.
  std::uint64_t varint();
  /// The same in two's complement.
  std::int64_t signed_varint();
  std::uint64_t fixed64();
  /// Text up to a NUL.
  std::string text();

  bool at_end() const { return at_ == bytes_.size(); }
  std::size_t at() const { return at_; }
  bool failed() const { return failed_; }

 private:
  std::span<const std::uint8_t> bytes_;
  std::size_t at_ = 0;
  bool failed_ = false;
};

/// The place of the content of a block of value changes.
struct FstBlock {
  std::uint64_t place = 0;
  std::uint64_t size = 0;
  bool signed_index = false;  ///< VCDATA_DYN_ALIAS2
};

/// From `tick` on dumping is on or off.
struct FstSwitch {
  std::uint64_t tick = 0;
  bool on = false;
};

class FstFile {
 public:
  /// A block is held in at most this much memory.
  static constexpr std::uint64_t most_block_bytes = 256U << 20U;

  static tl::expected<FstFile, CaptureError> open(std::unique_ptr<ByteSource> bytes);

  const Timescale& timescale() const { return timescale_; }
  const std::vector<FstSwitch>& switches() const { return switches_; }
  /// The bytes that the initial value of each variable has.
  const std::vector<std::uint32_t>& lengths() const { return lengths_; }
  /// The one-bit signals; a variable is the number of its handle, from 0.
  DeclaredLines& declared() { return declared_; }
  std::uint64_t size() const { return bytes_.size(); }

  /// The next block of value changes; nothing after the last. Fails with `truncated`.
  tl::expected<std::optional<FstBlock>, CaptureError> next_block();

  /// Reads bytes; false when they are not there.
  bool read(std::uint64_t place, std::span<std::uint8_t> into) const {
    return bytes_.read(place, into);
  }
  /// Unpacks `packed_size` bytes at `place` into `into`, which has exactly the unpacked size. The
  /// bytes are stored without packing if both sizes are equal and `may_be_stored` is true.
  bool unpack(Packing packing, std::uint64_t place, std::uint64_t packed_size,
              std::span<std::uint8_t> into, bool may_be_stored = true);

 private:
  struct Section {
    std::uint8_t kind = 0;
    std::uint64_t place = 0;  // of the content
    std::uint64_t size = 0;
  };

  std::optional<Section> section_at(std::uint64_t place) const;
  std::optional<CaptureError> unwrap();
  std::optional<CaptureError> read_sections();
  std::optional<CaptureError> read_header(const Section& section);
  std::optional<CaptureError> read_geometry(const Section& section);
  std::optional<CaptureError> read_blackouts(const Section& section);
  std::optional<CaptureError> read_hierarchy(const Section& section);
  std::optional<CaptureError> unpack_hierarchy(const Section& section,
                                               std::vector<std::uint8_t>& into);
  std::optional<CaptureError> take_hierarchy(std::span<const std::uint8_t> hierarchy);
  std::optional<CaptureError> take_variable(std::uint8_t type, FstCursor& cursor,
                                            std::uint32_t& handles);

  PlacedBytes bytes_;
  Unpacker unpacker_;
  std::vector<std::uint8_t> packed_;
  Timescale timescale_;
  std::vector<FstSwitch> switches_;
  bool has_geometry_ = false;
  std::vector<std::uint32_t> lengths_;
  DeclaredLines declared_;
  std::uint64_t next_place_ = 0;
};

}  // namespace biss::capture
