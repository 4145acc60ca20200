// The rules of `biss check`: one list for the encoder, the master and the line between them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "biss/base/units.hpp"

namespace biss::decode {

/// docs/check.md explains each. New rules are added at the end: the rows have the same order.
enum class Rule : std::uint8_t {
  frame_structure,
  frame_crc,
  ack_shortest,
  ack_longest,
  timeout_shortest,
  timeout_longest,
  line_delay,
  slo_idle,
  cds_idle,
  id_answer,
  id_pattern,
  header_damaged,
  rw_pattern,
  refusal,
  data_crc,
  write_start,
  write_echo,
  busy,
  next_register,
  manufacturer,
  profile,
  data_sheet,
  control_reset,
  clock_max,
  clock_min,
  clock_change,
  cycle_min,
  duty,
  ma_level,
  ready,
  extra_clocks,
  missing_request,
  start,
  cds_zero,
  stop,
  line_delay_jitter,
  line_delay_drift,
  cable,
  sampling_margin,
  sampling_uncompensated,
  glitch_ma,
  glitch_slo,
  nE,
  nW,
  sign_of_life,
  speed,
  stop_clock,
  reset,
  word_length,
  counter_values,
  safety,
};

inline constexpr std::size_t rule_count = 51;

/// A case of a rule is not seen without a frame, or without its format.
enum class Needs : std::uint8_t { line, frame, format, both };

struct RuleText {
  std::string_view name;
  /// The unit of the measured value (`ns`, `%`, `clocks`, `counts/s`), or the name of the counted
  /// thing.
  std::string_view unit;
  /// The document and section of the rule.
  std::string_view source;
  /// A value is measured and compared with a limit; else faults are counted, and the limit is 0.
  bool is_measured = false;
  Needs needs = Needs::line;
};
const RuleText& text_of(Rule rule);

enum class Verdict : std::uint8_t {
  pass,
  fail,
  marginal,    ///< beyond the limit, but not certainly, or nothing forbids it
  not_judged,  ///< the capture holds no case, or is too coarse for the rule
};
std::string_view name_of(Verdict verdict);

/// A measured value and its limit, in thousandths of the unit of the rule: picoseconds for `ns`.
struct Measured {
  std::int64_t limit = 0;
  std::int64_t worst = 0;
  /// From the worst value to the limit; negative: beyond it.
  std::int64_t margin = 0;
};

struct RuleResult {
  Verdict verdict = Verdict::not_judged;
  std::uint64_t cases = 0;
  std::uint64_t faults = 0;
  /// The value with the least margin; if the rule fails, among the values that are faults. Present
  /// only if the rule measures a value and a case was seen.
  std::optional<Measured> measured;
  /// Cycle of that value, or of the first fault.
  std::optional<std::uint64_t> cycle;
  /// For users: the fault, or the reason why the rule is not judged.
  std::string note;
};

/// The cases seen for each rule.
class Tallies {
 public:
  /// \param resolution as MarginSetup::resolution
  explicit Tallies(Picoseconds resolution) : resolution_(resolution) {}

  /// One case of a rule that counts faults.
  void count(Rule rule, bool good, std::uint64_t cycle, std::string_view note = {});
  /// The same for cases that depend on sampled bits: with fewer than four samples per period a
  /// fault is not certain, and is not counted.
  void count_sampled(Rule rule, bool good, Picoseconds period, std::uint64_t cycle,
                     std::string_view note = {});
  /// Several faults at once.
  void add_faults(Rule rule, std::uint64_t faults, std::uint64_t cycle, std::string_view note = {});

  /// A measured time. The resolution of the capture is added to `doubt`, once for each of the two
  /// edges; if that is more than the limit, the capture is too coarse and the time is not a case.
  void at_most(Rule rule, Picoseconds value, Picoseconds limit, Picoseconds doubt,
               std::uint64_t cycle);
  void at_least(Rule rule, Picoseconds value, Picoseconds limit, Picoseconds doubt,
                std::uint64_t cycle);
  /// A value in thousandths of the unit. \param doubt complete
  void measure(Rule rule, const Measured& value, std::int64_t doubt, std::uint64_t cycle);

  /// The capture is too coarse for a case of this rule.
  void too_coarse(Rule rule, Picoseconds needed);
  /// Why a rule has no case.
  void explain(Rule rule, std::string_view why) { tally(rule).why = why; }
  /// A fault of this rule is `marginal`: nothing forbids it.
  void make_advice(Rule rule) { tally(rule).advice = true; }

  Picoseconds resolution() const { return resolution_; }
  /// Whether the capture has at least four samples in this period of MA, so that its bits are
  /// certain.
  bool shows_bits(Picoseconds period) const { return 4 * resolution_ <= period; }
  RuleResult result(Rule rule) const;
  std::uint64_t faults(Rule rule) const { return tallies_[static_cast<std::size_t>(rule)].faults; }

 private:
  // The result of a rule, but for its verdict.
  struct Tally : RuleResult {
    std::string_view why;
    bool advice = false;
    // A fault that may come from the resolution of the capture.
    bool uncertain = false;
    // The finest resolution that a case needed, if the capture is coarser.
    std::optional<Picoseconds> needed;
  };

  Tally& tally(Rule rule) { return tallies_[static_cast<std::size_t>(rule)]; }
  Verdict verdict(const Tally& of) const;

  std::array<Tally, rule_count> tallies_{};
  Picoseconds resolution_;
};

}  // namespace biss::decode
