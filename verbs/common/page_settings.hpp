// The settings with which the page reads a capture: the options of `biss decode` in a command line.
#pragma once

#include <string>
#include <vector>

#include "verbs/common/verb.hpp"

namespace biss::verbs {

/// An option and its values, as words.
struct PageOption {
  Scope scope;
  std::vector<std::string> words;
};

/// The same members as `Settings` of the page, see view/src/state.ts.
struct PageSettings {
  std::string format;
  std::string ma;
  std::string slo;
  /// `deg` or `mm`; empty for counts.
  std::string units;
  bool invert_ma = false;
  bool invert_slo = false;
  /// Further options of `biss decode`, each with its values.
  std::vector<PageOption> further;

  /// The further options as one text, which view/src/core/arguments.ts splits again.
  std::string further_text() const;
  /// The part of an address after #, see view/src/shell/link.ts.
  std::string link_text() const;
};

/// \param given the options of a verb that reads a capture; options for the verb alone are left out
PageSettings page_settings(const std::vector<Option>& given);

}  // namespace biss::verbs
