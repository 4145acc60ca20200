// Everything that a master sees of a line, as a stepper: the cable, the encoder at its end, and
// their faults. The caller provides the master, for example in a simulator; Line has its own
// master.
//
//   MA ──ma_delay── filter ── Slave ── internal_delay ── slo_delay ──SLO
//                     or the caller's encoder
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <vector>

#include "biss/frame/codec.hpp"
#include "biss/slave/slave.hpp"
#include "biss/timing/device_timing.hpp"
#include "sim/disturbance.hpp"
#include "sim/encoder.hpp"
#include "sim/encoder_registers.hpp"
#include "sim/fault_details.hpp"
#include "sim/fault_schedule.hpp"
#include "sim/line.hpp"
#include "sim/line_setup.hpp"
#include "sim/pipe.hpp"
#include "sim/random.hpp"

namespace biss::sim {

struct FarEndSetup {
  /// The same as for Line, with one encoder. Faults are placed by its clock and interval; its other
  /// values of the master have no effect.
  LineSetup line;
  /// The longest processing time: each request has a different one, from line.processing up to
  /// this.
  Picoseconds processing_max{};
  /// A pulse of MA shorter than this does not reach the encoder; every other edge is delayed by it.
  Picoseconds ma_filter{};
  /// The caller provides the encoder, and the far end is only the cable. A fall of MA more than
  /// 1.25 periods after the previous one begins a request, for any state of the encoder.
  bool foreign_encoder = false;
};

/// The result of a step. All values hold until the next step.
struct FarEndOutput {
  bool slo = true;         ///< at the master
  bool ma = true;          ///< at the encoder
  Picoseconds deadline{};  ///< when step() is due again if no input changes before
};

/// The current request so far. It begins when MA falls after an idle time as long as the encoder's
/// timeout, or while the encoder is idle after an answer; see also FarEndSetup::foreign_encoder.
struct FarEndCycle {
  std::uint64_t number = 0;  ///< counts from 0
  Picoseconds begin{};       ///< MA falls at the master
  /// The time at which the encoder sampled the position that it sends; empty if it sampled none.
  std::optional<Picoseconds> sampled;
  /// Encoder::sent(), only if it sampled. After a fault it may sample again.
  Frame sent;
  FaultSet faults = 0;
  /// Faults that have a place in it, in the order of time.
  std::vector<InjectedFault> injected;
  /// The delay of the next request by the fault `delay`.
  Picoseconds lateness{};
};

class FarEnd {
 public:
  /// \pre as for Line, slaves is 1, processing_max is not below line.processing; with a foreign
  ///   encoder no rule is of a kind that needs_encoder()
  explicit FarEnd(const FarEndSetup& setup) : FarEnd(setup, nominal_of(setup)) {}

  FarEnd(const FarEnd&) = delete;
  FarEnd& operator=(const FarEnd&) = delete;

  /// The cycle by which faults are placed. \pre as for the constructor, except for the rules
  // The longest ACK and the delay of the filter belong to an undisturbed cycle.
  static NominalCycle nominal_of(const FarEndSetup& setup) {
    LineSetup line = setup.line;
    line.processing = setup.processing_max;
    line.internal_delay += setup.ma_filter;
    return Line(line).nominal();
  }

