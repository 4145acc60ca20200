// The contents of the help, and the forms in which it is printed.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace biss::verbs {

/// Help texts have at most this many columns; an example is never broken.
inline constexpr std::size_t help_width = 100;

struct OptionHelp {
  std::string name;     ///< `-f, --format`, or `FILE...` for an argument
  std::string value;    ///< `TIME`, `table|csv|jsonl`; empty for a flag or an argument
  std::string text;     ///< what it does
  std::string heading;  ///< `Options`, `Device timing`; empty for an argument
  bool required = false;
};

struct VerbHelp {
  std::string name;  ///< `biss`, `biss eds show`
  std::string purpose;
  std::vector<OptionHelp> options;  ///< in the order of declaration
  std::vector<std::string> examples;
  std::vector<VerbHelp> verbs;
};

/// The text of `--help` for a verb. For a verb with verbs, a list of them.
std::string help_text(const VerbHelp& verb);

/// The manual page of the whole command, in the macros of man(7).
std::string man_page(const VerbHelp& command, std::string_view version);

/// A completion script for bash: verbs, options, values of options that take one of some names, and
/// encoders for --format.
std::string bash_completion(const VerbHelp& command);

}  // namespace biss::verbs
