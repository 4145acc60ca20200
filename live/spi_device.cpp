#include "live/spi_device.hpp"

#include <linux/spi/spidev.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <climits>
#include <cstring>
#include <utility>

namespace biss::live {

namespace {

constexpr std::uint32_t several_lines =
    SPI_TX_DUAL | SPI_TX_QUAD | SPI_TX_OCTAL | SPI_RX_DUAL | SPI_RX_QUAD | SPI_RX_OCTAL;
// The modes that exist, and the modes of this controller. The kernel drops further data lines and
// refuses the rest.
constexpr std::uint32_t known_modes = SPI_CPHA | SPI_CPOL | SPI_CS_HIGH | SPI_LSB_FIRST |
                                      SPI_3WIRE | SPI_LOOP | SPI_NO_CS | SPI_READY |
                                      SPI_RX_CPHA_FLIP | several_lines;
constexpr std::uint32_t possible_modes =
    SPI_CPHA | SPI_CPOL | SPI_CS_HIGH | SPI_LSB_FIRST | SPI_NO_CS;

// The kernel aligns each transfer in its buffer.
constexpr std::uint64_t aligned(std::uint32_t bytes) { return (std::uint64_t{bytes} + 7) / 8 * 8; }

constexpr unsigned bytes_of_word(unsigned bits) { return bits <= 8 ? 1 : bits <= 16 ? 2 : 4; }

std::uint32_t load_word(const std::uint8_t* from, unsigned bytes) {
  std::uint16_t two = 0;
  std::uint32_t four = 0;
  if (bytes == 1) return *from;
  std::memcpy(bytes == 2 ? static_cast<void*>(&two) : &four, from, bytes);
  return bytes == 2 ? two : four;
}

void store_word(std::uint32_t word, std::uint8_t* to, unsigned bytes) {
  const auto two = static_cast<std::uint16_t>(word);
  if (bytes == 1) {
    *to = static_cast<std::uint8_t>(word);
  } else {
    std::memcpy(to, bytes == 2 ? static_cast<const void*>(&two) : &word, bytes);
  }
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

// One direction of it is null if the program gives no buffer.
struct SpiDevice::Transfer {
  const std::uint8_t* out = nullptr;
  std::uint8_t* in = nullptr;
  std::uint32_t bytes = 0;
  std::uint32_t bits = 0;
  Hertz speed{};
  Picoseconds word_gap{};
  Picoseconds gap{};  // after it
};

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
  const bool writes = _IOC_DIR(command) == _IOC_WRITE;
  if (!writes) return failed(ENOTTY);
  if (argument.size() < _IOC_SIZE(command)) return failed(EFAULT);
  if (_IOC_NR(command) == 0) return message(argument.first(_IOC_SIZE(command)), memory);
  if (_IOC_SIZE(command) != 1 && _IOC_SIZE(command) != 4) return failed(ENOTTY);
  return set(command, load_word(argument.data(), _IOC_SIZE(command)));
}

SpiAnswer SpiDevice::set(std::uint32_t command, std::uint32_t value) {
  switch (command) {
    case SPI_IOC_WR_MODE:
    case SPI_IOC_WR_MODE32:
      return {.result = (value & ~known_modes) != 0 ? -EINVAL : set_mode(value), .out = {}};
    case SPI_IOC_WR_LSB_FIRST:
      return {.result = set_mode(value != 0 ? mode_ | SPI_LSB_FIRST
                                            : mode_ & ~std::uint32_t{SPI_LSB_FIRST}),
              .out = {}};
    case SPI_IOC_WR_BITS_PER_WORD:
      return {.result = set_bits(value), .out = {}};
    case SPI_IOC_WR_MAX_SPEED_HZ:
      if (value == 0) return failed(EINVAL);
      speed_ = Hertz{value};
      return {};
    default:
      return failed(ENOTTY);
  }
}

int SpiDevice::set_mode(std::uint32_t mode) {
  mode &= ~several_lines;
  if ((mode & ~possible_modes) != 0) return -EINVAL;
  mode_ = mode;
  return 0;
}

int SpiDevice::set_bits(std::uint32_t bits) {
  if (bits > 32) return -EINVAL;
  bits_per_word_ = bits == 0 ? 8 : bits;
  return 0;
}

SpiAnswer SpiDevice::message(std::span<const std::uint8_t> argument, CallerMemory& memory) {
  if (argument.size() % sizeof(spi_ioc_transfer) != 0) return failed(EINVAL);
  std::vector<spi_ioc_transfer> given(argument.size() / sizeof(spi_ioc_transfer));
  if (given.empty()) return {};
  std::memcpy(given.data(), argument.data(), argument.size());

  // The two buffers of the kernel.
  std::array<std::uint8_t, buffer_bytes> out;
  std::array<std::uint8_t, buffer_bytes> in{};
  std::uint64_t total = 0;
  std::uint64_t out_total = 0;
  std::uint64_t in_total = 0;
  std::vector<Transfer> transfers;
  transfers.reserve(given.size());
  for (const spi_ioc_transfer& each : given) {
    Transfer transfer{.bytes = each.len,
                      .bits = each.bits_per_word,
                      .speed = Hertz{each.speed_hz},
                      .word_gap = microseconds(std::int64_t{each.word_delay_usecs}),
                      .gap = microseconds(std::int64_t{each.delay_usecs})};
    total += each.len;
    if (total > INT_MAX) return failed(EMSGSIZE);
    if (each.rx_buf != 0) {
      if (in_total + aligned(each.len) > buffer_bytes) return failed(EMSGSIZE);
      transfer.in = in.data() + in_total;
      in_total += aligned(each.len);
    }
    if (each.tx_buf != 0) {
      if (out_total + aligned(each.len) > buffer_bytes) return failed(EMSGSIZE);
      transfer.out = out.data() + out_total;
      if (!memory.read(each.tx_buf, {out.data() + out_total, each.len})) return failed(EFAULT);
      out_total += aligned(each.len);
    }
    // One data line: there is no other number of bits at once.
    const bool several =
        (each.tx_buf != 0 && each.tx_nbits > 1) || (each.rx_buf != 0 && each.rx_nbits > 1);
    if (several) return failed(EINVAL);
    // Chip select, which BiSS does not have, rests for 10 µs between two transfers.
    const bool last = &each == &given.back();
    if (each.cs_change != 0 && !last) transfer.gap += microseconds(10);
    transfers.push_back(transfer);
  }
  if (const int error = run(transfers); error != 0) return failed(error);
  for (std::size_t k = 0; k < given.size(); ++k) {
    if (given[k].rx_buf == 0) continue;
    if (!memory.write(given[k].rx_buf, {transfers[k].in, given[k].len})) return failed(EFAULT);
  }
  return {.result = static_cast<int>(total), .out = {}};
}

SpiAnswer SpiDevice::read(std::size_t bytes) {
  if (bytes > buffer_bytes) return failed(EMSGSIZE);
  SpiAnswer answer;
  answer.out.resize(bytes);
  Transfer transfer{.in = answer.out.data(), .bytes = static_cast<std::uint32_t>(bytes)};
  if (const int error = run({&transfer, 1}); error != 0) return failed(error);
  answer.result = static_cast<int>(bytes);
  return answer;
}

SpiAnswer SpiDevice::write(std::span<const std::uint8_t> bytes) {
  if (bytes.size() > buffer_bytes) return failed(EMSGSIZE);
  Transfer transfer{.out = bytes.data(), .bytes = static_cast<std::uint32_t>(bytes.size())};
  if (const int error = run({&transfer, 1}); error != 0) return failed(error);
  return {.result = static_cast<int>(bytes.size()), .out = {}};
}

// Fills in what the device has set. \return 0 or an error
int SpiDevice::check(Transfer& transfer) const {
  if (transfer.bits == 0) transfer.bits = bits_per_word_;
  if (transfer.speed.count == 0) transfer.speed = speed_;
  if (transfer.bits > 32 || transfer.bytes % bytes_of_word(transfer.bits) != 0) return EINVAL;
  transfer.speed = std::min(transfer.speed, bus_.rate_max());
  return transfer.speed < bus_.rate_min() ? EINVAL : 0;
}

int SpiDevice::run(std::span<Transfer> transfers) {
  for (Transfer& transfer : transfers) {
    if (const int error = check(transfer); error != 0) return error;
  }
  begin_ = clock_.step ? begin_ + *clock_.step : clock_.now();
  begin_ = std::max(begin_, bus_.time());
  const SpiMode mode{.clock_idle = (mode_ & SPI_CPOL) != 0,
                     .second_edge = (mode_ & SPI_CPHA) != 0,
                     .lsb_first = (mode_ & SPI_LSB_FIRST) != 0};
  bus_.begin(begin_, mode, bus_.period_at(transfers.front().speed));
  for (const Transfer& transfer : transfers) shift(transfer);
  return 0;
}

// Without a buffer there are no clocks.
void SpiDevice::shift(const Transfer& transfer) {
  const unsigned word = bytes_of_word(transfer.bits);
  const Picoseconds period = bus_.period_at(transfer.speed);
  const bool has_buffer = transfer.out != nullptr || transfer.in != nullptr;
  for (std::uint32_t at = 0; has_buffer && at < transfer.bytes; at += word) {
    const std::uint32_t out = transfer.out == nullptr ? 0 : load_word(transfer.out + at, word);
    const std::uint32_t in = bus_.exchange(out, transfer.bits, period, transfer.word_gap);
    if (transfer.in != nullptr) store_word(in, transfer.in + at, word);
  }
  bus_.pause(transfer.gap);
}

}  // namespace biss::live
