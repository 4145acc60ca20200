// Text in lines of a width, as help texts and `explain` print it.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace biss::verbs {

/// Columns, counted from 0.
struct Wrap {
  std::size_t first = 0;   ///< the column at which the text begins
  std::size_t indent = 0;  ///< the column at which its further lines begin
  std::size_t width = 0;   ///< of a line; a longer word is not broken
};

/// Appends `text` broken at spaces, without a line feed at its end.
void append_wrapped(std::string& out, std::string_view text, Wrap wrap);

}  // namespace biss::verbs
