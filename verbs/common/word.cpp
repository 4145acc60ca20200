#include "verbs/common/word.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "biss/frame/codec.hpp"
#include "biss/frame/decode.hpp"
#include "dump/text.hpp"
#include "identify/log_gamma.hpp"

namespace biss::verbs {
namespace {

constexpr std::size_t least_binary_digits = 32;
// A reading is not certain if it fits by chance more often than this.
constexpr double largest_chance = 0.02;
// Further words show nothing new.
constexpr std::size_t words_to_try = 200;

bool append_digits(Word& word, std::string_view digits, unsigned bits) {
  for (const char c : digits) {
    const int value = dump::hex_value(c);
    if (value < 0 || value >> bits != 0) return false;
    for (unsigned bit = bits; bit-- > 0;) word.append((value >> bit & 1) != 0);
  }
  return !digits.empty();
}

// `\xF0\x00` as `0xF0 0x00`; no token if there is anything else between them except quotes and
// blanks.
std::string without_escapes(std::string_view text) {
  std::string out;
  if (text.starts_with('b')) text.remove_prefix(1);
  while (!text.empty()) {
    if (text.starts_with("\\x") && dump::hex_byte(text.substr(2, 2))) {
      out += fmt::format("0x{} ", text.substr(2, 2));
      text.remove_prefix(4);
    } else if (std::string_view(" \"'").find(text.front()) != std::string_view::npos) {
      text.remove_prefix(1);
    } else {
      return {};
    }
  }
  return out;
}

std::vector<std::string> tokens_of(std::string_view text) {
  std::string plain(dump::trimmed(text));
  if (plain.find("\\x") != std::string::npos) plain = without_escapes(plain);
  // In a declaration in C, take the values.
  if (const std::size_t brace = plain.find('{'); brace != std::string::npos) {
    plain = plain.substr(brace + 1, plain.find('}') - brace - 1);
  }
  std::vector<std::string> tokens(1);
  for (const char c : plain) {
    if (std::string_view(" ,;[]()\n\t\r").find(c) == std::string_view::npos) {
      tokens.back() += c;
    } else if (!tokens.back().empty()) {
      tokens.emplace_back();
    }
  }
  if (tokens.back().empty()) tokens.pop_back();
  return tokens;
}

// `F0:00`, `F0-00`: one separator between all pairs of digits.
void join_pairs(std::string& token) {
  for (const char separator : {':', '-'}) {
    bool everywhere = token.size() > 2 && token.size() % 3 == 2;
    for (std::size_t i = 2; i < token.size(); i += 3) everywhere &= token[i] == separator;
    if (everywhere) std::erase(token, separator);
  }
}

bool append_token(Word& word, std::string token, Digits digits, bool is_only) {
  const bool is_hex = digits != "binary";
  const bool prefixed =
      token.starts_with(is_hex ? "0x" : "0b") || token.starts_with(is_hex ? "0X" : "0B");
  if (prefixed) token.erase(0, 2);
  if (prefixed || digits == "decimal") token.erase(token.find_last_not_of("uUlL") + 1);
  if (digits == "decimal" && !prefixed) {
    const auto byte = dump::number_in_base(token, 10);
    return byte && *byte <= 0xFF && append_digits(word, fmt::format("{:02X}", *byte), 4);
  }
  // Several binary numbers are bytes.
  if (!is_hex)
    return (!prefixed || is_only || token.size() % 8 == 0) && append_digits(word, token, 1);
  if (prefixed && token.size() == 1) token.insert(0, "0");
  if (!prefixed) join_pairs(token);
  // One number may end within a byte.
  const bool is_odd = token.size() % 2 != 0 && !(prefixed && is_only);
  return !is_odd && (digits == "hex" || token.size() == 2) && append_digits(word, token, 4);
}

std::size_t bytes_of_group(const WordReading& reading, std::size_t all) {
  if (reading.byte_order == "big") return 1;
  if (reading.byte_order == "little") return all;
  return reading.byte_order == "little16" ? 2 : reading.byte_order == "little32" ? 4 : 8;
}

Word in_order(Word word, const WordReading& reading) {
  const std::size_t size = bytes_of_group(reading, word.bytes.size());
  for (auto left = word.bytes.begin(); size > 1 && left != word.bytes.end();) {
    const auto end = left + std::min(static_cast<std::ptrdiff_t>(size), word.bytes.end() - left);
    std::reverse(left, end);
    left = end;
  }
  for (std::uint8_t& byte : word.bytes) {
    const std::uint64_t bits =
        reading.bit_order == "lsb" ? frame_detail::bits_reversed(byte, 8) : byte;
    byte = static_cast<std::uint8_t>(reading.invert ? ~bits : bits);
  }
  return word;
}

// The first `count` bits, or all if it is 0 or more than there are.
BitView first_bits(const BitView& all, std::uint64_t count) {
  if (count == 0 || count >= all.size_bits()) return all;
  return all.first(static_cast<std::size_t>(count));
}

// The frame at the place of the reading, in a word with its bits in order.
Word line_of(const Word& ordered, const WordReading& place, const FrameFormat& format) {
  const auto first = static_cast<std::size_t>(std::max<std::int64_t>(place.first_bit, 0));
  BitView clocks = ordered.view().from(std::min(first, ordered.size_bits));
  clocks = first_bits(clocks, place.bits);
  const std::size_t payload = format.payload_bits();
  const bool whole = clocks.size_bits() >= payload;
  if (place.payload && whole) clocks = clocks.from(clocks.size_bits() - payload);
  const std::string_view missing = place.payload           ? "1010"
                                   : place.first_bit == -2 ? "10"
                                   : place.first_bit == -1 ? "1"
                                                           : "";
  Word out;
  for (const char bit : missing) out.append(bit == '1');
  for (std::size_t i = 0; i < clocks.size_bits(); ++i) out.append(clocks[i]);
  if (place.payload && whole) out.append(false);
  return out;
}

enum class Fit : std::uint8_t { none, structure, checksum };

// Stricter than the decoder: the word begins as in the reading, and has zeros outside of the frame.
Fit fit_of(const Word& word, const Word& line, const WordReading& place,
           const FrameCodec<>& codec) {
  const BitView all = word.view();
  const std::size_t end = first_bits(all, place.bits).size_bits();
  const std::size_t payload = codec.payload_bits();
  if (all.size_bits() < 2 || all.find(!all[0], 0) == all.size_bits()) return Fit::none;
  const bool begins = place.payload ? end >= payload && all.find(true, 0) >= end - payload &&
                                          all.find(true, end) == all.size_bits()
                      : place.first_bit == 1
                          ? !all[0] && all[1]
                          : place.first_bit == 0 || all[0] == (place.first_bit == -2);
  const auto start = find_start(line.view(), FrameBounds{});
  if (!begins || !start.ok()) return Fit::none;
  const auto frame = decode_payload(line.view(), *start, codec);
  if (!frame.ok()) return frame.error().cause == FrameError::crc ? Fit::structure : Fit::none;
  const bool is_low = line.view().find(true, start->start_bit + 2 + payload) == line.size_bits;
  return is_low || place.bits != 0 ? Fit::checksum : Fit::none;
}

// The places that are worth a try, in words with their bits in order.
std::vector<WordReading> places_in(const std::vector<Word>& words, const WordReading& order,
                                   const FrameCodec<>& codec) {
  std::vector<WordReading> places;
  for (const int first_bit : {0, 1, -1, -2}) places.emplace_back(order).first_bit = first_bit;
  std::size_t clocks = 0;
  bool is_low = true;
  for (const Word& word : words) {
    const auto start = find_start(word.view(), FrameBounds{});
    if (!start.ok()) continue;
    const auto frame = decode_payload(word.view(), *start, codec);
    if (!frame.ok() && frame.error().cause != FrameError::stop_bit) continue;
    const std::size_t end = start->start_bit + 2 + codec.payload_bits();
    is_low = is_low && word.view().find(true, end) == word.size_bits;
    clocks = std::max(clocks, end);
  }
  if (is_low) clocks = 0;
  const std::size_t size = words.front().size_bits;
  const std::size_t payload = codec.payload_bits();
  for (const std::size_t bits : {clocks, std::size_t{0}, size - 1, payload + 1, payload}) {
    const bool is_frame = places.size() == 4;
    places.push_back(order);
    places.back().payload = !is_frame;
    places.back().bits = bits < size ? bits : 0;
  }
  return places;
}

std::string options_of(const WordReading& reading) {
  std::string out;
  const auto add = [&out](bool given, std::string_view option, const auto& value) {
    if (given) out += fmt::format("{}{}{}", out.empty() ? "" : " ", option, value);
  };
  add(!reading.digits.empty(), "--digits ", reading.digits);
  add(reading.payload, "--payload", "");
  add(reading.invert, "--invert", "");
  add(reading.bit_order != "msb", "--bit-order ", reading.bit_order);
  add(reading.byte_order != "big", "--byte-order ", reading.byte_order);
  add(reading.first_bit != 0, "--first-bit ", reading.first_bit);
  add(reading.bits != 0, "--bits ", reading.bits);
  return out.empty() ? "no such option" : out;
}

const std::vector<std::string> byte_orders{"big", "little", "little16", "little32", "little64"};

// Which readings fit, each tried once.
class Search {
 public:
  Search(const WordReading& given, const FrameFormat& format) : given_(given), codec_(format) {
    for (const ChannelFormat& channel : format.channels()) checksum_bits_ += channel.crc.width_bits;
  }

