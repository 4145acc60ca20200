#include "sim/line.hpp"

#include <algorithm>

#include "biss/timing/device_timing.hpp"
#include "sim/encoder_side_steps.hpp"

namespace biss::sim {

namespace {

// A master that has waited this long for SLO makes the request anyway: the longest timeout of BiSS
// C.
constexpr Picoseconds slo_wait_max = biss_static_timeout_max;
constexpr int idle_periods = 20;
constexpr int probe_cycles = 4;

Picoseconds real_period(const LineSetup& setup) {
  constexpr std::int64_t million = 1'000'000;
  const std::int64_t rate = million + setup.clock_error_ppm;
  return picoseconds((period_of(setup.clock).count * million + rate / 2) / rate);
}

MasterSetup master_setup(const LineSetup& setup) {
  MasterSetup master;
  master.period = real_period(setup);
  master.timing = setup.timing;
  master.slaves = setup.slaves;
  master.compensate = setup.compensate;
  master.trust_cycle_time = setup.interval.count != 0;
  // A cycle leaves room for CDM = 1.
  master.cdm = setup.has_control();
  // Any format and any clock is allowed: it is the user's experiment.
  master.no_error_flag = master.unchecked = true;
  master.timing.clock_max = hertz_max;
  master.low_time = master.period * (1000 - std::int64_t{setup.duty_per_mille}) / 1000;
  return master;
}

}  // namespace

Picoseconds least_interval(const LineSetup& setup) { return Line::undisturbed(setup).interval; }

NominalCycle Line::undisturbed(LineSetup setup) {
  setup.faults.clear();
  setup.record_at_slave = false;
  NominalCycle nominal{.period = real_period(setup),
                       .low_time = master_setup(setup).low_time,
                       .interval = picoseconds(1),
                       .clocks = 1,
                       .payload_bits = setup.format.payload_bits()};
  Line line(setup, nominal);
  line.control_.reset();
  for (int i = 0; i < probe_cycles; ++i) {
    const SimulatedCycle& cycle = line.next();
    nominal.interval = std::max(nominal.interval, line.end() - cycle.time);
    nominal.clocks = std::max(cycle.reading.clocks, 1U);
    // LAT, ACK, START and CDS come before.
    nominal.data_clock = 3U + cycle.reading.ack_clocks;
    nominal.line_delay = cycle.reading.line_delay.value_or(Picoseconds{});
  }
  nominal.interval += 2 * (setup.ma_jitter + setup.slo_jitter);
  return nominal;
}

Line::Line(const LineSetup& setup) : Line(setup, undisturbed(setup)) {}

Line::Line(const LineSetup& setup, const NominalCycle& nominal)
    : EncoderSide(setup, nominal),
      // The master checks each frame alone, without its neighbours.
      master_(Codec(setup.format.without_previous()), master_setup(setup)),
      full_(setup.slaves > 1 || !schedule_.empty() || setup.has_control()),
      next_begin_(setup.begin + idle_periods * nominal.period),
      number_(setup.first_cycle) {
  if (setup.has_control()) {
    control_ = std::make_unique<ControlMaster>(setup.accesses, setup.control);
  }
  now_ = next_begin_;
}

const SimulatedCycle& Line::next() {
  edges_.clear();
  begin_request();
  full_ ? run_request<true>() : run_request<false>();
  cycle_.reading = master_.reading();
  // Without CDS, CDM is unknown: the master stopped before it.
  if (control_ && !answered_) control_->step(number_, begin_, now_, CdsBit::missing);
  rest();
  set_sent();
  ++number_;
  return cycle_;
}

void Line::begin_request() {
  begin_cycle(number_, next_begin_);
  if (!schedule_.empty()) set_start(node_timing(0));
  // The master does not begin while SLO is low, unless the encoder is ready by time.
  const bool seen = slo_ || !master_.ready_by_time(now_);
  switch_channels();
  answered_ = false;
  const StepOutput out = ask(seen);
  ma_ = out.level;
  master_due_ = out.deadline;
  if (slo_ != seen) master_due_ = master_.step(now_, slo_).deadline;
  full_ ? put_ma<true>() : put_ma<false>();
}

StepOutput Line::ask(bool seen) {
  rises_ = 0;
  pause_ = pause_end_ = now_;
  const bool is_short = (faults_ & set_of(FaultKind::short_frame)) != 0;
  const bool is_reduced = (faults_ & set_of(FaultKind::reduced_frame)) != 0;
  if (!is_short && !is_reduced) {
    return control_ ? master_.begin(now_, seen, false) : master_.begin(now_, seen);
  }
  bool cdm = false;
  if (is_reduced && control_) {
    // Without CDS, CDM is known from the beginning.
    cdm = control_->step(number_, begin_, now_, CdsBit::missing);
    answered_ = true;
  }
  // The channels of a short frame are inactive.
  for (Node& node : nodes_) node.slave.set_channels_active(false);
  return master_.begin(now_, seen, cdm,
                       is_reduced ? RequestKind::reduced : RequestKind::control_only);
}

template <bool Full>
void Line::run_request() {
  while (!master_.done()) {
    const Picoseconds due = master_due_ < pause_ ? master_due_ : std::max(master_due_, pause_end_);
    now_ = std::min(due, next_event<Full>());
    const bool slo_changed = step<Full>();
    const bool pauses = now_ >= pause_ && now_ < pause_end_;
    if (!slo_changed && (pauses || now_ < master_due_)) continue;
    // A pausing master keeps its clock, but sees the level of SLO.
    const StepOutput out = master_.step(pauses ? pause_ - picoseconds(1) : now_, slo_);
    master_due_ = out.deadline;
    if (Full && control_) answer_cds();
    if (out.level == ma_) continue;
    ma_ = out.level;
    put_ma<Full>();
    if (ma_) pause();
  }
}

// After a rising edge of MA.
void Line::pause() {
  ++rises_;
  const bool regular =
      setup_.pause_clocks != 0 && rises_ % setup_.pause_clocks == 0 && rises_ < nominal().clocks;
  if (!regular && !pause_begins_) return;
  pause_begins_ = false;
  faults_ |= set_of(FaultKind::ma_pause);
  const auto periods = static_cast<std::int64_t>(1 + schedule_.detail(FaultKind::ma_pause) % 16U);
  const Picoseconds length = setup_.pause.count != 0 ? setup_.pause : nominal().period * periods;
  pause_ = now_ + nominal().period - master_.setup().low_time;
  pause_end_ = pause_ + length;
}

// Once CDS is known: CDM may depend on it.
void Line::answer_cds() {
  if (answered_ || master_.done() || !master_.reading().cds) return;
  answered_ = true;
  const CdsBit cds = *master_.reading().cds ? CdsBit::one : CdsBit::zero;
  master_.set_cdm(control_->step(number_, begin_, now_, cds));
}

// Until the next request begins.
void Line::rest() {
  const Picoseconds period = nominal().period;
  const bool sees_slo = setup_.interval.count == 0;
  const Picoseconds rested = sees_slo || !master_.reading().frame.ok() ? now_ + period : now_;
  const auto run = [this](Picoseconds end, bool until_ready) {
    full_ ? run_rest<true>(end, until_ready) : run_rest<false>(end, until_ready);
  };
  run(std::max({begin_ + interval() + lateness_, master_.earliest(), rested}), false);
  if (!slo_ && !master_.ready_by_time(now_)) {
    run(now_ + slo_wait_max, true);
    run(now_ + period, false);
  }
  next_begin_ = now_;
}

template <bool Full>
void Line::run_rest(Picoseconds end, bool until_ready) {
  for (Picoseconds next = next_event<Full>(); next <= end; next = next_event<Full>()) {
    now_ = next;
    step<Full>();
    if (until_ready && slo_) return;
  }
  now_ = end;
}

// In the order on the line: the nearest encoder first.
void Line::set_sent() {
  cycle_.time = begin_;
  cycle_.sent = Frame{};
  cycle_.sampled = nodes_.back().slave.source().sampled();
  cycle_.faults = faults_;
  cycle_.injected = injected_;
  cycle_.edges.swap(edges_);
  // The encoder was not idle, and has kept its timing.
  if (start_refused_) cycle_.faults |= set_of(FaultKind::late_start);
  // Late turns are a fault only if the turns are wrong.
  if (std::none_of(nodes_.begin(), nodes_.end(),
                   [](Node& node) { return node.slave.source().has_late_turns(); })) {
    cycle_.faults &= ~set_of(FaultKind::late_turns);
  }
  for (std::size_t k = nodes_.size(); k-- > 0;) {
    Encoding& slave = nodes_[k].slave;
    const bool taken = slave.source().sampled().has_value();
    for (std::size_t i = 0; i < slave.codec().format().channel_count; ++i) {
      const std::size_t channel = cycle_.sent.channel_count++;
      cycle_.taken[channel] = taken;
      if (taken) cycle_.sent.channel_list[channel] = slave.source().sent().channel_list[i];
    }
  }
}

// ---- The configuration, before the first position frame

void Line::begin_configuration(const ConfigureOptions& options, Hertz clock) {
  configurer_ = std::make_unique<ConfigureCycle>(options, clock);
  master_due_ = configurer_->begin(now_).deadline;
}

const std::vector<wire::Edge>& Line::configure_next() {
  edges_.clear();
  const std::uint32_t made = configurer_->configurator().requests();
  while (!configurer_->done() && configurer_->configurator().requests() == made) {
    now_ = std::min(master_due_, next_event<true>());
    const bool slo_changed = step<true>();
    if (!slo_changed && now_ < master_due_) continue;
    switch_channels();
    const StepOutput out = configurer_->step(now_, slo_);
    master_due_ = out.deadline;
    if (out.level == ma_) continue;
    ma_ = out.level;
    put_ma<true>();
  }
  if (configurer_->done()) end_configuration();
  return edges_;
}

// MA is high, and SLO gets time to become high.
void Line::end_configuration() {
  configuration_ = configurer_->result();
  if (configuration_->ok()) {
    MasterSetup found = (*configuration_)->master_setup(nominal().period);
    found.compensate = master_.setup().compensate;
    found.trust_cycle_time = master_.setup().trust_cycle_time;
    found.low_time = master_.setup().low_time;
    found.cdm = master_.setup().cdm;
    found.no_error_flag = found.unchecked = true;
    found.timing.clock_max = hertz_max;
    master_ = RequestCycle<Codec>(Codec((*configuration_)->format), found);
  }
  run_rest<true>(now_ + common_cycle, false);
  next_begin_ = now_;
}

}  // namespace biss::sim
