#include "tests/exhaustive/twin.hpp"

#include <array>
#include <stdexcept>
#include <string_view>

#include "biss/frame/format_text.hpp"

namespace exhaustive {

namespace {

using oracle::Kind;

std::string hexadecimal(const oracle::Bits& bits) {
  std::string digits;
  for (std::uint64_t left = oracle::number_of(bits, 0, bits.size()); left != 0; left /= 16) {
    digits.insert(digits.begin(), "0123456789abcdef"[left % 16]);
  }
  return "0x" + (digits.empty() ? "0" : digits);
}

std::string text_of(const oracle::Item& item) {
  const std::string bits = std::to_string(item.bits);
  switch (item.kind) {
    case Kind::position:
      return "pos" + bits;
    case Kind::multiturn:
      return "mt" + bits;
    case Kind::singleturn:
      return "st" + bits;
    case Kind::gray_singleturn:
      return "st" + bits + ":gray";
    case Kind::padding:
      return "pad" + bits;
    case Kind::nE:
      return "nE";
    case Kind::nW:
      return "nW";
    case Kind::E:
      return "E";
    case Kind::W:
      return "W";
    case Kind::counter:
      return "lc" + bits;
  }
  return {};
}

std::string text_of(const oracle::Description& description) {
  std::string text;
  for (const oracle::ChannelDescription& channel : description.channels) {
    if (!text.empty()) text += '+';
    bool first = true;
    for (const oracle::Item& item : channel.items) {
      if (!first) text += ',';
      first = false;
      text += text_of(item);
    }
    if (!channel.checksum) continue;
    text += ",crc" + std::to_string(channel.checksum->width()) + ":" +
            hexadecimal(channel.checksum->polynomial) + ":" + hexadecimal(channel.checksum->start);
    if (!channel.checksum->inverted) text += ":plain";
  }
  return description.cds_must_be_0 ? text + ";cds0" : text;
}

// All zeros and all ones reveal wrong carries and masks.
std::uint64_t random_number(biss::test::Random& random, std::size_t bits) {
  const std::uint32_t choice = random.below(8);
  if (choice == 0) return 0;
  if (choice == 1) return biss::low_mask(static_cast<unsigned>(bits));
  return random.bits(static_cast<unsigned>(bits));
}

bool carries(const oracle::ChannelDescription& channel, Kind a, Kind b) {
  for (const oracle::Item& item : channel.items) {
    if (item.kind == a || item.kind == b) return true;
  }
  return false;
}

std::size_t width_of(const oracle::ChannelDescription& channel, std::initializer_list<Kind> kinds) {
  std::size_t sum = 0;
  for (const oracle::Item& item : channel.items) {
    for (const Kind kind : kinds) sum += item.kind == kind ? item.bits : 0;
  }
  return sum;
}

}  // namespace

Twin twin_of(const oracle::Description& description) {
  Twin twin{description, text_of(description), {}};
  const auto format = biss::parse_format(twin.text);
  if (!format.ok()) throw std::runtime_error("not taken: " + twin.text);
  twin.format = *format;
  const auto again = biss::parse_format(biss::format_text(*format).view());
  if (!again.ok() || *again != *format) throw std::runtime_error("does not print: " + twin.text);
  return twin;
}

oracle::Checksum checksum_of(unsigned width, bool inverted, std::uint64_t start) {
  constexpr std::array<std::uint64_t, 17> polynomials{0,      0,      0,      0x0B,   0x13,   0x25,
                                                      0x43,   0x89,   0x12F,  0x211,  0x633,  0xB75,
                                                      0x180F, 0x201B, 0x4443, 0x8003, 0x190D9};
  return {oracle::bits_of(polynomials[width], width + 1), oracle::bits_of(start, width), inverted};
}

Sent random_sent(const oracle::Description& description, biss::test::Random& random) {
  Sent sent;
  for (const oracle::ChannelDescription& channel : description.channels) {
    oracle::Values values;
    values.position =
        random_number(random, width_of(channel, {Kind::position, Kind::multiturn, Kind::singleturn,
                                                 Kind::gray_singleturn}));
    values.counter = random_number(random, width_of(channel, {Kind::counter}));
    values.nE = !carries(channel, Kind::nE, Kind::E) || random.flip();
    values.nW = !carries(channel, Kind::nW, Kind::W) || random.flip();
    sent.values.push_back(values);
  }
  sent.lead = 1 + random.below(6);
  sent.ack = 1 + random.below(24);
  sent.cds = !description.cds_must_be_0 && random.flip();
  return sent;
}

biss::Frame frame_of(const Sent& sent) {
  biss::Frame frame;
  for (const oracle::Values& values : sent.values) {
    frame.channel_list[frame.channel_count++] = {
        values.position, static_cast<std::uint32_t>(values.counter), values.nE, values.nW};
  }
  frame.cds = sent.cds;
  frame.lead_clocks = static_cast<std::uint16_t>(sent.lead);
  frame.ack_clocks = static_cast<std::uint16_t>(sent.ack);
  return frame;
}

oracle::Bits bits_of(const biss::BitView& view) {
  oracle::Bits bits(view.size_bits());
  for (std::size_t i = 0; i < bits.size(); ++i) bits[i] = view[i];
  return bits;
}

Line line_of(const oracle::Bits& bits) {
  Line line;
  for (const bool bit : bits) line.append(bit);
  return line;
}

oracle::Limits limits_of(const biss::FrameBounds& bounds) {
  return {bounds.lead_min_clocks, bounds.lead_max_clocks, bounds.ack_min_clocks,
          bounds.ack_max_clocks};
}

std::string difference(const biss::Result<biss::Frame, biss::FrameFault>& core,
                       const oracle::Reading& judge) {
  const std::string cause{core.ok() ? std::string_view() : biss::name_of(core.error().cause)};
  if (cause != judge.cause) return "core says '" + cause + "', oracle '" + judge.cause + "'";
  if (!core.ok()) {
    return core.error().channel == judge.channel ? "" : "the cause is in different channels";
  }
  if (core->channel_count != judge.values.size()) return "different numbers of channels";
  for (std::size_t k = 0; k < judge.values.size(); ++k) {
    const biss::Channel& channel = core->channel_list[k];
    const oracle::Values values{channel.position, channel.life_counter, channel.nE, channel.nW};
    if (values != judge.values[k]) return "different values in channel " + std::to_string(k);
  }
  const bool same = core->lead_clocks == judge.lead && core->ack_clocks == judge.ack &&
                    core->cds == judge.cds && core->stop_seen == judge.stop_seen;
  return same ? "" : "different lead, ACK, CDS or STOP";
}

std::string difference(const oracle::Reading& judge, const Sent& sent) {
  if (!judge.cause.empty()) return "oracle says " + judge.cause + " of a good frame";
  const bool same = judge.values == sent.values && judge.lead == sent.lead &&
                    judge.ack == sent.ack && judge.cds == sent.cds && judge.stop_seen;
  return same ? "" : "oracle reads other values than were sent";
}

oracle::Bits damaged(oracle::Bits line, biss::test::Random& random) {
  const std::size_t at = random.below(static_cast<std::uint32_t>(line.size()));
  const auto place = line.begin() + static_cast<std::ptrdiff_t>(at);
  switch (random.below(4)) {
    case 0:
      line.resize(at);
      break;
    case 1:
      line.erase(place);
      break;
    case 2:
      line.insert(place, *place);
      break;
    default:
      line[at] = !line[at];
  }
  return line;
}

oracle::ChannelDescription random_channel(biss::test::Random& random) {
  oracle::ChannelDescription channel;
  std::size_t left = 1 + random.below(64);
  std::vector<oracle::Item> wanted;
  const auto want = [&](Kind kind, std::size_t most) {
    if (left == 0) return;
    const auto limit = static_cast<std::uint32_t>(std::min(left, most));
    wanted.push_back({kind, 1 + random.below(limit)});
    left -= wanted.back().bits;
  };
  if (random.flip()) want(random.flip() ? Kind::nE : Kind::E, 1);
  if (random.flip()) want(random.flip() ? Kind::nW : Kind::W, 1);
  if (random.flip()) want(Kind::counter, 32);
  if (random.flip()) {
    want(Kind::position, 64);
  } else {
    if (random.flip()) want(Kind::multiturn, 32);
    if (random.flip()) want(random.flip() ? Kind::singleturn : Kind::gray_singleturn, 64);
  }
  if (wanted.empty() || random.flip()) want(Kind::padding, 64);
  if (random.flip()) want(Kind::padding, 8);
  while (!wanted.empty()) {
    const auto pick = wanted.begin() + random.below(static_cast<std::uint32_t>(wanted.size()));
    channel.items.push_back(*pick);
    wanted.erase(pick);
  }
  if (random.below(4) != 0) {
    const unsigned width = 3 + random.below(14);
    channel.checksum = checksum_of(width, random.flip(), random.flip() ? 0 : random.bits(width));
  }
  return channel;
}

}  // namespace exhaustive
