#include "decode/check.hpp"

#include <algorithm>
#include <span>
#include <string_view>
#include <vector>

#include "decode/control_rules.hpp"
#include "decode/frame_rules.hpp"
#include "decode/safety_watch.hpp"
#include "decode/sequence_rules.hpp"
#include "decode/signal_rules.hpp"

namespace biss::decode {

namespace {

std::vector<Rule> rules_that_need(Needs needs) {
  std::vector<Rule> rules;
  for (std::size_t i = 0; i < rule_count; ++i) {
    const auto rule = static_cast<Rule>(i);
    const Needs all = text_of(rule).needs;
    if (all == needs || all == Needs::both) rules.push_back(rule);
  }
  return rules;
}

// Why the rules that a capture may not show, or a device may not have, are not judged.
void explain(const CheckSetup& setup, Tallies& tallies) {
  using enum Rule;
  const bool known = setup.format.has_value();
  const auto lacks = [&](auto has) {
    const auto channels = known ? setup.format->channels() : std::span<const ChannelFormat>();
    return known && std::none_of(channels.begin(), channels.end(), has);
  };
  const bool no_crc = lacks([](const ChannelFormat& channel) { return channel.crc.present(); });
  const bool no_life =
      lacks([](const ChannelFormat& channel) { return channel.life_counter.present(); });
  const DeviceTiming& timing = setup.timing;
  struct Reason {
    bool holds;
    Rule rule;
    std::string_view why;
  };
  const Reason reasons[] = {
      {no_crc, frame_crc, "the format has no checksum"},
      {no_crc, stop, "not certain without a checksum"},
      {no_crc, stop_clock, "not certain without a checksum"},
      {lacks([](const ChannelFormat& channel) { return channel.error.present; }), nE,
       "the format has no such bit"},
      {lacks([](const ChannelFormat& channel) { return channel.warning.present; }), nW,
       "the format has no such bit"},
      {no_life, sign_of_life, "the format has no sign of life"},
      {no_life, counter_values, "the format has no sign of life"},
      {!timing.clock_constant, clock_change, "the encoder does not demand a constant clock"},
      {!timing.duty_even, duty, "the encoder does not demand a duty of 1:1"},
      {timing.cycle_min.count == 0, cycle_min, "the shortest cycle of the encoder is not known"},
      {!setup.renishaw_cables, cable, "no table of cables is known for the encoder"},
      {!FrameRules::knows_reset(timing), reset,
       "the time after an aborted request is not known for the encoder"},
      {known && !setup.has_word_lengths, word_length, "no word lengths are known for the encoder"},
      {known && !setup.safety, safety, "give --safety"},
      {!setup.unidirectional, cds_zero, "the encoder may be bidirectional: CDS may be 1"},
      {known, extra_clocks, "no limit is known for this format"},
      {!setup.compensated, sampling_margin, "the master does not compensate the line delay"},
      {setup.speed_max == 0, speed, "the highest speed is not known: give --speed-max"},
      {true, missing_request, "fewer than five equal intervals in a row"},
  };
  for (const Rule rule : rules_that_need(Needs::format)) {
    if (!known) tallies.explain(rule, "needs the frame format");
  }
  for (const auto& [holds, rule, why] : reasons) {
    if (holds) tallies.explain(rule, why);
  }
}

}  // namespace

struct Check::Rules {
  explicit Rules(const CheckSetup& given) : setup(given) {
    explain(setup, tallies);
    if (setup.format && setup.safety) watch.emplace(*setup.format, *setup.safety);
    if (setup.has_word_lengths) {
      tallies.count(Rule::word_length, *setup.has_word_lengths, 0,
                    "no word of the data sheet has these lengths");
    }
  }

  CheckSetup setup;
  Tallies tallies{setup.resolution};
  FrameRules frames{setup, tallies};
  SignalRules signal{setup, tallies};
  SequenceRules sequence{setup, tallies};
  ControlRules control{setup.format, tallies};
  std::optional<SafetyWatch> watch;
};

Check::Check(const CheckSetup& setup) : rules_(std::make_unique<Rules>(setup)) {}
Check::~Check() = default;

void Check::push(std::uint64_t number, const Cycle& cycle) {
  rules_->frames.push(number, cycle);
  rules_->signal.push(number, cycle);
  rules_->sequence.push(number, cycle);
  rules_->control.push(number, cycle);
  if (!rules_->watch) return;
  if (const auto verdict = rules_->watch->judge(cycle)) {
    const bool good = !is_fault(*verdict) && *verdict != SafetyVerdict::latched;
    rules_->tallies.count(Rule::safety, good, number, name_of(*verdict));
  }
}

void Check::finish() {
  rules_->frames.finish();
  rules_->control.finish();
  const std::string_view why = rules_->frames.no_frame();
  if (why.empty()) return;
  for (const Rule rule : rules_that_need(Needs::frame)) {
    if (rules_->tallies.result(rule).note.empty()) rules_->tallies.explain(rule, why);
  }
}

RuleResult Check::result(Rule rule) const {
  const ControlRules& control = rules_->control;
  RuleResult result =
      rule == Rule::data_sheet ? control.data_sheet() : rules_->tallies.result(rule);
  // The manufacturer has two bytes; one good byte alone gives no verdict.
  const bool half_seen = rule == Rule::manufacturer && result.faults == 0;
  if (half_seen && !control.manufacturer_seen()) result.verdict = Verdict::not_judged;
  if (result.verdict == Verdict::not_judged && result.note.empty()) result.note = "no case";
  return result;
}

std::uint64_t Check::faults(Rule rule) const { return rules_->tallies.faults(rule); }

}  // namespace biss::decode
