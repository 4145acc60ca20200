// Every encoder of the catalogue: after a request that fails at any edge, the master makes no other
// one before the full request cycle has ended, whatever SLO does.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "biss/catalogue/catalogue.hpp"
#include "biss/master/request.hpp"
#include "tests/common/long_run.hpp"
#include "tests/exhaustive/scale.hpp"

namespace timing_test::reset_test {

using biss::CatalogueEntry;
using biss::Picoseconds;
using biss::RequestKind;
using Master = biss::RequestCycle<biss::FrameCodec<>>;

/// SLO after rising edge k of MA: high up to edge `fall`, low up to edge `rise`, a 1 there, `tail`
/// after it. While MA rests, it changes every 700 ns.
struct Slo {
  std::uint32_t fall = 0;
  std::uint32_t rise = 0;
  bool tail = false;

  bool after(std::uint32_t edge) const {
    return edge < fall || edge == rise || (edge > rise && tail);
  }
};

struct Outcome {
  std::uint32_t clocks = 0;
  Picoseconds next{};  ///< the earliest time of the next request
  bool failed = false;
  bool stayed_high = true;
};

Outcome outcome_of(const CatalogueEntry& entry, Picoseconds period, const Slo& slo,
                   RequestKind kind, Picoseconds begin) {
  constexpr Picoseconds flicker = biss::nanoseconds(700);
  biss::MasterSetup setup{.period = period, .timing = entry.timing};
  setup.line_delay_max = biss::microseconds(2);
  Master master(biss::FrameCodec<>(entry.frame_format()), setup);
  Outcome seen;
  biss::StepOutput out = master.begin(begin, true, false, kind);
  bool ma = out.level;
  bool level = true;
  Picoseconds now = begin;
  Picoseconds next_flicker = biss::never;
  while (!master.done()) {
    now = std::min(out.deadline, next_flicker);
    const bool changes = now == next_flicker;
    if (changes) next_flicker = now + flicker;
    if (changes) level = !level;
    out = master.step(now, level);
    if (out.level == ma) continue;
    ma = out.level;
    next_flicker = biss::never;
    if (!ma) continue;
    level = slo.after(++seen.clocks);
    next_flicker = now + 2 * period;
    out = master.step(now, level);
  }
  seen.stayed_high = ma;
  seen.failed = kind != RequestKind::frame || !master.reading().frame.ok();
  // SLO is high when the master looks: only its own rule keeps it from asking.
  seen.next = std::max(now, master.earliest());
  if (seen.next > now) {
    EXPECT_TRUE(master.begin(seen.next - biss::picoseconds(1), true).level);
    EXPECT_EQ(master.reading().refusal, biss::Refusal::too_early);
  }
  return seen;
}

std::uint32_t longest_ack(const biss::DeviceTiming& timing, Picoseconds period) {
  if (timing.ack_clocks != 0) return timing.ack_clocks;
  const std::int64_t clocks = (timing.ack_max.count + period.count - 1) / period.count;
  return static_cast<std::uint32_t>(std::max<std::int64_t>(clocks, 1));
}

/// LAT, the longest ACK, START, CDS, the channels, STOP, and the timeout.
Picoseconds full_cycle(const CatalogueEntry& entry, Picoseconds period) {
  const biss::DeviceTiming& timing = entry.timing;
  const std::uint32_t clocks =
      1U + longest_ack(timing, period) + 2U + entry.frame_format().payload_bits() + 1U;
  const Picoseconds last_rise = std::int64_t{clocks} * period - period / 2;
  const Picoseconds time = timing.timeout.time;
  switch (timing.timeout.rule) {
    case biss::TimeoutRule::cycle:
      return std::max(time, last_rise + period * 3 / 2);
    case biss::TimeoutRule::fixed:
      return last_rise + time;
    default:
      return last_rise + period * 3 / 2 + time;
  }
}

const bool all = biss::test::long_run();

std::vector<std::int64_t> clocks_khz(const CatalogueEntry& entry) {
  std::vector<std::int64_t> clocks{250, 500, 2'000, 10'000};
  if (all) {
    for (std::int64_t clock = 260; clock < 10'000; clock += clock / 8) clocks.push_back(clock);
  }
  std::erase_if(clocks, [&](std::int64_t khz) {
    return khz * 1000 < entry.timing.clock_min.count || khz * 1000 > entry.timing.clock_max.count;
  });
  return clocks;
}

/// The encoders, one of each timing and length of frame: the master knows no more of them.
std::vector<const CatalogueEntry*> encoders() {
  std::vector<const CatalogueEntry*> kinds;
  for (const CatalogueEntry& entry : biss::catalogue) {
    const bool known = std::any_of(kinds.begin(), kinds.end(), [&](const CatalogueEntry* kind) {
      return kind->timing == entry.timing &&
             kind->frame_format().payload_bits() == entry.frame_format().payload_bits();
    });
    if (!known) kinds.push_back(&entry);
  }
  return kinds;
}

/// One of so many edges of a long ACK is tried.
std::uint32_t step_of(std::uint32_t ack) {
  return all ? 1 : std::max(1U, ack / (exhaustive::slow_build ? 2U : 10U));
}

std::string text_of(const CatalogueEntry& entry, std::int64_t khz, const Slo& slo,
                    const Outcome& seen) {
  return std::string(entry.name) + " at " + std::to_string(khz) + " kHz, SLO falls at edge " +
         std::to_string(slo.fall) + ", rises at " + std::to_string(slo.rise) + ", then " +
         std::to_string(slo.tail) + ", " + std::to_string(seen.clocks) + " clocks, next after " +
         std::to_string(seen.next.count / 1000) + " ns";
}

// The edges at which the requests of this kind end.
std::set<std::uint32_t> expect_rests(const CatalogueEntry& entry, std::int64_t khz) {
  const Picoseconds period = biss::picoseconds(1'000'000'000 / khz);
  const Picoseconds full = full_cycle(entry, period);
  const std::uint32_t ack = longest_ack(entry.timing, period);
  const std::uint32_t last = ack + 4 + entry.frame_format().payload_bits();
  std::set<std::uint32_t> clocks;
  for (std::uint32_t fall = 1; fall <= 3; ++fall) {
    for (std::uint32_t rise = fall + 1; rise <= last; rise += rise < ack ? step_of(ack) : 1U) {
      const Slo slo{fall, rise, (rise + fall) % 2 == 0};
      const Outcome seen = outcome_of(entry, period, slo, RequestKind::frame, {});
      clocks.insert(seen.clocks);
      if (!seen.failed) continue;
      EXPECT_GE(seen.next, full) << text_of(entry, khz, slo, seen);
      EXPECT_TRUE(seen.stayed_high);
    }
  }
  return clocks;
}

TEST(Reset, RequestThatFailsAtAnyEdge_IsFollowedByNoneBeforeTheFullCycleEnds) {
  for (const CatalogueEntry* entry : encoders()) {
    for (const std::int64_t khz : clocks_khz(*entry)) {
      const auto clocks = expect_rests(*entry, khz);
      const std::uint32_t ack = longest_ack(entry->timing, biss::picoseconds(1'000'000'000 / khz));
      // It stops at the second edge, in ACK, and after each number of clocks that START permits.
      EXPECT_GE(clocks.size(), ack / step_of(ack)) << entry->name << " at " << khz;
      EXPECT_TRUE(clocks.contains(2)) << entry->name << " at " << khz;
    }
  }
}

TEST(Reset, ShortRequestOfADeviceWithAFixedCycle_IsFollowedByNoneBeforeTheFullCycleEnds) {
  for (const CatalogueEntry* entry : encoders()) {
    if (entry->timing.timeout.rule != biss::TimeoutRule::cycle) continue;
    for (const std::int64_t khz : clocks_khz(*entry)) {
      const Picoseconds period = biss::picoseconds(1'000'000'000 / khz);
      for (const RequestKind kind : {RequestKind::reduced, RequestKind::control_only}) {
        const Slo slo{2, longest_ack(entry->timing, period) + 1, false};
        const Outcome seen = outcome_of(*entry, period, slo, kind, biss::microseconds(3));
        ASSERT_GE(seen.next, biss::microseconds(3) + full_cycle(*entry, period))
            << text_of(*entry, khz, slo, seen);
      }
    }
  }
}

TEST(Reset, ResoluteOf26BitsAt250Khz_RestsForTheWholeCycleAndNotMuchLonger) {
  const CatalogueEntry* entry = biss::find_encoder("resolute-26");
  ASSERT_NE(entry, nullptr);
  // ACK of four clocks at most, 42 clocks with STOP, and 1.5 periods.
  const Outcome slow =
      outcome_of(*entry, biss::microseconds(4), {2, 99, false}, RequestKind::frame, {});
  EXPECT_GE(slow.next, biss::microseconds(174));
  EXPECT_LE(slow.next, biss::microseconds(182));
  const Outcome fast =
      outcome_of(*entry, biss::nanoseconds(100), {2, 999, false}, RequestKind::frame, {});
  EXPECT_GE(fast.next, biss::nanoseconds(31'250));
  EXPECT_LE(fast.next, biss::nanoseconds(31'600));
}

}  // namespace timing_test::reset_test
