// The states of the safety monitor: every event in every state, against the table that the
// documents show.
#include "biss/safety/states.hpp"

#include "biss/safety/monitor.hpp"
#include "tests/core/safety_bench.hpp"
#include "tests/core/test.hpp"

namespace biss::safety_states_test {

using enum SafetyVerdict;
using test::SafetyBench;

// Brings the monitor to that state. \pre it is untested, or has passed its self test
void bring_to(SafetyState state, SafetyBench& bench) {
  switch (state) {
    case SafetyState::untested:
      break;
    case SafetyState::starting:
      bench.good();
      break;
    case SafetyState::safe:
      bench.until_safe();
      break;
    case SafetyState::latched: {
      // Two faults: the second one is beyond the budget.
      bench.until_safe();
      bench.silence();
      bench.silence();
      break;
    }
    case SafetyState::failed:
    default: {
      const SafetyFinding good{.cause = safe};
      bench.monitor.step(OneClock{bench.now}, good, SafetyFinding{});
      break;
    }
  }
}

// Causes the event. False where it cannot happen in that state.
bool cause(SafetyEvent event, SafetyBench& bench, SafetyState state) {
  switch (event) {
    case SafetyEvent::self_test_passed:
      BISS_EXPECT_EQ(bench.monitor.self_test(bench.plan().fingerprint()),
                     state != SafetyState::failed);
      return true;
    case SafetyEvent::self_test_failed:
      return !bench.monitor.self_test(SafetyFingerprint());
    case SafetyEvent::good_frame:
      // In `starting` the second of three.
      bench.good();
      return true;
    case SafetyEvent::last_start_frame:
      if (state == SafetyState::starting) bench.good();
      bench.good();
      return true;
    case SafetyEvent::tolerated_fault:
      if (state == SafetyState::starting) return false;
      bench.silence();
      return true;
    case SafetyEvent::fault:
    case SafetyEvent::unlatched_fault:
      // A fault that no budget tolerates.
      bench.now += SafetyBench::cycle;
      bench.good();
      return true;
    case SafetyEvent::receiver_fault: {
      const SafetyFinding good{.cause = safe};
      bench.now += SafetyBench::cycle;
      bench.monitor.step(OneClock{bench.now}, good, SafetyFinding{});
      return state != SafetyState::untested && state != SafetyState::latched;
    }
    case SafetyEvent::acknowledged:
      bench.acknowledge();
      return true;
    case SafetyEvent::encoder_restarted:
      bench.monitor.encoder_restarted();
      return true;
  }
  return false;
}

BISS_TEST(SafetyStates, EveryEventInEveryState_LeadsWhereTheTableSays) {
  unsigned seen = 0;
  for (std::size_t row = 0; row < safety_state_count; ++row) {
    for (std::size_t column = 0; column < safety_event_count; ++column) {
      const SafetyState state = state_of(row);
      const auto event = static_cast<SafetyEvent>(column);
      const auto change = [&](SafetySetup& setup) {
        setup.latch = event != SafetyEvent::unlatched_fault || state == SafetyState::latched;
        setup.budget = {.faults = 1, .window = SafetyBench::cycle * 2};
      };
      SafetyBench bench(change, state != SafetyState::untested);
      bring_to(state, bench);
      BISS_ASSERT(bench.monitor.state() == state);
      if (!cause(event, bench, state)) continue;
      BISS_EXPECT_EQ(bench.monitor.state(), next_state(state, event)) << row << " " << column;
      ++seen;
    }
  }
  // All but tolerated faults while starting, and faults of the receiver in monitors that judge
  // nothing.
  BISS_EXPECT_EQ(seen, safety_state_count * safety_event_count - 3);
}

// The table, listed explicitly: a row for each state, a letter for each event. The letters: untested,
// (i) starting, safe, latched, failed.
BISS_TEST(SafetyStates, EveryTransition_IsTheListedOne) {
  constexpr std::string_view letters = "uislf";
  constexpr std::string_view rows[] = {"iuuuuuufuu", "ifisiiifii", "sfssslifsi", "lflllllfil",
                                       "ffffffffff"};
  for (std::size_t row = 0; row < safety_state_count; ++row) {
    for (std::size_t column = 0; column < safety_event_count; ++column) {
      const SafetyState next = state_of(letters.find(rows[row][column]));
      BISS_EXPECT_EQ(next_state(state_of(row), static_cast<SafetyEvent>(column)), next)
          << row << " " << column;
    }
  }
}

BISS_TEST(SafetyStates, OnlyAPowerUpLeavesFailed) {
  for (std::size_t column = 0; column < safety_event_count; ++column) {
    BISS_EXPECT_EQ(next_state(SafetyState::failed, static_cast<SafetyEvent>(column)),
                   SafetyState::failed);
    // Nor does a value that is not a state.
    BISS_EXPECT_EQ(next_state(SafetyState{}, static_cast<SafetyEvent>(column)),
                   SafetyState::failed);
  }
}

BISS_TEST(SafetyStates, AcknowledgementOfAnotherFault_ClearsNothing) {
  SafetyBench bench;
  bench.until_safe();
  bench.send_flipped(50);
  BISS_ASSERT(bench.monitor.latched_cause() == spw_crc);
  for (std::size_t i = 0; i < safety_verdict_count; ++i) {
    if (verdict_of(i) == spw_crc) continue;
    BISS_EXPECT(!bench.monitor.acknowledge(verdict_of(i))) << i;
    BISS_EXPECT_EQ(bench.monitor.state(), SafetyState::latched);
  }
  BISS_EXPECT(bench.monitor.acknowledge(spw_crc));
  BISS_EXPECT_EQ(bench.monitor.state(), SafetyState::starting);
}

BISS_TEST(SafetyStates, ABudgetOfLineFaults_ToleratesNoFaultOfTheEncoderOrTheReceiver) {
  struct Case {
    SafetyVerdict verdict;
    SafetyJudgement (*send)(SafetyBench&);
  };
  constexpr Case cases[] = {
      {cpw_error,
       [](SafetyBench& b) { return b.send_changed([](auto& words) { words.cpw_nE = false; }); }},
      {spw_error,
       [](SafetyBench& b) { return b.send_changed([](auto& words) { words.spw_nE = false; }); }},
      {comparison,
       [](SafetyBench& b) { return b.send_changed([](auto& words) { words.spw += 2; }); }},
      {disagreement,
       [](SafetyBench& b) {
         b.now += SafetyBench::cycle;
         return b.monitor.step(OneClock{b.now}, SafetyFinding{.cause = safe}, SafetyFinding{});
       }},
  };
  for (const Case& each : cases) {
    SafetyBench bench(
        [](SafetySetup& setup) { setup.budget = {.faults = 4, .window = milliseconds(1)}; });
    bench.until_safe();
    const SafetyJudgement judged = each.send(bench);
    BISS_EXPECT_EQ(judged.verdict, each.verdict);
    BISS_EXPECT(!judged.tolerated && judged.state != SafetyState::safe);
  }
}

}  // namespace biss::safety_states_test
