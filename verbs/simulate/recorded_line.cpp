#include "verbs/simulate/recorded_line.hpp"

#include <algorithm>
#include <utility>

#include "decode/times.hpp"
#include "verbs/common/host.hpp"

namespace biss::verbs {

ExitStatus RecordedLine::open(const std::string& file, const std::string& ma,
                              const std::string& slo, const RawSamples& raw, bool needs_slo) {
  InputArguments arguments{.files = {file}, .ma = ma, .slo = slo, .raw = raw};
  auto captures = list_captures(arguments, host_);
  if (!captures) return captures.error();
  const ExitStatus opened = input_.open(std::move(captures->front()), arguments);
  if (opened != ExitStatus::done) return opened;
  const decode::CycleReader reader(std::nullopt, DeviceTiming{});
  if (needs_slo) {
    const auto found = input_.find_lines(reader);
    if (!found) return found.error();
    lines_ = found->front().lines;
  } else {
    const auto found = input_.find_ma(reader);
    if (!found) return found.error();
    lines_.ma = *found;
  }
  guess_clock(input_.beginning());
  return input_.error().empty() ? ExitStatus::done : host_.fail(ExitStatus::io, input_.error());
}

void RecordedLine::guess_clock(std::span<const wire::Edge> beginning) {
  Picoseconds shortest = period_of(biss_clock_min);
  std::optional<Picoseconds> last;
  for (const wire::Edge& edge : beginning) {
    if (edge.line != lines_.ma) continue;
    if (last) shortest = std::min(shortest, 2 * decode::elapsed(*last, edge.time));
    last = edge.time;
  }
  clock_ = std::clamp(rate_of(shortest), biss_clock_min, biss_clock_max);
}

}  // namespace biss::verbs
