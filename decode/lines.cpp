#include "decode/lines.hpp"

#include <algorithm>
#include <array>
#include <cctype>

namespace biss::decode {

namespace {

using Index = std::optional<wire::LineIndex>;

// In order of preference. The first of each is the standard's name, the others are what people
// write on their probes.
constexpr std::array<std::string_view, 12> ma_names{
    "ma", "ma+", "ma_p", "map", "clk", "clock", "sck", "sclk", "clk+", "clk_p", "ma_clk", "mclk"};
constexpr std::array<std::string_view, 14> slo_names{"slo",   "sl",     "slo+", "sl+", "slo_p",
                                                     "sl_p",  "data",   "dat",  "sdo", "miso",
                                                     "data+", "data_p", "sdat", "do"};

constexpr std::size_t busiest_lines = 8;
constexpr std::size_t edges_to_try = 40'000;

std::string lower(std::string_view text) {
  std::string out(text);
  for (char& c : out) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return out;
}

std::string_view last_part(std::string_view name) { return name.substr(name.rfind('.') + 1); }

Index named(const std::vector<std::string>& names, std::string_view wanted) {
  const std::string key = lower(wanted);
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i] == wanted) return static_cast<wire::LineIndex>(i);
  }
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (lower(names[i]) == key || lower(last_part(names[i])) == key) {
      return static_cast<wire::LineIndex>(i);
    }
  }
  return std::nullopt;
}

template <std::size_t N>
Index usual(const std::vector<std::string>& names, const std::array<std::string_view, N>& wanted) {
  for (const std::string_view name : wanted) {
    if (const Index found = named(names, name)) return found;
  }
  return std::nullopt;
}

// The busiest lines, busiest first, and how often each moved.
std::vector<wire::LineIndex> moving_lines(std::size_t lines, std::span<const wire::Edge> edges) {
  std::vector<std::size_t> moves(lines, 0);
  for (const wire::Edge& edge : edges) ++moves[edge.line];
  std::vector<wire::LineIndex> moving;
  for (std::size_t i = 0; i < lines; ++i) {
    // The first edge of a line only tells its level.
    if (moves[i] > 1) moving.push_back(static_cast<wire::LineIndex>(i));
  }
  std::stable_sort(moving.begin(), moving.end(),
                   [&](auto a, auto b) { return moves[a] > moves[b]; });
  moving.resize(std::min(moving.size(), busiest_lines));
  return moving;
}

// How much a pair looks like MA and SLO: good frames count most, then cycles with a START.
std::size_t score(const Lines& lines, std::span<const wire::Edge> edges,
                  const CycleReader& reader) {
  std::size_t sum = 0;
  Decoder decoder(reader, [&](const Cycle& cycle) {
    if (is_good(cycle.status)) sum += cycle.frame ? 1000U : 20U;
    if (cycle.status == CycleStatus::crc) sum += 10;
    if (cycle.ack) ++sum;
  });
  std::vector<wire::Edge> pair;
  for (const wire::Edge& edge : edges) {
    if (edge.line != lines.ma && edge.line != lines.slo) continue;
    pair.push_back(edge);
    if (pair.size() == edges_to_try) break;
  }
  decoder.push(pair, lines);
  decoder.finish(pair.empty() ? Picoseconds{} : pair.back().time);
  return sum;
}

Result<FoundLines, LineProblem> by_behaviour(const std::vector<std::string>& names,
                                             std::span<const wire::Edge> beginning, Index ma,
                                             Index slo, const CycleReader& reader) {
  const std::vector<wire::LineIndex> moving = moving_lines(names.size(), beginning);
  const std::vector<wire::LineIndex> clocks = ma ? std::vector{*ma} : moving;
  const std::vector<wire::LineIndex> data = slo ? std::vector{*slo} : moving;
  if (moving.size() < 2 && !(ma && slo)) return failure(LineProblem::too_few_lines);
  FoundLines best{.lines = {}, .how = LineChoice::by_behaviour};
  std::size_t best_score = 0;
  for (const wire::LineIndex clock : clocks) {
    for (const wire::LineIndex datum : data) {
      if (clock == datum) continue;
      const Lines lines{clock, datum};
      const std::size_t points = score(lines, beginning, reader);
      if (points <= best_score) continue;
      best_score = points;
      best.lines = lines;
    }
  }
  if (best_score == 0) return failure(LineProblem::nothing_behaves);
  return best;
}

}  // namespace

Result<FoundLines, LineProblem> find_lines(const std::vector<std::string>& names,
                                           std::span<const wire::Edge> beginning,
                                           std::string_view ma, std::string_view slo,
                                           const CycleReader& reader) {
  Index ma_line = ma.empty() ? Index{} : named(names, ma);
  if (!ma.empty() && !ma_line) return failure(LineProblem::no_such_ma);
  Index slo_line = slo.empty() ? Index{} : named(names, slo);
  if (!slo.empty() && !slo_line) return failure(LineProblem::no_such_slo);
  const bool told = ma_line && slo_line;
  if (!ma_line) ma_line = usual(names, ma_names);
  if (!slo_line) slo_line = usual(names, slo_names);
  if (!ma_line || !slo_line) return by_behaviour(names, beginning, ma_line, slo_line, reader);
  if (*ma_line == *slo_line) return failure(LineProblem::same_line);
  const Lines lines{*ma_line, *slo_line};
  return FoundLines{
      lines, told ? LineChoice::told : LineChoice::by_name,
      score(lines, beginning, reader) == 0 && score({lines.slo, lines.ma}, beginning, reader) != 0};
}

}  // namespace biss::decode
