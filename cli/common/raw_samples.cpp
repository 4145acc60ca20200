#include "cli/common/raw_samples.hpp"

#include <fmt/format.h>

#include "cli/common/verb.hpp"

namespace biss::cli {

void add_raw_options(Verb verb, RawSamples& raw) {
  const Option rate = add_rate_option(
      verb, "--raw-rate", into(raw.rate),
      "Sample rate of a raw capture (.bin, .raw); its bits are the lines D0, D1, ... "
      "for --ma and --slo");
  const auto set_bytes = [&raw](std::uint64_t bytes) {
    if (bytes == 0) wrong_value("--raw-bytes", "a sample has 1 to 8 bytes");
    raw.bytes = bytes;
  };
  add_count_option(verb, "--raw-bytes", set_bytes,
                   "Bytes per raw sample, lowest byte first; 1 by default", capture::max_unit_bytes)
      .needs(rate);
}

capture::RawLayout layout_of(const RawSamples& raw, const std::string& ma, const std::string& slo) {
  capture::RawLayout all{*raw.rate, static_cast<std::size_t>(raw.bytes), {}};
  capture::RawLayout named = all;
  for (unsigned bit = 0; bit < 8 * raw.bytes; ++bit) {
    const std::string name = fmt::format("D{}", bit);
    all.lines.push_back({name, bit});
    if (name == ma || name == slo) named.lines.push_back({name, bit});
  }
  return named.lines.size() == 2 ? named : all;
}

}  // namespace biss::cli
