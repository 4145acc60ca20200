#include "capture/event_csv_writer.hpp"

#include <string_view>
#include <utility>

namespace biss::capture {
namespace {

constexpr char no_level_yet = ' ';

std::string cell_of(std::string_view name) {
  std::string cell;
  bool quote = name.empty() || name.front() == ' ' || name.back() == ' ';
  for (const char c : name) {
    if (c == ',' || c == ';' || c == '\t' || c == '"') quote = true;
    if (c == '"') cell += '"';
    cell += c == '\n' || c == '\r' ? '_' : c;
  }
  if (cell.empty()) cell.push_back('_');
  return quote ? '"' + cell + '"' : cell;
}

}  // namespace

EventCsvWriter::EventCsvWriter(std::vector<std::string> lines, ByteSink& sink)
    : EdgeWriter(std::move(lines), sink), cells_(this->lines().size(), no_level_yet) {
  text() += "time_ns";
  for (const std::string& name : this->lines()) text() += ',' + cell_of(name);
  text() += '\n';
}

void EventCsvWriter::put_row() {
  const std::int64_t time = row_time_->count;
  if (time < 0) text() += '-';
  const auto magnitude = time < 0 ? std::uint64_t{0} - static_cast<std::uint64_t>(time)
                                  : static_cast<std::uint64_t>(time);
  append_number(magnitude / 1'000);
  const auto rest = static_cast<unsigned>(magnitude % 1'000);
  text() += '.';
  for (const unsigned place : {100U, 10U, 1U}) text() += static_cast<char>('0' + rest / place % 10);
  for (const char cell : cells_) {
    text() += ',';
    if (cell != no_level_yet) text() += cell;
  }
  text() += '\n';
}

void EventCsvWriter::put(const wire::Edge& edge, bool new_time) {
  if (row_time_ && (new_time || edge.line <= row_line_)) put_row();
  row_time_ = edge.time;
  row_line_ = edge.line;
  cells_[edge.line] = "01x"[static_cast<std::size_t>(edge.level)];
}

void EventCsvWriter::put_end(Picoseconds end_time, bool later) {
  if (row_time_) put_row();
  row_time_ = end_time;
  if (later && !cells_.empty()) put_row();
}

}  // namespace biss::capture
