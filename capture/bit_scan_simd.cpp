// The loops of bit_scan.hpp with vectors: compiled once for each kind of processor, of which the best
// is chosen at run time.
#define HWY_WANT_AVX3_DL
// Vectors whose length is not known when compiling are not used: a word of 64 samples has to hold them.
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "capture/bit_scan_simd.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h.
#include <hwy/cache_control.h>
#include <hwy/highway.h>

#include <bit>
#include <cstring>

#include "capture/bit_scan.hpp"

HWY_BEFORE_NAMESPACE();
namespace biss::capture {
namespace HWY_NAMESPACE {

#if HWY_TARGET == HWY_SCALAR || HWY_TARGET == HWY_EMU128

void scan_pair_vectors(PairScan& scan) { scan_pair_plain(scan); }

#else

namespace hn = hwy::HWY_NAMESPACE;

// The changes of a busy line take longer to find than its bytes to arrive: so bytes are requested
// ahead.
constexpr std::size_t bytes_ahead = 4'096;

struct Clock {
  std::int64_t time;
  std::uint32_t step;

  // Not signed: after the last sample there may be no time.
  std::int64_t at(std::size_t sample) const {
    return static_cast<std::int64_t>(static_cast<std::uint64_t>(time) + sample * step);
  }
};

#if HWY_TARGET == HWY_AVX3_DL

// Bytes 0 to 7 of a block into eight words, bytes 8 to 15 into eight others.
alignas(64) constexpr std::uint64_t spread_low[8] = {
    0x8080808080808000, 0x8080808080808001, 0x8080808080808002, 0x8080808080808003,
    0x8080808080808004, 0x8080808080808005, 0x8080808080808006, 0x8080808080808007};
alignas(64) constexpr std::uint64_t spread_high[8] = {
    0x8080808080808008, 0x8080808080808009, 0x808080808080800A, 0x808080808080800B,
    0x808080808080800C, 0x808080808080800D, 0x808080808080800E, 0x808080808080800F};

// The times of the changes in a word of samples. Most words have up to `Expected`, 8 or 16.
template <std::size_t Expected>
HWY_INLINE std::int64_t* put_changes(std::uint64_t changes, std::int64_t time, std::uint32_t step,
                                     std::int64_t* out) {
  const hn::ScalableTag<std::uint8_t> d8;
  const hn::ScalableTag<std::uint32_t> d32;
  const hn::ScalableTag<std::uint64_t> d64;
  alignas(64) std::uint8_t samples[64];
  std::uint8_t bits[8];
  std::memcpy(bits, &changes, sizeof bits);
  hn::Store(hn::Compress(hn::Iota(d8, 0), hn::LoadMaskBits(d8, bits)), d8, samples);
  const auto times_of = [&](auto block, const std::uint64_t* spread) HWY_ATTR {
    const auto sample = hn::TableLookupBytesOr0(block, hn::BitCast(d8, hn::Load(d64, spread)));
    const auto offset = hn::MulEven(hn::BitCast(d32, sample), hn::Set(d32, step));
    return hn::Add(offset, hn::Set(d64, static_cast<std::uint64_t>(time)));
  };
  auto* const to = reinterpret_cast<std::uint64_t*>(out);
  const auto count = static_cast<std::size_t>(std::popcount(changes));
  const auto first = hn::LoadDup128(d8, samples);
  hn::StoreU(times_of(first, spread_low), d64, to);
  if (Expected == 16 || HWY_UNLIKELY(count > 8)) {
    hn::StoreU(times_of(first, spread_high), d64, to + 8);
  }
  for (std::size_t done = 16; HWY_UNLIKELY(done < count); done += 16) {
    const auto block = hn::LoadDup128(d8, samples + done);
    hn::StoreU(times_of(block, spread_low), d64, to + done);
    hn::StoreU(times_of(block, spread_high), d64, to + done + 8);
  }
  return out + count;
}

#else

template <std::size_t Expected>
HWY_INLINE std::int64_t* put_changes(std::uint64_t changes, std::int64_t time, std::uint32_t step,
                                     std::int64_t* out) {
  const auto next = [&] {
    const auto sample = static_cast<std::uint64_t>(std::countr_zero(changes));
    changes &= changes - 1;
    return static_cast<std::int64_t>(static_cast<std::uint64_t>(time) + sample * step);
  };
  if constexpr (HWY_TARGET > HWY_AVX2) {
    while (changes != 0) *out++ = next();
    return out;
  }
  // A few unnecessary times cost less than a test after each.
  std::int64_t* const end = out + std::popcount(changes);
  for (; out < end; out += 4) {
    for (std::size_t i = 0; i < 4; ++i) out[i] = next();
  }
  return end;
}

#endif

// One bit of 64 samples.
template <class D>
HWY_INLINE std::uint64_t plane_of(D d, const hn::TFromD<D>* at, hn::Vec<D> bit) {
  constexpr std::size_t lanes = hn::MaxLanes(D());
  std::uint64_t word = 0;
  for (std::size_t i = 0; i < 64; i += lanes) {
    std::uint8_t bits[8] = {};
    hn::StoreMaskBits(d, hn::TestBit(hn::LoadU(d, at + i), bit), bits);
    std::uint64_t part = 0;
    std::memcpy(&part, bits, sizeof part);
    word |= part << i;
  }
  return word;
}

// Whether all lanes of `bytes` bytes agree with the rest in the masked bits.
template <std::size_t Bytes, class D>
HWY_INLINE bool rests(D d, const hn::TFromD<D>* at, hn::Vec<D> rest, hn::Vec<D> mask) {
  constexpr std::size_t lanes = hn::MaxLanes(D());
  constexpr std::size_t samples = Bytes / sizeof(hn::TFromD<D>);
  auto differ = hn::Xor(hn::LoadU(d, at), rest);
  for (std::size_t i = lanes; i < samples; i += lanes) {
    differ = hn::Or(differ, hn::Xor(hn::LoadU(d, at + i), rest));
  }
  return hn::AllTrue(d, hn::Eq(hn::And(differ, mask), hn::Zero(d)));
}

template <class T>
HWY_INLINE void scan_units(PairScan& scan) {
  const hn::ScalableTag<T> d;
  constexpr std::size_t group = sizeof(T) < 4 ? 256 / sizeof(T) : 64;
  const auto* const samples = reinterpret_cast<const T*>(scan.samples);
  const T ma_bit = static_cast<T>(T{1} << scan.ma_bit);
  const T slo_bit = static_cast<T>(T{1} << scan.slo_bit);
  const Clock clock{scan.time, scan.step};
  std::uint64_t ma_before = scan.ma_high;
  std::uint64_t slo_before = scan.slo_high;
  std::int64_t* ma_out = scan.ma;
  std::int64_t* slo_out = scan.slo;
  const auto rest_now = [&] {
    return static_cast<T>((ma_before != 0 ? ma_bit : T{0}) | (slo_before != 0 ? slo_bit : T{0}));
  };
  auto rest = hn::Set(d, rest_now());
  const auto ma_mask = hn::Set(d, ma_bit);
  const auto slo_mask = hn::Set(d, slo_bit);
  const auto mask = hn::Or(ma_mask, slo_mask);
  std::size_t at = 0;
  for (; at + group <= scan.count; at += group) {
    for (std::size_t i = 0; i < group * sizeof(T); i += 64) {
      hwy::Prefetch(scan.samples + at * sizeof(T) + bytes_ahead + i);
    }
    if (HWY_LIKELY((rests<group * sizeof(T)>(d, samples + at, rest, mask)))) continue;
    for (std::size_t word = at; word < at + group; word += 64) {
      const std::uint64_t ma = plane_of(d, samples + word, ma_mask);
      const std::uint64_t slo = plane_of(d, samples + word, slo_mask);
      const std::uint64_t ma_changes = ma ^ (ma << 1U | ma_before);
      const std::uint64_t slo_changes = slo ^ (slo << 1U | slo_before);
      if ((ma_changes | slo_changes) == 0) continue;
      const std::int64_t time = clock.at(word);
      ma_out = put_changes<16>(ma_changes, time, scan.step, ma_out);
      slo_out = put_changes<8>(slo_changes, time, scan.step, slo_out);
      ma_before = ma >> 63U;
      slo_before = slo >> 63U;
    }
    rest = hn::Set(d, rest_now());
  }
  scan.samples += at * sizeof(T);
  scan.count -= at;
  scan.ma_high = ma_before != 0;
  scan.slo_high = slo_before != 0;
  scan.time = clock.at(at);
  scan.ma = ma_out;
  scan.slo = slo_out;
  if (scan.count != 0) scan_pair_plain(scan);
}

void scan_pair_vectors(PairScan& scan) {
  switch (scan.unit_bytes) {
    case 1:
      return scan_units<std::uint8_t>(scan);
    case 2:
      return scan_units<std::uint16_t>(scan);
    case 4:
      return scan_units<std::uint32_t>(scan);
    case 8:
      return scan_units<std::uint64_t>(scan);
    default:
      return scan_pair_plain(scan);
  }
}

#endif

}  // namespace HWY_NAMESPACE
}  // namespace biss::capture
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace biss::capture {

HWY_EXPORT(scan_pair_vectors);

void scan_pair(PairScan& scan) { HWY_DYNAMIC_DISPATCH(scan_pair_vectors)(scan); }

}  // namespace biss::capture

#endif
