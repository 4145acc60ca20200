// The eight transmission errors of IEC 61784-3: each gives its verdict in the specified cycle.
#include "biss/safety/monitor.hpp"
#include "biss/safety/verdict.hpp"
#include "tests/core/safety_bench.hpp"
#include "tests/core/test.hpp"

namespace biss::safety_kinds_test {

using enum SafetyVerdict;
using test::SafetyBench;
using test::SafetyWords;

// Injects the fault. Returns the judgement of the first frame or tick in which it can be detected.
using Commit = SafetyJudgement (*)(SafetyBench&);

struct Kind {
  TransmissionError kind;
  SafetyVerdict verdict;
  /// The time from the first wrong or missing frame to the verdict.
  unsigned reaction_cycles;
  Commit commit;
};

// In the order of the kinds. A kind may have several symptoms; the first one is that of its
// measure.
constexpr Kind kinds[] = {
    {TransmissionError::corruption, spw_crc, 0, [](SafetyBench& b) { return b.send_flipped(60); }},
    {TransmissionError::corruption, cpw_crc, 0, [](SafetyBench& b) { return b.send_flipped(20); }},
    {TransmissionError::corruption, comparison, 0,
     [](SafetyBench& b) {
       // A corruption that passed the CPW's CRC.
       SafetyWords words = b.next();
       words.cpw ^= std::uint64_t{1} << 30U;
       return b.send(words);
     }},
    {TransmissionError::repetition, counter_repeated, 0,
     [](SafetyBench& b) { return b.send(b.words()); }},
    {TransmissionError::sequence, counter_backwards, 0,
     [](SafetyBench& b) {
       // Repeats the frame before the last one.
       b.counter -= 1;
       return b.send(b.words());
     }},
    {TransmissionError::loss, counter_skipped, 0,
     [](SafetyBench& b) {
       b.next();
       return b.good();
     }},
    {TransmissionError::loss, no_frame, 0, [](SafetyBench& b) { return b.silence(); }},
    {TransmissionError::loss, watchdog, 1,
     [](SafetyBench& b) {
       // The master does not notice it either: no step is made.
       b.now = *b.monitor.deadline() + picoseconds(1);
       return b.watch(b.now);
     }},
    {TransmissionError::delay, watchdog, 1,
     [](SafetyBench& b) {
       b.now += SafetyBench::cycle;
       return b.good();
     }},
    {TransmissionError::insertion, counter_foreign, 0,
     [](SafetyBench& b) {
       SafetyWords words = b.words();
       words.life_counter = 45;
       return b.send(words);
     }},
    {TransmissionError::insertion, early, 0,
     [](SafetyBench& b) {
       b.now -= SafetyBench::cycle / 2;
       return b.good();
     }},
    {TransmissionError::masquerade, spw_crc, 0,
     [](SafetyBench& b) {
       // A channel as long as the SPW, with the CPW's kind of checksum.
       FrameFormat format = b.plan().format();
       format.channel_list[1].crc.polynomial = 0x11021;
       const FrameBits bits =
           test::bits_of(test::RunPlan(format, UnratedSafetySetup(b.plan().setup())), b.next());
       b.now += SafetyBench::cycle;
       return b.monitor.step(OneClock{b.now}, bits.view());
     }},
    {TransmissionError::addressing, counter_foreign, 0,
     [](SafetyBench& b) {
       // Another encoder with another position and its own counter.
       b.position = 77;
       b.counter += 31;
       return b.good();
     }},
    {TransmissionError::addressing, spw_crc, 0,
     [](SafetyBench& b) {
       // The same with another start value.
       FrameFormat format = b.plan().format();
       format.channel_list[1].crc.start = 0x1234;
       const FrameBits bits =
           test::bits_of(test::RunPlan(format, UnratedSafetySetup(b.plan().setup())), b.next());
       b.now += SafetyBench::cycle;
       return b.monitor.step(OneClock{b.now}, bits.view());
     }},
};

BISS_TEST(SafetyKinds, EachFault_HasItsVerdictInItsCycleAndThePositionIsWithheld) {
  for (const Kind& each : kinds) {
    SafetyBench bench([](SafetySetup& setup) { setup.frame_gap_min = SafetyBench::cycle * 3 / 4; });
    bench.until_safe();
    // Far enough from the counter's roll-over for the verdicts of this table.
    while (bench.counter != 25) bench.good();
    const Picoseconds last_good = bench.now;
    const SafetyJudgement judged = each.commit(bench);
    const auto kind = static_cast<std::size_t>(each.kind);
    BISS_EXPECT_EQ(judged.verdict, each.verdict) << kind;
    BISS_EXPECT(safety_measures[kind].may_be(judged.verdict)) << kind;
    BISS_EXPECT(!judged.position && judged.state == SafetyState::latched) << kind;
    // A part of a cycle counts in full.
    const Picoseconds due = last_good + SafetyBench::cycle;
    BISS_EXPECT_EQ(clocks_to_cover(bench.now - due, SafetyBench::cycle), each.reaction_cycles);
  }
}

BISS_TEST(SafetyKinds, EveryKind_HasOneVerdictOfItsOwn) {
  std::size_t seen = 0;
  for (const Kind& each : kinds) {
    const auto kind = static_cast<std::size_t>(each.kind);
    BISS_EXPECT(kind == seen || kind + 1U == seen);
    if (kind != seen) continue;
    BISS_EXPECT_EQ(safety_measures[kind].verdict, each.verdict) << kind;
    ++seen;
  }
  BISS_EXPECT_EQ(seen, transmission_error_count);
}

// The other possible verdicts, listed explicitly.
BISS_TEST(SafetyKinds, EveryKind_MayShowInTheWaysOfItsRow) {
  constexpr std::array<std::array<bool, safety_verdict_count>, transmission_error_count> may_be =
      [] {
        std::array<std::array<bool, safety_verdict_count>, transmission_error_count> made{};
        const auto allow = [&](TransmissionError kind, auto... verdicts) {
          ((made[static_cast<std::size_t>(kind)][index_of(verdicts)] = true), ...);
        };
        for (const TransmissionError kind :
             {TransmissionError::corruption, TransmissionError::masquerade,
              TransmissionError::addressing}) {
          allow(kind, no_frame, cpw_crc, spw_crc, cpw_error, spw_error, comparison);
        }
        // The counter may report any kind.
        for (auto& kind : made) {
          for (const SafetyVerdict verdict : {counter_mode, counter_repeated, counter_skipped,
                                              counter_backwards, counter_foreign}) {
            kind[index_of(verdict)] = true;
          }
        }
        allow(TransmissionError::loss, no_frame, watchdog);
        allow(TransmissionError::delay, watchdog, no_frame);
        allow(TransmissionError::insertion, early);
        return made;
      }();
  for (std::size_t kind = 0; kind < transmission_error_count; ++kind) {
    for (std::size_t verdict = 0; verdict < safety_verdict_count; ++verdict) {
      BISS_EXPECT_EQ(safety_measures[kind].may_be(verdict_of(verdict)), may_be[kind][verdict])
          << kind << " " << verdict;
    }
  }
}

}  // namespace biss::safety_kinds_test
