// Rows of CSV as cells: the part that all readers of CSV share.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace biss::capture {

/// A tab if there is one outside quotes, else a semicolon if there is one, else a comma.
char find_separator(std::string_view row);

/// `text` without blanks, carriage returns and (when not the separator) tabs around it.
std::string_view trim_cell(std::string_view text, char separator);

/// Takes the first cell off `row`; `last` when no separator followed it.
std::string_view take_cell(std::string_view& row, char separator, bool& last);

/// The cell without the quotes around it.
std::string_view without_quotes(std::string_view cell);

/// A quoted cell without its quotes, doubled ones made single.
std::string unquote(std::string_view cell);

/// All cells of a row, unquoted.
std::vector<std::string> cells_of(std::string_view row, char separator);

/// A row without data: it is blank, or it is a comment without a CR, because a CR may have ended
/// the comment.
bool is_csv_comment(std::string_view row);

/// The first place of `wanted`, or `end`.
const char* find_or_end(const char* from, const char* end, char wanted);

}  // namespace biss::capture
