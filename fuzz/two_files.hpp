// Two files as one input: the size of the first in four bytes, then both.
#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "capture/edge_source.hpp"
#include "capture/little_endian.hpp"
#include "capture/merge.hpp"
#include "capture/open.hpp"
#include "fuzz/require.hpp"

namespace biss::fuzz {

struct TwoFiles {
  std::string_view first;
  std::string_view second;
};

inline constexpr std::size_t first_size_bytes = 4;

inline std::string joined_files(const TwoFiles& files) {
  std::string input;
  capture::put_number(input, files.first.size(), first_size_bytes);
  return input.append(files.first).append(files.second);
}

/// Both are empty if the input has no size of the first.
inline TwoFiles split_files(std::string_view input) {
  if (input.size() < first_size_bytes) return {};
  const auto size = static_cast<std::size_t>(capture::get_number(input.data(), first_size_bytes));
  input.remove_prefix(first_size_bytes);
  const std::size_t first = std::min(size, input.size());
  return {input.substr(0, first), input.substr(first)};
}

/// Both files as one capture of the lines `MA` and `SLO`; the first alone if the second cannot be
/// opened. \param open opens the bytes of a file
template <class Open>
capture::Opened open_files(const TwoFiles& files, Open open) {
  std::vector<capture::NamedSource> sources;
  auto first = open(files.first);
  if (!first) return first;
  sources.push_back({std::move(*first), "MA"});
  auto second = open(files.second);
  if (second) sources.push_back({std::move(*second), "SLO"});
  require(second || !capture::capture_error_text(second.error(), "x").empty());
  return std::make_unique<capture::MergedSource>(std::move(sources));
}

}  // namespace biss::fuzz
