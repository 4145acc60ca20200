// Ctrl-C ends a run that goes on for ever, and its results are written.
#pragma once

#include <array>
#include <csignal>
#include <utility>

namespace biss::cli {

/// The first SIGINT, SIGTERM or SIGHUP asks the run to end. The second one does what it did before.
class EndBySignal {
 public:
  EndBySignal() {
    wanted_ = 0;
    struct sigaction action {};
    action.sa_handler = end;
    for (const auto& [number, before] : signals_) {
      ::sigaction(number, nullptr, before);
      if (before->sa_handler != SIG_IGN) ::sigaction(number, &action, nullptr);
    }
  }
  ~EndBySignal() {
    for (const auto& [number, before] : signals_) ::sigaction(number, before, nullptr);
  }
  EndBySignal(const EndBySignal&) = delete;
  EndBySignal& operator=(const EndBySignal&) = delete;

  static bool wanted() { return wanted_ != 0; }
  /// Called before the second signal; a signal handler may call it.
  static inline void (*before_end)() = [] {};

 private:
  static void end(int number) {
    if (wanted_ != 0) {
      before_end();
      for (const auto& [each, before] : signals_) ::sigaction(each, before, nullptr);
      ::raise(number);
    }
    wanted_ = 1;
  }

  static inline volatile std::sig_atomic_t wanted_ = 0;
  static inline std::array<struct sigaction, 3> before_{};
  static constexpr std::array<std::pair<int, struct sigaction*>, 3> signals_{
      {{SIGINT, &before_[0]}, {SIGTERM, &before_[1]}, {SIGHUP, &before_[2]}}};
};

}  // namespace biss::cli
