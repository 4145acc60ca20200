#include "capture/saleae_binary.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>

#include "capture/little_endian.hpp"
#include "capture/seconds.hpp"

namespace biss::capture {
namespace {

constexpr std::size_t chunk_count_bytes = 8;  // of version 1
constexpr std::size_t chunk_bytes_of_0 = 28;  // level, begin, end, number of changes
constexpr std::size_t chunk_bytes_of_1 = 36;  // with the sample rate after the level
constexpr std::uint32_t digital_export = 0;

class SaleaeBinary final : public StepSource {
 public:
  /// \param bytes after the header
  SaleaeBinary(ByteTaker bytes, std::uint64_t version, std::string name)
      : bytes_(std::move(bytes)), version_(version) {
    set_lines({std::move(name)});
  }

  /// Reads up to the first chunk; the cause when there is none.
  std::optional<CaptureError> open() {
    if (version_ == 1) {
      const char* const count = take(chunk_count_bytes, "the number of chunks");
      if (count == nullptr) return error();
      chunks_ = get_number(count, chunk_count_bytes);
      if (chunks_ == 0) return CaptureError{.cause = CaptureCause::empty};
    }
    if (!begin_chunk()) return error();
    return std::nullopt;
  }

  Picoseconds sample_period() const override { return period_; }
  Hertz sample_rate() const override { return rate_; }

 private:
  void step() override {
    while (!ended() && !block_.full()) {
      if (changes_left_ != 0) {
        read_changes();
      } else if (chunk_ < chunks_) {
        begin_chunk();
      } else {
        end();
      }
    }
  }

  // Null after the end, which is `truncated`.
  const char* take(std::size_t bytes, const char* expected) {
    const char* const taken = bytes_.take(bytes);
    if (taken != nullptr) return taken;
    if (!bytes_.error()) {
      stop(CaptureCause::truncated, expected);
    } else {
      fail(*bytes_.error());
    }
    return nullptr;
  }

  bool take_time(const char* at, Picoseconds earliest, Picoseconds& time) {
    const auto found = picoseconds_of(get_double(at));
    if (!found.ok()) {
      stop(found.error(), "a time that is a number");
    } else if (*found < earliest) {
      stop(CaptureCause::time_backwards);
    } else {
      time = *found;
    }
    return !ended();
  }

  bool begin_chunk() {
    ++chunk_;
    const std::size_t bytes = version_ == 0 ? chunk_bytes_of_0 : chunk_bytes_of_1;
    const char* at = take(bytes, "the header of a chunk");
    if (at == nullptr) return false;
    const std::uint64_t level = get_number(at, 4);
    if (level > 1) {
      stop(CaptureCause::malformed, "0 or 1 as the first level");
      return false;
    }
    at += 4;
    const Picoseconds gap = chunk_period_;
    if (version_ != 0) {
      if (!take_rate(get_double(at))) return false;
      at += 8;
    }
    Picoseconds begin;
    const Picoseconds earliest = chunk_ == 1 ? Picoseconds{INT64_MIN} : end_time_;
    if (!take_time(at, earliest, begin) || !take_time(at + 8, begin, chunk_end_)) return false;
    changes_left_ = get_number(at + 16, 8);
    // The difference of two times may exceed the range of a time.
    const auto later = static_cast<std::uint64_t>(begin.count) -
                       static_cast<std::uint64_t>(chunk_ == 1 ? begin.count : end_time_.count);
    if (later > static_cast<std::uint64_t>(gap.count)) push(end_time_, wire::Level::unknown);
    push(begin, level == 1 ? wire::Level::high : wire::Level::low);
    end_time_ = begin;
    end_chunk_when_read();
    return true;
  }

  // A rate of 0 is unknown.
  bool take_rate(double rate) {
    constexpr double fastest = 1e12;
    if (!(rate >= 0) || rate > fastest) {
      stop(CaptureCause::malformed, "a sample rate of 0 to 1 THz");
      return false;
    }
    chunk_period_ = rate == 0 ? Picoseconds{} : period_of_rate(rate);
    period_ = std::max(period_, chunk_period_);
    const Hertz of_chunk = whole_rate(rate);
    rate_ = chunk_ == 1 || rate_ == of_chunk ? of_chunk : Hertz{};
    return true;
  }

