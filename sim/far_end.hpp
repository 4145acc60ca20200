// Everything that a master sees of a line, as a stepper: the cable, the encoder at its end, and
// their faults. The caller provides the master, for example in a simulator; Line has its own
// master.
//
//   MA ──ma_delay── filter ── Slave ── internal_delay ── slo_delay ──SLO
//                     or the caller's encoder
#pragma once

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "sim/encoder_side.hpp"

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

class FarEnd : public EncoderSide {
 public:
  /// \pre as for Line, slaves is 1, processing_max is not below line.processing; with a foreign
  ///   encoder no rule is of a kind that needs_encoder()
  explicit FarEnd(const FarEndSetup& setup);

  /// The cycle by which faults are placed. \pre as for the constructor, except for the rules
  static NominalCycle nominal_of(const FarEndSetup& setup);

  /// Call it at each change of an input and at the deadline. Actions that were due earlier come
  /// first.
  /// \param foreign_slo the level that the caller's encoder drives; ignored without such an encoder
  FarEndOutput step(Picoseconds now, bool ma, bool foreign_slo);

  /// The last request that began; nothing before the first one. Valid until the next step.
  const FarEndCycle* cycle() const { return requests_ == 0 ? nullptr : &cycle_; }
  /// The request before it, complete; nothing before the second one. Valid until the next step.
  const FarEndCycle* previous() const { return requests_ < 2 ? nullptr : &previous_; }
  /// The number of requests; the next one has this number.
  std::uint64_t requests() const { return requests_; }

  /// The faults from the next request on; the rules of the setup end.
  /// \pre as for the constructor
  void set_faults(std::vector<FaultRule> rules) { schedule_.set_rules(std::move(rules)); }
  /// `cut` or `brown_out` lasts from now on, or ends: a plug that is pulled, a supply that is off.
  /// \pre now is not before the last step
  void set_lasting(FaultKind kind, bool lasts, Picoseconds now);
  /// The encoder moves in this way from now on.
  void set_motion(MotionKind kind) {
    encoder().set_motion(
        Motion(kind, position_word(setup_.format), nominal().interval, setup_.seed));
  }
  Encoder& encoder() { return nodes_[0].slave.source(); }
  /// Flags that the encoder reports in addition to faults, from the next sample on.
  void set_flags(bool nE, bool nW) {
    nE_ = nE;
    nW_ = nW;
    put_flags();
  }

  SlaveState state() const { return nodes_[0].slave.state(); }
  /// The registers now, and the registers after a loss of supply. \pre the setup has registers
  EncoderRegisters& registers() { return registers_[0]; }
  EncoderRegisters& initial_registers() { return setup_.registers[0]; }

 private:
  void take_rise();
  void take_fall();
  bool begins_request();
  Picoseconds timeout() const;
  void begin_request();
  void put_cycle();
  void run(Picoseconds end);

  Picoseconds processing_max_;
  FarEndCycle cycle_;
  FarEndCycle previous_;
  std::uint64_t requests_ = 0;
  Picoseconds fall_period_;  // of MA as it runs
  Picoseconds reference_{};  // 1.5 periods of MA, as the encoder measures them
  Picoseconds last_fall_{};  // of MA
  Picoseconds last_rise_{};
  unsigned rises_ = 0;  // of MA since the request began, up to 2
};

/// Whether a far end injects the fault in full: it does not need a master that takes part.
constexpr bool is_of_far_end(FaultKind kind) {
  return is_simulated(kind) && kind != FaultKind::delay;
}

/// Whether the fault is one of the encoder itself, which a cable cannot make.
bool needs_encoder(FaultKind kind);

}  // namespace biss::sim
