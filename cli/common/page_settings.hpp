// What the page reads a capture with: the options of `biss decode` that a command line has.
#pragma once

#include <string>
#include <vector>

#include "cli/common/verb.hpp"

namespace biss::cli {

/// As `Settings` of the page, see view/src/state.ts.
struct PageSettings {
  std::string format;
  std::string ma;
  std::string slo;
  /// `deg` or `mm`; empty for counts.
  std::string units;
  bool invert_ma = false;
  bool invert_slo = false;
  /// Further options of `biss decode`, each with its values.
  std::vector<std::vector<std::string>> further;

  /// The further options as one text, which view/src/core/arguments.ts splits again.
  std::string further_text() const;
  /// As the part of an address after #, see view/src/shell/link.ts.
  std::string link_text() const;
};

/// \param given the options of a verb that reads a capture. Those that say where the page comes from
/// and goes to are left out.
PageSettings page_settings(const std::vector<Option>& given);

}  // namespace biss::cli