  void end_chunk_when_read() {
    if (changes_left_ == 0) end_time_ = std::max(end_time_, chunk_end_);
  }

  void read_changes() {
    constexpr auto high = static_cast<std::uint8_t>(wire::Level::high);
    while (changes_left_ != 0 && !block_.full()) {
      const char* const at = take(8, "as many changes as the chunk has");
      if (at == nullptr || !take_time(at, end_time_, end_time_)) return;
      push(end_time_, level_ == high ? wire::Level::low : wire::Level::high);
      --changes_left_;
    }
    end_chunk_when_read();
  }

  void end() {
    finish();
    if (bytes_.take(1) != nullptr) {
      stop(CaptureCause::malformed, "the end of the file after the last change");
    } else if (bytes_.error()) {
      fail(*bytes_.error());
    }
  }

  void stop(CaptureCause cause, const char* expected = nullptr) {
    CaptureError error{.cause = cause, .expected = expected};
    if (version_ != 0 && chunk_ != 0) {
      error.part = "chunk";
      error.part_number = chunk_;
    }
    fail(error);
  }

  void push(Picoseconds time, wire::Level level) {
    if (level_ == static_cast<std::uint8_t>(level)) return;
    level_ = static_cast<std::uint8_t>(level);
    block_.push({time, 0, level});
  }

  ByteTaker bytes_;
  std::uint64_t version_;
  std::uint64_t chunks_ = 1;  // in the file
  std::uint64_t chunk_ = 0;   // being read, from 1
  std::uint64_t changes_left_ = 0;
  Picoseconds chunk_end_;
  Picoseconds chunk_period_;
  Picoseconds period_;
  Hertz rate_;
  std::uint8_t level_ = no_level;
};

}  // namespace

SaleaeBinaryWriter::SaleaeBinaryWriter(std::vector<std::string> lines, Hertz rate, ByteSink& sink)
    : EdgeWriter(std::move(lines), sink), rate_(rate) {
  if (this->lines().size() > 1) refuse(WriteCause::too_many_lines);
}

void SaleaeBinaryWriter::put(const wire::Edge& edge, bool) {
  if (edge.level == wire::Level::unknown) {
    if (level_ != wire::Level::unknown) end_chunk(edge.time);
  } else if (level_ == wire::Level::unknown) {
    first_level_ = edge.level;
    begin_ = edge.time;
  } else {
    std::string change;
    put_double(change, seconds_of(edge.time));
    if (!changes_.append(change)) refuse(WriteCause::write_failed);
    ++changes_in_chunk_;
  }
  level_ = edge.level;
  last_ = edge.time;
}

// The header of the chunk, as version 1 has it.
void SaleaeBinaryWriter::end_chunk(Picoseconds end) {
  std::string header;
  put_number(header, first_level_ == wire::Level::high ? 1 : 0, 4);
  put_double(header, rate_.count);
  put_double(header, seconds_of(begin_));
  put_double(header, seconds_of(end));
  put_number(header, changes_in_chunk_, 8);
  if (!chunks_.append(header)) refuse(WriteCause::write_failed);
  changes_in_chunk_ = 0;
  ++chunk_count_;
}

void SaleaeBinaryWriter::put_end(Picoseconds end_time, bool later) {
  // A channel without a known level gets one, so that the file can be read.
  if (level_ == wire::Level::unknown && chunk_count_ == 0) {
    first_level_ = wire::Level::low;
    begin_ = end_time;
    level_ = wire::Level::low;
    later = true;
  }
  if (level_ != wire::Level::unknown) end_chunk(later ? end_time : last_);
  if (!changes_.rewind() || !chunks_.rewind()) return refuse(WriteCause::write_failed);
  const std::uint64_t version = chunk_count_ == 1 ? 0 : 1;
  text() += saleae_magic;
  put_number(text(), version, 4);
  put_number(text(), digital_export, 4);
  if (version == 1) put_number(text(), chunk_count_, chunk_count_bytes);
  std::array<char, chunk_bytes_of_1> header{};
  for (; chunk_count_ != 0; --chunk_count_) {
    if (chunks_.read(header) != header.size()) return refuse(WriteCause::write_failed);
    const std::string_view bytes(header.data(), header.size());
    text() += bytes.substr(0, 4);
    text() += bytes.substr(version == 0 ? 12 : 4);
    put_changes(get_number(header.data() + 28, 8));
  }
}

void SaleaeBinaryWriter::put_changes(std::uint64_t changes) {
  constexpr std::uint64_t at_once = 1'024;
  std::array<char, 8 * at_once> block{};
  while (changes != 0) {
    const auto some = static_cast<std::size_t>(std::min(changes, at_once));
    const std::span<char> bytes = std::span(block).first(8 * some);
    if (changes_.read(bytes) != bytes.size()) return refuse(WriteCause::write_failed);
    text().append(bytes.data(), bytes.size());
    changes -= some;
    if (!flush_full()) return;
  }
}

namespace {

// Source of the layout: the format description of Saleae's support pages for Logic 2 exports.
constexpr std::uint32_t analog_export = 1;
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
  /// \param bytes after the header
  SaleaeAnalogReader(ByteTaker bytes, std::uint64_t version, std::string name)
      : bytes_(std::move(bytes)), channels_{{.name = std::move(name)}}, version_(version) {}

