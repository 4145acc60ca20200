// Derives FrameFormat and DeviceTiming, which master and decoder need, from a data sheet.
//
//   const auto device =
//       describe_device(image, {}, [](const biss::EdsRemark& remark) { print(remark); });
//   if (device.ok()) use(device->format, timing_at(*device, clock));
//
// Data sheets in devices are often wrong. Therefore everything that can be used is used, every
// disagreement and every replaced value is reported, and single fields can be overridden. Nothing
// is allocated.
#pragma once

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <type_traits>

#include "biss/base/result.hpp"
#include "biss/base/units.hpp"
#include "biss/eds/bp3_part.hpp"
#include "biss/eds/common_part.hpp"
#include "biss/eds/field.hpp"
#include "biss/eds/image.hpp"
#include "biss/eds/profile.hpp"
#include "biss/frame/format.hpp"
#include "biss/timing/device_timing.hpp"

namespace biss {

// ---- Remarks and overrides

/// A field that is set by hand, because the device's value is wrong.
struct EdsOverride {
  EdsPart part = EdsPart::common;
  /// The data channel of the BP3 part; the common part's symbols contain their channel.
  std::uint8_t channel = 0;
  std::string_view symbol{};
  std::uint32_t value = 0;
};

/// The kinds of remarks.
enum class EdsRemarkKind : std::uint8_t {
  overridden,     ///< `used` instead of the value in the bank
  disagrees,      ///< another source has another value, which is used: `used`
  repaired,       ///< a common mistake, corrected: `used`
  not_usable,     ///< not a valid value; the value of the profile or the widest value is used
  not_given,      ///< nothing is stored; the value of the profile or the widest value is used
  undivided,      ///< the lengths do not fit DL: the position is not divided into turns
  other_reading,  ///< C = 1: the lengths fit DL only in the other reading, which is used
  hypothesis,     ///< used in a unit or a layout that no source confirms
  doubtful,       ///< the format of an identifier; doubt_of() gives the reason
  order,          ///< several channels: which is first on the line is an assumption
};

/// The message for a user, without a full stop.
constexpr std::string_view text_of(EdsRemarkKind kind) {
  constexpr std::string_view texts[] = {
      "overridden by hand",
      "another source has another value, which is used",
      "a usual mistake, read with its intended meaning",
      "not usable, so the default is used",
      "not given, so the default is used",
      "MT_LEN, CO_LEN and FI_LEN do not fit DL, so the position is not divided",
      "whether DL counts the CRC (BP3, table 5) or not (table 6): the lengths decide",
      "used, though no source confirms its unit or place",
      "the meaning of the identifier is not certain",
      "that the highest channel comes first on the line is an assumption"};
  return texts[static_cast<std::size_t>(kind)];
}

/// A remark. Text is static, except for the symbol of an override, which belongs to the caller.
struct EdsRemark {
  EdsPart part = EdsPart::common;
  std::uint8_t channel = 0;
  std::string_view symbol{};
  EdsRemarkKind kind = EdsRemarkKind::overridden;
  /// Raw, as in the bank.
  std::uint32_t stored = 0;
  /// Raw; 0 if a default is used.
  std::uint32_t used = 0;
};

/// A function that takes the remarks, one by one.
template <class T>
concept EdsRemarkSink = std::invocable<T&, const EdsRemark&>;

/// Why a data sheet does not describe a device.
enum class EdsDeviceCause : std::uint8_t {
  no_channel,        ///< DC_NUM is 0, or nothing was read
  unknown_channel,   ///< no source gives the number of bits of a channel
  actuator,          ///< a channel carries data to the device
  unknown_override,  ///< no such symbol, or a value wider than its field
  override_unread,   ///< the part to override was not read
};

/// The message for a user, without a full stop.
constexpr std::string_view text_of(EdsDeviceCause cause) {
  constexpr std::string_view texts[] = {
      "the data sheet has no data channel", "no source gives the number of bits of this channel",
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

namespace biss::eds_detail {

// ---- A data sheet with overridden fields

class EdsReader {
 public:
  constexpr EdsReader(const EdsImage& image, std::span<const EdsOverride> overrides)
      : image_(image), overrides_(overrides) {}

  constexpr const EdsImage& image() const { return image_; }

  // Checks that every override can be applied, and reports what it replaces.
  template <class Sink>
  constexpr std::optional<EdsDeviceError> announce(Sink& sink) const {
    for (std::size_t i = 0; i < overrides_.size(); ++i) {
      const EdsOverride& each = overrides_[i];
      const auto index = static_cast<std::uint8_t>(i);
      const EdsField* field = find_field(fields_of(each.part), each.symbol);
      if (field == nullptr || each.value > field->all_ones()) {
        return EdsDeviceError{EdsDeviceCause::unknown_override, index};
      }
      const EdsBank* bank = bank_of(each);
      if (bank == nullptr) return EdsDeviceError{EdsDeviceCause::override_unread, index};
      sink(EdsRemark{each.part, each.channel, field->symbol, EdsRemarkKind::overridden,
                     field_value(*bank, *field), each.value});
    }
    return std::nullopt;
  }

  constexpr bool overrides(EdsPart part, std::size_t channel, std::string_view symbol) const {
    return std::any_of(overrides_.begin(), overrides_.end(), [&](const EdsOverride& each) {
      return is_for(each, part, channel) && each.symbol == symbol;
    });
  }

  // \pre image().common is not null
  constexpr CommonPart common() const {
    return parse_common_part(overridden(*image_.common, EdsPart::common, 0));
  }
  // \pre image().profiles[channel] is not null
  constexpr Bp3Part bp3(std::size_t channel) const {
    return parse_bp3_part(overridden(*image_.profiles[channel], EdsPart::bp3, channel));
  }

 private:
  constexpr const EdsBank* bank_of(const EdsOverride& each) const {
    if (each.part == EdsPart::common) return image_.common;
    if (each.channel >= max_channels) return nullptr;
    return image_.profiles[each.channel];
  }

  static constexpr bool is_for(const EdsOverride& each, EdsPart part, std::size_t channel) {
    return each.part == part && (part == EdsPart::common || each.channel == channel);
  }

  constexpr EdsBank overridden(EdsBank bank, EdsPart part, std::size_t channel) const {
    for (const EdsOverride& each : overrides_) {
      if (!is_for(each, part, channel)) continue;
      const EdsField* field = find_field(fields_of(part), each.symbol);
      // announce() refuses what cannot be set.
      if (field != nullptr) static_cast<void>(set_field(bank, *field, each.value));
    }
    return bank;
  }

  const EdsImage& image_;
  std::span<const EdsOverride> overrides_;
};

// ---- The format of one data channel, from the data sheet and the registers

// The CRC of a polynomial stored without its lowest bit; no CRC when none of 3 to 16 bits.
constexpr CrcSpec crc_of_stored(std::uint32_t stored, std::uint32_t start) {
  const unsigned width = stored_crc_bits(stored);
  if (width < min_crc_bits || width > max_crc_bits) return {};
  return {.polynomial = stored << 1U | 1U,
          .start = static_cast<std::uint16_t>(start),
          .width_bits = static_cast<std::uint8_t>(width)};
}

template <class Sink>
class ChannelReader {
 public:
  using Answer = Result<ChannelFormat, EdsDeviceError>;

  constexpr ChannelReader(const EdsReader& from, std::size_t number, Sink& sink)
      : reader_(from), index_(number), sink_(sink) {
    const EdsImage& image = from.image();
    if (image.common != nullptr) common_ = from.common().channels[number];
    if (image.profiles[number] == nullptr) return;
    (profile_part(image, number) == EdsPart::bp3 ? part_ : raw_) = from.bp3(number);
  }

  constexpr Answer run() {
    if (common_ && common_->actuator()) return fail(EdsDeviceCause::actuator);
    const ProfileIdentifier id{chosen_identifier()};
    const bool same_layout = part_ && id.profile() == Profile::bp3;
    options_.crc = stated_crc(id, same_layout);
    const bool by_lengths = same_layout && id.crc_is_data() && take_reading(id);
    const auto channel = profile_channel(id.raw, options_);
    if (!channel.ok()) {
      if (id.raw != 0) remark_part(EdsRemarkKind::not_usable, "BP_ID", id.raw, 0);
      return from_lengths();
    }
    if (!doubt_of(id).empty() && !by_lengths) {
      remark_part(EdsRemarkKind::doubtful, "BP_ID", id.raw, id.raw);
    }
    ChannelFormat format = *channel;
    if (same_layout) refine(format);
    compare_with_common(id, format);
    return format;
  }

 private:
  constexpr Answer fail(EdsDeviceCause cause) const {
    return failure(EdsDeviceError{cause, static_cast<std::uint8_t>(index_)});
  }
  constexpr void remark(EdsPart part, EdsRemarkKind kind, std::string_view symbol,
                        std::uint32_t stored, std::uint32_t used) const {
    sink_(EdsRemark{part, static_cast<std::uint8_t>(index_), symbol, kind, stored, used});
  }
  constexpr void remark_part(EdsRemarkKind kind, std::string_view symbol, std::uint32_t stored,
                             std::uint32_t used) const {
    remark(raw_ ? EdsPart::raw : EdsPart::bp3, kind, symbol, stored, used);
  }
  constexpr bool common_overrides(unsigned which) const {
    return reader_.overrides(EdsPart::common, 0, channel_symbols[index_][which]);
  }

  // The priority: overrides, then registers, then the bank. An overridden DLEN_i replaces DL.
  constexpr std::uint16_t chosen_identifier() const {
    const auto registers = reader_.image().identifiers[index_];
    std::uint16_t stored = 0;
    if (part_ || raw_) stored = (part_ ? part_ : raw_)->bp_id;
    if (is_swapped_bp3(stored)) {
      const auto meant = static_cast<std::uint16_t>(bytes_swapped(stored, 2));
      remark_part(EdsRemarkKind::repaired, "BP_ID", stored, meant);
      stored = meant;
    }
    std::uint16_t used = stored;
    if (registers && *registers != 0 &&
        !(part_ && reader_.overrides(EdsPart::bp3, index_, "BP_ID"))) {
      used = *registers;
      if ((part_ || raw_) && used != stored) {
        remark_part(EdsRemarkKind::disagrees, "BP_ID", stored, used);
      }
    }
    const ProfileIdentifier id{used};
    if (common_ && common_overrides(1) && id.profile() == Profile::bp3) {
      const bool counted = id.crc_is_data() && options_.length_counts_crc;
      const unsigned length = common_->dlen + (counted ? crc6.width_bits : 0U);
      return id.with_length(length).raw;
    }
    return used;
  }

  // The CRC that the data sheet states: an overridden CPOLY_i, then the profile's part. Without a
  // usable one, the CRC of the profile.
  constexpr CrcSpec stated_crc(ProfileIdentifier id, bool same_layout) const {
    CrcSpec crc = raw_ ? raw_crc(id) : same_layout ? part_crc(id.crc_is_data()) : CrcSpec{};
    if (common_ && common_overrides(3)) {
      const CrcSpec by_hand = crc_of_stored(common_->cpoly, 0);
      if (by_hand.present()) crc = with_start(by_hand, crc.start);
    }
    return crc;
  }

  static constexpr CrcSpec with_start(CrcSpec crc, std::uint32_t start) {
    crc.start = start <= crc.mask() ? static_cast<std::uint16_t>(start) : std::uint16_t{0};
    return crc;
  }

  // BP3 states no polynomial for C = 1, so CPOLY may be left out.
  constexpr CrcSpec part_crc(bool crc_is_data) const {
    CrcSpec crc = crc_of_stored(repaired(EdsPart::bp3, "CPOLY", part_->cpoly), 0);
    if (!crc.present()) {
      const bool left_out = crc_is_data && part_->cpoly == 0;
      remark(EdsPart::bp3, left_out ? EdsRemarkKind::not_given : EdsRemarkKind::not_usable, "CPOLY",
             part_->cpoly, 0);
      crc = crc6;
    }
    if (part_->cstart > crc.mask()) {
      remark(EdsPart::bp3, EdsRemarkKind::not_usable, "CSTART", part_->cstart, 0);
    }
    return with_start(crc, part_->cstart);
  }

  // NXP's driver reads CPOLY and CSTART at BP3's addresses for every profile. A safety position word
  // has a CRC of 16 bits, whatever these bytes mean.
  constexpr CrcSpec raw_crc(ProfileIdentifier id) const {
    const bool safety = id.profile() == Profile::bp3s;
    CrcSpec crc = crc_of_stored(raw_->cpoly, 0);
    if (!crc.present() || raw_->cstart > crc.mask()) return {};
    if (safety && crc.width_bits != bp3s_crc.width_bits) return {};
    crc = with_start(crc, raw_->cstart);
    if (crc == (safety ? bp3s_crc : crc6)) return {};
    remark(EdsPart::raw, EdsRemarkKind::hypothesis, "CPOLY", raw_->cpoly, raw_->cpoly);
    return crc;
  }

  // C = 1: whether DL counts the CRC, by the lengths of the part. False: they fit neither reading.
  constexpr bool take_reading(ProfileIdentifier id) {
    const unsigned data_bits = part_->position_bits() + 2;
    const bool counts = data_bits + options_.crc.width_bits == id.data_length();
    if (!counts && data_bits != id.data_length()) return false;
    if (counts != options_.length_counts_crc) {
      remark(EdsPart::bp3, EdsRemarkKind::other_reading, "BP_ID", id.raw, id.raw);
      options_.length_counts_crc = counts;
    }
    return true;
  }

  // Without a usable identifier: the lengths of the BP3 part, or DLEN_i with its two flags.
  constexpr Answer from_lengths() {
    const bool by_hand = common_ && common_overrides(1);
    if (part_ && !by_hand && part_->position_bits() >= 1 &&
        part_->position_bits() + 2 <= bp3_max_data_bits) {
      if (!options_.crc.present()) options_.crc = stated_crc({}, true);
      ChannelFormat format = position_channel(part_->position_bits(), 0, options_.crc);
      refine(format);
      return format;
    }
    if (!common_ || common_->dlen == 0 || common_->dlen > max_data_bits) {
      return fail(EdsDeviceCause::unknown_channel);
    }
    ChannelFormat format;
    format.data_bits = common_->dlen;
    if (common_->dlen >= 2) format = position_channel(common_->dlen - 2U, 0, {});
    format.crc =
        crc_of_stored(repaired(EdsPart::common, channel_symbols[index_][3], common_->cpoly), 0);
    if (raw_ && options_.crc.present()) {
      format.crc = options_.crc;
    } else if (!raw_ && !format.crc.present()) {
      remark(EdsPart::common, EdsRemarkKind::not_given, channel_symbols[index_][3], common_->cpoly,
             0);
    }
    return format;
  }

  constexpr void refine(ChannelFormat& format) const {
    divide(format);
    set_flags(format);
  }

  // Turns above singleturn if the lengths fit; a scale has no turns. Bits that the counts do not
  // need are padding.
  constexpr void divide(ChannelFormat& format) const {
    if (part_->position_bits() != format.position.bits) {
      remark(EdsPart::bp3, EdsRemarkKind::undivided, "MT_LEN", part_->position_bits(),
             format.position.bits);
      return;
    }
    const bool turns = !part_->linear() && part_->mt_len != 0;
    const Bp3Zeros zeros = part_->linear() ? scale_zeros(*part_) : singleturn_zeros(*part_);
    if (zeros.inside) remark(EdsPart::bp3, EdsRemarkKind::not_usable, "FI_FMT", part_->fi_fmt, 0);
    const unsigned low = format.position.shift;
    if (!turns) {
      format.position = without(zeros, low, format.position.bits);
      return;
    }
    const unsigned singleturn = singleturn_bits(*part_);
    format.position = {};
    if (singleturn != 0) format.singleturn = without(zeros, low, singleturn);
    format.multiturn = without(turns_zeros(*part_), low + singleturn, part_->mt_len);
  }

  // The rest of `bits` bits from `shift` on without these zeros.
  static constexpr Field without(const Bp3Zeros& zeros, unsigned shift, unsigned bits) {
    if (bits == 0) return {};
    return {static_cast<std::uint8_t>(shift + zeros.trailing),
            static_cast<std::uint8_t>(bits - zeros.leading - zeros.trailing)};
  }

  // Table B: 1 is nE, 2 is nW, 0 any value.
  constexpr void set_flags(ChannelFormat& format) const {
    const std::uint8_t first = format.error.shift;
    const std::uint8_t second = format.warning.shift;
    if (part_->fb1 > 2 || part_->fb2 > 2 || (part_->fb1 == part_->fb2 && part_->fb1 != 0)) {
      const bool first_wrong = part_->fb1 != 1;
      remark(EdsPart::bp3, EdsRemarkKind::not_usable, first_wrong ? "FB1" : "FB2",
             first_wrong ? part_->fb1 : part_->fb2, 0);
      return;
    }
    const auto flag = [&](unsigned function) -> FlagField {
      if (part_->fb1 == function) return {.shift = first, .present = true};
      if (part_->fb2 == function) return {.shift = second, .present = true};
      return {};
    };
    format.error = flag(1);
    format.warning = flag(2);
  }

  // Corrects a polynomial in full form, or with its bytes swapped.
  constexpr std::uint32_t repaired(EdsPart part, std::string_view symbol,
                                   std::uint32_t stored) const {
    std::uint32_t meant = stored;
    if (is_full_form_of_known(stored)) meant = stored >> 1U;
    if (part == EdsPart::bp3 && bytes_swapped(stored, 4) == crc6.polynomial >> 1U) {
      meant = crc6.polynomial >> 1U;
    }
    if (meant != stored) remark(part, EdsRemarkKind::repaired, symbol, stored, meant);
    return meant;
  }

  // The profile has precedence, unless the common part's field is overridden.
  constexpr void compare_with_common(ProfileIdentifier id, const ChannelFormat& format) const {
    if (!common_) return;
    const auto& symbols = channel_symbols[index_];
    // With C = 1, the sources do not state whether DLEN_i counts the CRC.
    const bool same = common_->dlen == format.data_bits ||
                      (id.crc_is_data() && common_->dlen == format.total_bits());
    if (!same && common_->dlen != 0) {
      remark(EdsPart::common, EdsRemarkKind::disagrees, symbols[1], common_->dlen,
             format.data_bits);
    }
    if (common_->cpoly == 0 || common_overrides(3)) return;
    if (common_->cpoly != format.crc.polynomial >> 1U) {
      remark(EdsPart::common, EdsRemarkKind::disagrees, symbols[3], common_->cpoly,
             format.crc.polynomial >> 1U);
    }
  }

  const EdsReader& reader_;
  std::size_t index_;
  ProfileOptions options_{};
  Sink& sink_;
  std::optional<CommonChannel> common_{};
  std::optional<Bp3Part> part_{};
  std::optional<Bp3Part> raw_{};  // read as if it had BP3's layout, for its CRC only
};

}  // namespace biss::eds_detail

namespace biss {

struct EdsDevice {
  FrameFormat format{};
  /// Without BUSY_S, which counts clocks; see timing_at().
  DeviceTiming timing{};
  std::uint8_t busy_s_clocks = 0;
  /// IDs the device takes; 0: not known.
  std::uint8_t slaves = 0;
  /// From power-on until control communication (a hypothesis), and until the last position.
  std::optional<Picoseconds> control_ready{};
  std::optional<Picoseconds> position_ready{};
};

/// The device's timing at one clock: BUSY_S delays START after the processing time; together they
/// take at most 40 us (D2). \pre clock is not 0 Hz
constexpr DeviceTiming timing_at(const EdsDevice& device, Hertz clock) {
  DeviceTiming timing = device.timing;
  const Picoseconds busy_s = std::int64_t{device.busy_s_clocks} * period_of(clock);
  timing.ack_max = std::min(std::min(timing.ack_max, biss_busy_max) + busy_s, biss_busy_max);
  return timing;
}

namespace eds_detail {

template <class Sink>
class TimingReader {
 public:
  constexpr TimingReader(const CommonPart& part, Sink& sink) : part_(part), sink_(sink) {}

  constexpr void fill(EdsDevice& device) const {
    DeviceTiming& timing = device.timing;
    set_clock(timing);
    if (part_.busy_s <= biss_busy_s_max_clocks) {
      device.busy_s_clocks = part_.busy_s;
    } else {
      say(EdsRemarkKind::not_usable, "BUSY_S", part_.busy_s, 0);
      device.busy_s_clocks = biss_busy_s_max_clocks;
    }
    if (const auto busy = time("TBUSY_MAX", part_.tbusy_max, biss_busy_max)) timing.ack_max = *busy;
    set_timeout(timing.timeout);
    // A longer cycle is safe, so all ones count as a time here.
    if (part_.tcyc != 0) timing.cycle_min = assumed("TCYC", part_.tcyc);
    if (part_.pon_dly != 0 && part_.pon_dly != 0xFFFF) {
      device.control_ready = assumed("PON_DLY", part_.pon_dly);
    }
  }

 private:
  constexpr void say(EdsRemarkKind kind, std::string_view symbol, std::uint32_t stored,
                     std::uint32_t used) const {
    sink_(EdsRemark{EdsPart::common, 0, symbol, kind, stored, used});
  }

  // The time of a field, whose unit is a hypothesis.
  constexpr Picoseconds assumed(std::string_view symbol, std::uint32_t raw) const {
    say(EdsRemarkKind::hypothesis, symbol, raw, raw);
    return eds_time(symbol, raw);
  }

  constexpr void set_clock(DeviceTiming& timing) const {
    if (part_.tma == 0) {
      say(EdsRemarkKind::not_given, "TMA", part_.tma, 0);
      return;
    }
    const Hertz clock = rate_of(eds_time("TMA", part_.tma));
    if (clock > biss_clock_max) say(EdsRemarkKind::not_usable, "TMA", part_.tma, 0);
    timing.clock_max = std::min(clock, biss_clock_max);
  }

  // A time that is given and is not longer than BiSS C allows.
  constexpr std::optional<Picoseconds> time(std::string_view symbol, std::uint8_t raw,
                                            Picoseconds longest) const {
    if (!is_given(raw)) {
      say(EdsRemarkKind::not_given, symbol, raw, 0);
      return std::nullopt;
    }
    if (eds_time(symbol, raw) > longest) {
      say(EdsRemarkKind::not_usable, symbol, raw, 0);
      return std::nullopt;
    }
    return assumed(symbol, raw);
  }

  // A device that states its sampling clock has the adaptive timeout, at most 3 of these clocks
  // above 1.5 periods (D2); otherwise the short one, or the static one.
  constexpr void set_timeout(Timeout& timeout) const {
    if (is_given(part_.tclk_max)) {
      const auto clock = time("TCLK_MAX", part_.tclk_max, biss_static_timeout_max);
      if (!clock) return;
      timeout.rule = TimeoutRule::adaptive;
      timeout.time = 3 * *clock;
      return;
    }
    const bool is_short = is_given(part_.tos_max);
    const auto fixed = is_short ? time("TOS_MAX", part_.tos_max, biss_static_timeout_max)
                                : time("TO_MAX", part_.to_max, biss_static_timeout_max);
    if (!fixed) return;
    timeout.rule = TimeoutRule::fixed;
    timeout.time = *fixed;
  }

  const CommonPart& part_;
  Sink& sink_;
};

}  // namespace eds_detail

/// The device that a data sheet describes, as far as it was read, with `overrides` applied first.
/// The priority is: overrides, registers, the profile's part, the common part. Times that are not
/// given are the widest that BiSS C allows. Parts of BP1 and BP3S are not decoded; the CRC at BP3's
/// addresses is taken from them as a hypothesis.
template <EdsRemarkSink Sink>
constexpr Result<EdsDevice, EdsDeviceError> describe_device(const EdsImage& image,
                                                            std::span<const EdsOverride> overrides,
                                                            Sink&& sink) {
  using PlainSink = std::remove_reference_t<Sink>;
  const eds_detail::EdsReader reader(image, overrides);
  if (const auto refused = reader.announce(sink)) return failure(*refused);
  EdsDevice device;
  std::size_t channels = channel_count(image);
  if (image.common != nullptr) {
    const CommonPart common = reader.common();
    channels = std::min<std::size_t>(common.dc_num, max_channels);
    device.slaves = common.sl_num;
    eds_detail::TimingReader<PlainSink>(common, sink).fill(device);
  }
  if (channels == 0) return failure(EdsDeviceError{EdsDeviceCause::no_channel, 0});
  if (channels > 1) {
    const auto count = static_cast<std::uint32_t>(channels);
    // Channel i belongs to the slave with the i-th ID, and the highest ID is first on the line.
    sink(EdsRemark{EdsPart::common, 0, "DC_NUM", EdsRemarkKind::order, count, count});
  }
  for (std::size_t i = 0; i < channels; ++i) {
    const auto channel = eds_detail::ChannelReader<PlainSink>(reader, i, sink).run();
    if (!channel.ok()) return failure(channel.error());
    device.format.channel_list[channels - 1 - i] = *channel;
    if (image.profiles[i] == nullptr || profile_part(image, i) != EdsPart::bp3) continue;
    const std::uint8_t delay = reader.bp3(i).pon_pdl;
    if (!eds_detail::is_given(delay)) continue;
    device.position_ready =
        std::max(device.position_ready.value_or(Picoseconds{}), milliseconds(delay));
  }
  device.format.channel_count = static_cast<std::uint8_t>(channels);
  return device;
}

}  // namespace biss
