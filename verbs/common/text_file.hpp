// A whole file as text, up to a largest size.
#pragma once

#include <cstddef>
#include <string>
#include <tl/expected.hpp>

namespace biss::verbs {

/// More than any file that this program writes: a state, a table of a bundle.
inline constexpr std::size_t max_text_file_bytes = std::size_t{64} << 20U;

/// The text, or why there is none: "cannot open it: No such file or directory", "it is a
/// directory", "it is larger than 64 MiB", "cannot read it: …".
tl::expected<std::string, std::string> read_text_file(const std::string& path);

}  // namespace biss::verbs
