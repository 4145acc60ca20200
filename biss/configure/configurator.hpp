// Automatic configuration: asks an unknown device, or a chain of them, for its frames and its
// timing.
//
//   Configurator configurator;
//   while (!configurator.done()) {
//     const ConfigureRequest& request = configurator.request();
//     // Make a request of request.kind, not before request.at, that ends with `cdm`:
//     const bool cdm = configurator.answer(now, cds);
//   }
//
// answer() is called as soon as the CDS of the request is known, or known to be missing; it returns
// the CDM that ends the same request. With the kind `reduced`, that is request.cdm. CDM must be
// held from one request to the next, and the clock must be 250 kHz to 1 MHz. configure_cycle.hpp
// does all of this with a RequestCycle. A master that must choose CDM before it receives CDS calls
// cdm_ahead() and take_cds() instead of answer().
//
// After the protocol description D2, "start-up for an unknown slave": channels off, rest, INIT,
// rest, register 0x41, the EDS in the bank it names, or the profile identifier.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "biss/base/big_endian.hpp"
#include "biss/base/result.hpp"
#include "biss/base/units.hpp"
#include "biss/configure/configuration.hpp"
#include "biss/control/register_map.hpp"
#include "biss/control/session.hpp"
#include "biss/eds/bank.hpp"
#include "biss/eds/check.hpp"
#include "biss/eds/common_part.hpp"
#include "biss/eds/device.hpp"
#include "biss/eds/image.hpp"
#include "biss/eds/profile.hpp"
#include "biss/frame/format.hpp"
#include "biss/master/request_setup.hpp"
#include "biss/timing/device_timing.hpp"

namespace biss::configure_detail {

// ---- The query of one slave: its identity, its profile, its EDS

/// Whether this maker's devices follow the register map at this address; true for unknown makers.
constexpr bool follows_map(const std::optional<DeviceIdentity>& identity, unsigned address) {
  if (!identity) return true;
  const auto maker = manufacturer_name(identity->manufacturer);
  for (const VendorRegister& quirk : map_quirks) {
    if (maker && quirk.vendor == *maker && quirk.contains(address)) return false;
  }
  return true;
}

/// One access after the other, on a session of the owner. Registers that a slave does not have are
/// skipped. BSEL is always restored. Do not move a query that runs: the session writes into it.
class SlaveQuery {
 public:
  /// Begins to read everything except the EDS.
  constexpr void begin(ControlSession& session, std::uint8_t slave) {
    start(slave, {});
    read(session, ConfigureStep::identity, reg::dev_id, 8);
  }
  /// Reads the EDS. \pre names_eds(description)
  /// \param description of this slave, by begin()
  /// \return false: it cannot be read, and nothing is under way
  constexpr bool begin_eds(ControlSession& session, std::uint8_t slave,
                           const SlaveDescription& description) {
    start(slave, description);
    step_ = ConfigureStep::select_bank;
    if (!follows_map(description_.identity, reg::bsel)) {
      note_unused(ConfigureError::eds_unreadable);
      return false;
    }
    return read(session, ConfigureStep::select_bank, reg::bsel, 1);
  }
  static constexpr bool names_eds(const SlaveDescription& description) {
    return eds_presence(description.eds_bank) != EdsPresence::none;
  }

