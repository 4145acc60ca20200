// Configuration by itself: an unknown device, or a chain of them, is asked what its frames look
// like and how it behaves in time.
//
//   Configurator configurator;
//   while (!configurator.done()) {
//     const ConfigureRequest request = configurator.request();
//     // … not before request.at make a request of request.kind that ends with request.cdm, …
//     const bool cdm = configurator.answer(now, cds);  // … and as soon as its CDS is there, or
//   }                                                  // will not come, say so.
//
// `cdm` is what is to end this very request; with the kind `reduced` it is request.cdm. CDM is to
// be held from one request to the next, and the clock is to be 250 kHz to 1 MHz.
// configure_cycle.hpp does all this with a RequestCycle.
//
// After the protocol description D2, "start-up for an unknown slave": channels off, rest, INIT,
// rest, the register 0x41, the EDS in the bank it names, else the profile identifier.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "biss/base/result.hpp"
#include "biss/base/units.hpp"
#include "biss/configure/configuration.hpp"
#include "biss/configure/configure_error.hpp"
#include "biss/configure/configure_options.hpp"
#include "biss/configure/eds_device.hpp"
#include "biss/configure/line_builder.hpp"
#include "biss/configure/slave_query.hpp"
#include "biss/control/session.hpp"
#include "biss/master/request_setup.hpp"

namespace biss {

/// Ends after max_requests at the latest, whatever the answers are. Not to be copied: its session
/// writes into it.
class Configurator {
 public:
  constexpr explicit Configurator(const ConfigureOptions& options = {})
      : options_(options), session_(options.control) {
    if (options.switch_channels) {
      session_.broadcast(ControlCommand::channels);
      left_behind_.channels_off = true;
      request_.cdm = session_.step({}, CdsBit::missing);
    } else {
      begin_init();
    }
  }
  Configurator(const Configurator&) = delete;
  Configurator& operator=(const Configurator&) = delete;

  constexpr bool done() const { return step_ == ConfigureStep::done; }
  /// The request to make. \pre !done()
  constexpr const ConfigureRequest& request() const { return request_; }

  /// The request was made. \pre !done()
  /// \param cds `missing` for the kind `reduced`, and where no CDS came that may be believed
  /// \return the CDM that is to end this request
  constexpr bool answer(Picoseconds now, CdsBit cds) {
    ++requests_;
    bool cdm = request_.cdm;
    if (request_.kind != RequestKind::reduced) {
      heard_ = heard_ || cds != CdsBit::missing;
      cdm = session_.step(now, cds);
    }
    request_ = {.kind = request_.kind, .at = now + options_.cycle};
    if (requests_ < options_.max_requests) {
      advance(now);
    } else {
      end_with({.cause = ConfigureError::too_many_requests, .step = step(), .slave = slave_});
      note_bank();
      step_ = ConfigureStep::done;
    }
    return cdm;
  }

  /// \pre done()
  constexpr Result<Configuration, ConfigureFault> result() const {
    if (fault_) return failure(*fault_);
    return config_;
  }
  /// Whole when done().
  constexpr LeftBehind left_behind() const { return left_behind_; }
  constexpr ConfigureStep step() const {
    return step_ == ConfigureStep::identity ? query_.step() : step_;
  }
  /// ID of the slave that is asked.
  constexpr std::uint8_t slave() const { return slave_; }
  /// Made so far.
  constexpr std::uint32_t requests() const { return requests_; }

 private:
  constexpr void advance(Picoseconds now) {
    switch (step_) {
      case ConfigureStep::channels_off:
        if (session_.done()) return begin_init();
        request_.cdm = session_.step(now, CdsBit::missing);
        return;
      case ConfigureStep::init:
        return advance_init(now);
      case ConfigureStep::identity:
        if (session_.done()) advance_query();
        return;
      case ConfigureStep::channels_on:
        if (session_.done()) end_channels_on();
        return;
      default:
        if (--left_ == 0) step_ = ConfigureStep::done;
        return;
    }
  }

  // The first of two brings MA back to high, should CDM 1 have been held.
  constexpr void begin_init() {
    step_ = ConfigureStep::init;
    left_ = 2;
  }
  constexpr void advance_init(Picoseconds now) {
    request_.at = now + std::max(options_.cycle, options_.init_rest);
    if (--left_ != 0) return;
    step_ = ConfigureStep::identity;
    request_.kind = RequestKind::control_only;
    query_.begin(session_, slave_);
  }

