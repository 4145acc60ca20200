#include "sim/line.hpp"

#include <algorithm>

#include "biss/timing/device_timing.hpp"
#include "sim/fault_details.hpp"

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

// The channels of slave k, counted from the far end.
FrameFormat part_of(const FrameFormat& format, std::size_t slaves, std::size_t k) {
  FrameFormat part;
  part.cds0 = format.cds0;
  const std::size_t first = slaves - 1U - k;
  const std::size_t count = k == 0 ? format.channel_count - first : 1;
  part.channel_count = static_cast<std::uint8_t>(count);
  for (std::size_t i = 0; i < count; ++i) part.channel_list[i] = format.channel_list[first + i];
  return part;
}

}  // namespace

Picoseconds least_interval(const LineSetup& setup) { return Line::undisturbed(setup).interval; }

Line::Undisturbed Line::undisturbed(LineSetup setup) {
  setup.faults.clear();
  setup.record_at_slave = false;
  Line line(setup, {.interval = picoseconds(1)});
  line.control_.reset();
  Undisturbed nominal;
  for (int i = 0; i < probe_cycles; ++i) {
    const SimulatedCycle& cycle = line.next();
    nominal.interval = std::max(nominal.interval, line.begin_ - cycle.time);
    nominal.clocks = cycle.reading.clocks;
    // LAT, ACK, START and CDS come before.
    nominal.data_clock = 3U + cycle.reading.ack_clocks;
    nominal.line_delay = cycle.reading.line_delay.value_or(Picoseconds{});
  }
  nominal.interval += 2 * (setup.ma_jitter + setup.slo_jitter);
  return nominal;
}

Line::Line(const LineSetup& setup) : Line(setup, undisturbed(setup)) {}

Line::Line(const LineSetup& setup, const Undisturbed& nominal)
    : setup_(setup),
      period_(real_period(setup)),
      // The master checks each frame alone, without its neighbours.
      master_(Codec(setup.format.without_previous()), master_setup(setup)),
      registers_(setup.registers),
      random_(setup.seed),
      schedule_(setup.faults, setup.seed),
      full_(setup.slaves > 1 || !schedule_.empty() || setup.has_control()),
      interval_(std::max(setup.interval, nominal.interval)),
      begin_(setup.begin + idle_periods * period_),
      number_(setup.first_cycle),
      slo_delay_(setup.slo_delay) {
  schedule_.set_nominal({.period = period_,
                         .low_time = master_.setup().low_time,
                         .interval = interval_,
                         .clocks = std::max(nominal.clocks, 1U),
                         .data_clock = nominal.data_clock,
                         .line_delay = nominal.line_delay,
                         .payload_bits = setup.format.payload_bits()});
  add_nodes();
  if (setup.has_control()) {
    control_ = std::make_unique<ControlMaster>(setup.accesses, setup.control);
  }
  now_ = begin_;
}

void Line::add_nodes() {
  nodes_.reserve(setup_.slaves);
  for (std::size_t k = 0; k < setup_.slaves; ++k) {
    const FrameFormat format = part_of(setup_.format, setup_.slaves, k);
    Motion motion(setup_.motion, position_word(format), interval_, setup_.seed + k);
    if (setup_.position) motion.hold(*setup_.position);
    SignOfLife life = setup_.life;
    // The start values are by channel of the whole frame.
    const std::size_t first = setup_.slaves - 1U - k;
    std::copy(setup_.life.starts.begin() + static_cast<std::ptrdiff_t>(first),
              setup_.life.starts.end(), life.starts.begin());
    nodes_.push_back({.slave = Encoding(Codec(format), node_timing(k),
                                        Encoder(format, motion, life, setup_.drift))});
  }
  if (registers_.empty()) return;
  registers_.resize(setup_.slaves);
  for (std::size_t k = 0; k < nodes_.size(); ++k) {
    nodes_[k].slave.source().set_registers(registers_[k]);
  }
}

SlaveTiming Line::node_timing(std::size_t k) const {
  SlaveTiming timing = slave_timing(setup_.timing, setup_.processing);
  timing.chained = k != 0;
  // Only the encoder at the far end has the fixed ACK of the device.
  if (timing.chained) timing.ack_clocks = 0;
  return timing;
}

const SimulatedCycle& Line::next() {
  cycle_.edges.clear();
  begin_request();
  full_ ? run_request<true>() : run_request<false>();
  cycle_.reading = master_.reading();
  if (control_) end_control();
  rest();
  set_sent();
  ++number_;
  return cycle_;
}

