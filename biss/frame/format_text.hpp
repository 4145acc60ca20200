// The text of a frame format:
//
//   frame   = channel *( "+" channel ) *( ";" option )
//   channel = item *( "," item )
//   item    = ("pos"N | "mt"N | "st"N) [":gray"] [":lsb"] | "pad"N | "nE" | "nW" | "E" | "W"
//           | "lc"N | "crc"N [":" POLY [":" START]] [":plain"] *error
//   error   = ":reversed" | ":no-flags" | ":cds" | ":previous"
//   option  = "cds0"
//
// N is decimal, POLY and START are 0x… . The items are in the order on the line. An error is one of
// the encoder's maker (CrcSpec), at most once each. Suffixes are read in any order.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <utility>

#include "biss/base/result.hpp"
#include "biss/frame/format.hpp"
#include "biss/frame/line_order.hpp"

namespace biss {

// ---- Mistakes in the text

/// The mistakes in the text of a frame format.
enum class FormatMistake : std::uint8_t {
  empty,
  unknown_item,
  unexpected_character,
  width_missing,
  width_zero,
  width_too_large,
  item_twice,
  position_twice,
  polarity_twice,
  data_after_crc,
  no_data_before_crc,
  too_long_for_previous,
  too_many_data_bits,
  crc_width,
  polynomial_missing,
  number_needs_0x,
  number_without_digits,
  number_too_large,
  polynomial_form,
  start_too_large,
  too_many_channels,
  unknown_option,
  option_twice,
};

inline constexpr std::size_t format_mistake_count = 23;

/// The mistake, and the index of its character (the text's length if the end is missing).
struct FormatTextError {
  FormatMistake mistake{};
  std::size_t at = 0;

  constexpr bool operator==(const FormatTextError&) const = default;
};

/// The message for a user, without a full stop.
constexpr std::string_view text_of(FormatMistake mistake) {
  constexpr std::array<std::string_view, format_mistake_count> texts{
      "the format is empty",
      "no such item; items are posN, mtN, stN, padN, nE, nW, E, W, lcN, crcN",
      "unexpected character",
      "the number of bits is missing",
      "an item of 0 bits",
      "too many bits for this item",
      "this item is in the channel already",
      "a channel has either pos or mt and st",
      "a flag has one polarity: nE or E, nW or W",
      "crc must be the last item of its channel",
      "crc has nothing to cover",
      "with :previous a channel carries at most 64 bits with its CRC",
      "a channel carries at most 64 bits before its CRC",
      "a CRC has 3 to 16 bits",
      "this CRC width has no usual polynomial; write crcN:0x…",
      "write the number as 0x…",
      "hexadecimal digits are missing",
      "the number is too large",
      "the polynomial must be in full form: as wide as the CRC, top and bottom bit 1",
      "the start value is wider than the CRC",
      "a frame has at most 8 channels",
      "no such option; the option is cds0",
      "this option is in the format already"};
  return texts[static_cast<std::size_t>(mistake)];
}

namespace frame_detail {

using Parsed = Result<bool, FormatTextError>;

// The value of a hexadecimal digit; 16 for other characters.
constexpr std::uint32_t digit_of(char c) {
  if (c >= '0' && c <= '9') return static_cast<std::uint32_t>(c - '0');
  if (c >= 'a' && c <= 'f') return static_cast<std::uint32_t>(c - 'a') + 10;
  if (c >= 'A' && c <= 'F') return static_cast<std::uint32_t>(c - 'A') + 10;
  return 16;
}

// Parses one format. Offsets count from the front of a channel and become shifts when its width is
// known.
class FormatParser {
 public:
  constexpr explicit FormatParser(std::string_view text) : text_(text) {}

  constexpr Result<FrameFormat, FormatTextError> parse() {
    if (text_.empty()) return fail(FormatMistake::empty, 0);
    do {
      if (format_.channel_count == max_channels) {
        return fail(FormatMistake::too_many_channels, at_ - 1);
      }
      const Parsed channel = parse_channel();
      if (!channel.ok()) return failure(channel.error());
    } while (take('+'));
    while (take(';')) {
      const std::size_t begin = at_;
      if (!take_word("cds0") || !at_separator()) return fail(FormatMistake::unknown_option, begin);
      if (format_.cds0) return fail(FormatMistake::option_twice, begin);
      format_.cds0 = true;
    }
    if (at_ != text_.size()) return fail(FormatMistake::unexpected_character, at_);
    return format_;
  }