  constexpr void advance_query() {
    if (count_slaves() && query_.advance(session_)) return;
    note_bank();
    if (query_.failed()) judge(*query_.failed());
    if (!fault_) take_slave();
    if (fault_ || ++slave_ == config_.slave_count) return end_queries();
    query_.begin(session_, slave_);
  }

  constexpr void note_bank() {
    if (!query_.bank_dirty()) return;
    left_behind_.banks = static_cast<std::uint8_t>(left_behind_.banks | 1U << slave_);
  }

  // False: there are more than can be asked.
  constexpr bool count_slaves() {
    const ControlOutcome& outcome = session_.outcome();
    if (config_.slave_count == 0) {
      config_.slave_count = static_cast<std::uint8_t>(std::popcount(outcome.slaves_present));
    }
    if (!outcome.more_slaves || fault_) return true;
    end_with({.cause = ConfigureError::too_many_slaves, .step = step()});
    return false;
  }

  constexpr void judge(ControlError error) {
    ConfigureError cause = ConfigureError::control_failed;
    const bool lost = error == ControlError::frame_lost || error == ControlError::no_answer ||
                      error == ControlError::no_such_slave;
    if (!heard_) {
      cause = ConfigureError::no_encoder;
    } else if (lost && config_.slave_count != 0) {
      cause = ConfigureError::line_lost;
    } else if (error == ControlError::no_answer) {
      cause = ConfigureError::no_control;
    } else if (lost) {
      cause = ConfigureError::line_lost;
    }
    end_with({.cause = cause, .step = query_.failed_step(), .slave = slave_, .control = error});
  }

  constexpr void take_slave() {
    config_.slave_list[slave_] = query_.description();
    if (!query_.has_eds()) {
      builder_.add_profile(slave_, query_.description(),
                           {options_.eds.check_crc_in_data, options_.eds.length_counts_crc});
      return;
    }
    const auto device = configure_detail::eds_device(query_.image(), config_.slave_list, slave_,
                                                     options_.eds, options_.unstated_clock_max);
    if (!device.ok()) return end_with(device.error());
    if (!builder_.add_device(*device)) {
      end_with({.cause = ConfigureError::eds_contradiction,
                .step = ConfigureStep::read_common,
                .slave = slave_});
    }
  }

  constexpr void end_queries() {
    if (!options_.switch_channels || config_.slave_count == 0) return begin_rest();
    step_ = ConfigureStep::channels_on;
    const auto all = static_cast<std::uint8_t>((1U << config_.slave_count) - 1U);
    session_.command(all, ControlCommand::channels, ExecuteIf::any_accepts);
  }
  constexpr void end_channels_on() {
    const auto error = session_.outcome().error;
    config_.channels_were_switched = !error;
    // Who does not know this command did not obey the broadcast either.
    const bool stay_off = error && error != ControlError::not_accepted;
    // Slaves without an ID heard the broadcast, and cannot be addressed.
    left_behind_.channels_off = stay_off || session_.outcome().more_slaves;
    if (stay_off) {
      end_with({.cause = ConfigureError::channels_stay_off, .step = step_, .control = error});
    }
    begin_rest();
  }

  constexpr void begin_rest() {
    if (!fault_) {
      const auto fault = builder_.finish(config_, options_.unstated_clock_max);
      if (fault) end_with(*fault);
    }
    step_ = ConfigureStep::rest;
    left_ = control_reset_zeros;
  }

  // The first cause stands.
  constexpr void end_with(const ConfigureFault& fault) {
    if (!fault_) fault_ = fault;
  }

  ConfigureOptions options_;
  ControlSession session_;
  ConfigureStep step_ = ConfigureStep::channels_off;  // `identity` stands for all of the query's
  ConfigureRequest request_{};
  std::uint32_t requests_ = 0;
  std::uint8_t left_ = 0;  // requests of this step
  std::uint8_t slave_ = 0;
  bool heard_ = false;
  LeftBehind left_behind_{};
  configure_detail::SlaveQuery query_;
  configure_detail::LineBuilder builder_;
  Configuration config_{};
  std::optional<ConfigureFault> fault_{};
};

}  // namespace biss
