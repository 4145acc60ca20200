// The verbs and their options as data: the declarations by verb.hpp, and the values from a command
// line. The parser, the help, the manual page, the completion, Python and the page read these
// records.
#pragma once

#include <algorithm>
#include <functional>
#include <list>
#include <stdexcept>
#include <string>
#include <vector>

#include "verbs/common/verb.hpp"

namespace biss::verbs {

struct DeclaredVerb {
  VerbText text;
  Run run{};
  std::list<Option> options{};
  std::list<DeclaredVerb> verbs{};
  std::vector<std::function<void()>> checks{};
  bool parsed = false;

  const std::string& name() const { return text.name; }
  /// A verb below this one must be named.
  bool needs_verb() const { return !run && !verbs.empty(); }
};

/// The first option or verb that fits; null if there is none.
template <class Records, class Fits>
auto* find_record(Records& records, Fits fits) {
  const auto found = std::find_if(records.begin(), records.end(), fits);
  return found == records.end() ? nullptr : &*found;
}

/// The same by its name.
template <class Records>
auto* find_named(Records& records, const std::string& name) {
  return find_record(records, [&](const auto& each) { return each.name() == name; });
}

/// Why options are wrong, as one line.
class WrongUsage : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The mistakes in the words of a request that show before any value is read.
struct WrongWords {
  std::string missing_value{};
  /// Words that the verb does not take.
  std::vector<std::string> further{};
  std::string empty_option{};
};

inline constexpr const char* empty_value = "empty; a value is needed";

/// Adds a value as written, or the values that it is split into.
void give(Option& option, const std::string& value);

/// Gives the values to the options, in the order of declaration. Throws WrongUsage.
void set_given(const DeclaredVerb& verb);

/// Throws WrongUsage if an option is missing, or excluded by another one.
void check_given(const DeclaredVerb& verb);

}  // namespace biss::verbs
