// Cable and encoders with their faults, without a master: the common part of Line and FarEnd.
#pragma once

#include <algorithm>
#include <cstddef>
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
#include "sim/random.hpp"
#include "wire/edge.hpp"

namespace biss::sim {

/// The index of each line in the edges: at the master and, if recorded, at the encoder next to it.
inline constexpr wire::LineIndex ma_line = 0;
inline constexpr wire::LineIndex slo_line = 1;
inline constexpr wire::LineIndex ma_at_slave_line = 2;
inline constexpr wire::LineIndex slo_at_slave_line = 3;

/// Edges of a level in flight, first in, first out; each inverts the level.
class Pipe {
 public:
  /// The arrival of the next edge; `never` without one in flight.
  Picoseconds front() const { return front_; }

  /// Adds an edge that is sent now: it arrives after the delay, give or take the jitter, or a
  /// picosecond after the previous one: edges do not overtake each other.
  void send(Picoseconds now, Picoseconds delay, Picoseconds jitter, Random& random) {
    Picoseconds arrival = now + delay;
    if (jitter.count != 0) {
      const auto width = static_cast<std::uint64_t>(2 * jitter.count + 1);
      arrival += picoseconds(static_cast<std::int64_t>(random.below(width))) - jitter;
    }
    if (front_ == never) {
      front_ = arrival;
    } else {
      const Picoseconds last = later_.empty() ? front_ : later_.back();
      later_.push_back(std::max(arrival, last + picoseconds(1)));
    }
  }
  /// \pre front() is not `never`
  void pop() {
    front_ = next_ == later_.size() ? never : later_[next_++];
    if (next_ == 0 || (next_ < later_.size() && next_ < 1024)) return;
    later_.erase(later_.begin(), later_.begin() + static_cast<std::ptrdiff_t>(next_));
    next_ = 0;
  }

 private:
  Picoseconds front_ = never;
  std::vector<Picoseconds> later_;
  std::size_t next_ = 0;  // to be in front; the arrivals before it have been
};

/// Line and FarEnd decide when a cycle begins, drive MA by put_ma(), and call step() at each event.
class EncoderSide {
 public:
  EncoderSide(const EncoderSide&) = delete;
  EncoderSide& operator=(const EncoderSide&) = delete;

  /// The cycle by which faults are placed.
  const NominalCycle& nominal() const { return schedule_.nominal(); }

 protected:
  using Codec = FrameCodec<>;
  using Encoding = Slave<Codec, Encoder>;
  struct Node {
    Encoding slave;
    Pipe slo{};
    Picoseconds due = never;
    bool level = true;  // as it enters the pipe
    bool sli = true;
  };

  /// \param nominal the interval of the setup replaces a shorter one
  EncoderSide(const LineSetup& setup, NominalCycle nominal);
  ~EncoderSide() = default;

  SlaveTiming node_timing(std::size_t k) const;
  void begin_cycle(std::uint64_t number, Picoseconds begin);
  /// The timing of the far end from the next fall of MA there, unless it is not idle then.
  void set_start(const SlaveTiming& timing);
  void switch_channels();
  void put_flags();
  /// A fault begins now and lasts until it is released.
  void hold_fault(FaultKind kind);
  void release_fault(FaultKind kind);

  // Full: there may be faults, several encoders, control communication or a filter. Without them
  // this takes two thirds of the time.
  template <bool Full>
  void put_ma();
  template <bool Full>
  void put_node(std::size_t k, bool level);
  template <bool Full>
  Picoseconds next_event() const;
  /// Everything that happens now at this side. True: SLO has changed at the master.
  template <bool Full>
  bool step();

  LineSetup setup_;
  FaultSchedule schedule_;
  Disturbance disturbance_;
  std::vector<EncoderRegisters> registers_;  // the far end's first; none or one for each node
  std::vector<Node> nodes_;                  // the far end's first
  /// In the order of time, of all lines.
  std::vector<wire::Edge> edges_;
  Picoseconds now_{};
  Picoseconds begin_{};  // of the cycle
  bool ma_ = true;       // the master drives
  bool slo_ = true;      // as the master sees it
  bool ma_slave_ = true;
  Picoseconds ma_filter_{};
  /// The caller drives this level in place of an encoder.
  std::optional<bool> foreign_level_;
  /// After a loss of supply the encoder waits for an edge of MA; else a low MA is an edge for it.
  bool waits_for_edge_ = false;
  bool nE_ = true;
  bool nW_ = true;

  // Since the cycle began.
  FaultSet faults_ = 0;
  std::vector<InjectedFault> injected_;
  Picoseconds lateness_{};     // of the next request, by `delay`
  bool pause_begins_ = false;  // of MA, with its next rising edge
  bool restarted_ = false;
  bool start_refused_ = false;  // set_start() had no effect

  bool is_on_its_way() const { return ma_pipe_.front() != never || filter_due_ != never; }

 private:
  bool take(Pipe& pipe, bool& level) const;
  template <bool Full>
  void step_node(std::size_t k, bool ma_changed);
  template <bool Full>
  void put_slo();
  template <bool Full>
  bool level_at(Place place, bool level) const;
  void record(wire::LineIndex line, bool level) {
    edges_.push_back({now_, line, level ? wire::Level::high : wire::Level::low});
  }
  void act();
  void put_levels();
  void begin_fault(FaultKind kind);
  void end_fault(FaultKind kind);
  void apply_start();
  void restart();

  Random random_;
  Pipe ma_pipe_;
  Picoseconds filter_due_ = never;
  Picoseconds slo_delay_{};
  std::optional<SlaveTiming> start_;
  FaultSet held_ = 0;
  bool waiting_ = false;      // see waits_for_edge_
  unsigned payload_bit_ = 0;  // that the node next to the master sends
  bool ma_wire_ = true;       // at the master
  bool ma_sent_ = true;       // on its way to the slaves
  bool ma_raw_ = true;        // before the filter
  bool slo_arrived_ = true;
};

}  // namespace biss::sim
