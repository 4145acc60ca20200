// Prints the tables of lab/reports/flips.md.
#include <cstdio>

#include "tests/exhaustive/flip_table.hpp"

int main() { std::fputs(exhaustive::flip_tables().c_str(), stdout); }
