// biss crc: the frame for a position, or the one in the bytes of an SPI buffer, bit by bit.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <string>
#include <tl/expected.hpp>
#include <utility>
#include <vector>

#include "biss/base/bits.hpp"
#include "biss/frame/codec.hpp"
#include "biss/frame/decode.hpp"
#include "biss/master/spi_read.hpp"
#include "biss/timing/cycle.hpp"
#include "cli/common/format_option.hpp"
#include "cli/common/verb.hpp"
#include "cli/common/verbs.hpp"
#include "dump/text.hpp"
#include "report/summary.hpp"

namespace biss::cli {
namespace {

struct CrcOptions {
  FormatArguments arguments;
  std::vector<std::string> positions;
  std::optional<std::vector<std::uint8_t>> bytes;
  std::optional<Hertz> clock;
  bool error = false;
  bool warning = false;
  std::optional<std::uint64_t> life_counter;
  report::Format to = report::Format::table;
  std::string output;
};

std::string channel_word(const FrameFormat& format, std::size_t k) {
  return format.channel_count == 1 ? "" : fmt::format(" of channel {}", k + 1);
}

// The options apply to every channel with such a bit; at least one must have it.
std::string check_flags(const CrcOptions& options, const FrameFormat& format) {
  const auto any = [&format](auto has) {
    return std::any_of(format.channels().begin(), format.channels().end(), has);
  };
  if (options.error && !any([](const ChannelFormat& c) { return c.error.present; })) {
    return "--error: the format has no error bit (nE or E)";
  }
  if (options.warning && !any([](const ChannelFormat& c) { return c.warning.present; })) {
    return "--warning: the format has no warning bit (nW or W)";
  }
  if (options.life_counter &&
      !any([](const ChannelFormat& c) { return c.life_counter.present(); })) {
    return "--lc: the format has no counter (lcN)";
  }
  return {};
}

std::string set_position(Channel& channel, std::string_view text, unsigned bits,
                         const std::string& where) {
  const std::uint64_t largest = low_mask(bits);
  if (bits == 0 && text != "0") {
    return fmt::format("position {}{}: the channel has no position; give 0", text, where);
  }
  const auto position = parse_count(text, largest);
  if (position.ok()) {
    channel.position = *position;
    return {};
  }
  if (position.error().cause == QuantityCause::too_large) {
    return fmt::format("position {}{}: too large; {} bits hold at most {} (0x{:X})", text, where,
                       bits, largest, largest);
  }
  return fmt::format("position {}{}", quantity_error_text(Quantity::count, text, position.error()),
                     where);
}

tl::expected<Frame, std::string> chosen_frame(const CrcOptions& options,
                                              const FrameFormat& format) {
  const auto wrong = [](std::string text) { return tl::make_unexpected(std::move(text)); };
  if (options.positions.size() != format.channel_count) {
    return wrong(
        format.channel_count == 1
            ? std::string("the format has 1 channel: give one position, or --read")
            : fmt::format("the format has {0} channels: give {0} positions", format.channel_count));
  }
  if (std::string text = check_flags(options, format); !text.empty()) return wrong(text);
  Frame frame;
  for (std::size_t k = 0; k < format.channel_count; ++k) {
    const ChannelFormat& channel = format.channel_list[k];
    Channel& values = frame.channel_list[k];
    std::string text = set_position(values, options.positions[k], channel.position_bits(),
                                    channel_word(format, k));
    if (!text.empty()) return wrong(text);
    if (channel.error.present) values.nE = !options.error;
    if (channel.warning.present) values.nW = !options.warning;
    if (!channel.life_counter.present()) continue;
    const std::uint64_t largest = low_mask(channel.life_counter.bits);
    const std::uint64_t count = options.life_counter.value_or(0);
    if (count > largest) {
      return wrong(fmt::format("--lc {}: too large; {} bits hold at most {}", count,
                               channel.life_counter.bits, largest));
    }
    values.life_counter = static_cast<std::uint32_t>(count);
  }
  return frame;
}

// A frame from START on, as it is on the line.
struct FrameWords {
  struct Word {
    std::uint64_t data = 0;
    std::uint16_t crc = 0;
  };
  bool cds = false;
  std::array<Word, max_channels> channels{};
  std::optional<bool> stop = false;  // empty: not received
};

FrameWords frame_words(const FrameFormat& format, const Frame& frame, const PlainCodec& codec) {
  FrameWords line;
  for (std::size_t k = 0; k < format.channel_count; ++k) {
    FrameWords::Word& word = line.channels[k];
    word.data = pack(format.channel_list[k], frame.channel_list[k]);
    if (format.channel_list[k].crc.present()) word.crc = codec.crc(k, word.data, frame.cds);
  }
  return line;
}

/// \pre the bits reach to the last one of the CRC
FrameWords frame_words(const FrameFormat& format, const BitView& bits, const FrameStart& start) {
  FrameWords line;
  std::size_t at = start.start_bit + 1;
  const auto next = [&](unsigned count) {
    at += count;
    return bits.word(at - count, count);
  };
  line.cds = next(1) != 0;
  for (std::size_t k = 0; k < format.channel_count; ++k) {
    line.channels[k].data = next(format.channel_list[k].data_bits);
    line.channels[k].crc = static_cast<std::uint16_t>(next(format.channel_list[k].crc.width_bits));
  }
  line.stop.reset();
  if (at < bits.size_bits()) line.stop = next(1) != 0;
  return line;
}

// A row of the human-readable table: bits of the frame that belong together.
struct Part {
  std::string name;
  std::size_t channel = 0;  // from 1; 0: belongs to no channel
  std::uint64_t word = 0;   // as on the line
  unsigned bits = 0;
  std::string value;
  std::string meaning;
};

// From the right, so that the groups are the hexadecimal digits.
std::string in_fours(std::uint64_t word, unsigned bits) {
  std::string out;
  for (unsigned i = bits; i-- > 0;) {
    out.push_back(((word >> i) & 1U) != 0 ? '1' : '0');
    if (i % 4 == 0 && i != 0) out.push_back(' ');
  }
  return out;
}

std::string both(std::uint64_t value) {
  return value < 10 ? fmt::format("{}", value) : fmt::format("{} = 0x{:X}", value, value);
}

Part flag_part(std::string name, const FlagField& flag, bool low_active, std::string_view what) {
  const std::uint64_t bit = flag.placed(low_active) >> flag.shift;
  if (flag.active_high) name.erase(0, 1);
  return {std::move(name),
          0,
          bit,
          1,
          fmt::format("{}", bit),
          low_active ? fmt::format("no {}", what) : std::string(what)};
}

std::string crc_text(std::uint16_t crc, unsigned bits) {
  return fmt::format("{} = 0x{:0{}X}", crc, crc, (bits + 3) / 4);
}

std::string crc_meaning(const ChannelFormat& channel) {
  std::string out = fmt::format("0x{:X}", channel.crc.polynomial);
  if (channel.crc.start != 0) out += fmt::format(", start 0x{:X}", channel.crc.start);
  return out + fmt::format(", {}, over {} bits", channel.crc.inverted ? "inverted" : "not inverted",
                           channel.data_bits);
}

// The channel's fields in line order, what lies between them as padding.
std::vector<Part> parts_of(const ChannelFormat& format, std::uint64_t data) {
  const Channel channel = unpack(format, data);
  std::vector<std::pair<unsigned, Part>> fields;
  const auto add = [&](std::string name, const Field& field, std::uint64_t value,
                       std::string meaning) {
    if (!field.present()) return;
    fields.push_back(
        {field.shift,
         {std::move(name), 0, field.of(data), field.bits, both(value), std::move(meaning)}});
  };
  add("position", format.position, channel.position, "most significant bit first");
  const unsigned below = format.singleturn.bits;
  const std::uint64_t singleturn = channel.position & low_mask(below);
  const std::uint64_t turns = below < 64 ? channel.position >> below : 0;
  add("multiturn", format.multiturn, turns, "whole turns");
  add("singleturn", format.singleturn, singleturn,
      format.singleturn_gray ? "within a turn, Gray code" : "within a turn");
  add("counter", format.life_counter, channel.life_counter, "sign of life");
  if (format.error.present) {
    fields.push_back({format.error.shift, flag_part("nE", format.error, channel.nE, "error")});
  }
  if (format.warning.present) {
    fields.push_back(
        {format.warning.shift, flag_part("nW", format.warning, channel.nW, "warning")});
  }
  std::sort(fields.begin(), fields.end(),
            [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<Part> parts;
  unsigned top = format.data_bits;
  const auto pad_down_to = [&](unsigned shift) {
    if (shift >= top) return;
    const std::uint64_t word = data >> shift & low_mask(top - shift);
    parts.push_back({"padding", 0, word, top - shift, both(word), "not judged"});
  };
  for (auto& [shift, part] : fields) {
    pad_down_to(shift + part.bits);
    top = shift;
    parts.push_back(std::move(part));
  }
  pad_down_to(0);
  return parts;
}

std::vector<Part> all_parts(const FrameFormat& format, const FrameWords& line,
                            const PlainCodec& codec) {
  const bool wrong_cds = format.cds0 && line.cds;
  std::vector<Part> parts{{"START", 0, 1, 1, "1", "the first 1 after ACK"},
                          {"CDS", 0, line.cds, 1, line.cds ? "1" : "0",
                           wrong_cds     ? "wrong: always 0"
                           : format.cds0 ? "always 0"
                                         : "control data"}};
  for (std::size_t k = 0; k < format.channel_count; ++k) {
    const ChannelFormat& channel = format.channel_list[k];
    for (Part& part : parts_of(channel, line.channels[k].data)) {
      part.channel = k + 1;
      parts.push_back(std::move(part));
    }
    if (!channel.crc.present()) continue;
    const std::uint16_t crc = line.channels[k].crc;
    const std::uint16_t computed = codec.crc(k, line.channels[k].data, line.cds);
    const unsigned bits = channel.crc.width_bits;
    std::string meaning = crc_meaning(channel);
    if (crc != computed) {
      meaning = fmt::format("wrong: {} computed; {}", crc_text(computed, bits), meaning);
    }
    parts.push_back({"CRC", k + 1, crc, bits, crc_text(crc, bits), std::move(meaning)});
  }
  if (line.stop) {
    parts.push_back(
        {"STOP", 0, *line.stop, 1, *line.stop ? "1" : "0",
         *line.stop ? "wrong: 0 until the timeout has passed" : "until the timeout has passed"});
  }
  return parts;
}

bool write_table(const FrameFormat& format, const FrameWords& line, const PlainCodec& codec,
                 report::TextSink& sink, const report::TableOptions& table_options) {
  using report::Kind;
  const bool several = format.channel_count > 1;
  std::vector<report::Column> columns;
  if (several) columns.push_back({.name = "channel", .kind = Kind::unsigned_integer});
  columns.push_back({.name = "field"});
  columns.push_back({.name = "from", .kind = Kind::unsigned_integer});
  columns.push_back({.name = "bits", .kind = Kind::unsigned_integer});
  columns.push_back({.name = "value"});
  columns.push_back({.name = "line", .heading = "on the line"});
  columns.push_back({.name = "meaning"});
  const auto table = report::make_table_writer(report::Format::table, columns, sink, table_options);
  unsigned from = 0;
  for (const Part& part : all_parts(format, line, codec)) {
    const std::string bits = in_fours(part.word, part.bits);
    std::vector<report::Cell> cells;
    if (several) cells.push_back(part.channel == 0 ? report::Cell() : report::Cell(part.channel));
    cells.insert(cells.end(), {part.name, from, part.bits, part.value, bits, part.meaning});
    if (!table->row(cells)) return false;
    from += part.bits;
  }
  return table->finish();
}

// START to the last CRC bit, as text.
std::string line_bits(const FrameFormat& format, const FrameWords& line) {
  std::string out = line.cds ? "11" : "10";
  const auto add = [&out](std::uint64_t word, unsigned bits) {
    for (unsigned i = bits; i-- > 0;) out.push_back(((word >> i) & 1U) != 0 ? '1' : '0');
  };
  for (std::size_t k = 0; k < format.channel_count; ++k) {
    add(line.channels[k].data, format.channel_list[k].data_bits);
    add(line.channels[k].crc, format.channel_list[k].crc.width_bits);
  }
  return out;
}

// What was found in a buffer.
struct Received {
  std::optional<FrameStart> start;
  std::optional<FrameWords> line;  // nothing where the bits end before the last one of the CRC
  std::optional<FrameFault> fault;
};

// The frame as JSON; without a line its values are null. `received` adds keys.
bool write_object(const FrameFormat& format, const std::optional<FrameWords>& line,
                  const PlainCodec& codec, const Received* received, report::TextSink& sink) {
  using report::Kind;
  const std::string bits = line ? line_bits(format, *line) : std::string();
  std::vector<report::Column> columns;
  std::vector<report::Cell> cells;
  const auto add = [&](std::string_view name, std::size_t k, Kind kind, report::Cell cell) {
    const std::string suffix = k == 0 ? "" : fmt::format("{}", k + 1);
    columns.push_back({.name = fmt::format("{}{}", name, suffix), .kind = kind});
    cells.push_back(cell);
  };
  for (std::size_t k = 0; k < format.channel_count; ++k) {
    const ChannelFormat& channel = format.channel_list[k];
    const FrameWords::Word word = line ? line->channels[k] : FrameWords::Word{};
    const Channel values = unpack(channel, word.data);
    const auto when = [&line](bool present, auto value) {
      return line && present ? report::Cell(value) : report::Cell();
    };
    const bool counts = channel.life_counter.present();
    add("position", k, Kind::unsigned_integer, when(channel.position_bits() != 0, values.position));
    add("nE", k, Kind::flag, when(channel.error.present, values.nE));
    add("nW", k, Kind::flag, when(channel.warning.present, values.nW));
    // The contract fixes the first keys up to `bits`; the counter of the first channel follows it.
    if (k != 0 && counts) add("lc", k, Kind::unsigned_integer, when(true, values.life_counter));
    add("crc", k, Kind::unsigned_integer, when(channel.crc.present(), word.crc));
    if (k == 0) add("bits", k, Kind::text, when(true, std::string_view(bits)));
    if (k == 0 && counts) add("lc", k, Kind::unsigned_integer, when(true, values.life_counter));
    if (received == nullptr) continue;
    const bool checked = line && channel.crc.present();
    add("crc_computed", k, Kind::unsigned_integer,
        checked ? report::Cell(codec.crc(k, word.data, line->cds)) : report::Cell());
  }
  if (received != nullptr) {
    const auto& start = received->start;
    const auto& fault = received->fault;
    add("lead_clocks", 0, Kind::unsigned_integer,
        start ? report::Cell(start->lead_clocks) : report::Cell());
    add("ack_clocks", 0, Kind::unsigned_integer,
        start ? report::Cell(start->ack_clocks) : report::Cell());
    add("status", 0, Kind::text, fault ? name_of(fault->cause) : std::string_view("ok"));
  }
  const auto table = report::make_table_writer(report::Format::jsonl, columns, sink);
  return table->row(cells) && table->finish();
}

// ---- Reading a buffer

// The bytes of a word: F0, F000, 0xF0, 0x0.
bool add_bytes(std::vector<std::uint8_t>& bytes, std::string_view word) {
  if (word.starts_with("0x") || word.starts_with("0X")) {
    word.remove_prefix(2);
    if (word.size() == 1 && dump::hex_digits_at_front(word) == 1) {
      bytes.push_back(static_cast<std::uint8_t>(dump::hex_value(word.front())));
      return true;
    }
  }
  if (word.empty() || word.size() % 2 != 0) return false;
  for (; !word.empty(); word.remove_prefix(2)) {
    const auto byte = dump::hex_byte(word.substr(0, 2));
    if (!byte) return false;
    bytes.push_back(*byte);
  }
  return true;
}

// As debuggers and hex dumps print them: F0 00 00 or {0xf0, 0x0, 0x0}.
std::vector<std::uint8_t> parse_bytes(std::string text) {
  constexpr std::string_view separators = ",{}\n";
  for (char& c : text) {
    if (separators.find(c) != std::string_view::npos) c = ' ';
  }
  std::vector<std::uint8_t> bytes;
  std::string_view rest = text;
  for (auto word = dump::next_word(rest); !word.empty(); word = dump::next_word(rest)) {
    if (!add_bytes(bytes, word)) {
      wrong_value("--read", fmt::format("'{}': expected bytes of two hexadecimal digits", word));
    }
  }
  if (bytes.empty()) wrong_value("--read", "expected bytes of two hexadecimal digits");
  return bytes;
}

Received receive(const CrcOptions& options, const Device& device) {
  const FrameCodec<> codec(device.format);
  const BitView bits(*options.bytes, 0, options.bytes->size() * 8);
  Received received;
  FrameBounds widest;
  const auto take = [&received](const auto& frame) {
    if (!frame.ok()) received.fault = frame.error();
  };
  if (options.clock) {
    // Whatever was received is read: the command shows bits and trusts none.
    const SpiSetup spi{
        .period = period_of(*options.clock), .no_error_flag = true, .unchecked = true};
    DeviceTiming timing = device.timing;
    timing.clock_max = std::max(timing.clock_max, *options.clock);
    const SpiReader reader(codec, spi, timing);
    widest.late_max_clocks = reader.bounds().late_max_clocks;
    take(reader.read(*options.bytes));
  } else {
    take(decode_frame(bits, codec, widest));
  }
  const auto start = find_start(bits, widest);
  if (!start.ok()) return received;
  received.start = *start;
  const std::size_t end = start->start_bit + 2 + device.format.payload_bits();
  if (end <= bits.size_bits()) received.line = frame_words(device.format, bits, *start);
  return received;
}

std::string_view likely_reason(FrameError error) {
  switch (error) {
    case FrameError::no_response:
      return "the encoder did not answer: supply, cable, MA";
    case FrameError::not_ready:
      return "the request came too early, or SLO is stuck low";
    case FrameError::response_range:
    case FrameError::ack_range:
      return "a wrong encoder type or limits, or a disturbed START";
    case FrameError::no_start:
    case FrameError::truncated:
      return "too few clocks for this encoder";
    case FrameError::cds:
    case FrameError::crc:
    case FrameError::stop_bit:
      break;
  }
  return "the frame was disturbed on the line, or the format is wrong";
}

std::string summary_of(const CrcOptions& options, const FrameFormat& format,
                       const Received& received) {
  report::Summary out;
  if (received.fault) {
    const FrameFault fault = *received.fault;
    const bool at_channel = fault.cause == FrameError::crc;
    out.entry("status",
              fmt::format("{}{}", name_of(fault.cause),
                          at_channel ? channel_word(format, fault.channel) : ""),
              likely_reason(fault.cause));
  } else {
    out.entry("status", "ok");
  }
  if (!received.start) return out.text();
  const unsigned ones = received.start->lead_clocks;
  std::string delay;
  if (options.clock && ones >= 2) {
    const Picoseconds period = period_of(*options.clock);
    delay = fmt::format("line delay {} to {} in SPI mode 3", text_of(period * (ones - 2)),
                        text_of(period * (ones - 1)));
  }
  out.entry("leading ones", fmt::format("{}", ones), delay);
  const unsigned zeros = received.start->ack_clocks;
  out.entry("ACK", fmt::format("{} clock{}", zeros, zeros == 1 ? "" : "s"));
  return out.text();
}

ExitStatus show_received(const CrcOptions& options, const Device& device) {
  if (options.clock && !accepts_clock(device.timing, *options.clock)) {
    return fail(ExitStatus::usage,
                fmt::format("--clock: the encoder does not accept {}", text_of(*options.clock)));
  }
  const PlainCodec codec(device.format);
  const Received received = receive(options, device);
  Output output;
  if (!output.open(options.output)) return output.status();
  bool written = true;
  if (options.to != report::Format::table) {
    written = write_object(device.format, received.line, codec, &received, output);
  } else if (received.line) {
    written = write_table(device.format, *received.line, codec, output, output.table_options());
  }
  if (!written || !output.finish()) return output.status();
  if (options.to == report::Format::table) {
    print_summary((received.line ? "\n" : "") + summary_of(options, device.format, received));
  }
  return received.fault ? ExitStatus::data_failed : ExitStatus::done;
}

ExitStatus run_crc(const CrcOptions& options) {
  const auto choice = choose_device(options.arguments);
  if (!choice) return fail(ExitStatus::usage, choice.error());
  if (options.bytes) return show_received(options, *choice);
  if (options.clock) return fail(ExitStatus::usage, "--clock: needs --read");
  const FrameFormat& format = choice->format;
  const auto frame = chosen_frame(options, format);
  if (!frame) return fail(ExitStatus::usage, frame.error());
  const PlainCodec codec(format);
  const FrameWords line = frame_words(format, *frame, codec);
  Output output;
  if (!output.open(options.output)) return output.status();
  const bool written = options.to == report::Format::table
                           ? write_table(format, line, codec, output, output.table_options())
                           : write_object(format, line, codec, nullptr, output);
  if (!written || !output.finish()) return output.status();
  return ExitStatus::done;
}

}  // namespace

void add_crc(Command& command) {
  const auto options = std::make_shared<CrcOptions>();
  Verb verb = command.add_verb(
      {.name = "crc",
       .purpose = "Show the frame for a position, or in a buffer, bit by bit, with its CRC",
       .examples = {"biss crc -f pos26,nE,nW,crc6 0x1234567",
                    "biss crc -f fs-28-24 0x1234567 0x123456 --lc 1 --to jsonl",
                    "biss crc -f resolute-18 --read 'F0 00 00 00 01 24 68 B9 A0' --clock 10MHz"}},
      [options] { return run_crc(*options); });
  add_format_option(verb, options->arguments, true);
  const Option position = verb.add_option(
      "POSITION", options->positions,
      "Position of each channel, decimal or 0x...; multiturn bits above singleturn bits");
  const Option error = verb.add_flag("--error", options->error, "Report an error: nE is 0");
  const Option warning = verb.add_flag("--warning", options->warning, "Report a warning: nW is 0");
  const Option counter = add_count_option(verb, "--lc", into(options->life_counter),
                                          "Value of the sign-of-life counter; 0 by default");
  verb.add_text_option(
          "--read", [options](const std::string& text) { options->bytes = parse_bytes(text); },
          "Show the frame in the bytes that an SPI peripheral received: SLO once per clock, in "
          "hexadecimal digits")
      .type_name("BYTES")
      .excludes(position)
      .excludes(error)
      .excludes(warning)
      .excludes(counter);
  add_rate_option(verb, "--clock", into(options->clock),
                  "Clock of --read, to check leading ones and ACK too");
  add_to_option(verb, options->to, {report::Format::table, report::Format::jsonl});
  add_output_option(verb, options->output);
}

}  // namespace biss::cli
