// `biss crc`: the frame for a position, or the frame in a buffer, bit by bit.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <bit>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "biss/frame/codec.hpp"
#include "biss/frame/decode.hpp"
#include "biss/frame/encode.hpp"
#include "biss/frame/line_order.hpp"
#include "biss/master/spi_read.hpp"
#include "biss/timing/cycle.hpp"
#include "device/words.hpp"
#include "report/summary.hpp"
#include "verbs/common/fields.hpp"
#include "verbs/common/format_option.hpp"
#include "verbs/common/verb.hpp"
#include "verbs/common/word.hpp"

namespace biss::verbs {
namespace {

struct CrcOptions {
  FormatArguments arguments;
  std::vector<std::string> positions;
  bool error = false;
  bool warning = false;
  std::optional<std::uint64_t> life_counter;
  /// The text of --read.
  std::string buffer;
  WordReading reading;
  std::optional<Hertz> clock;
  report::Format to = report::Format::table;
  std::string output;
};

// A frame as on the line, from START to STOP, or to the last bit of the CRC if STOP was not received.
struct FrameLine {
  BitView bits;
  /// START, CDS and STOP were received; else they have their correct levels.
  bool has_frame = true;

  bool cds() const { return bits[1]; }
  bool has_stop(const FrameFormat& format) const {
    return has_frame && bits.size_bits() > 2 + format.payload_bits();
  }
  // The data and the CRC of a channel.
  std::pair<std::uint64_t, std::uint16_t> words(const FrameFormat& format, std::size_t k) const {
    std::size_t at = 2;
    for (std::size_t i = 0; i < k; ++i) at += format.channel_list[i].total_bits();
    const ChannelFormat& channel = format.channel_list[k];
    return {bits.word(at, channel.data_bits),
            static_cast<std::uint16_t>(bits.word(at + channel.data_bits, channel.crc.width_bits))};
  }
};

// The frame found in a buffer.
struct Received {
  std::optional<FrameStart> start;
  std::optional<FrameLine> line;  // empty if the bits end before the last bit of the CRC
  std::optional<FrameFault> fault;
};

std::string both(std::uint64_t value) {
  return value < 10 ? fmt::format("{}", value) : fmt::format("{} = 0x{:X}", value, value);
}

std::string crc_text(std::uint16_t crc, unsigned bits) {
  return fmt::format("{} = 0x{:0{}X}", crc, crc, (bits + 3) / 4);
}

std::string crc_meaning(const ChannelFormat& channel) {
  const CrcSpec& crc = channel.crc;
  const int flags = crc.without_flags ? std::popcount(channel.flags_mask()) : 0;
  return fmt::format(
      "0x{:X}{}, {}{}, over {} bits{}{}", crc.polynomial,
      crc.start != 0 ? fmt::format(", start 0x{:X}", crc.start) : "",
      crc.inverted ? "inverted" : "not inverted", crc.reversed ? ", lowest bit first" : "",
      channel.data_bits - flags + (crc.with_cds ? 1 : 0), crc.with_cds ? " with CDS" : "",
      crc.without_flags ? " without nE and nW" : "");
}

// One field of a channel's data: its name and its meaning.
std::pair<std::string_view, std::string> texts_of(const ChannelFormat& format,
                                                  const LineField& field, const Channel& channel) {
  // In the order of FieldKind.
  constexpr std::array<std::pair<std::string_view, std::string_view>, 7> texts{
      {{"position", "the whole position"},
       {"multiturn", "whole turns"},
       {"singleturn", "within a turn"},
       {"counter", "sign of life"},
       {"", "error"},
       {"", "warning"},
       {"padding", "not judged"}}};
  const auto& [name, meaning] = texts[static_cast<std::size_t>(field.kind)];
  if (field.is_flag()) {
    const bool good = field.kind == FieldKind::error ? channel.nE : channel.nW;
    return {field.name, fmt::format("{}{}", good ? "no " : "", meaning)};
  }
  if (field.kind == FieldKind::position && !format.coded()) {
    return {name, "most significant bit first"};
  }
  return {name, fmt::format("{}{}{}", meaning, field.gray ? ", Gray code" : "",
                            field.lsb ? ", least significant bit first" : "")};
}

// From the right, so that the groups are the hexadecimal digits.
std::string in_fours(std::uint64_t word, unsigned bits) {
  std::string out = bits == 0 ? "" : fmt::format("{:0{}b}", word, bits);
  for (unsigned i = 4; i < bits; i += 4) out.insert(bits - i, 1, ' ');
  return out;
}

// START to the last CRC bit, as text.
std::string line_bits(const FrameFormat& format, const FrameLine& line) {
  std::string out;
  for (std::size_t i = line.has_frame ? 0 : 2; i < 2 + format.payload_bits(); ++i) {
    out += line.bits[i] ? '1' : '0';
  }
  return out;
}

// ` of channel 2`; empty if the format has one channel.
std::string channel_word(const FrameFormat& format, std::size_t k) {
  return format.channel_count == 1 ? "" : fmt::format(" of channel {}", k + 1);
}

// The frame bit by bit.
bool write_parts(const FrameFormat& format, const FrameLine& line, const PlainCodec& codec,
                 Output& output) {
  std::vector<FieldRow> rows;
  unsigned from = 0;
  // Bits of the frame that belong together.
  const auto add = [&](std::optional<std::size_t> channel, std::string_view name,
                       std::uint64_t word, unsigned bits, std::string_view value,
                       std::string_view meaning) {
    FieldRow& row = rows.emplace_back();
    if (format.channel_count > 1) row.emplace_back("channel", channel);
    row.insert(row.end(), {{"field", name},
                           {"from", from},
                           {"bits", bits},
                           {"value", value},
                           {"line", in_fours(word, bits), {.heading = "on the line"}},
                           {"meaning", meaning}});
    from += bits;
  };
  const auto add_bit = [&](std::string_view name, bool level, std::string_view meaning) {
    add({}, name, level, 1, level ? "1" : "0", meaning);
  };
  if (line.has_frame) {
    add_bit("START", true, "the first 1 after ACK");
    add_bit("CDS", line.cds(),
            !format.cds0 ? "control data"
            : line.cds() ? "wrong: always 0"
                         : "always 0");
  }
  for (std::size_t k = 0; k < format.channel_count; ++k) {
    const ChannelFormat& channel = format.channel_list[k];
    const auto [data, crc] = line.words(format, k);
    const Channel values = unpack(channel, data);
    for_each_field(channel, [&, data = data](const LineField& field) {
      const auto [name, meaning] = texts_of(channel, field, values);
      add(k + 1, name, field.place.of(data), field.place.bits,
          both(field.value(channel, values, data)), meaning);
    });
    if (!channel.crc.present()) continue;
    const std::uint16_t computed = codec.crc(k, data, line.cds());
    const unsigned bits = channel.crc.width_bits;
    const std::string wrong =
        crc == computed ? "" : fmt::format("wrong: {} computed; ", crc_text(computed, bits));
    add(k + 1, "CRC", crc, bits, crc_text(crc, bits), wrong + crc_meaning(channel));
  }
  if (line.has_stop(format)) {
    const bool stop = line.bits[line.bits.size_bits() - 1];
    add_bit("STOP", stop,
            stop ? "wrong: 0 until the timeout has passed" : "until the timeout has passed");
  }
  return write_rows(rows, report::Format::table, output);
}

// The frame as JSON; without a line its values are null. `received` adds keys.
bool write_object(const FrameFormat& format, const std::optional<FrameLine>& line,
                  const PlainCodec& codec, const Received* received, Output& output) {
  FieldRow row;
  for (std::size_t k = 0; k < format.channel_count; ++k) {
    const ChannelFormat& channel = format.channel_list[k];
    const auto [data, crc] =
        line ? line->words(format, k) : std::pair<std::uint64_t, std::uint16_t>();
    const Channel values = unpack(channel, data);
    const auto add = [&](std::string_view name, bool present, auto value) {
      row.emplace_back(fmt::format("{}{}", name, k == 0 ? "" : fmt::format("{}", k + 1)),
                       line && present ? std::optional(value) : std::nullopt);
    };
    const bool counts = channel.life_counter.present();
    add("position", channel.position_bits() != 0, values.position);
    add("nE", channel.error.present, values.nE);
    add("nW", channel.warning.present, values.nW);
    // The contract fixes the first keys up to `bits`; the counter of the first channel follows it.
    if (k != 0 && counts) add("lc", true, values.life_counter);
    add("crc", channel.crc.present(), crc);
    if (k == 0) add("bits", true, line ? line_bits(format, *line) : std::string());
    if (k == 0 && counts) add("lc", true, values.life_counter);
    if (received == nullptr) continue;
    const bool computes = line && channel.crc.present();
    add("crc_computed", computes, computes ? codec.crc(k, data, line->cds()) : std::uint16_t{0});
  }
  if (received != nullptr) {
    const auto& start = received->start;
    const auto clocks = [&](auto member) {
      return start ? std::optional(std::uint64_t{(*start).*member}) : std::nullopt;
    };
    row.emplace_back("lead_clocks", clocks(&FrameStart::lead_clocks));
    row.emplace_back("ack_clocks", clocks(&FrameStart::ack_clocks));
    row.emplace_back("status", received->fault ? name_of(received->fault->cause) : "ok");
  }
  return write_rows({row}, report::Format::jsonl, output);
}

// The options apply to every channel with this bit; at least one channel must have it.
void check_flags(const CrcOptions& options, const FrameFormat& format) {
  for (const auto& [given, option, kind] :
       {std::tuple(options.error, "--error", FieldKind::error),
        std::tuple(options.warning, "--warning", FieldKind::warning),
        std::tuple(options.life_counter.has_value(), "--lc", FieldKind::life_counter)}) {
    const std::string missing = missing_field(format, kind);
    if (given && !missing.empty()) throw wrong_usage("{}: {}", option, missing);
  }
}

std::uint64_t position_from(std::string_view text, unsigned bits, const std::string& where) {
  const std::uint64_t largest = low_mask(bits);
  if (bits == 0 && text != "0") {
    throw wrong_usage("position {}{}: the channel has no position; give 0", text, where);
  }
  const auto position = parse_count(text, largest);
  if (position.ok()) return *position;
  if (position.error().cause == QuantityCause::too_large) {
    throw wrong_usage("position {}{}: too large; {} bits hold at most {} (0x{:X})", text, where,
                      bits, largest, largest);
  }
  throw wrong_usage("position {}{}", quantity_error_text(Quantity::count, text, position.error()),
                    where);
}

Frame chosen_frame(const CrcOptions& options, const FrameFormat& format) {
  if (options.positions.size() != format.channel_count) {
    throw format.channel_count == 1
        ? wrong_usage("the format has 1 channel: give one position, or --read")
        : wrong_usage("the format has {0} channels: give {0} positions", format.channel_count);
  }
  check_flags(options, format);
  Frame frame;
  frame.channel_count = format.channel_count;
  frame.ack_clocks = 1;
  for (std::size_t k = 0; k < format.channel_count; ++k) {
    const ChannelFormat& channel = format.channel_list[k];
    Channel& values = frame.channel_list[k];
    values.position =
        position_from(options.positions[k], channel.position_bits(), channel_word(format, k));
    if (channel.error.present) values.nE = !options.error;
    if (channel.warning.present) values.nW = !options.warning;
    if (!channel.life_counter.present()) continue;
    const std::uint64_t largest = low_mask(channel.life_counter.bits);
    const std::uint64_t count = options.life_counter.value_or(0);
    if (count > largest) {
      throw wrong_usage("--lc {}: too large; {} bits hold at most {}", count,
                        channel.life_counter.bits, largest);
    }
    values.life_counter = static_cast<std::uint32_t>(count);
  }
  return frame;
}

using WordsByDigits = std::vector<std::pair<Digits, std::vector<Word>>>;

// The word in the text, by each kind of digits that it may have.
WordsByDigits words_of(const CrcOptions& options, const FrameFormat& format) {
  const std::string& chosen = options.reading.digits;
  WordsByDigits words;
  std::vector<std::string> good;
  for (const Digits digits : digits_in_order(options.buffer)) {
    auto word = parse_word(options.buffer, digits);
    if (!word || (!chosen.empty() && digits != chosen)) continue;
    if (!words.empty() && words.front().second.front() == *word) continue;
    if (is_good(*word, options.reading, format)) good.push_back(fmt::format("--digits {}", digits));
    words.push_back({digits, {std::move(*word)}});
  }
  if (words.empty()) {
    throw wrong_usage(
        "--read: '{}': expected bytes of two hexadecimal digits, bits, or a list of decimal bytes",
        options.buffer.substr(0, 40));
  }
  if (good.size() > 1) {
    throw wrong_usage("--read: the text is a good frame with {}; give one of them",
                      fmt::join(good, " and with "));
  }
  return words;
}

Received receive(const CrcOptions& options, const Word& word, const Device& device) {
  const FrameCodec<> codec(device.format);
  const BitView bits = word.view();
  Received received;
  FrameBounds widest;
  const auto take = [&received](const auto& frame) {
    if (!frame.ok()) received.fault = frame.error();
  };
  if (options.clock) {
    // All received bits are read: the command only shows them.
    const SpiSetup spi{
        .period = period_of(*options.clock), .no_error_flag = true, .unchecked = true};
    DeviceTiming timing = device.timing;
    timing.clock_max = std::max(timing.clock_max, *options.clock);
    const SpiReader reader(codec, spi, timing);
    widest.late_max_clocks = reader.bounds().late_max_clocks;
    take(reader.read(word.bytes, word.size_bits));
  } else {
    take(decode_frame(bits, codec, widest));
  }
  const auto start = find_start(bits, widest);
  if (!start.ok()) return received;
  const std::size_t end = 2 + device.format.payload_bits();
  const BitView line = bits.from(start->start_bit);
  if (end <= line.size_bits()) {
    received.line = {line.first(std::min(end + 1, line.size_bits())), !options.reading.payload};
  }
  // Otherwise the word does not have these bits.
  if (options.reading.has_ack()) received.start = *start;
  return received;
}

std::string summary_of(const CrcOptions& options, const FrameFormat& format,
                       const Received& received, const std::string& fitting) {
  report::Summary out;
  if (received.fault) {
    const FrameFault fault = *received.fault;
    const bool at_channel = fault.cause == FrameError::crc;
    out.entry("status",
              fmt::format("{}{}", name_of(fault.cause),
                          at_channel ? channel_word(format, fault.channel) : ""),
              fitting.empty() ? words_of(status_of(fault.cause)).reason : "");
  } else {
    out.entry("status", "ok");
  }
  if (received.start) {
    const unsigned ones = received.start->lead_clocks;
    std::string delay;
    if (options.clock && ones >= 2) {
      const Picoseconds period = period_of(*options.clock);
      delay = fmt::format("line delay {} to {} in SPI mode 3", text_of(period * (ones - 2)),
                          text_of(period * (ones - 1)));
    }
    out.entry("leading ones", fmt::format("{}", ones), delay);
    out.entry("ACK", report::counted(received.start->ack_clocks, "clock"));
  }
  if (!fitting.empty()) out.entry("try", fitting);
  return out.text();
}

// Prints the frame in the buffer, or why there is none and which options read it.
ExitStatus show_buffer(const CrcOptions& options, const Device& device, Host& host) {
  if (options.clock && !accepts_clock(device.timing, *options.clock)) {
    throw wrong_usage("--clock: the encoder does not accept {}", text_of(*options.clock));
  }
  if (options.clock && !options.reading.has_ack()) {
    throw wrong_usage("--clock: the word has no ACK; leave the option out");
  }
  const FrameFormat& format = device.format;
  const WordsByDigits words = words_of(options, format);
  const PlainCodec codec(format);
  const Word word = arrange(words.front().second.front(), options.reading, format);
  const Received received = receive(options, word, device);
  const bool is_table = options.to == report::Format::table;
  const ExitStatus status = write_output(host, options.output, [&](Output& output) {
    if (!is_table) return write_object(format, received.line, codec, &received, output);
    return !received.line || write_parts(format, *received.line, codec, output);
  });
  if (status != ExitStatus::done) return status;
  const std::string fitting =
      received.fault ? fitting_options(words, options.reading, format) : std::string();
  if (is_table || !fitting.empty()) {
    host.print_summary((is_table && received.line ? "\n" : "") +
                       summary_of(options, format, received, fitting));
  }
  return received.fault ? ExitStatus::data_failed : ExitStatus::done;
}

ExitStatus run_crc(const CrcOptions& options, Host& host) {
  const Device device = value_or_fail(choose_device(options.arguments));
  const FrameFormat& format = device.format;
  if (format.needs_previous()) {
    throw wrong_usage(
        "-f: with :previous the CRC of a frame is in the next one; decode a capture, or leave "
        ":previous out");
  }
  if (!options.buffer.empty()) return show_buffer(options, device, host);
  if (options.clock) throw wrong_usage("--clock: needs --read");
  const Frame frame = chosen_frame(options, format);
  const PlainCodec codec(format);
  const FrameBits bits = *encode_frame(frame, codec);
  const FrameLine line{bits.view().from(frame.lead_clocks + frame.ack_clocks)};
  return write_output(host, options.output, [&](Output& output) {
    return options.to == report::Format::table ? write_parts(format, line, codec, output)
                                               : write_object(format, line, codec, nullptr, output);
  });
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
  Option& position = verb.add_option(
      "POSITION", options->positions,
      "Position of each channel, decimal or 0x...; multiturn bits above singleturn bits");
  Option& error = verb.add_flag("--error", options->error, "Report an error: nE is 0");
  Option& warning = verb.add_flag("--warning", options->warning, "Report a warning: nW is 0");
  Option& counter = add_count_option(verb, "--lc", into(options->life_counter),
                                     "Value of the sign-of-life counter; 0 by default");
  Option& read =
      verb.add_option("--read", options->buffer,
                      "Show the frame in the bits that an SPI peripheral received: SLO once per "
                      "clock, in digits as in debuggers, dumps and source code")
          .type_name("BYTES")
          .excludes(position)
          .excludes(error)
          .excludes(warning)
          .excludes(counter);
  add_rate_option(verb, "--clock", into(options->clock),
                  "Clock of --read, to check leading ones and ACK too");
  add_to_option(verb, options->to, {report::Format::table, report::Format::jsonl});
  add_output_option(verb, options->output);
  add_word_options(verb, options->reading, read);
}

}  // namespace biss::verbs
