#include "tests/sim/fault_table.hpp"

#include <fmt/format.h>

#include "biss/catalogue/renishaw.hpp"
#include "biss/timing/cable.hpp"

namespace biss::campaign {

namespace {

// A status has a column where it occurs at all.
std::vector<std::size_t> used_statuses(const Outcome& outcome) {
  std::vector<std::size_t> used;
  for (std::size_t s = 0; s < decode::cycle_status_count; ++s) {
    bool any = outcome.behind.statuses[s] != 0;
    for (const Tally& tally : outcome.alone) any = any || tally.statuses[s] != 0;
    if (any) used.push_back(s);
  }
  return used;
}

std::string row(const std::string& name, const std::string& strikes, const Tally& tally,
                const std::vector<std::size_t>& statuses) {
  std::string text = fmt::format("| {} | {} | {} |", name, strikes, tally.cycles);
  for (const std::size_t s : statuses) {
    text += tally.statuses[s] == 0 ? "  |" : fmt::format(" {} |", tally.statuses[s]);
  }
  for (const std::uint64_t count : {tally.missing, tally.wrong_error, tally.wrong}) {
    text += count == 0 ? "  |" : fmt::format(" {} |", count);
  }
  return text + "\n";
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
  const std::vector<std::size_t> statuses = used_statuses(outcome);
  std::string text = "| fault | cycles struck | of these alone |";
  std::string rule = "|---|---:|---:|";
  for (const std::size_t s : statuses) {
    text += fmt::format(" `{}` |", decode::name_of(static_cast<decode::CycleStatus>(s)));
    rule += "---:|";
  }
  text += " no row | wrong, nE = 0 | **wrong** |\n" + rule + "---:|---:|---:|\n";
  for (std::size_t k = 0; k < sim::line_fault_kind_count; ++k) {
    text += row(fmt::format("`{}`", sim::fault_list[k].name), std::to_string(outcome.strikes[k]),
                outcome.alone[k], statuses);
  }
  text += row("several", "", outcome.several, statuses);
  text += row("none, but in the cycle before", "", outcome.behind, statuses);
  return text + row("none: undamaged", "", outcome.undamaged, statuses);
}

}  // namespace biss::campaign
