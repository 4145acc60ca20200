#include "capture/sample_scanner.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

namespace biss::capture {
namespace {

template <std::size_t UnitBytes>
std::uint64_t load(const std::uint8_t* at) {
  if constexpr (std::endian::native == std::endian::little) {
    std::uint64_t sample = 0;
    std::memcpy(&sample, at, UnitBytes);
    return sample;
  } else {
    std::uint64_t sample = 0;
    for (std::size_t i = UnitBytes; i-- > 0;) sample = sample << 8U | at[i];
    return sample;
  }
}

// As many copies of the sample as fill a word.
template <std::size_t UnitBytes>
constexpr std::uint64_t repeated(std::uint64_t sample) {
  for (std::size_t bytes = UnitBytes; bytes < sizeof sample; bytes *= 2) {
    sample |= sample << (8U * bytes % 64U);
  }
  return sample;
}

}  // namespace

SampleScanner::SampleScanner(const RawLayout& layout)
    : clock_(layout.rate), last_index_(clock_.last_index()), unit_bytes_(layout.unit_bytes) {
  for (std::size_t line = 0; line < layout.lines.size(); ++line) {
    const unsigned bit = layout.lines[line].bit;
    mask_ |= std::uint64_t{1} << bit;
    line_of_bit_[bit] = static_cast<wire::LineIndex>(line);
  }
}

void SampleScanner::push_changes(std::uint64_t sample, std::uint64_t changed, EdgeBlock& block) {
  const Picoseconds time = clock_.time_of(samples_);
  for (; changed != 0; changed &= changed - 1) {
    const auto bit = static_cast<unsigned>(std::countr_zero(changed));
    const bool high = (sample >> bit & 1U) != 0;
    block.push({time, line_of_bit_[bit], high ? wire::Level::high : wire::Level::low});
  }
  last_ = sample & mask_;
}

template <std::size_t UnitBytes>
const std::uint8_t* SampleScanner::scan_whole(const std::uint8_t* at, const std::uint8_t* end,
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

const std::uint8_t* SampleScanner::scan_units(const std::uint8_t* at, const std::uint8_t* end,
                                              EdgeBlock& block) {
  if (at == end || times_used_up()) return at;
  const auto units = static_cast<std::size_t>(end - at) / unit_bytes_;
  const std::uint64_t left = last_index_ - samples_ + 1;
  end = at + unit_bytes_ * static_cast<std::size_t>(std::min<std::uint64_t>(units, left));
  if (samples_ == 0 && at != end) {
    // Differs from the first sample in every line.
    std::uint64_t first = 0;
    for (std::size_t i = unit_bytes_; i-- > 0;) first = first << 8U | at[i];
    push_changes(first, mask_, block);
    at += unit_bytes_;
    ++samples_;
  }
  switch (unit_bytes_) {
    case 1:
      return scan_whole<1>(at, end, block);
    case 2:
      return scan_whole<2>(at, end, block);
    case 3:
      return scan_whole<3>(at, end, block);
    case 4:
      return scan_whole<4>(at, end, block);
    case 5:
      return scan_whole<5>(at, end, block);
    case 6:
      return scan_whole<6>(at, end, block);
    case 7:
      return scan_whole<7>(at, end, block);
    default:
      return scan_whole<8>(at, end, block);
  }
}

// Completes the sample with whose beginning the last piece ended.
const std::uint8_t* SampleScanner::finish_held(const std::uint8_t* at, const std::uint8_t* end,
                                               EdgeBlock& block) {
  if (block.full()) return at;
  while (held_bytes_ < unit_bytes_ && at != end) held_[held_bytes_++] = *at++;
  if (held_bytes_ < unit_bytes_) return at;
  if (scan_units(held_.data(), held_.data() + unit_bytes_, block) != held_.data()) held_bytes_ = 0;
  return at;
}

std::size_t SampleScanner::scan(std::span<const std::uint8_t> piece, EdgeBlock& block) {
  const std::uint8_t* at = piece.data();
  const std::uint8_t* const end = at + piece.size();
  if (held_bytes_ != 0) at = finish_held(at, end, block);
  if (held_bytes_ == 0) {
    at = scan_units(at, end, block);
    if (static_cast<std::size_t>(end - at) < unit_bytes_) {
      while (at != end) held_[held_bytes_++] = *at++;
    }
  }
  return static_cast<std::size_t>(at - piece.data());
}

}  // namespace biss::capture
