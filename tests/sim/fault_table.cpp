#include "tests/sim/fault_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <span>

#include "biss/catalogue/renishaw.hpp"
#include "biss/timing/cable.hpp"

namespace biss::campaign {

namespace {

// A status has a column if it occurs; `ok` has one in the first table.
std::vector<std::size_t> used_failures(const Outcome& outcome) {
  std::vector<std::size_t> used;
  for (std::size_t s = 1; s < cycle_status_count; ++s) {
    bool any = outcome.behind.statuses[s] != 0;
    for (const Tally& tally : outcome.alone) any = any || tally.statuses[s] != 0;
    if (any) used.push_back(s);
  }
  return used;
}

struct Line {
  std::string name;
  std::string injected;
  const Tally* tally;
};

std::vector<Line> lines_of(const Outcome& outcome) {
  std::vector<Line> lines;
  for (std::size_t k = 0; k < sim::line_fault_kind_count; ++k) {
    lines.push_back({fmt::format("`{}`", sim::fault_list[k].name),
                     std::to_string(outcome.injected[k]), &outcome.alone[k]});
  }
  lines.push_back({"several", "", &outcome.several});
  lines.push_back({"only in the cycle before", "", &outcome.behind});
  lines.push_back({"none: undamaged", "", &outcome.undamaged});
  return lines;
}

std::string cell(std::uint64_t count) { return count == 0 ? "  |" : fmt::format(" {} |", count); }

// As many statuses as fit into a table of 100 columns.
std::string status_table(const std::vector<Line>& lines, std::span<const std::size_t> statuses) {
  std::string text = "\n| fault |";
  std::string rule = "|---|";
  for (const std::size_t s : statuses) {
    text += fmt::format(" `{}` |", name_of(static_cast<CycleStatus>(s)));
    rule += "---:|";
  }
  text += "\n" + rule + "\n";
  for (const Line& line : lines) {
    text += "| " + line.name + " |";
    for (const std::size_t s : statuses) text += cell(line.tally->statuses[s]);
    text += '\n';
  }
  return text;
}

std::string place_text(const sim::FaultPlaces& places, const char* unit) {
  if (places.empty()) return "";
  return fmt::format("{} {}", places.whole ? "a whole" : "a point in a", unit);
}

}  // namespace

sim::LineSetup documented_line() {
  constexpr std::uint64_t share = (std::uint64_t{12} << 32U) / 1000;
  const CatalogueEntry& entry = renishaw_encoders[1];
  sim::LineSetup setup;
  setup.format = entry.frame_format();
  setup.timing = entry.timing;
  setup.clock = megahertz(10);
  setup.internal_delay = entry.timing.internal_delay_max;
  setup.ma_delay = setup.slo_delay = cable_delay(metres(20)) / 2;
  setup.motion = sim::MotionKind::random;
  setup.seed = 3;
  setup.faults = all_faults(share);
  return setup;
}

std::string fault_table(const Outcome& outcome) {
  const std::vector<Line> lines = lines_of(outcome);
  std::string text =
      "| fault | cycles | of these alone | `ok` | **wrong** | wrong, nE = 0 | no row |\n"
      "|---|---:|---:|---:|---:|---:|---:|\n";
  for (const Line& line : lines) {
    const Tally& tally = *line.tally;
    text += fmt::format("| {} | {} | {} |", line.name, line.injected, tally.cycles);
    for (const std::uint64_t count :
         {tally.right(), tally.wrong, tally.wrong_error, tally.missing}) {
      text += cell(count);
    }
    text += '\n';
  }
  constexpr std::size_t columns = 5;
  const std::vector<std::size_t> used = used_failures(outcome);
  for (std::size_t k = 0; k < used.size(); k += columns) {
    text += status_table(lines, std::span(used).subspan(k, std::min(columns, used.size() - k)));
  }
  return text;
}

std::string fault_list(std::size_t first, std::size_t last) {
  const bool simulated = first < sim::simulated_fault_count;
  const bool wrong_frames = simulated && first >= sim::line_fault_kind_count;
  std::string text = "| kind | effect |";
  std::string rule = "|---|---|";
  if (simulated) {
    text += " duration |";
    rule += "---|";
  }
  if (wrong_frames) {
    text += " IEC 61784-3 |";
    rule += "---|";
  }
  text += "\n" + rule + "\n";
  for (std::size_t k = first; k < last; ++k) {
    const sim::FaultEntry& entry = sim::fault_list[k];
    text += fmt::format("| `{}` | {} |", entry.name, entry.effect);
    if (simulated) text += fmt::format(" {} |", text_of(entry.extent));
    if (wrong_frames) text += fmt::format(" {} |", name_of(*entry.error));
    text += '\n';
  }
  return text;
}

std::string place_table() {
  const sim::NominalCycle nominal = sim::Line(documented_line()).nominal();
  std::string text = "| kind | `bit` | `clock` |\n|---|---|---|\n";
  for (std::size_t k = 0; k < sim::simulated_fault_count; ++k) {
    const sim::FaultEntry& entry = sim::fault_list[k];
    if (!sim::has_place(entry.kind)) continue;
    text += fmt::format("| `{}` | {} | {} |\n", entry.name,
                        place_text(places_of(entry.kind, sim::PlaceUnit::bit, nominal), "bit"),
                        place_text(places_of(entry.kind, sim::PlaceUnit::clock, nominal), "clock"));
  }
  return text;
}

}  // namespace biss::campaign
