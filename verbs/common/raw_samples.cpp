#include "verbs/common/raw_samples.hpp"

#include <fmt/format.h>

#include "verbs/common/verb.hpp"

namespace biss::verbs {

namespace {

Nanovolts voltage_of(const std::string& text) {
  const auto voltage = parse_voltage(text);
  if (!voltage) {
    wrong_value("--threshold", quantity_error_text(Quantity::voltage, text, voltage.error()));
  }
  return *voltage;
}

// `1.5V` or `1.5V:200mV`.
capture::Threshold threshold_of(const std::string& text) {
  const std::size_t colon = text.find(':');
  capture::Threshold threshold{voltage_of(text.substr(0, colon)), capture::default_hysteresis};
  if (colon == std::string::npos) return threshold;
  threshold.hysteresis = voltage_of(text.substr(colon + 1));
  if (threshold.hysteresis < Nanovolts{}) {
    wrong_value("--threshold", "the hysteresis must not be negative");
  }
  return threshold;
}

// `A-B` or `A-B=NAME`.
capture::Differential differential_of(const std::string& text) {
  const std::size_t equals = text.rfind('=');
  capture::Differential differential{text.substr(0, equals), text.substr(0, equals)};
  if (equals != std::string::npos) differential.name = text.substr(equals + 1);
  const std::size_t dash = differential.pair.find('-');
  if (dash == std::string::npos || dash == 0 || dash + 1 == differential.pair.size() ||
      differential.name.empty()) {
    wrong_value("--differential",
                fmt::format("'{}' is not A-B or A-B=NAME, as in CH1-CH2=MA", text));
  }
  return differential;
}

}  // namespace

void add_raw_options(Verb verb, RawSamples& raw) {
  verb = verb.scope(Scope::file);
  const Option& rate = add_rate_option(
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
  verb.add_text_option(
          "--threshold",
          [&raw](const std::string& text) { raw.analog.threshold = threshold_of(text); },
          "Threshold of analog channels and its hysteresis (100mV by default); by default both are "
          "measured for each channel at the beginning of the capture")
      .type_name("VOLTAGE[:VOLTAGE]");
  verb.add_text_option(
          "--differential",
          [&raw](const std::string& text) {
            raw.analog.differentials.push_back(differential_of(text));
          },
          "Take the analog channels A and B as one line, A minus B; repeatable", true)
      .type_name("A-B[=NAME]");
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

}  // namespace biss::verbs