  /// Call it when the session's access is done.
  /// \return false: that was the last one
  constexpr bool advance(ControlSession& session) {
    const ControlOutcome& outcome = session.outcome();
    if (outcome.error == ControlError::next_unavailable && outcome.bytes_done != 0) {
      // The device supports no longer sequence; the rest may still be present.
      to_ = to_.subspan(outcome.bytes_done);
      address_ = static_cast<std::uint8_t>(address_ + outcome.bytes_done);
      writing_ ? session.write(slave_, address_, to_) : session.read(slave_, address_, to_);
      return true;
    }
    const bool there = !outcome.error;
    // The write was refused, so BSEL is unchanged.
    if (!there && writing_ && is_absent(*outcome.error)) bank_dirty_ = bank_ != found_bank_;
    if (step_ == ConfigureStep::restore_bank) {
      bank_dirty_ = !there;
      return false;
    }
    if (!there && !is_absent(*outcome.error)) return fail(session, *outcome.error);
    switch (step_) {
      case ConfigureStep::identity:
        if (there) description_.identity = device_identity(buffer().first<8>());
        return read(session, ConfigureStep::profile, reg::bp_id, 2);
      case ConfigureStep::profile:
        if (there) {
          description_.profile =
              static_cast<std::uint16_t>(from_big_endian<2>(buffer().first<2>()));
        }
        return read(session, ConfigureStep::serial, reg::dev_sn, 4);
      case ConfigureStep::serial:
        if (there && follows_map(description_.identity, reg::dev_sn)) {
          description_.serial = serial_number(buffer().first<4>());
        }
        return read(session, ConfigureStep::find_eds, reg::eds_bank, 1);
      case ConfigureStep::find_eds:
        if (there) description_.eds_bank = buffer_[0];
        return false;
      case ConfigureStep::select_bank:
        if (there) return selected(session);
        break;
      case ConfigureStep::read_common:
        if (there) return take_common(session);
        break;
      default:
        return end_channel(session);
    }
    note_unused(ConfigureError::eds_unreadable, outcome.error);
    return restore(session);
  }

  constexpr ConfigureStep step() const { return step_; }
  constexpr const SlaveDescription& description() const { return description_; }
  /// The error that ended the query early.
  constexpr std::optional<ControlError> failed() const { return failed_; }
  /// The step in which the query failed. \pre failed()
  constexpr ConfigureStep failed_step() const { return failed_step_; }
  /// BSEL may not have its original value.
  constexpr bool bank_dirty() const { return bank_dirty_; }
  constexpr bool has_eds() const { return has_common_; }
  /// The cause why the EDS, or a part of it, is unused.
  constexpr std::optional<ConfigureFault> eds_fault() const { return eds_fault_; }
  /// The bytes read from the EDS; valid until the next begin(). \pre has_eds()
  constexpr EdsImage image() const {
    EdsImage image{.common = &common_, .eds_bank = description_.eds_bank};
    for (std::size_t i = 0; i < max_channels; ++i) {
      if (has_channel_[i]) image.profiles[i] = &channels_[i];
    }
    return image;
  }

 private:
  constexpr void start(std::uint8_t slave, const SlaveDescription& description) {
    slave_ = slave;
    description_ = description;
    failed_.reset();
    eds_fault_.reset();
    has_common_ = bank_dirty_ = false;
    has_channel_ = {};
    channel_ = 0;
  }

  constexpr std::span<std::uint8_t, bank_bytes> buffer() { return buffer_; }

  // Whether the slave refused the access. An old device without W inversion refuses by never
  // sending the start bit, for a read and for a write.
  static constexpr bool is_absent(ControlError error) {
    return error == ControlError::refused || error == ControlError::refused_or_not_addressed ||
           error == ControlError::busy_too_long || error == ControlError::start_missing ||
           error == ControlError::next_unavailable;
  }

  constexpr bool begin_access(ControlSession& session, ConfigureStep step, std::uint8_t address,
                              std::span<std::uint8_t> bytes, bool writing) {
    step_ = step;
    address_ = address;
    to_ = bytes;
    writing_ = writing;
    writing ? session.write(slave_, address, bytes) : session.read(slave_, address, bytes);
    return true;
  }
  constexpr bool read(ControlSession& session, ConfigureStep step, std::uint8_t address,
                      std::size_t size) {
    return begin_access(session, step, address, buffer().first(size), false);
  }
  constexpr bool select(ControlSession& session, ConfigureStep step, std::uint8_t bank) {
    bank_dirty_ = true;
    buffer_[0] = bank;
    return begin_access(session, step, reg::bsel, buffer().first(1), true);
  }

