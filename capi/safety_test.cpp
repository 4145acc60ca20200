// The safety monitor through the C interface.
#include "capi/biss_c_safety.h"

#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "capi/test_handles.hpp"

namespace biss::capi {
namespace safety_test {

constexpr const char* configuration = "fs-36-28";
constexpr const char* format_text = "pos36,nE,nW,crc6+pos28,nE,nW,lc6,crc16;cds0";
constexpr std::int64_t cycle = 62'500'000;

biss_safety_setup setup_of(const char* name = configuration) {
  static biss_format format;
  biss_safety_setup setup;
  EXPECT_EQ(biss_safety_parse(name, cycle, &format, &setup), BISS_OK);
  return setup;
}

// A monitor and the frames of its encoder.
class Bench {
 public:
  explicit Bench(const biss_safety_setup& setup) : safety_(opened(biss_safety_init, setup)) {}

  biss_safety* get() const { return safety_.get(); }

  // The next frame of the encoder at `position` of the SPW, `damage`d at a bit unless that is 0.
  biss_judgement frame(std::uint64_t position, std::size_t damage = 0) {
    biss_frame frame;
    EXPECT_EQ(biss_frame_defaults(codec_.get(), &frame), BISS_OK);
    frame.channels[0].position = position << 8U;
    frame.channels[1].position = position;
    counter_ = counter_ % 63 + 1;
    frame.channels[1].life_counter = counter_;
    frame.lead_clocks = 2;
    frame.ack_clocks = 50;
    std::array<std::uint8_t, BISS_FRAME_BYTES_MAX> bytes{};
    std::size_t bits = 0;
    EXPECT_EQ(biss_frame_encode(codec_.get(), &frame, bytes.data(), bytes.size(), &bits), BISS_OK);
    if (damage != 0) bytes[damage / 8] ^= static_cast<std::uint8_t>(0x80U >> (damage % 8));
    now_ += cycle;
    biss_judgement judgement;
    const biss_safety_time time{now_, now_, 0};
    EXPECT_EQ(
        biss_safety_step(safety_.get(), &time, bytes.data(), bytes.size(), 0, bits, &judgement),
        BISS_OK);
    return judgement;
  }
  biss_judgement watch(std::int64_t later) {
    biss_judgement judgement;
    const biss_safety_time time{now_ + later, now_ + later, 0};
    EXPECT_EQ(biss_safety_watch(safety_.get(), &time, &judgement), BISS_OK);
    return judgement;
  }
  bool self_test(const biss_safety_setup& expected) {
    bool passed = false;
    EXPECT_EQ(biss_safety_self_test(safety_.get(), &expected, &passed), BISS_OK);
    return passed;
  }
  std::int64_t now() const { return now_; }

