// `biss identify`: what the lines of a capture carry, and the frame format.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "cli/common/columns.hpp"
#include "cli/common/decoded_capture.hpp"
#include "cli/common/identified.hpp"
#include "cli/common/quantity.hpp"
#include "cli/common/verbs.hpp"
#include "decode/statistics.hpp"
#include "identify/collector.hpp"
#include "identify/line_facts.hpp"
#include "identify/protocol.hpp"
#include "report/summary.hpp"

namespace biss::cli {

namespace {

using identify::FormatCandidate;
using identify::FormatFinding;
using identify::Protocol;
using identify::ProtocolGuess;
using report::Cell;
using report::Kind;

struct IdentifyOptions {
  CaptureArguments capture;
  std::string output;
  report::Format to = report::Format::table;
};

const std::vector<report::Column>& identify_columns() {
  static const std::vector<report::Column> all{
      {.name = "file", .kind = Kind::text},
      {.name = "ma", .kind = Kind::text, .heading = "MA"},
      {.name = "slo", .kind = Kind::text, .heading = "SLO"},
      {.name = "inverted", .kind = Kind::text},
      clock_column(),
      line_delay_column(),
      {.name = "ack_clocks", .kind = Kind::unsigned_integer, .heading = "ACK", .unit = "clocks"},
      {.name = "format", .kind = Kind::text},
      {.name = "confidence", .kind = Kind::real, .places = 2},
      {.name = "equal", .kind = Kind::text},
      {.name = "alternatives", .kind = Kind::text},
      {.name = "encoders", .kind = Kind::text},
      {.name = "protocol", .kind = Kind::text},
      {.name = "protocol_confidence", .kind = Kind::real, .heading = "sure", .places = 2},
      {.name = "cycles", .kind = Kind::unsigned_integer},
      {.name = "frames", .kind = Kind::unsigned_integer},
      {.name = "timeout", .kind = Kind::text},
      {.name = "from_cycle", .kind = Kind::unsigned_integer},
      {.name = "to_cycle", .kind = Kind::unsigned_integer}};
  return all;
}

// For eyes the first nine columns; the summary has the rest.
std::vector<report::Column> columns_for(report::Format to) {
  constexpr std::ptrdiff_t shown = 9;
  const auto& all = identify_columns();
  if (to != report::Format::table) return all;
  return {all.begin(), all.begin() + shown};
}

// Four places: no more is known.
double rounded_down(double confidence) { return std::floor(confidence * 1e4) / 1e4; }

// What was measured on one pair of lines.
struct Line {
  decode::Statistics statistics;
  identify::SampleCollector samples;
  identify::ReleaseRule release;
  FormatFinding finding;

  void add(std::uint64_t number, const decode::Cycle& cycle) {
    statistics.add(cycle);
    samples.add(number, cycle);
    release.add(cycle);
  }
};

// A part of the capture whose requests have one number of clocks.
struct LengthPart {
  std::uint32_t clocks = 0;
  std::uint64_t from = 0;
  std::uint64_t to = 0;
  Line line{};
};

// Splits the frames of a capture where the number of clocks changes for good.
class LengthParts {
 public:
  void add(std::uint64_t number, const decode::Cycle& cycle) {
    const bool frame = cycle.status == decode::CycleStatus::unchecked ||
                       cycle.status == decode::CycleStatus::ack_range;
    if (!frame || cycle.raw.size_bits() <= identify::short_frame_bits || parts_.size() > most) {
      return;
    }
    if (!parts_.empty() && parts_.back().clocks == cycle.rising_edges) {
      next_.clear();
      return take(number, cycle);
    }
    if (!next_.empty() && next_.back().second.rising_edges != cycle.rising_edges) next_.clear();
    next_.emplace_back(number, cycle);
    if (next_.size() < least_frames) return;
    parts_.push_back({.clocks = cycle.rising_edges, .from = next_.front().first});
    for (const auto& [begun, each] : next_) take(begun, each);
    next_.clear();
  }

