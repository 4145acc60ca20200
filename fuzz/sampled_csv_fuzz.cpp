// CSV of oscilloscopes, sigrok and DSView: the readers on hostile text.
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>

#include "capture/open.hpp"
#include "capture/sampled_csv.hpp"
#include "fuzz/capture_check.hpp"
#include "fuzz/require.hpp"
#include "fuzz/scope_seeds.hpp"
#include "fuzz/token_mutator.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using biss::capture::Likeness;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  biss::capture::OpenOptions options;
  // Some with a threshold, some with a differential.
  if (size % 8 == 1) options.analog.threshold = {{1'700'000'000}, {200'000'000}};
  if (size % 16 == 2) options.analog.differentials = {{"CH1-CH2", "MA"}};
  biss::fuzz::check_reader(text, [&](std::unique_ptr<biss::capture::ByteSource> bytes) {
    return biss::capture::open_capture(std::move(bytes), "x.csv", options);
  });
  // The result for the beginning does not change when more of the file is read.
  std::optional<Likeness> likeness;
  for (std::size_t end = size < 512 ? 1 : size; end < size; end += 1 + end / 8) {
    const Likeness now = biss::capture::looks_like_sampled_csv(text.substr(0, end), false);
    biss::fuzz::require(!likeness || *likeness == Likeness::not_yet || now == *likeness);
    likeness = now;
  }
  return 0;
}

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t max_size, unsigned seed) {
  static constexpr std::array<std::string_view, 40> words{
      "X",         "CH1",        "CH2",           "Start",
      "Increment", "Sequence",   "Volt",          "Second",
      "2e-08",     "x-axis",     "second",        "Model",
      "TIME",      "Time",       "Time(s)",       "(ms)",
      "(mV)",      "CH1(V)",     "t0 = -1e-05s",  "tInc = 1e-08s",
      "Source",    "Segments,2", "LECROY",        "Record Length",
      "; CSV",     "logic",      "V DC",          "; Samplerate: 3 MHz",
      "nan",       "inf",        "-\xE2\x88\x9E", "9.9E+37",
      "",          "3.3",        "-0.05",         "1.65",
      "1e999",     "\r\n",       "\n\n",          "A0: 1 V DC\n"};
  return biss::fuzz::mutate_capture({data, max_size}, size, seed, ",;\n", words,
                                    biss::fuzz::scope_seed);
}
