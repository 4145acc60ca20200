// The frame formats in Python: encode, decode, and read SPI buffers.
#include <fmt/format.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "biss/base/bits.hpp"
#include "biss/crc/engines.hpp"
#include "biss/frame/decode.hpp"
#include "biss/frame/encode.hpp"
#include "biss/frame/format_text.hpp"
#include "biss/master/spi_read.hpp"
#include "python/module.hpp"
#include "python/numpy_arrays.hpp"
#include "verbs/common/format_option.hpp"

namespace biss::python {
namespace {

using Codec = FrameCodec<>;
// Position, life counter, nE, nW.
using ChannelValues = std::tuple<std::uint64_t, std::uint32_t, bool, bool>;

constexpr std::size_t most_frame_bytes = 65'536;

// In the order of EncodeError.
constexpr auto encode_texts = std::to_array<const char*>(
    {"the format has a different number of channels", "position: does not fit its channel",
     "life_counter: does not fit its channel", "ack_clocks: from 1 to 400",
     "lead_clocks: from 0 to 402", "the CRC belongs to the frame before (:previous)"});

UsageError usage_error(EncodeError error) {
  return UsageError(encode_texts[static_cast<std::size_t>(error)]);
}

std::span<const std::uint8_t> bytes_of(const py::bytes& bytes) {
  const std::string_view text = bytes;
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

// (None, channels, cds, stop_seen, lead_clocks, ack_clocks), or (cause, channel).
template <class Result>
py::tuple tuple_of(const Result& result) {
  if (!result.ok()) {
    const FrameFault& fault = result.error();
    return py::make_tuple(std::string(name_of(fault.cause)), fault.channel);
  }
  py::list channels;
  for (const Channel& channel : result->channels()) {
    channels.append(py::make_tuple(channel.position, channel.life_counter, channel.nE, channel.nW));
  }
  return py::make_tuple(py::none(), channels, result->cds, result->stop_seen, result->lead_clocks,
                        result->ack_clocks);
}

class FormatObject {
 public:
  FormatObject(const biss::Device& device) : device_(device), codec_(device.format) {}

  std::string text() const { return std::string(format_text(device_.format).view()); }
  unsigned payload_bits() const { return device_.format.payload_bits(); }
  const Codec& codec() const { return codec_; }
  const DeviceTiming& timing() const { return device_.timing; }

  py::list channels() const {
    py::list channels;
    for (const ChannelFormat& channel : device_.format.channels()) {
      py::dict about;
      about["data_bits"] = channel.data_bits;
      about["position_bits"] = channel.position_bits();
      about["multiturn_bits"] = channel.multiturn.bits;
      about["singleturn_bits"] = channel.singleturn.bits;
      about["life_counter_bits"] = channel.life_counter.bits;
      const char* const error = channel.error.active_high ? "E" : "nE";
      const char* const warning = channel.warning.active_high ? "W" : "nW";
      // A null pointer becomes None.
      about["error"] = channel.error.present ? error : nullptr;
      about["warning"] = channel.warning.present ? warning : nullptr;
      about["crc_bits"] = channel.crc.width_bits;
      about["polynomial"] = channel.crc.polynomial;
      channels.append(about);
    }
    return channels;
  }

  py::tuple encode(const std::vector<ChannelValues>& channels, bool cds, std::uint16_t lead_clocks,
                   std::uint16_t ack_clocks) const {
    Frame frame;
    if (channels.size() > max_channels) throw UsageError("at most 8 channels");
    for (const auto& [position, life_counter, nE, nW] : channels) {
      frame.channel_list[frame.channel_count++] = {position, life_counter, nE, nW};
    }
    frame.cds = cds;
    frame.lead_clocks = lead_clocks;
    frame.ack_clocks = ack_clocks;
    const auto bits = encode_frame(frame, codec_);
    if (!bits.ok()) throw usage_error(bits.error());
    const BitView view = bits->view();
    std::string bytes;
    for (std::size_t at = 0; at < view.size_bits(); at += 8) {
      const auto now = static_cast<unsigned>(std::min<std::size_t>(8, view.size_bits() - at));
      bytes.push_back(static_cast<char>(view.word(at, now) << (8U - now)));
    }
    return py::make_tuple(py::bytes(bytes), view.size_bits());
  }

  py::tuple decode(const py::bytes& buffer, std::size_t first_bit,
                   std::optional<std::size_t> bits) const {
    if (device_.format.needs_previous()) throw usage_error(EncodeError::needs_previous);
    const auto bytes = bytes_of(buffer);
    if (bytes.size() > most_frame_bytes) throw UsageError("a frame has at most 64 KiB");
    const std::size_t all = 8 * bytes.size();
    if (first_bit > all || bits.value_or(0) > all - first_bit) {
      throw UsageError(fmt::format("the buffer has {} bits", all));
    }
    return tuple_of(
        decode_frame(BitView(bytes, first_bit, bits.value_or(all - first_bit)), codec_));
  }

  unsigned crc(std::uint64_t data, std::size_t channel) const {
    if (channel >= device_.format.channel_count) throw UsageError("no such channel");
    const ChannelFormat& format = device_.format.channel_list[channel];
    if (!format.crc.present()) throw UsageError("the channel has no CRC");
    if ((data & ~low_mask(format.data_bits)) != 0) {
      throw UsageError(fmt::format("the channel has {} data bits", format.data_bits));
    }
    return codec_.crc(channel, data, false);
  }

 private:
  biss::Device device_;
  Codec codec_;
};

FormatObject format_of(const std::string& format, const std::string& ack_max,
                       const std::string& ack_clocks, const std::string& timeout,
                       const std::string& release, const std::string& clock_max,
                       const std::string& cycle_min) {
  const auto device =
      biss::choose_device({format, ack_max, ack_clocks, timeout, release, clock_max, cycle_min});
  if (!device) throw UsageError(device.error());
  return FormatObject(*device);
}

class SpiObject {
 public:
  SpiObject(const FormatObject& format, const SpiSetup& setup)
      : channels_(format.codec().format().channel_count),
        reader_(format.codec(), setup, format.timing()) {
    if (reader_.error()) throw UsageError(std::string(text_of(*reader_.error())));
  }

  std::size_t bytes() const { return reader_.bytes(); }
  std::size_t clocks() const { return reader_.clocks(); }

  py::tuple read(const py::bytes& buffer, std::optional<std::size_t> clocks) const {
    return tuple_of(reader_.read(bytes_of(buffer), clocks.value_or(reader_.clocks())));
  }

  // A row each: (number of the cause or 0, position, life counter, nE, nW), the last four by channel.
  py::tuple read_all(const py::array& array, std::optional<std::size_t> clocks) const {
    const std::size_t bits = clocks.value_or(reader_.clocks());
    if (!py::isinstance<py::array_t<std::uint8_t>>(array)) {
      throw py::type_error("an array of uint8 is needed");
    }
    const bool gaps =
        array.size() != 0 && array.ndim() == 2 && array.shape(1) > 1 && array.strides(1) != 1;
    if (array.ndim() != 2 || gaps) {
      throw UsageError("an array with a buffer of contiguous bytes in each row is needed");
    }
    const auto rows = static_cast<std::size_t>(array.shape(0));
    const auto width = static_cast<std::size_t>(array.shape(1));
    const auto stride = array.strides(0);
    const auto* const data = static_cast<const std::uint8_t*>(array.data());
    std::vector<std::uint8_t> causes(rows);
    std::vector<std::uint64_t> positions(rows * channels_);
    std::vector<std::uint32_t> counters(rows * channels_);
    std::vector<std::uint8_t> nE(rows * channels_);
    std::vector<std::uint8_t> nW(rows * channels_);
    {
      const py::gil_scoped_release released;
      for (std::size_t row = 0; row < rows; ++row) {
        const auto* const begin = data + static_cast<py::ssize_t>(row) * stride;
        const auto frame = reader_.read(std::span(begin, width), bits);
        if (!frame.ok()) {
          causes[row] = static_cast<std::uint8_t>(1 + static_cast<unsigned>(frame.error().cause));
          continue;
        }
        for (std::size_t k = 0; k < channels_; ++k) {
          const Channel& channel = frame->channel_list[k];
          positions[row * channels_ + k] = channel.position;
          counters[row * channels_ + k] = channel.life_counter;
          nE[row * channels_ + k] = channel.nE ? 1 : 0;
          nW[row * channels_ + k] = channel.nW ? 1 : 0;
        }
      }
    }
    const std::vector<py::ssize_t> shape{static_cast<py::ssize_t>(rows),
                                         static_cast<py::ssize_t>(channels_)};
    return py::make_tuple(array_of(std::move(causes)), array_of(std::move(positions), shape),
                          array_of(std::move(counters), shape), array_of(std::move(nE), shape),
                          array_of(std::move(nW), shape));
  }

 private:
  std::size_t channels_;
  SpiReader<Codec> reader_;
};

SpiObject spi_of(const FormatObject& format, std::int64_t period, bool falling,
                 std::int64_t delay_min, std::int64_t delay_max, std::uint16_t first_bit,
                 bool tail_ignored, bool no_error_flag, bool unchecked) {
  // One clock in a second is slower than any device.
  constexpr std::int64_t longest = picoseconds_per_second;
  if (period < 32 || period > longest) throw UsageError("the clock is from 1 Hz to 31.25 GHz");
  if (delay_min < 0 || delay_min > delay_max || delay_max > longest) {
    throw UsageError("line delay: 0 <= min <= max <= 1 s");
  }
  return {format,
          {.period = picoseconds(period),
           .phase = falling ? SpiPhase::sample_on_falling : SpiPhase::sample_on_rising,
           .line_delay = {picoseconds(delay_min), picoseconds(delay_max)},
           .first_bit = first_bit,
           .tail = tail_ignored ? SpiTail::ignored : SpiTail::must_stay_low,
           .no_error_flag = no_error_flag,
           .unchecked = unchecked}};
}

unsigned crc_of(std::uint64_t data, unsigned bits, unsigned width, std::uint32_t polynomial,
                std::uint16_t start, bool inverted) {
  if (bits == 0 || bits > max_data_bits) throw UsageError("bits: from 1 to 64");
  if (width < min_crc_bits || width > max_crc_bits) throw UsageError("width: from 3 to 16");
  if ((data & ~low_mask(bits)) != 0) throw UsageError("data: more than `bits` bits");
  CrcSpec spec{.polynomial = polynomial != 0 ? polynomial : default_polynomial(width),
               .start = start,
               .width_bits = static_cast<std::uint8_t>(width),
               .inverted = inverted};
  if (!is_full_form(spec.polynomial, width)) {
    throw UsageError("polynomial: the full form with the top and the bottom bit, such as 0x43");
  }
  if ((start & ~spec.mask()) != 0) throw UsageError("start: wider than the checksum");
  return CrcBitwise(spec)(data, bits);
}

}  // namespace

void add_frames(py::module_& module) {
  py::class_<FormatObject>(module, "Format")
      .def(py::init(&format_of))
      .def_property_readonly("text", &FormatObject::text)
      .def_property_readonly("payload_bits", &FormatObject::payload_bits)
      .def_property_readonly("channels", &FormatObject::channels)
      .def("encode", &FormatObject::encode)
      .def("decode", &FormatObject::decode)
      .def("crc", &FormatObject::crc);
  py::class_<SpiObject>(module, "Spi")
      .def(py::init(&spi_of))
      .def_property_readonly("transfer_bytes", &SpiObject::bytes)
      .def_property_readonly("clocks", &SpiObject::clocks)
      .def("read", &SpiObject::read)
      .def("read_all", &SpiObject::read_all);
  module.def("crc", &crc_of);
  py::list statuses;
  for (const std::string_view name : cycle_status_names) statuses.append(std::string(name));
  module.attr("statuses") = py::tuple(statuses);
}

}  // namespace biss::python
