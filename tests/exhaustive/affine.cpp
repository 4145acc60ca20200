#include "tests/exhaustive/affine.hpp"

#include <bit>
#include <cstddef>

namespace exhaustive {

bool AffineBit::at(std::uint64_t position) const {
  return (std::popcount(mask & position) % 2 != 0) != constant;
}

AffineBits affine_checksum(const oracle::Checksum& checksum, const AffineBits& data) {
  const std::size_t width = checksum.width();
  AffineBits dividend = data;
  dividend.resize(data.size() + width);
  for (std::size_t i = 0; i < width; ++i) {
    dividend[i] = dividend[i] + AffineBit{0, checksum.start[i]};
  }
  for (std::size_t i = 0; i < data.size(); ++i) {
    const AffineBit leading = dividend[i];
    for (std::size_t k = 0; k <= width; ++k) {
      if (checksum.polynomial[k]) dividend[i + k] = dividend[i + k] + leading;
    }
  }
  AffineBits remainder(dividend.end() - static_cast<std::ptrdiff_t>(width), dividend.end());
  for (AffineBit& bit : remainder) bit = bit + AffineBit{0, checksum.inverted};
  return remainder;
}

Positions Positions::with(AffineBit bit, bool level) const {
  Positions some = *this;
  if (level) bit.constant = !bit.constant;
  for (const AffineBit& equation : some.equations_) {
    if ((bit.mask & equation.mask & (~equation.mask + 1U)) != 0) bit = bit + equation;
  }
  if (bit.mask == 0) {
    some.none_ = some.none_ || bit.constant;
    return some;
  }
  const std::uint64_t pivot = bit.mask & (~bit.mask + 1U);
  for (AffineBit& equation : some.equations_) {
    if ((equation.mask & pivot) != 0) equation = equation + bit;
  }
  some.equations_.push_back(bit);
  return some;
}

std::uint64_t Positions::count() const {
  return none_ ? 0 : std::uint64_t{1} << (bits_ - equations_.size());
}

bool Positions::contains(std::uint64_t position) const {
  for (const AffineBit& equation : equations_) {
    if (equation.at(position)) return false;
  }
  return !none_;
}

std::uint64_t Positions::any(biss::test::Random& random) const {
  std::uint64_t position = random.bits(bits_);
  for (const AffineBit& equation : equations_) {
    if (equation.at(position)) position ^= equation.mask & (~equation.mask + 1U);
  }
  return position;
}

}  // namespace exhaustive
