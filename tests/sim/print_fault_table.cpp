// Prints the tables of docs/faults.md and lab/reports/faults.md.
#include <cstdio>

#include "tests/sim/fault_table.hpp"

int main() {
  using namespace biss;
  using namespace biss::campaign;
  const std::string lists[] = {fault_list(0, sim::line_fault_kind_count),
                               fault_list(sim::line_fault_kind_count, sim::simulated_fault_count),
                               fault_list(sim::simulated_fault_count, sim::line_only_fault_first),
                               fault_list(sim::line_only_fault_first, sim::fault_kind_count),
                               place_table()};
  for (const std::string& list : lists) std::printf("%s\n", list.c_str());
  const Outcome outcome = run(documented_line(), documented_cycles);
  std::fputs(fault_table(outcome).c_str(), stdout);
  std::fputs(outcome.complaints.c_str(), stderr);
  return outcome.complaints.empty() ? 0 : 1;
}
