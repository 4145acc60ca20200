// The user's signal to end a long run: the run saves its results before the process ends.
#pragma once

namespace biss::verbs {

/// While it exists, the first SIGINT, SIGTERM or SIGHUP is only noted. A second one ends the
/// process as it does without this. A signal that the parent process ignores stays ignored.
/// \pre at most one exists at a time
class Interruption {
 public:
  Interruption();
  ~Interruption();
  Interruption(const Interruption&) = delete;
  Interruption& operator=(const Interruption&) = delete;

  bool requested() const;
  /// Ends the process by the signal that was noted. \pre requested()
  void end_process() const;
};

}  // namespace biss::verbs
