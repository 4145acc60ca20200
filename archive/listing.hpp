// The files of an archive, in an order that depends on nothing but their paths.
#pragma once

#include <string>
#include <system_error>
#include <tl/expected.hpp>
#include <vector>

#include "archive/entry.hpp"

namespace biss::archive {

/// A file below one of the folders, or why something there is not read.
struct ListedFile {
  /// The given path without `./`, and the names below it. The bytes are unchanged.
  std::string path;
  FileStamp stamp;
  /// Empty: to be read. Else a cause of FileEntry, and a sentence.
  std::string cause;
  std::string message;
  /// As in FileEntry.
  std::uint64_t place = 0;
};

/// Lists all files at and below these paths and the paths of a list, sorted by path, each path
/// once.
///
/// A symbolic link is followed if it leads to a file or folder outside of all these paths and no
/// earlier link leads there; any other link has the cause `link` or `broken_link`. So nothing is
/// counted twice and no loop is entered. Files that this program writes (summaries, journals,
/// temporary files) are left out. Folders that cannot be read have the cause `folder_unreadable`;
/// pipes, sockets and devices `not_a_file`; files of the list that are gone `cannot_open`.
/// \return the files, or one line: which of `paths` does not exist
tl::expected<std::vector<ListedFile>, std::string> list_files(
    const std::vector<std::string>& paths, const std::vector<std::string>& listed = {});

/// The names in a folder, sorted; all of them unless there is a cause.
std::vector<std::string> names_in(const std::string& folder, std::error_code& cause);

/// Reads the stamp of a file; false if the file is gone.
bool read_stamp(const std::string& path, FileStamp& stamp);

}  // namespace biss::archive
