// The start of an encoder that the program does not know:
//
//   load ── a record in flash ──> check ── same encoder, good frames ──> ready
//     └── no record ──> ask ──> check          else, with a cause: ask
//
//   load   the record is in flash and undamaged: format and timing come from its data sheet
//   ask    a ConfigureLink asks for identity and data sheet, with a clock for every encoder
//   check  an EncoderLink reads frames of this format, and in them identity, serial number and
//          profile, which must be the same as in the record. After `ask` the record is then stored
//   ready  link() has positions; it has none before
#pragma once

#include <algorithm>
#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <utility>

#include "biss/axis/encoder_link.hpp"
#include "biss/base/units.hpp"
#include "biss/configure/configure_link.hpp"
#include "biss/configure/encoder_record.hpp"
#include "biss/frame/codec.hpp"
#include "biss/master/spi_read.hpp"
#include "biss/timing/cycle.hpp"

namespace boards {

/// An EncoderPort whose clock can be changed, and memory for the record that survives power off.
template <class T>
concept StartPort = biss::EncoderPort<T> &&
    requires(T& port, biss::Hertz most, biss::RecordBytes& bytes) {
  /// Sets the highest clock up to `most`, which is 1 MHz or more. No transfer runs. \return its period
  { port.set_clock(most) } -> std::same_as<biss::Picoseconds>;
  port.load(bytes);
  /// Erases the memory and writes the bytes. If power fails, it has any part of them.
  port.store(std::as_const(bytes));
};

/// Why the encoder is asked; or, if it is ready, why nothing was stored.
enum class StartCause : std::uint8_t {
  record,         ///< the memory has no record: `record`
  configuration,  ///< encoder or record give no configuration: `configure`
  setup,          ///< no encoder fits this AxisSetup: `axis`. Nothing is asked
  chain,          ///< there are several slaves
  format,         ///< there are several channels, or the axis cannot use the format: `axis`
  cycle,          ///< a frame takes longer than the cycle
  registers,      ///< they could not be read in frames of this format: `control`
  other_encoder,  ///< the record, or the data sheet that was read, belongs to another encoder
  no_serial,      ///< not stored: every encoder of this type has the same registers
  not_stored,     ///< the memory failed
};

constexpr std::string_view name_of(StartCause cause) {
  constexpr std::string_view names[] = {"record",    "configuration", "setup",     "chain",
                                        "format",    "cycle",         "registers", "other_encoder",
                                        "no_serial", "not_stored"};
  return names[static_cast<std::size_t>(cause)];
}

struct StartFault {
  StartCause cause{};
  std::optional<biss::RecordError> record{};
  std::optional<biss::ConfigureFault> configure{};
  std::optional<biss::AxisError> axis{};
  std::optional<biss::ControlError> control{};
};

/// After a trip of the axis, construct it again.
template <StartPort Port, std::size_t max_bytes>
class EncoderStart {
 public:
  using Codec = biss::FrameCodec<biss::CrcFast, 1>;
  using Reader = biss::SpiReader<Codec>;
  using Link = biss::EncoderLink<Port, Reader, max_bytes>;

  /// \param axis its to_sampling is taken from the data sheet
  constexpr EncoderStart(Port& port, const biss::AxisSetup& axis,
                         const biss::LineDelayRange& line_delay)
      : port_(port), axis_(axis), line_delay_(line_delay) {}

  // The two interrupts.
  constexpr void request(biss::Picoseconds now) {
    if (asks_) asks_->request(now);
    if (link_) link_->request(now);
  }
  constexpr void transfer_ended(bool good) {
    if (asks_) good ? asks_->transfer_complete() : asks_->transfer_failed();
    if (link_) good ? link_->transfer_complete() : link_->transfer_failed();
  }

  /// Takes the next step if it is time. Call it in the main loop with both interrupts masked. If it
  /// stores a record, it takes as long as the memory.
  constexpr std::optional<StartFault> advance() {
    if (link_ ? link_->axis().waits() : asks_ && asks_->waits()) return std::nullopt;
    if (asks_) return asks_->configurator().done() ? take_answers() : std::nullopt;
    if (!link_) return load();
    if (is_ready_ || !link_->session().done()) return std::nullopt;
    return query_.advance(link_->session()) ? std::nullopt : end_check();
  }

