#include "live/live_axis.hpp"

#include <algorithm>

#include "biss/axis/encoder_axis.hpp"
#include "biss/frame/codec.hpp"

namespace biss::live {
namespace {

/// Gives the axes the bytes of a transfer that has ended.
struct EndedTransfer {
  std::span<const std::uint8_t> received;

  bool start(std::span<std::uint8_t> receive) const {
    std::copy_n(received.begin(), std::min(received.size(), receive.size()), receive.begin());
    return true;
  }
};

/// Keeps the last good frame.
template <class Codec>
struct KeepingReader : SpiReader<Codec> {
  using SpiReader<Codec>::SpiReader;

  auto read(std::span<const std::uint8_t> received) const {
    const auto frame = SpiReader<Codec>::read(received);
    if (!frame.ok()) return frame;
    last.emplace();
    std::copy(frame->channel_list.begin(), frame->channel_list.end(), last->channel_list.begin());
    last->lead_clocks = frame->lead_clocks;
    last->ack_clocks = frame->ack_clocks;
    return frame;
  }

  mutable std::optional<Frame> last;
};

template <std::size_t channels>
class Axes final : public LiveAxis {
 public:
  Axes(const FrameFormat& format, const DeviceTiming& timing, const SpiSetup& spi,
       std::span<const AxisSetup> setups)
      : reader_(Codec(format), spi, timing), axis_(transfer_, reader_, keep(setups)) {}

  std::string error() const {
    if (reader_.error()) return std::string(text_of(*reader_.error()));
    const auto error = axis_.error();
    if (!error) return {};
    return *error == AxisError::buffer   ? "a frame has too many clocks for one transfer"
           : *error == AxisError::format ? "a channel has no position of 1 to 62 bits"
                                         : "the rate, or the largest step, fits no axis";
  }

  std::size_t bytes() const override { return reader_.bytes(); }
  void take(Picoseconds now, std::span<const std::uint8_t> received) override {
    for (std::size_t k = 0; k < channels; ++k) {
      const AxisPosition last = axis_.position(k);
      const bool lost = last.state == AxisState::tripped || last.cause == AxisCause::turns;
      if (lost) axis_.axis(k).reset();
    }
    transfer_.received = received;
    axis_.request(now);
    if (received.empty()) return axis_.transfer_failed();
    static_cast<void>(axis_.transfer_complete());
  }
  std::size_t axes() const override { return channels; }
  AxisPosition position(std::size_t k) const override { return axis_.position(k); }
  const std::optional<Frame>& frame() const override { return reader_.last; }
  std::uint32_t count(std::size_t k, AxisCause cause) const override {
    return axis_.axis(k).counts()[cause];
  }
  std::optional<std::pair<std::uint16_t, std::uint16_t>> line_delay_seen() const override {
    return axis_.line_delay_seen();
  }

 private:
  using Codec = FrameCodec<CrcFast, channels>;

  std::array<const AxisSetup*, channels> keep(std::span<const AxisSetup> setups) {
    std::array<const AxisSetup*, channels> kept{};
    for (std::size_t k = 0; k < channels; ++k) kept[k] = &(setups_[k] = setups[k]);
    return kept;
  }

  EndedTransfer transfer_;
  KeepingReader<Codec> reader_;
  std::array<AxisSetup, channels> setups_{};
  EncoderAxis<EndedTransfer, KeepingReader<Codec>, transfer_bytes_max, channels> axis_;
};

template <std::size_t channels>
tl::expected<std::unique_ptr<LiveAxis>, std::string> make_axes(const FrameFormat& format,
                                                               const DeviceTiming& timing,
                                                               const SpiSetup& spi,
                                                               std::span<const AxisSetup> setups) {
  if (format.channel_count == channels) {
    auto axes = std::make_unique<Axes<channels>>(format, timing, spi, setups);
    std::string error = axes->error();
    if (!error.empty()) return tl::unexpected(std::move(error));
    return axes;
  }
  if constexpr (channels < max_channels) {
    return make_axes<channels + 1>(format, timing, spi, setups);
  } else {
    return tl::unexpected(std::string("the format has no channel"));
  }
}

}  // namespace

tl::expected<std::unique_ptr<LiveAxis>, std::string> LiveAxis::make(
    const FrameFormat& format, const DeviceTiming& timing, const SpiSetup& spi,
    std::span<const AxisSetup> setups) {
  return make_axes<1>(format, timing, spi, setups);
}

}  // namespace biss::live
