// Prints the table of docs/faults.md.
#include <cstdio>

#include "tests/sim/fault_table.hpp"

int main() {
  using namespace biss::campaign;
  const Outcome outcome = run(documented_line(), documented_cycles);
  std::fputs(fault_table(outcome).c_str(), stdout);
  std::fputs(outcome.complaints.c_str(), stderr);
  return outcome.complaints.empty() ? 0 : 1;
}
