#include "capture/dsl_blocks.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "capture/bit_scan.hpp"
#include "capture/change_edges.hpp"
#include "capture/change_times.hpp"

namespace biss::capture {
namespace {

constexpr std::uint64_t plane_bytes = dsl_block_samples / 8;
constexpr std::uint64_t plane_word_samples = 64;
// What is deflated to more than this does not come from DSView; it is inflated as it is read.
constexpr std::uint64_t most_compressed = 2 * plane_bytes;

bool level_at(const std::uint8_t* bits, std::uint64_t sample) {
  return (bits[sample / 8] >> sample % 8 & 1U) != 0;
}

// A block, or what was left of one when reading as edges ended.
class DslPiece final : public PairPiece {
 public:
  DslPiece(const SampleClock& clock, bool verify, std::size_t ma_plane, std::size_t slo_plane)
      : clock_(clock), verify_(verify), ma_plane_(ma_plane), slo_plane_(slo_plane) {}

  void expand() override {
    if (error) return;
    if (!read_ahead && !inflate()) return;
    too_many = !scan(first, timed_end(), most_changes);
    if (too_many) {
      ma.clear();
      slo.clear();
    }
  }

  // Its changes as edges, in place of the arrays.
  void put_edges(ChangeEdges& edges, const PairSource::OnEdges& on_edges) {
    const std::uint64_t end = timed_end();
    for (std::uint64_t at = first; at < end;) {
      const std::uint64_t next = std::min(end, (at / scan_samples + 1) * scan_samples);
      scan(at, next, 2 * scan_samples);
      edges.put(ma, slo, on_edges);
      at = next;
    }
  }

  void reset() {
    error.reset();
    read_ahead.reset();
    beyond = false;
    too_many = false;
  }

  PackedBlock block;
  std::optional<DslRead> read_ahead;  ///< in place of a block
  std::uint64_t first = 0;
  std::uint64_t samples = 0;
  bool beyond = false;    // a line changes where no time can be represented
  bool too_many = false;  // changes for arrays
  std::uint64_t first_levels = 0;
  std::uint64_t last_levels = 0;
  std::optional<CaptureError> error;

 private:
  static std::span<std::uint8_t> sized(std::vector<std::uint64_t>& words, std::uint64_t bytes) {
    words.resize(static_cast<std::size_t>((bytes + 7) / 8));
    if (!words.empty()) words.back() = 0;
    return {reinterpret_cast<std::uint8_t*>(words.data()), static_cast<std::size_t>(bytes)};
  }

  // All planes, because a damaged one ends the capture whatever its line.
  bool inflate() {
    first_levels = last_levels = 0;
    for (std::size_t i = 0; i < block.planes.size(); ++i) {
      const PackedPlane& plane = block.planes[i];
      const auto bits = sized(i == ma_plane_    ? ma_
                              : i == slo_plane_ ? slo_
                                                : other_,
                              plane.size_bytes);
      if (!plane.inflate(inflater_, verify_, bits)) {
        error = block.damaged(damaged_plane);
        return false;
      }
      if (samples == 0) continue;
      first_levels |= std::uint64_t{level_at(bits.data(), 0)} << i;
      last_levels |= std::uint64_t{level_at(bits.data(), samples - 1)} << i;
      look_beyond(bits.data());
    }
    if (block.fault != nullptr) error = block.damaged(block.fault);
    return !error;
  }

  void look_beyond(const std::uint8_t* bits) {
    const std::uint64_t last = clock_.last_index();
    if (first + samples - 1 <= last) return;
    std::uint64_t at = std::max(first, last) - first;
    const bool high = level_at(bits, at);
    while (at < samples && level_at(bits, at) == high) ++at;
    beyond = beyond || at < samples;
  }

  const std::vector<std::uint64_t>& ma_bits() const { return read_ahead ? read_ahead->ma : ma_; }
  const std::vector<std::uint64_t>& slo_bits() const {
    if (read_ahead) return read_ahead->slo;
    return slo_plane_ == ma_plane_ ? ma_ : slo_;
  }

  // The end of the samples that have a time.
  std::uint64_t timed_end() const {
    const std::uint64_t last = clock_.last_index();
    return first > last ? first : std::min(first + samples, last + 1);
  }

  // The changes of both lines from `begin` to `end`. False where there are more than `most`.
  bool scan(std::uint64_t begin, std::uint64_t end, std::size_t most) {
    return scan(ma_bits(), begin, end, most, ma) &&
           scan(slo_bits(), begin, end, most - ma.times.size(), slo);
  }

