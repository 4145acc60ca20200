// All that a configuration asks one slave: its identity, its profile, its EDS.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "biss/configure/configuration.hpp"
#include "biss/configure/configure_error.hpp"
#include "biss/control/control_error.hpp"
#include "biss/control/register_map.hpp"
#include "biss/control/session.hpp"
#include "biss/control/vendor_registers.hpp"
#include "biss/eds/bank.hpp"
#include "biss/eds/common_part.hpp"
#include "biss/eds/image.hpp"

namespace biss::configure_detail {

/// Whether this maker's devices have in a register what the map says, as far as is known.
constexpr bool follows_map(const std::optional<DeviceIdentity>& identity, unsigned address) {
  if (!identity) return true;
  const auto maker = manufacturer_name(identity->manufacturer);
  for (const VendorRegister& quirk : map_quirks) {
    if (maker && quirk.vendor == *maker && quirk.contains(address)) return false;
  }
  return true;
}

/// One access after the other on a session of the owner's. What a slave does not have is left out;
/// BSEL is put back whatever happened. Not to be moved while it runs: the session writes into it.
class SlaveQuery {
 public:
  constexpr void begin(ControlSession& session, std::uint8_t slave) {
    slave_ = slave;
    description_ = {};
    failed_.reset();
    has_common_ = bank_dirty_ = false;
    has_channel_ = {};
    channel_ = 0;
    read(session, ConfigureStep::identity, reg::dev_id, 8);
  }

  /// To be called when the session's access is over.
  /// \return false: that was the last one
  constexpr bool advance(ControlSession& session) {
    const ControlOutcome& outcome = session.outcome();
    if (outcome.error == ControlError::next_unavailable && outcome.bytes_done != 0) {
      // The device knows no longer sequence; the rest may still be there.
      to_ = to_.subspan(outcome.bytes_done);
      address_ = static_cast<std::uint8_t>(address_ + outcome.bytes_done);
      writing_ ? session.write(slave_, address_, to_) : session.read(slave_, address_, to_);
      return true;
    }
    const bool there = !outcome.error;
    // Refused, so BSEL still is what it was.
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
        if (there) description_.profile = number();
        return read(session, ConfigureStep::serial, reg::dev_sn, 4);
      case ConfigureStep::serial:
        if (there && follows_map(description_.identity, reg::dev_sn)) {
          description_.serial = serial_number(buffer().first<4>());
        }
        return read(session, ConfigureStep::find_eds, reg::eds_bank, 1);
      case ConfigureStep::find_eds:
        return there && seek_eds(session);
      case ConfigureStep::select_bank:
        return there ? selected(session) : leave_eds(session);
      case ConfigureStep::read_common:
        return there ? take_common(session) : leave_eds(session);
      default:
        return there ? take_channel(session) : skip_channel(session);
    }
  }

  constexpr ConfigureStep step() const { return step_; }
  constexpr const SlaveDescription& description() const { return description_; }
  /// Why the query ended early.
  constexpr std::optional<ControlError> failed() const { return failed_; }
  /// The step at which it did. \pre failed()
  constexpr ConfigureStep failed_step() const { return failed_step_; }
  /// BSEL is not known to be as it was.
  constexpr bool bank_dirty() const { return bank_dirty_; }
  constexpr bool has_eds() const { return has_common_; }
  constexpr CommonPart common() const { return parse_common_part(common_); }
  /// What was read of the EDS; valid as long as the query is not begun again. \pre has_eds()
  constexpr EdsImage image() const {
    EdsImage image{.common = &common_, .eds_bank = description_.eds_bank};
    for (std::size_t i = 0; i < max_channels; ++i) {
      if (has_channel_[i]) image.profiles[i] = &channels_[i];
    }
    return image;
  }

 private:
  constexpr std::span<std::uint8_t, bank_bytes> buffer() { return buffer_; }
  constexpr std::uint16_t number() const {
    return static_cast<std::uint16_t>(std::uint32_t{buffer_[0]} << 8U | buffer_[1]);
  }

  // A clear no; an old device without W inversion says it by never starting, neither to be read nor
  // to be written.
  static constexpr bool is_absent(ControlError error) {
    return error == ControlError::refused || error == ControlError::refused_or_unheard ||
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
    buffer_[0] = wanted_bank_ = bank;
    return begin_access(session, step, reg::bsel, buffer().first(1), true);
  }

  constexpr bool seek_eds(ControlSession& session) {
    description_.eds_bank = buffer_[0];
    if (eds_presence(buffer_[0]) == EdsPresence::none) return false;
    if (!follows_map(description_.identity, reg::bsel)) {
      description_.eds_unused = true;
      return false;
    }
    return read(session, ConfigureStep::select_bank, reg::bsel, 1);
  }

  // BSEL was read, or written.
  constexpr bool selected(ControlSession& session) {
    if (!writing_) {
      found_bank_ = bank_ = buffer_[0];
      if (bank_ != description_.eds_bank) {
        return select(session, ConfigureStep::select_bank, description_.eds_bank);
      }
    } else {
      bank_ = wanted_bank_;
    }
    return begin_access(session, ConfigureStep::read_common, reg::bank, common_, false);
  }

  constexpr bool take_common(ControlSession& session) {
    if (!is_sound(common_)) return leave_eds(session);
    has_common_ = true;
    return next_channel(session);
  }

  constexpr bool next_channel(ControlSession& session) {
    const CommonPart part = common();
    const std::size_t count = std::min<std::size_t>(part.dc_num, max_channels);
    while (channel_ < count && part.channels[channel_].bank == 0) ++channel_;
    if (channel_ == count) return restore(session);
    const std::uint8_t bank = part.channels[channel_].bank;
    if (bank != bank_) return select(session, ConfigureStep::read_channels, bank);
    return begin_access(session, ConfigureStep::read_channels, reg::bank, channels_[channel_],
                        false);
  }

  constexpr bool take_channel(ControlSession& session) {
    if (writing_) {
      bank_ = wanted_bank_;
    } else {
      has_channel_[channel_] = is_sound(channels_[channel_]);
      if (!has_channel_[channel_]) description_.eds_unused = true;
      ++channel_;
    }
    return next_channel(session);
  }
  constexpr bool skip_channel(ControlSession& session) {
    description_.eds_unused = true;
    ++channel_;
    return next_channel(session);
  }

  // An empty bank has the right sum, too.
  static constexpr bool is_sound(const EdsBank& bank) {
    return bank[eds_checksum_address] == eds_checksum(bank) && !is_filled_with(bank, 0);
  }

  constexpr bool leave_eds(ControlSession& session) {
    // 0xFF says "none" on some devices.
    description_.eds_unused = eds_presence(description_.eds_bank) == EdsPresence::present;
    return restore(session);
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
  // The access under way.
  std::uint8_t address_ = 0;
  bool writing_ = false;
  std::span<std::uint8_t> to_{};
  std::array<std::uint8_t, bank_bytes> buffer_{};

  std::uint8_t found_bank_ = 0;   // BSEL as it was
  std::uint8_t bank_ = 0;         // BSEL as it is
  std::uint8_t wanted_bank_ = 0;  // BSEL as it is to be
  bool bank_dirty_ = false;
  bool has_common_ = false;
  std::size_t channel_ = 0;
  EdsBank common_{};
  std::array<bool, max_channels> has_channel_{};
  std::array<EdsBank, max_channels> channels_{};
};

}  // namespace biss::configure_detail
