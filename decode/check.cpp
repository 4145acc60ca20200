#include "decode/check.hpp"

#include <algorithm>

namespace biss::decode {

namespace {

// The rules that only the bits of a known frame can show.
constexpr Rule needs_format[] = {Rule::frame_crc,
                                 Rule::stop,
                                 Rule::extra_clocks,
                                 Rule::nE,
                                 Rule::nW,
                                 Rule::sign_of_life,
                                 Rule::line_delay_jitter,
                                 Rule::sampling_margin,
                                 Rule::sampling_uncompensated,
                                 Rule::speed,
                                 Rule::stop_clock,
                                 Rule::word_length,
                                 Rule::counter_values,
                                 Rule::safety};

// The rules that only a frame can show.
constexpr Rule needs_frame[] = {Rule::frame_structure,
                                Rule::frame_crc,
                                Rule::ack_shortest,
                                Rule::ack_longest,
                                Rule::timeout_shortest,
                                Rule::timeout_longest,
                                Rule::line_delay,
                                Rule::start,
                                Rule::cds_zero,
                                Rule::stop,
                                Rule::line_delay_jitter,
                                Rule::line_delay_drift,
                                Rule::cable,
                                Rule::sampling_margin,
                                Rule::sampling_uncompensated,
                                Rule::nE,
                                Rule::nW,
                                Rule::sign_of_life,
                                Rule::speed,
                                Rule::stop_clock,
                                Rule::counter_values};

void explain_format(const std::optional<FrameFormat>& format, Tallies& tallies) {
  if (!format) {
    for (const Rule rule : needs_format) tallies.explain(rule, "needs the frame format");
    return;
  }
  const auto channels = format->channels();
  const auto no_channel = [&](auto has) {
    return std::none_of(channels.begin(), channels.end(), has);
  };
  if (no_channel([](const ChannelFormat& channel) { return channel.crc.present(); })) {
    tallies.explain(Rule::frame_crc, "the format has no checksum");
    tallies.explain(Rule::stop, "not certain without a checksum");
    tallies.explain(Rule::stop_clock, "not certain without a checksum");
  }
  if (no_channel([](const ChannelFormat& channel) { return channel.error.present; })) {
    tallies.explain(Rule::nE, "the format has no such bit");
  }
  if (no_channel([](const ChannelFormat& channel) { return channel.warning.present; })) {
    tallies.explain(Rule::nW, "the format has no such bit");
  }
  if (no_channel([](const ChannelFormat& channel) { return channel.life_counter.present(); })) {
    tallies.explain(Rule::sign_of_life, "the format has no sign of life");
    tallies.explain(Rule::counter_values, "the format has no sign of life");
  }
}

// Why the rules that a capture may not show, or a device may not have, are not judged.
void explain(const CheckSetup& setup, Tallies& tallies) {
  explain_format(setup.format, tallies);
  const DeviceTiming& timing = setup.timing;
  if (!timing.clock_constant) {
    tallies.explain(Rule::clock_change, "the encoder does not demand a constant clock");
  }
  if (!timing.duty_even) tallies.explain(Rule::duty, "the encoder does not demand a duty of 1:1");
  if (timing.cycle_min.count == 0) {
    tallies.explain(Rule::cycle_min, "the shortest cycle of the encoder is not known");
  }
  if (!setup.renishaw_cables) {
    tallies.explain(Rule::cable, "no table of cables is known for the encoder");
  }
  if (!FrameRules::knows_reset(timing)) {
    tallies.explain(Rule::reset, "the time after an aborted request is not known for the encoder");
  }
  if (setup.format && !setup.has_word_lengths) {
    tallies.explain(Rule::word_length, "no word lengths are known for the encoder");
  }
  if (setup.format && !setup.safety) tallies.explain(Rule::safety, "give --safety");
  if (!setup.unidirectional) {
    tallies.explain(Rule::cds_zero, "the encoder may be bidirectional: CDS may be 1");
  }
  if (setup.format) tallies.explain(Rule::extra_clocks, "no limit is known for this format");
  if (!setup.compensated) {
    tallies.explain(Rule::sampling_margin, "the master does not compensate the line delay");
  }
  if (setup.speed_max == 0) {
    tallies.explain(Rule::speed, "the highest speed is not known: give --speed-max");
  }
  tallies.explain(Rule::missing_request, "fewer than five equal intervals in a row");
}

}  // namespace

Check::Check(const CheckSetup& setup)
    : tallies_(setup.resolution),
      frames_(setup.timing, setup.unidirectional || (setup.format && setup.format->cds0), tallies_),
      signal_({.timing = setup.timing,
               .renishaw_cables = setup.renishaw_cables,
               .compensated = setup.compensated},
              tallies_),
      sequence_(setup.format, setup.timing, setup.speed_max, tallies_, setup.renishaw_cables),
      control_(setup.format, tallies_) {
  explain(setup, tallies_);
  if (setup.format && setup.safety) safety_.emplace(*setup.format, *setup.safety);
  if (setup.has_word_lengths) {
    tallies_.count(Rule::word_length, *setup.has_word_lengths, 0,
                   "no word of the data sheet has these lengths");
  }
}

void Check::push(std::uint64_t number, const Cycle& cycle) {
  frames_.push(number, cycle);
  signal_.push(number, cycle);
  sequence_.push(number, cycle);
  control_.push(number, cycle);
  if (!safety_) return;
  if (const auto verdict = safety_->judge(cycle)) {
    const bool good = !is_fault(*verdict) && *verdict != SafetyVerdict::latched;
    tallies_.count(Rule::safety, good, number, name_of(*verdict));
  }
}

void Check::finish() {
  frames_.finish();
  control_.finish();
  const std::string_view why = frames_.no_frame();
  if (why.empty()) return;
  for (const Rule rule : needs_frame) {
    if (tallies_.result(rule).note.empty()) tallies_.explain(rule, why);
  }
}

RuleResult Check::result(Rule rule) const {
  RuleResult result = rule == Rule::data_sheet ? control_.data_sheet() : tallies_.result(rule);
  // The manufacturer has two bytes; one good byte alone is not a verdict.
  const bool half_seen = rule == Rule::manufacturer && result.faults == 0;
  if (half_seen && !control_.manufacturer_seen()) result.verdict = Verdict::not_judged;
  if (result.verdict == Verdict::not_judged && result.note.empty()) result.note = "no case";
  return result;
}

}  // namespace biss::decode
