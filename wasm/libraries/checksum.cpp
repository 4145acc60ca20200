// CRC-32 of RFC 1952. Samples of lines that rest are the same byte again and again: such stretches
// are one step of a table, all others are read sixteen bytes a step.
#include <libdeflate.h>

#include <algorithm>
#include <array>
#include <cstring>

namespace {

constexpr std::uint32_t polynomial = 0xEDB88320U;
constexpr std::size_t lanes = 16;
using Table = std::array<std::uint32_t, 256>;
using Tables = std::array<Table, lanes>;

// after_zeros[k][b]: the remainder of byte b with k zero bytes after it.
constexpr Tables after_zeros = [] {
  Tables tables{};
  for (std::uint32_t byte = 0; byte < 256; ++byte) {
    std::uint32_t crc = byte;
    for (int bit = 0; bit < 8; ++bit) crc = crc >> 1U ^ ((crc & 1U) != 0 ? polynomial : 0U);
    tables[0][byte] = crc;
  }
  for (std::size_t k = 1; k < lanes; ++k) {
    for (std::size_t byte = 0; byte < 256; ++byte) {
      const std::uint32_t before = tables[k - 1][byte];
      tables[k][byte] = before >> 8U ^ tables[0][before & 0xFFU];
    }
  }
  return tables;
}();

constexpr std::uint32_t read_byte(std::uint32_t crc, std::uint32_t byte) {
  return crc >> 8U ^ after_zeros[0][(crc ^ byte) & 0xFFU];
}

constexpr std::size_t run_bytes = 256;

// What a run of the same byte makes of a remainder: its four bytes, and the byte of the run, add up.
struct Runs {
  std::array<Table, 4> remainder{};
  Table byte{};
};
constexpr Runs runs = [] {
  Runs tables;
  const auto read = [](std::uint32_t crc, std::uint32_t byte) {
    for (std::size_t i = 0; i < run_bytes; ++i) crc = read_byte(crc, byte);
    return crc;
  };
  // All are sums of those with a single bit.
  const auto fill = [](Table& table, const auto& of_bit) {
    for (std::uint32_t bit = 1; bit < table.size(); bit <<= 1U) {
      const std::uint32_t value = of_bit(bit);
      for (std::uint32_t below = 0; below < bit; ++below) table[bit | below] = table[below] ^ value;
    }
  };
  for (std::size_t place = 0; place < tables.remainder.size(); ++place) {
    fill(tables.remainder[place], [&](std::uint32_t bit) { return read(bit << 8 * place, 0); });
  }
  fill(tables.byte, [&](std::uint32_t bit) { return read(0, bit); });
  return tables;
}();

std::uint64_t load_word(const std::uint8_t* at) {
  std::uint64_t word = 0;
  std::memcpy(&word, at, sizeof word);
  return word;
}

bool is_run(const std::uint8_t* at) {
  const std::uint64_t first = 0x0101'0101'0101'0101U * *at;
  if (load_word(at) != first || load_word(at + run_bytes - sizeof first) != first) return false;
  std::uint64_t differ = 0;
  for (std::size_t i = 0; i < run_bytes; i += sizeof first) differ |= load_word(at + i) ^ first;
  return differ == 0;
}

std::uint32_t read_run(std::uint32_t crc, std::uint8_t byte) {
  const auto& tables = runs.remainder;
  return tables[0][crc & 0xFFU] ^ tables[1][crc >> 8U & 0xFFU] ^ tables[2][crc >> 16U & 0xFFU] ^
         tables[3][crc >> 24U] ^ runs.byte[byte];
}

std::uint32_t four(std::size_t zeros, std::uint32_t word) {
  return after_zeros[zeros][word & 0xFFU] ^ after_zeros[zeros - 1][word >> 8U & 0xFFU] ^
         after_zeros[zeros - 2][word >> 16U & 0xFFU] ^ after_zeros[zeros - 3][word >> 24U];
}

std::uint32_t read_lanes(std::uint32_t crc, const std::uint8_t* at) {
  const std::uint64_t low = load_word(at) ^ crc;
  const std::uint64_t high = load_word(at + 8);
  return four(15, static_cast<std::uint32_t>(low)) ^
         four(11, static_cast<std::uint32_t>(low >> 32U)) ^
         four(7, static_cast<std::uint32_t>(high)) ^
         four(3, static_cast<std::uint32_t>(high >> 32U));
}

}  // namespace

std::uint32_t libdeflate_crc32(std::uint32_t before, const void* bytes, std::size_t count) {
  const auto* at = static_cast<const std::uint8_t*>(bytes);
  std::uint32_t crc = ~before;
  for (; count >= run_bytes; count -= run_bytes, at += run_bytes) {
    if (is_run(at)) {
      crc = read_run(crc, *at);
    } else {
      for (std::size_t i = 0; i < run_bytes; i += lanes) crc = read_lanes(crc, at + i);
    }
  }
  for (; count >= lanes; count -= lanes, at += lanes) crc = read_lanes(crc, at);
  for (; count != 0; --count, ++at) crc = read_byte(crc, *at);
  return ~crc;
}
