// The interface of Linux spidev, without a kernel: requests in, bytes and errno out. Behaves as
// drivers/spi/spidev.c and drivers/spi/spi.c of Linux 6.1 with a controller that has single data
// lines, words of 1 to 32 bits and both bit orders.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "live/spi_bus.hpp"

struct spi_ioc_transfer;

namespace biss::live {

/// The memory of the program that makes a request. False: an address is not its own.
class CallerMemory {
 public:
  virtual ~CallerMemory() = default;
  virtual bool read(std::uint64_t address, std::span<std::uint8_t> to) = 0;
  virtual bool write(std::uint64_t address, std::span<const std::uint8_t> from) = 0;
};

/// The result of a request.
struct SpiAnswer {
  /// Not negative, or an error of errno, negative.
  int result = 0;
  /// The value of an ioctl that reads, or the bytes of read().
  std::vector<std::uint8_t> out;
};

/// The time of a message's begin. Not before the end of the previous one.
struct MessageTime {
  std::function<Picoseconds()> now;  ///< in real time
  /// Each message begins this long after the begin of the previous one; empty: real time.
  std::optional<Picoseconds> step;
};

class SpiDevice {
 public:
  /// The bytes of a message in each direction: the kernel's `bufsiz`.
  static constexpr std::size_t buffer_bytes = 4096;

  /// \param bus outlives it
  /// \param speed the device's largest; transfers with speed 0 have it. Limited to the bus.
  SpiDevice(SpiBus& bus, Hertz speed, MessageTime time);

  void open() { ++users_; }
  /// With the last user the speed that was set ends, as in the kernel. The mode remains.
  void release();

  /// \param argument of _IOC_SIZE(command) bytes if the command writes
  SpiAnswer control(std::uint32_t command, std::span<const std::uint8_t> argument,
                    CallerMemory& memory);
  SpiAnswer read(std::size_t bytes);
  SpiAnswer write(std::span<const std::uint8_t> bytes);

  /// The end of the last message.
  Picoseconds busy_until() const { return bus_.time(); }

 private:
  SpiAnswer set_mode(std::uint32_t mode);
  SpiAnswer message(std::span<const std::uint8_t> argument, CallerMemory& memory);
  /// One transfer; null: without this buffer.
  SpiAnswer transfer(const std::uint8_t* out, std::uint8_t* in, std::size_t bytes);
  /// \param transfers with buffers of this program; what is 0 gets the value of the device
  /// \return 0 or an error; nothing was sent then
  int run(std::span<spi_ioc_transfer> transfers);

  SpiBus& bus_;
  Hertz speed_max_;
  Hertz speed_;
  MessageTime clock_;
  std::uint32_t mode_ = 0;
  std::uint8_t bits_per_word_ = 8;
  unsigned users_ = 0;
  Picoseconds begin_{};  // of the last message
};

}  // namespace biss::live
