#include "verbs/common/word_log.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "dump/text.hpp"
#include "verbs/common/text_file.hpp"

namespace biss::verbs {
namespace {

struct Line {
  std::size_t number = 0;
  std::optional<Picoseconds> time{};
  std::string text{};
  // A first number in the text that may not belong to the word, and the text after it.
  std::string first{};
  std::string rest{};

  const std::string& word(bool with_number) const {
    return with_number && !rest.empty() ? rest : text;
  }
};

Line line_of(std::size_t number, std::string_view text) {
  constexpr std::string_view separators = " \t,;:";
  const std::size_t end = std::min(text.find_first_of(separators), text.size());
  const std::size_t next = std::min(text.find_first_not_of(separators, end), text.size());
  const std::string_view front = text.substr(0, end);
  const std::string_view between = text.substr(end, next - end);
  const std::string rest(text.substr(next));
  Line line{number, {}, std::string(text), {}, {}};
  const bool is_number = front.find_first_not_of("0123456789.") == std::string_view::npos;
  const auto time = parse_time(front);
  if (rest.empty()) return line;
  if (time.ok() && !is_number) {
    line.time = *time;
    line.text = rest;
  } else if (is_number && (front.find('.') != std::string_view::npos || between.starts_with(';') ||
                           (between.starts_with(':') && between.size() > 1))) {
    line.text = rest;
  } else if (is_number) {
    line.first = front;
    line.rest = rest;
  }
  return line;
}

// Whether the first numbers rise from line to line: numbers of lines do, first bytes of words do
// not.
bool first_numbers_rise(const std::vector<Line>& lines) {
  std::optional<std::uint64_t> last;
  for (const Line& line : lines) {
    const auto number = parse_count(line.first);
    if (!number.ok() || (last && *number <= *last)) return false;
    last = *number;
  }
  return lines.size() > 1;
}

}  // namespace

tl::expected<std::vector<LoggedWord>, std::string> read_word_log(const WordArguments& arguments) {
  const std::string name = arguments.file == "-" ? "standard input" : arguments.file;
  const auto wrong = [&name](const Line& line, std::string_view what) {
    return tl::unexpected(fmt::format("{}:{}: {}", name, line.number, what));
  };
  const auto text = read_text_file(arguments.file == "-" ? "/dev/stdin" : arguments.file);
  if (!text) return tl::unexpected(fmt::format("{}: {}", name, text.error()));
  std::vector<Line> lines;
  std::string_view left = *text;
  if (left.starts_with("\xEF\xBB\xBF")) left.remove_prefix(3);
  for (std::size_t number = 1; !left.empty(); ++number) {
    const std::size_t end = std::min(left.find('\n'), left.size());
    const std::string_view row = dump::without_comment(left.substr(0, end));
    left.remove_prefix(std::min(end + 1, left.size()));
    if (row.empty()) continue;
    lines.push_back(line_of(number, row));
    const auto is_control = [](char c) { return static_cast<unsigned char>(c) < ' ' && c != '\t'; };
    if (std::any_of(row.begin(), row.end(), is_control)) {
      return wrong(lines.back(), "not plain text (compressed, UTF-16?); save the log as text");
    }
  }
  if (lines.empty()) return tl::unexpected(name + ": has no word; write one word a line");
  std::size_t farthest = 0;
  std::vector<std::vector<Word>> possible;
  for (const bool with_number : {false, true}) {
    for (const Digits digits : digits_in_order(lines.front().word(true))) {
      if (!arguments.reading.digits.empty() && arguments.reading.digits != digits) continue;
      std::vector<Word> words;
      for (const Line& line : lines) {
        auto word = parse_word(line.word(with_number), digits);
        if (!word) break;
        words.push_back(std::move(*word));
      }
      farthest = std::max(farthest, words.size());
      if (words.size() < lines.size()) continue;
      if (possible.size() == 1 && with_number && words != possible.front() &&
          first_numbers_rise(lines)) {
        return wrong(
            lines.front(),
            fmt::format("'{0}' is a number in front of the word or a part of it; write '{0}: ' "
                        "if it is a number, else join it to the rest",
                        lines.front().first));
      }
      if (possible.empty()) possible.push_back(std::move(words));
      break;
    }
  }
  if (possible.empty()) {
    return wrong(lines[farthest],
                 fmt::format("'{}' is not a word{}; correct the line, or begin it with #",
                             lines[farthest].text.substr(0, 40),
                             farthest == 0 ? "" : " in the digits of the others"));
  }
  std::vector<LoggedWord> log;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (!lines[i].time && !arguments.needs_times.empty()) {
      return wrong(lines[i],
                   fmt::format("no time such as 12.5us in front of the word; {} needs one",
                               arguments.needs_times));
    }
    if (i > 0 && lines[i].time.has_value() != lines[0].time.has_value()) {
      return wrong(lines[i], lines[0].time ? "no time in front of the word; is the line cut off?"
                                           : "a time in front of the word, unlike the lines above");
    }
    if (i > 0 && lines[i].time && lines[i - 1].time && *lines[i].time < *lines[i - 1].time) {
      return wrong(lines[i], "the time is earlier than in the line above; sort the lines");
    }
    log.push_back({lines[i].time, std::move(possible.front()[i])});
  }
  return log;
}

decode::Cycle cycle_of(const LoggedWord& logged, const WordReading& reading,
                       const decode::CycleReader& reader,
                       const std::optional<FrameFormat>& format) {
  const Word line = arrange(logged.word, reading, format.value_or(FrameFormat{}));
  decode::Cycle cycle = reader.read_bits(line.view());
  cycle.time = logged.time.value_or(Picoseconds{});
  if (!reading.payload || !format) return cycle;
  // START, CDS and STOP were not received.
  const decode::RawBits whole = cycle.raw;
  cycle.raw.clear();
  cycle.raw.append(whole.view().from(2).first(format->payload_bits()));
  return cycle;
}

}  // namespace biss::verbs
