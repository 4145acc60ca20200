#include "explain/checksum_variant.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "biss/crc/engines.hpp"
#include "biss/frame/format_text.hpp"

namespace biss::explain {

namespace {

constexpr std::size_t mistake_count = 7;
constexpr unsigned flag_bits = 2;
// START and CDS.
constexpr std::size_t before_data = 2;
// Of the frames, the part that a rule must fit; some may be damaged.
constexpr std::size_t fitting_percent = 85;
constexpr std::size_t least_frames = 8;

std::uint64_t reversed(std::uint64_t word, unsigned bits) {
  std::uint64_t out = 0;
  for (unsigned i = 0; i < bits; ++i) out |= ((word >> i) & 1U) << (bits - 1 - i);
  return out;
}

std::uint64_t data_of(const ChecksumVariant& rule, BitView raw) {
  return raw.word(before_data, rule.data_bits);
}

std::uint64_t received(const ChecksumVariant& rule, BitView raw) {
  return raw.word(before_data + rule.data_bits, rule.crc.width_bits);
}

// The suffix of `crc` in a format text; none for the others.
std::string_view suffix_of(Mistake mistake) {
  constexpr std::array<std::string_view, mistake_count> suffixes{
      ":reversed", ":no-flags", ":cds", ":previous", ":lsb", "", ""};
  return suffixes[static_cast<std::size_t>(mistake)];
}

// The usual checksums of frames whose format is not known.
std::vector<ChecksumVariant> layouts(const std::optional<FrameFormat>& format, unsigned payload) {
  std::vector<ChecksumVariant> all;
  if (format) {
    const ChannelFormat& channel = format->channel_list[0];
    if (format->channel_count != 1 || !channel.crc.present()) return all;
    all.push_back({.data_bits = channel.data_bits, .crc = channel.crc});
    return all;
  }
  constexpr std::array<std::uint8_t, 4> widths{6, 16, 5, 8};
  for (const std::uint8_t width : widths) {
    if (payload < width + 4U || payload > width + max_data_bits) continue;
    all.push_back({.data_bits = payload - width,
                   .crc = {.polynomial = default_polynomial(width), .width_bits = width}});
  }
  return all;
}

// Enough of them differ.
bool vary(const ChecksumVariant& rule, std::span<const WrongFrame> frames) {
  std::vector<std::uint64_t> data;
  for (const WrongFrame& frame : frames) data.push_back(data_of(rule, frame.raw.view()));
  std::sort(data.begin(), data.end());
  return std::unique(data.begin(), data.end()) - data.begin() >= std::ptrdiff_t{least_frames / 2};
}

std::size_t fitting(const ChecksumVariant& rule, std::span<const WrongFrame> frames) {
  return static_cast<std::size_t>(std::count_if(
      frames.begin(), frames.end(),
      [&](const WrongFrame& frame) { return rule.fits(frame.raw.view(), frame.before.view()); }));
}

std::string format_of(const ChecksumVariant& rule, const std::optional<FrameFormat>& format) {
  const std::string_view suffix = suffix_of(rule.mistake);
  if (suffix.empty()) return {};
  std::string text =
      format ? std::string(format_text(*format).view())
             : fmt::format("pos{},nE,nW,crc{}", rule.data_bits - flag_bits, rule.crc.width_bits);
  if (rule.mistake == Mistake::lsb) return text.insert(text.find(','), suffix);
  return text.insert(std::min(text.size(), text.find(';')), suffix);
}

}  // namespace

std::string_view text_of(Mistake mistake) {
  constexpr std::array<std::string_view, mistake_count> words{
      "its bits are in reverse order",
      "it leaves out the last two data bits, nE and nW",
      "it includes CDS",
      "it is that of the frame before",
      "it is computed with the lowest data bit first",
      "it is not inverted as BiSS requires, or has another start value",
      "it is the same in all frames"};
  return words[static_cast<std::size_t>(mistake)];
}

bool ChecksumVariant::fits(BitView raw, BitView before) const {
  const std::size_t size = before_data + data_bits + crc.width_bits;
  if (raw.size_bits() < size) return false;
  const CrcBitwise checksum(crc);
  const std::uint64_t data = data_of(*this, raw);
  const std::uint64_t seen = received(*this, raw);
  switch (mistake) {
    case Mistake::reversed:
      return reversed(seen, crc.width_bits) == checksum(data, data_bits);
    case Mistake::no_flags:
      return seen == checksum(data >> flag_bits, data_bits - flag_bits);
    case Mistake::cds:
      // A leading zero changes nothing.
      return seen == (data_bits < max_data_bits
                          ? checksum(data | std::uint64_t{raw[1]} << data_bits, data_bits + 1)
                          : checksum(data, data_bits)) &&
             raw[1];
    case Mistake::previous:
      return before.size_bits() >= size && seen == checksum(data_of(*this, before), data_bits);
    case Mistake::lsb:
      return seen == checksum(reversed(data >> flag_bits, data_bits - flag_bits) << flag_bits |
                                  (data & low_mask(flag_bits)),
                              data_bits);
    case Mistake::other_start:
      return (seen ^ checksum(data, data_bits)) == rest;
    case Mistake::constant:
      return seen == rest;
  }
  return false;
}

std::optional<ChecksumVariant> find_variant(std::span<const WrongFrame> frames,
                                            const std::optional<FrameFormat>& format,
                                            unsigned payload_bits) {
  std::optional<ChecksumVariant> best;
  std::size_t most = 0;
  for (ChecksumVariant rule : layouts(format, payload_bits)) {
    const std::size_t size = before_data + rule.data_bits + rule.crc.width_bits;
    std::vector<WrongFrame> whole;
    for (const WrongFrame& frame : frames) {
      if (frame.raw.view().size_bits() >= size) whole.push_back(frame);
    }
    if (whole.size() < least_frames || rule.data_bits <= flag_bits || !vary(rule, whole)) continue;
    const BitView last = whole.back().raw.view();
    for (std::size_t m = 0; m < mistake_count; ++m) {
      rule.mistake = static_cast<Mistake>(m);
      // These are formats of their own.
      if (!format && rule.mistake >= Mistake::other_start) continue;
      rule.rest = static_cast<std::uint16_t>(received(rule, last));
      if (rule.mistake == Mistake::other_start) {
        const std::uint64_t data = data_of(rule, last);
        const CrcBitwise usual({.polynomial = default_polynomial(rule.crc.width_bits),
                                .width_bits = rule.crc.width_bits});
        // The checksum of BiSS is no mistake.
        if (usual(data, rule.data_bits) == rule.rest) continue;
        rule.rest ^= CrcBitwise(rule.crc)(data, rule.data_bits);
      }
      const std::size_t count = fitting(rule, whole);
      if (count <= most || 100 * count < fitting_percent * whole.size()) continue;
      most = count;
      best = rule;
    }
  }
  if (best) best->format = format_of(*best, format);
  return best;
}

}  // namespace biss::explain
