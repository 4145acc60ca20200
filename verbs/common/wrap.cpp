#include "verbs/common/wrap.hpp"

#include <algorithm>

namespace biss::verbs {

void append_wrapped(std::string& out, std::string_view text, Wrap wrap) {
  std::size_t column = wrap.first;
  bool first = true;
  while (!text.empty()) {
    const std::string_view word = text.substr(0, text.find(' '));
    if (!first && column + 1 + word.size() > wrap.width) {
      out += '\n' + std::string(wrap.indent, ' ');
      column = wrap.indent;
    } else if (!first) {
      out += ' ';
      ++column;
    }
    out += word;
    column += word.size();
    text.remove_prefix(std::min(word.size() + 1, text.size()));
    first = false;
  }
}

}  // namespace biss::verbs
