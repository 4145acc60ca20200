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

template <std::size_t channels>
class Axes final : public LiveAxis {
 public:
  Axes(const FrameFormat& format, const DeviceTiming& timing, const SpiSetup& spi,
       const AxisSetup& setup)
      : reader_(Codec(format), spi, timing), setup_(setup), axis_(transfer_, reader_, setup_) {}

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
    transfer_.received = received;
    axis_.request(now);
    if (received.empty()) return axis_.transfer_failed();
    static_cast<void>(axis_.transfer_complete());
  }
  std::size_t axes() const override { return channels; }
  AxisPosition position(std::size_t k) const override { return axis_.position(k); }
  std::uint32_t count(std::size_t k, AxisCause cause) const override {
    return axis_.axis(k).counts()[cause];
  }
  std::optional<std::pair<std::uint16_t, std::uint16_t>> line_delay_seen() const override {
    return axis_.line_delay_seen();
  }

 private:
  using Codec = FrameCodec<CrcFast, channels>;

  EndedTransfer transfer_;
  SpiReader<Codec> reader_;
  AxisSetup setup_;
  EncoderAxis<EndedTransfer, SpiReader<Codec>, transfer_bytes_max, channels> axis_;
};

template <std::size_t channels>
tl::expected<std::unique_ptr<LiveAxis>, std::string> make_axes(const FrameFormat& format,
                                                               const DeviceTiming& timing,
                                                               const SpiSetup& spi,
                                                               const AxisSetup& setup) {
  if (format.channel_count == channels) {
    auto axes = std::make_unique<Axes<channels>>(format, timing, spi, setup);
    std::string error = axes->error();
    if (!error.empty()) return tl::unexpected(std::move(error));
    return axes;
  }
  if constexpr (channels < max_channels) {
    return make_axes<channels + 1>(format, timing, spi, setup);
  } else {
    return tl::unexpected(std::string("the format has no channel"));
  }
}

}  // namespace

tl::expected<std::unique_ptr<LiveAxis>, std::string> LiveAxis::make(const FrameFormat& format,
                                                                    const DeviceTiming& timing,
                                                                    const SpiSetup& spi,
                                                                    const AxisSetup& setup) {
  return make_axes<1>(format, timing, spi, setup);
}

}  // namespace biss::live
