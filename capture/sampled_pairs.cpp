#include "capture/sampled_pairs.hpp"

#include <algorithm>
#include <array>
#include <span>
#include <utility>

#include "capture/bit_scan.hpp"
#include "capture/change_edges.hpp"
#include "capture/zip.hpp"

namespace biss::capture {
namespace {

// Fits into the nearest cache: the scan finds there the bytes that the checksum has read.
constexpr std::size_t checksum_bytes = 32'768;

// The checksum of samples, part by part on their way to the scan.
class Verification {
 public:
  Verification(std::span<const std::uint8_t> bytes, bool wanted) : bytes_(bytes), wanted_(wanted) {}

  // Reads up to this byte and a little further.
  void read_to(std::size_t end) {
    while (wanted_ && read_ < end) {
      const auto part = bytes_.subspan(read_, std::min(checksum_bytes, bytes_.size() - read_));
      checksum_ = zip_checksum_after(checksum_, part);
      read_ += part.size();
    }
  }
  // Whether this is the checksum, or none is wanted.
  bool is(std::uint32_t checksum) {
    read_to(bytes_.size());
    return !wanted_ || checksum_ == checksum;
  }

 private:
  std::span<const std::uint8_t> bytes_;
  bool wanted_;
  std::uint32_t checksum_ = 0;
  std::size_t read_ = 0;
};

// Collects what scans find of a line.
class ChangeTimes {
 public:
  ChangeTimes(LineChanges& changes, bool first_high) : times_(&changes.times) {
    changes.first_high = first_high;
  }

  // Room for one scan. It grows in small steps, because a vector doubles.
  std::int64_t* room() {
    constexpr std::size_t scan = scan_samples + scan_slack;
    if (times_->capacity() < found_ + found_ / 4 + scan) {
      times_->reserve(found_ + found_ / 2 + scan);
    }
    if (times_->size() < found_ + scan) times_->resize(found_ + scan);
    return times_->data() + found_;
  }
  // A scan has put times up to `end`; returns them.
  std::span<std::int64_t> found(const std::int64_t* end) {
    const std::size_t before = found_;
    found_ = static_cast<std::size_t>(end - times_->data());
    return std::span(*times_).subspan(before, found_ - before);
  }
  void finish() { times_->resize(found_); }
  std::size_t count() const { return found_; }

 private:
  std::vector<std::int64_t, Unfilled<std::int64_t>>* times_;
  std::size_t found_ = 0;
};

class SampledPiece final : public PairPiece {
 public:
  SampledPiece(const PairLayout& layout, bool verify) : layout_(layout), verify_(verify) {}

  void expand() override {
    if (count == 0) return;
    samples_ = packed.bytes;
    if (packed.deflated) {
      samples_ = inflated_.take(static_cast<std::size_t>(packed.deflated->size_bytes));
      if (!inflate()) return damaged("data that inflates to its size");
    }
    Verification verification(samples_, packed.deflated && verify_);
    too_many = !scan(0, count, verification);
    if (too_many) {
      // Their memory is free while the piece waits for its turn.
      ma = LineChanges();
      slo = LineChanges();
    }
    if (packed.deflated && !verification.is(packed.deflated->checksum)) {
      damaged("data with its checksum");
    }
  }

  std::span<const std::uint8_t> ahead(std::size_t between) const override {
    const std::size_t size = packed.bytes.size();
    const auto after = packed.ahead.subspan(std::min(packed.ahead.size(), between * size));
    return after.first(std::min(after.size(), size));
  }

  // Its changes as edges, in place of the arrays.
  void put_edges(ChangeEdges& edges, const PairSource::OnEdges& on_edges) {
    Verification none(samples_, false);
    for (std::size_t at = 0; at < count; at += scan_samples) {
      scan(at, std::min(count, at + scan_samples), none);
      edges.put(ma, slo, on_edges);
    }
  }

  void reset() {
    packed.deflated.reset();
    packed.ahead = {};
    count = 0;
    too_many = false;
    error.reset();
    beginning = std::vector<std::uint8_t>();
  }

  PackedSamples packed;
  std::vector<std::uint8_t> beginning;  // holds packed.bytes of the first piece
  std::uint64_t first = 0;              // sample of the capture
  std::size_t count = 0;                // samples
  bool too_many = false;                // changes for arrays
  std::optional<CaptureError> error;

 private:
  bool inflate() {
    if (!inflater_) inflater_.emplace();
    return inflater_->inflate(
        packed.bytes, inflated_.take(static_cast<std::size_t>(packed.deflated->size_bytes)));
  }

  void damaged(const char* expected) {
    error = packed.deflated->damaged;
    error->expected = expected;
    count = 0;
  }

  bool is_high(const std::uint8_t* sample, unsigned bit) const {
    return (sample[bit / 8] >> bit % 8 & 1U) != 0;
  }

