// What a page reads a capture with.
#pragma once

#include <string>
#include <vector>

#include "cli/common/verb.hpp"

namespace biss::cli {

/// As `Settings` of the page, see view/src/state.ts.
struct ViewSettings {
  std::string format;
  std::string ma;
  std::string slo;
  bool invert_ma = false;
  bool invert_slo = false;
  /// Further options of `biss decode`, a word each.
  std::vector<std::string> further;

  /// The further words as one text, which the page splits again.
  std::string further_text() const;
  /// As the part of an address after #.
  std::string link_text() const;
};

/// The settings that a command line has. \pre the options of `verb` are parsed
ViewSettings view_settings(const Verb& verb);

}  // namespace biss::cli
