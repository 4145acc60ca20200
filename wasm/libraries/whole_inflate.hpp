// Deflate (RFC 1951) of a stream that is whole in memory, into memory that is large enough: without
// the states of a decompressor that can stop anywhere.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace biss::wasm {

/// What a symbol of a code says, packed; see whole_inflate.cpp.
using DeflateEntry = std::uint32_t;

/// A canonical prefix code. Codes of up to `TableBits` are looked up, longer ones are counted out.
template <unsigned TableBits>
class DeflateCode {
 public:
  /// \param lengths of the code of each symbol, up to 15 bits; 0 where it has none
  /// \param results what the symbols say
  /// Returns whether this is a code: complete, empty, or one symbol of one bit.
  bool build(std::span<const std::uint8_t> lengths, const DeflateEntry* results);

  /// The entry that the next bits select, with its number of bits. \pre `next` has 15 bits
  DeflateEntry at(std::uint64_t next) const;

 private:
  DeflateEntry count_out(std::uint64_t next) const;

  static constexpr unsigned most_bits = 15;
  std::array<DeflateEntry, std::size_t{1} << TableBits> table_{};
  // In the order of their codes, and how many there are of each length.
  std::array<DeflateEntry, 320> sorted_{};
  std::array<std::uint16_t, most_bits + 1> counts_{};
};

struct Inflated {
  std::size_t used = 0;  ///< bytes of the stream
  std::size_t made = 0;
};

class WholeInflater {
 public:
  /// Decompresses the stream at the front of `in`. Nothing where it is damaged or does not end, or
  /// where it makes more than `out` holds.
  std::optional<Inflated> inflate(std::span<const std::uint8_t> in, std::span<std::uint8_t> out);

 private:
  class Bits;
  struct Output;

  bool read_codes(Bits& bits);
  void set_fixed_codes();
  bool inflate_codes(Bits& bits, Output& out) const;

  DeflateCode<11> literals_;
  DeflateCode<9> distances_;
};

}  // namespace biss::wasm