  // Reads up to the first waveform; the cause when there is none.
  std::optional<CaptureError> open() {
    if (version_ == 1) {
      const char* const count = bytes_.take(8);
      if (count == nullptr) return missing("a whole header");
      waveforms_left_ = get_number(count, 8);
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
  CaptureError missing(const char* expected) const {
    return bytes_.error().value_or(
        CaptureError{.cause = CaptureCause::truncated, .expected = expected});
  }

  std::optional<CaptureError> open_waveform() {
    const char* const at = bytes_.take(version_ == 0 ? 32 : 40);
    if (at == nullptr) return missing("a whole header");
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
    while (next_sample_ < waveform_.samples && rows.times.size() < samples_of_block) {
      const char* const at = bytes_.take(4);
      if (at == nullptr) return missing("as many samples as the header gives");
      const auto bits = static_cast<std::uint32_t>(get_number(at, 4));
      if (const auto error = put(std::bit_cast<float>(bits), rows)) return error;
    }
    return std::nullopt;
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

  ByteTaker bytes_;
  std::vector<AnalogChannel> channels_;
  std::uint64_t version_;
  std::uint64_t waveforms_left_ = 1;
  bool first_waveform_ = true;
  Waveform waveform_;
  std::uint64_t next_sample_ = 0;
  Picoseconds sample_period_;
  Hertz sample_rate_;
  std::optional<Picoseconds> last_time_;
  std::optional<CaptureError> error_;
};

}  // namespace

Opened open_saleae_binary(std::unique_ptr<ByteSource> bytes, std::string name,
                          const AnalogOptions& options) {
  const auto failed = [](CaptureCause cause, const char* expected) {
    return tl::unexpected(CaptureError{.cause = cause, .expected = expected});
  };
  ByteTaker taker(std::move(bytes));
  const char* const header = taker.take(saleae_header_bytes);
  if (header == nullptr && taker.error()) return tl::unexpected(*taker.error());
  if (header == nullptr) return failed(CaptureCause::truncated, "the header");
  const std::uint64_t version = get_number(header + 8, 4);
  const std::uint64_t type = get_number(header + 12, 4);
  if (version > 1) {
    return failed(CaptureCause::unknown_format,
                  type == analog_export
                      ? "version 0 or 1 of Saleae's analog export"
                      : "version 0 or 1 of Saleae's binary export; this is a newer one");
  }
  if (type == digital_export) {
    if (name.empty()) name = "digital";
    auto reader = std::make_unique<SaleaeBinary>(std::move(taker), version, std::move(name));
    if (const auto error = reader->open()) return tl::unexpected(*error);
    return reader;
  }
  if (type != analog_export) {
    return failed(CaptureCause::malformed, "type 0 (digital) or 1 (analog)");
  }
  if (name.empty()) name = "analog";
  auto reader = std::make_unique<SaleaeAnalogReader>(std::move(taker), version, std::move(name));
  if (const auto error = reader->open()) return tl::unexpected(*error);
  return open_analog(std::move(reader), options);
}

}  // namespace biss::capture
