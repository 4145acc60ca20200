#include "capture/declared_lines.hpp"

#include <algorithm>
#include <unordered_map>

namespace biss::capture {
namespace {

constexpr std::uint32_t no_scope = UINT32_MAX;

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

bool DeclaredLines::store(std::size_t bytes) {
  stored_bytes_ += bytes;
  return stored_bytes_ <= max_stored_bytes;
}

bool DeclaredLines::open_scope(std::string_view name) {
  const std::uint32_t parent = open_scopes_.empty() ? no_scope : open_scopes_.back();
  if (!store(name.size() + sizeof(Scope))) return false;
  open_scopes_.push_back(static_cast<std::uint32_t>(scopes_.size()));
  scopes_.push_back({std::string(name), parent});
  return true;
}

bool DeclaredLines::add(std::string name, std::uint32_t variable) {
  if (signals_.size() == max_lines || !store(name.size())) return false;
  const std::uint32_t scope = open_scopes_.empty() ? no_scope : open_scopes_.back();
  signals_.push_back({std::move(name), scope, variable});
  return true;
}

std::string DeclaredLines::path_of(const Signal& signal) const {
  std::vector<const std::string*> names;
  for (std::uint32_t at = signal.scope; at != no_scope; at = scopes_[at].parent) {
    names.push_back(&scopes_[at].name);
  }
  std::string path;
  for (auto name = names.rbegin(); name != names.rend(); ++name) path += **name + '.';
  return path + signal.name;
}

bool DeclaredLines::finish() {
  struct Group {
    std::uint32_t variable;
    bool differ;
    bool named;
  };
  std::unordered_map<std::string_view, Group> groups;
  for (const Signal& signal : signals_) {
    const auto entry = groups.try_emplace(signal.name, Group{signal.variable, false, false}).first;
    if (entry->second.variable != signal.variable) entry->second.differ = true;
  }
  LineNames names;
  for (const Signal& signal : signals_) {
    Group& group = groups.at(signal.name);
    if (!group.differ && std::exchange(group.named, true)) continue;
    std::string name = group.differ ? path_of(signal) : signal.name;
    if (!store(name.size())) return false;
    names_.push_back(names.claim(name));
    variables_.push_back(signal.variable);
  }
  return true;
}

DrivenLines::DrivenLines(const DeclaredLines& lines, std::uint32_t variables)
    : variables_(variables), driven_(lines.variables().size()) {
  for (const std::uint32_t variable : lines.variables()) ++variables_[variable].lines;
  std::uint32_t first = 0;
  for (Variable& variable : variables_) {
    variable.first = std::exchange(first, first + variable.lines);
  }
  for (std::size_t line = 0; line < driven_.size(); ++line) {
    Variable& variable = variables_[lines.variables()[line]];
    driven_[variable.first++] = static_cast<wire::LineIndex>(line);
  }
  for (Variable& variable : variables_) {
    variable.first -= variable.lines;
    if (variable.lines == 1) variable.first = driven_[variable.first];
  }
}

std::uint32_t DrivenLines::variable_of(wire::LineIndex line) const {
  for (std::uint32_t variable = 0;; ++variable) {
    const Variable& driver = variables_[variable];
    if (driver.lines == 1 && driver.first == line) return variable;
    if (driver.lines < 2) continue;
    const auto* const first = driven_.data() + driver.first;
    if (std::find(first, first + driver.lines, line) != first + driver.lines) return variable;
  }
}

void DrivenLines::lose_levels(Picoseconds time, EdgeBlock& block) {
  for (std::uint32_t variable = 0; variable < variables_.size(); ++variable) {
    if (variables_[variable].level != no_level) set(variable, wire::Level::unknown, time, block);
  }
}

}  // namespace biss::capture
