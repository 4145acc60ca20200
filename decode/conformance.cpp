#include "decode/conformance.hpp"

#include <algorithm>

#include "biss/eds/profile.hpp"
#include "decode/times.hpp"

namespace biss::decode {

namespace {

// Within a frame the line delay may vary by this share of a period (D2, characteristics, row 8).
constexpr std::int64_t jitter_share = 4;
// R and W, and the bit before them.
constexpr unsigned silent_cycles = 3;

// The device could not answer such a request in full, or the capture does not show it.
bool is_no_evidence(CycleStatus status) {
  switch (status) {
    case CycleStatus::truncated:
    case CycleStatus::cut_start:
    case CycleStatus::cut_end:
    case CycleStatus::ma_glitch:
    case CycleStatus::ma_clock:
    case CycleStatus::unknown_level:
      return true;
    default:
      return false;
  }
}

// START was found, and MA ran as it should.
bool has_times(CycleStatus status) {
  return is_good(status) || status == CycleStatus::crc || status == CycleStatus::ack_range ||
         status == CycleStatus::cds || status == CycleStatus::stop_bit;
}

// Nothing where rules of their own judge the limit.
std::optional<Rule> rule_of(Limit limit) {
  switch (limit) {
    case Limit::clock_max:
      return Rule::clock_max;
    case Limit::clock_min:
      return Rule::clock_min;
    case Limit::clock_change:
      return Rule::clock_change;
    case Limit::cycle_min:
      return Rule::cycle_min;
    case Limit::release:
      break;
  }
  return std::nullopt;
}

}  // namespace

Conformance::Conformance(const std::optional<FrameFormat>& format, const DeviceTiming& timing)
    : format_(format),
      timing_(timing),
      limits_(timing),
      listener_([this](const SeenAccess& access) { judge_access(access); }) {}

void Conformance::push(std::uint64_t number, const Cycle& cycle) {
  judge_master(number, cycle);
  judge_idle(number, cycle);
  judge_frame(number, cycle);
  if (has_times(cycle.status)) judge_times(number, cycle);
  judge_stated_crc(number, cycle);
  watch_silence(number, cycle);
  watch_stray(number, cycle);
}

void Conformance::finish() { listener_.finish(); }

void Conformance::count(Rule rule, bool good, std::uint64_t cycle, std::string_view note) {
  Tally& of = tally(rule);
  ++of.cases;
  if (good || of.faults++ != 0) return;
  of.cycle = cycle;
  of.note = note;
}

void Conformance::at_most(Rule rule, Picoseconds value, Picoseconds limit, Picoseconds doubt,
                          std::uint64_t cycle) {
  measure(rule, {limit, value, limit - value}, doubt, cycle);
}

void Conformance::at_least(Rule rule, Picoseconds value, Picoseconds limit, Picoseconds doubt,
                           std::uint64_t cycle) {
  measure(rule, {limit, value, value - limit}, doubt, cycle);
}

void Conformance::measure(Rule rule, const RuleResult::Time& time, Picoseconds doubt,
                          std::uint64_t cycle) {
  Tally& of = tally(rule);
  ++of.cases;
  if (time.margin < -doubt) ++of.faults;
  if (of.time && of.time->margin + of.doubt <= time.margin + doubt) return;
  of.time = time;
  of.doubt = doubt;
  of.cycle = cycle;
}

// What the master must keep: else the other rules prove nothing.
void Conformance::judge_master(std::uint64_t number, const Cycle& cycle) {
  for (const LimitCase& each : limits_.compare(cycle)) {
    const auto rule = rule_of(each.limit);
    if (!rule) continue;
    if (each.is_longest) {
      at_most(*rule, each.value, each.bound, each.doubt, number);
    } else {
      at_least(*rule, each.value, each.bound, each.doubt, number);
    }
  }
}

// SLO low at a request is the device's fault only where the master has waited long enough.
void Conformance::judge_idle(std::uint64_t number, const Cycle& cycle) {
  const bool early = ready_by_ && cycle.time < *ready_by_;
  if (cycle.status == CycleStatus::not_ready) {
    if (!early) count(Rule::slo_idle, false, number, "SLO is low before the request");
  } else if (!is_no_evidence(cycle.status) || cycle.status == CycleStatus::truncated) {
    count(Rule::slo_idle, true, number);
  }
  const Picoseconds longest = std::max({timing_.timeout.time, biss_static_timeout_max,
                                        2 * cycle.period.value_or(period_of(biss_clock_min))});
  const Picoseconds clocks =
      (std::int64_t{cycle.rising_edges} + 1) * cycle.period.value_or(Picoseconds{});
  ready_by_ = shifted(cycle.time, clocks + longest + biss_line_delay_max);
}

void Conformance::judge_frame(std::uint64_t number, const Cycle& cycle) {
  const CycleStatus status = cycle.status;
  if (is_no_evidence(status) || status == CycleStatus::not_ready) return;
  if (status == CycleStatus::response_range) {
    return count(Rule::line_delay, false, number, "SLO falls too early or too late");
  }
  const Picoseconds asked = std::int64_t{cycle.rising_edges} * cycle.period.value_or(Picoseconds{});
  const bool long_enough = (usual_edges_ != 0 && cycle.rising_edges >= usual_edges_) ||
                           asked > biss_busy_max + biss_line_delay_max;
  const bool silent = status == CycleStatus::no_response || status == CycleStatus::no_start;
  if (silent && !long_enough) return;
  const bool good =
      has_times(status) && status != CycleStatus::cds && status != CycleStatus::stop_bit;
  count(Rule::frame_structure, good, number, name_of(status));
  if (is_good(status)) usual_edges_ = std::max(usual_edges_, cycle.rising_edges);
  const bool checked = std::any_of(cycle.crc_ok.begin(), cycle.crc_ok.end(),
                                   [](const auto& right) { return right.has_value(); });
  if (good && checked) count(Rule::frame_crc, status != CycleStatus::crc, number);
}

void Conformance::judge_times(std::uint64_t number, const Cycle& cycle) {
  if (!cycle.period) return;
  const Picoseconds jitter = *cycle.period / jitter_share;
  if (cycle.line_delay) {
    at_most(Rule::line_delay, *cycle.line_delay, biss_line_delay_max, {}, number);
  }
  if (cycle.ack) {
    const AckBounds bounds = ack_bounds(timing_, *cycle.period);
    at_least(Rule::ack_shortest, *cycle.ack, std::int64_t{bounds.min_clocks} * *cycle.period,
             jitter, number);
    at_most(Rule::ack_longest, *cycle.ack, std::int64_t{bounds.max_clocks} * *cycle.period, jitter,
            number);
  }
  if (cycle.release && cycle.line_delay) judge_timeout(number, cycle);
}

void Conformance::judge_timeout(std::uint64_t number, const Cycle& cycle) {
  const Picoseconds seen = *cycle.release - *cycle.line_delay;
  const auto [least, most] = release_bounds(timing_, cycle);
  at_least(Rule::timeout_shortest, seen, least, release_doubt(cycle, least), number);
  at_most(Rule::timeout_longest, seen, most, release_doubt(cycle, most), number);
}

void Conformance::judge_stated_crc(std::uint64_t number, const Cycle& cycle) {
  if (!stated_ || !has_times(cycle.status)) return;
  const ChannelFormat& channel = stated_->format().channels().front();
  const BitView raw = cycle.raw.view();
  if (!channel.crc.present() || raw.size_bits() < channel.total_bits() + 2U) return;
  const std::uint64_t sent = raw.word(2U + channel.data_bits, channel.crc.width_bits);
  count(Rule::profile, sent == stated_->crc(0, raw.word(2, channel.data_bits)), number,
        "the frame does not fit the profile identifier");
}

// After a damaged header the device must behave as if it was not addressed.
void Conformance::watch_silence(std::uint64_t number, const Cycle& cycle) {
  if (silence_left_ == 0 || cycle.status == CycleStatus::ma_glitch) return;
  const auto cds = cycle.cds();
  if (!cds) {
    silence_left_ = 0;
  } else if (*cds) {
    silence_left_ = 0;
    count(Rule::header_damaged, false, number, "R or W answers a damaged header");
  } else if (--silence_left_ == 0) {
    count(Rule::header_damaged, true, damaged_at_);
  }
}

// Only after 14 zeros of CDM it is certain that no access is running.
void Conformance::watch_stray(std::uint64_t number, const Cycle& cycle) {
  const std::uint64_t cds_before = listener_.stray_cds();
  const std::uint64_t cdm_before = listener_.stray_cdm();
  listener_.push(number, cycle);
  if (cycle.status == CycleStatus::ma_glitch) return;
  if (!cycle.cds() || !cycle.cdm || listener_.stray_cdm() != cdm_before) {
    zeros_ = 0;
    settled_ = false;
    return;
  }
  if (settled_) {
    count(Rule::cds_idle, listener_.stray_cds() == cds_before, number, "CDS = 1 without an access");
  }
  zeros_ = *cycle.cdm ? 0 : zeros_ + 1;
  settled_ = settled_ || zeros_ >= control_reset_zeros;
}

void Conformance::judge_access(const SeenAccess& access) {
  const AccessOutcome outcome = access.outcome;
  if (outcome == AccessOutcome::header_crc) {
    silence_left_ = silent_cycles;
    damaged_at_ = access.cycle;
    broken_off_ = true;
    return;
  }
  if (outcome == AccessOutcome::cut_end || !access.header_sent) return;
  if (outcome == AccessOutcome::frame_lost) {
    broken_off_ = true;
    announced_.reset();
    return;
  }
  judge_ids(access);
  if (access.kind != SeenAccess::Kind::command) return judge_register(access);
  announced_.reset();
  if (outcome == AccessOutcome::ok && access.command == ControlCommand::control) {
    control_off_ = access.slaves != 0;
  }
}

void Conformance::judge_ids(const SeenAccess& access) {
  const bool anybody = access.slaves_present != 0;
  const bool pattern = access.outcome == AccessOutcome::id_pattern ||
                       (access.slaves_present & (access.slaves_present + 1U)) != 0;
  if (!control_off_ || anybody) {
    count(Rule::id_answer, anybody || pattern, access.cycle, "IDL0 stays 0");
  }
  if (anybody || pattern) count(Rule::id_pattern, !pattern, access.cycle, "IDL has a gap");
  if (broken_off_ && answered_ && !control_off_) {
    count(Rule::control_reset, anybody || pattern, access.cycle,
          "no answer after an access that was broken off");
  }
  broken_off_ = access.outcome != AccessOutcome::ok && access.kind != SeenAccess::Kind::command;
  answered_ = answered_ || anybody;
}

void Conformance::judge_register(const SeenAccess& access) {
  const AccessOutcome outcome = access.outcome;
  judge_next(access);
  if (outcome == AccessOutcome::no_answer || outcome == AccessOutcome::no_such_slave ||
      outcome == AccessOutcome::id_pattern || access.kind == SeenAccess::Kind::unknown) {
    return;
  }
  const std::uint64_t at = access.cycle;
  const bool refused = outcome == AccessOutcome::refused ||
                       outcome == AccessOutcome::not_addressed ||
                       outcome == AccessOutcome::refused_or_not_addressed;
  if (refused) {
    count(Rule::refusal, outcome != AccessOutcome::not_addressed, at,
          "a read is refused with W = 0");
  }
  const bool pattern = outcome == AccessOutcome::rw_pattern;
  count(Rule::rw_pattern, !pattern, at, "R and W as no slave sends them");
  judge_manufacturer(access);
  if (refused || pattern) return;
  if (outcome == AccessOutcome::ok || outcome == AccessOutcome::data_crc ||
      outcome == AccessOutcome::busy_too_long) {
    at_most(Rule::busy, access.busy, register_busy_max, {}, at);
  }
  if (access.kind == SeenAccess::Kind::write) {
    judge_write(access);
  } else if (outcome == AccessOutcome::ok || outcome == AccessOutcome::data_crc) {
    count(Rule::data_crc, outcome == AccessOutcome::ok, at, "a byte and its CRC do not fit");
  }
  SeenRegisters& seen = slaves_[access.id];
  seen.take(access);
  last_access_[access.id] = at;
  judge_profile(access, seen);
}

void Conformance::judge_write(const SeenAccess& access) {
  const AccessOutcome outcome = access.outcome;
  const bool late = outcome == AccessOutcome::start_missing;
  if (late || outcome == AccessOutcome::ok || outcome == AccessOutcome::echo) {
    count(Rule::write_start, !late, access.cycle, "S of the first byte is not echoed");
  }
  if (outcome == AccessOutcome::ok || outcome == AccessOutcome::echo) {
    count(Rule::write_echo, outcome == AccessOutcome::ok, access.cycle,
          "the echo is not what was sent");
  }
}

// P = 0 has said that the next register can be accessed in the same way.
void Conformance::judge_next(const SeenAccess& access) {
  const AccessOutcome outcome = access.outcome;
  const bool announced = announced_ && announced_->id == access.id &&
                         announced_->kind == access.kind && announced_->next == access.address;
  const bool no =
      outcome == AccessOutcome::refused || outcome == AccessOutcome::refused_or_not_addressed;
  if (announced && (no || outcome == AccessOutcome::ok)) {
    count(Rule::next_register, !no, access.cycle, "refused after P = 0");
  }
  announced_.reset();
  const bool selects = access.kind == SeenAccess::Kind::write && access.address == reg::bsel;
  if (outcome != AccessOutcome::ok || !access.next_available || selects ||
      access.address + 1U >= register_count) {
    return;
  }
  announced_ = {access.id, access.kind, static_cast<std::uint8_t>(access.address + 1U)};
}

void Conformance::judge_manufacturer(const SeenAccess& access) {
  if (access.kind != SeenAccess::Kind::read || access.address < reg::mfr_id) return;
  const bool no =
      access.outcome == AccessOutcome::refused || access.outcome == AccessOutcome::not_addressed;
  if (!no && access.outcome != AccessOutcome::ok) return;
  count(Rule::manufacturer, !no, access.cycle, "a mandatory register is refused");
  if (!no) manufacturer_seen_[access.id] |= 1U << (access.address - reg::mfr_id);
}

void Conformance::judge_profile(const SeenAccess& access, const SeenRegisters& seen) {
  if (access.outcome != AccessOutcome::ok || access.kind != SeenAccess::Kind::read) return;
  if (access.address != reg::bp_id && access.address != reg::bp_id + 1U) return;
  const auto stated = seen.identifier();
  if (!stated) return;
  const auto channel = profile_channel(*stated);
  if (!channel.ok()) {
    const bool unknown = channel.error() == ProfileError::none_given ||
                         channel.error() == ProfileError::unknown_profile ||
                         channel.error() == ProfileError::bp1_layout ||
                         channel.error() == ProfileError::no_channel ||
                         channel.error() == ProfileError::actuator;
    if (!unknown) count(Rule::profile, false, access.cycle, "no identifier of its profile");
    return;
  }
  if (!format_) {
    const auto only = profile_format(*stated);
    const bool alone = access.slaves_present == 1 && !access.more_slaves;
    stated_.reset();
    if (alone && only.ok()) stated_.emplace(*only);
    return;
  }
  const auto channels = format_->channels();
  const bool fits = std::any_of(channels.begin(), channels.end(), [&](const ChannelFormat& sent) {
    const bool same_check = !sent.crc.present() || !channel->crc.present() ||
                            sent.crc.polynomial == channel->crc.polynomial;
    return sent.total_bits() == channel->total_bits() && same_check;
  });
  count(Rule::profile, fits, access.cycle, "no channel of the frame has the length it states");
}

}  // namespace biss::decode
