// `-f FORMAT` of the verbs that run the safety monitor: a frame, and how it is monitored.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "biss/frame/format.hpp"
#include "biss/safety/configurations.hpp"
#include "biss/safety/verdict.hpp"

namespace biss::verbs {

struct Option;
class Verb;

/// Returns the configuration of that name, otherwise the first one with the format's words and any
/// CDS, otherwise null.
const SafetyConfiguration* implied_configuration(std::string_view text, const FrameFormat& format);

/// Returns whether the format has two words, the second one with a sign of life of 6 bits, and
/// everything else that a monitor needs.
bool is_safety_format(const FrameFormat& format);

/// A frame and how it is monitored.
struct SafetyFormat {
  FrameFormat format;
  SafetySetup setup;
  /// The text of `-f`, if it names a device or a format.
  std::string device;

  /// Bits of the CPW's position that the comparison with the SPW does not cover.
  struct UncheckedBits {
    unsigned below_resolution = 0;  ///< singleturn bits that the SPW does not have
    unsigned not_compared = 0;      ///< singleturn bits of both words, left out by compare_bits
    unsigned turns = 0;             ///< turns that the SPW does not have, or that are ignored

    unsigned all() const { return below_resolution + not_compared + turns; }
  };
  UncheckedBits unchecked_bits() const;

  const ChannelFormat& cpw() const { return format.channel_list[setup.cpw]; }
  const ChannelFormat& spw() const { return format.channel_list[setup.spw]; }
};

/// Reads one of these:
/// * the name of a safety configuration;
/// * a catalogue name: monitored by the configuration that `decode` takes for it;
/// * the format of two words: monitored with the defaults of SafetySetup;
/// * a file: configuration.json of an evidence bundle.
/// \return nothing if it is none of these or cannot be monitored
std::optional<SafetyFormat> parse_safety_format(std::string_view text);

/// Returns one line with the reason why parse_safety_format() returns nothing (usage: exit status
/// 2).
std::string safety_format_error(std::string_view text);

/// Declares `-f,--format`, to be read by parse_safety_format().
Option& add_safety_format_option(Verb verb, std::string& target);

/// Returns the highest rate that the setup's shortest cycle allows, in whole hertz.
Hertz rate_of_cycle(const SafetySetup& setup);

/// Returns configuration.json: the frame, every parameter of the setup.
/// \param name of the configuration, or a text that states that there is none
std::string configuration_json(const SafetyFormat& monitored, std::string_view name);

/// Reads what configuration_json() writes. \return nothing if it is something else
std::optional<SafetyFormat> parse_configuration_json(const std::string& text);

/// Returns `VERDICT:COUNT …`, the most frequent first.
std::string verdicts_text(const std::array<std::uint64_t, safety_verdict_count>& counts);

}  // namespace biss::verbs