 private:
  constexpr Parsed parse_channel() {
    channel_ = {};
    do {
      const Parsed item = parse_item();
      if (!item.ok()) return item;
    } while (take(','));
    const auto settle = [this](auto& field, unsigned bits) {
      field.shift = static_cast<std::uint8_t>(channel_.data_bits - field.shift - bits);
    };
    for (Field* field :
         {&channel_.position, &channel_.multiturn, &channel_.singleturn, &channel_.life_counter}) {
      if (field->present()) settle(*field, field->bits);
    }
    for (FlagField* flag : {&channel_.error, &channel_.warning}) {
      if (flag->present) settle(*flag, 1);
    }
    format_.channel_list[format_.channel_count++] = channel_;
    return true;
  }

  constexpr Parsed parse_item() {
    begin_ = at_;
    if (channel_.crc.present()) return fail(FormatMistake::data_after_crc, begin_);
    if (take_word("pos")) return parse_position(channel_.position);
    if (take_word("mt")) return parse_position(channel_.multiturn);
    if (take_word("st")) return parse_position(channel_.singleturn);
    if (take_word("pad")) return parse_run(nullptr, max_data_bits);
    if (take_word("lc")) return parse_run(&channel_.life_counter, max_life_counter_bits);
    if (take_word("crc")) return parse_crc();
    if (take_word("nE")) return parse_flag(channel_.error, false);
    if (take_word("nW")) return parse_flag(channel_.warning, false);
    if (take_word("E")) return parse_flag(channel_.error, true);
    if (take_word("W")) return parse_flag(channel_.warning, true);
    return fail(FormatMistake::unknown_item, begin_);
  }

  constexpr Parsed parse_position(Field& field) {
    const bool is_pos = &field == &channel_.position;
    const bool has_turns = channel_.multiturn.present() || channel_.singleturn.present();
    if (is_pos ? has_turns : channel_.position.present()) {
      return fail(FormatMistake::position_twice, begin_);
    }
    const Parsed run = parse_run(&field, max_data_bits);
    if (!run.ok()) return run;
    bool gray = false;
    bool lsb = false;
    while (take_once(":gray", gray) || take_once(":lsb", lsb)) {
    }
    if (take(':') || !at_separator()) return fail(FormatMistake::unexpected_character, at_);
    if (is_pos) {
      channel_.position_gray = gray;
      channel_.position_lsb = lsb;
    } else if (&field == &channel_.multiturn) {
      channel_.multiturn_gray = gray;
      channel_.multiturn_lsb = lsb;
    } else {
      channel_.singleturn_gray = gray;
      channel_.singleturn_lsb = lsb;
    }
    return true;
  }

  // N bits of this item; `field` is null for padding.
  constexpr Parsed parse_run(Field* field, unsigned limit) {
    if (field != nullptr && field->present()) return fail(FormatMistake::item_twice, begin_);
    const auto bits = parse_width(limit);
    if (!bits.ok()) return failure(bits.error());
    const Parsed room = claim(*bits);
    if (!room.ok()) return room;
    if (field != nullptr) {
      field->shift = static_cast<std::uint8_t>(channel_.data_bits - *bits);
      field->bits = static_cast<std::uint8_t>(*bits);
    }
    return true;
  }

  constexpr Parsed parse_flag(FlagField& flag, bool active_high) {
    if (flag.present) {
      const bool same = flag.active_high == active_high;
      return fail(same ? FormatMistake::item_twice : FormatMistake::polarity_twice, begin_);
    }
    if (!at_separator()) return fail(FormatMistake::unexpected_character, at_);
    const Parsed room = claim(1);
    if (!room.ok()) return room;
    flag = {static_cast<std::uint8_t>(channel_.data_bits - 1), true, active_high};
    return true;
  }

  constexpr Parsed parse_crc() {
    if (channel_.data_bits == 0) return fail(FormatMistake::no_data_before_crc, begin_);
    const std::size_t width_at = at_;
    const auto width = parse_width(max_data_bits);
    if (!width.ok()) return failure(width.error());
    if (*width < min_crc_bits || *width > max_crc_bits) {
      return fail(FormatMistake::crc_width, width_at);
    }
    CrcSpec crc{default_polynomial(*width), 0, static_cast<std::uint8_t>(*width), true};
    if (take_number_colon()) {
      const Parsed numbers = parse_crc_numbers(crc);
      if (!numbers.ok()) return numbers;
    }
    const Parsed suffixes = parse_crc_suffixes(crc);
    if (!suffixes.ok()) return suffixes;
    if (crc.polynomial == 0) return fail(FormatMistake::polynomial_missing, width_at);
    const unsigned flags =
        (channel_.error.present ? 1U : 0U) + (channel_.warning.present ? 1U : 0U);
    if (crc.without_flags && flags == channel_.data_bits) {
      return fail(FormatMistake::no_data_before_crc, begin_);
    }
    if (crc.of_previous && channel_.data_bits + *width > max_data_bits) {
      return fail(FormatMistake::too_long_for_previous, begin_);
    }
    channel_.crc = crc;
    return true;
  }

