#include "verbs/safety/interruption.hpp"

#include <array>
#include <atomic>
#include <csignal>
#include <cstddef>

namespace biss::verbs {
namespace {

constexpr std::array<int, 3> numbers{SIGINT, SIGTERM, SIGHUP};
using Handler = void (*)(int);

std::array<Handler, numbers.size()> previous{};
std::atomic<int> noted{0};
static_assert(std::atomic<int>::is_always_lock_free);

void restore() {
  for (std::size_t n = 0; n < numbers.size(); ++n) std::signal(numbers[n], previous[n]);
}

extern "C" void note_signal(int number) {
  noted = number;
  restore();
}

}  // namespace

Interruption::Interruption() {
  noted = 0;
  for (std::size_t n = 0; n < numbers.size(); ++n) {
    previous[n] = std::signal(numbers[n], SIG_IGN);
  }
  for (std::size_t n = 0; n < numbers.size(); ++n) {
    if (previous[n] != SIG_IGN) std::signal(numbers[n], note_signal);
  }
}

Interruption::~Interruption() { restore(); }

bool Interruption::requested() const { return noted != 0; }

void Interruption::end_process() const { std::raise(noted); }

}  // namespace biss::verbs
