#include "capture/gather.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <system_error>

namespace biss::capture {
namespace {

// A separate stream on the same file.
Stdio reopened(int descriptor) {
  const int copy = ::dup(descriptor);
  if (copy < 0) return nullptr;
  Stdio file(::fdopen(copy, "rb"));
  if (!file) ::close(copy);
  return file;
}

// Continues to read from a place.
class BytesFrom final : public ByteSource {
 public:
  BytesFrom(const PlacedBytes& bytes, std::uint64_t place) : bytes_(&bytes), place_(place) {}

  Result<std::size_t, CaptureError> read(std::span<char> into) override {
    const std::uint64_t left = bytes_->size() - std::min(place_, bytes_->size());
    const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(left, into.size()));
    if (!bytes_->read(place_, {reinterpret_cast<std::uint8_t*>(into.data()), count})) {
      return failure(CaptureError{.cause = CaptureCause::read_failed});
    }
    place_ += count;
    return count;
  }

 private:
  const PlacedBytes* bytes_;
  std::uint64_t place_;
};

}  // namespace

Stdio temporary_file() {
  std::error_code none;
  const std::filesystem::path folder = std::filesystem::temp_directory_path(none);
  if (none) return nullptr;
  int descriptor = ::open(folder.c_str(), O_RDWR | O_TMPFILE | O_CLOEXEC, 0600);
  if (descriptor < 0) {
    std::string path = (folder / "biss-XXXXXX").string();
    descriptor = ::mkostemp(path.data(), O_CLOEXEC);
    if (descriptor >= 0) ::unlink(path.c_str());
  }
  if (descriptor < 0) return nullptr;
  Stdio file(::fdopen(descriptor, "w+b"));
  if (!file) ::close(descriptor);
  return file;
}

bool Spool::append(std::string_view bytes) {
  constexpr std::size_t most = 16U * 1024U * 1024U;
  bytes_.memory += bytes;
  return bytes_.memory.size() < most || spill();
}

bool Spool::spill() {
  if (!bytes_.file) bytes_.file = temporary_file();
  if (!bytes_.file) return false;
  const bool written = std::fwrite(bytes_.memory.data(), 1, bytes_.memory.size(),
                                   bytes_.file.get()) == bytes_.memory.size();
  bytes_.memory.clear();
  return written;
}

bool Spool::rewind() {
  return !bytes_.file || (spill() && std::fseek(bytes_.file.get(), 0, SEEK_SET) == 0);
}

std::size_t Spool::read(std::span<char> into) {
  if (bytes_.file) return std::fread(into.data(), 1, into.size(), bytes_.file.get());
  const std::size_t count = std::min(into.size(), bytes_.memory.size() - read_bytes_);
  if (count != 0) std::memcpy(into.data(), bytes_.memory.data() + read_bytes_, count);
  read_bytes_ += count;
  return count;
}

// A source that cannot be read at any place is copied to memory or to a file.
tl::expected<Gathered, CaptureError> gather(std::unique_ptr<ByteSource> bytes) {
  const auto no_room = tl::unexpected(CaptureError{.cause = CaptureCause::read_failed});
  if (const int descriptor = bytes->regular_file(); descriptor >= 0) {
    Stdio file = reopened(descriptor);
    if (!file) return no_room;
    return Gathered{std::move(file), {}};
  }
  Spool spool;
  BlockReader block;
  for (;;) {
    const auto got = block.read(*bytes);
    if (!got.ok()) return tl::unexpected(got.error());
    if (got->empty()) break;
    if (!spool.append({got->data(), got->size()})) return no_room;
  }
  if (!spool.rewind()) return no_room;
  return spool.take();
}

std::unique_ptr<ByteSource> bytes_from(const PlacedBytes& bytes, std::uint64_t place) {
  return std::make_unique<BytesFrom>(bytes, place);
}

PlacedBytes::PlacedBytes(Gathered bytes) : bytes_(std::move(bytes)), size_(bytes_.memory.size()) {
  if (!bytes_.file) return;
  struct stat about {};
  if (::fstat(::fileno(bytes_.file.get()), &about) != 0 || about.st_size < 0) return;
  size_ = static_cast<std::uint64_t>(about.st_size);
}

bool PlacedBytes::read(std::uint64_t place, std::span<std::uint8_t> into) const {
  if (place > size_ || into.size() > size_ - place) return false;
  if (into.empty()) return true;
  if (!bytes_.file) {
    std::memcpy(into.data(), bytes_.memory.data() + place, into.size());
    return true;
  }
  std::FILE* const file = bytes_.file.get();
  return ::fseeko(file, static_cast<off_t>(place), SEEK_SET) == 0 &&
         std::fread(into.data(), 1, into.size(), file) == into.size();
}

}  // namespace biss::capture
