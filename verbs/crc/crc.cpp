#include "verbs/crc/crc.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <memory>
#include <tl/expected.hpp>
#include <utility>
#include <vector>

#include "biss/frame/line_order.hpp"

namespace biss::verbs {
namespace {

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
  const CrcSpec& crc = channel.crc;
  const int flags = crc.without_flags ? std::popcount(channel.flags_mask()) : 0;
  return out + fmt::format(", {}{}, over {} bits{}{}", crc.inverted ? "inverted" : "not inverted",
                           crc.reversed ? ", lowest bit first" : "",
                           channel.data_bits - flags + (crc.with_cds ? 1 : 0),
                           crc.with_cds ? " with CDS" : "",
                           crc.without_flags ? " without nE and nW" : "");
}

std::vector<Part> parts_of(const ChannelFormat& format, std::uint64_t data) {
  const Channel channel = unpack(format, data);
  std::vector<Part> parts;
  for_each_field(format, [&](const LineField& field) {
    if (field.kind == FieldKind::error) {
      parts.push_back(flag_part("nE", format.error, channel.nE, "error"));
      return;
    }
    if (field.kind == FieldKind::warning) {
      parts.push_back(flag_part("nW", format.warning, channel.nW, "warning"));
      return;
    }
    // In the order of FieldKind.
    constexpr std::array<std::pair<const char*, const char*>, 7> texts{
        {{"position", "the whole position"},
         {"multiturn", "whole turns"},
         {"singleturn", "within a turn"},
         {"counter", "sign of life"},
         {"", ""},
         {"", ""},
         {"padding", "not judged"}}};
    const auto& [name, meaning] = texts[static_cast<std::size_t>(field.kind)];
    const bool plain = field.kind == FieldKind::position && !format.coded();
    parts.push_back({name, 0, field.place.of(data), field.place.bits,
                     both(field.value(format, channel, data)),
                     plain ? "most significant bit first"
                           : fmt::format("{}{}{}", meaning, field.gray ? ", Gray code" : "",
                                         field.lsb ? ", least significant bit first" : "")});
  });
  return parts;
}

std::vector<Part> all_parts(const FrameFormat& format, const FrameWords& line,
                            const PlainCodec& codec) {
  std::vector<Part> parts;
  if (line.cds) {
    const bool wrong_cds = format.cds0 && *line.cds;
    parts = {{"START", 0, 1, 1, "1", "the first 1 after ACK"},
             {"CDS", 0, *line.cds, 1, *line.cds ? "1" : "0",
              wrong_cds     ? "wrong: always 0"
              : format.cds0 ? "always 0"
                            : "control data"}};
  }
  for (std::size_t k = 0; k < format.channel_count; ++k) {
    const ChannelFormat& channel = format.channel_list[k];
    for (Part& part : parts_of(channel, line.channels[k].data)) {
      part.channel = k + 1;
      parts.push_back(std::move(part));
    }
    if (!channel.crc.present()) continue;
    const std::uint16_t crc = line.channels[k].crc;
    const std::uint16_t computed = codec.crc(k, line.channels[k].data, line.cds.value_or(false));
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

// START to the last CRC bit, as text.
std::string line_bits(const FrameFormat& format, const FrameWords& line) {
  std::string out = !line.cds ? "" : *line.cds ? "11" : "10";
  const auto add = [&out](std::uint64_t word, unsigned bits) {
    for (unsigned i = bits; i-- > 0;) out.push_back(((word >> i) & 1U) != 0 ? '1' : '0');
  };
  for (std::size_t k = 0; k < format.channel_count; ++k) {
    add(line.channels[k].data, format.channel_list[k].data_bits);
    add(line.channels[k].crc, format.channel_list[k].crc.width_bits);
  }
  return out;
}

}  // namespace

std::string channel_word(const FrameFormat& format, std::size_t k) {
  return format.channel_count == 1 ? "" : fmt::format(" of channel {}", k + 1);
}

FrameWords frame_words(const FrameFormat& format, const Frame& frame, const PlainCodec& codec) {
  FrameWords line;
  for (std::size_t k = 0; k < format.channel_count; ++k) {
    FrameWords::ChannelWord& word = line.channels[k];
    word.data = pack(format.channel_list[k], frame.channel_list[k]);
    if (format.channel_list[k].crc.present()) word.crc = codec.crc(k, word.data, frame.cds);
  }
  return line;
}

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
    const FrameWords::ChannelWord word = line ? line->channels[k] : FrameWords::ChannelWord{};
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
        checked ? report::Cell(codec.crc(k, word.data, line->cds.value_or(false)))
                : report::Cell());
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

namespace {

struct CrcOptions {
  FormatArguments arguments;
  std::vector<std::string> positions;
  BufferOptions buffer;
  bool error = false;
  bool warning = false;
  std::optional<std::uint64_t> life_counter;
};

// The options apply to every channel with this bit. Returns one line if no channel has it, else
// nothing.
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

ExitStatus run_crc(const CrcOptions& options, Host& host) {
  const auto choice = choose_device(options.arguments);
  if (!choice) return host.fail(ExitStatus::usage, choice.error());
  if (choice->format.needs_previous()) {
    return host.fail(ExitStatus::usage,
                     "-f: with :previous the CRC of a frame is in the next one; decode "
                     "a capture, or leave :previous out");
  }
  const BufferOptions& buffer = options.buffer;
  if (!buffer.text.empty()) return show_buffer(buffer, *choice, host);
  if (buffer.clock) return host.fail(ExitStatus::usage, "--clock: needs --read");
  const FrameFormat& format = choice->format;
  const auto frame = chosen_frame(options, format);
  if (!frame) return host.fail(ExitStatus::usage, frame.error());
  const PlainCodec codec(format);
  const FrameWords line = frame_words(format, *frame, codec);
  Output output(host);
  if (!output.open(buffer.output)) return output.status();
  const bool written = buffer.to == report::Format::table
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
                    "biss crc -f resolute-18 --read 'F0 00 00 00 01 24 68 B9 A0' --clock 10MHz",
                    "biss crc -f resolute-18 --read 0x00000000012345CD --payload"}},
      [options](Host& host) { return run_crc(*options, host); });
  add_format_option(verb, options->arguments, true);
  const Option position = verb.add_option(
      "POSITION", options->positions,
      "Position of each channel, decimal or 0x...; multiturn bits above singleturn bits");
  const Option error = verb.add_flag("--error", options->error, "Report an error: nE is 0");
  const Option warning = verb.add_flag("--warning", options->warning, "Report a warning: nW is 0");
  const Option counter = add_count_option(verb, "--lc", into(options->life_counter),
                                          "Value of the sign-of-life counter; 0 by default");
  const Option read =
      verb.add_option("--read", options->buffer.text,
                      "Show the frame in the bits that an SPI peripheral received: SLO once per "
                      "clock, in digits as in debuggers, dumps and source code")
          .type_name("BYTES")
          .excludes(position)
          .excludes(error)
          .excludes(warning)
          .excludes(counter);
  add_rate_option(verb, "--clock", into(options->buffer.clock),
                  "Clock of --read, to check leading ones and ACK too");
  add_to_option(verb, options->buffer.to, {report::Format::table, report::Format::jsonl});
  add_output_option(verb, options->buffer.output);
  add_word_options(verb, options->buffer.reading, read);
}

}  // namespace biss::verbs
