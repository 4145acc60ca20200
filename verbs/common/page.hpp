// The page that shows a capture in a browser, with a capture in it: see view/README.md.
#pragma once

#include <initializer_list>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

#include "verbs/common/verb.hpp"

namespace biss::verbs {

/// `--page FILE`, to be given to read_page().
Option add_page_option(Verb verb, std::string& path);

/// The text of the page. Without a path it is share/biss/biss.html of the command's installation,
/// otherwise view/dist/biss.html next to the command's build folder.
/// \return `io`: there is no page, it cannot be read, or the file is not the page of biss
tl::expected<std::string, VerbError> read_page(const std::string& path);

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

}  // namespace biss::verbs
