// Reads a buffer of an SPI peripheral for `biss crc`.
#include "verbs/crc/crc.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

#include "biss/master/spi_read.hpp"
#include "biss/timing/cycle.hpp"
#include "device/words.hpp"
#include "report/summary.hpp"

namespace biss::verbs {
namespace {

using WordsByDigits = std::vector<std::pair<Digits, std::vector<Word>>>;

// The word in the text, by each kind of digits that it may have.
tl::expected<WordsByDigits, std::string> words_of(const BufferOptions& options,
                                                  const FrameFormat& format) {
  const std::string& chosen = options.reading.digits;
  WordsByDigits words;
  std::vector<std::string> good;
  for (const Digits digits : digits_in_order(options.text)) {
    auto word = parse_word(options.text, digits);
    if (!word || (!chosen.empty() && digits != chosen)) continue;
    if (!words.empty() && words.front().second.front() == *word) continue;
    if (is_good(*word, options.reading, format)) good.push_back(fmt::format("--digits {}", digits));
    words.push_back({digits, {std::move(*word)}});
  }
  if (words.empty()) {
    return tl::unexpected(
        fmt::format("--read: '{}': expected bytes of two hexadecimal digits, bits, "
                    "or a list of decimal bytes",
                    options.text.substr(0, 40)));
  }
  if (good.size() > 1) {
    return tl::unexpected(fmt::format("--read: the text is a good frame with {}; give one of them",
                                      fmt::join(good, " and with ")));
  }
  return words;
}

Received receive(const BufferOptions& options, const Word& word, const Device& device) {
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
  received.start = *start;
  const std::size_t end = start->start_bit + 2 + device.format.payload_bits();
  if (end <= bits.size_bits()) received.line = frame_words(device.format, bits, *start);
  if (options.reading.has_ack()) return received;
  // The word does not have these bits.
  received.start.reset();
  if (received.line && options.reading.payload) {
    received.line->cds.reset();
    received.line->stop.reset();
  }
  return received;
}

std::string summary_of(const BufferOptions& options, const FrameFormat& format,
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
    const unsigned zeros = received.start->ack_clocks;
    out.entry("ACK", fmt::format("{} clock{}", zeros, zeros == 1 ? "" : "s"));
  }
  if (!fitting.empty()) out.entry("try", fitting);
  return out.text();
}

}  // namespace

ExitStatus show_buffer(const BufferOptions& options, const Device& device, Host& host) {
  if (options.clock && !accepts_clock(device.timing, *options.clock)) {
    return host.fail(ExitStatus::usage, fmt::format("--clock: the encoder does not accept {}",
                                                    text_of(*options.clock)));
  }
  if (options.clock && !options.reading.has_ack()) {
    return host.fail(ExitStatus::usage, "--clock: the word has no ACK; leave the option out");
  }
  const FrameFormat& format = device.format;
  const auto words = words_of(options, format);
  if (!words) return host.fail(ExitStatus::usage, words.error());
  const PlainCodec codec(format);
  const Word word = arrange(words->front().second.front(), options.reading, format);
  const Received received = receive(options, word, device);
  Output output(host);
  if (!output.open(options.output)) return output.status();
  const bool is_table = options.to == report::Format::table;
  bool written = true;
  if (!is_table) {
    written = write_object(format, received.line, codec, &received, output);
  } else if (received.line) {
    written = write_table(format, *received.line, codec, output, output.table_options());
  }
  if (!written || !output.finish()) return output.status();
  const std::string fitting =
      received.fault ? fitting_options(*words, options.reading, format) : std::string();
  if (is_table || !fitting.empty()) {
    host.print_summary((is_table && received.line ? "\n" : "") +
                       summary_of(options, format, received, fitting));
  }
  return received.fault ? ExitStatus::data_failed : ExitStatus::done;
}

}  // namespace biss::verbs
