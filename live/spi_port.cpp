#include "live/spi_port.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <linux/spi/spidev.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <utility>

#include "biss/timing/device_timing.hpp"

namespace biss::live {
namespace {

// MA rests high for this many bytes before the first clock and after the last one.
constexpr std::size_t rest_bytes = 1;
// A low and a high half of four clocks.
constexpr std::uint8_t four_clocks = 0x55;

// For the longest timeout, and an eighth of it.
std::size_t bytes_of_cdm(Hertz clock) {
  const Picoseconds time = biss_static_timeout_max + biss_static_timeout_max / 8;
  return static_cast<std::size_t>(clocks_to_cover(time, period_of(clock)) / 4 + 1);
}

std::string problem_of(const std::string& path, int error) {
  switch (error) {
    case ENOENT:
      return fmt::format("{}: not found; is SPI switched on (device tree, `raspi-config`)?", path);
    case EACCES:
    case EPERM:
      return fmt::format("{}: no permission; add your user to the group of the device", path);
    case EWOULDBLOCK:
      return fmt::format("{}: another `biss read` uses it; end it first", path);
    case ENOTTY:
      return fmt::format(
          "{}: is not an SPI device; name a device of spidev, such as /dev/spidev0.0", path);
    case EINVAL:
      return fmt::format("{}: the controller does not accept this mode or clock; try --ma-pin mosi",
                         path);
    default:
      return fmt::format("{}: {}", path, std::strerror(error));
  }
}

PortFault fault_of(int error) {
  switch (error) {
    case ESHUTDOWN:
    case ENODEV:
    case ENXIO:
    case ENOTCONN:
    case ECONNABORTED:
    case ENOTTY:
    case EBADF:
      return PortFault::gone;
    case EBUSY:
      return PortFault::busy;
    case EMSGSIZE:
      return PortFault::too_long;
    case ETIMEDOUT:
      return PortFault::timed_out;
    default:
      return PortFault::failed;
  }
}

}  // namespace

tl::expected<SpiPort, std::string> SpiPort::open(const SpiPortSetup& setup) {
  SpiPort port(setup);
  std::string problem = port.start();
  if (!problem.empty()) return tl::unexpected(std::move(problem));
  return port;
}

SpiPort::SpiPort(SpiPort&& other) noexcept
    : setup_(std::move(other.setup_)), descriptor_(std::exchange(other.descriptor_, -1)) {}

SpiPort::~SpiPort() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

bool SpiPort::reopen() {
  if (descriptor_ >= 0) ::close(std::exchange(descriptor_, -1));
  if (start().empty()) return true;
  // Without a descriptor, the next transfer is `gone` again.
  if (descriptor_ >= 0) ::close(std::exchange(descriptor_, -1));
  return false;
}

// Returns the reason of a failure, or an empty text.
std::string SpiPort::start() {
  const std::string& path = setup_.path;
  descriptor_ = ::open(path.c_str(), O_RDWR | O_CLOEXEC);
  if (descriptor_ < 0) return problem_of(path, errno);
  if (::flock(descriptor_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    return problem_of(path, errno);
  }
  const bool is_mosi = setup_.ma == MaPin::mosi;
  std::uint8_t mode = is_mosi ? SPI_MODE_0 : SPI_MODE_3;
  std::uint8_t bits = 8;
  auto speed = static_cast<std::uint32_t>(setup_.clock.count * (is_mosi ? 2 : 1));
  if (::ioctl(descriptor_, SPI_IOC_WR_MODE, &mode) != 0 ||
      ::ioctl(descriptor_, SPI_IOC_WR_BITS_PER_WORD, &bits) != 0 ||
      ::ioctl(descriptor_, SPI_IOC_WR_MAX_SPEED_HZ, &speed) != 0) {
    return problem_of(path, errno);
  }
  return {};
}

std::optional<PortFault> SpiPort::transfer(std::span<std::uint8_t> receive) {
  spi_ioc_transfer message{};
  std::span<std::uint8_t> into = receive;
  if (setup_.ma == MaPin::mosi) {
    sent_.assign(rest_bytes, 0xFF);
    sent_.insert(sent_.end(), 2 * receive.size(), four_clocks);
    if (cdm_) sent_.insert(sent_.end(), bytes_of_cdm(setup_.clock), *cdm_ ? 0x00 : 0xFF);
    sent_.insert(sent_.end(), rest_bytes, 0xFF);
    sampled_.resize(sent_.size());
    message.tx_buf = reinterpret_cast<std::uintptr_t>(sent_.data());
    into = sampled_;
  }
  message.rx_buf = reinterpret_cast<std::uintptr_t>(into.data());
  message.len = static_cast<std::uint32_t>(into.size());
  const int got = ::ioctl(descriptor_, SPI_IOC_MESSAGE(1), &message);
  error_ = got < 0 ? errno : 0;
  if (got < 0) return fault_of(error_);
  if (static_cast<std::size_t>(got) != into.size()) return PortFault::short_transfer;
  if (into.data() == receive.data()) return std::nullopt;
  // The sample in the high half of each clock.
  for (std::size_t i = 0; i < receive.size(); ++i) {
    unsigned byte = 0;
    for (std::size_t half : {2 * i, 2 * i + 1}) {
      for (int bit = 6; bit >= 0; bit -= 2) {
        byte = byte << 1U | ((sampled_[rest_bytes + half] >> bit) & 1U);
      }
    }
    receive[i] = static_cast<std::uint8_t>(byte);
  }
  return std::nullopt;
}

std::optional<ReachedClock> SpiPort::measure_clock(const std::function<bool()>& go_on) {
  using Clock = std::chrono::steady_clock;
  constexpr std::size_t most = 25;
  constexpr std::size_t least = 5;
  constexpr auto longest = std::chrono::milliseconds(300);
  // The longer one takes 10 ms, and fits into the buffer of spidev (4096 bytes), also with two bits
  // for each clock.
  const std::array<std::size_t, 2> lengths{
      16, std::clamp<std::size_t>(setup_.clock.count / 800, 64, 1024)};
  // The times of each length in nanoseconds.
  std::array<std::vector<std::int64_t>, 2> times;
  std::vector<std::uint8_t> bytes(lengths[1]);
  const auto first = Clock::now();
  while (times[0].size() < most && Clock::now() - first < longest) {
    for (std::size_t k = 0; k < 2; ++k) {
      const auto began = Clock::now();
      if (!go_on() || transfer(std::span(bytes).first(lengths[k]))) return std::nullopt;
      times[k].push_back(std::chrono::nanoseconds(Clock::now() - began).count());
    }
  }
  if (times[0].size() < least) return std::nullopt;
  for (auto& each : times) std::sort(each.begin(), each.end());
  const auto scatter = [](const auto& sorted) { return sorted[sorted.size() / 4] - sorted[0]; };
  const std::int64_t apart = times[1][0] - times[0][0];
  // The time of a transfer without its clocks may depend on its length.
  const std::int64_t asked =
      8 * static_cast<std::int64_t>(lengths[0]) * 1'000'000'000 / std::int64_t{setup_.clock.count};
  const std::int64_t other = std::max<std::int64_t>(times[0][0] - asked, 0);
  const std::int64_t doubt = scatter(times[0]) + scatter(times[1]) + other;
  if (apart <= 4 * doubt) return std::nullopt;
  const auto clocks = static_cast<std::int64_t>(8 * (lengths[1] - lengths[0]));
  const std::int64_t clock = clocks * 1'000'000'000 / apart;
  const std::int64_t uncertainty = clock * doubt / apart + 1;
  // No controller is faster than asked: these times are not the times of a line.
  if (clock - uncertainty > std::int64_t{setup_.clock.count} * 102 / 100) return std::nullopt;
  return ReachedClock{Hertz(static_cast<std::uint32_t>(clock)),
                      Hertz(static_cast<std::uint32_t>(uncertainty))};
}

}  // namespace biss::live
