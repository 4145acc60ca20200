// The binary export of Saleae Logic: two hostile files, read as one capture.
#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "capture/merge.hpp"
#include "capture/saleae_binary.hpp"
#include "fuzz/capture_check.hpp"
#include "fuzz/capture_seeds.hpp"

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

namespace {

using biss::capture::ByteSource;
using biss::fuzz::SplitMix;

constexpr std::size_t size_bytes = 4;

/// Bytes of its own, in blocks of a size.
class OwnBytes final : public ByteSource {
 public:
  OwnBytes(std::string text, std::size_t block) : text_(std::move(text)), block_(block) {}

  biss::Result<std::size_t, biss::capture::CaptureError> read(std::span<char> into) override {
    const std::size_t count = std::min({into.size(), block_, text_.size() - at_});
    std::copy_n(text_.begin() + static_cast<std::ptrdiff_t>(at_), count, into.begin());
    at_ += count;
    return count;
  }

 private:
  std::string text_;
  std::size_t block_;
  std::size_t at_ = 0;
};

std::size_t first_size(std::string_view input) {
  std::size_t size = 0;
  for (std::size_t i = size_bytes; i-- > 0;)
    size = size << 8U | static_cast<unsigned char>(input[i]);
  return std::min(size, input.size() - size_bytes);
}

// Both files of an input as one capture, in blocks as `bytes` come in.
biss::capture::Opened open_both(std::unique_ptr<ByteSource> bytes) {
  std::string input;
  std::array<char, 4'096> buffer{};
  std::size_t block = 0;
  for (;;) {
    const auto got = bytes->read(buffer);
    if (!got.ok() || *got == 0) break;
    block = std::max(block, *got);
    input.append(buffer.data(), *got);
  }
  if (input.size() < size_bytes) {
    return tl::unexpected(biss::capture::CaptureError{.cause = biss::capture::CaptureCause::empty});
  }
  const std::size_t first = first_size(input);
  std::vector<biss::capture::NamedSource> sources;
  for (const auto& [name, text] : {std::pair{"MA", input.substr(size_bytes, first)},
                                   std::pair{"SLO", input.substr(size_bytes + first)}}) {
    auto opened = biss::capture::open_saleae_binary(std::make_unique<OwnBytes>(text, block), name);
    if (!opened) return opened;
    sources.push_back({std::move(*opened), "x"});
  }
  return std::make_unique<biss::capture::MergedSource>(std::move(sources));
}

void put_double(std::string& text, std::size_t at, double value) {
  const auto bits = std::bit_cast<std::uint64_t>(value);
  for (std::size_t i = 0; i < 8; ++i) text[at + i] = static_cast<char>(bits >> (8 * i));
}

double get_double(const std::string& text, std::size_t at) {
  std::uint64_t bits = 0;
  for (std::size_t i = 8; i-- > 0;) bits = bits << 8U | static_cast<unsigned char>(text[at + i]);
  return std::bit_cast<double>(bits);
}

// A number of a file: most are times. Chunks begin at multiples of four bytes.
std::size_t number_place(const std::string& input, SplitMix& random) {
  constexpr std::size_t header_bytes = 16;
  const std::size_t first = size_bytes + (random() % 2 == 0 ? 0 : first_size(input));
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
      return put_double(input, at, specials[random() % specials.size()]);
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
      return put_double(input, at, get_double(input, at) + step);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view input(reinterpret_cast<const char*>(data), size);
  biss::fuzz::check_reader(input, open_both);
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
