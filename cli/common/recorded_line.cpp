#include "cli/common/recorded_line.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>

#include "cli/common/found_lines.hpp"
#include "cli/common/message.hpp"
#include "decode/lines.hpp"
#include "decode/times.hpp"

namespace biss::cli {

namespace {

// `MA` behind any scope, in any case.
bool is_named_ma(const std::string& name) {
  const std::string last = name.substr(name.rfind('.') + 1);
  return last.size() == 2 && std::toupper(static_cast<unsigned char>(last[0])) == 'M' &&
         std::toupper(static_cast<unsigned char>(last[1])) == 'A';
}

}  // namespace

ExitStatus RecordedLine::open(const std::string& file, const std::string& ma,
                              const std::string& slo, const RawSamples& raw, bool needs_slo) {
  const ExitStatus opened = input_.open({file}, ma, slo, raw);
  if (opened != ExitStatus::done) return opened;
  const auto beginning = input_.look_at_beginning(edges_at_beginning);
  if (!input_.error().empty()) return fail(ExitStatus::io, input_.error());
  if (needs_slo || !find_ma(ma)) {
    const decode::CycleReader reader(std::nullopt, DeviceTiming{});
    const auto found =
        find_lines(input_.lines(), beginning, input_.line_of(ma), input_.line_of(slo), reader);
    if (!found.ok()) {
      const bool told = !ma.empty() || !slo.empty();
      return fail(told ? ExitStatus::usage : ExitStatus::data_failed,
                  fmt::format("{}: {} not found; name {} of {}", input_.name(),
                              needs_slo ? "MA and SLO" : "MA",
                              needs_slo ? "them with --ma and --slo" : "it with --ma",
                              fmt::join(input_.lines(), ", ")));
    }
    lines_ = found->lines;
  }
  guess_clock(beginning);
  return ExitStatus::done;
}

bool RecordedLine::find_ma(const std::string& ma) {
  const auto& names = input_.lines();
  const auto at = ma.empty() ? std::find_if(names.begin(), names.end(), is_named_ma)
                             : std::find(names.begin(), names.end(), input_.line_of(ma));
  const bool only_one = ma.empty() && names.size() == 1;
  if (at == names.end() && !only_one) return false;
  lines_.ma = only_one ? 0 : static_cast<wire::LineIndex>(at - names.begin());
  return true;
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

}  // namespace biss::cli
