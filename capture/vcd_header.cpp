#include "capture/vcd_header.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <unordered_map>
#include <utility>

#include "capture/line_names.hpp"

namespace biss::capture {
namespace {

constexpr std::uint32_t no_scope = UINT32_MAX;

bool is_one_bit(std::string_view type, std::string_view size) {
  constexpr std::array<std::string_view, 4> without_level{"real", "realtime", "string", "event"};
  if (std::find(without_level.begin(), without_level.end(), type) != without_level.end()) {
    return false;
  }
  return size == "1";
}

bool is_number(std::string_view text) {
  return !text.empty() &&
         std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
}

// `[0:0]` says no more than that the signal has one bit; `[3]` says which bit of what it is.
bool is_whole_range(std::string_view text) {
  const std::size_t colon = text.find(':');
  if (!text.starts_with('[') || !text.ends_with(']') || colon == std::string_view::npos) {
    return false;
  }
  return text.substr(1, colon - 1) == text.substr(colon + 1, text.size() - colon - 2);
}

// Names may stand in several words: a range behind the name, or a name with blanks in it.
std::string join_name(const std::vector<std::string>& words, std::size_t first) {
  std::string name = words[first];
  for (std::size_t i = first + 1; i < words.size(); ++i) {
    if (is_whole_range(words[i])) continue;
    if (!words[i].starts_with('[')) name += ' ';
    name += words[i];
  }
  return name;
}

}  // namespace

std::uint64_t VcdTimescale::last_tick() const {
  if (divisor != 1) return std::numeric_limits<std::uint64_t>::max();
  return static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max()) / factor;
}

Picoseconds VcdTimescale::time_of(std::uint64_t ticks) const {
  if (divisor == 1) return {static_cast<std::int64_t>(ticks * factor)};
  const std::uint64_t round_up = ticks % divisor >= divisor / 2 ? 1 : 0;
  return {static_cast<std::int64_t>(ticks / divisor + round_up)};
}

