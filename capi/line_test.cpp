// The simulated far end of a line through the C interface.
#include <gtest/gtest.h>

#include <functional>
#include <set>
#include <string>
#include <vector>

#include "capi/test_handles.hpp"

namespace biss::capi {
namespace line_test {

constexpr const char* format = "pos26,nE,nW,crc6";
constexpr std::uint32_t clock_hz = 5'000'000;
constexpr std::int64_t period = 200'000;
constexpr std::int64_t interval = LineReader::interval;

const biss_master_setup master_setup = biss_master_defaults(named(format), period);

biss_line_setup line_setup() {
  biss_line_setup setup = biss_line_defaults(named(format), clock_hz);
  setup.interval_ps = interval;
  setup.ma_delay_ps = 130'000;
  setup.slo_delay_ps = 170'000;
  setup.internal_delay_ps = 42'000;
  setup.ready_min_ps = setup.ready_max_ps = 3'000'000;
  return setup;
}

TEST(CLine, PositionsThatWereSent_AreRead) {
  const LineHandle line = open_line(line_setup());
  LineReader reader(line.get(), master_setup);
  std::set<std::uint64_t> positions;
  for (unsigned i = 0; i < 20; ++i) {
    const biss_reading reading = reader.request();
    const biss_line_request truth = reader.truth();
    ASSERT_EQ(reading.cause, BISS_CAUSE_OK);
    EXPECT_EQ(reading.line_delay_ps, 342'000);
    EXPECT_EQ(truth.number, i);
    EXPECT_EQ(truth.begin_ps, reading.begin_ps);
    ASSERT_TRUE(truth.sampled);
    EXPECT_EQ(truth.channel_count, 1U);
    EXPECT_EQ(truth.channels[0].position, reading.channels[0].position);
    EXPECT_EQ(truth.faults, 0U);
    positions.insert(truth.channels[0].position);
  }
  EXPECT_EQ(positions.size(), 20U);
  EXPECT_STREQ(biss_line_state(line.get()), "idle");
}

// Each kind by its name, and the bit that reports it.
TEST(CLine, EachKindOfFault_IsInjectedByName) {
  EXPECT_EQ(biss_fault_count(), 33U);
  EXPECT_EQ(biss_fault_name(33), nullptr);
  EXPECT_EQ(biss_fault_effect(33), nullptr);
  for (std::size_t kind = 0; kind < biss_fault_count(); ++kind) {
    const std::string rule = std::string(biss_fault_name(kind)) + "@3";
    EXPECT_NE(biss_fault_effect(kind), nullptr);
    biss_line_setup setup = line_setup();
    setup.faults = rule.c_str();
    const LineHandle line = open_line(setup);
    LineReader reader(line.get(), master_setup);
    for (unsigned i = 0; i < 3; ++i) {
      ASSERT_EQ(reader.request().cause, BISS_CAUSE_OK) << rule;
      ASSERT_EQ(reader.truth().faults, 0U) << rule;
    }
    reader.request();
    if (rule.find("_idle") == std::string::npos) {
      EXPECT_EQ(reader.truth().faults, std::uint64_t{1} << kind) << rule;
    }
    if (rule == "delay@3") {
      EXPECT_GE(reader.truth().late_ps, interval);
    }
  }
}

TEST(CLine, FlippedBit_IsReportedWithItsPlace) {
  biss_line_setup setup = line_setup();
  setup.faults = "flip@1,bit=7 nW@2";
  const LineHandle line = open_line(setup);
  LineReader reader(line.get(), master_setup);
  EXPECT_EQ(reader.request().cause, BISS_CAUSE_OK);
  EXPECT_EQ(reader.request().cause, BISS_CAUSE_CRC);
  const biss_line_request truth = reader.truth();
  ASSERT_EQ(truth.place_count, 1U);
  EXPECT_STREQ(biss_fault_name(truth.places[0].kind), "flip");
  EXPECT_TRUE(truth.places[0].is_bit);
  EXPECT_EQ(truth.places[0].thousandths, 7'000U);
  const biss_reading reading = reader.request();
  EXPECT_EQ(reading.cause, BISS_CAUSE_OK);
  EXPECT_FALSE(reading.channels[0].nW);
}

TEST(CLine, AckAndFilter_ShowInTheReading) {
  biss_line_setup setup = line_setup();
  setup.ready_max_ps = 6'000'000;
  setup.ma_filter_ps = 25'000;
  const LineHandle line = open_line(setup);
  LineReader reader(line.get(), master_setup);
  std::set<std::uint32_t> acks;
  for (int i = 0; i < 40; ++i) {
    const biss_reading reading = reader.request();
    ASSERT_EQ(reading.cause, BISS_CAUSE_OK);
    EXPECT_EQ(reading.line_delay_ps, 367'000);
    acks.insert(reading.ack_clocks);
  }
  EXPECT_GE(acks.size(), 10U);
}

TEST(CLine, PositionOfTheCaller_IsSentOrRefused) {
  std::uint64_t position = 4711;
  biss_line_setup setup = line_setup();
  setup.user = &position;
  setup.position = [](void* user, std::int64_t) { return *static_cast<std::uint64_t*>(user); };
  const LineHandle line = open_line(setup);
  LineReader reader(line.get(), master_setup);
  EXPECT_EQ(reader.request().channels[0].position, 4711U);
  EXPECT_EQ(biss_line_set_flags(line.get(), true, false), BISS_OK);
  EXPECT_FALSE(reader.request().channels[0].nW);
  EXPECT_EQ(reader.worst(), BISS_OK);
  position = std::uint64_t{1} << 26U;
  const biss_reading reading = reader.request();
  EXPECT_EQ(reader.worst(), BISS_VALUE_RANGE);
  EXPECT_EQ(reading.channels[0].position, 0U);
  EXPECT_FALSE(reading.channels[0].nE);
}

TEST(CLine, Registers_AreThereAsTheyWerePut) {
  biss_line_setup setup = line_setup();
  setup.registers = true;
  const LineHandle line = open_line(setup);
  std::uint8_t value = 0;
  EXPECT_EQ(biss_line_put_register(line.get(), 3, 0x3F, 0x11, true), BISS_OK);
  EXPECT_EQ(biss_line_put_register(line.get(), 999, 0x7F, 0x22, false), BISS_OK);
  EXPECT_EQ(biss_line_put_register(line.get(), 0, 0x40, 3, true), BISS_OK);
  EXPECT_EQ(biss_line_register(line.get(), 3, 0x3F, &value), BISS_OK);
  EXPECT_EQ(value, 0x11);
  EXPECT_EQ(biss_line_register(line.get(), 0, 0x7F, &value), BISS_OK);
  EXPECT_EQ(value, 0x22);
  EXPECT_EQ(biss_line_register(line.get(), 0, 0x40, &value), BISS_OK);
  EXPECT_EQ(value, 3);
  EXPECT_EQ(biss_line_put_register(line.get(), 256, 0x3F, 0, true), BISS_NO_REGISTER);
  EXPECT_EQ(biss_line_put_register(line.get(), 0, 0x80, 0, true), BISS_NO_REGISTER);
  EXPECT_EQ(biss_line_register(line.get(), 0, 0x80, &value), BISS_NO_REGISTER);
  const LineHandle without = open_line(line_setup());
  EXPECT_EQ(biss_line_put_register(without.get(), 0, 0x48, 0, true), BISS_NO_REGISTER);
  EXPECT_EQ(biss_line_register(without.get(), 0, 0x48, &value), BISS_NO_REGISTER);
}

TEST(CLine, Setup_RefusedByItsCause) {
  const auto status = [](const std::function<void(biss_line_setup&)>& change) {
    biss_line_setup setup = line_setup();
    change(setup);
    biss_line line;
    const biss_status result = biss_line_init(&line, &setup);
    EXPECT_EQ(biss_line_set_flags(&line, true, true) == BISS_BAD_HANDLE, result != BISS_OK);
    biss_line_close(&line);
    return result;
  };
  using S = biss_line_setup;
  EXPECT_EQ(status([](S& s) { s.format = nullptr; }), BISS_NULL_ARGUMENT);
  EXPECT_EQ(status([](S& s) { s.format = named("pos"); }), BISS_BAD_FORMAT);
  biss_format wrong = *named(format);
  wrong.timing.timeout.rule = 7;
  EXPECT_EQ(status([&](S& s) { s.format = &wrong; }), BISS_BAD_TIMING);
  const std::vector<std::function<void(S&)>> spoilers{
      [](S& s) { s.clock_hz = 999; },
      [](S& s) { s.clock_hz = 100'000'001; },
      [](S& s) { s.interval_ps = -1; },
      [](S& s) { s.ma_delay_ps = 41'000'000; },
      [](S& s) { s.ma_filter_ps = 39'900'000; },
      [](S& s) { s.ma_jitter_ps = s.ma_delay_ps + 1; },
      [](S& s) { s.slo_jitter_ps = 212'001; },
      [](S& s) { s.ready_min_ps = s.ready_max_ps + 1; },
      [](S& s) { s.motion = "round"; },
      [](S& s) { s.counter_first = 2; },
      [](S& s) { s.counter_start = 0; },
      [](S& s) { s.counter_start = 64; },
      [](S& s) { s.register_busy_frames = 65'536; },
      [](S& s) { s.format = named("pos8,crc5;cds0"), s.registers = true; },
      [](S& s) { s.foreign_encoder = s.registers = true; },
      [](S& s) {
        s.foreign_encoder = true;
        s.position = [](void*, std::int64_t) { return std::uint64_t{0}; };
      }};
  for (std::size_t i = 0; i < spoilers.size(); ++i)
    EXPECT_EQ(status(spoilers[i]), BISS_BAD_SETUP) << i;
  EXPECT_EQ(status([](S& s) { s.motion = "sine"; }), BISS_OK);
  biss_line line;
  EXPECT_EQ(biss_line_init(nullptr, nullptr), BISS_NULL_ARGUMENT);
  EXPECT_EQ(biss_line_init(&line, nullptr), BISS_NULL_ARGUMENT);
}

TEST(CLine, FaultRules_RefusedByTheirCauseAndPlace) {
  struct Case {
    const char* faults;
    bool foreign;
    biss_status status;
    std::size_t at;
  };
  for (const Case& each :
       {Case{"", false, BISS_OK, 0}, Case{"  flip:0.5   cut@7 ", false, BISS_OK, 0},
        Case{"\tflip:1.0\n\tcut@7\r\n", false, BISS_OK, 0},
        Case{"flip:0.5 cut", false, BISS_FAULT_RULE, 9},
        Case{"flip:0.5 cut@1,bit=", false, BISS_FAULT_RULE, 9},
        Case{"flop@1", false, BISS_FAULT_KIND, 0},
        Case{"cut@1 gap_low@1", false, BISS_FAULT_KIND, 6},
        Case{"cut@1 flip@1", true, BISS_FAULT_KIND, 6},
        Case{"cut@1 glitch_slo@2", true, BISS_OK, 0},
        Case{"flip@1,bit=34", false, BISS_FAULT_PLACE, 0},
        Case{"cut@1 nE@1,bit=3", false, BISS_FAULT_PLACE, 6},
        Case{"flip@1 flip:0.1 flip@1", false, BISS_FAULT_TWICE, 16}}) {
    biss_line_setup setup = line_setup();
    setup.faults = each.faults;
    setup.foreign_encoder = each.foreign;
    biss_line line;
    EXPECT_EQ(biss_line_init(&line, &setup), each.status) << each.faults;
    EXPECT_EQ(biss_line_fault_at(&setup), each.at) << each.faults;
    EXPECT_EQ(biss_line_state(&line) == nullptr, each.foreign || each.status != BISS_OK);
    biss_line_close(&line);
  }
  EXPECT_EQ(biss_line_fault_at(nullptr), 0U);
}

TEST(CLine, CallsInTheWrongPlace_AreRefused) {
  biss_line_output out;
  biss_line_request request;
  std::uint8_t value = 0;
  const auto every = [&](biss_line* line) {
    return std::vector<biss_status>{
        biss_line_step(line, 0, true, true, &out), biss_line_set_flags(line, true, true),
        biss_line_request_of(line, &request), biss_line_put_register(line, 0, 0x48, 0, true),
        biss_line_register(line, 0, 0x48, &value)};
  };
  const LineHandle line = open_line(line_setup());
  EXPECT_EQ(biss_line_request_of(line.get(), &request), BISS_NO_READING);
  EXPECT_EQ(biss_line_step(line.get(), 0, true, true, nullptr), BISS_NULL_ARGUMENT);
  EXPECT_EQ(biss_line_request_of(line.get(), nullptr), BISS_NULL_ARGUMENT);
  EXPECT_EQ(biss_line_register(line.get(), 0, 0x48, nullptr), BISS_NULL_ARGUMENT);
  EXPECT_EQ(biss_line_step(line.get(), 10, true, true, &out), BISS_OK);
  EXPECT_EQ(biss_line_step(line.get(), 9, true, true, &out), BISS_TIME_BACKWARDS);
  EXPECT_EQ(biss_line_step(line.get(), INT64_MAX, true, true, &out), BISS_TIME_RANGE);
  biss_line copy = *line;
  biss_line_close(&copy);
  EXPECT_EQ(biss_line_step(line.get(), 11, true, true, &out), BISS_OK);
  biss_line_close(line.get());
  EXPECT_EQ(biss_line_state(line.get()), nullptr);
  expect_refusals(line.get(), every);
}

// A callback that calls its own line.
struct Caller {
  biss_line* line = nullptr;
  biss_status status = BISS_OK;
};

TEST(CLine, StepFromItsOwnCallback_IsRefused) {
  Caller caller;
  biss_line_setup setup = line_setup();
  setup.user = &caller;
  setup.position = [](void* user, std::int64_t moment) -> std::uint64_t {
    auto& self = *static_cast<Caller*>(user);
    biss_line_output out;
    self.status = biss_line_step(self.line, moment, true, true, &out);
    return 0;
  };
  const LineHandle line = open_line(setup);
  caller.line = line.get();
  LineReader reader(line.get(), master_setup);
  EXPECT_EQ(reader.request().cause, BISS_CAUSE_OK);
  EXPECT_EQ(caller.status, BISS_REENTERED);
}

}  // namespace line_test
}  // namespace biss::capi
