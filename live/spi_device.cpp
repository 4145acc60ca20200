#include "live/spi_device.hpp"

#include <linux/spi/spidev.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <climits>
#include <cstring>
#include <utility>

namespace biss::live {

namespace {

constexpr std::uint32_t several_lines =
    SPI_TX_DUAL | SPI_TX_QUAD | SPI_TX_OCTAL | SPI_RX_DUAL | SPI_RX_QUAD | SPI_RX_OCTAL;
// The modes of this controller. The kernel drops further data lines and refuses the rest.
constexpr std::uint32_t possible_modes =
    SPI_CPHA | SPI_CPOL | SPI_CS_HIGH | SPI_LSB_FIRST | SPI_NO_CS;

constexpr unsigned bytes_of_word(unsigned bits) { return bits <= 8 ? 1 : bits <= 16 ? 2 : 4; }

// The place of a word of these bytes in a word of 4 bytes of this processor.
constexpr unsigned place_of(unsigned bytes) {
  return std::endian::native == std::endian::big ? 4 - bytes : 0;
}

std::uint32_t load_word(const std::uint8_t* from, unsigned bytes) {
  std::array<std::uint8_t, 4> word{};
  std::copy_n(from, bytes, word.data() + place_of(bytes));
  return std::bit_cast<std::uint32_t>(word);
}

void store_word(std::uint32_t word, std::uint8_t* to, unsigned bytes) {
  const auto from = std::bit_cast<std::array<std::uint8_t, 4>>(word);
  std::copy_n(from.data() + place_of(bytes), bytes, to);
}

// Addresses of this program in a transfer.
std::uint64_t address_of(const std::uint8_t* bytes) {
  return reinterpret_cast<std::uintptr_t>(bytes);
}
std::uint8_t* bytes_at(std::uint64_t address) {
  return reinterpret_cast<std::uint8_t*>(static_cast<std::uintptr_t>(address));
}

// The value of a command that reads, of one or four bytes.
SpiAnswer value_of(std::uint32_t command, std::uint32_t value) {
  SpiAnswer answer;
  answer.out.resize(_IOC_SIZE(command));
  store_word(value, answer.out.data(), _IOC_SIZE(command));
  return answer;
}

SpiAnswer failed(int error) { return {.result = -error, .out = {}}; }

}  // namespace

SpiDevice::SpiDevice(SpiBus& bus, Hertz speed, MessageTime time)
    : bus_(bus),
      speed_max_(std::clamp(speed, bus.rate_min(), bus.rate_max())),
      speed_(speed_max_),
      clock_(std::move(time)) {}

void SpiDevice::release() {
  if (users_ > 0 && --users_ == 0) speed_ = speed_max_;
}

SpiAnswer SpiDevice::control(std::uint32_t command, std::span<const std::uint8_t> argument,
                             CallerMemory& memory) {
  if (_IOC_TYPE(command) != SPI_IOC_MAGIC) return failed(ENOTTY);
  switch (command) {
    case SPI_IOC_RD_MODE:
    case SPI_IOC_RD_MODE32:
      return value_of(command, mode_);
    case SPI_IOC_RD_LSB_FIRST:
      return value_of(command, (mode_ & SPI_LSB_FIRST) != 0 ? 1 : 0);
    case SPI_IOC_RD_BITS_PER_WORD:
      return value_of(command, bits_per_word_);
    case SPI_IOC_RD_MAX_SPEED_HZ:
      return value_of(command, speed_.count);
    default:
      break;
  }
  const unsigned bytes = _IOC_SIZE(command);
  if (_IOC_DIR(command) != _IOC_WRITE) return failed(ENOTTY);
  if (argument.size() < bytes) return failed(EFAULT);
  if (_IOC_NR(command) == 0) return message(argument.first(bytes), memory);
  const std::uint32_t value = load_word(argument.data(), std::min(bytes, 4U));
  switch (command) {
    case SPI_IOC_WR_MODE:
    case SPI_IOC_WR_MODE32:
      return set_mode(value);
    case SPI_IOC_WR_LSB_FIRST:
      return set_mode(value != 0 ? mode_ | SPI_LSB_FIRST : mode_ & ~std::uint32_t{SPI_LSB_FIRST});
    case SPI_IOC_WR_BITS_PER_WORD:
      if (value > 32) return failed(EINVAL);
      bits_per_word_ = static_cast<std::uint8_t>(value == 0 ? 8 : value);
      return {};
    case SPI_IOC_WR_MAX_SPEED_HZ:
      if (value == 0) return failed(EINVAL);
      speed_ = Hertz{value};
      return {};
    default:
      return failed(ENOTTY);
  }
}

SpiAnswer SpiDevice::set_mode(std::uint32_t mode) {
  mode &= ~several_lines;
  if ((mode & ~possible_modes) != 0) return failed(EINVAL);
  mode_ = mode;
  return {};
}

SpiAnswer SpiDevice::message(std::span<const std::uint8_t> argument, CallerMemory& memory) {
  if (argument.size() % sizeof(spi_ioc_transfer) != 0) return failed(EINVAL);
  std::vector<spi_ioc_transfer> given(argument.size() / sizeof(spi_ioc_transfer));
  if (given.empty()) return {};
  std::memcpy(given.data(), argument.data(), argument.size());

  // The same transfers in the two buffers of the kernel, which aligns each of them.
  std::vector<spi_ioc_transfer> here = given;
  std::array<std::uint8_t, buffer_bytes> out;
  std::array<std::uint8_t, buffer_bytes> in{};
  std::uint64_t total = 0;
  std::uint64_t out_end = 0;
  std::uint64_t in_end = 0;
  for (spi_ioc_transfer& each : here) {
    const std::uint64_t room = (std::uint64_t{each.len} + 7) / 8 * 8;
    total += each.len;
    if (each.tx_buf != 0) out_end += room;
    if (each.rx_buf != 0) in_end += room;
    if (total > INT_MAX || std::max(out_end, in_end) > buffer_bytes) return failed(EMSGSIZE);
    // One data line: there is no other number of bits at once.
    const bool several =
        (each.tx_buf != 0 && each.tx_nbits > 1) || (each.rx_buf != 0 && each.rx_nbits > 1);
    if (each.rx_buf != 0) each.rx_buf = address_of(in.data() + (in_end - room));
    if (each.tx_buf != 0) {
      std::uint8_t* const to = out.data() + (out_end - room);
      if (!memory.read(each.tx_buf, {to, each.len})) return failed(EFAULT);
      each.tx_buf = address_of(to);
    }
    if (several) return failed(EINVAL);
  }
  if (const int error = run(here); error != 0) return failed(error);
  for (std::size_t k = 0; k < given.size(); ++k) {
    if (given[k].rx_buf == 0) continue;
    const std::span<const std::uint8_t> from(bytes_at(here[k].rx_buf), given[k].len);
    if (!memory.write(given[k].rx_buf, from)) return failed(EFAULT);
  }
  return {.result = static_cast<int>(total), .out = {}};
}

SpiAnswer SpiDevice::read(std::size_t bytes) {
  std::vector<std::uint8_t> in(bytes);
  SpiAnswer answer = transfer(nullptr, in.data(), bytes);
  answer.out = std::move(in);
  return answer;
}

SpiAnswer SpiDevice::write(std::span<const std::uint8_t> bytes) {
  return transfer(bytes.data(), nullptr, bytes.size());
}

SpiAnswer SpiDevice::transfer(const std::uint8_t* out, std::uint8_t* in, std::size_t bytes) {
  if (bytes > buffer_bytes) return failed(EMSGSIZE);
  spi_ioc_transfer one{};
  one.tx_buf = address_of(out);
  one.rx_buf = address_of(in);
  one.len = static_cast<std::uint32_t>(bytes);
  const int error = run({&one, 1});
  return {.result = error != 0 ? -error : static_cast<int>(bytes), .out = {}};
}

int SpiDevice::run(std::span<spi_ioc_transfer> transfers) {
  for (spi_ioc_transfer& each : transfers) {
    if (each.bits_per_word == 0) each.bits_per_word = bits_per_word_;
    if (each.speed_hz == 0) each.speed_hz = speed_.count;
    each.speed_hz = std::min(each.speed_hz, bus_.rate_max().count);
    if (each.bits_per_word > 32 || each.len % bytes_of_word(each.bits_per_word) != 0 ||
        each.speed_hz < bus_.rate_min().count) {
      return EINVAL;
    }
  }
  begin_ = clock_.step ? begin_ + *clock_.step : clock_.now();
  begin_ = std::max(begin_, bus_.time());
  const SpiMode mode{.clock_idle = (mode_ & SPI_CPOL) != 0,
                     .second_edge = (mode_ & SPI_CPHA) != 0,
                     .lsb_first = (mode_ & SPI_LSB_FIRST) != 0};
  bus_.begin(begin_, mode, bus_.period_at(Hertz{transfers.front().speed_hz}));
  for (const spi_ioc_transfer& each : transfers) {
    const std::uint8_t* const out = bytes_at(each.tx_buf);
    std::uint8_t* const in = bytes_at(each.rx_buf);
    const unsigned word = bytes_of_word(each.bits_per_word);
    const Picoseconds period = bus_.period_at(Hertz{each.speed_hz});
    const Picoseconds word_gap = microseconds(std::int64_t{each.word_delay_usecs});
    // Without a buffer there are no clocks.
    const std::uint32_t end = out == nullptr && in == nullptr ? 0 : each.len;
    for (std::uint32_t at = 0; at < end; at += word) {
      const std::uint32_t sent = out == nullptr ? 0 : load_word(out + at, word);
      const std::uint32_t got = bus_.exchange(sent, each.bits_per_word, period, word_gap);
      if (in != nullptr) store_word(got, in + at, word);
    }
    bus_.pause(microseconds(std::int64_t{each.delay_usecs}));
    // Chip select, which BiSS does not have, rests for 10 µs between two transfers.
    if (each.cs_change != 0 && &each != &transfers.back()) bus_.pause(microseconds(10));
  }
  return 0;
}

}  // namespace biss::live
