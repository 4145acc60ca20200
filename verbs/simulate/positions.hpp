// `--positions`: the positions that the encoder sends, one with each request.
#pragma once

#include <cstdint>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "verbs/common/host.hpp"

namespace biss::verbs {

/// Reads a file with one position a line; `#` begins a comment. At least one position, at most a
/// million, none wider than `bits`.
tl::expected<std::vector<std::uint64_t>, VerbError> read_positions(const std::string& path,
                                                                   unsigned bits);

}  // namespace biss::verbs
