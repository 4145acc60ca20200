// `decode` of BiSS Safety: a verdict for every cycle, and what they add up to.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "biss/frame/codec.hpp"
#include "biss/frame/format.hpp"
#include "biss/safety/monitor.hpp"
#include "cli/safety/format.hpp"
#include "decode/cycle.hpp"
#include "report/summary.hpp"

namespace biss::cli {

class Verb;

/// What the user typed; empty where nothing.
struct SafetyArguments {
  std::string configuration;
  std::string counter;
  std::optional<std::uint64_t> compare_bits;
  std::optional<std::uint64_t> tolerance;
  std::optional<std::uint64_t> start_frames;
  std::optional<Picoseconds> watchdog;
  std::optional<Picoseconds> shortest;
  bool latch = false;
  /// Not typed: unless a configuration is named, what the words have; none is looked for.
  bool by_widths = false;

  bool given() const;
};

/// In the order of CounterMode.
inline constexpr std::array<std::string_view, 3> counter_mode_names{"count_1_63", "count_0_63",
                                                                    "learned"};

/// Declares the options that say what is checked and not of what: counter, comparison, start-up.
/// \pre arguments outlives the parsing
void add_check_options(Verb verb, SafetyArguments& arguments);

/// Declares `--safety` and the options that go with it. \pre arguments outlives the parsing
void add_safety_options(Verb verb, SafetyArguments& arguments);

/// How to monitor, or none where the format is not one of BiSS Safety, or one line of text that
/// says what is wrong (usage: exit status 2).
struct SafetyChoice {
  std::optional<SafetySetup> setup;
  std::string name;
  std::string error;
};

/// The configuration that is named, else that of the format's name, else the first one with the
/// format's widths (not where by_widths), else what the words have. The options stand above it.
/// Faults do not latch unless `--latch` says so, since every cycle is to have its verdict. \param
/// cycle how far requests are apart: the watchdog bites after one and a half of them
SafetyChoice choose_safety(const SafetyArguments& arguments, std::string_view format_text,
                           const FrameFormat& format, Picoseconds cycle);

/// The monitor behind the decoder, and its counts.
class SafetyWatch {
 public:
  /// \pre !check_safety(format, setup)
  SafetyWatch(const FrameFormat& format, const SafetySetup& setup);

  /// None for what is no whole request: cut by the capture's ends, or a pulse.
  std::optional<SafetyVerdict> judge(const decode::Cycle& cycle);

  std::uint64_t count(SafetyVerdict verdict) const {
    return counts_[static_cast<std::size_t>(verdict)];
  }
  /// Judgements that are a fault.
  std::uint64_t faults() const;
  /// Lines `safety`, `counter` and `comparison`. \param name of the configuration
  void add_to(report::Summary& summary, std::string_view name) const;

 private:
  void learn(const SafetyJudgement& judgement);
  std::string counter_text() const;

  using Plan = SafetyPlan<max_channels>;
  Plan plan_;
  SafetyMonitor<Plan> monitor_;
  std::array<std::uint64_t, safety_verdict_count> counts_{};
  std::uint64_t compared_ = 0;
  std::int64_t worst_ = 0;
  std::optional<std::uint8_t> last_;
  std::array<std::uint64_t, 2> rollovers_{};  // to 0, to 1
};

/// The verdict of that name, or none.
std::optional<SafetyVerdict> safety_verdict_of(std::string_view name);

}  // namespace biss::cli