  void add(const std::vector<Word>& all, const WordReading& given) {
    std::vector<Word> words;
    for (const Word& word : all) {
      const bool is_new = std::find(words.begin(), words.end(), word) == words.end();
      if (is_new && words.size() < words_to_try) words.push_back(word);
    }
    // In every order of bits and bytes.
    for (const std::string& byte_order : byte_orders) {
      for (const unsigned k : {0U, 1U, 2U, 3U}) {
        try_order(words, {.digits = given.digits,
                          .bit_order = k % 2 == 0 ? "msb" : "lsb",
                          .byte_order = byte_order,
                          .invert = k / 2 == 1});
      }
    }
  }

  std::string text() const {
    if (names_.empty() || checksum_bits_ == 0) return {};
    if (names_.size() > 1) {
      return fmt::format("unsure: {} fit; more words decide", fmt::join(names_, " and "));
    }
    const double chance = std::min(1.0, chance_ * static_cast<double>(seen_.size()));
    if (chance <= largest_chance) return names_.front() + " fits";
    return fmt::format(
        "unsure: {} fits, by chance in {:.0f} % of cases ({} tried); more words decide",
        names_.front(), 100 * chance, seen_.size());
  }

 private:
  void try_order(const std::vector<Word>& words, const WordReading& order) {
    const std::size_t group = 8 * bytes_of_group(order, words.front().bytes.size());
    const bool moves = group > 8 || order.bit_order == "lsb";
    std::vector<Word> ordered;
    for (const Word& word : words) {
      if (moves && word.size_bits % group != 0) return;
      ordered.push_back(in_order(word, order));
    }
    for (const WordReading& place : places_in(ordered, order, codec_)) try_place(ordered, place);
  }

