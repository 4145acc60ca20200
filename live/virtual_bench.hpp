// For the tests of this room: an encoder as a spidev device, a program's memory, and what it reads.
#pragma once

#include <linux/spi/spidev.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <string>
#include <vector>

#include "biss/frame/format_text.hpp"
#include "biss/master/spi_read.hpp"
#include "live/spi_device.hpp"

namespace biss::live {

/// Buffers at addresses of their own.
class TestMemory final : public CallerMemory {
 public:
  std::uint64_t put(std::vector<std::uint8_t> bytes) {
    const std::uint64_t address = next_;
    next_ += 0x10000;
    buffers_[address] = std::move(bytes);
    return address;
  }
  const std::vector<std::uint8_t>& at(std::uint64_t address) { return buffers_[address]; }
  bool read(std::uint64_t address, std::span<std::uint8_t> to) override {
    const auto from = buffers_.find(address);
    if (from == buffers_.end() || from->second.size() < to.size()) return false;
    std::copy_n(from->second.begin(), to.size(), to.begin());
    return true;
  }
  bool write(std::uint64_t address, std::span<const std::uint8_t> from) override {
    const auto to = buffers_.find(address);
    if (to == buffers_.end() || to->second.size() < from.size()) return false;
    std::copy(from.begin(), from.end(), to->second.begin());
    return true;
  }

 private:
  std::map<std::uint64_t, std::vector<std::uint8_t>> buffers_;
  std::uint64_t next_ = 0x7000'0000'0000;
};

inline sim::LineSetup test_line(const char* format = "pos26,nE,nW,crc6") {
  sim::LineSetup line;
  line.format = parse_format(format).value();
  line.clock = megahertz(5);
  line.ma_delay = line.slo_delay = nanoseconds(50);
  line.processing = microseconds(3);
  line.interval = microseconds(100);
  line.timing.timeout = {TimeoutRule::fixed, microseconds(15)};
  return line;
}

struct VirtualBench {
  explicit VirtualBench(const sim::LineSetup& line = test_line(),
                        const ControllerSetup& bus_setup = {}, Picoseconds step = microseconds(100))
      : encoder({.line = line, .processing_max = line.processing},
                [this](const sim::FarEndCycle& request) { requests.push_back(request); }),
        bus(encoder, bus_setup),
        device(bus, line.clock, {.now = {}, .step = step}),
        format(line.format),
        timing(line.timing) {}

  template <class Value>
  int set(std::uint32_t command, Value value) {
    std::vector<std::uint8_t> bytes(sizeof value);
    std::memcpy(bytes.data(), &value, sizeof value);
    return device.control(command, bytes, memory).result;
  }
  std::uint32_t get(std::uint32_t command) {
    const SpiAnswer answer = device.control(command, {}, memory);
    std::uint32_t value = 0;
    if (answer.result < 0) return 0xFFFF'FFFFU;
    std::memcpy(&value, answer.out.data(), answer.out.size());
    return value;
  }
  int message(const std::vector<spi_ioc_transfer>& transfers) {
    std::vector<std::uint8_t> bytes(transfers.size() * sizeof(spi_ioc_transfer));
    if (!bytes.empty()) std::memcpy(bytes.data(), transfers.data(), bytes.size());
    return device.control(SPI_IOC_MESSAGE_of(transfers.size()), bytes, memory).result;
  }
  static std::uint32_t SPI_IOC_MESSAGE_of(std::size_t count) {
    return _IOC(_IOC_WRITE, SPI_IOC_MAGIC, 0,
                static_cast<std::uint32_t>(count * sizeof(spi_ioc_transfer)));
  }
  /// The bytes of one full-duplex transfer.
  std::vector<std::uint8_t> exchange(std::vector<std::uint8_t> out,
                                     spi_ioc_transfer transfer = {}) {
    transfer.len = static_cast<std::uint32_t>(out.size());
    transfer.rx_buf = memory.put(std::vector<std::uint8_t>(out.size(), 0xA5));
    transfer.tx_buf = memory.put(std::move(out));
    if (message({transfer}) < 0) return {};
    return memory.at(transfer.rx_buf);
  }
  /// The position in these bytes, or the cause why there is none.
  std::string position(const std::vector<std::uint8_t>& bytes,
                       Picoseconds period = nanoseconds(200)) const {
    SpiSetup setup;
    setup.period = period;
    setup.line_delay = {{}, microseconds(1)};
    const SpiReader reader(FrameCodec<>(format), setup, timing);
    const auto frame = reader.read(bytes);
    if (!frame.ok()) return std::string(name_of(frame.error().cause));
    return std::to_string(frame->channels()[0].position);
  }

  std::vector<sim::FarEndCycle> requests;
  TestMemory memory;
  VirtualEncoder encoder;
  SpiBus bus;
  SpiDevice device;
  FrameFormat format;
  DeviceTiming timing;
};

}  // namespace biss::live