  // `begin` is that of the piece, or of a word. Samples before it in its word say nothing.
  bool scan(const std::vector<std::uint64_t>& words, std::uint64_t begin, std::uint64_t end,
            std::size_t most, LineChanges& changes) {
    changes.clear();
    if (begin == end) return true;
    const auto* const bits = reinterpret_cast<const std::uint8_t*>(words.data());
    const std::uint64_t base = first / plane_word_samples * plane_word_samples;
    const bool high = level_at(bits, begin - base);
    const ScanClock clock(clock_);
    ChangeTimes times(changes, high);
    PlaneScan found{.high = !high, .step = clock.step()};  // the first sample is a change
    for (std::uint64_t at = begin / plane_word_samples * plane_word_samples; at < end;
         at += scan_samples) {
      if (times.count() > most) return false;
      found.bits = bits + (at - base) / 8;
      found.count = static_cast<std::size_t>(std::min<std::uint64_t>(scan_samples, end - at));
      found.time = clock.time_of(at);
      found.changes = times.room(found.count);
      scan_plane(found);
      times.found(found.changes, at, clock);
    }
    times.finish();
    return times.count() <= most;
  }

  SampleClock clock_;
  bool verify_;
  std::size_t ma_plane_;
  std::size_t slo_plane_;
  Inflater inflater_;
  std::vector<std::uint64_t> ma_;
  std::vector<std::uint64_t> slo_;
  std::vector<std::uint64_t> other_;
};

class DslPairs final : public PairSource {
 public:
  DslPairs(DslBlocks& blocks, Hertz rate, bool verify, std::size_t ma, std::size_t slo,
           DslRead read)
      : blocks_(&blocks),
        clock_(rate),
        verify_(verify),
        ma_(ma),
        slo_(slo),
        ended_(read.ended),
        ahead_(read.error),
        end_time_(read.end_time),
        last_levels_(read.last_levels),
        edges_(static_cast<wire::LineIndex>(ma), static_cast<wire::LineIndex>(slo)) {
    if (read.first != 0) edges_.set((read.levels >> ma & 1U) != 0, (read.levels >> slo & 1U) != 0);
    if (read.first != read.end) read_ahead_ = std::move(read);
  }

  std::unique_ptr<PairPiece> fetch(std::unique_ptr<PairPiece> used) override {
    std::unique_ptr<DslPiece> piece(static_cast<DslPiece*>(used.release()));
    if (!piece) piece = std::make_unique<DslPiece>(clock_, verify_, ma_, slo_);
    piece->reset();
    if (!ended_ && !ahead_ && next(*piece)) return piece;
    if (!ahead_) return nullptr;
    ended_ = true;
    piece->samples = 0;
    piece->error = std::exchange(ahead_, std::nullopt);
    return piece;
  }

  bool settle(PairPiece& settled, const OnEdges& on_edges) override {
    auto& piece = static_cast<DslPiece&>(settled);
    if (!error_) error_ = piece.error;
    if (error_) return false;
    if (piece.samples == 0) return true;
    const std::uint64_t last = clock_.last_index();
    end_time_ = clock_.time_of(std::min(piece.first + piece.samples - 1, last));
    const bool changes_first = !piece.read_ahead && piece.first_levels != last_levels_;
    if (piece.beyond || (piece.first > last && changes_first)) {
      error_ = CaptureError{.cause = CaptureCause::time_out_of_range};
    }
    last_levels_ = piece.last_levels;
    if (piece.too_many) {
      piece.put_edges(edges_, on_edges);
    } else {
      edges_.skip(piece.ma, piece.slo);
    }
    return !piece.too_many;
  }

  Picoseconds end_time() const override { return end_time_; }
  const std::optional<CaptureError>& error() const override { return error_; }

 private:
  bool next(DslPiece& piece) {
    if (read_ahead_) {
      piece.first = read_ahead_->first;
      piece.samples = read_ahead_->end - read_ahead_->first;
      piece.beyond = read_ahead_->beyond;
      piece.last_levels = read_ahead_->last_levels;
      piece.read_ahead = std::exchange(read_ahead_, std::nullopt);
      return true;
    }
    const auto got = blocks_->next(piece.block);
    if (!got.ok()) ahead_ = got.error();
    if (!got.ok() || !*got) return false;
    piece.first = piece.block.first;
    piece.samples = piece.block.samples;
    return true;
  }

