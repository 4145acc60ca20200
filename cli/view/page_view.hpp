// Options of `biss decode` as the page takes them.
#pragma once

#include <string>
#include <vector>

#include "cli/common/verb.hpp"

namespace biss::cli {

/// The part of an address after #, see view/src/shell/link.ts. Options of the verb that are none of
/// `biss decode` are left out.
std::string page_view(const std::vector<Option>& given);

/// A word of the field Options, as view/src/core/arguments.ts splits it.
std::string quoted_word(const std::string& word);

}  // namespace biss::cli
