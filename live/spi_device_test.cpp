#include "live/spi_device.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cerrno>

#include "live/virtual_bench.hpp"

namespace biss::live {
namespace spi_device_test {

std::vector<std::uint8_t> ones(std::size_t bytes) { return std::vector<std::uint8_t>(bytes, 0xFF); }

spi_ioc_transfer transfer_of(std::uint64_t in, std::uint32_t bytes, std::uint64_t out = 0) {
  spi_ioc_transfer transfer{};
  transfer.tx_buf = out;
  transfer.rx_buf = in;
  transfer.len = bytes;
  return transfer;
}

TEST(SpiDevice, Settings_AreThoseOfTheKernel) {
  VirtualBench bench;
  EXPECT_EQ(bench.get(SPI_IOC_RD_MODE), 0U);
  EXPECT_EQ(bench.get(SPI_IOC_RD_BITS_PER_WORD), 8U);
  EXPECT_EQ(bench.get(SPI_IOC_RD_MAX_SPEED_HZ), 5'000'000U);
  EXPECT_EQ(bench.set(SPI_IOC_WR_MODE, std::uint8_t{SPI_MODE_3 | SPI_NO_CS}), 0);
  EXPECT_EQ(bench.get(SPI_IOC_RD_MODE32), std::uint32_t{SPI_MODE_3 | SPI_NO_CS});
  EXPECT_EQ(bench.set(SPI_IOC_WR_LSB_FIRST, std::uint8_t{1}), 0);
  EXPECT_EQ(bench.get(SPI_IOC_RD_LSB_FIRST), 1U);
  EXPECT_EQ(bench.get(SPI_IOC_RD_MODE), std::uint32_t{SPI_MODE_3 | SPI_NO_CS | SPI_LSB_FIRST});
  for (const std::uint8_t refused :
       std::initializer_list<std::uint8_t>{SPI_LOOP, SPI_3WIRE, SPI_READY}) {
    EXPECT_EQ(bench.set(SPI_IOC_WR_MODE, refused), -EINVAL) << int{refused};
  }
  EXPECT_EQ(bench.set(SPI_IOC_WR_MODE32, std::uint32_t{1U << 31U}), -EINVAL);
  EXPECT_EQ(bench.get(SPI_IOC_RD_MODE), std::uint32_t{SPI_MODE_3 | SPI_NO_CS | SPI_LSB_FIRST});
  // The kernel drops further data lines of a controller without them.
  EXPECT_EQ(bench.set(SPI_IOC_WR_MODE32, std::uint32_t{SPI_MODE_3 | SPI_RX_QUAD}), 0);
  EXPECT_EQ(bench.get(SPI_IOC_RD_MODE32), std::uint32_t{SPI_MODE_3});
  EXPECT_EQ(bench.set(SPI_IOC_WR_BITS_PER_WORD, std::uint8_t{33}), -EINVAL);
  EXPECT_EQ(bench.set(SPI_IOC_WR_BITS_PER_WORD, std::uint8_t{16}), 0);
  EXPECT_EQ(bench.get(SPI_IOC_RD_BITS_PER_WORD), 16U);
  EXPECT_EQ(bench.set(SPI_IOC_WR_BITS_PER_WORD, std::uint8_t{0}), 0);
  EXPECT_EQ(bench.get(SPI_IOC_RD_BITS_PER_WORD), 8U);
  EXPECT_EQ(bench.set(SPI_IOC_WR_MAX_SPEED_HZ, std::uint32_t{0}), -EINVAL);
  EXPECT_EQ(bench.set(_IOW(SPI_IOC_MAGIC, 9, std::uint8_t), std::uint8_t{0}), -ENOTTY);
  EXPECT_EQ(bench.set(_IOW('x', 1, std::uint8_t), std::uint8_t{0}), -ENOTTY);
  EXPECT_EQ(bench.device.control(_IO(SPI_IOC_MAGIC, 0), {}, bench.memory).result, -ENOTTY);
}

TEST(SpiDevice, SpeedThatWasSet_EndsWithTheLastUser) {
  VirtualBench bench;
  bench.device.open();
  bench.device.open();
  EXPECT_EQ(bench.set(SPI_IOC_WR_MAX_SPEED_HZ, std::uint32_t{1'000'000}), 0);
  bench.device.release();
  EXPECT_EQ(bench.get(SPI_IOC_RD_MAX_SPEED_HZ), 1'000'000U);
  bench.device.release();
  EXPECT_EQ(bench.get(SPI_IOC_RD_MAX_SPEED_HZ), 5'000'000U);
}

TEST(SpiDevice, MessagesThatCannotBe_GetTheErrorOfTheKernel) {
  VirtualBench bench;
  const std::uint64_t out = bench.memory.put(ones(8192));
  const std::uint64_t in = bench.memory.put(ones(8192));
  const auto with = [&](auto change) {
    spi_ioc_transfer transfer = transfer_of(in, 8, out);
    change(transfer);
    return bench.message({transfer});
  };
  EXPECT_EQ(bench.message({}), 0);
  EXPECT_EQ(with([](auto& t) { t.len = 4096; }), 4096);
  EXPECT_EQ(with([](auto& t) { t.len = 4097; }), -EMSGSIZE);
  EXPECT_EQ(with([](auto& t) { t.len = 0xFFFF'FFFF; }), -EMSGSIZE);
  EXPECT_EQ(with([](auto& t) { t.len = 0; }), 0);
  EXPECT_EQ(with([](auto& t) { t.tx_buf = 1; }), -EFAULT);
  EXPECT_EQ(with([](auto& t) { t.rx_buf = 1; }), -EFAULT);
  EXPECT_EQ(with([](auto& t) { t.bits_per_word = 33; }), -EINVAL);
  EXPECT_EQ(with([](auto& t) { t.bits_per_word = 16, t.len = 7; }), -EINVAL);
  EXPECT_EQ(with([](auto& t) { t.bits_per_word = 20, t.len = 6; }), -EINVAL);
  EXPECT_EQ(with([](auto& t) { t.tx_nbits = 2; }), -EINVAL);
  EXPECT_EQ(with([](auto& t) { t.rx_nbits = 4; }), -EINVAL);
  EXPECT_EQ(with([](auto& t) { t.speed_hz = 999; }), -EINVAL);
  // Each transfer begins at a multiple of 8 in the buffer of 4096 bytes.
  std::vector<spi_ioc_transfer> many(511, transfer_of(in, 8));
  EXPECT_EQ(bench.message(many), 4088);
  for (spi_ioc_transfer& each : many) each.len = 9;
  EXPECT_EQ(bench.message(many), -EMSGSIZE);
  // Without a buffer there are no clocks, but the length counts.
  const Picoseconds before = bench.device.busy_until();
  EXPECT_EQ(bench.message({transfer_of(0, 0x7FFF'FFFF)}), 0x7FFF'FFFF);
  EXPECT_LE(bench.device.busy_until() - before, microseconds(100));
  EXPECT_EQ(bench.message({transfer_of(0, 0x7FFF'FFFF), transfer_of(0, 1)}), -EMSGSIZE);
  // A size that is no whole number of transfers, and an argument that is missing.
  const std::uint32_t odd = _IOC(_IOC_WRITE, SPI_IOC_MAGIC, 0, 33);
  EXPECT_EQ(bench.device.control(odd, ones(33), bench.memory).result, -EINVAL);
  EXPECT_EQ(bench.device.control(SPI_IOC_MESSAGE(1), {}, bench.memory).result, -EFAULT);
  EXPECT_EQ(bench.device.read(4097).result, -EMSGSIZE);
  EXPECT_EQ(bench.device.write(ones(4097)).result, -EMSGSIZE);
  EXPECT_EQ(bench.device.read(0).result, 0);
}

TEST(SpiDevice, Mode3_ReadsTheFrameAtEachSpeed) {
  for (const std::uint32_t speed : {250'000U, 1'000'000U, 5'000'000U, 10'000'000U}) {
    VirtualBench bench(test_line(), {}, milliseconds(1));
    bench.set(SPI_IOC_WR_MODE, std::uint8_t{SPI_MODE_3});
    bench.set(SPI_IOC_WR_MAX_SPEED_HZ, speed);
    const Picoseconds period = period_of(hertz(speed));
    std::vector<std::string> seen;
    for (int i = 0; i < 4; ++i) seen.push_back(bench.position(bench.exchange(ones(12)), period));
    const SpiAnswer half = bench.device.read(12);
    EXPECT_EQ(half.result, 12);
    seen.push_back(bench.position(half.out, period));
    EXPECT_EQ(bench.device.write(ones(12)).result, 12);
    bench.encoder.finish(bench.bus.time());
    ASSERT_EQ(bench.requests.size(), 6U) << speed;
    for (std::size_t k = 0; k < seen.size(); ++k) {
      EXPECT_EQ(seen[k], std::to_string(bench.requests[k].sent.channel_list[0].position)) << speed;
    }
  }
}

// With modes 0 and 1 MA is low between messages, and in mode 1 it is sampled while SLO may change.
TEST(SpiDevice, OtherModes_GiveWhatTheirEdgesGive) {
  sim::LineSetup line = test_line();
  line.position = 4711;
  std::string seen;
  for (std::uint8_t mode = SPI_MODE_0; mode <= SPI_MODE_3; ++mode) {
    VirtualBench bench(line);
    bench.set(SPI_IOC_WR_MODE, mode);
    for (int i = 0; i < 3; ++i) seen += bench.position(bench.exchange(ones(12))) + ' ';
    bench.encoder.finish(bench.bus.time());
    for (const sim::FarEndCycle& request : bench.requests) {
      seen += std::to_string(request.begin.count / 1000) + ' ';
    }
    seen += '\n';
  }
  EXPECT_EQ(seen,
            "4711 4711 4711 100000 200200 300200 \n"
            "response_range 4711 4711 100000 200100 300100 \n"
            "4711 4711 4711 100100 200100 300100 \n"
            "4711 4711 4711 100000 200000 300000 \n");
}

// The same bits, least significant first or in words of 16 or 32 bits of this processor.
TEST(SpiDevice, BitsOfAWord_AreInTheOrderOfTheMode) {
  sim::LineSetup line = test_line();
  line.position = 4711;
  const auto read = [&](std::uint8_t mode, std::uint8_t bits) {
    VirtualBench bench(line);
    bench.set(SPI_IOC_WR_MODE, static_cast<std::uint8_t>(SPI_MODE_3 | mode));
    spi_ioc_transfer transfer{};
    transfer.bits_per_word = bits;
    return bench.exchange(ones(12), transfer);
  };
  const std::vector<std::uint8_t> plain = read(0, 0);
  std::vector<std::uint8_t> reversed = read(SPI_LSB_FIRST, 8);
  for (std::uint8_t& byte : reversed) {
    byte = static_cast<std::uint8_t>((byte * 0x0202020202ULL & 0x010884422010ULL) % 1023);
  }
  EXPECT_EQ(reversed, plain);
  for (const unsigned bytes : {2U, 4U}) {
    std::vector<std::uint8_t> words = read(0, static_cast<std::uint8_t>(bytes * 8));
    for (auto word = words.begin(); word != words.end(); word += bytes) {
      std::reverse(word, word + bytes);
    }
    EXPECT_EQ(words, plain) << bytes;
  }
  // 7 bits of each byte.
  std::string bits;
  std::string expected;
  for (const std::uint8_t byte : plain) {
    for (int k = 7; k >= 0; --k) expected += (byte >> k & 1) != 0 ? '1' : '0';
  }
  for (const std::uint8_t byte : read(0, 7)) {
    EXPECT_LT(byte, 0x80);
    for (int k = 6; k >= 0; --k) bits += (byte >> k & 1) != 0 ? '1' : '0';
  }
  EXPECT_EQ(bits, expected.substr(0, bits.size()));
}

TEST(SpiDevice, MaFromMosi_IsTheLevelOfItsBits) {
  VirtualBench bench(test_line(), {.ma = MaSource::mosi});
  bench.set(SPI_IOC_WR_MODE, std::uint8_t{SPI_MODE_0});
  bench.set(SPI_IOC_WR_MAX_SPEED_HZ, std::uint32_t{2'000'000});
  // 96 periods of MA, low first; the second half of each shows SLO just before the next fall.
  const std::vector<std::uint8_t> bits = bench.exchange(std::vector<std::uint8_t>(24, 0x55));
  std::vector<std::uint8_t> clocked(12);
  for (std::size_t k = 0; k < 96; ++k) {
    const unsigned bit = bits[k / 4] >> (7 - 2 * (k % 4)) & 1U;  // the first half
    clocked[k / 8] = static_cast<std::uint8_t>(clocked[k / 8] | bit << (7 - k % 8));
  }
  bench.encoder.finish(bench.bus.time());
  ASSERT_EQ(bench.requests.size(), 1U);
  EXPECT_EQ(bench.position(clocked, microseconds(1)),
            std::to_string(bench.requests[0].sent.channel_list[0].position));
  // It stays at its last level: a zero is a request that the encoder sees once.
  EXPECT_EQ(bench.device.write(std::vector<std::uint8_t>{0xF0}).result, 1);
}

TEST(SpiDevice, TimeOfMessages_IsAStepOrTheEndOfThePreviousOne) {
  VirtualBench bench(test_line(), {.word_gap = nanoseconds(200)}, microseconds(50));
  bench.set(SPI_IOC_WR_MODE, std::uint8_t{SPI_MODE_3});
  bench.exchange(ones(12));
  EXPECT_EQ(bench.device.busy_until(), microseconds(50) + 12 * nanoseconds(1'800));
  bench.exchange(ones(100));  // 180 us
  bench.exchange(ones(12));
  const std::uint64_t in = bench.memory.put(ones(24));
  std::vector<spi_ioc_transfer> two(2, transfer_of(in, 12));
  two[0].delay_usecs = 40;
  two[0].cs_change = 1;
  bench.message(two);
  EXPECT_EQ(bench.device.busy_until(),
            microseconds(330) + 2 * 12 * nanoseconds(1'800) + microseconds(50));
  bench.encoder.finish(bench.bus.time());
  // The third message follows without a rest, and is no request for the encoder.
  ASSERT_EQ(bench.requests.size(), 4U);
  EXPECT_EQ(bench.requests[0].begin, microseconds(50));
  EXPECT_EQ(bench.requests[1].begin, microseconds(100));
  EXPECT_EQ(bench.requests[2].begin, microseconds(330));
  EXPECT_EQ(bench.requests[3].begin,
            microseconds(330) + 12 * nanoseconds(1'800) + microseconds(50));
}

TEST(SpiBus, DividedClock_IsTheHighestThatIsNotAbove) {
  VirtualBench bench(test_line(), {.clock = megahertz(125)});
  EXPECT_EQ(bench.bus.period_at(megahertz(10)), nanoseconds(14 * 8));
  EXPECT_EQ(bench.bus.period_at(hertz(62'500'000)), nanoseconds(16));
  EXPECT_EQ(bench.bus.period_at(hertz(62'499'999)), nanoseconds(32));
  EXPECT_EQ(bench.bus.rate_min(), hertz(1908));
  EXPECT_EQ(bench.bus.rate_max(), hertz(62'500'000));
  spi_ioc_transfer slow{};
  slow.speed_hz = 1907;
  EXPECT_TRUE(bench.exchange(ones(1), slow).empty());
}

}  // namespace spi_device_test
}  // namespace biss::live
