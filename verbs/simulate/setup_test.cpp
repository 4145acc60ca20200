#include "verbs/simulate/setup.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace biss::verbs {
namespace setup_test {

LineOptions line_of(const std::string& format) {
  LineOptions line;
  line.device.format = format;
  return line;
}

sim::LineSetup chosen(const LineOptions& options) {
  const auto setup = line_setup(options);
  EXPECT_TRUE(setup.has_value()) << setup.error();
  return setup.value_or(sim::LineSetup{});
}

std::string error_of(const LineOptions& options) {
  const auto setup = line_setup(options);
  return setup ? "" : setup.error();
}

TEST(LineOptions, DelaysOfEachLine_ReplaceHalfOfTheCable) {
  LineOptions options = line_of("resolute-26");
  options.cable = metres(20);
  EXPECT_EQ(chosen(options).ma_delay, nanoseconds(100));
  EXPECT_EQ(chosen(options).slo_delay, nanoseconds(100));
  EXPECT_EQ(chosen(options).internal_delay, picoseconds(42'500));
  options.slo_delay = nanoseconds(7);
  EXPECT_EQ(chosen(options).ma_delay, nanoseconds(100));
  EXPECT_EQ(chosen(options).slo_delay, nanoseconds(7));
  options.ma_delay = Picoseconds{};
  options.internal_delay = nanoseconds(1);
  EXPECT_EQ(chosen(options).ma_delay, Picoseconds{});
  EXPECT_EQ(chosen(options).internal_delay, nanoseconds(1));
  options.ma_delay = microseconds(40);
  EXPECT_EQ(error_of(options), "--cable: the line delay is 40.008 us; BiSS C allows at most 40 us");
}

TEST(LineOptions, JitterOfEachLine_ReplacesThatOfBoth) {
  LineOptions options = line_of("resolute-26");
  options.cable = metres(2);
  options.jitter = nanoseconds(3);
  EXPECT_EQ(chosen(options).ma_jitter, nanoseconds(3));
  EXPECT_EQ(chosen(options).slo_jitter, nanoseconds(3));
  options.slo_jitter = nanoseconds(50);
  EXPECT_EQ(chosen(options).ma_jitter, nanoseconds(3));
  EXPECT_EQ(chosen(options).slo_jitter, nanoseconds(50));
  options.ma_jitter = Picoseconds{};
  EXPECT_EQ(chosen(options).ma_jitter, Picoseconds{});
}

TEST(LineOptions, JitterLongerThanTheDelay_IsRefused) {
  LineOptions options = line_of("resolute-26");
  options.jitter = nanoseconds(3);
  EXPECT_EQ(
      error_of(options),
      "--jitter: the delay of MA is 0 s, so its edges cannot come 3 ns earlier; give a longer "
      "--cable or less jitter");
  options.ma_jitter = Picoseconds{};
  EXPECT_EQ(error_of(options), "");
  options.slo_jitter = nanoseconds(43);
  EXPECT_EQ(error_of(options),
            "--jitter: the delay of SLO is 42.5 ns, so its edges cannot come 43 ns earlier; give a "
            "longer --cable or less jitter");
}

TEST(LineOptions, OptionsOfWhatTheFormatDoesNotHave_AreRefused) {
  LineOptions options = line_of("pos26,crc6");
  options.faults = {"nE@2"};
  EXPECT_EQ(error_of(options), "--fault: nE: the format has no error bit (nE or E)");
  options.faults = {"nW:0.1"};
  EXPECT_EQ(error_of(options), "--fault: nW: the format has no warning bit (nW or W)");
  options.device.format = "pos26,E,W,crc6";
  options.faults = {"nE@2", "nW:0.1"};
  EXPECT_EQ(chosen(options).faults.size(), 2U);

  options = line_of("resolute-26");
  options.counter_start = {60};
  EXPECT_EQ(error_of(options), "--counter-start: the format has no counter (lcN)");
  options.device.format = "fs-36-28";
  EXPECT_EQ(chosen(options).life.starts[1], 60);

  options = line_of("pos26,nE,nW,crc6+pos26,nE,nW,crc6");
  options.drift = 16;
  EXPECT_EQ(chosen(options).drift, 16);
  options.setup.slaves = 2;
  EXPECT_EQ(error_of(options), "--drift: no encoder has a further word that could drift");
}

TEST(LineOptions, ProcessingThatTheEncoderCannotHave_IsRefused) {
  LineOptions options = line_of("resolute-26");
  options.setup.clock = megahertz(10);
  options.processing = microseconds(16);
  EXPECT_EQ(chosen(options).processing, microseconds(16));
  EXPECT_EQ(wrong_start(chosen(options)), "");
  options.processing = microseconds(20);
  EXPECT_EQ(error_of(options),
            "--processing: this encoder takes at most 16 us; --ack-max sets another limit");
  options.device.ack_max = "20us";
  EXPECT_EQ(chosen(options).processing, microseconds(20));
  options.processing = microseconds(1);
  EXPECT_EQ(wrong_start(chosen(options)),
            "--processing: at 10 MHz this encoder takes at least 3.15 us");
  options = line_of("lenz-b3");
  options.processing = microseconds(5);
  EXPECT_EQ(error_of(options), "--processing: ACK of this encoder has a fixed length of 4 clocks");
}

TEST(LineOptions, AckThatEndsBeforeThePositionIsTaken_IsRefused) {
  LineOptions options = line_of("resolute-26");
  options.setup.clock = megahertz(5);
  options.device.ack_clocks = "15";
  EXPECT_EQ(wrong_start(chosen(options)),
            "--ack-clocks: at 5 MHz this encoder answers after 16 clocks at the earliest; it takes "
            "its position 3.25 us after LAT");
  options.device.ack_clocks = "16";
  EXPECT_EQ(wrong_start(chosen(options)), "");
  options = line_of("pos26,nE,nW,crc6");
  options.device.ack_clocks = "1";
  EXPECT_EQ(wrong_start(chosen(options)), "");
}

TEST(RegisterBusy, FramesAndTimes_AreRead) {
  RegisterBusy busy;
  EXPECT_EQ(read_busy("12", microseconds(100), busy), "");
  EXPECT_EQ(busy.read_frames, 12);
  EXPECT_EQ(busy.write_frames, 12);
  EXPECT_EQ(read_busy("250us", microseconds(100), busy), "");
  EXPECT_EQ(busy.read_frames, 3);
  EXPECT_EQ(read_busy("0", microseconds(100), busy), "");
  EXPECT_EQ(busy.read_frames, 0);
  EXPECT_THAT(read_busy("65536", microseconds(100), busy), testing::HasSubstr("'65536'"));
  EXPECT_THAT(read_busy("often", microseconds(100), busy), testing::HasSubstr("'often'"));
  EXPECT_THAT(read_busy("7s", microseconds(100), busy), testing::HasSubstr("70000 frames"));
}

}  // namespace setup_test
}  // namespace biss::verbs
