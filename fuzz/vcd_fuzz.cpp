// The VCD reader on hostile text.
#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <utility>

#include "capture/vcd.hpp"
#include "fuzz/capture_check.hpp"
#include "fuzz/capture_seeds.hpp"
#include "fuzz/token_mutator.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  biss::fuzz::check_reader(text,
                           [](auto bytes) { return biss::capture::open_vcd(std::move(bytes)); });
  return 0;
}

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t max_size, unsigned seed) {
  static constexpr std::array<std::string_view, 32> words{"$timescale 1fs $end",
                                                          "$timescale 100 us $end",
                                                          "$var wire 1 ! MA $end",
                                                          "$var wire 1 abc SLO $end",
                                                          "$var wire 8 ## pos [7:0] $end",
                                                          "$var real 64 $$ v $end",
                                                          "$scope module top $end",
                                                          "$upscope $end",
                                                          "$enddefinitions $end",
                                                          "$dumpvars",
                                                          "$dumpoff",
                                                          "$end",
                                                          "$comment x # 1! $end",
                                                          "$comment",
                                                          "0!",
                                                          "1!",
                                                          "0\"",
                                                          "1\"",
                                                          "x!",
                                                          "Z\"",
                                                          "b0 !",
                                                          "b1 \"",
                                                          "b1010 ##",
                                                          "r1.5 $$",
                                                          "0abc",
                                                          "#0",
                                                          "#9223372036854775807",
                                                          "#18446744073709551615",
                                                          "#",
                                                          "#99999999999999999999",
                                                          "\n",
                                                          " "};
  return biss::fuzz::mutate_capture({data, max_size}, size, seed, " \n", words,
                                    biss::fuzz::seed_text<biss::capture::VcdWriter>);
}
