#include "explain/checksum_variant.hpp"

#include <algorithm>
#include <array>

#include "biss/frame/codec.hpp"
#include "biss/frame/format_text.hpp"

namespace biss::explain {

namespace {

constexpr std::size_t mistake_count = 8;
constexpr std::uint8_t flag_bits = 2;
// START and CDS.
constexpr std::size_t before_data = 2;
// The part of the frames that a rule must fit; some may be damaged.
constexpr std::size_t fitting_percent = 85;
constexpr std::size_t least_frames = 8;

std::uint64_t data_of(const ChannelFormat& channel, BitView raw) {
  return raw.word(before_data, channel.data_bits);
}

std::uint64_t received(const ChannelFormat& channel, BitView raw) {
  return raw.word(before_data + channel.data_bits, channel.crc.width_bits);
}

bool is_whole(const ChannelFormat& channel, BitView raw) {
  return raw.size_bits() >= before_data + channel.total_bits();
}

// The channels that the frames may have, with the checksum that they should have.
std::vector<ChannelFormat> layouts(const std::optional<FrameFormat>& format, unsigned payload) {
  std::vector<ChannelFormat> all;
  if (format) {
    const ChannelFormat& channel = format->channel_list[0];
    if (format->channel_count == 1 && channel.crc.present()) all.push_back(channel);
    return all;
  }
  constexpr std::array<std::uint8_t, 4> widths{6, 16, 5, 8};
  for (const std::uint8_t width : widths) {
    if (payload < width + 4U || payload > width + max_data_bits) continue;
    const auto data_bits = static_cast<std::uint8_t>(payload - width);
    ChannelFormat& channel = all.emplace_back();
    channel.data_bits = data_bits;
    channel.position = {flag_bits, static_cast<std::uint8_t>(data_bits - flag_bits)};
    channel.error = {.shift = 1, .present = true};
    channel.warning.present = true;
    channel.crc = {.polynomial = default_polynomial(width), .width_bits = width};
  }
  return all;
}

// The checksum with this error, if formats have a word for it.
CrcSpec with_error(CrcSpec crc, Mistake mistake) {
  crc.reversed = mistake == Mistake::reversed;
  crc.without_flags = mistake == Mistake::no_flags;
  crc.with_cds = mistake == Mistake::cds;
  crc.of_previous = mistake == Mistake::previous;
  return crc;
}

// The checksum of BiSS is not a mistake.
bool is_usual(ChannelFormat channel, BitView raw) {
  channel.crc = {.polynomial = default_polynomial(channel.crc.width_bits),
                 .width_bits = channel.crc.width_bits};
  return frame_detail::deviating_crc(channel, data_of(channel, raw), false) ==
         received(channel, raw);
}

// Enough of them differ.
bool vary(const ChannelFormat& channel, std::span<const WrongFrame> frames) {
  std::vector<std::uint64_t> data;
  for (const WrongFrame& frame : frames) data.push_back(data_of(channel, frame.raw.view()));
  std::sort(data.begin(), data.end());
  return std::unique(data.begin(), data.end()) - data.begin() >= std::ptrdiff_t{least_frames / 2};
}

std::size_t fitting(const ChecksumVariant& rule, std::span<const WrongFrame> frames) {
  return static_cast<std::size_t>(std::count_if(
      frames.begin(), frames.end(),
      [&](const WrongFrame& frame) { return rule.fits(frame.raw.view(), frame.before.view()); }));
}

}  // namespace

std::string_view text_of(Mistake mistake) {
  constexpr std::array<std::string_view, mistake_count> words{
      "its bits are in reverse order",
      "it leaves out the last two data bits, nE and nW",
      "it includes CDS",
      "it belongs to the frame before",
      "it is computed with the lowest position bit first",
      "it is computed with the last data bit first",
      "it is not inverted as BiSS requires, or has another start value",
      "it is the same in all frames"};
  return words[static_cast<std::size_t>(mistake)];
}

std::uint64_t ChecksumVariant::rest_of(BitView raw, BitView before) const {
  std::uint64_t data = data_of(channel, channel.crc.of_previous ? before : raw);
  if (mistake == Mistake::constant) return received(channel, raw);
  if (mistake == Mistake::lsb || mistake == Mistake::all_lsb) {
    const unsigned kept = mistake == Mistake::lsb ? flag_bits : 0;
    data = frame_detail::bits_reversed(data >> kept, channel.data_bits - kept) << kept |
           (data & low_mask(kept));
  }
  return received(channel, raw) ^ frame_detail::deviating_crc(channel, data, raw[1]);
}

bool ChecksumVariant::fits(BitView raw, BitView before) const {
  if (!is_whole(channel, raw) || (channel.crc.of_previous && !is_whole(channel, before))) {
    return false;
  }
  // A leading zero changes nothing.
  return (mistake != Mistake::cds || raw[1]) && rest_of(raw, before) == rest;
}

std::optional<ChecksumVariant> find_variant(std::span<const WrongFrame> frames,
                                            const std::optional<FrameFormat>& format,
                                            unsigned payload_bits) {
  std::optional<ChecksumVariant> best;
  std::size_t most = 0;
  for (const ChannelFormat& channel : layouts(format, payload_bits)) {
    std::vector<WrongFrame> whole;
    for (const WrongFrame& frame : frames) {
      if (is_whole(channel, frame.raw.view())) whole.push_back(frame);
    }
    if (whole.size() < least_frames || channel.data_bits <= flag_bits || !vary(channel, whole)) {
      continue;
    }
    const BitView last = whole.back().raw.view();
    // Those without a checksum of their own are formats.
    const auto mistakes = static_cast<std::size_t>(Mistake::other_start);
    for (std::size_t m = 0; m < (format ? mistake_count : mistakes); ++m) {
      ChecksumVariant rule{.mistake = static_cast<Mistake>(m), .channel = channel};
      rule.channel.crc = with_error(channel.crc, rule.mistake);
      if (m >= mistakes) rule.rest = rule.rest_of(last, last);
      if (rule.mistake == Mistake::other_start && is_usual(channel, last)) continue;
      const std::size_t count = fitting(rule, whole);
      if (count <= most || 100 * count < fitting_percent * whole.size()) continue;
      most = count;
      best = rule;
    }
  }
  if (best && best->channel.crc.deviates()) {
    FrameFormat reads = format.value_or(FrameFormat{.channel_list = {}, .channel_count = 1});
    reads.channel_list[0] = best->channel;
    best->format = std::string(format_text(reads).view());
  }
  return best;
}

}  // namespace biss::explain
