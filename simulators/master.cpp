#include "simulators/master.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "biss/timing/device_timing.hpp"
#include "device/quantity.hpp"

namespace biss::simulators {

Master::Master(std::string name, Settings settings)
    : Instance(Role::master, std::move(name), std::move(settings)), jitter_(this->settings().seed) {
  const Settings& chosen = this->settings();
  line_delay_ = in_turn(chosen.line_delays, 0);
  open_master(period_of(in_turn(chosen.clocks, 0)));
  coverage().expect("format", chosen.format_text);
  coverage().expect_values(chosen.format);
  coverage().expect_line();
  for (const char* bit : {"0", "1"}) coverage().expect("CDM", bit);
  coverage().expect_ack();
}

void Master::open_master(Picoseconds period) {
  if (period == period_) return;
  // A clock above the limit of the design tests this limit.
  biss_format device = settings().device;
  device.timing.clock_max_hz = std::max(device.timing.clock_max_hz, biss_clock_max.count);
  biss_master_setup setup = biss_master_defaults(&device, period.count);
  setup.no_error_flag = setup.unchecked = true;
  biss_master_init(&master_, &setup);  // the settings are valid
  period_ = period;
}

std::int64_t Master::step(std::int64_t now, bool slo, bool request) {
  now_ = std::max(now_, now);
  request_ = request;
  if (!started_) {
    started_ = true;
    not_before_ = now_ + std::max(period_.count, settings().device.timing.timeout.time_ps);
  }
  const auto jitter = static_cast<std::uint64_t>(settings().jitter.count);
  const std::int64_t half = (line_delay_ - line_delay_ / 2).count;
  if (slo != slo_sent_) {
    slo_sent_ = slo;
    if (slo) rise_ = {clocks_, now_ - last_edge_};
    const auto late = static_cast<std::int64_t>(jitter_.below(jitter + 1));
    if (!slo_.put(now_, slo, half + late)) {
      board().broken(requests(), now_, "SLO", "pulses that a cable carries", "too many pulses");
    }
  }
  for (std::int64_t due = deadline(); due <= now_; due = deadline()) advance(due);
  advance(now_);
  return deadline();
}

std::int64_t Master::deadline() const {
  std::int64_t due = std::min({ma_.due(), slo_.due(), output_.deadline_ps});
  if (!running_ && request_ && now_ < not_before_) due = std::min(due, not_before_);
  return due;
}

void Master::advance(std::int64_t now) {
  slo_.take(now);
  if (!running_ && request_ && now >= not_before_) begin(now);
  if (running_) {
    biss_master_step(&master_, now, slo_.received(), &output_);
    if (biss_master_done(&master_)) end(now);
  }
  ma_.put(now, output_.level, (line_delay_ / 2).count);
  if (!ma_.take(now)) return;
  last_edge_ = now;
  if (!ma_.received()) return;
  if (++clocks_ == 1) ++latches_;
}

void Master::begin(std::int64_t now) {
  // Another delay only when the cable is empty, and MA was high at the design.
  const Picoseconds line_delay = in_turn(settings().line_delays, requests());
  const std::int64_t empty = ma_.due() == BISS_NEVER ? last_edge_ : ma_.due();
  if (line_delay != line_delay_ && now < empty + period_.count) {
    not_before_ = empty + period_.count;
    return;
  }
  line_delay_ = line_delay;
  open_master(period_of(in_turn(settings().clocks, requests())));
  const biss_status status = biss_master_begin(&master_, now, slo_.received(),
                                               in_turn(settings().cdm, requests()), &output_);
  if (status != BISS_OK) {
    // SLO is low, or it is too early: try again when SLO changes, or at the master's deadline.
    not_before_ = output_.deadline_ps;
    if (not_before_ == BISS_NEVER) not_before_ = now + period_.count;
    output_.deadline_ps = BISS_NEVER;
    return;
  }
  running_ = true;
  rise_ = {};
  clocks_ = 0;
}

void Master::end(std::int64_t now) {
  running_ = false;
  output_.deadline_ps = BISS_NEVER;
  biss_reading reading{};
  if (biss_master_reading(&master_, &reading) != BISS_OK) return;
  Outcome outcome;
  outcome.request = requests();
  outcome.time_ps = now;
  outcome.cause = biss_cause_name(reading.cause);
  for (std::size_t k = 0; k < reading.channel_count; ++k) {
    outcome.values[k] = {reading.channels[k], true, true};
  }
  board().read(outcome);
  if (!reading.ready) {
    board().broken(requests(), now, "SLO after the frame", "1 after the timeout", "still 0");
  }
  coverage().hit("format", settings().format_text);
  if (reading.cause == BISS_CAUSE_OK) {
    if (reading.ready) check_release(now, reading.clocks);
    coverage().hit_values(settings().format, outcome);
    coverage().hit_line(Picoseconds{reading.line_delay_ps}, period_, settings().device.timing);
    coverage().hit("CDM", in_turn(settings().cdm, requests()) ? "1" : "0");
    coverage().hit_ack(reading.ack_clocks);
  }
  count_request();
  not_before_ = now + std::max(period_.count, in_turn(settings().pauses, requests()).count);
}

// How long SLO was low after the last edge of MA, both at the design. Two percent for the clock of
// the design.
void Master::check_release(std::int64_t now, std::uint32_t clocks) {
  const biss_timing& timing = settings().device.timing;
  if (timing.timeout.rule == BISS_TIMEOUT_CYCLE) return;
  const bool adaptive = timing.timeout.rule == BISS_TIMEOUT_ADAPTIVE;
  const std::int64_t reference = period_.count * 3 / 2;
  const std::int64_t least =
      adaptive ? reference : std::min(timing.timeout.time_ps, biss_static_timeout_min.count);
  const std::int64_t most = adaptive ? reference + timing.timeout.time_ps : timing.timeout.time_ps;
  const bool after_stop = rise_.clocks >= clocks;
  if (after_stop && rise_.low * 102 >= least * 100 && rise_.low * 100 <= most * 102) return;
  board().broken(
      requests(), now, "timeout",
      fmt::format("{} to {}", biss::text_of(picoseconds(least)), biss::text_of(picoseconds(most))),
      after_stop ? biss::text_of(picoseconds(rise_.low)) : "before STOP");
}

bool Master::compare(const std::string& cause) {
  board().sent(take_staged(latches_ == 0 ? 0 : latches_ - 1, now_, cause));
  return true;
}

void Master::finish() {
  // The simulation may end within a request, which would have ended by itself.
  if (running_) board().withdraw(requests());
  board().fail_waiting();
}

}  // namespace biss::simulators
