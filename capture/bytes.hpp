// Sources and sinks for the bytes of a capture.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "biss/base/result.hpp"
#include "capture/edge_source.hpp"

namespace biss::capture {

/// A stream of bytes, read once from front to back.
class ByteSource {
 public:
  virtual ~ByteSource() = default;

  /// Puts the next bytes at the front of `into` and returns how many: at least one, 0 at the end.
  /// Fails with `read_failed`; bytes that are decompressed also with `damaged`, `truncated` and
  /// `too_large`.
  /// \pre into is not empty
  virtual Result<std::size_t, CaptureError> read(std::span<char> into) = 0;

  /// The next bytes in memory, at most `most`, without a copy. They are valid as long as this
  /// source. Empty if the bytes have to be read, and at the end.
  virtual std::span<const char> take(std::size_t most) {
    static_cast<void>(most);
    return {};
  }

  /// The bytes in memory that take() could return from here on.
  virtual std::span<const char> ahead() const { return {}; }

  /// Descriptor of the regular file that consists of all these bytes, for formats that are read at
  /// any place; -1 if there is no such file. It stays open as long as the source lives. Read either
  /// the file or the source, not both.
  virtual int regular_file() const { return -1; }
};

/// Calls this function of a C library for the object that a unique_ptr owns.
template <auto release>
struct Released {
  template <class T>
  void operator()(T* owned) const {
    release(owned);
  }
};

/// Reads a source in blocks: small at first, and twice as large after each that the source has
/// filled, up to 64 KiB.
class BlockReader {
 public:
  /// The next bytes, valid until the next call; none at the end. Fails as the source fails.
  Result<std::span<const char>, CaptureError> read(ByteSource& source);

 private:
  std::vector<char> block_;
  std::size_t filled_ = 0;
};

/// Takes pieces of known length off the front of a source.
class ByteTaker {
 public:
  explicit ByteTaker(std::unique_ptr<ByteSource> bytes) : bytes_(std::move(bytes)) {}

  /// The next `count` bytes, valid until the next call. Null if fewer are left, and if the source
  /// fails.
  const char* take(std::size_t count);
  /// Why the source failed.
  const std::optional<CaptureError>& error() const { return error_; }

 private:
  std::unique_ptr<ByteSource> bytes_;
  BlockReader block_;
  std::string read_;
  std::size_t at_ = 0;  // the next byte in read_
  std::optional<CaptureError> error_;
};

using OpenedBytes = tl::expected<std::unique_ptr<ByteSource>, CaptureError>;

/// Opens a file, a pipe or a device; `-` is standard input, which stays open afterwards.
/// Fails with `cannot_open` or `is_directory`. Bytes of a slow pipe are delivered as they arrive.
OpenedBytes open_bytes(const std::string& path);

/// `text` as a stream that hands out at most `block_bytes` a call; `text` must outlive it.
/// \pre block_bytes > 0
std::unique_ptr<ByteSource> memory_bytes(
    std::string_view text, std::size_t block_bytes = std::numeric_limits<std::size_t>::max());

/// Fails each time.
std::unique_ptr<ByteSource> failed_bytes(const CaptureError& error);

/// At most `most` bytes of `bytes`; then fails with `error`, unless `bytes` have ended.
std::unique_ptr<ByteSource> limited_bytes(std::unique_ptr<ByteSource> bytes, std::uint64_t most,
                                          const CaptureError& error);

/// `head`, then everything of `rest`: returns the bytes that were read to examine the beginning.
std::unique_ptr<ByteSource> prefixed_bytes(std::string head, std::unique_ptr<ByteSource> rest);

class ByteSink {
 public:
  virtual ~ByteSink() = default;

  /// Takes all of `bytes`; false when that failed, after which no further call is necessary.
  virtual bool write(std::string_view bytes) = 0;
  /// Passes on the bytes that the sink has held back; false when that failed.
  virtual bool flush() = 0;
};

/// Appends to a string that outlives the sink.
class StringSink final : public ByteSink {
 public:
  explicit StringSink(std::string& text) : text_(&text) {}
  bool write(std::string_view bytes) override;
  bool flush() override { return true; }

 private:
  std::string* text_;
};

}  // namespace biss::capture