  constexpr Parsed parse_crc_suffixes(CrcSpec& crc) {
    bool plain = false;
    bool reversed = false;
    bool without_flags = false;
    bool with_cds = false;
    bool of_previous = false;
    while (take_once(":plain", plain) || take_once(":reversed", reversed) ||
           take_once(":no-flags", without_flags) || take_once(":cds", with_cds) ||
           take_once(":previous", of_previous)) {
    }
    if (!at_separator()) return fail(FormatMistake::unexpected_character, at_);
    crc.inverted = !plain;
    crc.reversed = reversed;
    crc.without_flags = without_flags;
    crc.with_cds = with_cds;
    crc.of_previous = of_previous;
    return true;
  }

  constexpr Parsed parse_crc_numbers(CrcSpec& crc) {
    const std::size_t polynomial_at = at_;
    const auto polynomial = parse_hexadecimal();
    if (!polynomial.ok()) return failure(polynomial.error());
    if (!is_full_form(*polynomial, crc.width_bits)) {
      return fail(FormatMistake::polynomial_form, polynomial_at);
    }
    crc.polynomial = *polynomial;
    if (!take_number_colon()) return true;
    const std::size_t start_at = at_;
    const auto start = parse_hexadecimal();
    if (!start.ok()) return failure(start.error());
    if (*start > crc.mask()) return fail(FormatMistake::start_too_large, start_at);
    crc.start = static_cast<std::uint16_t>(*start);
    return true;
  }

  constexpr Result<unsigned, FormatTextError> parse_width(unsigned limit) {
    const std::size_t begin = at_;
    unsigned value = 0;
    while (at_ < text_.size() && text_[at_] >= '0' && text_[at_] <= '9') {
      value = value * 10 + static_cast<unsigned>(text_[at_++] - '0');
      if (value > limit) return fail(FormatMistake::width_too_large, begin);
    }
    if (at_ == begin) return fail(FormatMistake::width_missing, begin);
    if (value == 0) return fail(FormatMistake::width_zero, begin);
    if (!at_separator() && text_[at_] != ':') return fail(FormatMistake::unexpected_character, at_);
    return value;
  }

  constexpr Result<std::uint32_t, FormatTextError> parse_hexadecimal() {
    const std::size_t begin = at_;
    if (!take_word("0x") && !take_word("0X")) return fail(FormatMistake::number_needs_0x, begin);
    const std::size_t first = at_;
    std::uint32_t value = 0;
    for (; at_ < text_.size() && digit_of(text_[at_]) < 16; ++at_) {
      if (value >= (1U << 20U)) return fail(FormatMistake::number_too_large, begin);
      value = value * 16 + digit_of(text_[at_]);
    }
    if (at_ == first) return fail(FormatMistake::number_without_digits, at_);
    return value;
  }

  constexpr Parsed claim(unsigned bits) {
    if (channel_.data_bits + bits > max_data_bits) {
      return fail(FormatMistake::too_many_data_bits, begin_);
    }
    channel_.data_bits = static_cast<std::uint8_t>(channel_.data_bits + bits);
    return true;
  }

  constexpr bool take(char c) {
    if (at_ == text_.size() || text_[at_] != c) return false;
    ++at_;
    return true;
  }

  // Not substr(): its range check would bring exceptions into firmware.
  constexpr std::string_view rest() const { return {text_.data() + at_, text_.size() - at_}; }

  constexpr bool take_word(std::string_view word) {
    if (!rest().starts_with(word)) return false;
    at_ += word.size();
    return true;
  }

  constexpr bool take_once(std::string_view suffix, bool& taken) {
    if (taken || !take_word(suffix)) return false;
    taken = true;
    return true;
  }

  // The colon before a number, not the colon of a suffix.
  constexpr bool take_number_colon() {
    for (const std::string_view suffix :
         {":plain", ":reversed", ":no-flags", ":cds", ":previous"}) {
      if (rest().starts_with(suffix)) return false;
    }
    return take(':');
  }