  DslBlocks* blocks_;
  SampleClock clock_;
  bool verify_;
  std::size_t ma_;
  std::size_t slo_;

  // Of fetch().
  std::optional<DslRead> read_ahead_;
  bool ended_;
  std::optional<CaptureError> ahead_;  // not yet given to a piece

  // Of settle().
  Picoseconds end_time_;
  std::uint64_t last_levels_;
  std::optional<CaptureError> error_;
  ChangeEdges edges_;
};

}  // namespace

bool PackedPlane::inflate(Inflater& inflater, bool verify, std::span<std::uint8_t> into) const {
  if (!readable) return false;
  if (!deflated) {
    std::copy(bytes.begin(), bytes.end(), into.begin());
    return true;
  }
  if (!inflater.inflate(bytes, into)) return false;
  return !verify || zip_checksum(into) == checksum;
}

CaptureError PackedBlock::damaged(const char* expected) const {
  return {.cause = CaptureCause::damaged,
          .expected = expected,
          .part = "block",
          .part_number = number + 1};
}

DslBlocks::DslBlocks(std::unique_ptr<ZipArchive> archive, const DslHeader& header)
    : archive_(std::move(archive)), total_samples_(header.total_samples) {
  for (const SampleLine& line : header.lines) probes_.push_back(line.bit);
  blocks_ = header.total_blocks == 0 ? header.needed_blocks() : header.total_blocks;
}

Result<bool, CaptureError> DslBlocks::next(PackedBlock& block) {
  if (block_ == blocks_) {
    if (samples_ == 0) return failure(CaptureError{.cause = CaptureCause::empty});
    // DSView stores whole bytes of whole words.
    if (total_samples_ - samples_ < plane_word_samples) return false;
    return failure(CaptureError{.cause = CaptureCause::truncated,
                                .expected = "as many samples as the header has"});
  }
  block.number = block_++;
  block.first = samples_;
  block.samples = 0;
  block.fault = find_planes(block);
  read_planes(block);
  if (block.fault != nullptr) return true;
  const std::uint64_t most = std::min(total_samples_ - samples_, dsl_block_samples);
  block.samples = std::min(most, 8 * block.planes.front().size_bytes);
  if (block_ != blocks_ && block.samples != dsl_block_samples) {
    block.fault = "2 MiB in every block but the last";
  } else if (8 * block.planes.front().size_bytes - block.samples >= plane_word_samples) {
    block.fault = "no more samples than the header has";
  }
  if (block.fault != nullptr) block.samples = 0;
  samples_ += block.samples;
  return true;
}

// Returns the first fault that the directory shows.
const char* DslBlocks::find_planes(PackedBlock& block) {
  members_.clear();
  for (const unsigned probe : probes_) {
    const auto member =
        archive_->find("L-" + std::to_string(probe) + '/' + std::to_string(block.number));
    if (!member) return "this block of every probe";
    if (member->size_bytes > plane_bytes) return "at most 2 MiB";
    if (member->size_bytes / max_deflate_ratio > member->compressed_bytes) {
      return "a size that the compressed data can have";
    }
    members_.push_back(*member);
    if (member->size_bytes != members_.front().size_bytes) {
      return "blocks of the same size for all probes";
    }
  }
  return nullptr;
}

void DslBlocks::read_planes(PackedBlock& block) {
  const auto is_kept = [](const ZipMember& member) {
    return member.deflated && member.compressed_bytes <= most_compressed;
  };
  std::size_t needed = 0;
  for (const ZipMember& member : members_) {
    needed +=
        static_cast<std::size_t>(is_kept(member) ? member.compressed_bytes : member.size_bytes);
  }
  std::span<std::uint8_t> room = block.memory.take(needed);
  block.planes.clear();
  for (const ZipMember& member : members_) {
    const bool kept = is_kept(member);
    const auto bytes =
        room.first(static_cast<std::size_t>(kept ? member.compressed_bytes : member.size_bytes));
    room = room.subspan(bytes.size());
    const bool readable =
        kept ? archive_->read_compressed(member, bytes) : archive_->read_whole(member, bytes);
    block.planes.push_back({bytes, member.size_bytes, member.checksum, kept, readable});
  }
}

std::unique_ptr<PairSource> dsl_pairs(DslBlocks& blocks, Hertz rate, bool verify, std::size_t ma,
                                      std::size_t slo, DslRead read) {
  return std::make_unique<DslPairs>(blocks, rate, verify, ma, slo, std::move(read));
}

}  // namespace biss::capture
