#include "cli/common/text_file.hpp"

#include <fmt/format.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>

namespace biss::cli {

TextFile read_text_file(const std::string& path) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"),
                                                             std::fclose);
  if (!file) return {{}, fmt::format("cannot open it: {}", std::strerror(errno))};
  TextFile read;
  std::array<char, 65536> block{};
  for (;;) {
    const std::size_t size = std::fread(block.data(), 1, block.size(), file.get());
    if (std::ferror(file.get()) != 0) {
      if (errno == EISDIR) return {{}, "it is a directory"};
      return {{}, fmt::format("cannot read it: {}", std::strerror(errno))};
    }
    if (size == 0) return read;
    read.text.append(block.data(), size);
    if (read.text.size() > max_text_file_bytes) {
      return {{}, fmt::format("it is larger than {} MiB", max_text_file_bytes >> 20U)};
    }
  }
}

}  // namespace biss::cli
