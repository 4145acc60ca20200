#include "capture/saleae_analog.hpp"

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "capture/little_endian.hpp"
#include "capture/saleae_binary.hpp"
#include "capture/seconds.hpp"

namespace biss::capture {
namespace {

// Source of the layout: the format description of Saleae's support pages for Logic 2 exports.
constexpr std::uint32_t analog_type = 1;
constexpr std::size_t type_offset = 12;
constexpr std::size_t samples_of_block = 4'096;

// A waveform: samples at an even rate.
struct Waveform {
  double begin = 0;
  double period = 0;  // s
  std::uint64_t samples = 0;
};

CaptureError wrong(const char* expected) {
  return {.cause = CaptureCause::malformed, .expected = expected, .part = "header"};
}

class SaleaeAnalogReader final : public AnalogSamples {
 public:
  SaleaeAnalogReader(std::unique_ptr<ByteSource> bytes, std::string name)
      : bytes_(std::move(bytes)), channels_{{.name = std::move(name)}} {}

  // Reads the header; the cause when there is none.
  std::optional<CaptureError> open() {
    if (const auto error = take_all(buffer_.data(), saleae_header_bytes)) return error;
    version_ = static_cast<std::uint32_t>(get_number(buffer_.data() + 8, 4));
    if (version_ > 1) {
      return CaptureError{.cause = CaptureCause::unknown_format,
                          .expected = "version 0 or 1 of Saleae's analog export"};
    }
    waveforms_left_ = 1;
    if (version_ == 1) {
      if (const auto error = take_all(buffer_.data(), 8)) return error;
      waveforms_left_ = get_number(buffer_.data(), 8);
    }
    if (waveforms_left_ == 0) return CaptureError{.cause = CaptureCause::empty};
    if (const auto error = open_waveform()) return error;
    if (waveform_.samples == 0 && waveforms_left_ == 0) {
      return CaptureError{.cause = CaptureCause::empty};
    }
    return std::nullopt;
  }

  const std::vector<AnalogChannel>& channels() const override { return channels_; }
  Picoseconds sample_period() const override { return sample_period_; }
  Hertz sample_rate() const override { return sample_rate_; }
  std::optional<CaptureError> next(SampleRows& rows) override {
    while (!error_ && rows.times.empty()) {
      if (next_sample_ < waveform_.samples) {
        error_ = read_samples(rows);
      } else if (waveforms_left_ != 0) {
        error_ = open_waveform();
      } else {
        break;
      }
    }
    return error_;
  }

 private:
  // Fills `into`, or as much of it as there is.
  std::optional<CaptureError> take(char* into, std::size_t count, std::size_t& got) {
    got = 0;
    while (got < count) {
      const auto piece = bytes_->read({into + got, count - got});
      if (!piece.ok()) return piece.error();
      if (*piece == 0) break;
      got += *piece;
    }
    return std::nullopt;
  }

  std::optional<CaptureError> take_all(char* into, std::size_t count) {
    std::size_t got = 0;
    if (const auto error = take(into, count, got)) return error;
    if (got == count) return std::nullopt;
    return CaptureError{.cause = CaptureCause::truncated, .expected = "a whole header"};
  }

