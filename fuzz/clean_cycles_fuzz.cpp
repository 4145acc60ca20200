// Request cycles of any shape, with edges moved, lost and added, cut into runs anywhere: the quick
// way gives the rows that reading edge by edge gives.
#include "decode/clean_cycles.hpp"
#include "decode/run_join.hpp"
#include "decode/test_cycle_text.hpp"
#include "decode/test_line.hpp"
#include "fuzz/request_lines.hpp"
#include "fuzz/target.hpp"

namespace {

using namespace biss;
using namespace biss::fuzz;
using namespace biss::decode;

struct Input {
  RequestLines lines;
  MarginSetup margin;
  std::vector<wire::Edge> edges;
  Picoseconds end;
};

// The changes from `begin` on come much later; the ones before, long before zero.
void move_apart(std::vector<LevelChange>& line, Picoseconds begin, std::uint64_t more) {
  for (LevelChange& change : line) {
    std::uint64_t time = static_cast<std::uint64_t>(change.time.count) - (std::uint64_t{1} << 63U);
    if (change.time >= begin) time += more;
    change.time = Picoseconds{static_cast<std::int64_t>(time)};
  }
}

Input input_from(ByteSource& bytes) {
  Input input{.lines = request_lines(bytes)};
  RequestLines& lines = input.lines;
  if (bytes.next() % 2 == 0) {
    const Picoseconds sample = std::max(lines.period / (3 + bytes.next() % 30), picoseconds(1));
    input.margin.resolution = sample;
    input.margin.signal = sample.count % 2 == 0;
    lines.ma = test::sampled(lines.ma, sample);
    lines.slo = test::sampled(lines.slo, sample);
  }
  if (bytes.next() % 16 == 0) {
    const Picoseconds begin = lines.ma[bytes.next_16() % lines.ma.size()].time;
    constexpr std::uint64_t most = ~std::uint64_t{0} - (std::uint64_t{1} << 60U);
    const std::uint64_t high = bytes.next_16();
    const std::uint64_t more = std::min(high << 48U | std::uint64_t{bytes.next_16()} << 16U, most);
    for (auto* const line : {&lines.ma, &lines.slo}) move_apart(*line, begin, more);
    lines.end = std::max(lines.ma.back().time, lines.slo.back().time);
  }
  input.edges = lines.edges();
  input.end = lines.end + microseconds(bytes.next_16());
  return input;
}

template <class Push>
std::vector<std::string> rows(const Input& input, Push push) {
  std::vector<std::string> texts;
  Decoder decoder(CycleReader(input.lines.format, input.lines.timing, input.margin),
                  [&](const Cycle& cycle) { texts.push_back(test::text_of(cycle)); });
  push(decoder);
  decoder.finish(input.end);
  return texts;
}

void push_runs(const Input& input, ByteSource& bytes, Decoder& decoder) {
  CleanCycleFinder finder(input.lines.format, input.lines.timing, input.margin);
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
  require_same_rows("by runs", found, expected);
  return 0;
}
