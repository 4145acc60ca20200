// Four engines that compute the same checksum. The bitwise one is the reference; the tests compare
// the others with it. The faster ones need more memory. All take the data right-aligned in a 64-bit
// word.
#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "biss/base/bits.hpp"
#include "biss/crc/spec.hpp"

namespace biss {

namespace crc_detail {

// One step of the shift register: the next data bit enters at the top.
constexpr std::uint32_t step(const CrcSpec& spec, std::uint32_t reg, bool bit) {
  const bool feedback = (((reg >> (spec.width_bits - 1U)) & 1U) != 0) != bit;
  reg = (reg << 1U) & spec.mask();
  return feedback ? reg ^ (spec.polynomial & spec.mask()) : reg;
}

constexpr std::uint16_t finish(const CrcSpec& spec, std::uint32_t reg) {
  return static_cast<std::uint16_t>(spec.inverted ? reg ^ spec.mask() : reg);
}

// Remainder of `byte` followed by `zero_bits` zeros, start 0: an entry of every table below.
constexpr std::uint16_t remainder(const CrcSpec& spec, unsigned byte, unsigned byte_bits,
                                  unsigned zero_bits) {
  std::uint32_t reg = 0;
  for (unsigned i = byte_bits; i-- > 0;) reg = step(spec, reg, ((byte >> i) & 1U) != 0);
  for (unsigned i = 0; i < zero_bits; ++i) reg = step(spec, reg, false);
  return static_cast<std::uint16_t>(reg);
}

// A start value has the effect of an XOR with the first bits of the data, so the tables hold start
// 0 only. Data shorter than the register is computed bit by bit.
constexpr bool start_fits(const CrcSpec& spec, unsigned bits) {
  return spec.start == 0 || bits >= spec.width_bits;
}

constexpr std::uint64_t with_start(const CrcSpec& spec, std::uint64_t data, unsigned bits) {
  return spec.start == 0 ? data : data ^ (std::uint64_t{spec.start} << (bits - spec.width_bits));
}

// One XOR of a tree: the look-ups complete together, so a tree is faster than a chain. GCC would
// make a chain of the tree.
template <std::unsigned_integral Word>
constexpr Word pair(Word a, Word b) {
  const auto both = static_cast<Word>(a ^ b);
#if defined(__GNUC__) && !defined(__clang__) && __GNUC__ >= 12
  return __builtin_assoc_barrier(both);
#else
  return both;
#endif
}

}  // namespace crc_detail

/// The reference: bit by bit, no table.
///
/// All engines are called the same way: `engine(data, bits)` is the CRC of the lowest `bits` (1…64)
/// of `data`, most significant bit first, as transmitted (inverted if the spec is inverted). Bits
/// of `data` above `bits` must be 0. An engine without a checksum gives 0. Engines are plain data
/// and may be constexpr.
class CrcBitwise {
 public:
  constexpr CrcBitwise() = default;
  constexpr explicit CrcBitwise(const CrcSpec& spec) : spec_(spec) {}

  constexpr const CrcSpec& spec() const { return spec_; }

  constexpr std::uint16_t operator()(std::uint64_t data, unsigned bits) const {
    std::uint32_t reg = spec_.start;
    for (unsigned i = spec_.present() ? bits : 0; i-- > 0;)
      reg = crc_detail::step(spec_, reg, ((data >> i) & 1U) != 0);
    return crc_detail::finish(spec_, reg);
  }

 private:
  CrcSpec spec_;
};

/// A table of 16 (ChunkBits = 4) or 256 (ChunkBits = 8) entries, one step a chunk: 64 or 512 bytes,
/// for small flash.
template <unsigned ChunkBits>
class CrcTable {
  static_assert(ChunkBits == 4 || ChunkBits == 8);

 public:
  constexpr CrcTable() = default;
  constexpr explicit CrcTable(const CrcSpec& spec) : spec_(spec) {
    if (!spec.present()) return;
    for (unsigned i = 0; i < table_.size(); ++i) {
      table_[i] = static_cast<Entry>(crc_detail::remainder(spec, i, ChunkBits, 0)
                                     << (entry_bits - spec.width_bits));
    }
  }

  constexpr const CrcSpec& spec() const { return spec_; }

  // Inlined, because a constant spec leaves little of it.
  [[gnu::always_inline]] constexpr std::uint16_t operator()(std::uint64_t data,
                                                            unsigned bits) const {
    if (!crc_detail::start_fits(spec_, bits)) return CrcBitwise(spec_)(data, bits);
    data = crc_detail::with_start(spec_, data, bits);
    unsigned left = (bits + ChunkBits - 1U) / ChunkBits * ChunkBits;
    std::uint32_t reg = 0;
    if (left > 32) {
      reg = shift_in(reg, static_cast<std::uint32_t>(data >> 32U), left - 32U);
      left = 32;
    }
    reg = shift_in(reg, static_cast<std::uint32_t>(data), left);
    return crc_detail::finish(spec_, reg >> (16U - spec_.width_bits));
  }

