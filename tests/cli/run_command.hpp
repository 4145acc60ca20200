// Runs the command in a child process, and reads the tables that it writes. It includes the standard
// headers that most tests need.
#pragma once

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "capture/test_folder.hpp"
#include "wire/edge.hpp"

namespace biss::verbs {

using test::content_of;
using test::Folder;

/// The result of a run.
struct Outcome {
  int status = -1;  ///< exit status; 128 plus the signal's number if a signal ended it
  std::string out;
  std::string err;
  long peak_kib = 0;  ///< peak memory, by run_measured() only

  friend void PrintTo(const Outcome& outcome, std::ostream* stream) {
    *stream << "status " << outcome.status << ", " << outcome.err;
  }
};

std::vector<std::string> split(const std::string& text, char separator);

/// The words of a command line.
class Words : public std::vector<std::string> {
 public:
  Words() = default;
  Words(std::initializer_list<std::string> words) : vector(words) {}
  Words(std::vector<std::string> words) : vector(std::move(words)) {}
  /// Separated by spaces. Each `{}` is one of the values, which remains a word or a part of one.
  template <class... Values>
  Words(const char* line, const Values&... values) {
    constexpr char separator = '\x1F';  // occurs in no value
    std::string text = line;
    std::replace(text.begin(), text.end(), ' ', separator);
    for (std::string& word :
         split(fmt::vformat(text, fmt::make_format_args(values...)), separator)) {
      push_back(std::move(word));
    }
  }
};

inline Words operator+(Words words, const std::vector<std::string>& more) {
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

/// Runs `biss` with these arguments; its standard input is `input` (a file), or empty.
Outcome run(const std::vector<std::string>& arguments,
            const std::filesystem::path& input = "/dev/null");
template <class... Values>
Outcome run(const char* line, const Values&... values) {
  return run(Words(line, values...));
}

/// The outcome of a run that succeeds; otherwise the test ends with the error of the command.
Outcome ok(Outcome outcome);
inline Outcome run_ok(const std::vector<std::string>& arguments,
                      const std::filesystem::path& input = "/dev/null") {
  return ok(run(arguments, input));
}
template <class... Values>
Outcome run_ok(const char* line, const Values&... values) {
  return ok(run(line, values...));
}

/// Matches the outcome of a run with this status and an error that matches, or contains a text.
inline auto fails(int status, const testing::Matcher<std::string>& err) {
  return testing::AllOf(testing::Field("status", &Outcome::status, status),
                        testing::Field("err", &Outcome::err, err));
}
inline auto fails(int status, const char* part) { return fails(status, testing::HasSubstr(part)); }
inline auto fails(int status, const std::string& part) { return fails(status, part.c_str()); }
/// The same, without output and with an error of one line that contains a text.
inline auto refuses(int status, const std::string& part) {
  return testing::AllOf(fails(status, part), testing::Field("out", &Outcome::out, ""),
                        testing::Field("err", &Outcome::err, testing::MatchesRegex("[^\n]*\n")));
}

/// Starts a program. \return its process
pid_t start(std::vector<std::string> words, const std::string& input = "/dev/null",
            const std::string& out = "/dev/null", const std::string& err = "/dev/null");

/// Measures peak memory too. The peak of a process contains that of the one which started it, so a
/// small process stands between.
Outcome run_measured(const std::vector<std::string>& arguments);
/// With a limit as the options of `ulimit`.
Outcome run_limited(const std::string& limit, const std::vector<std::string>& arguments);
/// Sends a signal, such as `KILL`, after this time.
Outcome run_for(std::chrono::microseconds time, const std::string& signal,
                const std::vector<std::string>& arguments);

/// A test with a folder.
class InFolder : public testing::Test {
 protected:
  const Folder folder;
};

/// Rows of a CSV without quoted cells, by column name.
using Row = std::map<std::string, std::string>;
std::vector<Row> rows_of(std::string_view csv);
/// Expects of each row that it is ok and has the position of the truth file.
void expect_truth(const std::vector<Row>& rows, const std::vector<Row>& truth);

/// The edges of an event CSV of MA and SLO, which are the lines 0 and 1.
std::vector<wire::Edge> edges_of(const std::string& capture);
/// An event CSV of MA and SLO again, each row changed. \return the path of the file
std::string rewritten(const Folder& folder, const std::string& name, const std::string& capture,
                      const std::function<void(Row&)>& change);
/// One line of an event CSV in a file of its own, under this name. \return the path of the file
std::string one_line(const Folder& folder, const std::string& name, const std::string& line,
                     const std::string& capture, const std::string& column);
/// The rows of one event CSV of MA and SLO, and those of another one 200 µs later.
/// \return the path of the file
std::string joined(const Folder& folder, const std::string& first, const std::string& second);

}  // namespace biss::verbs
