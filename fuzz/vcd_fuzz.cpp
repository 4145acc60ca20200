// The VCD reader on hostile text.
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <utility>

#include "capture/vcd.hpp"
#include "fuzz/capture_check.hpp"
#include "fuzz/capture_seeds.hpp"
#include "fuzz/capture_words.hpp"
#include "fuzz/token_mutator.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  biss::fuzz::check_reader(text,
                           [](auto bytes) { return biss::capture::open_vcd(std::move(bytes)); });
  return 0;
}

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t max_size, unsigned seed) {
  return biss::fuzz::mutate_capture({data, max_size}, size, seed, " \n", biss::fuzz::vcd_words,
                                    biss::fuzz::seed_text<biss::capture::VcdWriter>);
}
