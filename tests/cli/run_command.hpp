// Runs the command in a child process, and reads the tables that it writes. It includes the standard
// headers that most tests need.
#pragma once

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace biss::verbs {

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

/// Measures peak memory too. The peak of a process contains that of the one which started it, so a
/// small process stands between.
Outcome run_measured(const std::vector<std::string>& arguments);

/// A temporary folder for each test, removed by the destructor.
class Folder {
 public:
  Folder();
  ~Folder();
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  /// Writes a file. \return its path
  std::string file(const std::string& name, std::string_view content) const;
  std::size_t files() const;

 private:
  std::filesystem::path folder_;
};

/// A test with a folder.
class InFolder : public testing::Test {
 protected:
  const Folder folder;
};

std::string content_of(const std::string& path);

/// Rows of a CSV without quoted cells, by column name.
using Row = std::map<std::string, std::string>;
std::vector<Row> rows_of(std::string_view csv);

}  // namespace biss::verbs
