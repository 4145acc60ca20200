// BiSS Safety in `decode`: the options of the monitor, and its lines in the summary.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include <tl/expected.hpp>

#include "biss/frame/format.hpp"
#include "biss/safety/setup.hpp"
#include "biss/safety/verdict.hpp"
#include "decode/safety_watch.hpp"
#include "report/summary.hpp"
#include "verbs/common/safety_format.hpp"

namespace biss::verbs {

class DecodedCapture;
class Verb;

/// The options as given on the command line; empty if not given.
struct SafetyArguments {
  std::string configuration;
  std::string counter;
  std::optional<std::uint64_t> compare_bits;
  std::optional<std::uint64_t> tolerance;
  std::optional<std::uint64_t> start_frames;
  std::optional<Picoseconds> watchdog;
  std::optional<Picoseconds> shortest;
  bool latch = false;
  /// Not an option: without a named configuration the widths of the words count.
  bool by_widths = false;
  /// Not an option: the shortest cycle of the encoder is not known. Without `--shortest-gap` the gap
  /// is not checked, unless the watchdog needs it.
  bool any_gap = false;

  bool given() const;
};

/// Declares the options of the checks: counter, comparison, start-up.
/// \pre arguments outlives the parsing
void add_check_options(Verb verb, SafetyArguments& arguments);

/// Declares `--safety` and the options that go with it. \pre arguments outlives the parsing
void add_safety_options(Verb verb, SafetyArguments& arguments);

/// How to monitor, and the name of the configuration.
struct SafetyChoice {
  SafetySetup setup;
  std::string name;
};

/// Chooses the named configuration, else the configuration of the format's name, else the first one
/// with the format's widths (not with by_widths), else the widths of the words. Single options
/// override it. Faults do not latch without `--latch`, so that every cycle has its own verdict.
/// \param cycle time from request to request; the watchdog allows one and a half of them
/// \return the choice, or one line with the mistake (usage: exit status 2)
tl::expected<SafetyChoice, std::string> choose_safety(const SafetyArguments& arguments,
                                                      std::string_view format_text,
                                                      const FrameFormat& format, Picoseconds cycle);

/// How to monitor the current capture: empty with `--safety off`, and without options for a format
/// that is not one of BiSS Safety.
/// \param format_text the format as the user typed it; empty: the capture's own
/// \return the choice, or one line with the mistake (usage: exit status 2)
/// \pre next() was true and read() has not been called since
tl::expected<std::optional<SafetyChoice>, std::string> choose_monitor(SafetyArguments arguments,
                                                                      std::string format_text,
                                                                      DecodedCapture& capture);

/// Adds the lines `safety`, `counter` and `comparison`. \param name of the configuration
void add_safety(report::Summary& summary, const decode::SafetyWatch& watch, std::string_view name);

/// The mistake in a setup, with the option that corrects it if there is one.
std::string_view message_of(SafetySetupError mistake);

}  // namespace biss::verbs
