// The verdicts, and the names and sources of the rules.
#include <algorithm>

#include "decode/conformance.hpp"

namespace biss::decode {

RuleResult Conformance::result(Rule rule) const {
  const Tally& of = tallies_[static_cast<std::size_t>(rule)];
  RuleResult result{
      .cases = of.cases, .faults = of.faults, .time = of.time, .cycle = of.cycle, .note = of.note};
  if (rule == Rule::data_sheet) {
    for (const auto& [id, seen] : slaves_) {
      const auto judged = seen.judge_eds();
      if (!judged) continue;
      ++result.cases;
      if (judged->findings == 0) continue;
      if (result.faults == 0) {
        result.cycle = last_access_.at(id);
        result.note = std::string(judged->first.symbol) + ": ";
        result.note += text_of(judged->first.problem);
      }
      result.faults += judged->findings;
    }
  }
  // One byte of two says nothing of the other.
  const bool half_seen = rule == Rule::manufacturer && result.faults == 0 &&
                         std::none_of(manufacturer_seen_.begin(), manufacturer_seen_.end(),
                                      [](unsigned seen) { return seen == 3; });
  if (result.cases == 0 || half_seen) {
    result.verdict = Verdict::not_judged;
  } else if (result.faults != 0) {
    result.verdict = Verdict::fail;
  } else {
    const bool beyond = result.time && result.time->margin < Picoseconds{};
    result.verdict = beyond ? Verdict::marginal : Verdict::pass;
  }
  return result;
}

std::string_view name_of(Verdict verdict) {
  constexpr std::array<std::string_view, 4> names{"pass", "fail", "marginal", "not_judged"};
  return names[static_cast<std::size_t>(verdict)];
}

const RuleText& text_of(Rule rule) {
  static constexpr std::array<RuleText, rule_count> texts{{
      {"frame_structure", "frames", "D2, the BiSS frame"},
      {"frame_crc", "frames", "D2, single-cycle data"},
      {"ack_shortest", "ns", "D2, characteristics, row 10"},
      {"ack_longest", "ns", "D2, characteristics, row 10"},
      {"timeout_shortest", "ns", "D2, characteristics, rows 5 and 6"},
      {"timeout_longest", "ns", "D2, characteristics, rows 5 and 6"},
      {"line_delay", "ns", "D2, characteristics, row 7"},
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
      {"busy", "ns", "D2, characteristics, row 11"},
      {"next_register", "accesses", "D2, sequential access"},
      {"manufacturer", "accesses", "D2, registers"},
      {"profile", "cases", "D2, registers; BP3"},
      {"data_sheet", "findings", "BP3; common part: inferred"},
      {"control_reset", "accesses", "D2, control communication"},
      {"clock_max", "ns", "data sheet; D2, characteristics, row 1"},
      {"clock_min", "ns", "data sheet; D2, characteristics, row 1"},
      {"clock_change", "ns", "data sheet"},
      {"cycle_min", "ns", "data sheet"},
  }};
  return texts[static_cast<std::size_t>(rule)];
}

}  // namespace biss::decode
