// A file that gets its name only when it is complete.
#pragma once

#include <string>

namespace biss::verbs {

/// A new file that replaces its target as a whole: until take_name() the target is untouched.
///
/// If the file system can (O_TMPFILE), the file has no name until then, and nothing is left even
/// when the process is killed. Otherwise it is next to the target as `.biss-PID-N.tmp`, and
/// discard(), the destructor or a signal that ends the process removes it.
class TemporaryFile {
 public:
  TemporaryFile() = default;
  ~TemporaryFile() { discard(); }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;

  /// Creates the file in the target's folder; its mode is as for any created file (umask).
  /// \return a descriptor open for reading and writing, owned by this object; -1 and errno on failure
  int create(const std::string& target);
  /// Gives the file the target's name, in place of any file with this name, and closes it. False
  /// and errno on failure; then call discard().
  bool take_name();
  /// Closes and removes the file, if there is one.
  void discard();

  bool exists() const { return descriptor_ >= 0; }

 private:
  std::string target_;
  std::string name_;  // empty while the file has none
  int descriptor_ = -1;
};

/// Ignores SIGPIPE and SIGXFSZ, so that the write fails instead. SIGINT, SIGTERM and SIGHUP remove
/// temporary files before they end the process; one that the parent ignored stays ignored.
void install_signal_handling();

}  // namespace biss::verbs
