#include "sim/far_end.hpp"

#include <algorithm>

#include "biss/timing/device_timing.hpp"
#include "sim/fault_details.hpp"
#include "sim/line.hpp"

namespace biss::sim {

// The longest ACK and the delay of the filter belong to an undisturbed cycle.
NominalCycle FarEnd::nominal_of(const FarEndSetup& setup) {
  LineSetup line = setup.line;
  line.processing = setup.processing_max;
  line.internal_delay += setup.ma_filter;
  return Line(line).nominal();
}

FarEnd::Encoding FarEnd::make_slave(const FarEndSetup& setup, const NominalCycle& nominal) {
  const LineSetup& line = setup.line;
  const auto channels = line.format.channels();
  const auto word = std::find_if(channels.begin(), channels.end(), [](const ChannelFormat& each) {
    return each.position_bits() != 0;
  });
  Motion motion(line.motion, word == channels.end() ? channels.front() : *word, nominal.interval,
                line.seed);
  if (line.position) motion.hold(*line.position);
  return Encoding(Codec(line.format), slave_timing(line.timing, line.processing),
                  Encoder(line.format, motion, line.life, line.drift));
}

FarEnd::FarEnd(const FarEndSetup& setup) : FarEnd(setup, nominal_of(setup)) {}

FarEnd::FarEnd(const FarEndSetup& setup, const NominalCycle& nominal)
    : setup_(setup),
      period_(period_of(setup.line.clock)),
      fall_period_(period_),
      random_(setup.line.seed),
      schedule_(setup.line.faults, setup.line.seed),
      slave_(make_slave(setup, nominal)),
      slo_delay_(setup.line.slo_delay) {
  schedule_.set_nominal(nominal);
  if (setup.line.registers.empty()) return;
  registers_ = setup.line.registers[0];
  encoder().set_registers(*registers_);
}

FarEndOutput FarEnd::step(Picoseconds now, bool ma, bool foreign_slo) {
  run_until(now);
  now_ = now;
  if (ma != ma_) take_ma(ma);
  if (setup_.foreign_encoder && foreign_slo != slave_level_) {
    slave_level_ = foreign_slo;
    put_slave();
  }
  run_now();
  return {slo_, ma_slave_, next_event()};
}

void FarEnd::run_until(Picoseconds time) {
  for (Picoseconds next = next_event(); next < time; next = next_event()) {
    now_ = std::max(now_, next);
    run_now();
  }
}

// Everything that is due; without delays, one event makes the next at the same time.
void FarEnd::run_now() {
  while (next_event() <= now_) {
    if (schedule_.next() <= now_) act();
    if (ma_pipe_.front() <= now_) {
      ma_pipe_.pop();
      ma_raw_ = !ma_raw_;
      filter_due_ = ma_raw_ == ma_slave_ ? never : now_ + setup_.ma_filter;
    }
    const bool ma_changed = filter_due_ <= now_;
    if (ma_changed) {
      filter_due_ = never;
      ma_slave_ = ma_raw_;
    }
    step_slave(ma_changed);
    if (slo_pipe_.front() <= now_) {
      slo_pipe_.pop();
      slo_arrived_ = !slo_arrived_;
      put_slo();
    }
  }
}

Picoseconds FarEnd::next_event() const {
  return std::min({schedule_.next(), ma_pipe_.front(), filter_due_, slave_due_, slo_pipe_.front()});
}

// ---- MA

void FarEnd::take_ma(bool ma) {
  if (ma) {
    take_rise();
  } else {
    if (begins_request()) {
      begin_request();
    } else {
      fall_period_ = now_ - last_fall_;
    }
    last_fall_ = now_;
  }
  ma_ = ma;
  put_ma();
}

// The first clock of a request shows the clock of the master: at first its low time, half a period.
void FarEnd::take_rise() {
  last_rise_ = now_;
  if (requests_ == 0 || rises_ == 2) return;
  ++rises_;
  const Picoseconds since = now_ - cycle_.begin;
  reference_ = rises_ == 1 ? since * 3 : since;
  if (rises_ == 1) fall_period_ = std::max(fall_period_, since * 2);
}

// MA falls. It was idle, at 1 or at a CDM of 1, as long as the encoder's timeout; or the encoder
// has become idle earlier. A shorter idle time is a gap between the bytes of an SPI master, for
// example.
bool FarEnd::begins_request() const {
  if (requests_ == 0) return true;
  if (now_ - last_fall_ <= fall_period_ + fall_period_ / 4) return false;
  if (setup_.foreign_encoder) return true;
  if (std::max(last_rise_ - last_fall_, now_ - last_rise_) >= timeout()) return true;
  const bool on_its_way = ma_pipe_.front() != never || filter_due_ != never;
  const bool answered = cycle_.sampled || restarted_;
  return !on_its_way && answered && slave_.state() == SlaveState::idle;
}

// The idle time of MA that ends a frame. With the rule `cycle` a frame may last longer; the encoder
// ignores a request in it.
Picoseconds FarEnd::timeout() const {
  const Timeout& timeout = slave_.timing().timeout;
  const Picoseconds static_timeout = slave_.timing().static_timeout;
  const Picoseconds reference = std::min(reference_, static_timeout);
  switch (timeout.rule) {
    case TimeoutRule::fixed:
      return timeout.time;
    case TimeoutRule::cycle:
      return reference * timeout.release_half_periods / 3;
    case TimeoutRule::adaptive:
      break;
  }
  return std::min(reference + timeout.time, static_timeout);
}

void FarEnd::begin_request() {
  const LineSetup& line = setup_.line;
  cycle_.number = requests_++;
  cycle_.begin = now_;
  rises_ = 0;
  restarted_ = false;
  cycle_.sampled.reset();
  cycle_.sent = Frame{};
  cycle_.injected.clear();
  cycle_.lateness = {};
  if (registers_) slave_.set_channels_active(registers_->channels_active());
  encoder().begin_cycle(sampling_shift(line.timing, line.seed, cycle_.number));
  schedule_.begin_cycle(cycle_.number, now_);
  cycle_.faults = 0;
  act();
  cycle_.faults |= disturbance_.active();
  timing_ = timing_of_request();
}

SlaveTiming FarEnd::timing_of_request() const {
  const LineSetup& line = setup_.line;
  const Picoseconds more = setup_.processing_max - line.processing;
  const std::uint64_t drawn = Random(~line.seed ^ scrambled(cycle_.number)).below(time_parts + 1U);
  SlaveTiming timing = slave_timing(line.timing, line.processing + part_of(more, drawn));
  if (!disturbance_.active(FaultKind::late_start)) return timing;
  return late_timing(timing, line.timing, schedule_.detail(FaultKind::late_start), period_);
}

void FarEnd::put_ma() {
  const bool wire = disturbance_.level(Place::ma_master, ma_);
  const bool level = disturbance_.level(Place::ma_slave, wire);
  if (level == ma_sent_) return;
  ma_sent_ = level;
  ma_pipe_.push(arrival(setup_.line.ma_delay, setup_.line.ma_jitter));
}

// ---- The encoder

void FarEnd::step_slave(bool ma_changed) {
  if (setup_.foreign_encoder || (!ma_changed && now_ < slave_due_)) return;
  if (timing_ && ma_changed && !ma_slave_) apply_timing();
  const SlaveState before = slave_.state();
  const StepOutput out = slave_.step(now_, ma_slave_, false);
  slave_due_ = out.deadline;
  const SlaveState after = slave_.state();
  encoder().follow(after);
  if (ma_changed && ma_slave_ && after >= SlaveState::data && after <= SlaveState::stop) {
    payload_bit_ = before == SlaveState::start ? 0U - 1U : payload_bit_ + 1U;
  }
  if (encoder().sampled() != cycle_.sampled) {
    cycle_.sampled = encoder().sampled();
    if (cycle_.sampled) cycle_.sent = encoder().sent();
  }
  slave_level_ = out.level;
  put_slave();
}

// The pending step comes first: at the highest rate an encoder becomes idle with the request. An
// encoder that is still not idle keeps its timing.
void FarEnd::apply_timing() {
  slave_.step(now_, true, false);
  if (slave_.state() == SlaveState::idle) slave_.set_timing(*timing_);
  timing_.reset();
}

void FarEnd::put_slave() {
  const SlaveState state = slave_.state();
  const bool sends = state == SlaveState::data || state == SlaveState::stop;
  const bool inverted = sends && disturbance_.inverts(payload_bit_);
  const bool level = disturbance_.level(Place::slo_slave, slave_level_ != inverted);
  if (level == slo_sent_) return;
  slo_sent_ = level;
  slo_pipe_.push(arrival(setup_.line.internal_delay + slo_delay_, setup_.line.slo_jitter));
}

void FarEnd::put_slo() { slo_ = disturbance_.level(Place::slo_master, slo_arrived_); }

Picoseconds FarEnd::arrival(Picoseconds delay, Picoseconds jitter) {
  if (jitter.count == 0) return now_ + delay;
  const auto width = static_cast<std::uint64_t>(2 * jitter.count + 1);
  return now_ + delay - jitter + picoseconds(static_cast<std::int64_t>(random_.below(width)));
}

// ---- Faults

void FarEnd::act() {
  while (schedule_.next() <= now_) {
    const FaultAction action = schedule_.take();
    // A fault that ends with the begin of this request concerns only earlier requests.
    if (action.begins || action.time > cycle_.begin) cycle_.faults |= set_of(action.kind);
    action.begins ? begin_fault(action.kind) : end_fault(action.kind);
  }
  put_flags();
  put_ma();
  put_slave();
  put_slo();
}

void FarEnd::begin_fault(FaultKind kind) {
  disturbance_.begin(kind);
  const std::uint64_t detail = schedule_.detail(kind);
  const FrameFormat& format = setup_.line.format;
  if (kind == FaultKind::flip || kind == FaultKind::burst) {
    const BitPattern pattern =
        pattern_of(kind, detail, schedule_.place(kind), format.payload_bits());
    cycle_.injected.push_back({kind, {PlaceUnit::bit, std::uint64_t{pattern.first} * 1000U}});
    disturbance_.set(kind, pattern);
  } else if (has_place(kind)) {
    cycle_.injected.push_back(
        {kind, schedule_.place(kind).value_or(place_after(now_ - cycle_.begin, period_))});
  }
  encoder().begin_fault(kind, detail);
  if (kind == FaultKind::brown_out) restart();
  if (kind == FaultKind::masquerade) disturbance_.set(kind, noise_of(detail, format));
  if (kind == FaultKind::delay) cycle_.lateness = nominal().interval * late_cycles(detail);
  if (kind == FaultKind::delay_step)
    slo_delay_ = setup_.line.slo_delay + delay_step(detail, period_);
}

void FarEnd::end_fault(FaultKind kind) {
  disturbance_.end(kind);
  encoder().end_fault(kind);
  disturbance_.set(kind, {});
  if (kind == FaultKind::brown_out) restart();
  if (kind == FaultKind::delay_step) slo_delay_ = setup_.line.slo_delay;
}

void FarEnd::set_flags(bool nE, bool nW) {
  nE_ = nE;
  nW_ = nW;
  put_flags();
}

void FarEnd::put_flags() {
  encoder().set_flags(nE_ && !disturbance_.active(FaultKind::nE),
                      nW_ && !disturbance_.active(FaultKind::nW),
                      disturbance_.active(FaultKind::frozen));
}

// Without supply an encoder loses everything but its position.
void FarEnd::restart() {
  restarted_ = true;
  slave_ = Encoding(slave_.codec(), slave_.timing(), slave_.source());
  slave_due_ = never;
  slave_level_ = setup_.foreign_encoder ? slave_level_ : true;
  encoder().restart();
  if (!registers_) return;
  *registers_ = setup_.line.registers[0];
  encoder().set_registers(*registers_);
}

}  // namespace biss::sim
