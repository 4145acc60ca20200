// A measured function. Each has its own source in rows/, as in a firmware that calls it once, and
// one line that defines it:
//
//   BISS_ROW(crc6, "CRC6 of 28 bits", crc) { return engine(s.value, 28); }
//
// The line has the name, the title in the table, the function that prepares the sample
// (prepare.hpp), and the call for sample `s`.
#pragma once

#include <cstdint>

#include "firmware/cost/prepare.hpp"
#include "firmware/cost/sample.hpp"

namespace cost {

using Run = std::uint64_t (*)(const Sample&);

/// The default number of samples of a row.
inline constexpr std::uint32_t usual_samples = 256;

struct Row {
  const char* name;
  const char* title;
  void (*prepare)(Sample&, prepare::Random&);
  Run run;
  std::uint32_t samples;
};

}  // namespace cost

// The record is in a section that only the measuring image keeps. An image of the function alone
// drops it and shows the function's size.
#define BISS_ROW(row, row_title, maker) BISS_ROW_TIMES(row, row_title, maker, cost::usual_samples)
#define BISS_ROW_TIMES(row, row_title, maker, times)                      \
  extern "C" std::uint64_t cost_##row(const cost::Sample&);               \
  namespace {                                                             \
  [[gnu::used, gnu::section("biss_rows")]] constexpr cost::Row row_##row{ \
      #row, row_title, cost::prepare::maker, cost_##row, times};          \
  }                                                                       \
  std::uint64_t cost_##row([[maybe_unused]] const cost::Sample& s)
