#include "capture/spool.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <system_error>

namespace biss::capture {

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

}  // namespace biss::capture