  constexpr bool at_separator() const {
    return at_ == text_.size() || text_[at_] == ',' || text_[at_] == '+' || text_[at_] == ';';
  }

  constexpr Failure<FormatTextError> fail(FormatMistake mistake, std::size_t at) const {
    return failure(FormatTextError{mistake, at});
  }

  std::string_view text_;
  std::size_t at_ = 0;
  std::size_t begin_ = 0;
  ChannelFormat channel_;
  FrameFormat format_;
};

}  // namespace frame_detail

/// Parses the text of a frame format; the grammar is at the top of this file.
/// \return the format, or the mistake and the index of its character
constexpr Result<FrameFormat, FormatTextError> parse_format(std::string_view text) {
  return frame_detail::FormatParser(text).parse();
}

namespace frame_detail {

// Never defined: the compiler prints its name and the mistake if the text of a format is wrong.
template <FormatMistake Mistake>
void this_format_text_is_wrong();

template <std::size_t... Index>
constexpr void stop_at(FormatMistake mistake, std::index_sequence<Index...>) {
  ((static_cast<std::size_t>(mistake) == Index
        ? this_format_text_is_wrong<static_cast<FormatMistake>(Index)>()
        : void()),
   ...);
}

}  // namespace frame_detail

/// The format of a text while compiling; a mistake stops the build with its name.
///
///   constexpr FrameFormat format = frame_format("pos26,nE,nW,crc6;cds0");
consteval FrameFormat frame_format(std::string_view text) {
  const auto format = parse_format(text);
  if (!format.ok()) {
    frame_detail::stop_at(format.error().mistake, std::make_index_sequence<format_mistake_count>());
  }
  return *format;
}

// ---- The canonical text

/// Text of limited length, without heap.
class FormatText {
 public:
  constexpr std::string_view view() const { return {text_.data(), size_}; }

  constexpr void append(std::string_view part) {
    for (const char c : part) text_[size_++] = c;
  }

  constexpr void append_number(std::uint32_t value, unsigned base) {
    std::array<char, 10> digits{};
    std::size_t count = 0;
    do {
      digits[count++] = "0123456789ABCDEF"[value % base];
      value /= base;
    } while (value != 0);
    while (count > 0) text_[size_++] = digits[--count];
  }

 private:
  // The longest channel has a 1-bit pad before each of its other items, 129 characters:
  // "pad1,mt1:gray:lsb,pad1,st1:gray:lsb,pad1,nE,pad1,nW,pad1,lc32,pad1,
  // crc16:0x190D9:0xFFFF:plain:reversed:no-flags:cds:previous+"
  std::array<char, 8 * 129> text_{};
  std::size_t size_ = 0;
};

namespace frame_detail {

constexpr void append_crc(FormatText& text, const CrcSpec& crc) {
  text.append(",crc");
  text.append_number(crc.width_bits, 10);
  if (crc.start != 0 || crc.polynomial != default_polynomial(crc.width_bits)) {
    text.append(":0x");
    text.append_number(crc.polynomial, 16);
  }
  if (crc.start != 0) {
    text.append(":0x");
    text.append_number(crc.start, 16);
  }
  if (!crc.inverted) text.append(":plain");
  if (crc.reversed) text.append(":reversed");
  if (crc.without_flags) text.append(":no-flags");
  if (crc.with_cds) text.append(":cds");
  if (crc.of_previous) text.append(":previous");
}

constexpr void append_channel(FormatText& text, const ChannelFormat& channel) {
  bool first = true;
  for_each_field(channel, [&](const LineField& field) {
    if (!first) text.append(",");
    first = false;
    text.append(field.name);
    if (!field.is_flag()) text.append_number(field.place.bits, 10);
    if (field.gray) text.append(":gray");
    if (field.lsb) text.append(":lsb");
  });
  if (channel.crc.present()) append_crc(text, channel.crc);
}

}  // namespace frame_detail

/// The canonical text: adjacent padding is one item; polynomial and start value appear only if they
/// are not the usual ones. parse_format() of this text gives the same format.
constexpr FormatText format_text(const FrameFormat& format) {
  FormatText text;
  bool first = true;
  for (const ChannelFormat& channel : format.channels()) {
    if (!first) text.append("+");
    first = false;
    frame_detail::append_channel(text, channel);
  }
  if (format.cds0) text.append(";cds0");
  return text;
}

}  // namespace biss