  // The changes of the samples from `begin` to `end`. False if there are too many.
  bool scan(std::size_t begin, std::size_t end, Verification& verification) {
    // If the period is not a whole number of picoseconds, a scan counts in samples from its first
    // one.
    const std::uint32_t step = layout_.clock.whole_step();
    const std::uint8_t* const samples = samples_.data();
    const bool ma_high = is_high(samples + begin * layout_.unit_bytes, layout_.ma_bit);
    const bool slo_high = is_high(samples + begin * layout_.unit_bytes, layout_.slo_bit);
    ChangeTimes ma_times(ma, ma_high);
    ChangeTimes slo_times(slo, slo_high);
    PairScan scan{.unit_bytes = layout_.unit_bytes,
                  .ma_bit = layout_.ma_bit,
                  .slo_bit = layout_.slo_bit,
                  .ma_high = !ma_high,  // the first sample is a change
                  .slo_high = !slo_high,
                  .step = std::max(step, 1U)};
    for (std::size_t at = begin; at < end; at += scan_samples) {
      if (ma_times.count() + slo_times.count() > most_changes) return false;
      scan.samples = samples + at * layout_.unit_bytes;
      scan.count = std::min(scan_samples, end - at);
      verification.read_to((at + scan.count) * layout_.unit_bytes);
      scan.time = step == 0 ? 0 : layout_.clock.time_of(first + at).count;
      scan.ma = ma_times.room();
      scan.slo = slo_times.room();
      scan_pair(scan);
      for (const auto found : {ma_times.found(scan.ma), slo_times.found(scan.slo)}) {
        if (step == 0) layout_.clock.times_after(first + at, found);
      }
    }
    ma_times.finish();
    slo_times.finish();
    return true;
  }
  PairLayout layout_;
  bool verify_;
  std::optional<Inflater> inflater_;
  Buffer inflated_;
  std::span<const std::uint8_t> samples_;
};

class SampledPairs final : public PairSource {
 public:
  SampledPairs(SamplePieces& pieces, const PairLayout& layout, const SampleReading& reading,
               SamplesRead read)
      : pieces_(&pieces),
        layout_(layout),
        reading_(reading),
        last_index_(layout.clock.last_index()),
        next_(read.samples),
        first_bytes_(std::move(read.bytes)),
        ended_(read.ended),
        ahead_(read.error),
        edges_(layout.ma, layout.slo) {
    if (next_ == 0) return;
    end_time_ = layout_.clock.time_of(next_ - 1);
    edges_.set((read.last_sample >> layout.ma_bit & 1U) != 0,
               (read.last_sample >> layout.slo_bit & 1U) != 0);
  }

  std::unique_ptr<PairPiece> fetch(std::unique_ptr<PairPiece> used) override {
    std::unique_ptr<SampledPiece> piece(static_cast<SampledPiece*>(used.release()));
    if (!piece) piece = std::make_unique<SampledPiece>(layout_, reading_.verify);
    piece->reset();
    while (!ended_ && !ahead_) {
      if (!next_bytes(*piece)) continue;
      take_samples(*piece);
      if (piece->count != 0) return piece;
    }
    if (!ahead_) return nullptr;
    ended_ = true;
    piece->error = std::exchange(ahead_, std::nullopt);
    return piece;
  }

  bool settle(PairPiece& settled, const OnEdges& on_edges) override {
    auto& piece = static_cast<SampledPiece&>(settled);
    if (!error_) error_ = piece.error;
    if (error_) return false;
    end_time_ = layout_.clock.time_of(piece.first + piece.count - 1);
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
  // False at the end of the capture, and if there is an error.
  bool next_bytes(SampledPiece& piece) {
    PackedSamples& packed = piece.packed;
    if (!first_bytes_.empty()) {
      piece.beginning = std::exchange(first_bytes_, std::vector<std::uint8_t>());
      packed.bytes = piece.beginning;
      return true;
    }
    const FetchWish wish{.piece_bytes = std::max(reading_.piece_bytes, layout_.unit_bytes),
                         .unit_bytes = layout_.unit_bytes,
                         .at_sample = begun_bytes_ == 0};
    packed.deflated.reset();
    const auto got = pieces_->fetch(packed, wish);
    if (!got.ok()) {
      ahead_ = got.error();
      return false;
    }
    if (*got) return true;
    ended_ = true;
    if (begun_bytes_ != 0) {
      ahead_ =
          CaptureError{.cause = CaptureCause::truncated, .expected = "a whole number of samples"};
    } else if (next_ == 0) {
      ahead_ = CaptureError{.cause = CaptureCause::empty};
    }
    return false;
  }

  // The whole samples of the bytes; the rest goes to the next piece.
  void take_samples(SampledPiece& piece) {
    PackedSamples& packed = piece.packed;
    std::uint64_t samples = 0;
    if (packed.deflated) {
      samples = packed.deflated->size_bytes / layout_.unit_bytes;
    } else {
      packed.prepend(std::span(begun_).first(std::exchange(begun_bytes_, 0)));
      samples = packed.bytes.size() / layout_.unit_bytes;
      const auto whole = static_cast<std::size_t>(samples) * layout_.unit_bytes;
      begun_bytes_ = packed.bytes.size() - whole;
      std::copy(packed.bytes.begin() + static_cast<std::ptrdiff_t>(whole), packed.bytes.end(),
                begun_.begin());
      packed.bytes = packed.bytes.first(whole);
    }
    const std::uint64_t left = next_ > last_index_ ? 0 : last_index_ - next_ + 1;
    if (samples > left) ahead_ = CaptureError{.cause = CaptureCause::time_out_of_range};
    piece.first = next_;
    piece.count = static_cast<std::size_t>(std::min(samples, left));
    next_ += piece.count;
  }

  SamplePieces* pieces_;
  PairLayout layout_;
  SampleReading reading_;
  std::uint64_t last_index_;

  // Used by fetch().
  std::uint64_t next_;  // sample
  std::vector<std::uint8_t> first_bytes_;
  std::array<std::uint8_t, max_unit_bytes> begun_{};
  std::size_t begun_bytes_ = 0;
  bool ended_;
  std::optional<CaptureError> ahead_;  // not yet given to a piece

  // Used by settle().
  Picoseconds end_time_;
  std::optional<CaptureError> error_;
  ChangeEdges edges_;
};

}  // namespace

std::unique_ptr<PairSource> sampled_pairs(SamplePieces& pieces, const PairLayout& layout,
                                          const SampleReading& reading, SamplesRead read) {
  return std::make_unique<SampledPairs>(pieces, layout, reading, std::move(read));
}

}  // namespace biss::capture
