// `biss identify`: the protocol on the lines of a capture, and the frame format.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <memory>
#include <optional>
#include <vector>

#include "biss/timing/device_timing.hpp"
#include "decode/distribution.hpp"
#include "decode/statistics.hpp"
#include "device/quantity.hpp"
#include "identify/collector.hpp"
#include "identify/protocol.hpp"
#include "report/summary.hpp"
#include "rows/columns.hpp"
#include "verbs/common/decoded_capture.hpp"
#include "verbs/common/fields.hpp"
#include "verbs/common/identified.hpp"
#include "verbs/common/table_output.hpp"
#include "verbs/common/verb.hpp"

namespace biss::verbs {

namespace {

using identify::FormatCandidate;
using identify::FormatFinding;
using identify::Protocol;
using identify::ProtocolGuess;

struct IdentifyOptions {
  CaptureArguments capture;
  std::string output;
  report::Format to = report::Format::table;
};

// Four places: confidences are not more precise.
double rounded_down(double confidence) { return std::floor(confidence * 1e4) / 1e4; }

// The rule by which the encoder releases SLO after a frame: the one that fits best. If the clock
// and the length of the frames do not change, several rules fit.
class ReleaseRule {
 public:
  void add(const decode::Cycle& cycle) {
    if (!cycle.release || !cycle.line_delay || !cycle.period) return;
    const Picoseconds after_clock = *cycle.release - *cycle.line_delay;
    if (after_clock.count < 0) return;
    after_clock_.add(after_clock.count);
    in_periods_.add(after_clock.count * 1000 / cycle.period->count);
    after_begin_.add((cycle.clocked + after_clock).count);
  }

  // The rule, if only one of the three fits.
  std::optional<Timeout> rule() const {
    if (after_clock_.count() < least_frames) return std::nullopt;
    const bool fixed = is_constant(after_clock_);
    const bool cycle = is_constant(after_begin_);
    // 1.5 periods, and up to three clocks of the encoder.
    const bool adaptive =
        is_constant(in_periods_) && in_periods_.median() >= 1400 && in_periods_.median() <= 3000;
    if (int{fixed} + int{cycle} + int{adaptive} != 1) return std::nullopt;
    if (adaptive) return Timeout{TimeoutRule::adaptive, {}};
    if (fixed) return Timeout{TimeoutRule::fixed, picoseconds(after_clock_.median())};
    return Timeout{TimeoutRule::cycle, picoseconds(after_begin_.median())};
  }

 private:
  static constexpr std::uint64_t least_frames = 8;

  static bool is_constant(const decode::Distribution& values) {
    return 50 * (values.max() - values.min()) <= values.median();
  }

  // From the last edge of MA to SLO, at the encoder.
  decode::Distribution after_clock_;
  // Thousandths of a period.
  decode::Distribution in_periods_;
  decode::Distribution after_begin_;
};

// The measurements on one pair of lines.
struct Line {
  // Empty if the lines carry another protocol.
  std::optional<std::string> ma;
  std::optional<std::string> slo;
  std::string inverted;
  decode::Statistics statistics;
  identify::SampleCollector samples;
  ReleaseRule release;
  std::vector<identify::FormatPart> parts;

