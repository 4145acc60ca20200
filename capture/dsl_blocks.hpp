// The blocks of a DSLogic capture as they lie in its archive, and their samples as changes of two
// lines.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "capture/buffer.hpp"
#include "capture/dsl.hpp"
#include "capture/pair_source.hpp"
#include "capture/zip.hpp"

namespace biss::capture {

/// The samples of a probe in a block.
struct PackedPlane {
  std::span<const std::uint8_t> bytes;
  std::uint64_t size_bytes = 0;
  std::uint32_t checksum = 0;
  bool deflated = false;  ///< false: `bytes` are the samples, their checksum is verified
  bool readable = true;

  /// Makes the samples. False when they are damaged.
  /// \pre into.size() == size_bytes
  bool inflate(Inflater& inflater, bool verify, std::span<std::uint8_t> into) const;
};

/// Why the samples of a plane cannot be used.
inline constexpr const char* damaged_plane = "data that inflates to its size and checksum";

/// A block of all probes.
struct PackedBlock {
  std::uint64_t number = 0;         ///< counted from 0
  std::uint64_t first = 0;          ///< sample of the capture
  std::uint64_t samples = 0;        ///< of each probe
  std::vector<PackedPlane> planes;  ///< in the order of the header
  /// What is wrong with the block; then the planes before the fault are there, of which one may be
  /// damaged.
  const char* fault = nullptr;
  Buffer memory;

  CaptureError damaged(const char* expected) const;
};

/// Reads the blocks one after the other.
class DslBlocks {
 public:
  DslBlocks(std::unique_ptr<ZipArchive> archive, const DslHeader& header);

  /// The next block; false at the end. Fails with `empty` or `truncated` there.
  Result<bool, CaptureError> next(PackedBlock& block);

 private:
  const char* find_planes(PackedBlock& block);
  void read_planes(PackedBlock& block);

  std::unique_ptr<ZipArchive> archive_;
  std::vector<unsigned> probes_;
  std::uint64_t total_samples_ = 0;
  std::uint64_t blocks_ = 0;   // of each probe
  std::uint64_t block_ = 0;    // the next
  std::uint64_t samples_ = 0;  // of the blocks before
  std::vector<ZipMember> members_;
};

/// How far a DSLogic capture has been read as edges.
struct DslRead {
  std::uint64_t end = 0;  ///< samples of all blocks read
  /// The rest of the block at hand for both lines, from the word on in which it begins.
  std::uint64_t first = 0;
  std::vector<std::uint64_t> ma;
  std::vector<std::uint64_t> slo;
  /// Of all probes: a change where no time can be represented; the last levels, a bit each.
  bool beyond = false;
  std::uint64_t last_levels = 0;
  /// Levels before `first`, a bit for each probe; of no meaning where nothing was read.
  std::uint64_t levels = 0;
  Picoseconds end_time;
  bool ended = false;
  std::optional<CaptureError> error;
};

/// The rest of the capture. `blocks` outlives it; `ma` and `slo` are numbers of planes, and of lines.
std::unique_ptr<PairSource> dsl_pairs(DslBlocks& blocks, Hertz rate, bool verify, std::size_t ma,
                                      std::size_t slo, DslRead read);

}  // namespace biss::capture
