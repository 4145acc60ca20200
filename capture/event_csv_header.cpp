#include "capture/event_csv_header.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "capture/line_names.hpp"

namespace biss::capture {
namespace {

std::string lower_case(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return lower;
}

char find_separator(std::string_view row) {
  bool quoted = false;
  char separator = ',';
  for (const char c : row) {
    if (c == '"') quoted = !quoted;
    if (quoted) continue;
    if (c == '\t') return '\t';
    if (c == ';') separator = ';';
  }
  return separator;
}

// Takes the first cell off `row`; `last` when no separator followed it.
std::string_view take_cell(std::string_view& row, char separator, bool& last) {
  bool quoted = false;
  std::size_t end = 0;
  for (; end < row.size() && (quoted || row[end] != separator); ++end) {
    if (row[end] == '"') quoted = !quoted;
  }
  const std::string_view cell = row.substr(0, end);
  last = end == row.size();
  row.remove_prefix(last ? end : end + 1);
  return trim_cell(cell, separator);
}

// A quoted cell without its quotes, doubled ones made single.
std::string unquote(std::string_view cell) {
  if (cell.size() < 2 || !cell.starts_with('"') || !cell.ends_with('"')) return std::string(cell);
  std::string text;
  for (std::size_t i = 1; i + 1 < cell.size(); ++i) {
    text += cell[i];
    if (cell[i] == '"' && cell[i + 1] == '"' && i + 2 < cell.size()) ++i;
  }
  return text;
}

}  // namespace

std::string_view trim_cell(std::string_view text, char separator) {
  const auto blank = [separator](char c) {
    return c == ' ' || c == '\r' || (c == '\t' && separator != '\t');
  };
  while (!text.empty() && blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && blank(text.back())) text.remove_suffix(1);
  return text;
}

std::optional<int> event_csv_time_scale(std::string_view name) {
  constexpr std::array<std::pair<std::string_view, int>, 8> units{{{"", 12},
                                                                   {"s", 12},
                                                                   {"ms", 9},
                                                                   {"us", 6},
                                                                   {"\xC2\xB5s", 6},
                                                                   {"\xCE\xBCs", 6},
                                                                   {"ns", 3},
                                                                   {"ps", 0}}};
  const std::string lower = lower_case(name);
  std::string_view unit = lower;
  if (!unit.starts_with("time")) return std::nullopt;
  unit.remove_prefix(4);
  unit.remove_prefix(std::min(unit.find_first_not_of(" _/(["), unit.size()));
  while (!unit.empty() && std::string_view(" )]").find(unit.back()) != std::string_view::npos) {
    unit.remove_suffix(1);
  }
  for (const auto& [text, scale] : units) {
    if (unit == text) return scale;
  }
  return std::nullopt;
}

bool looks_like_event_csv(std::string_view row) {
  bool last = false;
  const std::string_view cell = take_cell(row, find_separator(row), last);
  return lower_case(unquote(cell)).starts_with("time");
}

std::variant<EventCsvHeader, EventCsvHeaderFault> parse_event_csv_header(std::string_view row) {
  EventCsvHeader header;
  header.separator = find_separator(row);
  const char* const start = row.data();
  bool last = false;
  const auto scale = event_csv_time_scale(unquote(take_cell(row, header.separator, last)));
  if (!scale) {
    return EventCsvHeaderFault{0, "a header such as time_ns,MA,SLO with s, ms, us, ns or ps"};
  }
  header.scale = *scale;
  LineNames names;
  while (!last) {
    const auto offset = static_cast<std::size_t>(row.data() - start);
    const std::string name = unquote(take_cell(row, header.separator, last));
    if (name.empty()) return EventCsvHeaderFault{offset, "the name of a line in every column"};
    header.lines.push_back(names.claim(name));
  }
  if (header.lines.empty()) {
    return EventCsvHeaderFault{static_cast<std::size_t>(row.data() - start),
                               "a column for each line behind the time"};
  }
  return header;
}

}  // namespace biss::capture
