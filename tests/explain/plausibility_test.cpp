// Positions that no axis can have, in any channel.
#include "explain/plausibility.hpp"

#include <gtest/gtest.h>

#include "biss/frame/format_text.hpp"

namespace biss::explain::plausibility_test {

// A good cycle each 100 us; its channels are at these positions.
decode::Cycle cycle_at(std::int64_t number, std::uint64_t first, std::uint64_t second) {
  decode::Cycle cycle;
  cycle.time = microseconds(100) * number;
  Frame frame;
  frame.channel_count = 2;
  for (Channel& channel : frame.channel_list) channel.nE = channel.nW = true;
  frame.channel_list[0].position = first;
  frame.channel_list[1].position = second;
  cycle.frame = frame;
  return cycle;
}

TEST(Plausibility, JumpOfTheSecondChannel_IsSeenThere) {
  const FrameFormat format = *parse_format("pos17,nE,nW,crc6+pos19,nE,nW,crc6");
  Plausibility first(format, 0);
  Plausibility second(format, 1);
  for (std::uint64_t i = 0; i < 200; ++i) {
    const std::uint64_t jump = i % 40 == 7 ? std::uint64_t{1} << 17U : 0;
    const decode::Cycle cycle =
        cycle_at(static_cast<std::int64_t>(i), 1000 + 10 * i, (5000 + 10 * i) ^ jump);
    first.push(i, cycle);
    second.push(i, cycle);
  }
  EXPECT_EQ(first.steps().count, 0U);
  EXPECT_EQ(second.steps().count, 5U);
  EXPECT_EQ(second.steps().first_cycle, 7U);
}

}  // namespace biss::explain::plausibility_test
