// Reads request cycles from the edges of a reader, judges them, and counts the inputs that reach a
// cycle.
#pragma once

#include <cstdint>
#include <cstdio>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "biss/frame/format_text.hpp"
#include "biss/timing/renishaw.hpp"
#include "decode/check.hpp"
#include "decode/decoder.hpp"
#include "decode/lines.hpp"
#include "fuzz/require.hpp"
#include "wire/edge.hpp"

namespace biss::fuzz {

/// The format that the cycles of fuzzed captures are read with: short, so that many captures are
/// read in a second.
inline constexpr std::string_view capture_format = "pos5,nE,nW,crc4";

/// Counts inputs, and prints the counts when the program ends.
class Tally {
 public:
  void add(bool reached_cycle, bool reached_frame) {
    ++inputs_;
    cycles_ += reached_cycle ? 1U : 0U;
    frames_ += reached_frame ? 1U : 0U;
  }
  ~Tally() {
    std::fprintf(stderr, "tally: inputs %llu reaching_cycles %llu reaching_frames %llu\n", inputs_,
                 cycles_, frames_);
  }

 private:
  unsigned long long inputs_ = 0;
  unsigned long long cycles_ = 0;
  unsigned long long frames_ = 0;
};

/// A whole request: MA was idle before, and clocked twice at least.
inline bool is_request(const decode::Cycle& cycle) {
  return cycle.rising_edges >= 2 && cycle.status != decode::CycleStatus::cut_start &&
         cycle.status != decode::CycleStatus::unknown_level;
}

/// Checks the invariants of every row.
inline void check_cycle(const decode::Cycle& cycle, const FrameFormat& format) {
  require(cycle.frame.has_value() == (cycle.status == decode::CycleStatus::ok));
  require(!name_of(cycle.status).empty());
  require(!cycle.line_delay ||
          (cycle.line_delay->count >= 0 && *cycle.line_delay <= biss_line_delay_max));
  require(!cycle.period || cycle.period->count >= 0);
  require(cycle.raw.size_bits() <= format.payload_bits() + 3U);
  if (cycle.frame) require(cycle.frame->channel_list[0].position <= low_mask(5));
  if (cycle.frame) require(cycle.crc_ok[0] == true);
}

/// A rule that fails has a fault, one that passes has a case.
inline void check_verdicts(const decode::Check& check) {
  for (std::size_t i = 0; i < decode::rule_count; ++i) {
    const decode::RuleResult result = check.result(static_cast<decode::Rule>(i));
    if (result.verdict == decode::Verdict::fail) require(result.faults != 0 && result.cycle);
    if (result.verdict == decode::Verdict::pass) require(result.cases != 0 && result.faults == 0);
  }
}

/// MA and SLO are the first two lines, as in the seeds. In an eighth of the inputs they are
/// searched for, because the search decodes each pair several times. Empty if none is found.
inline std::optional<decode::Lines> lines_of(const std::vector<std::string>& names,
                                             const std::vector<wire::Edge>& edges,
                                             const decode::CycleReader& reader) {
  if (edges.size() % 8 != 0 && names.size() >= 2) return decode::Lines{.ma = 0, .slo = 1};
  const decode::LineRequest request{.ma = {}, .slo = {}, .each = edges.size() % 3 == 0};
  const auto found = decode::find_lines(names, edges, request, reader);
  if (found) return found->front().lines;
  require(found.error().candidates.size() <= names.size() * names.size());
  return std::nullopt;
}

/// Finds MA and SLO, reads the cycles, checks each row, and counts the input.
inline void check_cycles(const std::vector<std::string>& names,
                         const std::vector<wire::Edge>& edges, Picoseconds end) {
  static Tally tally;
  static const FrameFormat format = *parse_format(capture_format);
  static const decode::CycleReader reader(format, DeviceTiming{}, {.signal = true});
  bool reached_cycle = false;
  bool reached_frame = false;
  if (const auto lines = lines_of(names, edges, reader)) {
    Picoseconds last{INT64_MIN};
    std::uint64_t number = 0;
    decode::Check check({.format = format,
                         .timing = renishaw_timing,
                         .unidirectional = true,
                         .renishaw_cables = true,
                         .speed_max = 1'000'000});
    decode::Decoder decoder(reader, [&](const decode::Cycle& cycle) {
      check_cycle(cycle, format);
      check.push(number++, cycle);
      require(cycle.time >= last && cycle.time <= end);
      last = cycle.time;
      reached_cycle = reached_cycle || is_request(cycle);
      reached_frame = reached_frame || cycle.frame.has_value();
    });
    decoder.push(edges, *lines);
    decoder.finish(end);
    check.finish();
    check_verdicts(check);
  }
  tally.add(reached_cycle, reached_frame);
}

}  // namespace biss::fuzz