  /// Null unless ready.
  constexpr Link* link() { return is_ready_ ? &*link_ : nullptr; }
  // The encoder that is ready.
  constexpr const biss::EncoderRecord& record() const { return record_; }
  constexpr const Reader& reader() const { return *reader_; }

 private:
  using Fault = std::optional<StartFault>;

  constexpr Fault load() {
    // The time to the sampling is in the data sheet, and the largest range has 62 bits.
    biss::AxisSetup setup = axis_;
    setup.to_sampling = biss::microseconds(1);
    const auto error = biss::check_axis(setup, 62);
    if (error) return StartFault{.cause = StartCause::setup, .axis = error};
    biss::RecordBytes bytes{};
    port_.load(bytes);
    const auto record = biss::read_record(bytes);
    if (!record.ok()) return ask({.cause = StartCause::record, .record = record.error()});
    return check(*record);
  }

  constexpr Fault ask(const StartFault& fault) {
    link_.reset();
    asked_ = true;
    asks_.emplace(port_, port_.set_clock(biss::common_clock_max), line_delay_);
    return fault;
  }

  constexpr Fault take_answers() {
    const biss::Configurator& answers = asks_->configurator();
    const auto result = answers.result();
    if (!result.ok()) return ask({.cause = StartCause::configuration, .configure = result.error()});
    if (result->slave_count != 1) return ask({.cause = StartCause::chain});
    return check(record_of(result->slave_list[0], answers.image()));
  }

  constexpr Fault check(const biss::EncoderRecord& record) {
    record_ = record;
    const auto config = configuration_of(record_);
    if (!config.ok()) return ask({.cause = StartCause::configuration, .configure = config.error()});
    if (config->format.channel_count != 1) return ask({.cause = StartCause::format});
    biss::DeviceTiming timing = config->timing;
    const biss::SpiSetup spi{.period = port_.set_clock(timing.clock_max),
                             .line_delay = line_delay_};
    timing.ack_max =
        std::min(timing.ack_max + std::int64_t{config->start_delay_clocks} * spi.period,
                 biss::biss_busy_max);
    axis_.to_sampling = sampling_delay(spi, timing);
    asks_.reset();
    reader_.emplace(Codec(config->format), spi, timing);
    link_.emplace(port_, *reader_, axis_, biss::ControlOptions{.retries = 3});
    const auto error = link_->axis().error();
    if (error) return ask({.cause = StartCause::format, .axis = error});
    biss::Picoseconds cycle = static_cast<std::int64_t>(reader_->bytes() * 8U) * spi.period;
    cycle += spi.period / 2 + timeout_after(timing.timeout, spi.period, cycle);
    if (std::max(cycle, timing.cycle_min) > axis_.cycle) return ask({.cause = StartCause::cycle});
    query_.begin(link_->session(), 0);
    return std::nullopt;
  }

  constexpr Fault end_check() {
    const auto failed = query_.failed();
    if (failed) return ask({.cause = StartCause::registers, .control = failed});
    if (!is_of(record_, query_.description())) return ask({.cause = StartCause::other_encoder});
    is_ready_ = true;
    const Fault fault = asked_ ? store() : std::nullopt;
    link_->axis().reset();
    return fault;
  }

  constexpr Fault store() {
    const bool is_unique = record_.identity != 0 && record_.serial != 0;
    if (!is_unique) return StartFault{.cause = StartCause::no_serial};
    auto bytes = std::bit_cast<biss::RecordBytes>(record_);
    port_.store(bytes);
    port_.load(bytes);
    if (bytes == std::bit_cast<biss::RecordBytes>(record_)) return std::nullopt;
    return StartFault{.cause = StartCause::not_stored};
  }

  Port& port_;
  biss::AxisSetup axis_;
  biss::LineDelayRange line_delay_;
  bool asked_ = false;
  bool is_ready_ = false;
  biss::EncoderRecord record_{};
  biss::SlaveQuery query_{};
  std::optional<biss::ConfigureLink<Port>> asks_{};
  std::optional<Reader> reader_{};
  std::optional<Link> link_{};
};

}  // namespace boards
