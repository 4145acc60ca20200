#include "capture/bit_scan.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

#include "capture/decimal.hpp"

namespace biss::capture {
namespace {

constexpr std::size_t word_samples = 64;

// Eight samples fill as many words as a sample has bytes; this bit in each of them.
template <std::size_t UnitBytes>
std::array<std::uint64_t, UnitBytes> bit_in_eight(unsigned bit) {
  std::array<std::uint8_t, 8 * UnitBytes> bytes{};
  for (std::size_t i = 0; i < 8; ++i) {
    bytes[i * UnitBytes + bit / 8] = static_cast<std::uint8_t>(1U << bit % 8);
  }
  std::array<std::uint64_t, UnitBytes> words{};
  std::memcpy(words.data(), bytes.data(), bytes.size());
  return words;
}

template <std::size_t UnitBytes>
class PlainPair {
 public:
  explicit PlainPair(const PairScan& scan)
      : ma_(bit_in_eight<UnitBytes>(scan.ma_bit)), slo_(bit_in_eight<UnitBytes>(scan.slo_bit)) {
    set_rest(scan.ma_high, scan.slo_high);
  }

  void set_rest(bool ma_high, bool slo_high) {
    for (std::size_t i = 0; i < UnitBytes; ++i) {
      rest_[i] = (ma_high ? ma_[i] : 0) | (slo_high ? slo_[i] : 0);
    }
  }

  // Whether a word of 64 samples from here on shows the levels of the rest.
  bool rests(const std::uint8_t* at) const {
    std::uint64_t differ = 0;
    for (std::size_t eight = 0; eight < 8; ++eight) {
      for (std::size_t i = 0; i < UnitBytes; ++i, at += 8) {
        std::uint64_t bytes = 0;
        std::memcpy(&bytes, at, 8);
        differ |= (bytes ^ rest_[i]) & (ma_[i] | slo_[i]);
      }
    }
    return differ == 0;
  }

 private:
  std::array<std::uint64_t, UnitBytes> ma_;
  std::array<std::uint64_t, UnitBytes> slo_;
  std::array<std::uint64_t, UnitBytes> rest_{};
};

// One bit of up to 64 samples.
template <std::size_t UnitBytes>
std::uint64_t plane_of(const std::uint8_t* at, std::size_t count, unsigned bit) {
  std::uint64_t word = 0;
  std::size_t i = 0;
  if constexpr (UnitBytes == 1) {
    // The product moves bit 0 of byte k to bit 56 + k.
    constexpr std::uint64_t lowest = 0x0101'0101'0101'0101U;
    constexpr std::uint64_t gather = 0x0102'0408'1020'4080U;
    for (; i + 8 <= count; i += 8) {
      word |= ((load_eight(reinterpret_cast<const char*>(at + i)) >> bit & lowest) * gather >> 56U)
              << i;
    }
  }
  for (; i < count; ++i) {
    word |= std::uint64_t{at[i * UnitBytes + bit / 8]} >> bit % 8 << 63U >> (63U - i);
  }
  return word;
}

// The times of the changes in a word of samples.
std::int64_t* put_changes(std::uint64_t changes, std::int64_t time, std::int64_t step,
                          std::int64_t* out) {
  for (; changes != 0; changes &= changes - 1) *out++ = time + std::countr_zero(changes) * step;
  return out;
}

// The first `count` samples of `levels` that differ from the one before; `high` before the first.
std::uint64_t changes_of(std::uint64_t levels, std::size_t count, bool& high) {
  const std::uint64_t changes = levels ^ (levels << 1U | std::uint64_t{high});
  high = (levels >> (count - 1) & 1U) != 0;
  return changes & ~std::uint64_t{0} >> (word_samples - count);
}

template <std::size_t UnitBytes>
void scan_units_plain(PairScan& scan) {
  PlainPair<UnitBytes> pair(scan);
  const std::int64_t step = scan.step;
  for (std::size_t at = 0; at < scan.count; at += word_samples) {
    const std::uint8_t* const samples = scan.samples + at * UnitBytes;
    const std::size_t count = std::min(word_samples, scan.count - at);
    if (count == word_samples && pair.rests(samples)) continue;
    const std::int64_t time = scan.time + static_cast<std::int64_t>(at) * step;
    const std::uint64_t ma = plane_of<UnitBytes>(samples, count, scan.ma_bit);
    const std::uint64_t slo = plane_of<UnitBytes>(samples, count, scan.slo_bit);
    scan.ma = put_changes(changes_of(ma, count, scan.ma_high), time, step, scan.ma);
    scan.slo = put_changes(changes_of(slo, count, scan.slo_high), time, step, scan.slo);
    pair.set_rest(scan.ma_high, scan.slo_high);
  }
}

}  // namespace

void scan_pair_plain(PairScan& scan) {
  constexpr std::array scans{scan_units_plain<1>, scan_units_plain<2>, scan_units_plain<3>,
                             scan_units_plain<4>, scan_units_plain<5>, scan_units_plain<6>,
                             scan_units_plain<7>, scan_units_plain<8>};
  scans[scan.unit_bytes - 1](scan);
}

}  // namespace biss::capture
