#include "capture/bytes.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

namespace biss::capture {
namespace {

bool at_start_of_file(int descriptor) {
  struct stat about {};
  return ::fstat(descriptor, &about) == 0 && S_ISREG(about.st_mode) &&
         ::lseek(descriptor, 0, SEEK_CUR) == 0;
}

class DescriptorBytes final : public ByteSource {
 public:
  DescriptorBytes(int descriptor, bool owned)
      : descriptor_(descriptor), owned_(owned), regular_(at_start_of_file(descriptor)) {}
  DescriptorBytes(const DescriptorBytes&) = delete;
  DescriptorBytes& operator=(const DescriptorBytes&) = delete;
  ~DescriptorBytes() override {
    if (owned_) ::close(descriptor_);
  }

  Result<std::size_t, CaptureError> read(std::span<char> into) override {
    for (;;) {
      const ssize_t got = ::read(descriptor_, into.data(), into.size());
      if (got >= 0) return static_cast<std::size_t>(got);
      if (errno != EINTR) return failure(CaptureError{.cause = CaptureCause::read_failed});
    }
  }

  int regular_file() const override { return regular_ ? descriptor_ : -1; }

 private:
  int descriptor_;
  bool owned_;
  bool regular_;
};

class MemoryBytes final : public ByteSource {
 public:
  MemoryBytes(std::string_view text, std::size_t block_bytes)
      : rest_(text), block_bytes_(block_bytes) {}

  Result<std::size_t, CaptureError> read(std::span<char> into) override {
    const std::size_t count = std::min({into.size(), rest_.size(), block_bytes_});
    if (count != 0) std::memcpy(into.data(), rest_.data(), count);
    rest_.remove_prefix(count);
    return count;
  }

  std::span<const char> take(std::size_t most) override {
    const std::string_view taken = rest_.substr(0, std::min(most, block_bytes_));
    rest_.remove_prefix(taken.size());
    return taken;
  }

  std::span<const char> ahead() const override { return rest_; }

 private:
  std::string_view rest_;
  std::size_t block_bytes_;
};

class PrefixedBytes final : public ByteSource {
 public:
  PrefixedBytes(std::string head, std::unique_ptr<ByteSource> rest)
      : head_(std::move(head)), rest_(std::move(rest)) {}

  Result<std::size_t, CaptureError> read(std::span<char> into) override {
    if (given_ == head_.size()) return rest_->read(into);
    const std::size_t count = std::min(into.size(), head_.size() - given_);
    std::memcpy(into.data(), head_.data() + given_, count);
    given_ += count;
    return count;
  }

  std::span<const char> take(std::size_t most) override {
    if (given_ != head_.size()) return {};
    return rest_->take(most);
  }

  std::span<const char> ahead() const override {
    if (given_ != head_.size()) return {};
    return rest_->ahead();
  }

  int regular_file() const override { return rest_->regular_file(); }

 private:
  std::string head_;
  std::size_t given_ = 0;
  std::unique_ptr<ByteSource> rest_;
};

class FailedBytes final : public ByteSource {
 public:
  explicit FailedBytes(const CaptureError& error) : error_(error) {}

  Result<std::size_t, CaptureError> read(std::span<char>) override { return failure(error_); }

 private:
  CaptureError error_;
};

class LimitedBytes final : public ByteSource {
 public:
  LimitedBytes(std::unique_ptr<ByteSource> bytes, std::uint64_t most, const CaptureError& error)
      : bytes_(std::move(bytes)), left_(most), error_(error) {}

  Result<std::size_t, CaptureError> read(std::span<char> into) override {
    const auto got = bytes_->read(into);
    if (!got.ok()) return got;
    if (*got > left_) return failure(error_);
    left_ -= *got;
    return got;
  }

 private:
  std::unique_ptr<ByteSource> bytes_;
  std::uint64_t left_;
  CaptureError error_;
};

}  // namespace

Result<std::span<const char>, CaptureError> BlockReader::read(ByteSource& source) {
  constexpr std::size_t least = 4'096;
  constexpr std::size_t most = 65'536;
  if (filled_ == block_.size()) block_.resize(std::clamp(2 * filled_, least, most));
  const auto got = source.read(block_);
  if (!got.ok()) return failure(got.error());
  filled_ = *got;
  return std::span<const char>(block_).first(filled_);
}

const char* ByteTaker::take(std::size_t count) {
  if (read_.size() - at_ < count) read_.erase(0, std::exchange(at_, 0));
  while (read_.size() - at_ < count) {
    const auto got = block_.read(*bytes_);
    if (!got.ok()) error_ = got.error();
    if (!got.ok() || got->empty()) return nullptr;
    read_.append(got->data(), got->size());
  }
  return read_.data() + std::exchange(at_, at_ + count);
}

OpenedBytes open_bytes(const std::string& path) {
  const bool standard_input = path == "-";
  const int descriptor = standard_input ? STDIN_FILENO : ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return tl::unexpected(CaptureError{.cause = CaptureCause::cannot_open});
  auto bytes = std::make_unique<DescriptorBytes>(descriptor, !standard_input);
  struct stat about {};
  if (::fstat(descriptor, &about) == 0 && S_ISDIR(about.st_mode)) {
    return tl::unexpected(CaptureError{.cause = CaptureCause::is_directory});
  }
  return bytes;
}

std::unique_ptr<ByteSource> memory_bytes(std::string_view text, std::size_t block_bytes) {
  return std::make_unique<MemoryBytes>(text, block_bytes);
}

std::unique_ptr<ByteSource> failed_bytes(const CaptureError& error) {
  return std::make_unique<FailedBytes>(error);
}

std::unique_ptr<ByteSource> limited_bytes(std::unique_ptr<ByteSource> bytes, std::uint64_t most,
                                          const CaptureError& error) {
  return std::make_unique<LimitedBytes>(std::move(bytes), most, error);
}

std::unique_ptr<ByteSource> prefixed_bytes(std::string head, std::unique_ptr<ByteSource> rest) {
  return std::make_unique<PrefixedBytes>(std::move(head), std::move(rest));
}

bool StringSink::write(std::string_view bytes) {
  text_->append(bytes);
  return true;
}

}  // namespace biss::capture
