// An archive to read: simulated captures of several encoders in several file formats, some of them
// damaged, and some files that are not captures.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "tests/cli/run_command.hpp"

namespace biss::verbs {

/// Writes the files below a temporary folder; the same ones for the same number.
class ArchiveFolder {
 public:
  explicit ArchiveFolder(std::size_t files);

  std::string path() const { return folder_.path("captures"); }
  /// A path next to the captures.
  std::string beside(const std::string& name) const { return folder_.path(name); }

 private:
  Folder folder_;
};

/// Kills and repeats the command, and compares the summary with the summary of an uninterrupted
/// run.
/// \return how often the process was killed before its end
int kill_and_resume(const ArchiveFolder& archive, int kills, unsigned seed);

/// Every file of the archive in one summary, by `threads` threads.
std::string summary_of(const ArchiveFolder& archive, const std::string& threads);

/// The summary of this many shards, merged.
std::string merged_summary_of(const ArchiveFolder& archive, unsigned shards);

}  // namespace biss::verbs
