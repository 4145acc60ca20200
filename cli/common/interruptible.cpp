#include "cli/common/interruptible.hpp"

#include <utility>

namespace biss::cli {
namespace {

constexpr auto ask_every = std::chrono::milliseconds(100);

thread_local Interruptible* interruptible = nullptr;

}  // namespace

Interruptible::Interruptible(std::function<bool()> go_on)
    : go_on_(std::move(go_on)),
      next_(std::chrono::steady_clock::now() + ask_every),
      outer_(std::exchange(interruptible, this)) {}

Interruptible::~Interruptible() { interruptible = outer_; }

void Interruptible::check() {
  if (interruptible == nullptr) return;
  const auto now = std::chrono::steady_clock::now();
  if (now < interruptible->next_) return;
  interruptible->next_ = now + ask_every;
  if (!interruptible->go_on_()) throw Interrupted();
}

}  // namespace biss::cli
