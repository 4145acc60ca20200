#include "capture/samples.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <utility>

#include "capture/little_endian.hpp"
#include "capture/sampled_pairs.hpp"

namespace biss::capture {
namespace {

template <std::size_t UnitBytes>
std::uint64_t load(const std::uint8_t* at) {
  std::uint64_t sample = 0;
  std::memcpy(&sample, at, UnitBytes);
  return sample;
}

// As many copies of the sample as fill a word.
template <std::size_t UnitBytes>
constexpr std::uint64_t repeated(std::uint64_t sample) {
  for (std::size_t bytes = UnitBytes; bytes < sizeof sample; bytes *= 2) {
    sample |= sample << (8U * bytes % 64U);
  }
  return sample;
}

/// Finds the changes in a stream of samples that comes in pieces of any length. A change has the time
/// of the first sample that shows it; the first sample gives each line's initial level, at time 0.
class SampleScanner {
 public:
  /// \pre fault_of(layout) is null
  explicit SampleScanner(const RawLayout& layout)
      : clock_(layout.rate), last_index_(clock_.last_index()), unit_bytes_(layout.unit_bytes) {
    for (std::size_t line = 0; line < layout.lines.size(); ++line) {
      const unsigned bit = layout.lines[line].bit;
      mask_ |= std::uint64_t{1} << bit;
      line_of_bit_[bit] = static_cast<wire::LineIndex>(line);
    }
  }

  /// Reads whole samples at the front of `piece` until none is left, the block is full or the times
  /// are used up, and returns how many bytes these are.
  std::size_t scan(std::span<const std::uint8_t> piece, EdgeBlock& block) {
    if (times_used_up()) return 0;
    const auto units = piece.size() / unit_bytes_;
    const std::uint64_t left = last_index_ - samples_ + 1;
    const std::uint8_t* const at = piece.data();
    const std::uint8_t* const end =
        at + unit_bytes_ * static_cast<std::size_t>(std::min<std::uint64_t>(units, left));
    if (samples_ == 0 && at != end) {
      // The first sample is a change in every line.
      last_ = ~get_number(reinterpret_cast<const char*>(at), unit_bytes_) & mask_;
    }
    using Scan = const std::uint8_t* (SampleScanner::*)(const std::uint8_t*, const std::uint8_t*,
                                                        EdgeBlock&);
    constexpr std::array<Scan, max_unit_bytes> scans{
        &SampleScanner::scan_whole<1>, &SampleScanner::scan_whole<2>, &SampleScanner::scan_whole<3>,
        &SampleScanner::scan_whole<4>, &SampleScanner::scan_whole<5>, &SampleScanner::scan_whole<6>,
        &SampleScanner::scan_whole<7>, &SampleScanner::scan_whole<8>};
    return static_cast<std::size_t>((this->*scans[unit_bytes_ - 1])(at, end, block) - at);
  }

  /// Whole samples seen.
  std::uint64_t samples() const { return samples_; }
  /// The lines' bits in the last of them.
  std::uint64_t last_sample() const { return last_; }
  /// The time of the next sample does not fit into 64 bits of picoseconds.
  bool times_used_up() const { return samples_ > last_index_; }
  /// Time of the last sample; 0 before the first.
  Picoseconds end_time() const {
    return samples_ == 0 ? Picoseconds{} : clock_.time_of(samples_ - 1);
  }

 private:
  template <std::size_t UnitBytes>
  const std::uint8_t* scan_whole(const std::uint8_t* at, const std::uint8_t* end,
                                 EdgeBlock& block) {
    constexpr bool fills_words = sizeof(std::uint64_t) % UnitBytes == 0;
    while (at != end) {
      if constexpr (fills_words) {
        // A line rests for many samples between two changes.
        const std::uint64_t mask = repeated<UnitBytes>(mask_);
        const std::uint64_t rest = repeated<UnitBytes>(last_);
        const std::uint8_t* const began = at;
        while (end - at >= 8 && ((load<8>(at) ^ rest) & mask) == 0) at += 8;
        samples_ += static_cast<std::size_t>(at - began) / UnitBytes;
        if (at == end) break;
      }
      const std::uint64_t sample = load<UnitBytes>(at);
      const std::uint64_t changed = (sample ^ last_) & mask_;
      if (changed != 0) {
        if (block.full()) break;
        push_changes(sample, changed, block);
      }
      at += UnitBytes;
      ++samples_;
    }
    return at;
  }

  void push_changes(std::uint64_t sample, std::uint64_t changed, EdgeBlock& block) {
    const Picoseconds time = clock_.time_of(samples_);
    for (; changed != 0; changed &= changed - 1) {
      const auto bit = static_cast<unsigned>(std::countr_zero(changed));
      const bool high = (sample >> bit & 1U) != 0;
      block.push({time, line_of_bit_[bit], high ? wire::Level::high : wire::Level::low});
    }
    last_ = sample & mask_;
  }

