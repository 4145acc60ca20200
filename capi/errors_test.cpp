// Every way in which the C interface refuses.
#include <gtest/gtest.h>

#include <climits>
#include <functional>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "capi/test_handles.hpp"

namespace biss::capi {
namespace errors_test {

constexpr const char* format = "pos26,nE,nW,crc6";
constexpr std::int64_t period = 1'000'000;
constexpr int last_status = BISS_NO_CRC;

biss_status try_slave(const biss_slave_setup* setup) {
  auto slave = std::make_unique<biss_slave>();
  const biss_status status = biss_slave_init(slave.get(), setup);
  EXPECT_EQ(biss_slave_state(slave.get()) == nullptr, status != BISS_OK);
  return status;
}

biss_status try_master(const biss_master_setup* setup) {
  auto master = std::make_unique<biss_master>();
  biss_output out;
  const biss_status status = biss_master_init(master.get(), setup);
  EXPECT_EQ(biss_master_begin(master.get(), 0, true, false, &out) == BISS_BAD_HANDLE,
            status != BISS_OK);
  return status;
}

TEST(CErrors, NamesAndTexts_AreThereAndDiffer) {
  std::set<std::string> names;
  for (int i = BISS_OK; i <= last_status; ++i) {
    const auto status = static_cast<biss_status>(i);
    names.insert(biss_status_name(status));
    EXPECT_GT(std::string(biss_status_text(status)).size(), 3U);
  }
  EXPECT_EQ(names.size(), 1U + last_status);
  EXPECT_STREQ(biss_status_name(BISS_SLO_LOW), "slo_low");
  EXPECT_STREQ(biss_status_name(BISS_NO_READING), "no_reading");
  for (const int number : {last_status + 1, 99, -1, INT_MAX, INT_MIN}) {
    EXPECT_STREQ(biss_status_name(static_cast<biss_status>(number)), "unknown") << number;
    EXPECT_STREQ(biss_status_text(static_cast<biss_status>(number)), "no such status") << number;
  }
  const std::vector<std::pair<biss_cause, const char*>> causes{
      {BISS_CAUSE_OK, "ok"},
      {BISS_CAUSE_NO_RESPONSE, "no_response"},
      {BISS_CAUSE_NOT_READY, "not_ready"},
      {BISS_CAUSE_RESPONSE_RANGE, "response_range"},
      {BISS_CAUSE_NO_START, "no_start"},
      {BISS_CAUSE_ACK_RANGE, "ack_range"},
      {BISS_CAUSE_TRUNCATED, "truncated"},
      {BISS_CAUSE_CDS, "cds"},
      {BISS_CAUSE_CRC, "crc"},
      {BISS_CAUSE_STOP_BIT, "stop_bit"}};
  EXPECT_EQ(causes.size(), 1U + BISS_CAUSE_STOP_BIT);
  for (const auto& [cause, name] : causes) EXPECT_STREQ(biss_cause_name(cause), name);
  for (const int number : {BISS_CAUSE_STOP_BIT + 1, 99, -1, INT_MAX, INT_MIN}) {
    EXPECT_STREQ(biss_cause_name(static_cast<biss_cause>(number)), "unknown") << number;
  }
}

TEST(CVersion, HeaderAndLibrary_AreOfOneVersion) {
  EXPECT_STREQ(biss_version(), BISS_C_VERSION);
  EXPECT_GE(BISS_C_VERSION_NUMBER, 100);
}

TEST(CEncoders, EachOfTheList_IsAFormat) {
  std::set<std::string> names;
  for (std::size_t i = 0; i < biss_encoder_count(); ++i) {
    ASSERT_NE(biss_encoder_name(i), nullptr);
    EXPECT_EQ(biss_format_problem(biss_encoder_name(i), nullptr), nullptr);
    names.insert(biss_encoder_name(i));
  }
  EXPECT_EQ(names.size(), biss_encoder_count());
  EXPECT_EQ(names.count("resolute-26"), 1U);
  EXPECT_EQ(biss_encoder_name(biss_encoder_count()), nullptr);
}

TEST(CErrors, NullPointers_AreNamedEverywhere) {
  Encoder encoder;
  const biss_slave_setup slave_setup = encoder.setup(format);
  const SlaveHandle slave = open_slave(slave_setup);
  const MasterHandle master = open_master(biss_master_defaults(named(format), period));
  biss_format parsed;
  EXPECT_EQ(biss_format_parse(nullptr, &parsed), BISS_NULL_ARGUMENT);
  EXPECT_EQ(biss_format_parse(format, nullptr), BISS_NULL_ARGUMENT);
  EXPECT_EQ(biss_slave_init(nullptr, &slave_setup), BISS_NULL_ARGUMENT);
  EXPECT_EQ(try_slave(nullptr), BISS_NULL_ARGUMENT);
  EXPECT_EQ(biss_slave_step(slave.get(), 0, true, false, nullptr), BISS_NULL_ARGUMENT);
  EXPECT_EQ(biss_slave_state(nullptr), nullptr);
  EXPECT_EQ(biss_master_init(nullptr, nullptr), BISS_NULL_ARGUMENT);
  EXPECT_EQ(try_master(nullptr), BISS_NULL_ARGUMENT);
  EXPECT_EQ(biss_master_begin(master.get(), 0, true, false, nullptr), BISS_NULL_ARGUMENT);
  EXPECT_EQ(biss_master_step(master.get(), 0, true, nullptr), BISS_NULL_ARGUMENT);
  EXPECT_EQ(biss_master_reading(master.get(), nullptr), BISS_NULL_ARGUMENT);
  EXPECT_TRUE(biss_master_done(nullptr));
}

TEST(CErrors, MemoryThatHadNoInit_IsNamedEverywhere) {
  Encoder encoder;
  const SlaveHandle slave = open_slave(encoder.setup(format));
  const MasterHandle master = open_master(biss_master_defaults(named(format), period));
  biss_output out;
  biss_reading reading;
  const biss_slave copied_slave = *slave;
  EXPECT_EQ(biss_slave_state(&copied_slave), nullptr);
  const biss_master copied_master = *master;
  EXPECT_TRUE(biss_master_done(&copied_master));
  EXPECT_EQ(biss_master_begin(master.get(), 0, true, false, &out), BISS_OK);
  EXPECT_FALSE(biss_master_done(master.get()));
  expect_refusals(slave.get(), [&](biss_slave* s) {
    return std::vector{biss_slave_step(s, 0, true, false, &out)};
  });
  expect_refusals(master.get(), [&](biss_master* m) {
    return std::vector{biss_master_begin(m, 0, true, false, &out),
                       biss_master_step(m, 0, true, &out), biss_master_reading(m, &reading)};
  });
}

TEST(CErrors, InitThatFails_EndsTheObject) {
  Encoder encoder;
  const SlaveHandle slave = open_slave(encoder.setup(format));
  EXPECT_EQ(biss_slave_init(slave.get(), nullptr), BISS_NULL_ARGUMENT);
  EXPECT_EQ(biss_slave_state(slave.get()), nullptr);
  const biss_slave_setup setup = encoder.setup(format);
  EXPECT_EQ(biss_slave_init(slave.get(), &setup), BISS_OK);
  EXPECT_STREQ(biss_slave_state(slave.get()), "idle");
}

TEST(CErrors, SlaveSetup_RefusedByItsCause) {
  Encoder encoder;
  biss_slave_setup setup = encoder.setup(format);
  setup.sample = nullptr;
  EXPECT_EQ(try_slave(&setup), BISS_NULL_ARGUMENT);
  setup = encoder.setup(nullptr);
  EXPECT_EQ(try_slave(&setup), BISS_NULL_ARGUMENT);
  setup = encoder.setup("pos26,crc");
  EXPECT_EQ(try_slave(&setup), BISS_BAD_FORMAT);
  setup = encoder.setup("resolute");
  EXPECT_EQ(try_slave(&setup), BISS_BAD_FORMAT);
  setup = encoder.setup(format);
  setup.ready_ps = -1;
  EXPECT_EQ(try_slave(&setup), BISS_BAD_SETUP);
  setup.ready_ps = 0;
  setup.cds = nullptr;
  setup.cdm = nullptr;
  EXPECT_EQ(try_slave(&setup), BISS_OK);
  setup.register_permits = [](void*, bool, std::uint8_t) { return true; };
  EXPECT_EQ(try_slave(&setup), BISS_NULL_ARGUMENT);
  setup.register_read = [](void*, std::uint8_t) { return 0; };
  setup.register_write = [](void*, std::uint8_t, std::uint8_t) {};
  EXPECT_EQ(try_slave(&setup), BISS_OK);
  // Answers to accesses are in CDS, which is always 0 here.
  setup.format = named("pos26,nE,nW,crc6;cds0");
  EXPECT_EQ(try_slave(&setup), BISS_BAD_SETUP);
}

TEST(CErrors, TimingThatNoDeviceHas_IsRefused) {
  const std::vector<std::function<void(biss_timing&)>> spoilers{
      [](biss_timing& t) { t.start_min_ps = -1; },
      [](biss_timing& t) { t.ack_max_ps = BISS_DURATION_MAX + 1; },
      [](biss_timing& t) { t.ack_clocks = 401; },
      [](biss_timing& t) { t.timeout.rule = 3; },
      [](biss_timing& t) { t.timeout.time_ps = INT64_MIN; },
      [](biss_timing& t) { t.internal_delay_max_ps = -5; },
      [](biss_timing& t) { t.cycle_min_ps = INT64_MAX; },
      [](biss_timing& t) { t.clock_min_hz = t.clock_max_hz + 1; },
      [](biss_timing& t) { t.sampling_min_ps = t.sampling_typical_ps + 1; },
      [](biss_timing& t) { t.sampling_max_ps = t.sampling_typical_ps - 1; }};
  Encoder encoder;
  biss_slave_setup slave_setup = encoder.setup(format);
  biss_master_setup master_setup = biss_master_defaults(named(format), period);
  for (std::size_t i = 0; i < spoilers.size(); ++i) {
    biss_format spoiled = *named("resolute-26");
    slave_setup.format = master_setup.format = &spoiled;
    ASSERT_EQ(try_slave(&slave_setup), BISS_OK);
    ASSERT_EQ(try_master(&master_setup), BISS_OK);
    spoilers[i](spoiled.timing);
    EXPECT_EQ(try_slave(&slave_setup), BISS_BAD_TIMING) << i;
    EXPECT_EQ(try_master(&master_setup), BISS_BAD_TIMING) << i;
  }
}

TEST(CErrors, MasterSetup_RefusedByItsCause) {
  const std::vector<std::function<void(biss_master_setup&)>> spoilers{
      [](biss_master_setup& s) { s.period_ps = 31; },
      [](biss_master_setup& s) { s.period_ps = BISS_DURATION_MAX + 1; },
      [](biss_master_setup& s) { s.low_time_ps = s.period_ps; },
      [](biss_master_setup& s) { s.low_time_ps = -1; },
      [](biss_master_setup& s) { s.slaves = 0; },
      [](biss_master_setup& s) { s.slaves = 9; },
      [](biss_master_setup& s) { s.extra_clocks = 65'536; },
      [](biss_master_setup& s) { s.sample_step_ps = -1; },
      [](biss_master_setup& s) { s.sample_shift_ps = s.period_ps / 2 + 1; },
      [](biss_master_setup& s) { s.sample_shift_ps = -s.period_ps / 2 - 1; },
      [](biss_master_setup& s) { s.line_delay_max_ps = -1; },
      [](biss_master_setup& s) { s.reset_time_ps = -1; },
      [](biss_master_setup& s) { s.idle_min_ps = BISS_DURATION_MAX + 1; }};
  biss_master_setup setup = biss_master_defaults(named(format), period);
  EXPECT_EQ(try_master(&setup), BISS_OK);
  for (std::size_t i = 0; i < spoilers.size(); ++i) {
    setup = biss_master_defaults(named(format), period);
    spoilers[i](setup);
    EXPECT_EQ(try_master(&setup), BISS_BAD_SETUP) << i;
  }
  setup = biss_master_defaults(nullptr, period);
  EXPECT_EQ(try_master(&setup), BISS_NULL_ARGUMENT);
  setup = biss_master_defaults(named(""), period);
  EXPECT_EQ(try_master(&setup), BISS_BAD_FORMAT);
}

TEST(CErrors, MasterForAFormatWithoutErrorFlagOrChecksum_NeedsTheWord) {
  const auto status = [](const char* text, bool no_error_flag, bool unchecked) {
    biss_master_setup setup = biss_master_defaults(named(text), 100'000);
    setup.no_error_flag = no_error_flag;
    setup.unchecked = unchecked;
    return try_master(&setup);
  };
  EXPECT_EQ(status("pos24,crc6", false, true), BISS_NO_ERROR_FLAG);
  EXPECT_EQ(status("pos24,crc6", true, false), BISS_OK);
  EXPECT_EQ(status("pos24,nE,nW", true, false), BISS_NO_CRC);
  EXPECT_EQ(status("pos24,nE,nW", false, true), BISS_OK);
  EXPECT_EQ(status("pos24", true, true), BISS_OK);
}

TEST(CErrors, MasterAboveTheClockOfTheEncoder_IsRefused) {
  biss_master_setup setup = biss_master_defaults(named("resolute-26"), 100'000);
  EXPECT_EQ(try_master(&setup), BISS_OK);
  setup.period_ps = 99'999;
  EXPECT_EQ(try_master(&setup), BISS_CLOCK_MAX);
  setup.period_ps = 100'000;
  biss_format slower = *named("resolute-26");
  slower.timing.clock_max_hz = 5'000'000;
  setup.format = &slower;
  EXPECT_EQ(try_master(&setup), BISS_CLOCK_MAX);
}

TEST(CErrors, TimeThatRunsBackwards_ChangesNothing) {
  Encoder encoder;
  const SlaveHandle slave = open_slave(encoder.setup(format));
  const MasterHandle master = open_master(biss_master_defaults(named(format), period));
  biss_output out{};
  EXPECT_EQ(biss_slave_step(slave.get(), 100, false, false, &out), BISS_OK);
  EXPECT_EQ(biss_slave_step(slave.get(), 99, true, false, &out), BISS_TIME_BACKWARDS);
  EXPECT_EQ(biss_slave_step(slave.get(), BISS_TIME_MAX + 1, true, false, &out), BISS_TIME_RANGE);
  EXPECT_STREQ(biss_slave_state(slave.get()), "requested");
  EXPECT_EQ(biss_slave_step(slave.get(), 100, true, false, &out), BISS_OK);
  EXPECT_STREQ(biss_slave_state(slave.get()), "latched");
  EXPECT_EQ(biss_master_begin(master.get(), -BISS_TIME_MAX - 1, true, false, &out),
            BISS_TIME_RANGE);
  EXPECT_EQ(biss_master_begin(master.get(), 5, true, false, &out), BISS_OK);
  EXPECT_EQ(biss_master_step(master.get(), 4, true, &out), BISS_TIME_BACKWARDS);
  EXPECT_EQ(biss_master_step(master.get(), INT64_MAX, true, &out), BISS_TIME_RANGE);
}

TEST(CErrors, Requests_RefusedWhileOneRunsAndWhileTheEncoderIsNotReady) {
  const MasterHandle master = open_master(biss_master_defaults(named(format), period));
  biss_output out{};
  biss_reading reading;
  EXPECT_EQ(biss_master_reading(master.get(), &reading), BISS_NO_READING);
  EXPECT_EQ(biss_master_begin(master.get(), 0, false, false, &out), BISS_SLO_LOW);
  EXPECT_TRUE(out.level);
  EXPECT_EQ(out.deadline_ps, BISS_NEVER);
  ASSERT_EQ(biss_master_reading(master.get(), &reading), BISS_OK);
  EXPECT_EQ(reading.cause, BISS_CAUSE_NOT_READY);
  EXPECT_EQ(biss_master_begin(master.get(), 10, true, false, &out), BISS_OK);
  EXPECT_EQ(biss_master_begin(master.get(), 20, true, false, &out), BISS_RUNNING);
  EXPECT_EQ(biss_master_reading(master.get(), &reading), BISS_RUNNING);
  std::int64_t now = 10;
  while (!biss_master_done(master.get())) {
    now = out.deadline_ps;
    ASSERT_EQ(biss_master_step(master.get(), now, true, &out), BISS_OK);
  }
  ASSERT_EQ(biss_master_reading(master.get(), &reading), BISS_OK);
  EXPECT_EQ(reading.cause, BISS_CAUSE_NO_RESPONSE);
  EXPECT_FALSE(reading.line_delay_measured);
  EXPECT_EQ(reading.channel_count, 0U);
}

TEST(CErrors, RequestBeforeTheShortestCycle_IsTooEarly) {
  biss_format slow = *named(format);
  slow.timing.cycle_min_ps = 500 * period;
  Encoder encoder;
  encoder.says.resize(1, {1, 0, true, true});
  const SlaveHandle slave = open_slave(encoder.setup(format));
  const MasterHandle master = open_master(biss_master_defaults(&slow, period));
  Line line(slave.get(), master.get());
  line.request(false);
  biss_output out{};
  EXPECT_EQ(biss_master_begin(master.get(), line.now(), true, false, &out), BISS_TOO_EARLY);
  EXPECT_EQ(out.deadline_ps, 500 * period);
  EXPECT_EQ(biss_master_begin(master.get(), out.deadline_ps, true, false, &out), BISS_OK);
}

TEST(CErrors, ValueWiderThanItsField_IsToldAndSentAsNoData) {
  for (const biss_channel& wide :
       {biss_channel{1ULL << 26U, 0, true, true}, biss_channel{1, 64, true, true}}) {
    Encoder encoder{.says = {wide}};
    const SlaveHandle slave = open_slave(encoder.setup("pos26,nE,nW,lc6,crc6"));
    const MasterHandle master =
        open_master(biss_master_defaults(named("pos26,nE,nW,lc6,crc6"), period));
    Line line(slave.get(), master.get());
    EXPECT_EQ(line.request(false), BISS_VALUE_RANGE);
    EXPECT_EQ(line.reading().cause, BISS_CAUSE_OK);
    EXPECT_EQ(line.reading().channels[0].position, 0U);
    EXPECT_FALSE(line.reading().channels[0].nE);
    EXPECT_FALSE(line.reading().channels[0].nW);
    encoder.says[0] = {1, 63, true, true};
    EXPECT_EQ(line.request(false), BISS_OK);
    EXPECT_TRUE(line.reading().channels[0].nE);
    EXPECT_EQ(line.reading().channels[0].life_counter, 63U);
  }
}

// Calls its own slave from the callback.
struct Meddler {
  biss_slave* slave = nullptr;
  biss_status status = BISS_OK;

  static void sample(void* user, std::int64_t moment, biss_channel*, std::size_t) {
    auto& self = *static_cast<Meddler*>(user);
    biss_output out;
    self.status = biss_slave_step(self.slave, moment, true, false, &out);
  }
};

TEST(CErrors, StepFromItsOwnCallback_IsRefused) {
  Meddler meddler;
  biss_slave_setup setup = biss_slave_defaults(named(format));
  setup.sample = &Meddler::sample;
  setup.user = &meddler;
  const SlaveHandle slave = open_slave(setup);
  meddler.slave = slave.get();
  biss_output out{};
  EXPECT_EQ(biss_slave_step(slave.get(), 0, false, false, &out), BISS_OK);
  EXPECT_EQ(biss_slave_step(slave.get(), 1'000, true, false, &out), BISS_OK);
  EXPECT_EQ(meddler.status, BISS_REENTERED);
  EXPECT_STREQ(biss_slave_state(slave.get()), "latched");
}

}  // namespace errors_test
}  // namespace biss::capi
