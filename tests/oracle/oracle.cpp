#include "tests/oracle/oracle.hpp"

namespace oracle {

namespace {

Reading no_frame(const std::string& cause, std::size_t channel = 0) {
  Reading reading;
  reading.cause = cause;
  reading.channel = channel;
  return reading;
}

void append(Bits& line, const Bits& more) { line.insert(line.end(), more.begin(), more.end()); }

// Reflected code: neighbours differ in one bit, and a bit is 1 where the number's bit differs from
// the one above it.
Bits gray_of(const Bits& number) {
  Bits code;
  bool above = false;
  for (const bool bit : number) {
    code.push_back(bit != above);
    above = bit;
  }
  return code;
}

Bits number_of_gray(const Bits& code) {
  Bits number;
  bool above = false;
  for (const bool bit : code) {
    above = above != bit;
    number.push_back(above);
  }
  return number;
}

std::size_t bits_of_kind(const ChannelDescription& channel, Kind kind) {
  std::size_t sum = 0;
  for (const Item& item : channel.items) sum += item.kind == kind ? item.bits : 0;
  return sum;
}

// The position's bits, most significant first: `pos`, or multiturn above singleturn.
Bits position_bits(const ChannelDescription& channel, const Values& values) {
  const std::size_t singleturn =
      bits_of_kind(channel, Kind::singleturn) + bits_of_kind(channel, Kind::gray_singleturn);
  return bits_of(values.position, bits_of_kind(channel, Kind::position) +
                                      bits_of_kind(channel, Kind::multiturn) + singleturn);
}

Bits item_bits(const ChannelDescription& channel, const Item& item, const Values& values) {
  const Bits position = position_bits(channel, values);
  const auto length = static_cast<std::ptrdiff_t>(item.bits);
  switch (item.kind) {
    case Kind::position:
      return position;
    case Kind::multiturn:
      return {position.begin(), position.begin() + length};
    case Kind::singleturn:
      return {position.end() - length, position.end()};
    case Kind::gray_singleturn:
      return gray_of({position.end() - length, position.end()});
    case Kind::padding:
      return Bits(item.bits, false);
    case Kind::nE:
      return {values.nE};
    case Kind::nW:
      return {values.nW};
    case Kind::E:
      return {!values.nE};
    case Kind::W:
      return {!values.nW};
    case Kind::counter:
      return bits_of(values.counter, item.bits);
  }
  return {};
}

Values read_channel(const ChannelDescription& channel, const Bits& data) {
  Values values;
  Bits high;
  Bits low;
  std::size_t at = 0;
  for (const Item& item : channel.items) {
    Bits bits;
    for (std::size_t i = 0; i < item.bits; ++i) bits.push_back(data[at + i]);
    at += item.bits;
    switch (item.kind) {
      case Kind::position:
      case Kind::multiturn:
        high = bits;
        break;
      case Kind::singleturn:
        low = bits;
        break;
      case Kind::gray_singleturn:
        low = number_of_gray(bits);
        break;
      case Kind::padding:
        break;
      case Kind::nE:
        values.nE = bits.front();
        break;
      case Kind::nW:
        values.nW = bits.front();
        break;
      case Kind::E:
        values.nE = !bits.front();
        break;
      case Kind::W:
        values.nW = !bits.front();
        break;
      case Kind::counter:
        values.counter = number_of(bits, 0, bits.size());
        break;
    }
  }
  append(high, low);
  values.position = number_of(high, 0, high.size());
  return values;
}

// Takes `count` bits off the line.
Bits take(const Bits& line, std::size_t& at, std::size_t count) {
  Bits bits;
  while (bits.size() < count) bits.push_back(line[at++]);
  return bits;
}

// START found: the rest of the frame.
Reading read_rest(const Description& description, const Bits& line, std::size_t at,
                  Reading reading) {
  std::size_t needed = 1;
  for (const ChannelDescription& channel : description.channels) {
    needed += channel.data_bits() + (channel.checksum ? channel.checksum->width() : 0);
  }
  if (line.size() - at < needed) return no_frame("truncated");
  reading.cds = line[at++];
  if (description.cds_must_be_0 && reading.cds) return no_frame("cds");
  for (const ChannelDescription& channel : description.channels) {
    const Bits data = take(line, at, channel.data_bits());
    if (channel.checksum) {
      const Bits received = take(line, at, channel.checksum->width());
      if (received != checksum_of(*channel.checksum, data)) {
        return no_frame("crc", reading.values.size());
      }
    }
    reading.values.push_back(read_channel(channel, data));
  }
  if (at == line.size()) return reading;
  if (line[at]) return no_frame("stop_bit");
  reading.stop_seen = true;
  return reading;
}

}  // namespace

std::size_t ChannelDescription::data_bits() const {
  std::size_t sum = 0;
  for (const Item& item : items) sum += item.bits;
  return sum;
}

Bits bits_of(std::uint64_t number, std::size_t count) {
  Bits reversed;
  for (std::size_t i = 0; i < count; ++i) {
    reversed.push_back(number % 2 == 1);
    number /= 2;
  }
  return {reversed.rbegin(), reversed.rend()};
}

std::uint64_t number_of(const Bits& bits, std::size_t first, std::size_t count) {
  std::uint64_t number = 0;
  for (std::size_t i = first; i < first + count; ++i) number = number * 2 + (bits[i] ? 1 : 0);
  return number;
}

Bits checksum_of(const Checksum& checksum, const Bits& data) {
  const std::size_t width = checksum.width();
  Bits dividend = data;
  dividend.resize(data.size() + width, false);
  for (std::size_t i = 0; i < width; ++i) dividend[i] = dividend[i] != checksum.start[i];
  for (std::size_t i = 0; i < data.size(); ++i) {
    if (!dividend[i]) continue;
    for (std::size_t k = 0; k <= width; ++k) {
      dividend[i + k] = dividend[i + k] != checksum.polynomial[k];
    }
  }
  Bits remainder(dividend.end() - static_cast<std::ptrdiff_t>(width), dividend.end());
  if (checksum.inverted) remainder.flip();
  return remainder;
}

Bits encode(const Description& description, const std::vector<Values>& values, std::size_t lead,
            std::size_t ack, bool cds) {
  Bits line(lead, true);
  append(line, Bits(ack, false));
  line.push_back(true);
  line.push_back(cds);
  for (std::size_t k = 0; k < description.channels.size(); ++k) {
    const ChannelDescription& channel = description.channels[k];
    Bits data;
    for (const Item& item : channel.items) append(data, item_bits(channel, item, values[k]));
    append(line, data);
    if (channel.checksum) append(line, checksum_of(*channel.checksum, data));
  }
  line.push_back(false);
  return line;
}

Reading decode(const Description& description, const Limits& limits, const Bits& line) {
  Reading reading;
  std::size_t at = 0;
  while (at < line.size() && line[at]) ++at;
  reading.lead = at;
  if (at == line.size()) return no_frame("no_response");
  if (reading.lead == 0) return no_frame("not_ready");
  if (reading.lead < limits.lead_min || reading.lead > limits.lead_max) {
    return no_frame("response_range");
  }
  while (at < line.size() && !line[at]) ++at;
  if (at == line.size()) return no_frame("no_start");
  reading.ack = at - reading.lead;
  if (reading.ack < limits.ack_min || reading.ack > limits.ack_max) return no_frame("ack_range");
  ++at;
  return read_rest(description, line, at, reading);
}

}  // namespace oracle