  SampleClock clock_;
  std::uint64_t last_index_;
  std::size_t unit_bytes_;
  std::uint64_t mask_ = 0;
  std::array<wire::LineIndex, 64> line_of_bit_{};
  std::uint64_t samples_ = 0;
  std::uint64_t last_ = 0;
};

class SampledSource final : public StepSource {
 public:
  SampledSource(const RawLayout& layout, std::unique_ptr<SamplePieces> pieces,
                const SampleReading& reading, bool is_raw)
      : pieces_(std::move(pieces)),
        scanner_(layout),
        layout_(layout),
        reading_(reading),
        is_raw_(is_raw) {
    set_lines(names_of(layout.lines));
  }

  bool is_raw() const override { return is_raw_; }
  Picoseconds end_time() const override { return scanner_.end_time(); }
  Picoseconds sample_period() const override { return longest_period(layout_.rate); }
  Hertz sample_rate() const override { return layout_.rate; }

  std::unique_ptr<PairSource> pairs(wire::LineIndex ma, wire::LineIndex slo) override {
    const PairLayout layout{.clock = SampleClock(layout_.rate),
                            .unit_bytes = layout_.unit_bytes,
                            .ma_bit = layout_.lines[ma].bit,
                            .slo_bit = layout_.lines[slo].bit,
                            .ma = ma,
                            .slo = slo};
    SamplesRead read{scanner_.samples(),
                     scanner_.last_sample(),
                     {piece_.begin(), piece_.end()},
                     ended(),
                     error()};
    packed_ = {};
    return sampled_pairs(*pieces_, layout, reading_, std::move(read));
  }

 private:
  static constexpr std::size_t piece_bytes = 262'144;

  void step() override {
    if (piece_.size() < layout_.unit_bytes) return fetch();
    piece_ = piece_.subspan(scanner_.scan(piece_, block_));
    if (piece_.size() >= layout_.unit_bytes && scanner_.times_used_up()) {
      fail({.cause = CaptureCause::time_out_of_range});
    }
  }

  void fetch() {
    // The beginning of a sample goes to the next piece.
    std::copy(piece_.begin(), piece_.end(), begun_.begin());
    piece_ = std::span(begun_).first(piece_.size());
    const auto more =
        pieces_->fetch(packed_, {.piece_bytes = piece_bytes, .unit_bytes = 1, .at_sample = false});
    if (!more.ok()) return fail(more.error());
    if (*more) {
      packed_.prepend(piece_);
      piece_ = packed_.bytes;
      return;
    }
    finish();
    if (!piece_.empty()) {
      fail({.cause = CaptureCause::truncated, .expected = "a whole number of samples"});
    } else if (scanner_.samples() == 0) {
      fail({.cause = CaptureCause::empty});
    }
  }

  std::unique_ptr<SamplePieces> pieces_;
  SampleScanner scanner_;
  RawLayout layout_;
  SampleReading reading_;
  bool is_raw_;
  PackedSamples packed_;
  // The bytes that are not scanned yet, in packed_ or, of a sample that was begun, in begun_.
  std::span<const std::uint8_t> piece_;
  std::array<std::uint8_t, max_unit_bytes> begun_{};
};

class RawPieces final : public SamplePieces {
 public:
  explicit RawPieces(std::unique_ptr<ByteSource> bytes) : bytes_(std::move(bytes)) {}

  Result<bool, CaptureError> fetch(PackedSamples& piece, const FetchWish& wish) override {
    if (wish.at_sample) {
      const auto lying = bytes_->take(wish.piece_bytes / wish.unit_bytes * wish.unit_bytes);
      piece.bytes = {reinterpret_cast<const std::uint8_t*>(lying.data()), lying.size()};
      const auto after = bytes_->ahead();
      piece.ahead = {reinterpret_cast<const std::uint8_t*>(after.data()), after.size()};
      if (!lying.empty()) return true;
    }
    const auto room = piece.room(wish.piece_bytes);
    const auto got = bytes_->read({reinterpret_cast<char*>(room.data()), room.size()});
    if (!got.ok()) return failure(got.error());
    piece.bytes = room.first(*got);
    return *got != 0;
  }

