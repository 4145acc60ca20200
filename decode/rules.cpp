#include "decode/rules.hpp"

#include <algorithm>
#include <limits>

namespace biss::decode {

namespace {

// Beyond this no time of a capture is an exact number of thousandths.
constexpr std::int64_t most_thousandths = std::numeric_limits<std::int64_t>::max() / 4;

std::string coarse(Picoseconds resolution, Picoseconds needed) {
  const auto in_ns = [](Picoseconds time) {
    std::string text = std::to_string(time.count / 1'000);
    const std::int64_t rest = time.count % 1'000;
    if (rest != 0) text += '.' + std::to_string(1'000 + rest).substr(1);
    while (rest != 0 && text.back() == '0') text.pop_back();
    return text + " ns";
  };
  return "the capture is too coarse: its resolution is " + in_ns(resolution) + ", needed are " +
         in_ns(needed);
}

}  // namespace

void Tallies::count(Rule rule, bool good, std::uint64_t cycle, std::string_view note) {
  Tally& of = tally(rule);
  ++of.cases;
  if (good || of.faults++ != 0) return;
  // If a fault has no value, the values of other cases are not shown.
  of.measured.reset();
  of.cycle = cycle;
  of.note = note;
}

void Tallies::count_sampled(Rule rule, bool good, Picoseconds period, std::uint64_t cycle,
                            std::string_view note) {
  if (good || shows_bits(period)) return count(rule, good, cycle, note);
  too_coarse(rule, period / 4);
  tally(rule).uncertain = true;
}

void Tallies::add_faults(Rule rule, std::uint64_t faults, std::uint64_t cycle,
                         std::string_view note) {
  if (faults == 0) return;
  Tally& of = tally(rule);
  if (of.faults == 0) {
    of.cycle = cycle;
    of.note = note;
  }
  of.faults += faults;
}

void Tallies::at_most(Rule rule, Picoseconds value, Picoseconds limit, Picoseconds doubt,
                      std::uint64_t cycle) {
  if (2 * resolution_ > limit) return too_coarse(rule, limit / 2);
  measure(rule, {limit.count, value.count, (limit - value).count}, (doubt + 2 * resolution_).count,
          cycle);
}

void Tallies::at_least(Rule rule, Picoseconds value, Picoseconds limit, Picoseconds doubt,
                       std::uint64_t cycle) {
  if (2 * resolution_ > std::max(limit, -limit) && limit.count != 0) {
    return too_coarse(rule, std::max(limit, -limit) / 2);
  }
  measure(rule, {limit.count, value.count, (value - limit).count}, (doubt + 2 * resolution_).count,
          cycle);
}

void Tallies::measure(Rule rule, const Measured& value, std::int64_t doubt, std::uint64_t cycle) {
  Tally& of = tally(rule);
  ++of.cases;
  const bool fault_before = of.faults != 0;
  const bool fault = value.margin < -doubt;
  if (fault) ++of.faults;
  if (fault_before && !fault) return;
  if (of.measured && fault == fault_before && of.measured->margin <= value.margin) return;
  of.measured = value;
  of.cycle = cycle;
  of.note.clear();
}

void Tallies::too_coarse(Rule rule, Picoseconds needed) {
  auto& finest = tally(rule).needed;
  finest = std::min(finest.value_or(needed), needed);
}

Verdict Tallies::verdict(const Tally& of) const {
  if (of.faults != 0) return of.advice ? Verdict::marginal : Verdict::fail;
  if (of.cases == 0 || of.uncertain) return Verdict::not_judged;
  return of.measured && of.measured->margin < 0 ? Verdict::marginal : Verdict::pass;
}

RuleResult Tallies::result(Rule rule) const {
  const Tally& of = tallies_[static_cast<std::size_t>(rule)];
  RuleResult result = of;
  result.verdict = verdict(of);
  if (result.measured) {
    result.measured->worst =
        std::clamp(result.measured->worst, -most_thousandths, most_thousandths);
  }
  const bool may_explain =
      result.verdict == Verdict::not_judged || (result.verdict == Verdict::marginal && of.advice);
  if (result.verdict == Verdict::not_judged && of.needed) {
    result.note = coarse(resolution_, *of.needed);
  } else if (result.note.empty() && may_explain) {
    result.note = of.why;
  }
  return result;
}

std::string_view name_of(Verdict verdict) {
  constexpr std::array<std::string_view, 4> names{"pass", "fail", "marginal", "not_judged"};
  return names[static_cast<std::size_t>(verdict)];
}

const RuleText& text_of(Rule rule) {
  using enum Needs;
  static constexpr std::array<RuleText, rule_count> texts{{
      {"frame_structure", "frames", "D2, the BiSS frame", false, frame},
      {"frame_crc", "frames", "D2, single-cycle data", false, both},
      {"ack_shortest", "ns", "D2, characteristics, row 10", true, frame},
      {"ack_longest", "ns", "D2, characteristics, row 10", true, frame},
      {"timeout_shortest", "ns", "D2, characteristics, rows 5 and 6", true, frame},
      {"timeout_longest", "ns", "D2, characteristics, rows 5 and 6", true, frame},
      {"line_delay", "ns", "D2, characteristics, row 7", true, frame},
      {"slo_idle", "requests", "D2, the BiSS frame"},
      {"cds_idle", "cycles", "D2, control communication"},
      {"id_answer", "accesses", "D2, ID assignment"},
      {"id_pattern", "accesses", "D2, ID assignment"},
      {"header_damaged", "accesses", "D2, control communication"},
      {"rw_pattern", "accesses", "D2, register access"},
      {"refusal", "accesses", "D2, register access; AN22"},
      {"data_crc", "bytes", "D2, register access"},
      {"write_start", "bytes", "D2, register access"},
      {"write_echo", "bytes", "D2, register access"},
      {"busy", "ns", "D2, characteristics, row 11", true},
      {"next_register", "accesses", "D2, sequential access"},
      {"manufacturer", "accesses", "D2, registers"},
      {"profile", "cases", "D2, registers; BP3"},
      {"data_sheet", "findings", "BP3; common part: inferred"},
      {"control_reset", "accesses", "D2, control communication"},
      {"clock_max", "ns", "data sheet; D2, characteristics, row 1", true},
      {"clock_min", "ns", "data sheet; D2, characteristics, row 1", true},
      {"clock_change", "ns", "data sheet", true},
      {"cycle_min", "ns", "data sheet", true},
      {"duty", "%", "data sheet; 40 % as in D2, characteristics, rows 3 and 4", true},
      {"ma_level", "ns", "D2, characteristics, rows 3 and 4", true},
      {"ready", "ns", "D2, the BiSS frame", true},
      {"extra_clocks", "clocks", "data sheet", true, format},
      {"missing_request", "requests", "the requests of the capture"},
      {"start", "frames", "D2, the BiSS frame; data sheet", false, frame},
      {"cds_zero", "frames", "data sheet", false, frame},
      {"stop", "frames", "D2, the BiSS frame", false, both},
      {"line_delay_jitter", "ns", "D2, characteristics, row 8", true, both},
      {"line_delay_drift", "ns", "D2, characteristics, row 8: inferred", true, frame},
      {"cable", "ns", "data sheet", true, frame},
      {"sampling_margin", "%", "D2, characteristics, row 8", true, both},
      {"sampling_uncompensated", "%", "data sheet", true, both},
      {"glitch_ma", "pulses", "inferred"},
      {"glitch_slo", "pulses", "inferred"},
      {"nE", "frames", "data sheet; BP3", false, both},
      {"nW", "frames", "data sheet; BP3", false, both},
      {"sign_of_life", "frames", "Safety Concept A5; data sheet", false, both},
      {"speed", "counts/s", "--speed-max", true, both},
      {"stop_clock", "frames", "D2, the BiSS frame", false, both},
      {"reset", "ns", "data sheet", true},
      {"word_length", "formats", "data sheet; Safety Concept A5", false, format},
      {"counter_values", "rollovers", "data sheet", false, both},
      {"safety", "frames", "--safety", false, format},
  }};
  return texts[static_cast<std::size_t>(rule)];
}

}  // namespace biss::decode
