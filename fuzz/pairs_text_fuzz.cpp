// VCD and event CSV in pieces of any size, on hostile text: the same changes, end and error as in
// blocks.
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

#include "capture/event_csv.hpp"
#include "capture/sampled_csv.hpp"
#include "capture/test_capture.hpp"
#include "capture/test_pairs.hpp"
#include "capture/vcd.hpp"
#include "fuzz/capture_check.hpp"
#include "fuzz/capture_seeds.hpp"
#include "fuzz/capture_words.hpp"
#include "fuzz/require.hpp"
#include "fuzz/token_mutator.hpp"

namespace {

bool is_vcd(std::string_view text) { return text.starts_with('$'); }

// Sizes, lines and what is read in blocks before follow from the text.
template <class Open>
void check(Open open, std::string_view text) {
  using namespace biss::capture;
  const Read read = read_all(open(memory_bytes(text), default_piece_bytes));
  if (read.lines.size() < 2) return;
  biss::fuzz::SplitMix random{biss::fuzz::block_size_of(text) * 31 + text.size()};
  for (int i = 0; i < 2; ++i) {
    PairWay way{.blocks = random() % 3, .ahead = 1 + random() % 4};
    way.ma = static_cast<biss::wire::LineIndex>(random() % read.lines.size());
    way.slo = static_cast<biss::wire::LineIndex>(random() % read.lines.size());
    const std::size_t block = random() % 2 == 0 ? 1 + random() % 700 : one_block;
    const std::size_t piece = random() % 4 == 0 ? default_piece_bytes : 1 + random() % 700;
    const PairRead pairs = read_pairs(open(memory_bytes(text, block), piece), way);
    if (!pairs.by_pieces) continue;
    biss::fuzz::require(difference(pairs_of_edges(read, way), pairs).empty());
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  if (is_vcd(text)) {
    check(biss::capture::open_vcd, text);
    return 0;
  }
  const biss::capture::EventCsvRows rows = biss::capture::event_csv_rows(text);
  check(
      [&rows](auto bytes, auto piece) {
        return biss::capture::open_event_csv(std::move(bytes), piece, rows);
      },
      text);
  return 0;
}

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t max_size, unsigned seed) {
  using namespace biss::fuzz;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  if (is_vcd(text)) {
    return mutate_capture({data, max_size}, size, seed, " \n", vcd_words,
                          seed_text<biss::capture::VcdWriter>);
  }
  return mutate_capture({data, max_size}, size, seed, ",\n", csv_words,
                        seed % 3 == 0 ? saleae_seed : seed_text<biss::capture::EventCsvWriter>);
}
