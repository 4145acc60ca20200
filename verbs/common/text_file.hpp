// A whole file as text, up to a largest size, or line by line.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

#include "verbs/common/host.hpp"

namespace biss::verbs {

/// The text, or why there is none: "cannot open it: No such file or directory", "it is a
/// directory", "it is larger than 64 MiB", "cannot read it: …".
tl::expected<std::string, std::string> read_text_file(const std::string& path);

/// Calls take(line) for the lines of a file, or of standard input for `-`: without `#` comments,
/// and no empty line. take() returns an empty text, or why the line is wrong. The first error ends
/// the file: read_lines() throws a VerbError with `io`.
/// \param option that names the file
void read_lines(std::string_view option, const std::string& path,
                const std::function<std::string(std::string_view line)>& take);

}  // namespace biss::verbs