  void try_place(const std::vector<Word>& ordered, WordReading place) {
    std::vector<Word> lines;
    std::size_t structure = 0;
    std::size_t good = 0;
    for (const Word& word : ordered) {
      lines.push_back(line_of(word, place, codec_.format()));
      const Fit fit = fit_of(word, lines.back(), place, codec_);
      structure += fit != Fit::none ? 1U : 0U;
      good += fit == Fit::checksum ? 1U : 0U;
    }
    const std::size_t words = ordered.size();
    if (2 * structure <= words || std::find(seen_.begin(), seen_.end(), lines) != seen_.end())
      return;
    seen_.push_back(std::move(lines));
    if (2 * good <= words || place == given_) return;
    const std::string count = words == 1 ? "" : fmt::format(" ({} of {})", good, words);
    names_.push_back(options_of(place) + count);
    const auto [n, k] = std::pair(static_cast<double>(words), static_cast<double>(good));
    chance_ = std::exp(identify::log_gamma(n + 1) - identify::log_gamma(k + 1) -
                       identify::log_gamma(n - k + 1) - k * checksum_bits_ * std::log(2.0));
  }

  const WordReading& given_;
  FrameCodec<> codec_;
  unsigned checksum_bits_ = 0;
  std::vector<std::vector<Word>> seen_;
  std::vector<std::string> names_;
  // The probability that one of the readings fits as many words by chance.
  double chance_ = 1;
};

}  // namespace

void Word::append(bool bit) {
  if (size_bits % 8 == 0) bytes.push_back(0);
  if (bit) bytes.back() = static_cast<std::uint8_t>(bytes.back() | 0x80U >> size_bits % 8);
  ++size_bits;
}

std::optional<Word> parse_word(std::string_view text, Digits digits) {
  const auto tokens = tokens_of(text);
  Word word;
  for (const std::string& token : tokens) {
    if (!append_token(word, token, digits, tokens.size() == 1)) return std::nullopt;
  }
  const bool is_list = digits != "decimal" || tokens.size() > 1;
  return word.size_bits != 0 && is_list ? std::optional(std::move(word)) : std::nullopt;
}

std::array<Digits, 3> digits_in_order(std::string_view text) {
  const auto bits = parse_word(text, "binary");
  const bool prefixed = text.find("0b") != std::string_view::npos;
  if (bits && (prefixed || bits->size_bits >= least_binary_digits))
    return {"binary", "hex", "decimal"};
  return {"hex", "binary", "decimal"};
}

void add_word_options(Verb given, WordReading& reading, const Option& of) {
  Verb verb = given.section("Words");
  add_name_option(verb, "--digits", reading.digits, {"hex", "binary", "decimal"},
                  "Digits of the text; by default hexadecimal if possible, but binary if there are "
                  "32 or more and all are 0 or 1. decimal is a list of bytes")
      .needs(of);
  add_name_option(verb, "--bit-order", reading.bit_order, {"msb", "lsb"},
                  "Bit of each byte that was received first: the highest (default) or lowest")
      .needs(of);
  add_name_option(verb, "--byte-order", reading.byte_order, byte_orders,
                  "Order of the bytes: as received (big, the default), the whole word reversed, or "
                  "in words of 16, 32 or 64 bits")
      .needs(of);
  verb.add_flag("--invert", reading.invert, "Invert all bits: the two wires of SLO are swapped")
      .needs(of);
  verb.add_option("--first-bit", reading.first_bit,
                  "Bit of the first clock; 0 by default. -1: the word begins within ACK; -2: it "
                  "begins with START")
      .type_name("N")
      .needs(of);
  add_count_option(verb, "--bits", into(reading.bits),
                   "Number of clocks, from the first bit on; all bits by default", 65'535)
      .needs(of);
  verb.add_flag("--payload", reading.payload,
                "The word (or the bits of --bits) ends with the frame after CDS up to its CRC, "
                "without ACK and START")
      .needs(of);
  verb.after_parsing([&reading] {
    const std::int64_t least = reading.payload ? 0 : -2;
    if (reading.first_bit < least || reading.first_bit > 65'535) {
      wrong_value("--first-bit", fmt::format("from {} to 65535", least));
    }
  });
}

Word arrange(const Word& word, const WordReading& reading, const FrameFormat& format) {
  return line_of(in_order(word, reading), reading, format);
}

bool is_good(const Word& word, const WordReading& reading, const FrameFormat& format) {
  const Word line = arrange(word, reading, format);
  return decode_frame(line.view(), FrameCodec<>(format), FrameBounds{}).ok();
}

std::string fitting_options(const std::vector<std::pair<Digits, std::vector<Word>>>& texts,
                            const WordReading& given, const FrameFormat& format) {
  Search search(given, format);
  for (const auto& [digits, words] : texts) {
    WordReading named = given;
    if (digits != texts.front().first) named.digits = digits;
    search.add(words, named);
  }
  return search.text();
}

}  // namespace biss::verbs
