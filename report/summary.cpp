#include "report/summary.hpp"

#include <algorithm>

#include "report/text.hpp"

namespace biss::report {
namespace {

std::string printable(std::string_view text) {
  std::string out;
  append_printable(out, text);
  return out;
}

}  // namespace

void Summary::title(std::string_view text) { lines_.push_back({true, printable(text), {}, {}}); }

void Summary::entry(std::string_view key, std::string_view value, std::string_view note) {
  lines_.push_back({false, printable(key), printable(value), printable(note)});
}

std::string Summary::text() const {
  std::size_t key_width = 0;
  std::size_t value_width = 0;
  for (const Line& line : lines_) {
    if (line.is_title) continue;
    key_width = std::max(key_width, display_width(line.key));
    // A long value without a note is prose and must not push the notes of others away.
    if (!line.note.empty()) value_width = std::max(value_width, display_width(line.value));
  }
  std::string out;
  for (const Line& line : lines_) {
    if (line.is_title) {
      if (!out.empty()) out.push_back('\n');
      out.append(line.key);
    } else {
      append_padded(out, line.key, key_width + 2, false);
      append_padded(out, line.value, line.note.empty() ? 0 : value_width + 2, false);
      out.append(line.note);
    }
    while (!out.empty() && out.back() == ' ') out.pop_back();
    out.push_back('\n');
  }
  return out;
}

std::string counted(std::uint64_t count, std::string_view noun) {
  std::string out;
  append_number(out, count);
  out.append(" ").append(noun);
  return count == 1 ? out : out + 's';
}

void append_count(std::string& list, std::uint64_t count, std::string_view name) {
  if (count == 0) return;
  if (!list.empty()) list.append(", ");
  append_number(list, count);
  list.append(" ").append(name);
}

}  // namespace biss::report
