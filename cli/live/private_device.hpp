// A command that sees a device of ours: it runs in its own mount namespace, in which a name of /dev
// is a FUSE file. No other program sees the file, and nothing of it remains.
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

namespace biss::cli {

struct StartedCommand {
  pid_t process = -1;
  /// An open descriptor of /dev/fuse; the file of the command is its root.
  int fuse = -1;
  /// One line why it could not be started; empty: it runs.
  std::string problem;
};

/// Starts `words` with `device` as a new regular file of FUSE. Without the right to mount it uses a
/// user namespace, in which the user is number 0.
/// \pre words is not empty
StartedCommand start_with_device(const std::vector<std::string>& words, const std::string& device);

}  // namespace biss::cli