  // BSEL was read or written.
  constexpr bool selected(ControlSession& session) {
    bank_ = buffer_[0];
    if (!writing_) {
      found_bank_ = bank_;
      if (bank_ != description_.eds_bank) {
        return select(session, ConfigureStep::select_bank, description_.eds_bank);
      }
    }
    return begin_access(session, ConfigureStep::read_common, reg::bank, common_, false);
  }

  constexpr bool take_common(ControlSession& session) {
    if (!is_sound(common_)) {
      note_unused(ConfigureError::eds_checksum);
      return restore(session);
    }
    has_common_ = true;
    return next_channel(session);
  }

  constexpr bool next_channel(ControlSession& session) {
    const CommonPart part = parse_common_part(common_);
    const std::size_t count = std::min<std::size_t>(part.dc_num, max_channels);
    while (channel_ < count && part.channels[channel_].bank == 0) ++channel_;
    if (channel_ == count) return restore(session);
    const std::uint8_t bank = part.channels[channel_].bank;
    if (bank != bank_) return select(session, ConfigureStep::read_channels, bank);
    return begin_access(session, ConfigureStep::read_channels, reg::bank, channels_[channel_],
                        false);
  }

  // The bank of a channel was selected or read, or one of both failed.
  constexpr bool end_channel(ControlSession& session) {
    const std::optional<ControlError> error = session.outcome().error;
    if (!error && writing_) {
      bank_ = buffer_[0];
      return next_channel(session);
    }
    has_channel_[channel_] = !error && is_sound(channels_[channel_]);
    if (!has_channel_[channel_]) {
      note_unused(error ? ConfigureError::eds_unreadable : ConfigureError::eds_checksum, error);
    }
    ++channel_;
    return next_channel(session);
  }

  // An empty bank has the right sum, too.
  static constexpr bool is_sound(const EdsBank& bank) {
    return bank[eds_checksum_address] == eds_checksum(bank) && !is_filled_with(bank, 0);
  }

  // The first cause is kept.
  constexpr void note_unused(ConfigureError cause, std::optional<ControlError> error = {}) {
    // 0xFF means "none" on some devices.
    if (!has_common_ && eds_presence(description_.eds_bank) == EdsPresence::doubtful) return;
    description_.eds_unused = true;
    if (eds_fault_) return;
    eds_fault_ = {.cause = cause, .step = step_, .slave = slave_, .control = error};
  }

  constexpr bool fail(ControlSession& session, ControlError error) {
    failed_ = error;
    failed_step_ = step_;
    return restore(session);
  }

  constexpr bool restore(ControlSession& session) {
    if (!bank_dirty_) return false;
    return select(session, ConfigureStep::restore_bank, found_bank_);
  }

  std::uint8_t slave_ = 0;
  ConfigureStep step_ = ConfigureStep::identity;
  SlaveDescription description_{};
  std::optional<ControlError> failed_{};
  ConfigureStep failed_step_{};
  std::optional<ConfigureFault> eds_fault_{};
  // The access under way.
  std::uint8_t address_ = 0;
  bool writing_ = false;
  std::span<std::uint8_t> to_{};
  std::array<std::uint8_t, bank_bytes> buffer_{};

  std::uint8_t found_bank_ = 0;  // BSEL before the query
  std::uint8_t bank_ = 0;        // BSEL now
  bool bank_dirty_ = false;
  bool has_common_ = false;
  std::size_t channel_ = 0;
  EdsBank common_{};
  std::array<bool, max_channels> has_channel_{};
  std::array<EdsBank, max_channels> channels_{};
};

// ---- The answers of the slaves, merged to one format and one timing for the line

class LineBuilder {
 public:
  constexpr explicit LineBuilder(const EdsFindingTaker& taker) : taker_(taker) {}

