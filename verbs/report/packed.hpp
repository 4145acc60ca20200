// Bytes as text of a page.
#pragma once

#include <string>
#include <string_view>

namespace biss::verbs {

/// Base64 of gzip; the same bytes give the same text.
std::string packed(std::string_view bytes);

}  // namespace biss::verbs
