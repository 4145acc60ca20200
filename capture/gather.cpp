#include "capture/gather.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string_view>
#include <system_error>
#include <utility>

namespace biss::capture {
namespace {

constexpr std::size_t most_in_memory = 16U * 1024U * 1024U;

// A stream of its own on the same file.
Stdio reopened(int descriptor) {
  const int copy = ::dup(descriptor);
  if (copy < 0) return nullptr;
  Stdio file(::fdopen(copy, "rb"));
  if (!file) ::close(copy);
  return file;
}

// A file without a name in TMPDIR, /tmp by default. Null on failure.
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

bool write_all(std::string_view bytes, std::FILE* file) {
  return std::fwrite(bytes.data(), 1, bytes.size(), file) == bytes.size();
}

}  // namespace

// What cannot be read at any place is copied to where it can be. Small files do not pay for the
// room that large ones want.
std::optional<Gathered> gather(std::unique_ptr<ByteSource> bytes) {
  constexpr std::size_t least_room = 4'096;
  constexpr std::size_t most_room = 1'048'576;
  Gathered gathered;
  if (const int descriptor = bytes->regular_file(); descriptor >= 0) {
    gathered.file = reopened(descriptor);
    if (!gathered.file) return std::nullopt;
    return gathered;
  }
  std::string& memory = gathered.memory;
  std::size_t filled = 0;
  for (;;) {
    if (filled == memory.size()) memory.resize(filled + std::clamp(filled, least_room, most_room));
    const auto got = bytes->read(std::span(memory).subspan(filled));
    if (!got.ok()) return std::nullopt;
    if (*got == 0) break;
    filled += *got;
    if (filled < most_in_memory) continue;
    if (!gathered.file) gathered.file = temporary_file();
    if (!gathered.file || !write_all({memory.data(), filled}, gathered.file.get())) {
      return std::nullopt;
    }
    filled = 0;
  }
  memory.resize(filled);
  if (!gathered.file) return gathered;
  if (!write_all(memory, gathered.file.get()) || std::fflush(gathered.file.get()) != 0) {
    return std::nullopt;
  }
  memory = {};
  return gathered;
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
  while (!into.empty()) {
    const ssize_t got =
        ::pread(::fileno(bytes_.file.get()), into.data(), into.size(), static_cast<off_t>(place));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    into = into.subspan(static_cast<std::size_t>(got));
    place += static_cast<std::uint64_t>(got);
  }
  return true;
}

}  // namespace biss::capture
