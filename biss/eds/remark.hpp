// What describing a device from its data sheet came across, and how the data sheet is overridden.
#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "biss/eds/field.hpp"

namespace biss {

/// A single field set by hand, because what the device holds is wrong.
struct EdsOverride {
  EdsPart part = EdsPart::common;
  /// The data channel whose BP3 part is meant; the common part's symbols carry theirs.
  std::uint8_t channel = 0;
  std::string_view symbol{};
  std::uint32_t value = 0;
};

/// One enumerator a reason to say something.
enum class EdsRemarkKind : std::uint8_t {
  overridden,  ///< `used` instead of what the bank holds
  disagrees,   ///< another source says something else and is believed: `used`
  repaired,    ///< a usual mistake read as what it means: `used`
  not_usable,  ///< no sense can be made of it; the profile's or the widest value stands in
  not_given,   ///< the same, because nothing is stored
  undivided,   ///< the lengths do not fit DL: the position is not divided into turns
  hypothesis,  ///< used, in a unit or a layout that no source confirms
  doubtful,    ///< the identifier's format: doubt_of() says why
  order,       ///< several channels: which is first on the line is an assumption
};

inline constexpr std::size_t eds_remark_count = 9;

/// The name scripts see, the same as the enumerator's.
constexpr std::string_view name_of(EdsRemarkKind kind) {
  constexpr std::array<std::string_view, eds_remark_count> names{
      "overridden", "disagrees",  "repaired", "not_usable", "not_given",
      "undivided",  "hypothesis", "doubtful", "order"};
  return names[static_cast<std::size_t>(kind)];
}

/// What a user is told, without a full stop.
constexpr std::string_view text_of(EdsRemarkKind kind) {
  constexpr std::array<std::string_view, eds_remark_count> texts{
      "overridden by hand",
      "another source says otherwise and is believed",
      "a usual mistake, read as what it means",
      "not usable, the default stands in",
      "not given, the default stands in",
      "MT_LEN, CO_LEN and FI_LEN do not fit DL, the position is left undivided",
      "used, though no source confirms its unit or place",
      "what the identifier means is not beyond doubt",
      "that the highest channel comes first on the line is an assumption"};
  return texts[static_cast<std::size_t>(kind)];
}

/// A remark. Text is static, but for the symbol of an override, which is the caller's.
struct EdsRemark {
  EdsPart part = EdsPart::common;
  std::uint8_t channel = 0;
  std::string_view symbol{};
  EdsRemarkKind kind = EdsRemarkKind::overridden;
  /// Raw, as in the bank.
  std::uint32_t stored = 0;
  /// Raw; 0 where a default stands in.
  std::uint32_t used = 0;
};

/// What takes the remarks, one by one.
template <class T>
concept EdsRemarkSink = std::invocable<T&, const EdsRemark&>;

/// What no document settles.
struct EdsDeviceOptions {
  /// C = 1: whether DL counts the CRC (ProfileOptions::length_counts_crc), and whether to check it.
  bool check_crc_in_data = false;
  bool length_counts_crc = true;
  /// Use the times whose unit is a hypothesis (biss/eds/scale.hpp); false leaves them at the widest
  /// that BiSS C allows.
  bool use_hypotheses = true;
  /// Channel i is the slave's with the i-th ID, and the highest ID comes first on the line.
  bool highest_channel_first = true;
};

/// Why a data sheet describes no device.
enum class EdsDeviceCause : std::uint8_t {
  no_channel,        ///< DC_NUM is 0, or nothing was read
  unknown_channel,   ///< no source says how many bits a channel has
  actuator,          ///< a channel carries data to the device
  unknown_override,  ///< no such symbol, or a value wider than its field
  override_unread,   ///< the part to override was not read
};

inline constexpr std::size_t eds_device_cause_count = 5;

/// What a user is told, without a full stop.
constexpr std::string_view text_of(EdsDeviceCause cause) {
  constexpr std::array<std::string_view, eds_device_cause_count> texts{
      "the data sheet has no data channel", "no source says how many bits this channel has",
      "this channel carries data to the device, which is not supported",
      "no field with this symbol takes this value", "the part with this field was not read"};
  return texts[static_cast<std::size_t>(cause)];
}

struct EdsDeviceError {
  EdsDeviceCause cause = EdsDeviceCause::no_channel;
  /// The channel; for an override its index.
  std::uint8_t index = 0;

  constexpr bool operator==(const EdsDeviceError&) const = default;
};

}  // namespace biss
