// Digital CSV of Saleae Logic: the reader on hostile text, the writer on its result.
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "capture/event_csv.hpp"
#include "fuzz/capture_check.hpp"
#include "fuzz/capture_seeds.hpp"
#include "fuzz/require.hpp"
#include "fuzz/token_mutator.hpp"

namespace {

using biss::fuzz::Read;
using biss::fuzz::require;

// Rows of Saleae have a level for every line, X before the first change.
std::vector<biss::wire::Edge> known_edges(const Read& read) {
  std::vector<biss::wire::Edge> known;
  known.reserve(read.edges.size());
  std::vector<bool> began(read.lines.size());
  for (const biss::wire::Edge& edge : read.edges) {
    if (edge.level != biss::wire::Level::unknown) began[edge.line] = true;
    if (began[edge.line]) known.push_back(edge);
  }
  return known;
}

void check_round_trip(const Read& read) {
  if (read.lines.empty()) return;
  std::string written;
  biss::capture::StringSink sink(written);
  biss::capture::EventCsvWriter writer(read.lines, sink, biss::capture::CsvDialect::saleae);
  require(writer.write(read.edges).ok() && writer.finish(read.end).ok());
  const Read back =
      biss::fuzz::read_checked(biss::capture::open_event_csv(biss::capture::memory_bytes(written)));
  require(back.lines.size() == read.lines.size());
  require(known_edges(back) == known_edges(read));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  check_round_trip(biss::fuzz::check_reader(
      text, [](auto bytes) { return biss::capture::open_event_csv(std::move(bytes)); }));
  return 0;
}

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t max_size, unsigned seed) {
  static constexpr std::array<std::string_view, 18> words{
      "Time [s]",  "Time[s]", "Channel 0",      "MA",  "\"SLO\"", "0", "1",    "X",   "",
      "-0.000001", "2e-08",   "9223372.036855", "1e9", "0.5",     ",", "\r\n", " 1 ", "nan"};
  return biss::fuzz::mutate_capture({data, max_size}, size, seed, ",\n", words,
                                    biss::fuzz::saleae_seed);
}
