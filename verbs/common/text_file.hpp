// A whole file as text, up to a largest size.
#pragma once

#include <string>
#include <tl/expected.hpp>

namespace biss::verbs {

/// The text, or why there is none: "cannot open it: No such file or directory", "it is a
/// directory", "it is larger than 64 MiB", "cannot read it: …".
tl::expected<std::string, std::string> read_text_file(const std::string& path);

}  // namespace biss::verbs