  /// The descriptions of the slaves and their number; after finish(), everything.
  Configuration config{};

  /// Adds a slave whose EDS is missing or unused. An EDS that describes this ID has precedence, in
  /// any order of the calls.
  /// \param eds_fault the cause why its EDS is unused, if it has one
  constexpr void add_profile(std::uint8_t id, const std::optional<ConfigureFault>& eds_fault) {
    SlaveDescription& slave = config.slave_list[id];
    if (slave.source == ValueSource::eds) return;
    Slot& slot = slots_[id];
    const auto channel = profile_channel(slave.profile.value_or(0));
    if (channel.ok() || channel.error() == ProfileError::no_channel) {
      slave.source = ValueSource::profile;
      if (channel.ok()) slot.channel = *channel;
      return;
    }
    const bool none = channel.error() == ProfileError::none_given;
    slot.fault = eds_fault.value_or(
        ConfigureFault{.cause = none ? ConfigureError::no_profile : ConfigureError::unknown_profile,
                       .step = ConfigureStep::profile,
                       .slave = id});
    if (!eds_fault && !none) slot.fault->profile = channel.error();
  }

  /// Adds the IDs that the EDS of the slave `holder` describes.
  /// \param image with a common part; the identifiers are filled in here
  /// \return nothing, or eds_contradiction
  constexpr std::optional<ConfigureFault> add_eds(EdsImage image, std::uint8_t holder) {
    const CommonPart common = parse_common_part(*image.common);
    ConfigureFault wrong{.cause = ConfigureError::eds_contradiction,
                         .step = ConfigureStep::read_common,
                         .slave = holder};
    if (common.sl_off > holder) {
      wrong.field = "SL_OFF";
      return wrong;
    }
    const std::size_t first = common.first_slave(holder);
    // Channel i belongs to the i-th slave if each slave has one channel.
    for (std::size_t i = 0; i < common.dc_num && i < max_channels; ++i) {
      const std::size_t slave = common.dc_num == 1 ? holder : first + i;
      if (slave >= control_max_slaves || (common.dc_num != 1 && common.dc_num != common.sl_num)) {
        break;
      }
      const auto& profile = config.slave_list[slave].profile;
      if (profile.value_or(0) != 0) image.identifiers[i] = profile;
    }
    std::optional<EdsFinding> refused;
    check_eds(image, [&](const EdsFinding& finding) {
      ++config.slave_list[holder].eds_findings;
      if (taker_.take != nullptr) taker_.take(taker_.user, holder, finding);
      if (!refused && contradicts(finding)) refused = finding;
    });
    TimeSources times;
    const auto device = describe_device(image, {}, times);
    if (!device.ok()) {
      wrong.eds = device.error().cause;
      return wrong;
    }
    if (refused) {
      wrong.step = ConfigureStep::read_channels;
      wrong.problem = refused->problem;
      wrong.field = refused->symbol;
      return wrong;
    }
    const std::size_t count = device->format.channel_count;
    if (common.sl_num == 0 || first + common.sl_num > config.slave_count || count > common.sl_num) {
      wrong.field = count > common.sl_num ? "DC_NUM" : "SL_NUM";
      return wrong;
    }
    put(*device, common, first);
    config.timeout_source = std::min(config.timeout_source, times.timeout);
    config.busy_source = std::min(config.busy_source, times.busy);
    config.cycle_source = std::min(config.cycle_source, times.cycle);
    return std::nullopt;
  }

