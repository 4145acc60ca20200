#include "capture/csv_cells.hpp"

#include <cstddef>
#include <cstring>

namespace biss::capture {

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

std::string_view trim_cell(std::string_view text, char separator) {
  const auto blank = [separator](char c) {
    return c == ' ' || c == '\r' || (c == '\t' && separator != '\t');
  };
  while (!text.empty() && blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && blank(text.back())) text.remove_suffix(1);
  return text;
}

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

std::string_view without_quotes(std::string_view cell) {
  if (cell.size() < 2 || !cell.starts_with('"') || !cell.ends_with('"')) return cell;
  return cell.substr(1, cell.size() - 2);
}

std::string unquote(std::string_view cell) {
  if (cell.size() < 2 || !cell.starts_with('"') || !cell.ends_with('"')) return std::string(cell);
  std::string text;
  for (std::size_t i = 1; i + 1 < cell.size(); ++i) {
    text += cell[i];
    if (cell[i] == '"' && cell[i + 1] == '"' && i + 2 < cell.size()) ++i;
  }
  return text;
}

std::vector<std::string> cells_of(std::string_view row, char separator) {
  constexpr std::size_t usual_cells = 8;
  std::vector<std::string> cells;
  cells.reserve(usual_cells);
  for (bool last = false; !last;) cells.push_back(unquote(take_cell(row, separator, last)));
  return cells;
}

bool is_csv_comment(std::string_view row) {
  if (!row.empty() && row.front() >= '-' && row.front() <= '9') return false;
  row = trim_cell(row, ',');
  return row.empty() || (row.front() == '#' && row.find('\r') == std::string_view::npos);
}

const char* find_or_end(const char* from, const char* end, char wanted) {
  const void* const found = std::memchr(from, wanted, static_cast<std::size_t>(end - from));
  return found == nullptr ? end : static_cast<const char*>(found);
}

}  // namespace biss::capture
