// The parts of `biss archive`: reading the files, and showing the sum.
#pragma once

#include <cstdint>
#include <string>

#include "archive/listing.hpp"
#include "archive/summary.hpp"
#include "lab/experiment.hpp"
#include "report/table.hpp"
#include "verbs/common/decoded_capture.hpp"

namespace biss::verbs {

/// How the sum is shown and kept.
struct SummaryOptions {
  /// The JSON; empty: none.
  std::string output;
  /// Rows of the table.
  std::uint64_t worst = 20;
  report::Format to = report::Format::table;
};

/// The captures to read, and the settings for reading them.
struct ArchiveTask {
  CaptureArguments capture;
  archive::Setup setup;
  lab::Shard shard;
  /// 0: one for each core.
  unsigned threads = 0;
  /// Empty: none.
  std::string journal;
};

/// Reads the files of the shard that the journal does not know. Throws a VerbError if the journal
/// fails; the failure of a file is in its entry.
/// \param files all files, as list_files() gives them
archive::Summary read_archive(const ArchiveTask& task,
                              const std::vector<archive::ListedFile>& files, Host& host);

/// Reads the file as `biss decode --each` would, or returns the cause of a failure. Prints nothing;
/// any thread.
/// \param arguments of all files; its `files` and `threads` are not used
/// \param threads for this file; the entry does not depend on them
archive::FileEntry read_listed_file(const archive::ListedFile& file,
                                    const CaptureArguments& arguments, unsigned threads,
                                    Host& host);

/// The same file will have the same entry as long as its stamp does not change: no cause that
/// depends on the machine and the moment.
bool is_lasting(const archive::FileEntry& entry);

/// Writes the JSON, prints the table of the worst files on standard output, unless the JSON goes
/// there, and the sums on stderr.
/// \return `data_failed` if shards are missing, or no file has a request cycle
ExitStatus show_summary(archive::Summary& summary, const SummaryOptions& options, Host& host);

}  // namespace biss::verbs
