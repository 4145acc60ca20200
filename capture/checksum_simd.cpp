// The CRC-32 of inflated samples, which must not take longer than inflating them. It uses
// carry-less multiplication of whole vectors if the processor has it, else libdeflate.
// Source: Gopal and others, Fast CRC Computation for Generic Polynomials Using PCLMULQDQ, Intel 2009.
#define HWY_WANT_AVX3_DL
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SSE4 | HWY_AVX2 | HWY_AVX3)

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "capture/checksum_simd.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h.
#include <hwy/highway.h>
#include <libdeflate.h>

#include <cstring>

#include "capture/zip.hpp"

HWY_BEFORE_NAMESPACE();
namespace biss::capture {
namespace HWY_NAMESPACE {

#if HWY_TARGET == HWY_AVX3_DL

namespace hn = hwy::HWY_NAMESPACE;

// The remainder of x^power, its bits reversed, one place higher as the products need it.
constexpr std::uint64_t folding_factor(unsigned power) {
  constexpr std::uint32_t polynomial = 0xEDB8'8320U;
  std::uint32_t remainder = 0x8000'0000U;
  for (unsigned i = 0; i < power; ++i) {
    remainder = remainder >> 1U ^ ((remainder & 1U) != 0 ? polynomial : 0U);
  }
  return std::uint64_t{remainder} << 1U;
}

constexpr std::size_t block_bytes = 256;
constexpr std::size_t block_words = block_bytes / 8;
// Each 16 bytes are moved forward by a block.
alignas(16) constexpr std::uint64_t factors[2] = {folding_factor(8 * block_bytes + 32),
                                                  folding_factor(8 * block_bytes - 32)};
using Words = hn::ScalableTag<std::uint64_t>;

HWY_INLINE hn::Vec<Words> folded(hn::Vec<Words> sum, hn::Vec<Words> factor,
                                 const std::uint8_t* next) {
  const hn::Repartition<std::uint8_t, Words> d8;
  const auto bytes = hn::BitCast(Words(), hn::LoadU(d8, next));
  return hn::Xor(hn::Xor(hn::CLMulLower(sum, factor), hn::CLMulUpper(sum, factor)), bytes);
}

std::uint32_t checksum(std::uint32_t before, const std::uint8_t* bytes, std::size_t count) {
  if (count < 2 * block_bytes) return libdeflate_crc32(before, bytes, count);
  const Words d;
  const std::size_t lanes = hn::Lanes(d);
  alignas(64) std::uint64_t sums[block_words];
  std::memcpy(sums, bytes, block_bytes);
  sums[0] ^= ~before;
  const auto factor = hn::LoadDup128(d, factors);
  auto sum0 = hn::Load(d, sums);
  auto sum1 = hn::Load(d, sums + lanes);
  auto sum2 = hn::Load(d, sums + 2 * lanes);
  auto sum3 = hn::Load(d, sums + 3 * lanes);
  std::size_t at = block_bytes;
  for (; at + block_bytes <= count; at += block_bytes) {
    sum0 = folded(sum0, factor, bytes + at);
    sum1 = folded(sum1, factor, bytes + at + 8 * lanes);
    sum2 = folded(sum2, factor, bytes + at + 16 * lanes);
    sum3 = folded(sum3, factor, bytes + at + 24 * lanes);
  }
  hn::Store(sum0, d, sums);
  hn::Store(sum1, d, sums + lanes);
  hn::Store(sum2, d, sums + 2 * lanes);
  hn::Store(sum3, d, sums + 3 * lanes);
  // One block that has the remainder of all bytes so far. It includes the bytes before it.
  const std::uint32_t nothing_before = ~std::uint32_t{0};
  const std::uint32_t so_far = libdeflate_crc32(nothing_before, sums, block_bytes);
  return libdeflate_crc32(so_far, bytes + at, count - at);
}

#else

std::uint32_t checksum(std::uint32_t before, const std::uint8_t* bytes, std::size_t count) {
  return libdeflate_crc32(before, bytes, count);
}

#endif

}  // namespace HWY_NAMESPACE
}  // namespace biss::capture
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace biss::capture {

HWY_EXPORT(checksum);

std::uint32_t zip_checksum_after(std::uint32_t before, std::span<const std::uint8_t> bytes) {
  return HWY_DYNAMIC_DISPATCH(checksum)(before, bytes.data(), bytes.size());
}

}  // namespace biss::capture

#endif
