#include "live/line_reader.hpp"

#include <sys/prctl.h>

#include <algorithm>
#include <cerrno>
#include <ctime>

namespace biss::live {
namespace {

std::int64_t clock_nanoseconds() {
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec * 1'000'000'000LL + now.tv_nsec;
}

// Returns early if a signal comes.
void sleep_until(std::int64_t nanoseconds) {
  const timespec until{nanoseconds / 1'000'000'000, nanoseconds % 1'000'000'000};
  ::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr);
}

}  // namespace

std::optional<Transfer> LineReader::next(
    const std::function<void(PortFault, Picoseconds)>& on_fault,
    const std::function<bool(Picoseconds)>& go_on) {
  if (!began_) {
    // Otherwise Linux adds up to 50 µs to each sleep.
    ::prctl(PR_SET_TIMERSLACK, 1UL, 0UL, 0UL, 0UL);
    began_ = clock_nanoseconds();
  }
  const auto now = [this] { return nanoseconds(clock_nanoseconds() - *began_); };
  for (;;) {
    Picoseconds time = now();
    while (time < due_) {
      if (!go_on(due_)) return std::nullopt;
      sleep_until(*began_ + std::min(due_.count / 1'000, time.count / 1'000 + 100'000'000));
      time = now();
    }
    if (!go_on(due_)) return std::nullopt;
    lateness_.add((time - due_).count / 1'000);
    ++counts_.requests;
    const auto fault = port_.transfer(buffer_);
    // Less a nanosecond, for the resolution of the clock.
    const Picoseconds next = std::max(now() + rest_, time + least_ - nanoseconds(1));
    const std::int64_t missed = std::max<std::int64_t>((next - due_).count - 1, 0) / cycle_.count;
    counts_.late += fault ? 0 : static_cast<std::uint64_t>(missed);
    due_ = due_ + (1 + missed) * cycle_;
    if (!fault) {
      faults_in_a_row_ = 0;
      return Transfer{time, buffer_};
    }
    ++counts_.faults[static_cast<std::size_t>(*fault)];
    counts_.last_error = port_.error();
    on_fault(*fault, time);
    if (*fault != PortFault::gone && ++faults_in_a_row_ < 10) continue;
    due_ = due_ + std::max<std::int64_t>(pause_after_faults.count / cycle_.count, 1) * cycle_;
    if (*fault != PortFault::gone) continue;
    sleep_until(*began_ + due_.count / 1'000);
    static_cast<void>(port_.reopen());
  }
}

}  // namespace biss::live
