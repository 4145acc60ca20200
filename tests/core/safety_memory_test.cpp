// The safety monitor and faults of the memory: every bit of its state, its plan, and its judgement.
#include "biss/safety/monitor.hpp"
#include "tests/core/monitor_bytes.hpp"
#include "tests/core/safety_bench.hpp"
#include "tests/core/test.hpp"

namespace biss::safety_memory_test {

using enum SafetyVerdict;

// The engine of the microcontrollers: its tables are small enough to flip all their bits.
using Plan = SafetyPlan<2, CrcTable<4>>;
using Monitor = SafetyMonitor<Plan>;

constexpr Picoseconds cycle = nanoseconds(31'250);

BISS_TEST(SafetyCodes, VerdictsAndStates_DifferInFourBits) {
  constexpr std::size_t count = safety_verdict_count + safety_state_count + 2;
  std::array<std::uint16_t, count> codes{};
  std::size_t k = 0;
  for (std::size_t i = 0; i < safety_verdict_count; ++i) {
    codes[k++] = static_cast<std::uint16_t>(verdict_of(i));
  }
  for (std::size_t i = 0; i < safety_state_count; ++i) {
    codes[k++] = static_cast<std::uint16_t>(state_of(i));
  }
  codes[k++] = 0;
  codes[k++] = 0xFFFF;
  for (std::size_t a = 0; a < count; ++a) {
    for (std::size_t b = 0; b < a; ++b) {
      const auto apart = static_cast<std::uint16_t>(codes[a] ^ codes[b]);
      BISS_EXPECT(std::popcount(apart) >= 4) << a << " " << b;
    }
  }
}

// Every value that is none of the listed ones: none of them has a number or a name.
BISS_TEST(SafetyCodes, OtherValues_AreNoVerdictsAndNoStates) {
  for (unsigned value = 0; value < 0x10000U; ++value) {
    const auto word = static_cast<std::uint16_t>(value);
    std::size_t verdict = 0;
    while (verdict < safety_verdict_count &&
           static_cast<std::uint16_t>(verdict_of(verdict)) != word) {
      ++verdict;
    }
    BISS_EXPECT_EQ(index_of(static_cast<SafetyVerdict>(word)), verdict) << value;
    std::size_t state = 0;
    while (state < safety_state_count && static_cast<std::uint16_t>(state_of(state)) != word) {
      ++state;
    }
    const auto as_state = static_cast<SafetyState>(word);
    BISS_EXPECT_EQ(name_of(as_state) == "invalid", state == safety_state_count) << value;
    if (state == safety_state_count) {
      BISS_EXPECT_EQ(next_state(as_state, SafetyEvent::good_frame), SafetyState::failed) << value;
    }
  }
}

// A monitor as bytes that a fault can change.
using Bytes = test::MonitorBytes<Monitor>;

// What a monitor may be asked, each to be refused. The encoder's last counter is 20.
class Probe {
 public:
  explicit Probe(const Plan& plan) : good(bits(plan, words(21))) {
    repeated = bits(plan, words(20));
    lost = bits(plan, words(22));
    auto wrong = words(21);
    wrong.spw += 2;
    apart = bits(plan, wrong);
    wrong = words(21);
    wrong.cpw_nE = false;
    error = bits(plan, wrong);
    flipped = good;
    flipped.flip(2U + test::ack_clocks + 2U + 50U);
  }

  static test::SafetyWords words(std::uint32_t counter) {
    return {.cpw = 0x5'5555'1234U, .spw = 0x5'5555'1234U >> 8U, .life_counter = counter};
  }
  static FrameBits bits(const Plan& plan, const test::SafetyWords& sent) {
    return test::bits_of(plan, sent);
  }

  // The number of wrong frames for which this monitor gives a position.
  unsigned accepted_by(const Bytes& monitor) const {
    unsigned accepted = 0;
    for (const FrameBits* each : {&repeated, &lost, &apart, &error, &flipped}) {
      accepted += gives_position(monitor, cycle, *each) ? 1U : 0U;
    }
    accepted += gives_position(monitor, 2 * cycle, good) ? 1U : 0U;
    accepted += gives_position(monitor, cycle / 2, good) ? 1U : 0U;
    return accepted;
  }
  static bool gives_position(Bytes monitor, Picoseconds now, const FrameBits& sent) {
    return monitor.monitor().step(OneClock{now}, sent.view()).position.has_value();
  }

  FrameBits good;
  FrameBits repeated;
  FrameBits lost;
  FrameBits apart;
  FrameBits error;
  FrameBits flipped;
};

Plan usual_plan() {
  const SafetyConfiguration& type = *find_safety_configuration("fs-36-28");
  return {type.frame_format(), UnratedSafetySetup(type.setup)};
}

// Good frames up to the time 0 and the counter 20.
void make_safe(Monitor& monitor, const Plan& plan) {
  for (std::uint32_t counter = 10; counter <= 20; ++counter) {
    const FrameBits sent = Probe::bits(plan, Probe::words(counter));
    monitor.step(OneClock{(std::int64_t{counter} - 20) * cycle}, sent.view());
  }
}
Bytes safe_monitor(const Plan& plan) {
  Monitor monitor(plan);
  static_cast<void>(monitor.self_test(plan.fingerprint()));
  make_safe(monitor, plan);
  return Bytes(monitor);
}

// With any two bits of a word changed, and any bit; under emulation one word of eight.
void with_any_two_bits(Bytes& bytes, const auto& expect) {
  const auto step = static_cast<std::size_t>(32U * test::rounds(1, 8));
  for (std::size_t word = 0; word < Bytes::size_bits; word += step) {
    for (std::size_t a = word; a < word + 32U; ++a) {
      bytes.flip(a);
      expect(a, a);
      for (std::size_t b = word; b < a; ++b) {
        bytes.flip(b);
        expect(a, b);
        bytes.flip(b);
      }
      bytes.flip(a);
    }
  }
}

BISS_TEST(SafetyMemory, AnyBitOfASafeMonitor_NeverMakesItAcceptAWrongFrame) {
  const Plan plan = usual_plan();
  const Probe probe(plan);
  Bytes bytes = safe_monitor(plan);
  BISS_ASSERT(bytes.monitor().state() == SafetyState::safe);
  BISS_EXPECT(Probe::gives_position(bytes, cycle, probe.good));
  BISS_EXPECT_EQ(probe.accepted_by(bytes), 0);
  for (std::size_t bit = 0; bit < Bytes::size_bits; ++bit) {
    bytes.flip(bit);
    BISS_EXPECT_EQ(probe.accepted_by(bytes), 0) << bit;
    bytes.flip(bit);
  }
}

BISS_TEST(SafetyMemory, AnyTwoBitsOfAWord_NeverMakeASafeMonitorAcceptAWrongFrame) {
  const Plan plan = usual_plan();
  const Probe probe(plan);
  Bytes bytes = safe_monitor(plan);
  with_any_two_bits(bytes, [&](std::size_t a, std::size_t b) {
    BISS_EXPECT_EQ(probe.accepted_by(bytes), 0) << a << " " << b;
  });
}

BISS_TEST(SafetyMemory, SameBitOfTwoWords_ChangesTheChecksum) {
  const Plan plan = usual_plan();
  const Probe probe(plan);
  Bytes bytes = safe_monitor(plan);
  constexpr std::size_t begin = sizeof(Plan) * 8U;
  // The checksum itself, and what follows it, are not among the words.
  constexpr std::size_t end = Bytes::size_bits - 96U;
  for (std::size_t apart = 32; apart <= 128; apart += 32) {
    for (std::size_t bit = begin; bit + apart < end; ++bit) {
      bytes.flip(bit);
      bytes.flip(bit + apart);
      Bytes changed = bytes;
      BISS_EXPECT_EQ(changed.monitor().step(OneClock{cycle}, probe.good.view()).verdict, memory)
          << bit;
      bytes.flip(bit);
      bytes.flip(bit + apart);
    }
  }
}

// A monitor that must refuse every frame: latched, failed, untested.
BISS_TEST(SafetyMemory, AnyTwoBitsOfAMonitorThatRefuses_GiveNoPosition) {
  const Plan plan = usual_plan();
  const Probe probe(plan);
  Bytes latched_one = safe_monitor(plan);
  latched_one.monitor().step(OneClock{cycle / 2}, BitView());
  Bytes failed_one = safe_monitor(plan);
  const SafetyFinding wrong;
  failed_one.monitor().step(OneClock{cycle / 2}, SafetyFinding{.cause = safe}, wrong);
  BISS_EXPECT_EQ(latched_one.monitor().state(), SafetyState::latched);
  BISS_EXPECT_EQ(failed_one.monitor().state(), SafetyState::failed);
  for (Bytes bytes : {latched_one, failed_one, Bytes(Monitor(plan))}) {
    with_any_two_bits(bytes, [&](std::size_t a, std::size_t b) {
      BISS_EXPECT(!Probe::gives_position(bytes, cycle, probe.good)) << a << " " << b;
    });
  }
}

BISS_TEST(SafetyMemory, AnyBitOfAPlan_FailsTheSelfTestOrIsRefusedInEveryFrame) {
  const Plan plan = usual_plan();
  const Probe probe(plan);
  for (std::size_t bit = 0; bit < sizeof(Plan) * 8U;
       bit += static_cast<std::size_t>(test::rounds(1, 64))) {
    Plan wrong = plan;
    auto* bytes = reinterpret_cast<unsigned char*>(&wrong);
    bytes[bit / 8U] = static_cast<unsigned char>(bytes[bit / 8U] ^ (1U << (bit % 8U)));
    Monitor monitor(wrong);
    if (!monitor.self_test(plan.fingerprint())) continue;
    make_safe(monitor, plan);
    BISS_EXPECT_EQ(probe.accepted_by(Bytes(monitor)), 0) << bit;
  }
}

BISS_TEST(SafetyMemory, AChangedBit_IsNamedOnceAndThenHolds) {
  const Plan plan = usual_plan();
  const Probe probe(plan);
  Bytes bytes = safe_monitor(plan);
  // The monitor's memory lies behind its plan.
  bytes.flip(8U * sizeof(Plan) + 70U);
  Monitor& monitor = bytes.monitor();
  BISS_EXPECT_EQ(monitor.step(OneClock{cycle}, probe.good.view()).verdict, memory);
  BISS_EXPECT_EQ(monitor.state(), SafetyState::failed);
  BISS_EXPECT_EQ(monitor.latched_cause(), memory);
  BISS_EXPECT_EQ(monitor.step(OneClock{2 * cycle}, probe.good.view()).verdict, failed);
  BISS_EXPECT(!monitor.acknowledge(memory));
  monitor.encoder_restarted();
  BISS_EXPECT(!monitor.self_test(plan.fingerprint()));
  BISS_EXPECT_EQ(monitor.state(), SafetyState::failed);
}

BISS_TEST(SafetyMemory, AChangedPlan_IsAFaultThatHoldsAfterItIsRightAgain) {
  const Plan plan = usual_plan();
  const Probe probe(plan);
  const Bytes sound = safe_monitor(plan);
  unsigned named = 0;
  for (std::size_t bit = 0; bit < sizeof(Plan) * 8U; ++bit) {
    Bytes bytes = sound;
    bytes.flip(bit);
    Monitor& monitor = bytes.monitor();
    if (monitor.step(OneClock{cycle}, probe.good.view()).verdict != memory) continue;
    ++named;
    bytes.flip(bit);
    BISS_EXPECT_EQ(monitor.state(), SafetyState::failed) << bit;
    BISS_EXPECT_EQ(monitor.latched_cause(), memory) << bit;
    BISS_EXPECT_EQ(monitor.step(OneClock{2 * cycle}, probe.good.view()).verdict, failed) << bit;
  }
  BISS_EXPECT(named > 500);
}

BISS_TEST(SafetyMemory, AnyBitOfAMonitorWithAPlanMadeWhileCompiling_IsNamed) {
  constexpr auto type = safety_configuration("fs-36-28");
  using Fixed = SafetyMonitor<FixedSafetyPlan<type.frame_format(), type.setup, CrcTable<4>>>;
  Fixed monitor;
  BISS_EXPECT(monitor.self_test());
  // The checksum comes last; what follows it is not used.
  for (std::size_t bit = 0; bit < sizeof monitor * 8U - 32U; ++bit) {
    test::MonitorBytes bytes(monitor);
    bytes.flip(bit);
    BISS_EXPECT_EQ(bytes.monitor().watch(OneClock{}).verdict, memory) << bit;
  }
}

// Nothing that the caller may do makes a changed memory the right one.
BISS_TEST(SafetyMemory, NoFunction_KeepsAChangedBit) {
  using Call = void (*)(Monitor&);
  constexpr Call calls[] = {
      [](Monitor& m) { static_cast<void>(m.self_test(m.plan().fingerprint())); },
      [](Monitor& m) { m.acknowledge(m.latched_cause()); },
      [](Monitor& m) { m.encoder_restarted(); },
      [](Monitor& m) { m.expect_position(1, 2); },
      [](Monitor& m) { m.watch(OneClock{cycle}); },
  };
  const Plan plan = usual_plan();
  const Bytes safe_one = safe_monitor(plan);
  Bytes latched_one = safe_one;
  latched_one.monitor().step(OneClock{cycle / 2}, BitView());
  for (const Bytes& sound : {safe_one, latched_one}) {
    for (const Call call : calls) {
      Bytes bytes = sound;
      bytes.flip(8U * sizeof(Plan) + 70U);
      call(bytes.monitor());
      BISS_EXPECT_EQ(bytes.monitor().state(), SafetyState::failed);
      BISS_EXPECT_EQ(bytes.monitor().latched_cause(), memory);
    }
  }
}

// The length of the frame and the engines of the CRCs are in the plan, not in its fingerprint.
BISS_TEST(SafetyMemory, PlanWithAnotherLengthOrEngine_IsNoLongerItself) {
  const Plan plan = usual_plan();
  BISS_EXPECT(plan.is(plan.fingerprint()));
  unsigned lengths = 0;
  unsigned engines = 0;
  for (std::size_t bit = 0; bit < sizeof(Plan) * 8U; ++bit) {
    Plan wrong = plan;
    auto* bytes = reinterpret_cast<unsigned char*>(&wrong);
    bytes[bit / 8U] = static_cast<unsigned char>(bytes[bit / 8U] ^ (1U << (bit % 8U)));
    const bool length = wrong.payload_bits() != plan.payload_bits();
    bool engine = false;
    for (const std::size_t k : {std::size_t{0}, std::size_t{1}}) {
      engine = engine || SafetyFingerprint::word_of(wrong.codec().engine_spec(k)) !=
                             SafetyFingerprint::word_of(plan.codec().engine_spec(k));
    }
    lengths += length ? 1U : 0U;
    engines += engine ? 1U : 0U;
    const bool same = !length && !engine;
    BISS_EXPECT(same || !wrong.is(plan.fingerprint())) << bit;
  }
  BISS_EXPECT(lengths != 0 && engines != 0);
}

BISS_TEST(SafetyMemory, AnyTwoBitsOfAJudgement_NeverChangeOrInventAPosition) {
  const Plan plan = usual_plan();
  const Probe probe(plan);
  Bytes safe_one = safe_monitor(plan);
  Monitor& monitor = safe_one.monitor();
  const SafetyJudgement good = monitor.step(OneClock{cycle}, probe.good.view());
  BISS_ASSERT(good.position.has_value());
  const SafetyJudgement bad = monitor.step(OneClock{2 * cycle}, probe.good.view());
  BISS_EXPECT(!bad.position.has_value());
  for (const SafetyJudgement& sound : {good, bad}) {
    GuardedPosition changed = sound.position;
    auto* bytes = reinterpret_cast<unsigned char*>(&changed);
    const auto flip = [&](std::size_t bit) {
      bytes[bit / 8U] = static_cast<unsigned char>(bytes[bit / 8U] ^ (1U << (bit % 8U)));
    };
    for (std::size_t a = 0; a < sizeof changed * 8U; ++a) {
      flip(a);
      for (std::size_t b = a / 32U * 32U; b <= a; ++b) {
        if (b != a) flip(b);
        const bool same = sound.position && *changed == *sound.position;
        BISS_EXPECT(!changed.has_value() || same) << a << " " << b;
        if (b != a) flip(b);
      }
      flip(a);
    }
  }
}

}  // namespace biss::safety_memory_test