 private:
  Handle<biss_safety> safety_;
  Handle<biss_codec> codec_ = opened(biss_codec_init, *named(format_text));
  std::uint32_t counter_ = 0;
  std::int64_t now_ = 0;
};

TEST(CSafety, GoodFrames_BecomeSafeAfterTheSelfTest) {
  Bench bench(setup_of());
  EXPECT_EQ(bench.frame(1000).verdict, BISS_VERDICT_SELF_TEST);
  EXPECT_TRUE(bench.self_test(setup_of()));
  EXPECT_EQ(bench.frame(1000).verdict, BISS_VERDICT_STARTING);
  EXPECT_EQ(bench.frame(1001).verdict, BISS_VERDICT_STARTING);
  const biss_judgement judgement = bench.frame(1002);
  EXPECT_EQ(judgement.verdict, BISS_VERDICT_SAFE);
  EXPECT_STREQ(judgement.state, "safe");
  ASSERT_TRUE(judgement.has_position);
  EXPECT_EQ(judgement.position, 1002U);
  EXPECT_EQ(judgement.low, 1001U);
  EXPECT_EQ(judgement.high, 1003U);
  EXPECT_EQ(judgement.control_position, 1002U << 8U);
  EXPECT_TRUE(judgement.cpw_nW && judgement.spw_nW);
  EXPECT_EQ(judgement.difference_lsb, 0);
}

TEST(CSafety, DamagedFrame_IsLatchedUntilAcknowledged) {
  Bench bench(setup_of());
  ASSERT_TRUE(bench.self_test(setup_of()));
  for (std::uint64_t i = 0; i < 5; ++i) bench.frame(i);
  // A bit of the CPW: 2 + 50 + START + CDS, then 44 bits.
  const biss_judgement damaged = bench.frame(5, 60);
  EXPECT_STREQ(biss_verdict_name(damaged.verdict), "cpw_crc");
  EXPECT_FALSE(damaged.has_position);
  EXPECT_EQ(damaged.position, 0U);
  EXPECT_EQ(bench.frame(6).verdict, BISS_VERDICT_LATCHED);
  biss_verdict cause = BISS_VERDICT_SAFE;
  ASSERT_EQ(biss_safety_cause(bench.get(), &cause), BISS_OK);
  EXPECT_EQ(cause, BISS_VERDICT_CPW_CRC);
  EXPECT_EQ(biss_safety_acknowledge(bench.get(), BISS_VERDICT_SPW_CRC), BISS_NO_READING);
  EXPECT_EQ(biss_safety_acknowledge(bench.get(), static_cast<biss_verdict>(99)), BISS_NO_READING);
  EXPECT_EQ(biss_safety_acknowledge(bench.get(), cause), BISS_OK);
  EXPECT_EQ(biss_safety_cause(bench.get(), &cause), BISS_NO_READING);
  EXPECT_EQ(bench.frame(7).verdict, BISS_VERDICT_STARTING);
}

TEST(CSafety, WatchdogDeadlineAndExpectation_AreThere) {
  Bench bench(setup_of());
  bool is_expected = true;
  std::int64_t deadline = 0;
  ASSERT_EQ(biss_safety_deadline(bench.get(), &is_expected, &deadline), BISS_OK);
  EXPECT_FALSE(is_expected);
  ASSERT_TRUE(bench.self_test(setup_of()));
  for (std::uint64_t i = 0; i < 5; ++i) bench.frame(i);
  ASSERT_EQ(biss_safety_deadline(bench.get(), &is_expected, &deadline), BISS_OK);
  EXPECT_TRUE(is_expected);
  EXPECT_EQ(deadline, bench.now() + cycle + cycle / 2);
  EXPECT_EQ(bench.watch(cycle).verdict, BISS_VERDICT_SAFE);
  ASSERT_EQ(biss_safety_expect(bench.get(), 10, 20), BISS_OK);
  EXPECT_EQ(bench.frame(21).verdict, BISS_VERDICT_STIMULUS);
  EXPECT_EQ(biss_safety_acknowledge(bench.get(), BISS_VERDICT_STIMULUS), BISS_OK);
  for (std::uint64_t i = 0; i < 5; ++i) EXPECT_EQ(bench.frame(15).verdict, BISS_VERDICT_STIMULUS);
  EXPECT_EQ(biss_safety_encoder_restarted(bench.get()), BISS_OK);
  for (std::uint64_t i = 0; i < 5; ++i) bench.frame(i);
  EXPECT_EQ(bench.watch(2 * cycle).verdict, BISS_VERDICT_WATCHDOG);
}

// A program that looks at the verdict alone takes it for no position of an axis.
TEST(CSafety, SafeWithoutAFrame_HasNoPositionThatAnEncoderCouldHave) {
  Bench bench(setup_of());
  ASSERT_TRUE(bench.self_test(setup_of()));
  for (std::uint64_t i = 0; i < 5; ++i) bench.frame(1000);
  const biss_judgement judgement = bench.watch(cycle);
  EXPECT_EQ(judgement.verdict, BISS_VERDICT_SAFE);
  EXPECT_FALSE(judgement.has_position);
  for (const std::uint64_t position :
       {judgement.position, judgement.low, judgement.high, judgement.control_position}) {
    EXPECT_EQ(position, BISS_NO_POSITION);
  }
}

// An expectation, then no answer that the budget tolerates, then a position outside.
TEST(CSafety, ExpectationAfterAToleratedFault_IsStillThere) {
  biss_safety_setup setup = setup_of();
  setup.budget_faults = 1;
  setup.budget_window_ps = 100 * cycle;
  setup.frame_gap_max_ps = 4 * cycle;
  Bench bench(setup);
  ASSERT_TRUE(bench.self_test(setup));
  for (std::uint64_t i = 0; i < 5; ++i) bench.frame(1000 + i);
  ASSERT_EQ(biss_safety_expect(bench.get(), 5'000'000, 5'000'100), BISS_OK);
  EXPECT_TRUE(bench.frame(1005, 60).tolerated);
  const biss_judgement judgement = bench.frame(1006);
  EXPECT_EQ(judgement.verdict, BISS_VERDICT_STIMULUS);
  EXPECT_FALSE(judgement.has_position);
}

TEST(CSafety, SelfTestOfAFailedMonitor_DoesNotPass) {
  Bench bench(setup_of());
  biss_safety_setup other = setup_of();
  other.start_frames = 4;
  ASSERT_TRUE(bench.self_test(setup_of()));
  EXPECT_FALSE(bench.self_test(other));
  EXPECT_STREQ(bench.frame(1).state, "failed");
  EXPECT_FALSE(bench.self_test(setup_of()));
}

TEST(CSafety, AnotherSetupThanExpected_FailsTheSelfTest) {
  Bench bench(setup_of());
  biss_safety_setup other = setup_of();
  other.start_frames = 4;
  EXPECT_FALSE(bench.self_test(other));
  EXPECT_EQ(bench.frame(1).verdict, BISS_VERDICT_SELF_TEST);
}

TEST(CSafety, ExpectedSetupWithoutTheChecksOfRating_FailsTheSelfTest) {
  biss_safety_setup unrated = setup_of();
  unrated.unrated = true;
  Bench rated(setup_of());
  EXPECT_FALSE(rated.self_test(unrated));
  EXPECT_TRUE(rated.self_test(setup_of()));
  EXPECT_FALSE(rated.self_test(unrated));
  EXPECT_STREQ(rated.frame(1).state, "failed");
  Bench other(unrated);
  EXPECT_FALSE(other.self_test(setup_of()));
  EXPECT_TRUE(other.self_test(unrated));
}

TEST(CSafety, ExpectedSetupThatCannotBeMonitored_IsRefused) {
  biss_safety_setup weak = setup_of();
  weak.compare_bits = 8;
  weak.unrated = true;
  Bench bench(weak);
  weak.unrated = false;
  bool passed = true;
  EXPECT_EQ(biss_safety_self_test(bench.get(), &weak, &passed), BISS_BAD_SAFETY);
  EXPECT_FALSE(passed);
  EXPECT_EQ(bench.frame(1).verdict, BISS_VERDICT_SELF_TEST);
}

TEST(CSafety, SetupsThatCannotBeMonitored_HaveTheirName) {
  const auto problem = [](auto change) -> std::string {
    biss_safety_setup setup = setup_of();
    change(setup);
    const auto safety = std::make_unique<biss_safety>();
    const biss_status status = biss_safety_init(safety.get(), &setup);
    EXPECT_EQ(biss_safety_expect(safety.get(), 0, 0) == BISS_BAD_HANDLE, status != BISS_OK);
    const char* name = biss_safety_problem(&setup);
    EXPECT_EQ(status == BISS_BAD_SAFETY, name != nullptr);
    return name != nullptr ? name : biss_status_name(status);
  };
  using S = biss_safety_setup;
  EXPECT_EQ(problem([](S&) {}), "ok");
  EXPECT_EQ(problem([](S& s) { s.spw = 0; }), "channels");
  EXPECT_EQ(problem([](S& s) { s.start_frames = 1; }), "start_frames");
  EXPECT_EQ(problem([](S& s) { s.frame_gap_max_ps = 0; }), "frame_gap");
  EXPECT_EQ(problem([](S& s) { s.format = named("pos26,nE,nW,crc6"); }), "channels");
  EXPECT_EQ(problem([](S& s) { s.bounds.ack_min_clocks = 32, s.bounds.ack_max_clocks = 2; }),
            "bounds");
  EXPECT_EQ(problem([](S& s) { s.bounds.lead_max_clocks = 0; }), "bounds");
  EXPECT_EQ(problem([](S& s) { s.compare_bits = 8; }), "weak_comparison");
  EXPECT_EQ(problem([](S& s) { s.compare_bits = 8, s.unrated = true; }), "ok");
  EXPECT_EQ(problem([](S& s) { s.format = named("pos20,nE,nW,crc6+pos19,nE,nW,lc6,crc16"); }),
            "unrated");
  EXPECT_EQ(problem([](S& s) { s.format = named("what"); }), "bad_format");
  EXPECT_EQ(problem([](S& s) { s.format = nullptr; }), "null_argument");
  EXPECT_EQ(problem([](S& s) { s.cpw = 256; }), "bad_setup");
  EXPECT_EQ(problem([](S& s) { s.counter = static_cast<biss_counter_mode>(3); }), "bad_setup");
}

TEST(CSafety, WatchdogInWhichAPeriodCanBeLost_IsRefused) {
  const auto problem = [](std::int64_t cycle_min, std::int64_t most, std::int64_t least,
                          bool unrated) -> std::string {
    biss_format format;
    biss_safety_setup setup;
    EXPECT_EQ(biss_safety_parse(configuration, 0, &format, &setup), BISS_OK);
    setup.cycle_min_ps = cycle_min;
    setup.frame_gap_max_ps = most;
    if (least >= 0) setup.frame_gap_min_ps = least;
    setup.unrated = unrated;
    const char* name = biss_safety_problem(&setup);
    const auto safety = std::make_unique<biss_safety>();
    EXPECT_EQ(biss_safety_init(safety.get(), &setup), name == nullptr ? BISS_OK : BISS_BAD_SAFETY);
    return name == nullptr ? "ok" : name;
  };
  constexpr std::int64_t usual = -1;
  constexpr std::int64_t ms = 1'000'000'000;
  for (const bool unrated : {false, true}) {
    EXPECT_EQ(problem(2 * ms, 3 * ms, usual, unrated), "frame_gap");
    EXPECT_EQ(problem(2 * ms, 3 * ms, 2 * ms, unrated), "ok");
    EXPECT_EQ(problem(INT64_MAX, 100'000 * ms, usual, unrated), "frame_gap");
    EXPECT_EQ(problem(INT64_MAX, 46'875'000, usual, unrated), "frame_gap");
    EXPECT_EQ(problem(0, 46'875'000, usual, unrated), "frame_gap");
  }
  // Without a shortest gap the encoder's own cycle counts, at most 31.25 us of it.
  EXPECT_EQ(problem(2 * ms, 3 * ms, 0, true), "frame_gap");
  EXPECT_EQ(problem(2 * ms, 46'875'000, 0, true), "ok");
  EXPECT_EQ(problem(31'250'000, 46'875'000, 0, false), "residual");
}

TEST(CSafety, DefaultsAtAnyCycle_AreValidUpTo100Seconds) {
  biss_format format;
  biss_safety_setup setup;
  for (const char* name : {configuration, "rxm", format_text}) {
    for (std::int64_t cycle_ps = 31'250'000; cycle_ps <= 100'000'000'000'000;
         cycle_ps += cycle_ps / 9) {
      ASSERT_EQ(biss_safety_parse(name, cycle_ps, &format, &setup), BISS_OK);
      EXPECT_EQ(biss_safety_problem(&setup), nullptr) << name << " " << cycle_ps;
    }
    ASSERT_EQ(biss_safety_parse(name, 100'000'000'000'001, &format, &setup), BISS_OK);
    EXPECT_STREQ(biss_safety_problem(&setup), "frame_gap");
    ASSERT_EQ(biss_safety_parse(name, std::numeric_limits<std::int64_t>::max(), &format, &setup),
              BISS_OK);
    EXPECT_STREQ(biss_safety_problem(&setup), "frame_gap");
  }
}

// A request every 2 ms with the defaults of that cycle, then every 31.25 us: no frame is accepted.
TEST(CSafety, FramesFasterThanTheSetupsCycle_AreEarly) {
  biss_format format;
  biss_safety_setup setup;
  ASSERT_EQ(biss_safety_parse(configuration, 2 * std::int64_t{1'000'000'000}, &format, &setup),
            BISS_OK);
  Bench bench(setup);
  EXPECT_TRUE(bench.self_test(setup));
  bench.frame(1000);
  EXPECT_EQ(bench.frame(1001).verdict, BISS_VERDICT_EARLY);
}

TEST(CSafety, SelfTestWithAnotherLimitRatingOrUnrated_Fails) {
  const auto passes = [](auto opened_with, auto expects) {
    biss_safety_setup opened = setup_of();
    opened_with(opened);
    Bench bench(opened);
    biss_safety_setup expected = setup_of();
    expects(expected);
    return bench.self_test(expected);
  };
  using S = biss_safety_setup;
  const auto as_it_is = [](S&) {};
  const auto wide = [](S& s) { s.residual_max_e15 = 2'500'000; };
  const auto rating = [](S& s) { s.rating_check = 1; };
  const auto unrated = [](S& s) { s.unrated = true; };
  EXPECT_TRUE(passes(as_it_is, as_it_is));
  EXPECT_TRUE(passes(wide, wide));
  EXPECT_TRUE(passes(unrated, unrated));
  EXPECT_FALSE(passes(wide, as_it_is));
  EXPECT_FALSE(passes(as_it_is, wide));
  EXPECT_FALSE(passes(rating, as_it_is));
  EXPECT_FALSE(passes(unrated, as_it_is));
  EXPECT_FALSE(passes(as_it_is, unrated));
}

TEST(CSafety, WrongCalls_AreRefusedByTheirCause) {
  biss_format format;
  biss_safety_setup setup;
  EXPECT_EQ(biss_safety_parse(nullptr, 0, &format, &setup), BISS_NULL_ARGUMENT);
  EXPECT_EQ(biss_safety_parse(configuration, 0, nullptr, &setup), BISS_NULL_ARGUMENT);
  EXPECT_EQ(biss_safety_parse("what", 0, &format, &setup), BISS_BAD_FORMAT);
  EXPECT_EQ(biss_safety_parse(configuration, -1, &format, &setup), BISS_BAD_SETUP);
  EXPECT_EQ(biss_safety_defaults(nullptr, 0, &setup), BISS_NULL_ARGUMENT);
  EXPECT_EQ(biss_safety_defaults(named(format_text), 0, &setup), BISS_OK);
  EXPECT_EQ(setup.start_frames, 3U);
  setup = setup_of();
  const Handle<biss_safety> memory = opened(biss_safety_init, setup);
  biss_safety* const safety = memory.get();
  EXPECT_EQ(biss_safety_init(nullptr, &setup), BISS_NULL_ARGUMENT);
  bool flag = false;
  std::int64_t deadline = 0;
  biss_verdict cause{};
  biss_judgement judgement;
  const biss_safety_time time{};
  const auto every = [&](biss_safety* s) {
    return std::vector<biss_status>{biss_safety_self_test(s, &setup, &flag),
                                    biss_safety_step(s, &time, nullptr, 0, 0, 0, &judgement),
                                    biss_safety_watch(s, &time, &judgement),
                                    biss_safety_deadline(s, &flag, &deadline),
                                    biss_safety_expect(s, 0, 1),
                                    biss_safety_acknowledge(s, BISS_VERDICT_CLOCK),
                                    biss_safety_cause(s, &cause),
                                    biss_safety_encoder_restarted(s)};
  };
  EXPECT_EQ(biss_safety_step(safety, &time, nullptr, 1, 0, 0, &judgement), BISS_NULL_ARGUMENT);
  EXPECT_EQ(biss_safety_self_test(safety, nullptr, &flag), BISS_NULL_ARGUMENT);
  expect_refusals(safety, every);
  for (const int number : {-1, 23, 99}) {
    EXPECT_STREQ(biss_verdict_name(static_cast<biss_verdict>(number)), "invalid");
  }
}

}  // namespace safety_test
}  // namespace biss::capi
