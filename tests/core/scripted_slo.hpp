// A device that answers from a script through a delay line, for the tests of the master.
#pragma once

#include "biss/base/units.hpp"
#include "biss/timing/step.hpp"
#include "tests/core/frames.hpp"
#include "tests/core/test.hpp"

namespace biss::test {

/// Levels in transit, at most `Capacity`. Each level comes out `delay` after it was put in, in
/// order.
template <std::size_t Capacity>
class BasicDelayLine {
 public:
  constexpr explicit BasicDelayLine(Picoseconds delay) : delay_(delay) {}

  void put(Picoseconds now, bool level) { put_at(now + delay_, level); }
  /// \pre not before the levels in transit
  void put_at(Picoseconds time, bool level) {
    if (level == last_) return;
    BISS_ASSERT(size_ != ring_.size());
    last_ = level;
    ring_[(first_ + size_++) % ring_.size()] = {time, level};
  }
  constexpr Picoseconds next() const { return size_ == 0 ? never : ring_[first_].time; }
  /// Removes the levels that have arrived. Returns the level at the end.
  constexpr bool level(Picoseconds now) {
    while (size_ != 0 && ring_[first_].time <= now) {
      level_ = ring_[first_].level;
      first_ = (first_ + 1) % ring_.size();
      --size_;
    }
    return level_;
  }

 private:
  struct Change {
    Picoseconds time{};
    bool level = true;
  };
  Picoseconds delay_;
  std::array<Change, Capacity> ring_{};
  std::size_t first_ = 0;
  std::size_t size_ = 0;
  bool last_ = true;
  bool level_ = true;
};

using DelayLine = BasicDelayLine<128>;

/// Puts bit k of the script on SLO at rising edge k + 1 of MA, 0 after the last one, and 1 when MA
/// was idle for `timeout`.
struct ScriptedSlo {
  LineBits script;
  Picoseconds delay{};
  Picoseconds timeout = microseconds(20);
  /// The peak jitter: each change is delayed by a different time up to this one.
  Picoseconds jitter{};

  DelayLine line{delay};
  std::size_t rises = 0;
  bool ma = true;
  /// MA when the timeout expired: 0 is CDM 1.
  bool ma_at_timeout = true;
  Picoseconds expires = never;
  Random random{0x510};

  Picoseconds next() const { return std::min(expires, line.next()); }

  void step(Picoseconds now, bool new_ma) {
    if (expires <= now) {
      expires = never;
      rises = 0;
      ma_at_timeout = ma;
      send(now, true);
    }
    if (new_ma == ma) return;
    ma = new_ma;
    // The edge of MA that ends CDM is not a clock.
    if (rises == 0 && ma && expires == never) return;
    expires = now + timeout;
    if (!ma) return;
    send(now, rises < script.size_bits() && script.view()[rises]);
    ++rises;
  }

 private:
  void send(Picoseconds now, bool level) {
    const auto late =
        static_cast<std::int64_t>(random.below(static_cast<std::uint32_t>(jitter.count) + 1U));
    line.put(now + picoseconds(late), level);
  }
};

/// MA in one request.
struct Seen {
  std::uint32_t rises = 0;
  std::uint32_t falls = 0;
  Picoseconds last_rise{};
  Picoseconds last_edge{};
  Picoseconds shortest = never;
  Picoseconds end{};
};

/// Runs a request from `now` on. Each deadline is served with a delay of up to `late`.
template <class AnyMaster, class Device>
Seen run(AnyMaster& master, Device& device, Picoseconds now, bool cdm = false,
         Picoseconds late = {}) {
  Random random(0x1A7E);
  Seen seen;
  bool ma = true;
  Picoseconds due = now;
  StepOutput out;
  bool begun = false;
  for (std::uint32_t steps = 0; steps < 100'000 && !(begun && master.done()); ++steps) {
    now = std::max(now, std::min(due, device.next()));
    device.step(now, ma);
    const bool slo = device.line.level(now);
    out = begun ? master.step(now, slo) : master.begin(now, slo, cdm);
    begun = true;
    const auto limit = static_cast<std::uint32_t>(late.count) + 1U;
    due = out.has_deadline() ? out.deadline + picoseconds(random.below(limit)) : never;
    if (out.level != ma) {
      if (seen.falls + seen.rises != 0) {
        seen.shortest = std::min(seen.shortest, now - seen.last_edge);
      }
      ma = out.level;
      ++(ma ? seen.rises : seen.falls);
      seen.last_edge = now;
      if (ma) seen.last_rise = now;
    }
    device.step(now, ma);
  }
  BISS_EXPECT(master.done());
  BISS_EXPECT(ma);
  seen.end = now;
  return seen;
}

}  // namespace biss::test
