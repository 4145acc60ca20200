#include "device/nearest.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace biss {
namespace nearest_test {

TEST(Nearest, TypingSlips_AreCountedAndFarWordsAreNot) {
  const std::vector<std::string> words = {"decode", "crc", "encoders", "plan", "simulate"};
  EXPECT_EQ(nearest("decod", words), "decode");
  EXPECT_EQ(nearest("encode", words), "encoders");
  EXPECT_EQ(nearest("crx", words), "crc");
  EXPECT_EQ(nearest("simluate", words), "simulate");
  EXPECT_EQ(nearest("sim", words), "simulate");
  EXPECT_EQ(nearest("zzzz", words), "");
  EXPECT_EQ(nearest("", words), "");
  EXPECT_EQ(nearest(std::string(100'000, 'd'), words), "");
}

}  // namespace nearest_test
}  // namespace biss
