// Frames with known CRCs from public documents, test benches and captures, both ways: the CRC is
// computed, the frame encodes to the published bits, and they decode to the published values.
#include <gtest/gtest.h>

#include <string>

#include "biss/frame/codec.hpp"
#include "biss/frame/decode.hpp"
#include "biss/frame/encode.hpp"
#include "biss/frame/format_text.hpp"
#include "tests/data/vectors.hpp"
#include "tests/oracle/oracle.hpp"

namespace published::published_test {

std::string data_file(const char* name) { return std::string(BISS_TEST_DATA "/") + name; }

std::string levels_of(const biss::BitView& view) {
  std::string levels;
  for (std::size_t i = 0; i < view.size_bits(); ++i) levels += view[i] ? '1' : '0';
  return levels;
}

biss::FrameBits bits_of(const std::string& levels) {
  biss::FrameBits bits;
  for (const char level : levels) bits.append(level == '1');
  return bits;
}

template <class Crc>
void expect_both_ways(const Vector& vector, const biss::FrameFormat& format) {
  const biss::FrameCodec<Crc> codec(format);
  biss::Frame frame;
  frame.channel_count = 1;
  frame.channel_list[0] = {vector.position, static_cast<std::uint32_t>(vector.life_counter),
                           vector.nE, vector.nW};
  frame.lead_clocks = 1;
  frame.ack_clocks = 1;
  EXPECT_EQ(codec.crc(0, biss::pack(format.channel_list[0], frame.channel_list[0]), false),
            vector.crc);

  const std::string line = "1010" + vector.bits + "0";
  const auto bits = biss::encode_frame(frame, codec);
  ASSERT_TRUE(bits.ok());
  EXPECT_EQ(levels_of(bits->view()), line);

  const auto back = biss::decode_frame(bits_of(line).view(), codec);
  ASSERT_TRUE(back.ok());
  EXPECT_EQ(back->channel_list[0], frame.channel_list[0]);
  for (std::size_t i = 4; i + 1 < line.size(); ++i) {
    biss::FrameBits hurt = bits_of(line);
    hurt.flip(i);
    EXPECT_FALSE(biss::decode_frame(hurt.view(), codec).ok()) << "bit " << i;
  }
}

// The same by polynomial division, from the published bits alone.
void expect_oracle_agrees(const Vector& vector, const biss::CrcSpec& crc) {
  const std::size_t width = crc.width_bits;
  oracle::Bits data;
  for (const char level : vector.bits.substr(0, vector.bits.size() - width)) {
    data.push_back(level == '1');
  }
  const oracle::Checksum checksum{oracle::bits_of(crc.polynomial, width + 1),
                                  oracle::Bits(width, false), true};
  EXPECT_EQ(oracle::checksum_of(checksum, data), oracle::bits_of(vector.crc, width));
}

std::size_t check_all(const File& file) {
  std::size_t checked = 0;
  for (const Vector& vector : file.vectors) {
    SCOPED_TRACE(vector.name);
    const auto format = biss::parse_format(vector.format);
    EXPECT_TRUE(format.ok()) << vector.format;
    if (!format.ok()) continue;
    expect_both_ways<biss::CrcBitwise>(vector, *format);
    expect_both_ways<biss::CrcTable<4>>(vector, *format);
    expect_both_ways<biss::CrcTable<8>>(vector, *format);
    expect_both_ways<biss::CrcSliced>(vector, *format);
    expect_oracle_agrees(vector, format->channel_list[0].crc);
    ++checked;
  }
  return checked;
}

TEST(PublishedVectors, EachRow_HoldsBothWays) {
  const File file = read_vectors(data_file("vectors.csv"));
  EXPECT_GE(file.data_lines, 14U);
  EXPECT_EQ(check_all(file), file.data_lines);
}

TEST(PublishedSlaveLog, EachLine_HoldsBothWays) {
  const File file = read_slave_log(data_file("slave_log.txt"));
  EXPECT_GE(file.data_lines, 29U);
  EXPECT_EQ(check_all(file), file.data_lines);
}

}  // namespace published::published_test
