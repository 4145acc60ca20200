// Automatic configuration with a RequestCycle: drives MA, takes SLO, and returns the format and the
// timing that are needed to read the encoder.
#pragma once

#include <algorithm>

#include "biss/base/units.hpp"
#include "biss/configure/configurator.hpp"
#include "biss/frame/fixed.hpp"
#include "biss/frame/format_text.hpp"
#include "biss/master/request.hpp"
#include "biss/timing/step.hpp"

namespace biss {

/// A master without configuration.
///
///   ConfigureCycle cycle;
///   StepOutput out = cycle.begin(now);
///   while (!cycle.done()) out = cycle.step(now, slo);  // at each change of SLO and each deadline
///   const auto result = cycle.result();
///   if (result.ok()) read_with(result->format, result->master_setup(period));
///
/// MA is high at the end. Do not copy it.
class ConfigureCycle {
 public:
  /// \param clock 250 kHz to 1 MHz
  constexpr explicit ConfigureCycle(const ConfigureOptions& options = {},
                                    Hertz clock = common_clock_max)
      : configurator_(options), master_(Codec{}, setup(clock)) {}

  constexpr StepOutput begin(Picoseconds now) {
    wait_until(std::max(now, configurator_.request().at));
    return {true, due_};
  }

  /// Like RequestCycle::step().
  constexpr StepOutput step(Picoseconds now, bool slo) {
    if (done()) return {ma_, never};
    if (!running_) {
      if (now >= due_) request(now, slo);
      return {ma_, due_};
    }
    drive(master_.step(now, slo));
    if (!answered_ && master_.reading().cds && !master_.done()) {
      answered_ = true;
      const CdsBit cds = *master_.reading().cds ? CdsBit::one : CdsBit::zero;
      master_.set_cdm(configurator_.answer(now, cds));
    }
    if (master_.done()) end_request(now);
    return {ma_, due_};
  }

  constexpr bool done() const { return configurator_.done() && !running_; }
  /// \pre done()
  constexpr Result<Configuration, ConfigureFault> result() const { return configurator_.result(); }
  constexpr const Configurator& configurator() const { return configurator_; }

 private:
  // Frames of this format are never requested.
  using Codec = FixedCodec<frame_format("pad1")>;

  // For the longest and slowest chain.
  static constexpr MasterSetup setup(Hertz clock) {
    return {.period = period_of(clock),
            .busy_s_clocks = biss_busy_s_max_clocks + control_max_slaves - 1,
            .hold_cdm = true,
            .unchecked = true};
  }

  constexpr void drive(const StepOutput& out) {
    ma_ = out.level;
    due_ = out.deadline;
  }
  constexpr void wait_until(Picoseconds time) {
    running_ = false;
    due_ = time;
  }

  constexpr void request(Picoseconds now, bool slo) {
    const ConfigureRequest& request = configurator_.request();
    drive(master_.begin(now, slo, request.cdm, request.kind));
    answered_ = false;
    running_ = true;
    if (master_.done()) end_request(now);  // refused: SLO is low
  }

  constexpr void end_request(Picoseconds now) {
    if (!answered_) configurator_.answer(now, CdsBit::missing);
    wait_until(configurator_.done() ? never
                                    : std::max(configurator_.request().at, master_.earliest()));
    if (configurator_.done()) ma_ = true;
  }

  Configurator configurator_;
  RequestCycle<Codec> master_;
  bool running_ = false;
  bool answered_ = false;  // the configurator has the answer to this request
  bool ma_ = true;
  Picoseconds due_ = never;
};

}  // namespace biss
