#include "capture/key_file.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <utility>

#include "capture/decimal.hpp"
#include "capture/text_source.hpp"

namespace biss::capture {
namespace {

constexpr std::array<std::pair<char, char>, 5> escapes{
    {{'s', ' '}, {'n', '\n'}, {'t', '\t'}, {'r', '\r'}, {'\\', '\\'}}};

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view blanks = " \t\r";
  text.remove_prefix(std::min(text.find_first_not_of(blanks), text.size()));
  return text.substr(0, text.find_last_not_of(blanks) + 1);
}

// Takes the next row off the front of `text`.
std::string_view take_row(std::string_view& text) {
  const std::size_t end = std::min(text.find_first_of("\r\n"), text.size());
  const std::string_view row = trimmed(text.substr(0, end));
  const bool both = text.substr(end).starts_with("\r\n");
  text.remove_prefix(std::min(end + (both ? 2 : 1), text.size()));
  return row;
}

// Neither a section nor a key: empty, or a comment.
bool is_comment_row(std::string_view row) {
  return row.empty() || row.front() == '#' || row.front() == ';';
}

std::string unescaped(std::string_view value) {
  std::string text;
  for (std::size_t i = 0; i < value.size(); ++i) {
    const auto* const escape = std::find_if(escapes.begin(), escapes.end(), [&](const auto& e) {
      return value[i] == '\\' && i + 1 < value.size() && value[i + 1] == e.first;
    });
    if (escape != escapes.end()) ++i;
    text += escape != escapes.end() ? escape->second : value[i];
  }
  return text;
}

}  // namespace

std::string escaped(std::string_view text) {
  std::string value;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto* const escape = std::find_if(escapes.begin(), escapes.end(),
                                            [&](const auto& e) { return text[i] == e.second; });
    // Blanks inside are kept.
    const bool plain = text[i] == ' ' && i != 0 && i + 1 != text.size();
    if (escape == escapes.end() || plain) {
      value += text[i];
    } else {
      value += {'\\', escape->first};
    }
  }
  return value;
}

Hertz parse_sample_rate(std::string_view text) {
  text = trimmed(text);
  const std::size_t digits = std::min(text.find_first_not_of("0123456789."), text.size());
  std::string unit = lower_case(trimmed(text.substr(digits)));
  if (unit.ends_with("hz")) unit.resize(unit.size() - 2);
  int scale = 0;
  if (unit == "k") scale = 3;
  if (unit == "m") scale = 6;
  if (unit == "g") scale = 9;
  if (scale == 0 && !unit.empty()) return {};
  const auto rate = parse_decimal(text.substr(0, digits), scale);
  if (!rate.ok() || *rate > std::numeric_limits<std::uint32_t>::max()) return {};
  return Hertz{static_cast<std::uint32_t>(*rate)};
}

std::string sample_rate_text(Hertz rate) {
  constexpr std::array<std::pair<std::uint32_t, const char*>, 4> units{
      {{1'000'000'000, " GHz"}, {1'000'000, " MHz"}, {1'000, " kHz"}, {1, " Hz"}}};
  const auto* const unit = std::find_if(units.begin(), units.end(),
                                        [&](const auto& u) { return rate.count % u.first == 0; });
  return std::to_string(rate.count / unit->first) + unit->second;
}

std::optional<CaptureError> SamplesDescription::read(std::string_view text) {
  while (!text.empty()) {
    ++line_;
    const std::string_view row = take_row(text);
    if (!is_comment_row(row) && !read_row(row)) return error_;
  }
  if (!done_ && !complete()) return error_;
  return std::nullopt;
}

bool SamplesDescription::wrong(const char* expected, CaptureCause cause) {
  error_ = {.cause = cause, .line = line_, .column = 1, .expected = expected, .part = style_.part};
  return false;
}

bool SamplesDescription::read_row(std::string_view row) {
  if (row.front() == '[') return begin_section(row);
  if (done_) return true;
  const std::size_t equals = row.find('=');
  if (equals == std::string_view::npos) return wrong(style_.row);
  return take_key(trimmed(row.substr(0, equals)), trimmed(row.substr(equals + 1)));
}

bool SamplesDescription::take_key(std::string_view key, std::string_view value) {
  if (key == "capturefile") {
    if (!capture_file_.empty()) return wrong("the capturefile once");
    capture_file_ = unescaped(value);
  } else if (key == "samplerate") {
    if (rate_.count != 0) return wrong("the samplerate once");
    rate_ = parse_sample_rate(value);
    if (rate_.count == 0) return wrong("a sample rate of 1 Hz to 4.29 GHz");
  } else if (key.starts_with("probe")) {
    const auto number = whole_number<unsigned>(key.substr(5));
    if (!number || *number - style_.first_probe >= most_probes) return wrong(style_.probes);
    if (!probes_.emplace(*number, unescaped(value)).second) return wrong("each probe once");
  }
  return true;
}

}  // namespace biss::capture
