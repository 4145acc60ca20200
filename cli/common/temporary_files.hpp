// Files that must not outlive the process unless they were renamed.
#pragma once

#include <string>

namespace biss::cli {

/// Creates a file that nobody had before, mode by umask, and remembers it for the signals. Returns
/// a descriptor open for writing, or -1 and errno (EMFILE too when many exist at once).
int create_temporary(const std::string& path);

/// Renames it and forgets it. False and errno when that failed; it is still remembered then.
bool rename_temporary(const std::string& path, const std::string& target);

/// Removes and forgets it.
void remove_temporary(const std::string& path);

/// From now on SIGPIPE and SIGXFSZ are ignored, so that the write fails instead, and SIGINT,
/// SIGTERM and SIGHUP remove what is remembered before they end the process as they always do. A
/// signal that the parent ignored stays ignored.
void install_signal_handling();

}  // namespace biss::cli
