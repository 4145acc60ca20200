// The reader of DSLogic captures on hostile archives, headers and blocks.
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string_view>
#include <utility>

#include "capture/dsl.hpp"
#include "fuzz/capture_check.hpp"
#include "fuzz/dsl_mutator.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view archive(reinterpret_cast<const char*>(data), size);
  biss::fuzz::check_reader(archive, [](std::unique_ptr<biss::capture::ByteSource> bytes) {
    return biss::capture::open_dsl(std::move(bytes));
  });
  return 0;
}

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t max_size, unsigned seed) {
  return biss::fuzz::mutate_archive<biss::fuzz::DslMutator>(data, size, max_size, seed);
}
