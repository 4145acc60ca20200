#include "capture/raw_reader.hpp"

#include <cstdint>
#include <utility>
#include <vector>

#include "capture/sampled_source.hpp"

namespace biss::capture {
namespace {

constexpr std::size_t piece_bytes = 262'144;

class RawPieces final : public SamplePieces {
 public:
  explicit RawPieces(std::unique_ptr<ByteSource> bytes) : bytes_(std::move(bytes)) {}

  Result<std::span<const std::uint8_t>, CaptureError> next() override {
    // Files that fit into a small buffer do not pay for a large one.
    if (last_bytes_ == buffer_.size()) {
      buffer_.resize(buffer_.empty() ? piece_bytes / 64 : piece_bytes);
    }
    const auto got = bytes_->read({reinterpret_cast<char*>(buffer_.data()), buffer_.size()});
    if (!got.ok()) return failure(got.error());
    last_bytes_ = *got;
    return std::span<const std::uint8_t>(buffer_).first(*got);
  }

 private:
  std::unique_ptr<ByteSource> bytes_;
  std::vector<std::uint8_t> buffer_;
  std::size_t last_bytes_ = 0;
};

}  // namespace

Opened open_raw(std::unique_ptr<ByteSource> bytes, const RawLayout& layout) {
  return open_samples(layout, std::make_unique<RawPieces>(std::move(bytes)));
}

}  // namespace biss::capture