  void add(std::uint64_t number, const decode::Cycle& cycle) {
    statistics.add(cycle);
    samples.add(number, cycle);
    release.add(cycle);
  }
};

std::string joined(const std::vector<std::string>& texts) {
  return fmt::format("{}", fmt::join(texts, " | "));
}

// The guesses and their odds: without the first one if it is the format.
std::string alternatives_of(const FormatFinding& finding, report::Format to) {
  const bool json = to == report::Format::jsonl;
  std::vector<std::string> texts;
  for (std::size_t i = finding.sure() != nullptr ? 1 : 0; i < finding.candidates.size(); ++i) {
    const FormatCandidate& each = finding.candidates[i];
    texts.push_back(
        fmt::format(fmt::runtime(json ? "{{\"format\":\"{}\",\"odds\":{:.4f}}}" : "{} {:.4f}"),
                    text_of(each.format), rounded_down(each.confidence)));
  }
  if (json) return fmt::format("[{}]", fmt::join(texts, ","));
  return joined(texts);
}

// The row of a format, or of another protocol.
FieldRow format_fields(const std::string& file, const ProtocolGuess& guess, const Line& line,
                       const identify::FormatPart& part, report::Format to) {
  const decode::Statistics& statistics = line.statistics;
  std::optional<Hertz> clock;
  std::optional<Picoseconds> delay;
  std::optional<std::uint64_t> ack;
  std::optional<std::string> timeout;
  if (statistics.period().count() != 0) {
    clock = rate_of(picoseconds(statistics.period().median()));
  }
  if (statistics.line_delay().count() != 0) {
    delay = picoseconds(statistics.line_delay().median());
  }
  if (statistics.ack_clocks().count() != 0) {
    ack = static_cast<std::uint64_t>(statistics.ack_clocks().median());
  }
  if (const auto rule = line.release.rule()) timeout = biss::text_of(*rule);
  const FormatFinding& finding = part.finding;
  const bool any = !finding.candidates.empty();
  const FormatCandidate best = any ? finding.candidates.front() : FormatCandidate{};
  std::vector<std::string> equal;
  for (const FrameFormat& each : best.equal) equal.push_back(text_of(each));
  const auto when = [](bool known, const auto& value) {
    return known ? std::optional(value) : std::nullopt;
  };
  const bool is_biss = line.ma.has_value();
  const bool several = line.parts.size() > 1;
  FieldRow row{
      {"file", file},
      {"ma", line.ma, {.heading = "MA"}},
      {"slo", line.slo, {.heading = "SLO"}},
      {"inverted", unless_empty(line.inverted)},
      {"clock_hz", clock, rows::clock_column()},
      {"line_delay_ns", delay, rows::line_delay_column()},
      {"ack_clocks", ack, {.heading = "ACK", .unit = "clocks"}},
      {"format", when(finding.sure() != nullptr, text_of(best.format))},
      {"confidence", when(any && !finding.still, rounded_down(best.confidence)), {.places = 2}}};
  // The summary has the rest for people.
  if (to == report::Format::table) return row;
  const FieldRow further{
      {"equal", unless_empty(joined(equal))},
      {"alternatives", unless_empty(is_biss ? alternatives_of(finding, to) : ""), {.json = true}},
      {"encoders", unless_empty(encoders_text(best, best.encoders.size()))},
      {"protocol", name_of(guess.protocol)},
      {"protocol_confidence", guess.confidence, {.heading = "sure", .places = 2}},
      {"cycles", when(is_biss, statistics.cycles())},
      {"frames", when(is_biss, statistics.good())},
      {"timeout", timeout},
      {"from_cycle", when(several, part.from_cycle)},
      {"to_cycle", when(several, part.to_cycle)}};
  row.insert(row.end(), further.begin(), further.end());
  return row;
}

class IdentifyRun {
 public:
  IdentifyRun(const IdentifyOptions& options, Host& host) : options_(options), host_(host) {}

  ExitStatus run() {
    const std::string& format = options_.capture.device.format;
    if (!format.empty() && format != "none") {
      return host_.fail(
          ExitStatus::usage,
          "identify finds the format without -f: leave it out; biss explain compares a "
          "format with the frames");
    }
    const ExitStatus opened = capture_.open(options_.capture);
    if (opened != ExitStatus::done) return opened;
    return write_captures(
        capture_, options_.output, options_.to,
        [this] { return columns_of(format_fields("", {}, {}, {}, options_.to)); }, true,
        std::bind_front(&IdentifyRun::judge, this));
  }

