// Runs the command in a child process, and reads the tables that it writes.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace biss::verbs {

/// The result of a run.
struct Outcome {
  int status = -1;  ///< exit status; 128 plus the signal's number if a signal ended it
  std::string out;
  std::string err;
  long peak_kib = 0;  ///< peak memory, by run_measured() only
};

/// Runs `biss` with these arguments; its standard input is `input` (a file), or empty.
Outcome run(const std::vector<std::string>& arguments,
            const std::filesystem::path& input = "/dev/null");
/// Measures peak memory too. The peak of a process contains the peak of its parent, so a small
/// process starts the command.
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

std::string content_of(const std::string& path);

/// Rows of a CSV without quoted cells, by column name.
using Row = std::map<std::string, std::string>;
std::vector<Row> rows_of(std::string_view csv);

}  // namespace biss::verbs
