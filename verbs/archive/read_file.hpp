// One file of an archive, read to the end.
#pragma once

#include "archive/listing.hpp"
#include "verbs/common/decoded_capture.hpp"

namespace biss::verbs {

/// Reads the file as `biss decode --each` would, or returns the cause of a failure. Prints nothing;
/// any thread.
/// \param arguments of all files; its `files` and `threads` are not used
/// \param threads for this file; the entry does not depend on them
archive::FileEntry read_listed_file(const archive::ListedFile& file,
                                    const CaptureArguments& arguments, unsigned threads,
                                    Host& host);

/// The same file will have the same entry as long as its stamp does not change: its cause, if any,
/// does not depend on the machine or the moment.
bool is_lasting(const archive::FileEntry& entry);

}  // namespace biss::verbs
