#include "capture/compressed.hpp"

#include <zlib.h>
#include <zstd.h>
#include <zstd_errors.h>

#include <algorithm>
#include <limits>
#include <new>
#include <optional>
#include <span>
#include <utility>

#include "capture/text_source.hpp"

namespace biss::capture {
namespace {

constexpr std::string_view gzip_magic = "\x1F\x8B\x08";
constexpr std::string_view zstd_magic = "\x28\xB5\x2F\xFD";

// RFC 8878, 3.1.2: a zstd file may begin with a frame without content.
bool is_skippable_frame(std::string_view head) {
  return !head.empty() && (head.front() & 0xF0) == 0x50 &&
         head.substr(1).starts_with("\x2A\x4D\x18");
}

/// One step of a decompressor.
struct Step {
  std::size_t made = 0;
  /// The text that was expected after these bytes; null if there is no fault.
  const char* fault = nullptr;
};

// The common part of both formats.
class CompressedBytes : public ByteSource {
 public:
  Result<std::size_t, CaptureError> read(std::span<char> into) final {
    while (!error_) {
      if (input_.empty() && !holds_output_ && !refill()) break;
      if (ended_) return std::size_t{0};
      const Step step = decompress(input_, into);
      if (step.fault != nullptr) stop(CaptureCause::damaged, step.fault);
      if (step.made != 0) return step.made;
    }
    return failure(*error_);
  }

 protected:
  CompressedBytes(std::unique_ptr<ByteSource> bytes, const char* part)
      : bytes_(std::move(bytes)), part_(part) {}

  /// Takes bytes off the front of `input`, and sets both of these members.
  virtual Step decompress(std::string_view& input, std::span<char> into) = 0;

  // decompress() can make more bytes without further input.
  bool holds_output_ = false;
  // The compressed data may end here: a member or frame is complete.
  bool whole_ = false;

 private:
  void stop(CaptureCause cause, const char* expected) {
    error_ = {.cause = cause, .expected = expected, .part = part_};
  }

  // False after an error. At the end of the file, `input_` stays empty and `ended_` is true.
  bool refill() {
    const auto got = block_.read(*bytes_);
    if (!got.ok()) {
      error_ = got.error();
    } else if (!got->empty()) {
      input_ = std::string_view(got->data(), got->size());
    } else if (whole_) {
      ended_ = true;
    } else {
      stop(CaptureCause::truncated, "the rest of the compressed data");
    }
    return !error_;
  }

  std::unique_ptr<ByteSource> bytes_;
  // CaptureError::part.
  const char* part_;
  BlockReader block_;
  std::string_view input_;
  bool ended_ = false;
  std::optional<CaptureError> error_;
};

class GzipBytes final : public CompressedBytes {
 public:
  explicit GzipBytes(std::unique_ptr<ByteSource> bytes)
      : CompressedBytes(std::move(bytes), "gzip data") {
    // zlib.h: 15 allows every window, and 16 more means gzip only.
    constexpr int gzip_of_any_window = 15 + 16;
    if (inflateInit2(&stream_, gzip_of_any_window) != Z_OK) throw std::bad_alloc();
  }
  GzipBytes(const GzipBytes&) = delete;
  GzipBytes& operator=(const GzipBytes&) = delete;
  ~GzipBytes() override { inflateEnd(&stream_); }

 private:
  Step decompress(std::string_view& input, std::span<char> into) override {
    if (whole_) {
      // Tapes and some tools pad the end with zeros.
      input.remove_prefix(std::min(input.find_first_not_of('\0'), input.size()));
      if (input.empty()) return {};
      if (input.front() != gzip_magic.front()) {
        return {.fault = "another gzip member or the end of the file"};
      }
      inflateReset(&stream_);  // fails only without inflateInit2()
      whole_ = false;
    }
    return inflate_member(input, into);
  }

