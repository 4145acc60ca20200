// Reads request cycles from the edges of a reader, judges them, and counts the inputs that reach a
// cycle.
#pragma once

#include <cstdint>
#include <cstdio>
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

/// The format that the cycles of fuzzed captures are read with.
inline constexpr std::string_view capture_format = "pos12,nE,nW,crc6";

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
  if (cycle.frame) require(cycle.frame->channel_list[0].position <= low_mask(12));
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

/// Finds MA and SLO, reads the cycles, checks each row, and counts the input. With many lines, MA
/// and SLO are searched for in an eighth of the inputs only, because the search decodes each pair.
/// Otherwise they are the first two lines.
inline void check_cycles(const std::vector<std::string>& lines,
                         const std::vector<wire::Edge>& edges, Picoseconds end) {
  static Tally tally;
  static const FrameFormat format = *parse_format(capture_format);
  static const decode::CycleReader reader(format, DeviceTiming{}, {.signal = true});
  bool reached_cycle = false;
  bool reached_frame = false;
  Picoseconds last{INT64_MIN};
  decode::Check check({.format = format,
                       .timing = renishaw_timing,
                       .unidirectional = true,
                       .renishaw_cables = true,
                       .speed_max = 1'000'000});
  std::uint64_t number = 0;
  const bool given = lines.size() > 3 && edges.size() % 8 != 0;
  decode::LineRequest request{.ma = {}, .slo = {}, .each = edges.size() % 3 == 0};
  if (given) request = {.ma = lines[0], .slo = lines[1]};
  const auto found = decode::find_lines(lines, edges, request, reader);
  if (!found) require(found.error().candidates.size() <= lines.size() * lines.size());
  if (found) {
    decode::Decoder decoder(reader, [&](const decode::Cycle& cycle) {
      check_cycle(cycle, format);
      check.push(number++, cycle);
      require(cycle.time >= last && cycle.time <= end);
      last = cycle.time;
      reached_cycle = reached_cycle || is_request(cycle);
      reached_frame = reached_frame || cycle.frame.has_value();
    });
    decoder.push(edges, found->front().lines);
    decoder.finish(end);
    check.finish();
    check_verdicts(check);
  }
  tally.add(reached_cycle, reached_frame);
}

}  // namespace biss::fuzz
