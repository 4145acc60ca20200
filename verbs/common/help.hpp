// The forms in which the help is printed.
#pragma once

#include <string>
#include <string_view>

#include "verbs/common/declared.hpp"

namespace biss::verbs {

/// The text of `--help` for a verb. For a verb with verbs, a list of them.
/// \param path `biss`, `biss eds show`
std::string help_text(const DeclaredVerb& verb, const std::string& path);

/// The manual page of the whole command, in the macros of man(7).
std::string man_page(const DeclaredVerb& command, std::string_view version);

/// A completion script for bash: verbs, options, values of options that take one of some names, and
/// encoders for --format.
std::string bash_completion(const DeclaredVerb& command);

/// A verb and those below it as JSON, with their options; wasm/biss.d.mts has the fields.
std::string described(const DeclaredVerb& verb);

}  // namespace biss::verbs
