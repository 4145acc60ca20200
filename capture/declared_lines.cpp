#include "capture/declared_lines.hpp"

namespace biss::capture {
namespace {

// `[0:0]` only means that the signal has one bit; `[3]` selects a bit of a wider signal.
bool is_whole_range(std::string_view text) {
  const std::size_t colon = text.find(':');
  if (!text.starts_with('[') || !text.ends_with(']') || colon == std::string_view::npos) {
    return false;
  }
  return text.substr(1, colon - 1) == text.substr(colon + 1, text.size() - colon - 2);
}

}  // namespace

std::string joined_name(std::span<const std::string> words) {
  std::string name = words[0];
  for (const std::string& word : words.subspan(1)) {
    if (is_whole_range(word)) continue;
    if (!word.starts_with('[')) name += ' ';
    name += word;
  }
  return name;
}

}  // namespace biss::capture
