#include "verbs/common/text_file.hpp"

#include <fmt/format.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>

namespace biss::verbs {

// More than any file that this program writes: a state, a table of a bundle.
constexpr std::size_t max_text_file_bytes = std::size_t{64} << 20U;

tl::expected<std::string, std::string> read_text_file(const std::string& path) {
  const auto wrong = [](const char* what) {
    return tl::make_unexpected(fmt::format("{}: {}", what, std::strerror(errno)));
  };
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"),
                                                             std::fclose);
  if (!file) return wrong("cannot open it");
  std::string text;
  std::array<char, 65536> block{};
  for (;;) {
    const std::size_t size = std::fread(block.data(), 1, block.size(), file.get());
    if (std::ferror(file.get()) != 0) {
      if (errno == EISDIR) return tl::make_unexpected(std::string("it is a directory"));
      return wrong("cannot read it");
    }
    if (size == 0) return text;
    text.append(block.data(), size);
    if (text.size() > max_text_file_bytes) {
      return tl::make_unexpected(
          fmt::format("it is larger than {} MiB", max_text_file_bytes >> 20U));
    }
  }
}

}  // namespace biss::verbs
