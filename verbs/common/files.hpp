// The files that a command line names, and which of them are the same file.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace biss::verbs {

class Host;

/// The use of a file by a verb. A state is read first and replaced later.
enum class FileUse : std::uint8_t { read, write, read_and_write };

struct NamedFile {
  std::string option;  ///< `-o`, `FILE`: as the error calls it
  std::string path;    ///< `-` for standard input or output
  FileUse use{};
};

/// Finds two names or links of the same file, one of them written; or standard input or output
/// named twice. A file that does not exist yet is identified by its folder and name. Terminals and
/// /dev/null may be named any number of times.
/// \return one line about them; empty if there are none
std::string file_conflict(const std::vector<NamedFile>& files, Host& host);

/// The path at the end of symbolic links, also if nothing is there. Empty if they form a circle.
std::string follow_links(std::string path);

/// The path names an open descriptor and not a file: /dev/stdout, /proc/self/fd/5.
bool names_a_descriptor(const std::string& path);

}  // namespace biss::verbs
