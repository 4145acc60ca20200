// The canonical text of a frame format: parse_format() of it gives the same format back.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "biss/frame/format.hpp"

namespace biss {

/// Text of bounded length, without heap.
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
  // A channel is longest with a 1-bit pad before each of its other items:
  // "pad1,mt1,pad1,st1:gray,pad1,nE,pad1,nW,pad1,lc32,pad1,crc16:0x190D9:0xFFFF:plain+", 84
  // characters.
  std::array<char, 8 * 96> text_{};
  std::size_t size_ = 0;
};

namespace frame_detail {

// Whatever begins at a channel's data bit, found by its place; null name: padding.
struct NamedRun {
  std::string_view name;
  unsigned bits = 0;
  bool is_flag = false;
};

constexpr NamedRun run_below(const ChannelFormat& channel, unsigned top) {
  const auto ends_at = [top](unsigned shift, unsigned bits) {
    return bits != 0 && shift + bits == top;
  };
  if (ends_at(channel.position.shift, channel.position.bits)) {
    return {"pos", channel.position.bits};
  }
  if (ends_at(channel.multiturn.shift, channel.multiturn.bits)) {
    return {"mt", channel.multiturn.bits};
  }
  if (ends_at(channel.singleturn.shift, channel.singleturn.bits)) {
    return {"st", channel.singleturn.bits};
  }
  if (ends_at(channel.life_counter.shift, channel.life_counter.bits)) {
    return {"lc", channel.life_counter.bits};
  }
  if (ends_at(channel.error.shift, channel.error.present ? 1 : 0)) {
    return {channel.error.active_high ? "E" : "nE", 1, true};
  }
  if (ends_at(channel.warning.shift, channel.warning.present ? 1 : 0)) {
    return {channel.warning.active_high ? "W" : "nW", 1, true};
  }
  return {};
}

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
}

constexpr void append_channel(FormatText& text, const ChannelFormat& channel) {
  unsigned padding = 0;
  bool first = true;
  const auto item = [&](std::string_view name, unsigned bits, bool is_flag) {
    if (!first) text.append(",");
    first = false;
    text.append(name);
    if (!is_flag) text.append_number(bits, 10);
  };
  for (unsigned top = channel.data_bits; top > 0;) {
    const NamedRun run = run_below(channel, top);
    if (run.bits == 0) {
      ++padding;
      --top;
      continue;
    }
    if (padding != 0) item("pad", padding, false);
    padding = 0;
    item(run.name, run.bits, run.is_flag);
    if (run.name == "st" && channel.singleturn_gray) text.append(":gray");
    top -= run.bits;
  }
  if (padding != 0) item("pad", padding, false);
  if (channel.crc.present()) append_crc(text, channel.crc);
}

}  // namespace frame_detail

/// The canonical text: neighbouring padding as one item, polynomial and start only where they are
/// not the usual ones.
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
