#include "live/virtual_encoder.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "live/virtual_bench.hpp"
#include "sim/fault_text.hpp"

namespace biss::live {
namespace virtual_encoder_test {

using testing::HasSubstr;
using testing::StartsWith;

// A bench whose requests are one letter each: `+` read, `!` a good frame without trust, `-` not.
class Commands : public testing::Test {
 protected:
  Commands() { bench.set(SPI_IOC_WR_MODE, std::uint8_t{SPI_MODE_3}); }

  std::string ask(std::string_view line) { return bench.encoder.command(line, bench.bus.time()); }
  std::string read() { return bench.position(bench.exchange(std::vector<std::uint8_t>(12, 0xFF))); }

  VirtualBench bench;
};

TEST_F(Commands, FaultNext_DamagesOneRequest) {
  const std::string good = read();
  EXPECT_EQ(ask("fault cut@next,clock=2"), "ok fault cut@1,clock=2");
  EXPECT_EQ(read(), "no_response");
  for (int i = 0; i < 6; ++i) read();
  ask("fault flip@next,bit=3");
  EXPECT_EQ(read(), "crc");
  EXPECT_THAT(read(), testing::MatchesRegex("[0-9]+"));
  bench.encoder.finish(bench.bus.time());
  ASSERT_EQ(bench.requests.size(), 10U);
  EXPECT_EQ(sim::text_of(bench.requests[1].faults), "cut");
  EXPECT_EQ(sim::text_of(bench.requests[8].faults), "flip");
  EXPECT_EQ(bench.requests[8].injected[0].place.whole(), 3U);
  EXPECT_EQ(bench.requests[9].faults, 0U);
  EXPECT_EQ(good, std::to_string(bench.requests[0].sent.channel_list[0].position));
}

TEST_F(Commands, FaultRate_LastsUntilOff) {
  EXPECT_EQ(ask("fault flip:1"), "ok fault flip:1");
  for (int i = 0; i < 3; ++i) EXPECT_EQ(read(), "crc");
  EXPECT_EQ(ask("fault off"), "ok no faults");
  EXPECT_THAT(read(), testing::MatchesRegex("[0-9]+"));
  EXPECT_THAT(ask("status"), HasSubstr(R"("requests":4,"faults":3,)"));
  EXPECT_THAT(ask("status"), HasSubstr(R"("last_cause":"flip")"));
}

TEST_F(Commands, Positions_AreHeldAndMove) {
  EXPECT_EQ(ask("at 4711"), "ok at 4711");
  EXPECT_EQ(read(), "4711");
  EXPECT_EQ(ask("move -4712"), "ok at 67108863");
  EXPECT_EQ(read(), "67108863");
  EXPECT_EQ(ask("motion ramp"), "ok motion ramp");
  EXPECT_NE(read(), read());
}

TEST_F(Commands, Flags_AreSent) {
  EXPECT_EQ(ask("nE 0"), "ok nE 0 nW 1");
  read();
  EXPECT_EQ(ask("nW 0"), "ok nE 0 nW 0");
  ask("nE 1");
  read();
  bench.encoder.finish(bench.bus.time());
  ASSERT_EQ(bench.requests.size(), 2U);
  EXPECT_FALSE(bench.requests[0].sent.channel_list[0].nE);
  EXPECT_TRUE(bench.requests[0].sent.channel_list[0].nW);
  EXPECT_TRUE(bench.requests[1].sent.channel_list[0].nE);
  EXPECT_FALSE(bench.requests[1].sent.channel_list[0].nW);
}

TEST_F(Commands, PlugAndPower_AreRequestsWithoutAnswer) {
  for (const auto& [off, on, name] :
       {std::tuple{"unplug", "plug", "cut"}, {"power off", "power on", "brown_out"}}) {
    const std::size_t before = bench.requests.size();
    EXPECT_EQ(ask(off), std::string("ok ") + off);
    for (int i = 0; i < 3; ++i) EXPECT_EQ(read(), "no_response") << off;
    EXPECT_THAT(ask("status"), HasSubstr(name == std::string("cut") ? R"("plugged":false)"
                                                                    : R"("powered":false)"));
    EXPECT_EQ(ask(on), std::string("ok ") + on);
    EXPECT_THAT(read(), testing::MatchesRegex("[0-9]+")) << on;
    for (std::size_t k = before + 1; k < bench.requests.size(); ++k) {
      EXPECT_EQ(sim::text_of(bench.requests[k].faults), name) << k;
    }
  }
}

TEST_F(Commands, WrongCommands_ChangeNothing) {
  for (const char* wrong : {"",
                            "help",
                            "fault",
                            "fault flop@next",
                            "fault flip",
                            "fault flip:2",
                            "fault flip@next,bit=99",
                            "fault delay:0.1",
                            "fault short_frame@next",
                            "at",
                            "at -1",
                            "at 67108864",
                            "at 1x",
                            "move x",
                            "motion spin",
                            "nE 2",
                            "nE",
                            "power",
                            "plug in",
                            "status all"}) {
    EXPECT_THAT(ask(wrong), StartsWith("error: ")) << wrong;
    EXPECT_EQ(ask(wrong).find('\n'), std::string::npos) << wrong;
  }
  read();
  EXPECT_THAT(ask("fault flip@0"), StartsWith("error: request 0 has passed"));
  EXPECT_THAT(ask("status"), HasSubstr(R"("requests":1,"faults":0,)"));
}

TEST_F(Commands, FaultsWithoutEnd_AreBounded) {
  std::string answer;
  for (int i = 0; i < 2000; ++i) answer = ask("fault flip@" + std::to_string(1000 + i));
  EXPECT_THAT(answer, StartsWith("error: 1000 faults are waiting"));
}

TEST(VirtualEncoder, WidePosition_IsATextInStatus) {
  VirtualBench bench(test_line("pos64,crc16"));
  EXPECT_EQ(bench.encoder.command("at 9007199254740993", {}), "ok at 9007199254740993");
  EXPECT_THAT(bench.encoder.command("status", {}), HasSubstr(R"("position":"9007199254740993")"));
}

}  // namespace virtual_encoder_test
}  // namespace biss::live
