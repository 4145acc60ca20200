// Request cycles of any shape, with edges moved, lost and added: the input of the targets that compare
// two ways of decoding a line.
#pragma once

#include <fmt/format.h>

#include <iterator>

#include "biss/frame/format_text.hpp"
#include "biss/timing/device_timing.hpp"
#include "decode/line_history.hpp"
#include "decode/test_line.hpp"
#include "fuzz/target.hpp"
#include "wire/edge.hpp"

namespace biss::fuzz {

/// The lines to decode, and the setup.
struct RequestLines {
  std::optional<FrameFormat> format;
  DeviceTiming timing;
  std::vector<decode::LevelChange> ma;
  std::vector<decode::LevelChange> slo;
  /// The period of the last request.
  Picoseconds period;
  Picoseconds end;

  /// MA is line 0, SLO line 1. If both change at one time, SLO comes first.
  std::vector<wire::Edge> edges() const {
    std::vector<wire::Edge> all;
    all.reserve(ma.size() + slo.size());
    auto change = slo.begin();
    for (const decode::LevelChange& edge : ma) {
      for (; change != slo.end() && change->time <= edge.time; ++change) {
        all.push_back({change->time, 1, change->level});
      }
      all.push_back({edge.time, 0, edge.level});
    }
    for (; change != slo.end(); ++change) all.push_back({change->time, 1, change->level});
    return all;
  }
};

inline decode::test::Shape shape_from(ByteSource& bytes) {
  decode::test::Shape shape;
  shape.period = picoseconds(20'000 + std::int64_t{bytes.next_16()} * 32);
  shape.high_percent = 30 + bytes.next() % 41;
  shape.line_delay = picoseconds(std::int64_t{bytes.next_16()} * 16);
  shape.timeout = nanoseconds(std::int64_t{bytes.next()} * 100);
  shape.gap = nanoseconds(10 + std::int64_t{bytes.next()} * 50);
  shape.extra_clocks = bytes.next() % 6 - 1;
  shape.ack_clocks = static_cast<std::uint16_t>(1 + bytes.next() % 40);
  shape.ending = static_cast<decode::test::Ending>(bytes.next() % 3);
  shape.jitter_percent = bytes.next() % 16;
  const int pauses = std::max(0, bytes.next() % 8 - 3);
  for (int i = 0; i < pauses; ++i) shape.pauses.push_back(bytes.next() % 64);
  shape.pause = shape.period * bytes.next() / 16;
  return shape;
}

// Any edge is moved up to its neighbours, lost, or becomes a pulse.
inline void damage(std::vector<decode::LevelChange>& line, ByteSource& bytes) {
  const std::size_t at = 1 + bytes.next_16() % line.size();
  if (at + 1 >= line.size()) return;
  const Picoseconds before = line[at - 1].time;
  const Picoseconds room = line[at + 1].time - before;
  switch (bytes.next() % 3) {
    case 0:
      line[at].time = before + room * bytes.next() / 256;
      break;
    case 1:
      line.erase(line.begin() + static_cast<std::ptrdiff_t>(at),
                 line.begin() + static_cast<std::ptrdiff_t>(at + 2));
      break;
    default:
      decode::test::TestLine::add_pulse(line, line[at].time,
                                        picoseconds(1 + std::int64_t{bytes.next_16()} * 8));
  }
}

// The changes as a capture delivers them: times never fall, and each change has a different level.
inline void put_in_order(std::vector<decode::LevelChange>& line) {
  const auto earlier = [](const decode::LevelChange& a, const decode::LevelChange& b) {
    return a.time < b.time;
  };
  if (!std::is_sorted(line.begin(), line.end(), earlier)) {
    std::stable_sort(line.begin(), line.end(), earlier);
  }
  line.erase(std::unique(line.begin(), line.end(),
                         [](const decode::LevelChange& a, const decode::LevelChange& b) {
                           return a.level == b.level;
                         }),
             line.end());
}

/// At least two requests, in a format that is mostly known.
inline RequestLines request_lines(ByteSource& bytes) {
  constexpr std::array<std::string_view, 4> formats{"pos26,nE,nW,crc6", "pos9,crc5",
                                                    "pos36,nE,nW,crc6",
                                                    "pos36,nE,nW,crc6+pos28,nE,nW,lc6,crc16;cds0"};
  RequestLines input;
  const std::string_view text = formats[bytes.next() % formats.size()];
  const unsigned choice = bytes.next();
  if (choice % 8 != 7) input.format = *parse_format(text);
  input.timing.clock_constant = choice % 2 == 0;
  if (choice % 16 < 4) input.timing.timeout.time = nanoseconds(100 * bytes.next());
  decode::test::TestLine line(bytes.next());
  decode::test::Shape shape = shape_from(bytes);
  const int cycles = 2 + bytes.next() % 5;
  for (int i = 0; i < cycles; ++i) {
    if (bytes.next() % 4 == 0) shape = shape_from(bytes);
    line.request(shape, std::uint64_t{bytes.next_16()} << 20U | bytes.next_16(), text);
  }
  for (int i = bytes.next() % 4; i > 0; --i)
    damage(bytes.next() % 2 == 0 ? line.ma : line.slo, bytes);
  put_in_order(line.ma);
  put_in_order(line.slo);
  input.period = shape.period;
  input.end = line.last_time();
  input.ma = std::move(line.ma);
  input.slo = std::move(line.slo);
  return input;
}

/// Reports a finding unless both ways give the same rows, and prints the first row that differs.
inline void require_same_rows(std::string_view way, const std::vector<std::string>& found,
                              const std::vector<std::string>& by_edges) {
  const auto [one, other] =
      std::mismatch(found.begin(), found.end(), by_edges.begin(), by_edges.end());
  if (one == found.end() && other == by_edges.end()) return;
  fmt::print(stderr, "row {} of {} and {}\n", one - found.begin(), found.size(), by_edges.size());
  fmt::print(stderr, "{}: {}\n", way, one == found.end() ? "none" : *one);
  fmt::print(stderr, "by edges: {}\n", other == by_edges.end() ? "none" : *other);
  require(false);
}

}  // namespace biss::fuzz
