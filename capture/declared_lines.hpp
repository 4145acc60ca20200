// The one-bit signals that a simulator's file declares in scopes, and the lines they become.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "capture/edge_source.hpp"
#include "wire/edge.hpp"

namespace biss::capture {

/// The most variables of a file, whatever their width.
inline constexpr std::size_t max_variables = 1U << 20U;

/// A name of several words: a range after the name, or a name with blanks in it. `MA [3]` is
/// `MA[3]`; the range `[0:0]` of a one-bit signal is left out. \pre words is not empty
std::string joined_name(std::span<const std::string> words);

/// Collects signals of one bit. A signal has a name, a scope, and a variable: the number to which
/// the file's values belong.
///
/// The name of a line is its plain name. If another line has the same name, the scopes are added:
/// `top.cap.MA`. Signals of the same name and variable are one line; signals of another name and
/// the same variable are lines that change together.
class DeclaredLines {
 public:
  static constexpr std::size_t max_depth = 256;

  /// False when the names take too much memory. \pre depth() < max_depth
  bool open_scope(std::string_view name) {
    const std::uint32_t parent = open_scopes_.empty() ? no_scope : open_scopes_.back();
    if (!store(name.size() + sizeof(Scope))) return false;
    open_scopes_.push_back(static_cast<std::uint32_t>(scopes_.size()));
    scopes_.push_back({std::string(name), parent});
    return true;
  }

  /// \pre depth() != 0
  void close_scope() { open_scopes_.pop_back(); }
  std::size_t depth() const { return open_scopes_.size(); }

  /// Declares a signal in the open scope; false when there are too many.
  bool add(std::string name, std::uint32_t variable) {
    if (signals_.size() == max_lines || !store(name.size())) return false;
    const std::uint32_t scope = open_scopes_.empty() ? no_scope : open_scopes_.back();
    signals_.push_back({std::move(name), scope, variable});
    return true;
  }

  /// Accounts for memory that the caller spends on names; false when it is too much.
  bool store(std::size_t bytes) {
    stored_bytes_ += bytes;
    return stored_bytes_ <= max_stored_bytes;
  }

  /// Gives each line its name; false when the names take too much memory. Nothing is declared later.
  bool finish() {
    struct Group {
      std::uint32_t variable;
      bool differ;
      bool named;
    };
    std::unordered_map<std::string_view, Group> groups;
    for (const Signal& signal : signals_) {
      const auto entry =
          groups.try_emplace(signal.name, Group{signal.variable, false, false}).first;
      if (entry->second.variable != signal.variable) entry->second.differ = true;
    }
    for (const Signal& signal : signals_) {
      Group& group = groups.at(signal.name);
      if (!group.differ && std::exchange(group.named, true)) continue;
      std::string name = group.differ ? path_of(signal) : signal.name;
      if (!store(name.size())) return false;
      names_.push_back(std::move(name));
      variables_.push_back(signal.variable);
    }
    return true;
  }

  /// The variable of each line. \pre finish() returned true
  const std::vector<std::uint32_t>& variables() const { return variables_; }
  std::vector<std::string> take_names() { return std::move(names_); }

 private:
  static constexpr std::uint32_t no_scope = UINT32_MAX;
  static constexpr std::size_t max_stored_bytes = 64U << 20U;

  struct Scope {
    std::string name;
    std::uint32_t parent;
  };
  struct Signal {
    std::string name;
    std::uint32_t scope;
    std::uint32_t variable;
  };

  std::string path_of(const Signal& signal) const {
    std::vector<const std::string*> names;
    for (std::uint32_t at = signal.scope; at != no_scope; at = scopes_[at].parent) {
      names.push_back(&scopes_[at].name);
    }
    std::string path;
    for (auto name = names.rbegin(); name != names.rend(); ++name) path += **name + '.';
    return path + signal.name;
  }

  std::vector<Scope> scopes_;
  std::vector<std::uint32_t> open_scopes_;
  std::vector<Signal> signals_;
  std::size_t stored_bytes_ = 0;
  std::vector<std::uint32_t> variables_;
  std::vector<std::string> names_;
};

/// The last level of each variable, and the lines that show it.
class DrivenLines {
 public:
  DrivenLines() = default;
  /// \pre every variable of `lines` is below `variables`
  DrivenLines(const DeclaredLines& lines, std::uint32_t variables)
      : variables_(variables), driven_(lines.variables().size()) {
    for (const std::uint32_t variable : lines.variables()) ++variables_[variable].lines;
    std::uint32_t first = 0;
    for (Variable& variable : variables_) {
      variable.first = first;
      first += std::exchange(variable.lines, 0U);
    }
    for (std::size_t line = 0; line < driven_.size(); ++line) {
      Variable& variable = variables_[lines.variables()[line]];
      driven_[variable.first + variable.lines++] = static_cast<wire::LineIndex>(line);
    }
  }

  bool drives(std::uint32_t variable) const { return variables_[variable].lines != 0; }
  /// The number of lines of a variable.
  std::uint32_t lines_of(std::uint32_t variable) const { return variables_[variable].lines; }

  /// Pushes an edge for each line of the variable if that changes its level.
  void set(std::uint32_t variable, wire::Level level, Picoseconds time, EdgeBlock& block) {
    Variable& driver = variables_[variable];
    if (driver.level == static_cast<std::uint8_t>(level)) return;
    driver.level = static_cast<std::uint8_t>(level);
    for (std::uint32_t i = 0; i < driver.lines; ++i) {
      block.push({time, driven_[driver.first + i], level});
    }
  }

  /// The variable that drives the line. \pre the line is one of these
  std::uint32_t variable_of(wire::LineIndex line) const {
    for (std::uint32_t variable = 0;; ++variable) {
      const Variable& driver = variables_[variable];
      const auto* const first = driven_.data() + driver.first;
      if (std::find(first, first + driver.lines, line) != first + driver.lines) return variable;
    }
  }

  /// The variable has this level; no edge is pushed.
  void note(std::uint32_t variable, wire::Level level) {
    variables_[variable].level = static_cast<std::uint8_t>(level);
  }

  /// Every level that was known is unknown from now on.
  void lose_levels(Picoseconds time, EdgeBlock& block) {
    for (std::uint32_t variable = 0; variable < variables_.size(); ++variable) {
      if (variables_[variable].level != no_level) set(variable, wire::Level::unknown, time, block);
    }
  }

 private:
  struct Variable {
    std::uint32_t first = 0;  // place in driven_
    std::uint32_t lines = 0;
    std::uint8_t level = no_level;
  };

  std::vector<Variable> variables_;
  std::vector<wire::LineIndex> driven_;  // the lines of each variable, one after the other
};

}  // namespace biss::capture
