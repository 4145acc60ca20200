// Input that no encoder sends: the decoder accepts any bits. Buffers have exactly their size, so that
// a sanitizer detects an access outside. Texts of formats: fuzz/format_fuzz.cpp.
#include <gtest/gtest.h>

#include <vector>

#include "tests/core/test.hpp"
#include "tests/exhaustive/scale.hpp"
#include "tests/exhaustive/twin.hpp"

namespace exhaustive::hostile_test {

// Runs of equal bits, as lines have, and noise.
std::vector<std::uint8_t> random_bytes(biss::test::Random& random) {
  oracle::Bits bits;
  const std::size_t size = 8 * static_cast<std::size_t>(random.below(40));
  bool level = true;
  while (bits.size() < size) {
    const std::uint32_t run = random.flip() ? 1 + random.below(3) : 1 + random.below(60);
    bits.insert(bits.end(), run, level);
    level = !level;
  }
  std::vector<std::uint8_t> bytes;
  for (std::size_t i = 0; i < size; i += 8) {
    bytes.push_back(static_cast<std::uint8_t>(oracle::number_of(bits, i, 8)));
  }
  return bytes;
}

TEST(HostileBits, OfAnySizeAndOffset_AreReadAlike) {
  BISS_RANDOM(random, 0x4057'0001);
  std::uint64_t frames = 0;
  for (std::uint64_t round = 0; round < rounds(100'000); ++round) {
    oracle::Description description;
    for (std::uint32_t left = 1 + random.below(8); left > 0; --left) {
      description.channels.push_back(random_channel(random));
    }
    const Twin twin = twin_of(description);
    const biss::FrameCodec<biss::CrcBitwise> codec(twin.format);
    const std::vector<std::uint8_t> bytes = random_bytes(random);
    const biss::BitView view(bytes, random.below(17), random.below(330));
    const auto frame = biss::decode_frame(view, codec);
    if (frame.ok()) ++frames;
    const oracle::Reading judge = oracle::decode(description, {}, bits_of(view));
    ASSERT_EQ(difference(frame, judge), "") << twin.text << " round " << round;
  }
  EXPECT_GT(frames, 0U);
}

}  // namespace exhaustive::hostile_test
