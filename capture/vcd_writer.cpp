// Writes edges as VCD.
#include <cstddef>
#include <string>
#include <string_view>
#include <utility>

#include "capture/vcd.hpp"

namespace biss::capture {
namespace {

// 0 is `!`, 1 is `"`, … 94 is `!!`: the shortest identifiers first.
std::string id_of(std::size_t line) {
  constexpr std::size_t letters = '~' - '!' + 1;
  std::string id;
  for (;;) {
    id += static_cast<char>('!' + line % letters);
    if (line < letters) return id;
    line = line / letters - 1;
  }
}

std::string one_word(std::string_view name) {
  std::string word(name);
  for (char& c : word) {
    if (static_cast<unsigned char>(c) <= ' ') c = '_';
  }
  if (word.empty() || word == "$end") return "_" + word;
  return word;
}

}  // namespace

VcdWriter::VcdWriter(std::vector<std::string> lines, ByteSink& sink)
    : EdgeWriter(std::move(lines), sink) {
  text() += "$timescale 1ps $end\n$scope module capture $end\n";
  for (const std::string& line : this->lines()) {
    ids_.push_back(id_of(ids_.size()));
    text() += "$var wire 1 " + ids_.back() + ' ' + one_word(line) + " $end\n";
  }
  text() += "$upscope $end\n$enddefinitions $end\n";
}

void VcdWriter::put_time(Picoseconds time) {
  text() += '#';
  append_number(static_cast<std::uint64_t>(time.count));
  text() += '\n';
}

void VcdWriter::put(const wire::Edge& edge, bool new_time) {
  if (new_time) put_time(edge.time);
  text() += "01x"[static_cast<std::size_t>(edge.level)];
  text() += ids_[edge.line];
  text() += '\n';
}

void VcdWriter::put_end(Picoseconds end_time, bool later) {
  if (later) put_time(end_time);
}

}  // namespace biss::capture
