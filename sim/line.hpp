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
#include "biss/master/request.hpp"
#include "sim/control_master.hpp"
#include "sim/encoder_side.hpp"

namespace biss::sim {

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
class Line : public EncoderSide {
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
  Picoseconds interval() const { return nominal().interval; }
  /// The master's control communication; null if there is none.
  const ControlMaster* control() const { return control_.get(); }
  /// The registers of an encoder; 0 is the one at the far end. \pre the setup has registers for it
  EncoderRegisters& registers(std::size_t encoder) { return registers_[encoder]; }
  /// The time of the next request; no edge so far is later.
  Picoseconds end() const { return next_begin_; }

 private:
  friend Picoseconds least_interval(const LineSetup&);

  Line(const LineSetup& setup, const NominalCycle& nominal);
  static NominalCycle undisturbed(LineSetup setup);

  void begin_request();
  StepOutput ask(bool seen);
  template <bool Full>
  void run_request();
  void pause();
  void answer_cds();
  void rest();
  template <bool Full>
  void run_rest(Picoseconds end, bool until_ready);
  void set_sent();
  void end_configuration();

  RequestCycle<Codec> master_;
  bool full_;  // see put_ma()
  std::unique_ptr<ControlMaster> control_;
  std::unique_ptr<ConfigureCycle> configurer_;
  std::optional<Result<Configuration, ConfigureFault>> configuration_;
  bool answered_ = false;  // the CDS of the request under way
  SimulatedCycle cycle_;
  Picoseconds next_begin_{};
  std::uint64_t number_ = 0;
  Picoseconds master_due_ = never;
  Picoseconds pause_{};  // of MA: from here to pause_end_
  Picoseconds pause_end_{};
  std::uint32_t rises_ = 0;  // of MA in this request
};

}  // namespace biss::sim
