#include "verbs/common/text_file.hpp"

#include <fmt/format.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <system_error>

#include "dump/text.hpp"

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

void read_lines(std::string_view option, const std::string& path,
                const std::function<std::string(std::string_view line)>& take) {
  const bool is_stdin = path == "-";
  std::ifstream file;
  if (!is_stdin) file.open(path);
  std::error_code ignored;
  if (!is_stdin && (!file || std::filesystem::is_directory(path, ignored))) {
    throw wrong_file("{}: cannot open '{}'", option, path);
  }
  dump::LineSource lines(is_stdin ? std::cin : file, {});
  const auto wrong = [&](std::uint64_t line, std::string_view what) {
    return wrong_file("{}: line {}: {}", is_stdin ? "standard input" : path, line, what);
  };
  while (lines.next()) {
    const std::string_view line = dump::without_comment(lines.line());
    const std::string why = line.empty() ? "" : take(line);
    if (!why.empty()) throw wrong(lines.number(), why);
  }
  if (!lines.error()) return;
  throw wrong(lines.error()->line, lines.error()->cause == dump::DumpCause::line_too_long
                                       ? fmt::format("longer than {} bytes", dump::max_line_bytes)
                                       : "cannot be read");
}

}  // namespace biss::verbs
