// Whole frames: 1 to 8 channels, every length of ACK and of line delay, any bounds, any damage.
#include <gtest/gtest.h>

#include <map>
#include <string>

#include "tests/core/test.hpp"
#include "tests/exhaustive/scale.hpp"
#include "tests/exhaustive/twin.hpp"

namespace exhaustive::frame_sweep_test {

using Codec = biss::FrameCodec<biss::CrcTable<4>>;

oracle::Description random_description(biss::test::Random& random, std::size_t channels) {
  oracle::Description description;
  while (description.channels.size() < channels) {
    description.channels.push_back(random_channel(random));
  }
  description.cds_must_be_0 = random.flip();
  return description;
}

TEST(EveryAck, From1To400ClocksWith1To8Channels_IsTheIdentityForBothReaders) {
  BISS_RANDOM(random, 0xACC0'0001);
  for (std::size_t channels = 1; channels <= 8; ++channels) {
    for (std::size_t ack = 1; ack <= 400; ++ack) {
      if (slow_build && ack > 40 && ack % 10 != channels) continue;
      const Twin twin = twin_of(random_description(random, channels));
      Sent sent = random_sent(twin.description, random);
      sent.ack = ack;
      const std::string what = judge_frame(twin, Codec(twin.format), sent);
      ASSERT_EQ(what, "") << channels << " channels, ACK " << ack;
    }
  }
}

TEST(EveryLead, From1To402Clocks_IsTheIdentityForBothReaders) {
  BISS_RANDOM(random, 0xACC0'0002);
  for (std::size_t lead = 1; lead <= 402; ++lead) {
    const Twin twin = twin_of(random_description(random, 1 + lead % 8));
    Sent sent = random_sent(twin.description, random);
    sent.lead = lead;
    sent.ack = 1 + random.below(400);
    const std::string what = judge_frame(twin, Codec(twin.format), sent);
    ASSERT_EQ(what, "") << "lead " << lead;
  }
}

TEST(RandomFrames, OfAnyFormat_AreReadAlikeWholeAndDamaged) {
  BISS_RANDOM(random, 0xACC0'0003);
  std::map<std::string, unsigned> seen;
  for (std::uint64_t round = 0; round < rounds(40'000); ++round) {
    const Twin twin = twin_of(random_description(random, 1 + random.below(8)));
    const Codec codec(twin.format);
    const Sent sent = random_sent(twin.description, random);
    std::string what = judge_frame(twin, codec, sent);
    const oracle::Bits line =
        oracle::encode(twin.description, sent.values, sent.lead, sent.ack, sent.cds);
    for (unsigned harm = 0; harm < 3 && what.empty(); ++harm) {
      const auto bound = [&random](unsigned below) {
        return static_cast<std::uint16_t>(random.below(below));
      };
      const biss::FrameBounds bounds{bound(3), static_cast<std::uint16_t>(3 + bound(5)), bound(12),
                                     static_cast<std::uint16_t>(12 + bound(20))};
      const oracle::Bits hurt = damaged(line, random);
      what = judge_line(twin, codec, hurt, bounds);
      ++seen[oracle::decode(twin.description, limits_of(bounds), hurt).cause];
    }
    ASSERT_EQ(what, "") << "round " << round;
  }
  for (const auto& [cause, count] : seen) std::printf("%8u %s\n", count, cause.c_str());
  EXPECT_EQ(seen.size(), biss::frame_error_count + 1) << "a cause was never met";
}

}  // namespace exhaustive::frame_sweep_test