VcdTimescale parse_vcd_timescale(std::string_view text) {
  const std::size_t digits = std::min(text.find_first_not_of("01"), text.size());
  const std::string_view number = text.substr(0, digits);
  if (number != "1" && number != "10" && number != "100") return {};
  const std::uint64_t count = number.size() == 1 ? 1 : number.size() == 2 ? 10 : 100;
  const std::string_view unit = text.substr(digits);
  if (unit == "fs") return {1, 1'000 / count};
  if (unit == "ps") return {count, 1};
  if (unit == "ns") return {count * 1'000, 1};
  if (unit == "us") return {count * 1'000'000, 1};
  if (unit == "ms") return {count * 1'000'000'000, 1};
  if (unit == "s") return {count * 1'000'000'000'000, 1};
  return {};
}

VcdHeader::Step VcdHeader::fail(CaptureCause cause, const char* expected) {
  cause_ = cause;
  expected_ = expected;
  return Step::failed;
}

bool VcdHeader::store(std::size_t bytes) {
  stored_bytes_ += bytes;
  return stored_bytes_ <= max_stored_bytes;
}

VcdHeader::Step VcdHeader::feed(std::string_view word) {
  if (section_ == Section::none) return begin_section(word);
  if (word == "$end") return end_section();
  if (section_ == Section::comment) return Step::more;
  if (words_.size() == max_words) return malformed("$end, after so many words");
  words_.emplace_back(word);
  return Step::more;
}

VcdHeader::Step VcdHeader::begin_section(std::string_view keyword) {
  if (keyword.size() < 2 || keyword[0] != '$' || keyword[1] < 'a' || keyword[1] > 'z') {
    return malformed(started_ ? "a declaration such as $var, or $enddefinitions"
                              : "a VCD, which begins with a word such as $timescale or $date");
  }
  started_ = true;
  words_.clear();
  constexpr std::array<std::pair<std::string_view, Section>, 5> sections{{
      {"$timescale", Section::timescale},
      {"$var", Section::var},
      {"$scope", Section::scope},
      {"$upscope", Section::upscope},
      {"$enddefinitions", Section::end},
  }};
  if (keyword == "$end") return malformed("a declaration for $end to close");
  // $date, $version, $comment, and what tools have invented: text up to $end.
  section_ = Section::comment;
  for (const auto& [name, section] : sections) {
    if (keyword == name) section_ = section;
  }
  return Step::more;
}

VcdHeader::Step VcdHeader::end_section() {
  switch (std::exchange(section_, Section::none)) {
    case Section::timescale:
      return end_timescale();
    case Section::var:
      return end_var();
    case Section::scope:
      return end_scope();
    case Section::upscope:
      return end_upscope();
    case Section::end:
      return end_definitions();
    case Section::none:
    case Section::comment:
      break;
  }
  return Step::more;
}

VcdHeader::Step VcdHeader::end_timescale() {
  std::string text;
  for (const std::string& word : words_) text += word;
  const VcdTimescale timescale = parse_vcd_timescale(text);
  if (!timescale.known()) {
    return malformed("a time scale of 1, 10 or 100 and s, ms, us, ns, ps or fs before this $end");
  }
  if (signals_.timescale.known() && timescale != signals_.timescale) {
    return malformed("one $timescale; this second one differs from the first");
  }
  signals_.timescale = timescale;
  return Step::more;
}

VcdHeader::Step VcdHeader::end_var() {
  if (words_.size() < 4) return malformed("type, size, identifier and name before this $end");
  if (!is_number(words_[1])) return malformed("a number of bits as the second word of this $var");
  if (!VcdIds::valid(words_[2])) {
    return malformed("an identifier of printable characters as the third word of this $var");
  }
  const std::uint32_t variable = signals_.ids.add(words_[2]);
  if (signals_.ids.size() > max_variables || !store(words_[2].size())) {
    return fail(CaptureCause::too_many_lines, nullptr);
  }
  if (!is_one_bit(words_[0], words_[1])) return Step::more;
  std::string name = join_name(words_, 3);
  if (lines_.size() == max_lines || !store(name.size())) {
    return fail(CaptureCause::too_many_lines, nullptr);
  }
  lines_.push_back(
      {std::move(name), open_scopes_.empty() ? no_scope : open_scopes_.back(), variable});
  return Step::more;
}

VcdHeader::Step VcdHeader::end_scope() {
  if (words_.size() < 2) return malformed("kind and name of the scope before this $end");
  if (open_scopes_.size() == max_scopes) return malformed("at most 256 scopes in one another");
  const std::uint32_t parent = open_scopes_.empty() ? no_scope : open_scopes_.back();
  if (!store(words_[1].size() + sizeof(Scope))) return fail(CaptureCause::too_many_lines, nullptr);
  open_scopes_.push_back(static_cast<std::uint32_t>(scopes_.size()));
  scopes_.push_back({words_[1], parent});
  return Step::more;
}

VcdHeader::Step VcdHeader::end_upscope() {
  if (open_scopes_.empty()) return malformed("a $scope for this $upscope to close");
  open_scopes_.pop_back();
  return Step::more;
}

VcdHeader::Step VcdHeader::end_definitions() {
  if (!signals_.timescale.known()) return malformed("a $timescale before $enddefinitions");
  if (!name_lines()) return fail(CaptureCause::too_many_lines, nullptr);
  connect_lines();
  return Step::done;
}

std::string VcdHeader::path_of(const Signal& signal) const {
  std::vector<const std::string*> names;
  for (std::uint32_t at = signal.scope; at != no_scope; at = scopes_[at].parent) {
    names.push_back(&scopes_[at].name);
  }
  std::string path;
  for (auto name = names.rbegin(); name != names.rend(); ++name) path += **name + '.';
  return path + signal.name;
}

// Gives each line its name and removes signals that are another one over again. False when the
// names would take too much memory.
bool VcdHeader::name_lines() {
  struct Group {
    std::uint32_t variable;
    bool differ;
    bool named;
  };
  std::unordered_map<std::string_view, Group> groups;
  for (const Signal& signal : lines_) {
    const auto entry = groups.try_emplace(signal.name, Group{signal.variable, false, false}).first;
    if (entry->second.variable != signal.variable) entry->second.differ = true;
  }
  LineNames names;
  std::vector<Signal> kept;
  for (const Signal& signal : lines_) {
    Group& group = groups.at(signal.name);
    if (!group.differ && std::exchange(group.named, true)) continue;
    std::string name = group.differ ? path_of(signal) : signal.name;
    if (!store(name.size())) return false;
    signals_.lines.push_back(names.claim(name));
    kept.push_back({{}, no_scope, signal.variable});
  }
  lines_ = std::move(kept);
  return true;
}

// Sorts the lines by the identifier that drives them.
void VcdHeader::connect_lines() {
  std::vector<VcdVariable>& variables = signals_.variables;
  variables.resize(signals_.ids.size());
  for (const Signal& line : lines_) ++variables[line.variable].lines;
  std::uint32_t first = 0;
  for (VcdVariable& variable : variables) {
    variable.first = std::exchange(first, first + variable.lines);
  }
  std::vector<std::uint32_t> next(variables.size());
  std::transform(variables.begin(), variables.end(), next.begin(),
                 [](const VcdVariable& variable) { return variable.first; });
  signals_.driven.resize(lines_.size());
  for (std::size_t line = 0; line < lines_.size(); ++line) {
    signals_.driven[next[lines_[line].variable]++] = static_cast<wire::LineIndex>(line);
  }
}

}  // namespace biss::capture
