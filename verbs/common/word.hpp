// A frame as a word of digits, without a line: its text, the order of its bits, and which order fits.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "biss/base/bits.hpp"
#include "biss/frame/format.hpp"
#include "verbs/common/verb.hpp"

namespace biss::verbs {

/// Bits in transmission order.
struct Word {
  std::vector<std::uint8_t> bytes;
  std::size_t size_bits = 0;

  BitView view() const { return BitView(bytes, 0, size_bits); }
  void append(bool bit);
  bool operator==(const Word&) const = default;
};

/// The digits of a text: `hex`, `binary`, or `decimal`, a list of bytes.
using Digits = std::string_view;

/// The word in a text, as in debuggers, hex dumps, sources and logs: `F0 00`, `F000`, `0xF000`,
/// `F0:00`, `F0-00`, `\xF0\x00`, `{0xF0, 0x0}`, `0b1111`, `1111 0000`, `240, 0`. Empty for any
/// other text.
std::optional<Word> parse_word(std::string_view text, Digits digits);

/// The order in which a text is tried: hexadecimal first, unless it has 0 and 1 only, and 32 of them
/// or more, or `0b`.
std::array<Digits, 3> digits_in_order(std::string_view text);

/// The place of a frame's bits in a word; the values are the values of the options.
struct WordReading {
  std::string digits;  ///< empty: by digits_in_order()
  std::string bit_order = "msb";
  std::string byte_order = "big";
  bool invert = false;
  /// The first clock of the word. -1: LAT is missing, or LAT and a part of ACK; -2: LAT and ACK are
  /// missing.
  std::int64_t first_bit = 0;
  std::uint64_t bits = 0;  ///< from first_bit on; 0: all
  bool payload = false;

  /// The word begins with the first clock of the request.
  bool has_ack() const { return !payload && first_bit >= 0; }
  bool operator==(const WordReading&) const = default;
};

/// Declares the options of a reading, which need the option `of`. \pre reading outlives the parsing
void add_word_options(Verb verb, WordReading& reading, const Option& of);

/// The bits from the first clock on. Bits that the word lacks (LAT, ACK; with `payload` also START,
/// CDS, STOP) get their correct levels.
Word arrange(const Word& word, const WordReading& reading, const FrameFormat& format);
/// The word is a good frame.
bool is_good(const Word& word, const WordReading& reading, const FrameFormat& format);

/// One line: the options with which more than half of the words are good frames, all if there are
/// several, and how certain that is. Empty if there are none, or the format has no checksum.
/// \param texts the words of a text by its digits; the first one was read by `given`
std::string fitting_options(const std::vector<std::pair<Digits, std::vector<Word>>>& texts,
                            const WordReading& given, const FrameFormat& format);

}  // namespace biss::verbs
