// The event CSV reader on hostile text.
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <utility>

#include "capture/event_csv.hpp"
#include "capture/sampled_csv.hpp"
#include "fuzz/capture_check.hpp"
#include "fuzz/capture_seeds.hpp"
#include "fuzz/capture_words.hpp"
#include "fuzz/token_mutator.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const biss::capture::EventCsvRows rows = biss::capture::event_csv_rows(text);
  biss::fuzz::check_reader(text, [&rows](auto bytes) {
    return biss::capture::open_event_csv(std::move(bytes), biss::capture::default_piece_bytes,
                                         rows);
  });
  return 0;
}

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t max_size, unsigned seed) {
  return biss::fuzz::mutate_capture({data, max_size}, size, seed, ",\n", biss::fuzz::csv_words,
                                    biss::fuzz::seed_text<biss::capture::EventCsvWriter>);
}
