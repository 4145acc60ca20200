// The oracle compared with published numbers and hand-written lines, independent of the core.
#include "tests/oracle/oracle.hpp"

#include <gtest/gtest.h>

#include <string>

namespace oracle::oracle_test {

// Spaces are for the reader.
Bits line_of(const std::string& text) {
  Bits bits;
  for (const char c : text) {
    if (c != ' ') bits.push_back(c == '1');
  }
  return bits;
}

Checksum checksum(const std::string& polynomial) {
  const Bits coefficients = line_of(polynomial);
  return {coefficients, Bits(coefficients.size() - 1, false), true};
}

const Checksum crc4 = checksum("10011");
const Checksum crc6 = checksum("1000011");
const Checksum crc16 = checksum("11001000011011001");

Description one(std::vector<Item> items, const std::optional<Checksum>& sum, bool cds0 = false) {
  return {{{std::move(items), sum}}, cds0};
}

TEST(Oracle, PublishedNumbers_DivideToTheirRemainders) {
  EXPECT_EQ(checksum_of(crc6, line_of("010011010101")), bits_of(0x1C, 6));
  EXPECT_EQ(checksum_of(crc6, line_of("110101101110100010001011")), line_of("001100"));
  EXPECT_EQ(checksum_of(crc6, bits_of(0xFCD * 4 + 3, 14)), bits_of(0x3D, 6));
  EXPECT_EQ(checksum_of(crc16, bits_of(0xD9CFE0C0DA, 40)), bits_of(0x5F29, 16));
  EXPECT_EQ(checksum_of(crc4, bits_of(0x400, 11)), bits_of(6, 4));
  EXPECT_EQ(checksum_of(crc4, bits_of(0x48, 8)), bits_of(3, 4));
}

TEST(Oracle, StartValue_ChangesTheRemainder) {
  Checksum started = crc16;
  started.start = bits_of(1, 16);
  EXPECT_EQ(checksum_of(started, bits_of((0x123456ULL * 4 + 3) * 64 + 1, 32)), bits_of(0x24CD, 16));
  EXPECT_EQ(checksum_of(crc16, bits_of((0x123456ULL * 4 + 3) * 64 + 1, 32)), bits_of(0x1CBF, 16));
}

TEST(Oracle, FrameByHand_EncodesAndReadsBack) {
  const Description format = one({{Kind::position, 18}, {Kind::nE, 1}, {Kind::nW, 1}}, crc6, true);
  const Bits line = line_of("11 000 1 0 010010001101000101 1 1 001101 0");
  const std::vector<Values> values{{0x12345, 0, true, true}};
  EXPECT_EQ(encode(format, values, 2, 3, false), line);
  const Reading reading = decode(format, {}, line);
  EXPECT_EQ(reading.cause, "");
  EXPECT_EQ(reading.values, values);
  EXPECT_EQ(reading.lead, 2U);
  EXPECT_EQ(reading.ack, 3U);
  EXPECT_TRUE(reading.stop_seen);
}

TEST(Oracle, EveryItemByHand_StandsInLineOrder) {
  const Description format = one({{Kind::multiturn, 2},
                                  {Kind::padding, 2},
                                  {Kind::gray_singleturn, 3},
                                  {Kind::W, 1},
                                  {Kind::E, 1},
                                  {Kind::counter, 4}},
                                 std::nullopt);
  // Turn 2, 5 of 8 in Gray is 111, a warning, no error, counter 9.
  const std::vector<Values> values{{2 * 8 + 5, 9, true, false}};
  const Bits line = line_of("1 0 1 1  10 00 111 1 0 1001  0");
  EXPECT_EQ(encode(format, values, 1, 1, true), line);
  EXPECT_EQ(decode(format, {}, line).values, values);
}

TEST(Oracle, DamagedLines_HaveTheirCauses) {
  const Description format = one({{Kind::position, 3}, {Kind::nE, 1}}, crc4, true);
  // 1011 with CRC4: 1011 0000 / 10011 leaves 1110, inverted 0001.
  const auto cause = [&](const std::string& line, const Limits& limits = {}) {
    return decode(format, limits, line_of(line)).cause;
  };
  EXPECT_EQ(cause("11 00 1 0 1011 0001 0"), "");
  EXPECT_EQ(cause("11 00 1 0 1011 0001"), "");
  EXPECT_EQ(cause("1111"), "no_response");
  EXPECT_EQ(cause(""), "no_response");
  EXPECT_EQ(cause("00 1 0 1011 0001 0"), "not_ready");
  EXPECT_EQ(cause("11 00 1 0 1011 0001 0", {3, 9, 1, 9}), "response_range");
  EXPECT_EQ(cause("11 00 1 0 1011 0001 0", {1, 1, 1, 9}), "response_range");
  EXPECT_EQ(cause("11 00"), "no_start");
  EXPECT_EQ(cause("11 00 1 0 1011 0001 0", {1, 9, 3, 9}), "ack_range");
  EXPECT_EQ(cause("11 00 1 0 1011 0001 0", {1, 9, 1, 1}), "ack_range");
  EXPECT_EQ(cause("11 00 1 0 1011 000"), "truncated");
  EXPECT_EQ(cause("11 00 1"), "truncated");
  EXPECT_EQ(cause("11 00 1 1 1011 0001 0"), "cds");
  EXPECT_EQ(cause("11 00 1 0 1010 0001 0"), "crc");
  EXPECT_EQ(cause("11 00 1 0 1011 0001 1"), "stop_bit");
}

TEST(Oracle, SecondChannelDamaged_IsNamed) {
  const Description format{
      {{{{Kind::position, 3}, {Kind::nE, 1}}, crc4}, {{{Kind::position, 4}}, crc4}}, false};
  const std::vector<Values> values{{5, 0, true, true}, {11, 0, true, true}};
  Bits line = line_of("1 0 1 0  1011 0001  1011 0001  0");
  EXPECT_EQ(encode(format, values, 1, 1, false), line);
  line[12] = !line[12];
  const Reading reading = decode(format, {}, line);
  EXPECT_EQ(reading.cause, "crc");
  EXPECT_EQ(reading.channel, 1U);
}

}  // namespace oracle::oracle_test
