// Request cycles of any shape, with edges moved, lost and added, cut into runs anywhere: the quick
// way gives the rows that reading edge by edge gives.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "decode/clean_cycles.hpp"
#include "decode/run_join.hpp"
#include "decode/test_cycle_text.hpp"
#include "decode/test_line.hpp"
#include "fuzz/byte_source.hpp"
#include "fuzz/require.hpp"

namespace {

using namespace biss;
using namespace biss::decode;
using biss::fuzz::ByteSource;

test::Shape shape_from(ByteSource& bytes) {
  test::Shape shape;
  shape.period = picoseconds(20'000 + std::int64_t{bytes.next_16()} * 32);
  shape.high_percent = 30 + bytes.next() % 41;
  shape.line_delay = picoseconds(std::int64_t{bytes.next_16()} * 16);
  shape.timeout = nanoseconds(std::int64_t{bytes.next()} * 100);
  shape.gap = nanoseconds(10 + std::int64_t{bytes.next()} * 50);
  shape.extra_clocks = bytes.next() % 6 - 1;
  shape.ack_clocks = static_cast<std::uint16_t>(1 + bytes.next() % 40);
  shape.ending = static_cast<test::Ending>(bytes.next() % 3);
  shape.jitter_percent = bytes.next() % 16;
  return shape;
}

// Any edge is moved up to its neighbours, lost, or becomes a pulse.
void damage(std::vector<LevelChange>& line, ByteSource& bytes) {
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
      test::TestLine::add_pulse(line, line[at].time,
                                picoseconds(1 + std::int64_t{bytes.next_16()} * 8));
  }
}

// What a capture delivers: times never fall, and each change is one.
void put_in_order(std::vector<LevelChange>& line) {
  std::stable_sort(line.begin(), line.end(),
                   [](const LevelChange& a, const LevelChange& b) { return a.time < b.time; });
  line.erase(
      std::unique(line.begin(), line.end(),
                  [](const LevelChange& a, const LevelChange& b) { return a.level == b.level; }),
      line.end());
}

struct Input {
  std::optional<FrameFormat> format;
  DeviceTiming timing;
  MarginSetup margin;
  std::vector<wire::Edge> edges;
  Picoseconds end;
};

Input input_from(ByteSource& bytes) {
  constexpr std::array formats{"pos26,nE,nW,crc6", "pos9,crc5", "pos36,nE,nW,crc6",
                               "pos36,nE,nW,crc6+pos28,nE,nW,lc6,crc16;cds0"};
  Input input;
  const std::string_view text = formats[bytes.next() % formats.size()];
  const unsigned choice = bytes.next();
  if (choice % 8 != 7) input.format = *parse_format(text);
  input.timing.clock_constant = choice % 2 == 0;
  test::TestLine line(bytes.next());
  test::Shape shape = shape_from(bytes);
  const int cycles = 2 + bytes.next() % 5;
  for (int i = 0; i < cycles; ++i) {
    if (bytes.next() % 4 == 0) shape = shape_from(bytes);
    line.request(shape, std::uint64_t{bytes.next_16()} << 20U | bytes.next_16(), text);
  }
  for (int i = bytes.next() % 4; i > 0; --i)
    damage(bytes.next() % 2 == 0 ? line.ma : line.slo, bytes);
  if (bytes.next() % 2 == 0) {
    const Picoseconds sample = std::max(shape.period / (3 + bytes.next() % 30), picoseconds(1));
    input.margin.resolution = sample;
    line.ma = test::sampled(line.ma, sample);
    line.slo = test::sampled(line.slo, sample);
  }
  put_in_order(line.ma);
  put_in_order(line.slo);
  input.edges = line.edges();
  input.end = line.last_time() + microseconds(bytes.next_16());
  return input;
}

template <class Push>
std::vector<std::string> rows(const Input& input, Push push) {
  std::vector<std::string> texts;
  Decoder decoder(CycleReader(input.format, input.timing, input.margin),
                  [&](const Cycle& cycle) { texts.push_back(test::text_of(cycle)); });
  push(decoder);
  decoder.finish(input.end);
  return texts;
}

void push_runs(const Input& input, ByteSource& bytes, Decoder& decoder) {
  CleanCycleFinder finder(input.format, input.timing, input.margin);
  std::vector<CleanCycle> clean;
  RunJoin join(finder, decoder);
  const std::size_t usual = 1 + bytes.next_16() % 2000;
  for (std::size_t at = 0; at < input.edges.size();) {
    const std::size_t end = std::min(input.edges.size(), at + usual + bytes.next());
    if (bytes.next() % 4 == 1) {
      join.push(std::span(input.edges).subspan(at, end - at), {0, 1});
      at = end;
      continue;
    }
    std::array<std::vector<std::int64_t>, 2> times;
    std::array<bool, 2> first{};
    for (; at < end; ++at) {
      const wire::Edge& edge = input.edges[at];
      if (times[edge.line].empty()) first[edge.line] = edge.level == wire::Level::high;
      times[edge.line].push_back(edge.time.count);
    }
    const PairRun run{{times[0], first[0]}, {times[1], first[1]}};
    finder.find(run, clean);
    join.push(run, clean);
  }
  join.flush();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  ByteSource bytes(data, size);
  const Input input = input_from(bytes);
  const auto expected = rows(input, [&](Decoder& decoder) { decoder.push(input.edges, {0, 1}); });
  const auto found = rows(input, [&](Decoder& decoder) { push_runs(input, bytes, decoder); });
  biss::fuzz::require(found == expected);
  return 0;
}