  /// Call it at each change of an input and at the deadline. Actions that were due earlier come
  /// first.
  /// \param foreign_slo the level that the caller's encoder drives; ignored without such an encoder
  FarEndOutput step(Picoseconds now, bool ma, bool foreign_slo) {
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

  /// The last request that began; nothing before the first one. Valid until the next step.
  const FarEndCycle* cycle() const { return requests_ == 0 ? nullptr : &cycle_; }
  const NominalCycle& nominal() const { return schedule_.nominal(); }
  Encoder& encoder() { return slave_.source(); }
  /// Flags that the encoder reports in addition to faults, from the next sample on.
  void set_flags(bool nE, bool nW) {
    nE_ = nE;
    nW_ = nW;
    put_flags();
  }

  SlaveState state() const { return slave_.state(); }
  /// The registers now, and the registers after a loss of supply. \pre the setup has registers
  EncoderRegisters& registers() { return *registers_; }
  EncoderRegisters& initial_registers() { return setup_.line.registers[0]; }

 private:
  using Codec = FrameCodec<>;
  using Encoding = Slave<Codec, Encoder>;

  FarEnd(const FarEndSetup& setup, const NominalCycle& nominal)
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

  static Encoding make_slave(const FarEndSetup& setup, const NominalCycle& nominal) {
    const LineSetup& line = setup.line;
    Motion motion(line.motion, position_word(line.format), nominal.interval, line.seed);
    if (line.position) motion.hold(*line.position);
    return Encoding(Codec(line.format), slave_timing(line.timing, line.processing),
                    Encoder(line.format, motion, line.life, line.drift));
  }

  SlaveTiming timing_of_request() const {
    const LineSetup& line = setup_.line;
    const Picoseconds more = setup_.processing_max - line.processing;
    const std::uint64_t drawn =
        Random(~line.seed ^ scrambled(cycle_.number)).below(time_parts + 1U);
    SlaveTiming timing = slave_timing(line.timing, line.processing + part_of(more, drawn));
    if (!disturbance_.active(FaultKind::late_start)) return timing;
    return late_timing(timing, line.timing, schedule_.detail(FaultKind::late_start), period_);
  }

  // The first clock of a request shows the clock of the master: at first its low time, half a period.
  void take_rise() {
    last_rise_ = now_;
    if (requests_ == 0 || rises_ == 2) return;
    ++rises_;
    const Picoseconds since = now_ - cycle_.begin;
    reference_ = rises_ == 1 ? since * 3 : since;
    if (rises_ == 1) fall_period_ = std::max(fall_period_, since * 2);
  }

  // MA falls. It has rested, at 1 or at a CDM of 1, as long as the encoder's timeout; or the encoder
  // has become idle earlier. A shorter rest is a gap between the bytes of an SPI master, for example.
  bool begins_request() const {
    if (requests_ == 0) return true;
    if (now_ - last_fall_ <= fall_period_ + fall_period_ / 4) return false;
    if (setup_.foreign_encoder) return true;
    if (std::max(last_rise_ - last_fall_, now_ - last_rise_) >= timeout()) return true;
    const bool on_its_way = ma_pipe_.front() != never || filter_due_ != never;
    const bool answered = cycle_.sampled || restarted_;
    return !on_its_way && answered && slave_.state() == SlaveState::idle;
  }

  // The rest of MA that ends a frame. With the rule `cycle` a frame may last longer; a request in it
  // is one that the encoder ignores.
  Picoseconds timeout() const {
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

  void begin_request() {
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

  void run_until(Picoseconds time) {
    for (Picoseconds next = next_event(); next < time; next = next_event()) {
      now_ = std::max(now_, next);
      run_now();
    }
  }

  // Everything that is due; without delays, one event makes the next at the same time.
  void run_now() {
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

  Picoseconds next_event() const {
    return std::min(
        {schedule_.next(), ma_pipe_.front(), filter_due_, slave_due_, slo_pipe_.front()});
  }

  void take_ma(bool ma) {
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

  void put_ma() {
    const bool wire = disturbance_.level(Place::ma_master, ma_);
    const bool level = disturbance_.level(Place::ma_slave, wire);
    if (level == ma_sent_) return;
    ma_sent_ = level;
    ma_pipe_.send(now_, setup_.line.ma_delay, setup_.line.ma_jitter, random_);
  }

  void step_slave(bool ma_changed) {
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
  void apply_timing() {
    slave_.step(now_, true, false);
    if (slave_.state() == SlaveState::idle) slave_.set_timing(*timing_);
    timing_.reset();
  }

  void put_slave() {
    const SlaveState state = slave_.state();
    const bool sends = state == SlaveState::data || state == SlaveState::stop;
    const bool inverted = sends && disturbance_.inverts(payload_bit_);
    const bool level = disturbance_.level(Place::slo_slave, slave_level_ != inverted);
    if (level == slo_sent_) return;
    slo_sent_ = level;
    slo_pipe_.send(now_, setup_.line.internal_delay + slo_delay_, setup_.line.slo_jitter, random_);
  }

  void put_slo() { slo_ = disturbance_.level(Place::slo_master, slo_arrived_); }

  void act() {
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

  void begin_fault(FaultKind kind) {
    const std::uint64_t detail = schedule_.detail(kind);
    disturbance_.begin(kind, schedule_, setup_.line.format,
                       place_after(now_ - cycle_.begin, period_), cycle_.injected);
    encoder().begin_fault(kind, detail);
    if (kind == FaultKind::brown_out) restart();
    if (kind == FaultKind::delay) cycle_.lateness = nominal().interval * late_cycles(detail);
    if (kind == FaultKind::delay_step) {
      slo_delay_ = setup_.line.slo_delay + delay_step(detail, period_);
    }
  }

  void end_fault(FaultKind kind) {
    disturbance_.end(kind);
    encoder().end_fault(kind);
    if (kind == FaultKind::brown_out) restart();
    if (kind == FaultKind::delay_step) slo_delay_ = setup_.line.slo_delay;
  }

  void put_flags() {
    encoder().set_flags(nE_ && !disturbance_.active(FaultKind::nE),
                        nW_ && !disturbance_.active(FaultKind::nW),
                        disturbance_.active(FaultKind::frozen));
  }

  // Without supply an encoder loses everything but its position.
  void restart() {
    restarted_ = true;
    slave_ = Encoding(slave_.codec(), slave_.timing(), slave_.source());
    slave_due_ = never;
    slave_level_ = setup_.foreign_encoder ? slave_level_ : true;
    encoder().restart();
    if (!registers_) return;
    *registers_ = setup_.line.registers[0];
    encoder().set_registers(*registers_);
  }

  FarEndSetup setup_;
  Picoseconds period_;
  Picoseconds fall_period_;  // of MA as it runs
  Picoseconds reference_{};  // 1.5 periods of MA, as the encoder measures them
  Random random_;
  FaultSchedule schedule_;
  Disturbance disturbance_;
  Encoding slave_;
  std::optional<EncoderRegisters> registers_;
  Pipe ma_pipe_;
  Pipe slo_pipe_;
  FarEndCycle cycle_;
  std::uint64_t requests_ = 0;
  std::optional<SlaveTiming> timing_;  // from the request under way on, once it is there
  Picoseconds now_{};
  Picoseconds slo_delay_;
  Picoseconds slave_due_ = never;
  Picoseconds filter_due_ = never;
  Picoseconds last_fall_{};  // of MA
  Picoseconds last_rise_{};
  unsigned rises_ = 0;      // of MA since the request began, up to 2
  bool restarted_ = false;  // the encoder, since the request began
  unsigned payload_bit_ = 0;
  bool ma_ = true;           // the master drives
  bool ma_sent_ = true;      // on its way
  bool ma_raw_ = true;       // at the encoder, before its filter
  bool ma_slave_ = true;     // as the encoder sees it
  bool slave_level_ = true;  // the encoder drives
  bool slo_sent_ = true;     // on its way
  bool slo_arrived_ = true;
  bool slo_ = true;  // as the master sees it
  bool nE_ = true;
  bool nW_ = true;
};

/// Whether the fault is one of the encoder itself, which a cable cannot make.
constexpr bool needs_encoder(FaultKind kind) {
  switch (kind) {
    case FaultKind::flip:
    case FaultKind::burst:
    case FaultKind::late_start:
    case FaultKind::nE:
    case FaultKind::nW:
    case FaultKind::frozen:
      return true;
    case FaultKind::delay:
      return false;
    default:
      return static_cast<std::size_t>(kind) >= line_fault_kind_count;
  }
}

}  // namespace biss::sim
