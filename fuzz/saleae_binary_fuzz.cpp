// The binary export of Saleae Logic: two hostile files, read as one capture.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>

#include "capture/little_endian.hpp"
#include "capture/saleae_binary.hpp"
#include "fuzz/capture_check.hpp"
#include "fuzz/capture_seeds.hpp"
#include "fuzz/two_files.hpp"

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

namespace {

using biss::fuzz::SplitMix;

void replace_double(std::string& text, std::size_t at, double value) {
  std::string bytes;
  biss::capture::put_double(bytes, value);
  text.replace(at, bytes.size(), bytes);
}

// A number of a file: most are times. Chunks begin at multiples of four bytes.
std::size_t number_place(const std::string& input, SplitMix& random) {
  constexpr std::size_t header_bytes = 16;
  const std::size_t first = biss::fuzz::first_size_bytes +
                            (random() % 2 == 0 ? 0 : biss::fuzz::split_files(input).first.size());
  const std::size_t begin = std::min(first + header_bytes, input.size() - 8);
  return begin + 4 * (random() % ((input.size() - 8 - begin) / 4 + 1));
}

void change(std::string& input, SplitMix& random) {
  using Limits = std::numeric_limits<double>;
  static constexpr std::array specials{Limits::quiet_NaN(),
                                       Limits::infinity(),
                                       -Limits::infinity(),
                                       Limits::max(),
                                       -0.0,
                                       0.0,
                                       Limits::denorm_min(),
                                       -1e-6,
                                       9'223'372.0,
                                       1e8};
  const std::size_t at = number_place(input, random);
  switch (random() % 8) {
    case 0:
      return replace_double(input, at, specials[random() % specials.size()]);
    case 1:
      input[at] = static_cast<char>(random() % 4);
      return;
    case 2:
      // Version or type of the first file, or the size of it.
      input[random() % 20] = static_cast<char>(random() % 3);
      return;
    default:
      // A little earlier or later: mostly still in order.
      const double step = static_cast<double>(random() % 200) * 1e-9 - 100e-9;
      return replace_double(input, at, biss::capture::get_double(input.data() + at) + step);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view input(reinterpret_cast<const char*>(data), size);
  biss::fuzz::check_blocks(input, [input](std::size_t block) {
    return biss::fuzz::open_files(biss::fuzz::split_files(input), [block](std::string_view bytes) {
      return biss::capture::open_saleae_binary(biss::capture::memory_bytes(bytes, block), "line");
    });
  });
  return 0;
}

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t max_size, unsigned seed) {
  constexpr std::size_t smallest_capture = 100;
  SplitMix random{seed};
  std::string input(reinterpret_cast<const char*>(data), size);
  if (size < smallest_capture || random() % 8 == 0) {
    input = biss::fuzz::saleae_binary_seed(random());
  }
  if (random() % 16 == 0) {
    input.resize(std::min(input.size(), max_size));
    std::copy(input.begin(), input.end(), data);
    return LLVMFuzzerMutate(data, input.size(), max_size);
  }
  for (std::uint64_t times = 1 + random() % 3; times != 0; --times) change(input, random);
  if (random() % 16 == 0) input.resize(input.size() - random() % 40);
  const std::size_t kept = std::min(input.size(), max_size);
  std::copy_n(input.begin(), kept, data);
  return kept;
}