  // Finds the format of each. Empty: they have one format, or the length changes too often.
  std::vector<LengthPart> finish() {
    if (parts_.size() < 2 || parts_.size() > most) return {};
    bool differs = false;
    for (LengthPart& part : parts_) {
      part.line.finding = identify::find_format(part.line.samples.samples());
      const auto* sure = part.line.finding.sure();
      const auto* first = parts_.front().line.finding.sure();
      differs = differs || (sure != nullptr && first != nullptr && sure->format != first->format);
    }
    return differs ? std::move(parts_) : std::vector<LengthPart>();
  }

 private:
  static constexpr std::size_t least_frames = 8;
  static constexpr std::size_t most = 8;

  void take(std::uint64_t number, const decode::Cycle& cycle) {
    parts_.back().to = number;
    parts_.back().line.add(number, cycle);
  }

  std::vector<LengthPart> parts_;
  // Frames of another length: a part, if there are enough.
  std::vector<std::pair<std::uint64_t, decode::Cycle>> next_;
};

std::string joined(const std::vector<std::string>& texts) {
  return fmt::format("{}", fmt::join(texts, " | "));
}

class IdentifyRun {
 public:
  explicit IdentifyRun(const IdentifyOptions& options) : options_(options) {}

  ExitStatus run() {
    const std::string& format = options_.capture.device.format;
    if (!format.empty() && format != "none") {
      return fail(ExitStatus::usage,
                  "identify finds the format without -f: leave it out; biss explain compares a "
                  "format with the frames");
    }
    const ExitStatus opened = capture_.open(options_.capture);
    if (opened != ExitStatus::done) return opened;
    return write_captures(
        capture_, options_.output, options_.to, [this] { return columns_for(options_.to); }, true,
        [&](report::TableWriter& writer, RunMessages& messages) {
          return identify(writer, messages);
        });
  }

 private:
  // The row of one pair of lines.
  ExitStatus identify(report::TableWriter& writer, RunMessages& messages) {
    const ProtocolGuess guess = capture_.protocol();
    const bool other = guess.protocol != Protocol::biss_c && guess.protocol != Protocol::unknown &&
                       guess.protocol != Protocol::clock_alone;
    if (!capture_.has_lines() || other) {
      put_other(writer, guess);
      report::Summary summary;
      summary.title(capture_.input().name());
      add_protocol(summary, guess);
      messages.add_summary(summary.text());
      return ExitStatus::data_failed;
    }
    Line line;
    LengthParts lengths;
    const bool read = capture_.read([&](std::uint64_t number, const decode::Cycle& cycle) {
      line.add(number, cycle);
      lengths.add(number, cycle);
      return true;
    });
    const std::vector<LengthPart> parts = lengths.finish();
    if (parts.empty()) {
      line.finding = identify::find_format(line.samples.samples());
      put(writer, guess, line);
    }
    for (const LengthPart& part : parts) put(writer, guess, part.line, &part);
    messages.add_summary(summary(guess, line, parts));
    if (!read) return messages.fail(ExitStatus::io, capture_.input().error());
    if (line.statistics.cycles() == 0) {
      return messages.fail(ExitStatus::data_failed, capture_.no_request());
    }
    const bool sure = parts.empty() ? line.finding.sure() != nullptr
                                    : std::ranges::all_of(parts, [](const LengthPart& part) {
                                        return part.line.finding.sure() != nullptr;
                                      });
    return sure ? ExitStatus::done : ExitStatus::data_failed;
  }

  void put_other(report::TableWriter& writer, const ProtocolGuess& guess) {
    std::vector<Cell> cells(identify_columns().size());
    cells[0] = capture_.input().name();
    cells[12] = name_of(guess.protocol);
    cells[13] = guess.confidence;
    cells.resize(columns_for(options_.to).size());
    writer.row(cells);
  }

