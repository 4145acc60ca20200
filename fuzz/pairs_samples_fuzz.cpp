// Sampled captures as changes of two lines: raw samples, sigrok sessions and DSLogic captures give what
// their edges give, whatever the size of the pieces.
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "capture/open.hpp"
#include "capture/test_capture.hpp"
#include "fuzz/capture_check.hpp"
#include "fuzz/dsl_mutator.hpp"
#include "fuzz/raw_mutator.hpp"
#include "fuzz/require.hpp"
#include "fuzz/sr_mutator.hpp"
#include "fuzz/zip_members.hpp"

namespace {

using namespace biss::fuzz;

// A number derived from the input, so that inputs stay plain captures.
std::uint64_t number_of(std::string_view input) {
  SplitMix mixed{input.size()};
  for (std::size_t i = 0; i < input.size(); i += 1 + input.size() / 16) {
    mixed.state = mixed() ^ static_cast<unsigned char>(input[i]);
  }
  return mixed();
}

// Reads a capture both ways; `open` opens it each time. Pairs of two lines that `number` selects.
template <class Open>
void check_pairs(Open open, std::uint64_t number) {
  const biss::capture::Read read = biss::capture::read_all(open());
  const std::size_t lines = read.lines.size();
  if (lines == 0) return;
  const biss::capture::PairWay way{.ma = static_cast<biss::wire::LineIndex>(number % lines),
                                   .slo = static_cast<biss::wire::LineIndex>(number / 64 % lines),
                                   .blocks = number / 4'096 % 4,
                                   .ahead = 2};
  const biss::capture::PairRead pairs = read_pairs(open(), way);
  require(pairs.by_pieces);
  require(difference(pairs_of_edges(read, way), pairs).empty());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr std::array<std::size_t, 8> piece_sizes{1,   7,     64,     100,
                                                   512, 1'000, 10'000, std::size_t{64} << 20U};
  const std::string_view input(reinterpret_cast<const char*>(data), size);
  const std::uint64_t number = number_of(input);
  biss::capture::OpenOptions options;
  options.piece_bytes = piece_sizes[number >> 32U & 7U];
  options.no_verify = (number >> 40U & 3U) == 0;
  if (input.starts_with("PK")) {
    check_pairs([&] { return open_capture(biss::capture::memory_bytes(input), "x.sr", options); },
                number);
    return 0;
  }
  if (size < raw_header_bytes) return 0;
  options.raw = raw_layout(input);
  const std::string_view samples = input.substr(raw_header_bytes);
  // A binary export of Saleae Logic is not raw samples, whatever its name.
  if (samples.starts_with("<SALEAE>")) return 0;
  const std::size_t block = block_size_of(input);
  check_pairs(
      [&] { return open_capture(biss::capture::memory_bytes(samples, block), "x.raw", options); },
      number);
  return 0;
}

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t max_size, unsigned seed) {
  const std::string_view input(reinterpret_cast<const char*>(data), size);
  if (!input.starts_with("PK")) return mutate_raw(data, size, max_size, seed);
  const bool is_dsl = input.find("metadata") == std::string_view::npos;
  return is_dsl ? mutate_archive<DslMutator>(data, size, max_size, seed)
                : mutate_archive<SrMutator>(data, size, max_size, seed);
}
