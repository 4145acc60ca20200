// biss_timing_document FOLDER: prints docs/timing.md, made from the features in the folder.
#include <cstdio>
#include <exception>

#include "tests/timing/feature.hpp"

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  try {
    std::fputs(timing_test::document_of(timing_test::read_features(argv[1])).c_str(), stdout);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "biss_timing_document: %s\n", error.what());
    return 1;
  }
  return 0;
}