  void put(report::TableWriter& writer, const ProtocolGuess& guess, const Line& line,
           const LengthPart* part = nullptr) {
    const decode::Statistics& statistics = line.statistics;
    std::vector<Cell> cells(identify_columns().size());
    const decode::Lines& lines = capture_.lines().lines;
    const std::string inverted = fmt::format("{}{}{}", lines.ma_inverted ? "MA" : "",
                                             lines.ma_inverted && lines.slo_inverted ? ";" : "",
                                             lines.slo_inverted ? "SLO" : "");
    cells[0] = capture_.input().name();
    cells[1] = capture_.ma_name();
    cells[2] = capture_.slo_name();
    if (!inverted.empty()) cells[3] = inverted;
    if (statistics.period().count() != 0) {
      cells[4] = rate_of(picoseconds(statistics.period().median()));
    }
    if (statistics.line_delay().count() != 0) {
      cells[5] = picoseconds(statistics.line_delay().median());
    }
    if (statistics.ack_clocks().count() != 0) {
      cells[6] = static_cast<std::uint64_t>(statistics.ack_clocks().median());
    }
    std::string format;
    std::vector<std::string> equal;
    std::vector<std::string> alternatives;
    std::string encoders;
    const auto& candidates = line.finding.candidates;
    if (!candidates.empty()) {
      const FormatCandidate& best = candidates.front();
      format = text_of(best.format);
      for (const FrameFormat& each : best.equal) equal.push_back(text_of(each));
      encoders = encoders_text(best, best.encoders.size());
      cells[7] = format;
      if (!line.finding.still) cells[8] = rounded_down(best.confidence);
    }
    for (std::size_t i = 1; i < candidates.size(); ++i) {
      alternatives.push_back(text_of(candidates[i].format));
    }
    const std::string equal_text = joined(equal);
    const std::string alternatives_text = joined(alternatives);
    if (!equal.empty()) cells[9] = equal_text;
    if (!alternatives.empty()) cells[10] = alternatives_text;
    if (!encoders.empty()) cells[11] = encoders;
    cells[12] = name_of(guess.protocol);
    cells[13] = guess.confidence;
    cells[14] = statistics.cycles();
    cells[15] = statistics.good();
    const auto rule = line.release.rule();
    const std::string timeout = rule ? cli::text_of(*rule) : std::string();
    if (rule) cells[16] = timeout;
    if (part != nullptr) {
      cells[17] = part->from;
      cells[18] = part->to;
    }
    cells.resize(columns_for(options_.to).size());
    writer.row(cells);
  }

  static void add_protocol(report::Summary& summary, const ProtocolGuess& guess) {
    summary.entry("protocol", name_of(guess.protocol),
                  fmt::format("confidence {:.2f}: {}", guess.confidence, guess.why));
  }

  std::string summary(const ProtocolGuess& guess, const Line& line,
                      const std::vector<LengthPart>& parts) const {
    report::Summary out;
    out.title(fmt::format("{}: {} request cycles, {} with a frame", capture_.input().name(),
                          line.statistics.cycles(), line.statistics.good()));
    add_protocol(out, guess);
    out.entry(
        "lines", fmt::format("MA = {}, SLO = {}", capture_.ma_name(), capture_.slo_name()),
        capture_.lines().look_swapped ? "exchanged? the other way round cycles can be read" : "");
    if (parts.empty()) add_finding(out, line.finding);
    for (const LengthPart& part : parts) {
      out.entry(
          "length", fmt::format("{} clocks", part.clocks),
          fmt::format("cycles {} to {}; read these with --since and --until", part.from, part.to));
      add_finding(out, part.line.finding);
    }
    return out.text();
  }

  static void add_finding(report::Summary& out, const FormatFinding& finding) {
    add_identified(out, finding, true);
    if (finding.candidates.empty()) return;
    const identify::Layout& best = finding.candidates.front().layout;
    out.entry("evidence", fmt::format("{:.0f} bits", best.score),
              fmt::format("{} independent differences, checksums right in {:.1f} % of the frames",
                          best.channels.front().rank, 100 * best.right_share));
  }

  const IdentifyOptions& options_;
  DecodedCapture capture_;
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
      [options] { return IdentifyRun(*options).run(); });
  add_capture_options(verb, options->capture, true);
  add_range_options(verb, options->capture);
  add_output_option(verb, options->output);
  add_to_option(verb, options->to);
}

}  // namespace biss::cli
