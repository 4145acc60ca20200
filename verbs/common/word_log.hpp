// A log of frames as words, one a line: `decode --words`.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "decode/cycle_reader.hpp"
#include "verbs/common/word.hpp"

namespace biss::verbs {

struct LoggedWord {
  std::optional<Picoseconds> time;
  Word word;
};

struct WordArguments {
  /// `-` for standard input; empty: none.
  std::string file;
  /// Gives timed words of a live line, called `file`, one after the other, until it gives none.
  std::function<std::optional<LoggedWord>()> next;
  WordReading reading;
  /// The option that needs a time on every line; empty: none.
  std::string needs_times;
};

/// Reads the words; all lines have the same number of digits, and either all or none have a number
/// before the word.
/// \return the words, or one line: the file, the line, the remedy
tl::expected<std::vector<LoggedWord>, std::string> read_word_log(const WordArguments& arguments);

/// The cycle of a word; its time is 0 if the word has none.
decode::Cycle cycle_of(const LoggedWord& logged, const WordReading& reading,
                       const decode::CycleReader& reader, const std::optional<FrameFormat>& format);

}  // namespace biss::verbs