  /// Completes the configuration. \pre config.slave_count is known
  constexpr std::optional<ConfigureFault> finish() {
    // The timing of a device about which nothing is known.
    constexpr DeviceTiming unstated{.clock_min = common_clock_min, .clock_max = common_clock_max};
    for (std::size_t k = 0; k < config.slave_count; ++k) {
      if (slots_[k].fault) return slots_[k].fault;
      const ValueSource source = config.slave_list[k].source;
      config.format_source = std::min(config.format_source, source);
      if (source == ValueSource::eds) continue;
      config.clock_source = config.timeout_source = ValueSource::defaults;
      config.busy_source = config.cycle_source = ValueSource::defaults;
      config.start_delay_clocks = biss_busy_s_max_clocks;
      merge(unstated);
    }
    for (std::size_t k = config.slave_count; k-- > 0;) {
      if (!slots_[k].channel) continue;
      config.format.channel_list[config.format.channel_count++] = *slots_[k].channel;
    }
    if (config.format.channel_count == 0) {
      return ConfigureFault{.cause = ConfigureError::no_channel, .step = ConfigureStep::profile};
    }
    config.timing = timing_.value_or(unstated);
    config.start_delay_clocks =
        static_cast<std::uint8_t>(config.start_delay_clocks + config.slave_count - 1);
    return std::nullopt;
  }

 private:
  struct Slot {
    std::optional<ChannelFormat> channel{};  // empty: the slave sends none
    std::optional<ConfigureFault> fault{};   // why its channel is not known
  };

  // The sources of times, whose units no source confirms.
  struct TimeSources {
    ValueSource timeout = ValueSource::defaults;
    ValueSource busy = ValueSource::defaults;
    ValueSource cycle = ValueSource::defaults;

    constexpr void operator()(const EdsRemark& remark) {
      if (remark.kind != EdsRemarkKind::hypothesis) return;
      const std::string_view symbol = remark.symbol;
      if (symbol == "TBUSY_MAX") busy = ValueSource::hypothesis;
      if (symbol == "TCYC") cycle = ValueSource::hypothesis;
      if (symbol == "TCLK_MAX" || symbol == "TOS_MAX" || symbol == "TO_MAX") {
        timeout = ValueSource::hypothesis;
      }
    }
  };

  // Takes the channels and the timing of the IDs from `first` on.
  constexpr void put(const EdsDevice& device, const CommonPart& common, std::size_t first) {
    const std::size_t count = device.format.channel_count;
    for (std::size_t i = 0; i < common.sl_num; ++i) {
      config.slave_list[first + i].source = ValueSource::eds;
      slots_[first + i] = {};
      // The highest ID is first on the line.
      if (i < count) slots_[first + i].channel = device.format.channel_list[count - 1 - i];
    }
    config.start_delay_clocks = std::max(config.start_delay_clocks, device.busy_s_clocks);
    DeviceTiming timing = device.timing;
    // Up to common_clock_max, every slave accepts every clock.
    timing.clock_min = common_clock_min;
    if (common.tma == 0) {
      config.clock_source = ValueSource::defaults;
      timing.clock_max = common_clock_max;
    }
    merge(timing);
  }

  constexpr void merge(const DeviceTiming& other) {
    if (!timing_) {
      timing_ = other;
      return;
    }
    DeviceTiming& all = *timing_;
    all.clock_min = std::max(all.clock_min, other.clock_min);
    all.clock_max = std::min(all.clock_max, other.clock_max);
    all.start_min = std::min(all.start_min, other.start_min);
    all.ack_max = std::max(all.ack_max, other.ack_max);
    // Clocks that one device always takes may be fewer than another needs.
    all.ack_clocks = all.ack_clocks == other.ack_clocks ? all.ack_clocks : std::uint16_t{0};
    if (all.timeout.rule == other.timeout.rule) {
      all.timeout.time = std::max(all.timeout.time, other.timeout.time);
    } else {
      all.timeout = {};
    }
    all.internal_delay_max += other.internal_delay_max;
    all.cycle_min = std::max(all.cycle_min, other.cycle_min);
  }

  EdsFindingTaker taker_;
  std::array<Slot, control_max_slaves> slots_{};
  std::optional<DeviceTiming> timing_{};
};

}  // namespace biss::configure_detail

