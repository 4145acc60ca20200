// The invariants of every capture that a reader delivers, for any input: of its edges, and of the
// request cycles in them.
#pragma once

#include <limits>

#include "biss/timing/renishaw.hpp"
#include "capture/bytes.hpp"
#include "capture/edge_source.hpp"
#include "capture/open.hpp"
#include "decode/check.hpp"
#include "decode/decoder.hpp"
#include "decode/lines.hpp"
#include "fuzz/capture_seeds.hpp"
#include "fuzz/target.hpp"

namespace biss::fuzz {

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
  return cycle.rising_edges >= 2 && cycle.status != CycleStatus::cut_start &&
         cycle.status != CycleStatus::unknown_level;
}

/// Checks the invariants of every row.
inline void check_cycle(const decode::Cycle& cycle, const FrameFormat& format) {
  require(cycle.frame.has_value() == (cycle.status == CycleStatus::ok));
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

/// MA and SLO are the first two lines, as in the seeds. In an eighth of the inputs they are searched
/// for, because the search decodes each pair several times. Nothing where none is found.
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

/// A number that follows from the input, so that inputs stay plain captures.
inline std::size_t mixed_from(std::string_view text) {
  std::size_t mixed = text.size();
  for (std::size_t i = 0; i < text.size(); i += 1 + text.size() / 8) {
    mixed = mixed * 31 + static_cast<unsigned char>(text[i]);
  }
  return mixed ^ mixed >> 16U;
}

/// The size of the blocks that an input is read in. Blocks of a few bytes cost the most, and
/// the other sizes find most of what they find.
inline std::size_t block_size_of(std::string_view text) {
  constexpr std::array<std::size_t, 16> sizes{
      1, 3, 7, 64, 64, 500, 500, 1'000, 1'000, 4'096, 4'096, 4'096, 4'096, 4'096, 4'096, 1'000'000};
  return sizes[mixed_from(text) % sizes.size()];
}

/// Whether the input is read in one block too, to compare: the half of those in blocks of a few
/// bytes, and an eighth of the rest.
inline bool is_compared(std::string_view text) {
  constexpr std::size_t few_bytes = 64;
  const std::size_t parts = block_size_of(text) <= few_bytes ? 2 : 8;
  return mixed_from(text) / 16 % parts == 0;
}

/// The content of a capture up to its end or its first error.
struct Read {
  std::vector<std::string> lines;
  std::vector<wire::Edge> edges;
  Picoseconds end{};
};

/// Reads to the end. Reports a finding if times decrease, a line is not in the list, an edge
/// changes no level, an error has no text, or the end is not final.
inline Read read_checked(capture::Opened opened) {
  Read read;
  std::vector<wire::Edge>& all = read.edges;
  if (!opened) {
    require(!capture::capture_error_text(opened.error(), "x").empty());
    return read;
  }
  read.lines = (*opened)->lines();
  all.reserve(256);
  std::vector<int> levels(read.lines.size(), -1);
  for (;;) {
    const auto block = (*opened)->next_block();
    if (!block.ok() || block->empty()) {
      const auto again = (*opened)->next_block();
      require(again.ok() == block.ok() && (!again.ok() || again->empty()));
      require(block.ok() || !capture::capture_error_text(block.error(), "x").empty());
      break;
    }
    for (const wire::Edge& edge : *block) {
      require(edge.line < levels.size());
      require(all.empty() || edge.time >= all.back().time);
      require(levels[edge.line] != static_cast<int>(edge.level));
      levels[edge.line] = static_cast<int>(edge.level);
      all.push_back(edge);
    }
  }
  read.end = (*opened)->end_time();
  require(all.empty() || read.end >= all.back().time);
  return read;
}

/// Reads `input` in blocks of the size derived from it and, for a part of the inputs, in one block
/// too: the edges must be the same. Then reads their request cycles. Returns the content.
/// \param open opens the input, to be read in blocks of a size
template <class Open>
Read check_blocks(std::string_view input, Open open) {
  Read read = read_checked(open(block_size_of(input)));
  check_cycles(read.lines, read.edges, read.end);
  if (is_compared(input)) {
    require(read.edges == read_checked(open(std::numeric_limits<std::size_t>::max())).edges);
  }
  return read;
}

/// The same with `open` for the bytes of a file.
template <class Open>
Read check_reader(std::string_view text, Open open) {
  return check_blocks(text,
                      [&](std::size_t block) { return open(capture::memory_bytes(text, block)); });
}

}  // namespace biss::fuzz
