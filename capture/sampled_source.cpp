#include "capture/sampled_source.hpp"

#include <utility>

#include "capture/edge_block.hpp"
#include "capture/line_names.hpp"
#include "capture/sample_scanner.hpp"

namespace biss::capture {
namespace {

class SampledSource final : public EdgeSource {
 public:
  SampledSource(const RawLayout& layout, std::unique_ptr<SamplePieces> pieces)
      : pieces_(std::move(pieces)), scanner_(layout), rate_(layout.rate) {
    LineNames names;
    for (const SampleLine& line : layout.lines) lines_.push_back(names.claim(line.name));
  }

  const std::vector<std::string>& lines() const override { return lines_; }
  Picoseconds end_time() const override { return scanner_.end_time(); }
  Picoseconds sample_period() const override {
    const bool whole = picoseconds_per_second % rate_.count == 0;
    return period_of(rate_) + picoseconds(whole ? 0 : 1);
  }

  Result<std::span<const wire::Edge>, CaptureError> next_block() override {
    block_.grow();
    block_.prepare(lines_.size());
    while (!stopped_ && block_.empty()) {
      if (piece_.empty()) {
        fetch();
      } else {
        piece_ = piece_.subspan(scanner_.scan(piece_, block_));
        if (!piece_.empty() && scanner_.times_used_up()) {
          stop({.cause = CaptureCause::time_out_of_range});
        }
      }
    }
    if (block_.empty() && failed_) return failure(error_);
    return block_.edges();
  }

 private:
  void fetch() {
    const auto piece = pieces_->next();
    if (!piece.ok()) return stop(piece.error());
    piece_ = *piece;
    if (!piece_.empty()) return;
    stopped_ = true;
    if (scanner_.inside_sample()) {
      stop({.cause = CaptureCause::truncated, .expected = "a whole number of samples"});
    } else if (scanner_.samples() == 0) {
      stop({.cause = CaptureCause::empty});
    }
  }

  void stop(const CaptureError& error) {
    error_ = error;
    stopped_ = true;
    failed_ = true;
  }

  std::unique_ptr<SamplePieces> pieces_;
  SampleScanner scanner_;
  Hertz rate_;
  std::vector<std::string> lines_;
  EdgeBlock block_;
  std::span<const std::uint8_t> piece_;
  bool stopped_ = false;
  bool failed_ = false;
  CaptureError error_;
};

}  // namespace

Opened open_samples(const RawLayout& layout, std::unique_ptr<SamplePieces> pieces) {
  if (const char* const expected = fault_of(layout)) {
    return {nullptr, {.cause = CaptureCause::bad_layout, .expected = expected}};
  }
  return {std::make_unique<SampledSource>(layout, std::move(pieces)), {}};
}

}  // namespace biss::capture
