// Runs that a program ends early, where it runs a verb in its own process.
#pragma once

#include <chrono>
#include <functional>

namespace biss::cli {

/// Thrown by Interruptible::check(). No std::exception: it must not look like a failure of one file.
struct Interrupted {};

/// While it exists, check() asks on this thread whether the run goes on. Progress::due() calls it, so
/// that every long run asks.
class Interruptible {
 public:
  /// \param go_on called ten times a second at most; after false it must stay false
  explicit Interruptible(std::function<bool()> go_on);
  ~Interruptible();
  Interruptible(const Interruptible&) = delete;
  Interruptible& operator=(const Interruptible&) = delete;

  /// Throws Interrupted where the run ends. Does nothing on a thread that has no Interruptible.
  static void check();

 private:
  std::function<bool()> go_on_;
  std::chrono::steady_clock::time_point next_;
  Interruptible* outer_;
};

}  // namespace biss::cli