namespace biss {

/// The registers of one slave in a session of the caller.
using SlaveQuery = configure_detail::SlaveQuery;

/// Ends after at most max_requests, for any answers. Do not copy it: its session writes into it.
class Configurator {
 public:
  constexpr explicit Configurator(const ConfigureOptions& options = {})
      : options_(options), session_(options.control) {
    if (options.switch_channels) {
      session_.broadcast(ControlCommand::channels);
      unrestored_.channels_off = true;
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

  /// Takes the answer to the request. \pre !done()
  /// \param cds `missing` for the kind `reduced`, and if no valid CDS came
  /// \return the CDM that ends this request
  constexpr bool answer(Picoseconds now, CdsBit cds) {
    const bool cdm = request_.kind == RequestKind::reduced ? request_.cdm : session_.step(now, cds);
    end_request(now, cds);
    return cdm;
  }

  /// The CDM that ends the request, before its CDS is known. \pre !done(), and without
  /// ConfigureOptions::switch_channels
  constexpr bool cdm_ahead() const {
    return request_.kind == RequestKind::reduced ? request_.cdm : session_.cdm_ahead();
  }
  /// Like answer(), for a request that ended with cdm_ahead().
  constexpr void take_cds(Picoseconds now, CdsBit cds) {
    if (request_.kind != RequestKind::reduced) session_.take_cds(now, cds);
    end_request(now, cds);
  }

  /// \pre done()
  constexpr Result<Configuration, ConfigureFault> result() const {
    if (fault_) return failure(*fault_);
    return builder_.config;
  }
  /// The data sheet of the slave that was asked last, as it was read; empty if it has none. It lives
  /// as long as this object. \pre done()
  constexpr EdsImage image() const { return query_.has_eds() ? query_.image() : EdsImage{}; }
  /// Complete when done().
  constexpr Unrestored unrestored() const { return unrestored_; }
  constexpr ConfigureStep step() const {
    return step_ == ConfigureStep::identity ? query_.step() : step_;
  }
  /// The ID of the current slave.
  constexpr std::uint8_t slave() const { return slave_; }
  /// The number of requests made so far.
  constexpr std::uint32_t requests() const { return requests_; }

 private:
  constexpr void end_request(Picoseconds now, CdsBit cds) {
    ++requests_;
    if (request_.kind != RequestKind::reduced) {
      received_cds_ = received_cds_ || cds != CdsBit::missing;
    }
    request_ = {.kind = request_.kind, .at = now + options_.cycle};
    if (requests_ < options_.max_requests) {
      advance(now);
    } else {
      end_with({.cause = ConfigureError::too_many_requests, .step = step(), .slave = slave_});
      note_bank();
      step_ = ConfigureStep::done;
    }
  }

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

  // The first of two returns MA to high, in case CDM 1 was held.
  constexpr void begin_init() {
    step_ = ConfigureStep::init;
    left_ = 2;
  }
  constexpr void advance_init(Picoseconds now) {
    // MA is high for 40 µs at least (D2).
    request_.at = now + std::max(options_.cycle, biss_static_timeout_max);
    if (--left_ != 0) return;
    step_ = ConfigureStep::identity;
    request_.kind = RequestKind::control_only;
    query_.begin(session_, slave_);
  }

  // First all slaves without their EDS: an EDS may describe slaves before and after its own.
  constexpr void advance_query() {
    if (count_slaves() && query_.advance(session_)) return;
    note_bank();
    if (query_.failed()) judge(*query_.failed());
    if (!fault_) take_slave();
    if (fault_) return end_queries();
    ++slave_;
    if (!reads_eds_) {
      if (slave_ != config().slave_count) return query_.begin(session_, slave_);
      reads_eds_ = true;
      slave_ = 0;
    }
    if (!begin_next_eds()) end_queries();
  }

  // False: no further slave has an EDS that can be read.
  constexpr bool begin_next_eds() {
    for (; slave_ != config().slave_count; ++slave_) {
      const SlaveDescription& known = config().slave_list[slave_];
      if (!query_.names_eds(known)) continue;
      if (query_.begin_eds(session_, slave_, known)) return true;
      take_slave();
    }
    return false;
  }

  constexpr void note_bank() {
    if (!query_.bank_dirty()) return;
    unrestored_.banks = static_cast<std::uint8_t>(unrestored_.banks | 1U << slave_);
  }

  // False: there are more slaves than can be addressed.
  constexpr bool count_slaves() {
    const ControlOutcome& outcome = session_.outcome();
    if (config().slave_count == 0) {
      config().slave_count = static_cast<std::uint8_t>(std::popcount(outcome.slaves_present));
    }
    if (!outcome.more_slaves || fault_) return true;
    end_with({.cause = ConfigureError::too_many_slaves, .step = step()});
    return false;
  }

  constexpr void judge(ControlError error) {
    ConfigureError cause = ConfigureError::control_failed;
    if (!received_cds_) {
      cause = ConfigureError::no_encoder;
    } else if (error == ControlError::no_answer && config().slave_count == 0) {
      cause = ConfigureError::no_control;
    } else if (error == ControlError::frame_lost || error == ControlError::no_answer ||
               error == ControlError::no_such_slave) {
      cause = ConfigureError::line_lost;
    }
    end_with({.cause = cause, .step = query_.failed_step(), .slave = slave_, .control = error});
  }

  constexpr void take_slave() {
    config().slave_list[slave_] = query_.description();
    if (!query_.has_eds()) return builder_.add_profile(slave_, query_.eds_fault());
    const auto fault = builder_.add_eds(query_.image(), slave_);
    if (!fault) return;
    const bool unread = fault->eds == EdsDeviceCause::unknown_channel;
    end_with(unread ? query_.eds_fault().value_or(*fault) : *fault);
  }

  constexpr void end_queries() {
    if (!options_.switch_channels || config().slave_count == 0) return begin_rest();
    step_ = ConfigureStep::channels_on;
    const auto all = static_cast<std::uint8_t>((1U << config().slave_count) - 1U);
    session_.command(all, ControlCommand::channels, ExecuteIf::any_accepts);
  }
  constexpr void end_channels_on() {
    const auto error = session_.outcome().error;
    config().channels_were_switched = !error;
    // A slave without this command did not obey the broadcast, either.
    const bool stay_off = error && error != ControlError::not_accepted;
    // Slaves without an ID received the broadcast and cannot be addressed.
    unrestored_.channels_off = stay_off || session_.outcome().more_slaves;
    if (stay_off) {
      end_with({.cause = ConfigureError::channels_stay_off, .step = step_, .control = error});
    }
    begin_rest();
  }

  constexpr void begin_rest() {
    if (!fault_) {
      const auto fault = builder_.finish();
      if (fault) end_with(*fault);
    }
    step_ = ConfigureStep::rest;
    left_ = control_reset_zeros;
  }

  constexpr Configuration& config() { return builder_.config; }

  // The first cause is kept.
  constexpr void end_with(const ConfigureFault& fault) {
    if (!fault_) fault_ = fault;
  }

  ConfigureOptions options_;
  ControlSession session_;
  ConfigureStep step_ =
      ConfigureStep::channels_off;  // `identity` stands for all steps of the query
  ConfigureRequest request_{};
  std::uint32_t requests_ = 0;
  std::uint8_t left_ = 0;  // requests of this step
  std::uint8_t slave_ = 0;
  bool received_cds_ = false;
  bool reads_eds_ = false;  // all slaves are known except for their EDS
  Unrestored unrestored_{};
  configure_detail::SlaveQuery query_;
  configure_detail::LineBuilder builder_{options_.findings};
  std::optional<ConfigureFault> fault_{};
};

}  // namespace biss