 private:
  // The few entries of the small table are wide, which saves a shift in each step.
  using Entry = std::conditional_t<ChunkBits == 4, std::uint32_t, std::uint16_t>;
  static constexpr unsigned entry_bits = 8U * sizeof(Entry);

  // The register is left-aligned in 16 bits, as the table's entries are, so that the same step
  // serves widths below a chunk. It is added to the data before they are shifted out.
  constexpr std::uint32_t shift_in(std::uint32_t reg, std::uint32_t word, unsigned left) const {
    word = (word << (32U - left)) ^ (reg << 16U);
    for (; left > 0; left -= ChunkBits) {
      const std::uint32_t entry = table_[word >> (32U - ChunkBits)];
      word = (word << ChunkBits) ^ (entry << (32U - entry_bits));
    }
    return word >> 16U;
  }

  // The first member, because indexing it then takes one instruction.
  std::array<Entry, std::size_t{1} << ChunkBits> table_{};
  CrcSpec spec_;
};

/// One table for each byte position, 4 KiB: the look-ups are independent of one another, the
/// fastest engine on a PC.
class CrcSliced {
 public:
  constexpr CrcSliced() = default;
  constexpr explicit CrcSliced(const CrcSpec& spec) : spec_(spec) {
    if (!spec.present()) return;
    for (unsigned slice = 0; slice < slices; ++slice) {
      // A remainder is linear in the byte: eight of them give the other 248.
      for (unsigned bit = 0; bit < 8; ++bit) {
        table_[slice][1U << bit] = crc_detail::remainder(spec, 1U << bit, 8, 8 * slice);
      }
      for (unsigned i = 1; i < 256; ++i) {
        const unsigned lowest = i & (~i + 1U);
        table_[slice][i] =
            static_cast<std::uint16_t>(table_[slice][lowest] ^ table_[slice][i ^ lowest]);
      }
    }
    // Every CRC contains one entry of the first table, so the inversion is stored there.
    for (std::uint16_t& entry : table_[0]) entry = crc_detail::finish(spec, entry);
    low_bits_ = spec.start == 0 ? 40 : 0;
  }

  constexpr const CrcSpec& spec() const { return spec_; }

  constexpr std::uint16_t operator()(std::uint64_t data, unsigned bits) const {
    if (bits <= low_bits_) [[likely]]
      return low_slices(data);
    if (spec_.start == 0) return all_slices(data);
    return started(data, bits);
  }

 private:
  static constexpr unsigned slices = 8;

  // Data of up to 40 bits.
  constexpr std::uint16_t low_slices(std::uint64_t data) const {
    using crc_detail::pair;
    const std::uint32_t early = pair(pair(at(0, data), at(1, data)), at(4, data));
    // The fourth byte needs no mask when it is the top one.
    const std::uint32_t fourth = table_[3][static_cast<std::uint32_t>(data) >> 24U];
    return static_cast<std::uint16_t>(early ^ pair(at(2, data), fourth));
  }

  constexpr std::uint16_t all_slices(std::uint64_t data) const {
    const std::uint32_t high = at(4, data) ^ at(5, data) ^ at(6, data) ^ at(7, data);
    return static_cast<std::uint16_t>(high ^ low_slices(data & low_mask(32)));
  }

  // Not inlined: start 0 is the usual case.
  [[gnu::noinline]] constexpr std::uint16_t started(std::uint64_t data, unsigned bits) const {
    if (!crc_detail::start_fits(spec_, bits)) return CrcBitwise(spec_)(data, bits);
    return all_slices(crc_detail::with_start(spec_, data, bits));
  }

  constexpr std::uint32_t at(unsigned slice, std::uint64_t data) const {
    return table_[slice][(data >> (8U * slice)) & 0xFFU];
  }

  CrcSpec spec_;
  // Data of up to this many bits needs the low slices only; 0 if there is a start value.
  std::uint8_t low_bits_ = 0;
  std::array<std::array<std::uint16_t, 256>, slices> table_{};
};

/// The engine for this machine, chosen at compile time: sliced tables on a PC, a table of 16
/// entries on a microcontroller. BISS_SMALL selects the small one on any machine.
#if defined(BISS_SMALL) || (defined(__ARM_ARCH_PROFILE) && __ARM_ARCH_PROFILE == 'M')
using CrcFast = CrcTable<4>;
#else
using CrcFast = CrcSliced;
#endif

}  // namespace biss
