// The files that a command line names: which of them are one and the same.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace biss::verbs {

class Host;

/// What a verb does with a file. A state is read first and replaced later.
enum class FileUse : std::uint8_t { read, write, read_and_write };

struct NamedFile {
  std::string option;  ///< `-o`, `FILE`: as the error calls it
  std::string path;    ///< `-` for standard input or output
  FileUse use{};
};

/// Finds two of the files that are the same, by whatever name and link, one of them written; or
/// standard input or output named twice. A file that does not exist yet is known by its folder and
/// name. Terminals and /dev/null may be named any number of times.
/// \return one line that says so; empty if there are none
std::string file_conflict(const std::vector<NamedFile>& files, Host& host);

/// The path at the end of symbolic links, also if nothing is there. Empty if they form a circle.
std::string follow_links(std::string path);

/// The path names an open descriptor and not a file: /dev/stdout, /proc/self/fd/5.
bool names_a_descriptor(const std::string& path);

}  // namespace biss::verbs
