// A whole file as text, of a size that is bounded.
#pragma once

#include <cstddef>
#include <string>

namespace biss::cli {

/// More is no file that this program writes: a state, a bundle's table.
inline constexpr std::size_t max_text_file_bytes = std::size_t{64} << 20U;

/// The text, or why there is none: "cannot open it: No such file or directory", "it is a
/// directory", "it is larger than 64 MiB", "cannot read it: …".
struct TextFile {
  std::string text;
  std::string error;

  explicit operator bool() const { return error.empty(); }
};

TextFile read_text_file(const std::string& path);

}  // namespace biss::cli
