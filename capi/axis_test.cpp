// An axis in C: its positions, causes and refusals.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

#include "biss/axis/cause.hpp"
#include "capi/biss_c_axis.h"
#include "capi/test_handles.hpp"

namespace biss::capi {
namespace axis_test {

constexpr std::int64_t cycle_ps = 100'000'000;

// An SPI whose transfer ends when the test says so.
struct Bench {
  biss_spi spi{};
  biss_codec codec{};
  biss_axis axis{};
  std::uint8_t* bytes = nullptr;
  std::size_t count = 0;
  bool busy = false;
  std::int64_t now_ps = 0;

  explicit Bench(const char* format = "resolute-26") {
    biss_spi_setup setup = biss_spi_defaults(named(format), 100'000);
    setup.line_delay_max_ps = 700'000;
    EXPECT_EQ(biss_spi_init(&spi, &setup), BISS_OK);
    EXPECT_EQ(biss_codec_init(&codec, named(format)), BISS_OK);
  }
  biss_axis_setup setup() {
    biss_axis_setup chosen = biss_axis_defaults(&spi, cycle_ps, 1'000'000);
    chosen.user = this;
    chosen.start = [](void* user, std::uint8_t* into, std::size_t size) {
      auto& bench = *static_cast<Bench*>(user);
      if (bench.busy) return false;
      bench.bytes = into;
      bench.count = size;
      return bench.busy = true;
    };
    return chosen;
  }
  biss_axis_position get() const {
    biss_axis_position position{};
    EXPECT_EQ(biss_axis_get(&axis, &position), BISS_OK);
    return position;
  }
  void request() { EXPECT_EQ(biss_axis_request(&axis, now_ps += cycle_ps), BISS_OK); }
  biss_axis_position good(std::uint64_t position) {
    request();
    biss_frame frame;
    biss_frame_defaults(&codec, &frame);
    frame.lead_clocks = 3;
    frame.ack_clocks = 40;
    frame.channels[0].position = position;
    std::size_t bits = 0;
    std::array<std::uint8_t, BISS_FRAME_BYTES_MAX> line{};
    EXPECT_EQ(biss_frame_encode(&codec, &frame, line.data(), line.size(), &bits), BISS_OK);
    std::copy_n(line.begin(), count, bytes);
    busy = false;
    EXPECT_EQ(biss_axis_complete(&axis), BISS_OK);
    return get();
  }
};

TEST(CAxis, GoodFrames_ArePositionsAndBadCyclesHaveTheirCause) {
  Bench b;
  const biss_axis_setup setup = b.setup();
  ASSERT_EQ(biss_axis_init(&b.axis, &setup), BISS_OK);
  EXPECT_EQ(b.get().state, BISS_AXIS_NO_POSITION);
  EXPECT_EQ(b.good(1000).cause, BISS_AXIS_FIRST);
  biss_axis_position now = b.good(1100);
  EXPECT_EQ(now.state, BISS_AXIS_MEASURED);
  EXPECT_EQ(now.position, 1100);
  EXPECT_EQ(now.uncertainty, 0);
  EXPECT_EQ(now.number, 2U);
  EXPECT_EQ(now.moment_ps, 2 * cycle_ps + 50'000 + 3'250'000);
  EXPECT_TRUE(now.usable);
  b.request();
  b.busy = false;
  EXPECT_EQ(biss_axis_complete(&b.axis), BISS_OK);  // nothing was written
  now = b.get();
  EXPECT_EQ(now.state, BISS_AXIS_EXTRAPOLATED);
  EXPECT_EQ(now.cause, BISS_AXIS_NO_RESPONSE);
  EXPECT_EQ(now.position, 1200);
  EXPECT_EQ(now.uncertainty, 1'000'100);
  b.request();
  b.busy = false;
  EXPECT_EQ(biss_axis_failed(&b.axis), BISS_OK);
  EXPECT_EQ(b.get().cause, BISS_AXIS_FAILED);
  EXPECT_EQ(biss_axis_count(&b.axis, BISS_AXIS_FAILED), 1U);
  EXPECT_EQ(biss_axis_count(&b.axis, static_cast<biss_axis_cause>(99)), 0U);
  EXPECT_EQ(biss_axis_set_turns(&b.axis, -2), BISS_OK);
  EXPECT_EQ(b.good(1400).position, 1400 - (2 << 26));
  EXPECT_EQ(biss_axis_set_turns(&b.axis, INT64_MAX), BISS_VALUE_RANGE);
  EXPECT_EQ(biss_axis_trip(&b.axis), BISS_OK);
  EXPECT_EQ(b.get().state, BISS_AXIS_STOPPED);
  EXPECT_FALSE(b.get().usable);
  EXPECT_EQ(biss_axis_reset(&b.axis), BISS_OK);
  EXPECT_EQ(biss_axis_set_turns(&b.axis, 1), BISS_NO_READING);
  EXPECT_EQ(biss_axis_complete(&b.axis), BISS_OK);
  EXPECT_EQ(biss_axis_count(&b.axis, BISS_AXIS_UNEXPECTED), 1U);
}

TEST(CAxis, SetupThatCannotWork_HasItsStatus) {
  Bench b;
  const auto status = [&b](auto change) {
    biss_axis_setup setup = b.setup();
    change(setup);
    const biss_status result = biss_axis_init(&b.axis, &setup);
    biss_axis_position unused;
    EXPECT_EQ(biss_axis_get(&b.axis, &unused), result == BISS_OK ? BISS_OK : BISS_BAD_HANDLE);
    return result;
  };
  using Setup = biss_axis_setup;
  EXPECT_EQ(status([](Setup&) {}), BISS_OK);
  EXPECT_EQ(status([](Setup& s) { s.spi = nullptr; }), BISS_NULL_ARGUMENT);
  EXPECT_EQ(status([](Setup& s) { s.start = nullptr; }), BISS_NULL_ARGUMENT);
  EXPECT_EQ(status([](Setup& s) { s.cycle_ps = 0; }), BISS_BAD_SETUP);
  EXPECT_EQ(status([](Setup& s) { s.max_step = 0; }), BISS_BAD_SETUP);
  EXPECT_EQ(status([](Setup& s) { s.max_step = 1 << 25; }), BISS_BAD_SETUP);
  EXPECT_EQ(status([](Setup& s) { s.max_step = BISS_NO_STEP_LIMIT; }), BISS_OK);
  EXPECT_EQ(status([](Setup& s) { s.trip_after = 65'536; }), BISS_BAD_SETUP);
  EXPECT_EQ(status([](Setup& s) { s.power_up_ps = -1; }), BISS_BAD_SETUP);
  EXPECT_EQ(status([](Setup& s) { s.offset = INT64_MIN; }), BISS_BAD_SETUP);
  EXPECT_EQ(status([](Setup& s) { s.bad_cycles = static_cast<biss_bad_cycle_rule>(3); }),
            BISS_BAD_SETUP);
  EXPECT_EQ(status([](Setup& s) { s.warnings = static_cast<biss_warning_rule>(-1); }),
            BISS_BAD_SETUP);
  const biss_spi never{};
  EXPECT_EQ(status([&never](Setup& s) { s.spi = &never; }), BISS_BAD_HANDLE);
  Bench two("pos24,nE,nW,crc6+pos12,nE,nW,crc6");
  EXPECT_EQ(status([&two](Setup& s) { s.spi = &two.spi; }), BISS_BAD_FORMAT);
  EXPECT_EQ(biss_axis_init(&b.axis, nullptr), BISS_NULL_ARGUMENT);
  EXPECT_EQ(biss_axis_request(nullptr, 0), BISS_NULL_ARGUMENT);
  EXPECT_EQ(biss_axis_count(&b.axis, BISS_AXIS_OK), 0U);
}

TEST(CAxis, EveryCause_HasTheNameOfTheCore) {
  for (std::size_t i = 0; i < axis_cause_count; ++i) {
    EXPECT_EQ(biss_axis_cause_name(static_cast<biss_axis_cause>(i)),
              name_of(static_cast<AxisCause>(i)));
  }
  EXPECT_STREQ(biss_axis_cause_name(static_cast<biss_axis_cause>(-1)), "unknown");
}

}  // namespace axis_test
}  // namespace biss::capi
