// The layout of raw samples in the first bytes of an input.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "capture/samples.hpp"

namespace biss::fuzz {

/// The sample rate, little end first; bytes per sample; the number of lines; the bit of each of the
/// first eight lines.
inline constexpr std::size_t raw_header_bytes = 4 + 1 + 1 + 8;

inline std::string raw_header(const capture::RawLayout& layout) {
  std::string header;
  for (unsigned i = 0; i < 4; ++i) header += static_cast<char>(layout.rate.count >> (8 * i));
  header += static_cast<char>(layout.unit_bytes);
  header += static_cast<char>(layout.lines.size());
  for (const capture::SampleLine& line : layout.lines) header += static_cast<char>(line.bit);
  header.resize(raw_header_bytes);
  return header;
}

/// The layout of a header, which may be invalid. \pre header.size() >= raw_header_bytes
inline capture::RawLayout raw_layout(std::string_view header) {
  const auto byte = [header](std::size_t i) { return static_cast<std::uint8_t>(header[i]); };
  capture::RawLayout layout;
  for (std::size_t i = 0; i < 4; ++i) layout.rate.count |= std::uint32_t{byte(i)} << (8 * i);
  layout.unit_bytes = byte(4);
  // Two names belong to BiSS lines, and some occur twice.
  constexpr std::string_view names[] = {"MA", "SLO", "a", "b", "a", "SLO", "", "c"};
  const std::size_t lines = std::min<std::size_t>(byte(5), std::size(names));
  for (std::size_t i = 0; i < lines; ++i) {
    layout.lines.push_back({std::string(names[i]), byte(6 + i)});
  }
  return layout;
}

}  // namespace biss::fuzz
