// The page that shows a capture in a browser, with a capture in it, and its settings: see
// view/README.md.
#pragma once

#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include "verbs/common/verb.hpp"

namespace biss::verbs {

/// `--page FILE`, to be given to read_page().
Option& add_page_option(Verb verb, std::string& path);

/// The text of the page. Without a path it is share/biss/biss.html of the command's installation,
/// otherwise view/dist/biss.html next to the command's build folder.
/// Throws a VerbError with `io`: there is no page, it cannot be read, or the file is not the page
/// of biss.
std::string read_page(const std::string& path);

/// An attribute of an element: `data-NAME="VALUE"`. The value is any text.
struct PageAttribute {
  std::string_view name;
  std::string_view value;
};

/// The page with one more element: `biss-capture`, which view/src/shell/carried.ts describes, or
/// `biss-report`, which view/src/core/report.ts describes: facts about the whole capture, for a page
/// with a part of it.
/// \param content base64 of gzip, or empty
/// \pre `page` is from read_page()
std::string page_with(std::string_view page, std::string_view id,
                      std::initializer_list<PageAttribute> attributes, std::string_view content);

/// An option and its values, as words.
struct PageOption {
  Scope scope;
  std::vector<std::string> words;
};

/// The settings with which the page reads a capture: the options of `biss decode` in a command line.
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
PageSettings page_settings(const std::vector<const Option*>& given);

}  // namespace biss::verbs
