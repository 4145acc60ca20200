// Master, cable and encoders in picoseconds: an event loop around the core's steppers.
//
//   RequestCycle ──MA──> ma_delay ──┬──> Slave 0 ──> … ──> Slave n-1 ──> slo_delay ──SLO──> back
//        recorded here              └ in parallel          internal_delay each     recorded here
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "biss/configure/configure_cycle.hpp"
#include "biss/frame/codec.hpp"
#include "biss/master/request.hpp"
#include "biss/slave/slave.hpp"
#include "sim/control_master.hpp"
#include "sim/disturbance.hpp"
#include "sim/encoder.hpp"
#include "sim/encoder_registers.hpp"
#include "sim/fault_schedule.hpp"
#include "sim/line_setup.hpp"
#include "sim/pipe.hpp"
#include "sim/random.hpp"
#include "wire/edge.hpp"

namespace biss::sim {

/// The index of each line in the edges: at the master and, if recorded, at the encoder next to it.
inline constexpr wire::LineIndex ma_line = 0;
inline constexpr wire::LineIndex slo_line = 1;
inline constexpr wire::LineIndex ma_at_slave_line = 2;
inline constexpr wire::LineIndex slo_at_slave_line = 3;

/// One request cycle, up to the next request.
struct SimulatedCycle {
  Picoseconds time{};  ///< the first falling edge of MA
  /// The frame that the encoders sent, without the effect of faults: see Encoder::sent().
  Frame sent;
  /// Whether an encoder took a position for this channel of `sent`.
  std::array<bool, max_channels> taken{};
  /// When the encoder next to the master took the position that it sent.
  std::optional<Picoseconds> sampled;
  BasicReading<Frame> reading;
  /// The faults in it.
  FaultSet faults = 0;
  /// The faults that begin in it, in the order of time; only faults with a place.
  std::vector<InjectedFault> injected;
  /// In the order of time.
  std::vector<wire::Edge> edges;
};

/// Simulates one cycle after the other. The first request comes after 20 idle periods, MA and SLO
/// high.
///
/// When a request is due while SLO is low, the master waits for 40 µs and then makes the request
/// anyway, so that the line shows the result for a master without this check. With a given interval
/// it does not wait if the encoder is ready by its fixed cycle time
/// (RequestCycle::ready_by_time()).
///
/// If the encoders have registers or the master has accesses, each request also carries one bit of
/// control communication in each direction. The values of these bits delay no request.
class Line {
 public:
  /// \pre setup meets the conditions of LineSetup; setup.format has a channel, setup.clock is
  /// positive
  explicit Line(const LineSetup& setup);

  /// Valid until the next call. \pre !configuring()
  const SimulatedCycle& next();

  /// Lets an unconfigured, ideal master read the configuration from the encoders first. No fault is
  /// injected during this time. \pre next() has not been called
  /// \param clock 250 kHz to 1 MHz
  void begin_configuration(const ConfigureOptions& options, Hertz clock);
  bool configuring() const { return configurer_ && !configuration_; }
  /// Runs until one more request is answered. \return its edges, valid until the next call. \pre configuring()
  const std::vector<wire::Edge>& configure_next();
  /// The current step, or the last one. \pre begin_configuration() was called
  const Configurator& configurator() const { return configurer_->configurator(); }
  /// The result, once the configuration is finished. From then on the master uses it, at the
  /// setup's clock, and the registers stay as it left them.
  const std::optional<Result<Configuration, ConfigureFault>>& configuration() const {
    return configuration_;
  }

  /// From one request to the next without faults.
  Picoseconds interval() const { return interval_; }
  /// The cycle by which faults are placed.
  const NominalCycle& nominal() const { return schedule_.nominal(); }
  /// The master's control communication; null if there is none.
  const ControlMaster* control() const { return control_.get(); }
  /// The registers of an encoder; 0 is the one at the far end. \pre the setup has registers for it
  EncoderRegisters& registers(std::size_t encoder) { return registers_[encoder]; }
  /// The time of the next request; no edge so far is later.
  Picoseconds end() const { return begin_; }

 private:
  using Codec = FrameCodec<>;
  using Encoding = Slave<Codec, Encoder>;
  struct Node {
    Encoding slave;
    Pipe slo{};
    Picoseconds due = never;
    bool level = true;  // as it enters the pipe
    bool sli = true;
  };
  // A line without faults.
  struct Undisturbed {
    Picoseconds interval{};
    std::uint32_t clocks = 0;
    std::uint32_t data_clock = 0;
    Picoseconds line_delay{};
  };
  friend Picoseconds least_interval(const LineSetup&);

  Line(const LineSetup& setup, const Undisturbed& nominal);
  static Undisturbed undisturbed(LineSetup setup);

  void add_nodes();
  SlaveTiming node_timing(std::size_t k) const;
  void begin_request();
  void switch_channels();
  void answer_cds();
  void end_configuration();
  void end_control();
  void set_sent();
  void rest();
  template <bool Full>
  void run_request();
  template <bool Full>
  void run_rest(Picoseconds end, bool until_ready);
  template <bool Full>
  Picoseconds next_event() const;
  template <bool Full>
  bool step_line();
  template <bool Full>
  void step_node(std::size_t k, bool ma_changed);
  template <bool Full>
  void put_ma();
  template <bool Full>
  void put_node(std::size_t k, bool level);
  template <bool Full>
  bool put_slo();
  void record(wire::LineIndex line, bool level) {
    cycle_.edges.push_back({now_, line, level ? wire::Level::high : wire::Level::low});
  }
  void count_payload(SlaveState before, SlaveState after);

  void act();
  void begin_fault(FaultKind kind);
  void end_fault(FaultKind kind);
  void set_start(bool late);
  void pause();
  StepOutput ask(bool seen);
  void apply_start();
  void restart();

  LineSetup setup_;
  Picoseconds period_;
  RequestCycle<Codec> master_;
  std::vector<EncoderRegisters> registers_;  // the far end's first
  std::unique_ptr<ControlMaster> control_;
  std::unique_ptr<ConfigureCycle> configurer_;
  std::optional<Result<Configuration, ConfigureFault>> configuration_;
  bool answered_ = false;             // the CDS of the request under way
  std::vector<Node> nodes_;           // the far end's first
  std::optional<SlaveTiming> start_;  // for the far end, once it is idle
  Pipe ma_pipe_;
  Random random_;
  FaultSchedule schedule_;
  bool full_;  // a chain, faults or registers: needs the full event loop
  Disturbance disturbance_;
  SimulatedCycle cycle_;
  Picoseconds interval_{};
  Picoseconds begin_{};
  Picoseconds lateness_{};  // of the next request, by `delay`
  Picoseconds pause_{};     // of MA: from here to pause_end_
  Picoseconds pause_end_{};
  std::uint32_t rises_ = 0;    // of MA in this request
  bool pause_begins_ = false;  // with the next rising edge of MA
  std::uint64_t number_ = 0;

  Picoseconds now_{};
  Picoseconds master_due_ = never;
  Picoseconds slo_delay_{};
  unsigned payload_bit_ = 0;  // that the node next to the master sends
  bool ma_ = true;            // the master drives
  bool ma_wire_ = true;       // on the line there
  bool ma_sent_ = true;       // on its way to the slaves
  bool ma_slave_ = true;      // as the slaves see it
  bool slo_arrived_ = true;
  bool slo_ = true;  // as the master sees it
};

}  // namespace biss::sim