  Step inflate_member(std::string_view& input, std::span<char> into) {
    const auto room =
        static_cast<uInt>(std::min<std::size_t>(into.size(), std::numeric_limits<uInt>::max()));
    // zlib only reads it; its pointer is const only with the macro ZLIB_CONST.
    stream_.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(input.data()));
    stream_.avail_in = static_cast<uInt>(input.size());
    stream_.next_out = reinterpret_cast<Bytef*>(into.data());
    stream_.avail_out = room;
    const int result = inflate(&stream_, Z_NO_FLUSH);
    input.remove_prefix(input.size() - stream_.avail_in);
    Step step{.made = room - stream_.avail_out};
    whole_ = result == Z_STREAM_END;
    holds_output_ = result == Z_OK && stream_.avail_out == 0;
    if (result == Z_MEM_ERROR) throw std::bad_alloc();
    if (result != Z_OK && result != Z_STREAM_END && result != Z_BUF_ERROR) {
      step.fault = "compressed data that inflates to its size and checksum";
    }
    return step;
  }

  z_stream stream_{};
};

class ZstdBytes final : public CompressedBytes {
 public:
  explicit ZstdBytes(std::unique_ptr<ByteSource> bytes)
      : CompressedBytes(std::move(bytes), "zstd data"), stream_(ZSTD_createDStream()) {
    if (!stream_) throw std::bad_alloc();
  }

 private:
  Step decompress(std::string_view& input, std::span<char> into) override {
    // A call that fails delivers nothing, not even the blocks before the fault. Therefore each call
    // gets at most one block: zstd asks for a block and the header of the next one.
    const std::size_t given = asked_ > block_header_bytes ? asked_ - block_header_bytes : asked_;
    ZSTD_inBuffer in{input.data(), std::min(given, input.size()), 0};
    ZSTD_outBuffer out{into.data(), into.size(), 0};
    const std::size_t left = ZSTD_decompressStream(stream_.get(), &out, &in);
    input.remove_prefix(in.pos);
    if (ZSTD_isError(left) != 0) return {.made = out.pos, .fault = fault_of_code(left)};
    asked_ = std::max<std::size_t>(left, 1);
    whole_ = left == 0;
    holds_output_ = left != 0 && out.pos == out.size;
    return {.made = out.pos};
  }

  static constexpr std::size_t block_header_bytes = 3;

  static const char* fault_of_code(std::size_t code) {
    switch (ZSTD_getErrorCode(code)) {
      case ZSTD_error_memory_allocation:
        throw std::bad_alloc();
      case ZSTD_error_frameParameter_windowTooLarge:
        return "a window of at most 128 MiB (decompress it with zstd -d --long=31 first)";
      case ZSTD_error_prefix_unknown:
        return "another zstd frame or the end of the file";
      default:
        return "compressed data that decompresses to its size and checksum";
    }
  }

  std::unique_ptr<ZSTD_DStream, Released<ZSTD_freeDStream>> stream_;
  // The bytes that zstd asks for next.
  std::size_t asked_ = 1;
};

}  // namespace

Compression compression_of(std::string_view head) {
  if (head.starts_with(gzip_magic)) return Compression::gzip;
  if (head.starts_with(zstd_magic)) return Compression::zstd;
  return is_skippable_frame(head) ? Compression::zstd : Compression::none;
}

std::string_view without_compression(std::string_view path) {
  const std::size_t dot = path.rfind('.');
  if (dot == std::string_view::npos) return path;
  const std::string extension = lower_case(path.substr(dot));
  const bool compressed = extension == ".gz" || extension == ".zst" || extension == ".gzip";
  return compressed ? path.substr(0, dot) : path;
}

std::unique_ptr<ByteSource> decompressed(std::unique_ptr<ByteSource> bytes,
                                         Compression compression) {
  if (compression == Compression::zstd) return std::make_unique<ZstdBytes>(std::move(bytes));
  return std::make_unique<GzipBytes>(std::move(bytes));
}

}  // namespace biss::capture
