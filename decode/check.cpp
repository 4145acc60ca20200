#include "decode/check.hpp"

namespace biss::decode {

Check::Check(const CheckSetup& setup)
    : tallies_(setup.resolution),
      frames_(setup.timing, setup.unidirectional || (setup.format && setup.format->cds0), tallies_),
      signal_({.timing = setup.timing,
               .renishaw_cables = setup.renishaw_cables,
               .compensated = setup.compensated},
              tallies_),
      sequence_(setup.format, setup.timing, setup.speed_max, tallies_),
      control_(setup.format, tallies_) {}

void Check::push(std::uint64_t number, const Cycle& cycle) {
  frames_.push(number, cycle);
  signal_.push(number, cycle);
  sequence_.push(number, cycle);
  control_.push(number, cycle);
}

void Check::finish() { control_.finish(); }

RuleResult Check::result(Rule rule) const {
  if (rule == Rule::data_sheet) return control_.data_sheet();
  RuleResult result = tallies_.result(rule);
  // One byte of two says nothing of the other.
  const bool half_seen = rule == Rule::manufacturer && result.faults == 0;
  if (half_seen && !control_.manufacturer_seen()) result.verdict = Verdict::not_judged;
  return result;
}

}  // namespace biss::decode
