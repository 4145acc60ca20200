#include <gtest/gtest.h>
#include <zlib.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

// libdeflate_crc32() of checksum.cpp, see CMakeLists.txt.
extern "C" std::uint32_t biss_page_crc32(std::uint32_t before, const void* bytes,
                                         std::size_t count);

namespace checksum_test {

// Stretches of one byte, some far longer than a step of the table, between others.
std::vector<std::uint8_t> samples(std::size_t count, std::mt19937& random) {
  std::vector<std::uint8_t> bytes;
  while (bytes.size() < count) {
    const bool rests = random() % 2 == 0;
    const std::size_t length = 1 + random() % 1'200;
    for (std::size_t i = 0; i < length; ++i) {
      bytes.push_back(rests && i != 0 ? bytes.back() : static_cast<std::uint8_t>(random()));
    }
  }
  bytes.resize(count);
  // A byte that differs anywhere in a stretch.
  for (std::size_t i = 0; i < count / 400; ++i) bytes[random() % count] ^= 1U;
  return bytes;
}

TEST(PageChecksum, RunsAndOthersAnywhere_AreThoseOfZlib) {
  constexpr unsigned seed = 20'260'102;
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  for (int round = 0; round < 2'000; ++round) {
    const std::vector<std::uint8_t> bytes = samples(random() % 6'000, random);
    const auto before = static_cast<std::uint32_t>(round % 3 == 0 ? 0 : random());
    const std::size_t skipped = std::min<std::size_t>(bytes.size(), random() % 9);
    const std::size_t count = bytes.size() - skipped;
    ASSERT_EQ(biss_page_crc32(before, bytes.data() + skipped, count),
              crc32_z(before, bytes.data() + skipped, count))
        << round;
  }
}

}  // namespace checksum_test
