// Writes edges as an event CSV.
#include <cstddef>
#include <string>
#include <string_view>
#include <utility>

#include "capture/event_csv.hpp"

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

EventCsvWriter::EventCsvWriter(std::vector<std::string> lines, ByteSink& sink, CsvDialect dialect)
    : EdgeWriter(std::move(lines), sink),
      dialect_(dialect),
      cells_(this->lines().size(), dialect == CsvDialect::saleae ? 'X' : no_level_yet) {
  text() += dialect == CsvDialect::saleae ? "Time [s]" : "time_ns";
  for (const std::string& name : this->lines()) text() += ',' + cell_of(name);
  text() += '\n';
}

void EventCsvWriter::put_time(Picoseconds time) {
  if (time < Picoseconds{}) text() += '-';
  const auto count = static_cast<std::uint64_t>(time.count);
  const std::uint64_t magnitude = time < Picoseconds{} ? std::uint64_t{0} - count : count;
  const std::uint64_t unit =
      dialect_ == CsvDialect::saleae ? std::uint64_t{picoseconds_per_second} : 1'000;
  append_number(magnitude / unit);
  text() += '.';
  for (std::uint64_t place = unit / 10; place != 0; place /= 10) {
    text() += static_cast<char>('0' + magnitude / place % 10);
  }
}

void EventCsvWriter::put_row() {
  put_time(*row_time_);
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
  cells_[edge.line] =
      (dialect_ == CsvDialect::saleae ? "01X" : "01x")[static_cast<std::size_t>(edge.level)];
}

void EventCsvWriter::put_end(Picoseconds end_time, bool later) {
  if (row_time_) put_row();
  row_time_ = end_time;
  if (later && !cells_.empty()) put_row();
}

}  // namespace biss::capture