  std::optional<CaptureError> open_waveform() {
    const char* const at = buffer_.data();
    if (const auto error = take_all(buffer_.data(), version_ == 0 ? 32 : 40)) return error;
    double rate = 0;
    double downsample = 0;
    waveform_.begin = get_double(at);
    if (version_ == 0) {
      rate = static_cast<double>(get_number(at + 8, 8));
      downsample = static_cast<double>(get_number(at + 16, 8));
      waveform_.samples = get_number(at + 24, 8);
    } else {
      // The time of the trigger, at 8, is not needed.
      rate = get_double(at + 16);
      downsample = static_cast<double>(static_cast<std::int64_t>(get_number(at + 24, 8)));
      waveform_.samples = get_number(at + 32, 8);
    }
    if (!(rate >= 1e-3 && rate <= 1e12)) return wrong("a sample rate");
    if (!(downsample >= 1 && downsample <= 1e9)) return wrong("a downsample factor of 1 or more");
    if (const auto begin = picoseconds_of(waveform_.begin); !begin.ok()) {
      return CaptureError{.cause = begin.error(), .expected = "a time", .part = "header"};
    }
    waveform_.period = downsample / rate;
    next_sample_ = 0;
    --waveforms_left_;
    const Hertz of_waveform = whole_rate(rate / downsample);
    if (std::exchange(first_waveform_, false)) {
      sample_period_ = period_of_rate(rate / downsample);
      sample_rate_ = of_waveform;
    } else if (sample_rate_ != of_waveform) {
      sample_rate_ = {};
    }
    return std::nullopt;
  }

  std::optional<CaptureError> read_samples(SampleRows& rows) {
    const std::uint64_t left = waveform_.samples - next_sample_;
    const std::size_t wanted =
        4 * static_cast<std::size_t>(std::min<std::uint64_t>(left, samples_of_block));
    std::size_t got = 0;
    const auto failed = take(buffer_.data(), wanted, got);
    for (std::size_t i = 0; i + 4 <= got; i += 4) {
      const auto bits = static_cast<std::uint32_t>(get_number(buffer_.data() + i, 4));
      if (const auto error = put(std::bit_cast<float>(bits), rows)) return error;
    }
    if (failed) return failed;
    if (got == wanted) return std::nullopt;
    return CaptureError{.cause = CaptureCause::truncated,
                        .expected = "as many samples as the header gives"};
  }

  std::optional<CaptureError> put(float volts, SampleRows& rows) {
    const auto found =
        picoseconds_of(waveform_.begin + static_cast<double>(next_sample_) * waveform_.period);
    if (!found.ok()) return CaptureError{.cause = found.error()};
    const Picoseconds time = *found;
    if (last_time_ && time < *last_time_)
      return CaptureError{.cause = CaptureCause::time_backwards};
    if (next_sample_ == 0 && last_time_) {
      // Between two waveforms nothing is known.
      rows.times.push_back(*last_time_);
      rows.values.push_back(bad_sample);
    }
    Nanovolts value = bad_sample;
    const double limit = static_cast<double>(over_range.count);
    const double nanovolts = static_cast<double>(volts) * 1e9;
    if (!std::isnan(nanovolts)) {
      value = Nanovolts{std::llround(std::min(std::max(nanovolts, -limit), limit))};
    }
    last_time_ = time;
    ++next_sample_;
    rows.times.push_back(time);
    rows.values.push_back(value);
    return std::nullopt;
  }

  std::unique_ptr<ByteSource> bytes_;
  std::vector<AnalogChannel> channels_;
  std::uint32_t version_ = 0;
  std::uint64_t waveforms_left_ = 0;
  bool first_waveform_ = true;
  Waveform waveform_;
  std::uint64_t next_sample_ = 0;
  Picoseconds sample_period_;
  Hertz sample_rate_;
  std::optional<Picoseconds> last_time_;
  std::array<char, 4 * samples_of_block> buffer_;
  std::optional<CaptureError> error_;
};

}  // namespace

bool looks_like_saleae_analog(std::string_view head) {
  return head.size() >= saleae_header_bytes && head.starts_with(saleae_magic) &&
         get_number(head.data() + type_offset, 4) == analog_type;
}

Opened open_saleae_analog(std::unique_ptr<ByteSource> bytes, std::string name,
                          const AnalogOptions& options) {
  auto reader = std::make_unique<SaleaeAnalogReader>(std::move(bytes), std::move(name));
  if (const auto error = reader->open()) return tl::unexpected(*error);
  return open_analog(std::move(reader), options);
}

}  // namespace biss::capture
