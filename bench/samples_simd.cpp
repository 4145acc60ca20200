// The least cost of planes of samples: reading them, testing two bits, storing the planes.
#define HWY_WANT_AVX3_DL
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_AVX3_DL)

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "bench/samples_simd.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h.
#include <hwy/highway.h>

#include "bench/samples.hpp"

HWY_BEFORE_NAMESPACE();
namespace biss::bench {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

std::uint64_t planes(const std::uint8_t* samples, std::size_t count) {
  constexpr std::size_t block = 16'384;
  const hn::ScalableTag<std::uint8_t> d;
  const std::size_t lanes = hn::Lanes(d);
  const auto ma_bit = hn::Set(d, std::uint8_t{1});
  const auto slo_bit = hn::Set(d, std::uint8_t{2});
  alignas(64) std::uint8_t ma[block / 8 + 8];
  alignas(64) std::uint8_t slo[block / 8 + 8];
  std::uint64_t sum = 0;
  for (std::size_t at = 0; at + block <= count; at += block) {
    for (std::size_t i = 0; i < block; i += lanes) {
      const auto bytes = hn::LoadU(d, samples + at + i);
      hn::StoreMaskBits(d, hn::TestBit(bytes, ma_bit), ma + i / 8);
      hn::StoreMaskBits(d, hn::TestBit(bytes, slo_bit), slo + i / 8);
    }
    sum += ma[0] + slo[block / 8 - 1];
  }
  return sum;
}

std::uint64_t read_bytes(const std::uint8_t* bytes, std::size_t count) {
  const hn::ScalableTag<std::uint8_t> d;
  const std::size_t lanes = hn::Lanes(d);
  auto sum0 = hn::Zero(d);
  auto sum1 = hn::Zero(d);
  for (std::size_t at = 0; at + 4 * lanes <= count; at += 4 * lanes) {
    sum0 = hn::Xor(hn::Xor(sum0, hn::LoadU(d, bytes + at)), hn::LoadU(d, bytes + at + lanes));
    sum1 = hn::Xor(hn::Xor(sum1, hn::LoadU(d, bytes + at + 2 * lanes)),
                   hn::LoadU(d, bytes + at + 3 * lanes));
  }
  return hn::GetLane(hn::Xor(sum0, sum1));
}

}  // namespace HWY_NAMESPACE
}  // namespace biss::bench
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace biss::bench {

HWY_EXPORT(planes);
HWY_EXPORT(read_bytes);

std::uint64_t plane_pass(std::span<const std::uint8_t> samples) {
  return HWY_DYNAMIC_DISPATCH(planes)(samples.data(), samples.size());
}

std::uint64_t read_pass(std::span<const std::uint8_t> bytes) {
  return HWY_DYNAMIC_DISPATCH(read_bytes)(bytes.data(), bytes.size());
}

}  // namespace biss::bench

#endif
