// Everything that a master sees of a line, as a stepper: the cable, the encoder at its end, and
// their faults. The caller provides the master, for example in a simulator; Line has its own
// master.
//
//   MA ──ma_delay── filter ── Slave ── internal_delay ── slo_delay ──SLO
//                     or the caller's encoder
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "biss/frame/codec.hpp"
#include "biss/slave/slave.hpp"
#include "sim/disturbance.hpp"
#include "sim/encoder.hpp"
#include "sim/encoder_registers.hpp"
#include "sim/fault_schedule.hpp"
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
  explicit FarEnd(const FarEndSetup& setup);
  FarEnd(const FarEnd&) = delete;
  FarEnd& operator=(const FarEnd&) = delete;

  /// The cycle by which faults are placed. \pre as for the constructor, except for the rules
  static NominalCycle nominal_of(const FarEndSetup& setup);

  /// Call it at each change of an input and at the deadline. Actions that were due earlier come
  /// first.
  /// \param foreign_slo the level that the caller's encoder drives; ignored without such an encoder
  FarEndOutput step(Picoseconds now, bool ma, bool foreign_slo);

  /// The last request that began; nothing before the first one. Valid until the next step.
  const FarEndCycle* cycle() const { return requests_ == 0 ? nullptr : &cycle_; }
  const NominalCycle& nominal() const { return schedule_.nominal(); }
  Encoder& encoder() { return slave_.source(); }
  /// Flags that the encoder reports in addition to faults, from the next sample on.
  void set_flags(bool nE, bool nW);
  SlaveState state() const { return slave_.state(); }
  /// The registers now, and the registers after a loss of supply. \pre the setup has registers
  EncoderRegisters& registers() { return *registers_; }
  EncoderRegisters& initial_registers() { return setup_.line.registers[0]; }

 private:
  using Codec = FrameCodec<>;
  using Encoding = Slave<Codec, Encoder>;

  FarEnd(const FarEndSetup& setup, const NominalCycle& nominal);
  static Encoding make_slave(const FarEndSetup& setup, const NominalCycle& nominal);
  SlaveTiming timing_of_request() const;
  void take_rise();
  bool begins_request() const;
  Picoseconds timeout() const;
  void begin_request();
  void run_until(Picoseconds time);
  void run_now();
  Picoseconds next_event() const;
  void take_ma(bool ma);
  void put_ma();
  void step_slave(bool ma_changed);
  void apply_timing();
  void put_slave();
  void put_slo();
  Picoseconds arrival(Picoseconds delay, Picoseconds jitter);
  void act();
  void begin_fault(FaultKind kind);
  void end_fault(FaultKind kind);
  void put_flags();
  void restart();

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
