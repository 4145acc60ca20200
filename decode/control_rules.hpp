// Rules on control communication, registers and the data sheet in them.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string_view>

#include "biss/eds/profile.hpp"
#include "biss/frame/codec.hpp"
#include "decode/control_listener.hpp"
#include "decode/frame_rules.hpp"
#include "decode/seen_registers.hpp"

namespace biss::decode {

class ControlRules {
 public:
  ControlRules(const std::optional<FrameFormat>& format, Tallies& tallies)
      : format_(format),
        tallies_(tallies),
        listener_([this](const SeenAccess& access) { judge_access(access); }) {}

  ControlRules(const ControlRules&) = delete;
  ControlRules& operator=(const ControlRules&) = delete;

  void push(std::uint64_t number, const Cycle& cycle) {
    period_ = cycle.period.value_or(period_);
    judge_stated_crc(number, cycle);
    watch_silence(number, cycle);
    watch_stray(number, cycle);
  }

  void finish() { listener_.finish(); }

  /// The rule of that name, by all registers so far.
  RuleResult data_sheet() const {
    RuleResult result;
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
    if (result.cases == 0) return result;
    result.verdict = result.faults == 0 ? Verdict::pass : Verdict::fail;
    return result;
  }

  /// Both registers of the manufacturer of one slave were read.
  bool manufacturer_seen() const {
    return std::any_of(manufacturer_seen_.begin(), manufacturer_seen_.end(),
                       [](unsigned seen) { return seen == 3; });
  }

 private:
  // R and W, and the bit before them.
  static constexpr unsigned silent_cycles = 3;

  // A register that was accessed; its P announced that the next one can be accessed.
  struct Announced {
    std::uint8_t id = 0;
    SeenAccess::Kind kind = SeenAccess::Kind::unknown;
    std::uint8_t next = 0;
  };

  void count(Rule rule, bool good, std::uint64_t cycle, std::string_view note = {}) {
    tallies_.count_sampled(rule, good, period_, cycle, note);
  }

  void judge_stated_crc(std::uint64_t number, const Cycle& cycle) {
    if (!stated_ || !has_times(cycle.status)) return;
    const ChannelFormat& channel = stated_->format().channels().front();
    const BitView raw = cycle.raw.view();
    if (!channel.crc.present() || raw.size_bits() < channel.total_bits() + 2U) return;
    const std::uint64_t sent = raw.word(2U + channel.data_bits, channel.crc.width_bits);
    count(Rule::profile, sent == stated_->crc(0, raw.word(2, channel.data_bits), raw[1]), number,
          "the frame does not fit the profile identifier");
  }

  // After a damaged header the device must behave as if it was not addressed.
  void watch_silence(std::uint64_t number, const Cycle& cycle) {
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
  void watch_stray(std::uint64_t number, const Cycle& cycle) {
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
      count(Rule::cds_idle, listener_.stray_cds() == cds_before, number,
            "CDS = 1 without an access");
    }
    zeros_ = *cycle.cdm ? 0 : zeros_ + 1;
    settled_ = settled_ || zeros_ >= control_reset_zeros;
  }

  void judge_access(const SeenAccess& access) {
    const AccessOutcome outcome = access.outcome;
    if (outcome == AccessOutcome::header_crc) {
      silence_left_ = silent_cycles;
      damaged_at_ = access.cycle;
      broken_off_ = true;
      return;
    }
    if (outcome == AccessOutcome::cut_end || !access.header_sent) return;
    if (outcome == AccessOutcome::frame_lost || access.reduced) {
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

  void judge_ids(const SeenAccess& access) {
    const bool anybody = access.slaves_present != 0;
    const bool pattern = access.outcome == AccessOutcome::id_pattern ||
                         (access.slaves_present & (access.slaves_present + 1U)) != 0;
    if (!control_off_ || anybody) {
      count(Rule::id_answer, anybody || pattern, access.cycle, "IDL0 stays 0");
    }
    if (anybody || pattern) count(Rule::id_pattern, !pattern, access.cycle, "IDL has a gap");
    if (broken_off_ && answered_ && !control_off_) {
      count(Rule::control_reset, anybody || pattern, access.cycle,
            "no answer after an access that was aborted");
    }
    broken_off_ = access.outcome != AccessOutcome::ok && access.kind != SeenAccess::Kind::command;
    answered_ = answered_ || anybody;
  }

  void judge_register(const SeenAccess& access) {
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
    count(Rule::rw_pattern, !pattern, at, "R and W with levels that no slave sends");
    judge_manufacturer(access);
    if (refused || pattern) return;
    if (outcome == AccessOutcome::ok || outcome == AccessOutcome::data_crc ||
        outcome == AccessOutcome::busy_too_long) {
      tallies_.at_most(Rule::busy, access.busy, register_busy_max, {}, at);
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

  void judge_write(const SeenAccess& access) {
    const AccessOutcome outcome = access.outcome;
    const bool late = outcome == AccessOutcome::start_missing;
    if (late || outcome == AccessOutcome::ok || outcome == AccessOutcome::echo) {
      count(Rule::write_start, !late, access.cycle, "S of the first byte is not echoed");
    }
    if (outcome == AccessOutcome::ok || outcome == AccessOutcome::echo) {
      count(Rule::write_echo, outcome == AccessOutcome::ok, access.cycle,
            "the echo differs from the bits sent");
    }
  }

  // P = 0 has said that the next register can be accessed in the same way.
  void judge_next(const SeenAccess& access) {
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

  void judge_manufacturer(const SeenAccess& access) {
    if (access.kind != SeenAccess::Kind::read || access.address < reg::mfr_id) return;
    const bool no =
        access.outcome == AccessOutcome::refused || access.outcome == AccessOutcome::not_addressed;
    if (!no && access.outcome != AccessOutcome::ok) return;
    count(Rule::manufacturer, !no, access.cycle, "a mandatory register is refused");
    if (!no) manufacturer_seen_[access.id] |= 1U << (access.address - reg::mfr_id);
  }

  void judge_profile(const SeenAccess& access, const SeenRegisters& seen) {
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

  std::optional<FrameFormat> format_;
  Tallies& tallies_;
  ControlListener listener_;
  std::map<unsigned, SeenRegisters> slaves_;
  std::map<unsigned, std::uint64_t> last_access_;
  std::array<unsigned, control_max_slaves> manufacturer_seen_{};
  std::optional<Announced> announced_;
  // By the profile identifier of the only slave, if no format was given.
  std::optional<FrameCodec<>> stated_;
  // The period of the last cycle that has one.
  Picoseconds period_{};
  // Zeros of CDM since the last 1 or the last missing cycle.
  unsigned zeros_ = 0;
  bool settled_ = false;
  unsigned silence_left_ = 0;
  std::uint64_t damaged_at_ = 0;
  bool answered_ = false;
  bool broken_off_ = false;
  bool control_off_ = false;
};

}  // namespace biss::decode