 private:
  // The rows of one pair of lines.
  ExitStatus judge(report::TableWriter& writer, RunMessages& messages) {
    const ProtocolGuess guess = capture_.protocol();
    const bool other = guess.protocol != Protocol::biss_c && guess.protocol != Protocol::unknown &&
                       guess.protocol != Protocol::clock_alone;
    Line line;
    const std::string& name = capture_.input().name();
    if (!capture_.has_lines() || other) {
      write_row(writer, format_fields(name, guess, line, {}, options_.to));
      report::Summary summary;
      summary.title(name);
      add_protocol(summary, guess);
      messages.add_summary(summary.text());
      return ExitStatus::data_failed;
    }
    const decode::Lines& lines = capture_.lines().lines;
    line.ma = capture_.ma_name();
    line.slo = capture_.slo_name();
    line.inverted = fmt::format("{}{}{}", lines.ma_inverted ? "MA" : "",
                                lines.ma_inverted && lines.slo_inverted ? ";" : "",
                                lines.slo_inverted ? "SLO" : "");
    const bool read = capture_.read([&line](std::uint64_t number, const decode::Cycle& cycle) {
      line.add(number, cycle);
      return true;
    });
    line.parts = identify::find_parts(line.samples.samples());
    if (line.parts.empty()) line.parts.emplace_back();
    bool sure = true;
    for (const identify::FormatPart& part : line.parts) {
      write_row(writer, format_fields(name, guess, line, part, options_.to));
      sure = sure && part.finding.sure() != nullptr;
    }
    messages.add_summary(summary(guess, line));
    if (!read) return messages.fail(ExitStatus::io, capture_.input().error());
    if (line.statistics.cycles() == 0) {
      return messages.fail(ExitStatus::data_failed, capture_.no_request());
    }
    return sure ? ExitStatus::done : ExitStatus::data_failed;
  }

  static void add_protocol(report::Summary& summary, const ProtocolGuess& guess) {
    summary.entry("protocol", name_of(guess.protocol),
                  fmt::format("confidence {:.2f}: {}", guess.confidence, guess.why));
  }

  std::string summary(const ProtocolGuess& guess, const Line& line) const {
    report::Summary out;
    out.title(fmt::format("{}: {} request cycles, {} with a frame", capture_.input().name(),
                          line.statistics.cycles(), line.statistics.good()));
    add_protocol(out, guess);
    out.entry(
        "lines", fmt::format("MA = {}, SLO = {}", capture_.ma_name(), capture_.slo_name()),
        capture_.lines().look_swapped ? "exchanged? cycles can be read if they are exchanged" : "");
    for (const identify::FormatPart& part : line.parts) {
      if (line.parts.size() > 1) {
        out.entry("length", fmt::format("{} bits after CDS", part.bits),
                  fmt::format("from cycle {} to {}", part.from_cycle, part.to_cycle));
      }
      add_identified(out, part.finding, true);
      if (part.finding.candidates.empty()) continue;
      const identify::Layout& best = part.finding.candidates.front().layout;
      out.entry("evidence", fmt::format("{:.0f} bits", best.score),
                fmt::format("{} independent differences, checksums right in {:.1f} % of the frames",
                            best.channels.front().rank, 100 * best.right_share));
    }
    return out.text();
  }

  const IdentifyOptions& options_;
  Host& host_;
  DecodedCapture capture_{host_};
};

}  // namespace

void add_identify(Command& command) {
  const auto options = std::make_shared<IdentifyOptions>();
  options->capture.each = true;
  options->capture.keep_unknown = true;
  Verb verb = command.add_verb(
      {.name = "identify",
       .purpose = "Find out what the lines of a capture carry, and the frame format",
       .examples = {"biss identify capture.vcd", "biss identify *.sr --to jsonl",
                    "biss identify samples.bin --raw-rate 100MHz --ma D0 --slo D3"}},
      [options](Host& host) { return IdentifyRun(*options, host).run(); });
  add_capture_options(verb, options->capture, true);
  add_range_options(verb, options->capture);
  add_output_option(verb, options->output);
  add_to_option(verb, options->to);
}

}  // namespace biss::verbs