void Line::begin_request() {
  cycle_.time = begin_;
  cycle_.faults = 0;
  cycle_.injected.clear();
  pause_begins_ = false;
  for (std::size_t k = 0; k < nodes_.size(); ++k) {
    nodes_[k].slave.source().begin_cycle(sampling_shift(setup_.timing, setup_.seed + k, number_));
  }
  schedule_.begin_cycle(number_, begin_);
  if (!schedule_.empty()) {
    act();
    set_start(disturbance_.active(FaultKind::late_start));
    cycle_.faults |= disturbance_.active();
  }
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

template <bool Full>
void Line::run_request() {
  while (!master_.done()) {
    const Picoseconds due = master_due_ < pause_ ? master_due_ : std::max(master_due_, pause_end_);
    now_ = std::min(due, next_event<Full>());
    const bool slo_changed = step_line<Full>();
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

// Until the next request begins.
void Line::rest() {
  const auto run = [this](Picoseconds end, bool until_ready) {
    full_ ? run_rest<true>(end, until_ready) : run_rest<false>(end, until_ready);
  };
  const bool sees_slo = setup_.interval.count == 0;
  const Picoseconds rested = sees_slo || !master_.reading().frame.ok() ? now_ + period_ : now_;
  run(std::max({begin_ + interval_ + lateness_, master_.earliest(), rested}), false);
  lateness_ = {};
  if (!slo_ && !master_.ready_by_time(now_)) {
    run(now_ + slo_wait_max, true);
    run(now_ + period_, false);
  }
  begin_ = now_;
}

template <bool Full>
void Line::run_rest(Picoseconds end, bool until_ready) {
  for (Picoseconds next = next_event<Full>(); next <= end; next = next_event<Full>()) {
    now_ = next;
    step_line<Full>();
    if (until_ready && slo_) return;
  }
  now_ = end;
}

StepOutput Line::ask(bool seen) {
  rises_ = 0;
  pause_ = pause_end_ = now_;
  const bool is_short = (cycle_.faults & set_of(FaultKind::short_frame)) != 0;
  const bool is_reduced = (cycle_.faults & set_of(FaultKind::reduced_frame)) != 0;
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

// After a rising edge of MA.
void Line::pause() {
  ++rises_;
  const bool regular = setup_.pause_clocks != 0 && rises_ % setup_.pause_clocks == 0 &&
                       rises_ < schedule_.nominal().clocks;
  if (!regular && !pause_begins_) return;
  pause_begins_ = false;
  cycle_.faults |= set_of(FaultKind::ma_pause);
  const auto periods = static_cast<std::int64_t>(1 + schedule_.detail(FaultKind::ma_pause) % 16U);
  const Picoseconds length = setup_.pause.count != 0 ? setup_.pause : period_ * periods;
  pause_ = now_ + period_ - master_.setup().low_time;
  pause_end_ = pause_ + length;
}

// In the order on the line: the nearest encoder first.
void Line::set_sent() {
  cycle_.sent = Frame{};
  cycle_.sampled = nodes_.back().slave.source().sampled();
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

template <bool Full>
Picoseconds Line::next_event() const {
  const Node& far = nodes_.front();
  Picoseconds next = std::min({ma_pipe_.front(), far.due, far.slo.front()});
  if constexpr (!Full) return next;
  for (const Node& node : nodes_) next = std::min({next, node.due, node.slo.front()});
  return std::min(next, schedule_.next());
}

// Everything that happens now, except the master's step. True: SLO has changed at the master.
template <bool Full>
bool Line::step_line() {
  const bool slo_before = slo_;
  if constexpr (Full) {
    if (schedule_.next() <= now_) act();
  }
  const bool ma_changed = ma_pipe_.front() <= now_;
  if (ma_changed) {
    ma_pipe_.pop();
    ma_slave_ = !ma_slave_;
    if (setup_.record_at_slave) record(ma_at_slave_line, ma_slave_);
  }
  step_node<Full>(0, ma_changed);
  for (std::size_t k = 1; Full && k < nodes_.size(); ++k) step_node<Full>(k, ma_changed);
  Pipe& last = Full ? nodes_.back().slo : nodes_.front().slo;
  if (last.front() <= now_) {
    last.pop();
    slo_arrived_ = !slo_arrived_;
    put_slo<Full>();
  }
  return slo_ != slo_before;
}

template <bool Full>
void Line::step_node(std::size_t k, bool ma_changed) {
  Node& node = nodes_[k];
  bool sli_changed = false;
  if (Full && k != 0 && nodes_[k - 1U].slo.front() <= now_) {
    nodes_[k - 1U].slo.pop();
    node.sli = !node.sli;
    sli_changed = true;
  }
  if (!ma_changed && !sli_changed && now_ < node.due) return;
  if (Full && k == 0 && start_ && ma_changed && !ma_slave_) apply_start();
  const SlaveState before = node.slave.state();
  const StepOutput out = node.slave.step(now_, ma_slave_, node.sli);
  node.due = out.deadline;
  if (Full) node.slave.source().follow(node.slave.state());
  if (Full && k + 1U == nodes_.size() && ma_changed && ma_slave_) {
    count_payload(before, node.slave.state());
  }
  put_node<Full>(k, out.level);
}

// Counts the bit of the payload that follows a rising edge of MA.
void Line::count_payload(SlaveState before, SlaveState after) {
  if (after < SlaveState::data || after > SlaveState::stop) return;
  payload_bit_ = before == SlaveState::start ? 0U - 1U : payload_bit_ + 1U;
}

template <bool Full>
void Line::put_ma() {
  bool level = ma_;
  if constexpr (Full) level = disturbance_.level(Place::ma_master, level);
  if (level != ma_wire_) {
    ma_wire_ = level;
    record(ma_line, level);
  }
  if constexpr (Full) level = disturbance_.level(Place::ma_slave, level);
  if (level == ma_sent_) return;
  ma_sent_ = level;
  ma_pipe_.send(now_, setup_.ma_delay, setup_.ma_jitter, random_);
}

template <bool Full>
void Line::put_node(std::size_t k, bool level) {
  Node& node = nodes_[k];
  const bool last = !Full || k + 1U == nodes_.size();
  if (Full && last) {
    const SlaveState state = node.slave.state();
    const bool sends = state == SlaveState::data || state == SlaveState::stop;
    level = disturbance_.level(Place::slo_slave,
                               level != (sends && disturbance_.inverts(payload_bit_)));
  }
  if (level == node.level) return;
  node.level = level;
  if (!last) return node.slo.send(now_, setup_.internal_delay, {}, random_);
  if (setup_.record_at_slave) record(slo_at_slave_line, level);
  node.slo.send(now_, setup_.internal_delay + slo_delay_, setup_.slo_jitter, random_);
}

template <bool Full>
bool Line::put_slo() {
  bool level = slo_arrived_;
  if constexpr (Full) level = disturbance_.level(Place::slo_master, level);
  if (level == slo_) return false;
  slo_ = level;
  record(slo_line, level);
  return true;
}

void Line::act() {
  while (schedule_.next() <= now_) {
    const FaultAction action = schedule_.take();
    // A fault that ends with the begin of this cycle concerns only earlier cycles.
    if (action.begins || action.time > begin_) cycle_.faults |= set_of(action.kind);
    action.begins ? begin_fault(action.kind) : end_fault(action.kind);
  }
  for (Node& node : nodes_) {
    node.slave.source().set_flags(!disturbance_.active(FaultKind::nE),
                                  !disturbance_.active(FaultKind::nW),
                                  disturbance_.active(FaultKind::frozen));
    node.slave.source().set_late_turns(disturbance_.active(FaultKind::late_turns));
  }
  put_ma<true>();
  put_node<true>(nodes_.size() - 1U,
                 nodes_.back().slave.step(now_, ma_slave_, nodes_.back().sli).level);
  put_slo<true>();
}

// ---- Faults other than the levels that Disturbance changes

void Line::begin_fault(FaultKind kind) {
  const std::uint64_t detail = schedule_.detail(kind);
  disturbance_.begin(kind, schedule_, setup_.format, place_after(now_ - begin_, period_),
                     cycle_.injected);
  for (Node& node : nodes_) node.slave.source().begin_fault(kind, detail);
  if (kind == FaultKind::brown_out) restart();
  if (kind == FaultKind::ma_pause) pause_begins_ = true;
  if (kind == FaultKind::delay) lateness_ = interval_ * late_cycles(detail);
  if (kind == FaultKind::delay_step) slo_delay_ = setup_.slo_delay + delay_step(detail, period_);
}

void Line::end_fault(FaultKind kind) {
  disturbance_.end(kind);
  for (Node& node : nodes_) node.slave.source().end_fault(kind);
  if (kind == FaultKind::brown_out) restart();
  if (kind == FaultKind::delay_step) slo_delay_ = setup_.slo_delay;
}

// The timing of an idle encoder changes now, the timing of any other one when the request reaches
// it (apply_start()).
void Line::set_start(bool late) {
  Encoding& slave = nodes_.front().slave;
  SlaveTiming timing = node_timing(0);
  if (late) {
    timing = late_timing(timing, setup_.timing, schedule_.detail(FaultKind::late_start), period_);
  }
  start_.reset();
  if (slave.timing() == timing) return;
  if (slave.state() == SlaveState::idle) return slave.set_timing(timing);
  start_ = timing;
}

// The pending step comes first: at the highest rate an encoder becomes idle with the request. An
// encoder that is still not idle keeps its timing, and the cycle is marked.
void Line::apply_start() {
  Node& far = nodes_.front();
  far.slave.step(now_, true, far.sli);
  if (far.slave.state() == SlaveState::idle) {
    far.slave.set_timing(*start_);
  } else {
    cycle_.faults |= set_of(FaultKind::late_start);
  }
  start_.reset();
}

// Without supply an encoder loses everything but its position.
void Line::restart() {
  for (std::size_t k = 0; k < nodes_.size(); ++k) {
    Node& node = nodes_[k];
    node.slave = Encoding(node.slave.codec(), node.slave.timing(), node.slave.source());
    node.slave.source().restart();
    if (!registers_.empty()) {
      registers_[k] = k < setup_.registers.size() ? setup_.registers[k] : EncoderRegisters();
      node.slave.source().set_registers(registers_[k]);
    }
    node.due = never;
  }
}

// ---- The control communication, during the position frames and before the first one

// Switches the data channels as commanded.
void Line::switch_channels() {
  if (registers_.empty() && !schedule_.empty()) {
    for (Node& node : nodes_) node.slave.set_channels_active(true);
  }
  for (std::size_t k = 0; k < registers_.size(); ++k) {
    nodes_[k].slave.set_channels_active(registers_[k].channels_active());
  }
}

// Once CDS is known: CDM may depend on it.
void Line::answer_cds() {
  if (answered_ || master_.done() || !master_.reading().cds) return;
  answered_ = true;
  const CdsBit cds = *master_.reading().cds ? CdsBit::one : CdsBit::zero;
  master_.set_cdm(control_->step(number_, begin_, now_, cds));
}

// Without CDS, CDM is unknown: the master stopped before it.
void Line::end_control() {
  if (!answered_) control_->step(number_, begin_, now_, CdsBit::missing);
}

void Line::begin_configuration(const ConfigureOptions& options, Hertz clock) {
  configurer_ = std::make_unique<ConfigureCycle>(options, clock);
  master_due_ = configurer_->begin(now_).deadline;
}

const std::vector<wire::Edge>& Line::configure_next() {
  cycle_.edges.clear();
  const std::uint32_t made = configurer_->configurator().requests();
  while (!configurer_->done() && configurer_->configurator().requests() == made) {
    now_ = std::min(master_due_, next_event<true>());
    const bool slo_changed = step_line<true>();
    if (!slo_changed && now_ < master_due_) continue;
    switch_channels();
    const StepOutput out = configurer_->step(now_, slo_);
    master_due_ = out.deadline;
    if (out.level == ma_) continue;
    ma_ = out.level;
    put_ma<true>();
  }
  if (configurer_->done()) end_configuration();
  return cycle_.edges;
}

// MA is high, and SLO gets time to become high.
void Line::end_configuration() {
  configuration_ = configurer_->result();
  if (configuration_->ok()) {
    MasterSetup found = (*configuration_)->master_setup(period_);
    found.compensate = master_.setup().compensate;
    found.trust_cycle_time = master_.setup().trust_cycle_time;
    found.low_time = master_.setup().low_time;
    found.cdm = master_.setup().cdm;
    found.no_error_flag = found.unchecked = true;
    found.timing.clock_max = hertz_max;
    master_ = RequestCycle<Codec>(Codec((*configuration_)->format), found);
  }
  run_rest<true>(now_ + common_cycle, false);
  begin_ = now_;
}

}  // namespace biss::sim