 private:
  std::unique_ptr<ByteSource> bytes_;
};

constexpr std::size_t most_copies = 8'192;

}  // namespace

const char* fault_of(const RawLayout& layout) {
  if (layout.rate.count == 0) return "a sample rate of 1 Hz or more";
  if (layout.unit_bytes == 0 || layout.unit_bytes > max_unit_bytes) {
    return "samples of 1 to 8 bytes";
  }
  if (layout.lines.empty()) return "the bit of at least one line";
  std::uint64_t taken = 0;
  for (const SampleLine& line : layout.lines) {
    if (line.bit >= 8 * layout.unit_bytes) return "bits that lie in the sample, counted from 0";
    const std::uint64_t bit = std::uint64_t{1} << line.bit;
    if ((taken & bit) != 0) return "a bit of its own for each line";
    taken |= bit;
  }
  return nullptr;
}

// From the first sample on, the period's fraction of a picosecond adds up in units of 2^-52 ps.
// This rounds down by at most 4097 units. A bias makes up for it: it is larger than that, and
// smaller than the smallest fraction that a time can have, 2^-32 ps.
void SampleClock::times_after(std::uint64_t first, std::span<std::int64_t> samples) const {
  constexpr unsigned point = 52;
  constexpr std::uint64_t bias = 1U << 16U;
  const auto scaled = [this](std::uint64_t part) {
    return static_cast<std::uint64_t>((static_cast<unsigned __int128>(part) << point) / rate_);
  };
  const std::uint64_t whole = second / rate_;
  const std::uint64_t fraction = scaled(second % rate_);
  const std::uint64_t begun = scaled((first % rate_ * (second % rate_) + rate_ / 2) % rate_) + bias;
  const std::uint64_t base = count_of(first);
  for (std::int64_t& sample : samples) {
    const auto index = static_cast<std::uint64_t>(sample);
    sample =
        static_cast<std::int64_t>(base + index * whole + ((begun + index * fraction) >> point));
  }
}

Picoseconds longest_period(Hertz rate) {
  const bool whole = picoseconds_per_second % rate.count == 0;
  return period_of(rate) + picoseconds(whole ? 0 : 1);
}

std::vector<std::string> names_of(std::span<const SampleLine> lines) {
  std::vector<std::string> names;
  for (const SampleLine& line : lines) names.push_back(line.name);
  return names;
}

RawLayout packed_layout(const std::vector<std::string>& lines, Hertz rate) {
  RawLayout layout{rate, std::max<std::size_t>(1, (lines.size() + 7) / 8), {}};
  for (std::size_t line = 0; line < lines.size(); ++line) {
    layout.lines.push_back({lines[line], static_cast<unsigned>(line)});
  }
  return layout;
}

void PackedSamples::prepend(std::span<const std::uint8_t> begun) {
  if (begun.empty()) return;
  const auto joined = memory.take(begun_room + bytes.size()).subspan(begun_room - begun.size());
  std::copy(begun.begin(), begun.end(), joined.begin());
  bytes = joined;
}

Opened open_samples(const RawLayout& layout, std::unique_ptr<SamplePieces> pieces,
                    const SampleReading& reading, bool is_raw) {
  if (const char* const expected = fault_of(layout)) {
    return tl::unexpected(CaptureError{.cause = CaptureCause::bad_layout, .expected = expected});
  }
  return std::make_unique<SampledSource>(layout, std::move(pieces), reading, is_raw);
}

Opened open_raw(std::unique_ptr<ByteSource> bytes, const RawLayout& layout,
                const SampleReading& reading) {
  return open_samples(layout, std::make_unique<RawPieces>(std::move(bytes)), reading, true);
}

SampledWriter::SampledWriter(const RawLayout& layout, ByteSink& sink)
    : EdgeWriter(names_of(layout.lines), sink),
      clock_(layout.rate),
      unit_bytes_(layout.unit_bytes) {
  if (layout.lines.size() > 8 * max_unit_bytes) refuse(WriteCause::too_many_lines);
  for (const SampleLine& line : layout.lines) bits_.push_back(line.bit);
}

void SampledWriter::put(const wire::Edge& edge, bool) {
  put_until(clock_.first_at_or_after(edge.time));
  const std::uint64_t bit = std::uint64_t{1} << bits_[edge.line];
  levels_ = edge.level == wire::Level::high ? levels_ | bit : levels_ & ~bit;
  copies_.clear();
  last_time_ = edge.time;
}

void SampledWriter::put_end(Picoseconds end_time, bool later) {
  put_until(clock_.first_at_or_after(later ? end_time : last_time_) + 1);
  put_close();
}

// Samples up to the one before `index` show the present levels.
void SampledWriter::put_until(std::uint64_t index) {
  while (next_ < index) {
    const auto count =
        static_cast<std::size_t>(std::min<std::uint64_t>(index - next_, most_copies));
    while (copies_.size() < count * unit_bytes_) {
      for (std::size_t i = 0; i < unit_bytes_; ++i) {
        copies_ += static_cast<char>(levels_ >> (8U * i) & 0xFFU);
      }
    }
    if (!put_samples(std::string_view(copies_).substr(0, count * unit_bytes_))) return;
    next_ += count;
  }
}

bool RawWriter::put_samples(std::string_view bytes) {
  text() += bytes;
  return flush_full();
}

}  // namespace biss::capture
