// Checks a data sheet: each part alone, and the parts against each other and the registers.
//
//   check_eds(image, [](const biss::EdsFinding& finding) { print(finding); });
//
// It allocates and corrects nothing; a good data sheet gives no finding. A wrong field is reported
// where its own range or a contradiction shows it; otherwise the checksum shows that the bank is
// damaged somewhere. The units of times are not checked: most of them are hypotheses.
#pragma once

#include <array>
#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <type_traits>

#include "biss/base/units.hpp"
#include "biss/crc/spec.hpp"
#include "biss/eds/bank.hpp"
#include "biss/eds/bp3_part.hpp"
#include "biss/eds/common_part.hpp"
#include "biss/eds/field.hpp"
#include "biss/eds/image.hpp"
#include "biss/eds/profile.hpp"
#include "biss/timing/device_timing.hpp"

namespace biss {

// ---- Findings

/// What can be wrong with a data sheet.
enum class EdsProblem : std::uint8_t {
  all_zero,              ///< an empty bank, whose checksum is even right
  all_ones,              ///< erased memory
  checksum,              ///< not the sum of the bytes
  out_of_range,          ///< outside the document's range, not marked as absent either
  version,               ///< a version that is not known
  profile,               ///< the identifier is not BP3's
  reserved_bit,          ///< bit 7 of the identifier
  data_length,           ///< DL that the profile does not allow
  reserved_not_zero,     ///< a reserved byte
  unnamed_not_zero,      ///< a byte or bit that no source names (only when asked)
  little_endian,         ///< lowest byte first: the other order makes sense
  polynomial_full_form,  ///< with its lowest bit, which must be left out
  polynomial,            ///< not the profile's, or no CRC of 3 to 16 bits
  min_above_max,         ///< a shortest, lowest, first above its longest, highest, last
  lengths,               ///< MT_LEN, CO_LEN, FI_LEN, flags (and CRC with C = 1) do not add up to DL
  length_reading,        ///< C = 1: they add up to DL in the other reading, with or without CRC
  count_above_length,    ///< more counts than its length in bits can represent
  alignment,             ///< zeros not where BP3 has them: before MT, after the singleturn value
  encoder_type,          ///< rotary or linear, but counts, lengths and checksum fit the other
  crc_bit,               ///< C = 0 in a safety encoder, C = 1 in a standard encoder
  identifier,            ///< differs from registers 0x42 and 0x43
  channel_count,         ///< DC_NUM is not the number of channels that are filled in
  channel_unused,        ///< something in a channel beyond DC_NUM
  bank_is_common,        ///< a channel's part in the common part's own bank: a loop
  bank_outside,          ///< a channel's part outside the data sheet
  bank_shared,           ///< two channels with one part
  bank_in_user_area,     ///< a bank of the data sheet among the user banks
  too_few_banks,         ///< EDS_LEN leaves no room for the parts, or runs past bank 255
  slave_offset,          ///< SL_OFF is not below SL_NUM
  actuator,              ///< BP3 is a sensor's profile
  data_length_differs,   ///< DLEN_i is not the profile's DL
  polynomial_differs,    ///< CPOLY_i is not the profile's CPOLY
};

inline constexpr std::size_t eds_problem_count = 32;

/// The name that scripts see, the same as the enumerator's.
constexpr std::string_view name_of(EdsProblem problem) {
  constexpr std::array<std::string_view, eds_problem_count> names{"all_zero",
                                                                  "all_ones",
                                                                  "checksum",
                                                                  "out_of_range",
                                                                  "version",
                                                                  "profile",
                                                                  "reserved_bit",
                                                                  "data_length",
                                                                  "reserved_not_zero",
                                                                  "unnamed_not_zero",
                                                                  "little_endian",
                                                                  "polynomial_full_form",
                                                                  "polynomial",
                                                                  "min_above_max",
                                                                  "lengths",
                                                                  "length_reading",
                                                                  "count_above_length",
                                                                  "alignment",
                                                                  "encoder_type",
                                                                  "crc_bit",
                                                                  "identifier",
                                                                  "channel_count",
                                                                  "channel_unused",
                                                                  "bank_is_common",
                                                                  "bank_outside",
                                                                  "bank_shared",
                                                                  "bank_in_user_area",
                                                                  "too_few_banks",
                                                                  "slave_offset",
                                                                  "actuator",
                                                                  "data_length_differs",
                                                                  "polynomial_differs"};
  return names[static_cast<std::size_t>(problem)];
}

/// The message for a user, without a full stop.
constexpr std::string_view text_of(EdsProblem problem) {
  constexpr std::array<std::string_view, eds_problem_count> texts{
      "the bank is empty, every byte is 0",
      "the bank is erased memory, every byte is 0xFF",
      "not the sum of the bytes before it",
      "outside its range",
      "this version is not known",
      "not an identifier of BP3",
      "bit 7 must be 0",
      "the profile does not allow this data length",
      "a reserved byte must be 0",
      "no source names this byte or bit",
      "the bytes stand in the wrong order, the highest comes first",
      "the polynomial has its lowest bit, which must be left out",
      "not a polynomial of this profile",
      "the lower limit is above the upper one",
      "MT_LEN, CO_LEN, FI_LEN and the flags do not add up to DL",
      "the lengths and flags fit only the other reading of DL; with C = 1, BP3's table 5 adds the "
      "CRC bits to the data length, and table 6 says \"data length without CRC\"",
      "more counts than its length can tell apart",
      "BP3 aligns turns right, with leading zeros, and the singleturn value left, with trailing "
      "zeros",
      "counts, lengths and checksum are those of the other type",
      "C must be 1 in a safety encoder, and 0 in a standard encoder",
      "not what the registers 0x42 and 0x43 say",
      "not the number of channels that are filled in",
      "something stands in a channel that DC_NUM leaves out",
      "the bank is the common part's own",
      "the bank is not one of the data sheet's",
      "two channels share this bank",
      "a bank of the data sheet lies among the user banks",
      "the data sheet's length has no room for its parts",
      "the device has fewer slaves",
      "BP3 is a profile of sensors",
      "not the data length of the profile's part",
      "not the polynomial of the profile's part"};
  return texts[static_cast<std::size_t>(problem)];
}

/// A finding. Text is static.
struct EdsFinding {
  EdsPart part = EdsPart::common;
  /// The data channel whose part it is; 0 in the common part.
  std::uint8_t channel = 0;
  /// The wrong field, as far as it is known; the version field for a whole bank.
  std::string_view symbol{};
  EdsProblem problem = EdsProblem::checksum;
  /// As stored.
  std::uint32_t value = 0;
  /// The field that it contradicts, which may be the wrong one instead; empty when there is none.
  std::string_view against{};
  /// The right value where it is known (checksum, lengths, registers, the other byte order, the
  /// polynomial's right form); otherwise the value of `against`.
  std::uint32_t expected = 0;
};

/// Two fields, or the data sheet and the registers, describe different frames or times, and no rule
/// says which is right. A format from such a data sheet may be wrong.
constexpr bool contradicts(const EdsFinding& finding) {
  switch (finding.problem) {
    case EdsProblem::lengths:
    case EdsProblem::count_above_length:
    case EdsProblem::encoder_type:
    case EdsProblem::identifier:
    case EdsProblem::bank_is_common:
    case EdsProblem::bank_shared:
    case EdsProblem::slave_offset:
    case EdsProblem::data_length:
    case EdsProblem::data_length_differs:
      return true;
    case EdsProblem::alignment:
      return finding.against.ends_with("_FMT");  // no format has zeros between two fields
    case EdsProblem::out_of_range:
      return finding.against == "FB2";  // no nE
    case EdsProblem::polynomial_differs:
      return finding.value != 0;  // else it is not given
    case EdsProblem::channel_count:
      return finding.expected > finding.value;  // fewer: registers may describe the others
    case EdsProblem::min_above_max:
      return finding.part == EdsPart::common;  // not those of temperature and supply
    case EdsProblem::little_endian:
      return !finding.against.empty();  // a count; identifier and polynomial are repaired
    default:
      return false;
  }
}

/// A function that takes the findings, one by one.
template <class T>
concept EdsSink = std::invocable<T&, const EdsFinding&>;

/// What no document defines.
struct EdsCheckOptions {
  /// 0 and all ones mark an optional value that is not given (inferred: the ranges exclude just
  /// these two). False: they are out of range.
  bool zero_is_absent = true;
  bool ones_are_absent = true;
  /// Reserved bytes must be 0. The documents do not say so.
  bool reserved_zero = true;
  /// Bytes and bits that no source names must be 0: common part 0x13, bits 2 and 4…7 of FORMAT_i,
  /// 5…7 of BC_OFF.
  bool unnamed_zero = false;
  /// With C = 1, DL counts the CRC's bits: ProfileOptions::length_counts_crc.
  bool length_counts_crc = true;
  /// Parts of other profiles have BP3's checksum, too.
  bool raw_checksum = true;

  /// Whether a value of an optional field means that it is not given.
  constexpr bool absent(std::uint32_t value, std::uint32_t all_ones) const {
    return (zero_is_absent && value == 0) || (ones_are_absent && value == all_ones);
  }
};

}  // namespace biss

namespace biss::eds_detail {

// ---- What the checks of all parts share

// One part under test, and the receiver of its findings.
template <EdsSink Sink>
struct PartReport {
  Sink& sink;
  EdsPart part = EdsPart::common;
  std::uint8_t channel = 0;

  constexpr void operator()(EdsProblem problem, std::string_view symbol, std::uint32_t value,
                            std::string_view against = {}, std::uint32_t expected = 0) const {
    sink(EdsFinding{part, channel, symbol, problem, value, against, expected});
  }
};

// Reports a bank that is empty or erased; true when it is.
template <class Report>
constexpr bool check_filling(const EdsBank& bank, std::string_view first, const Report& report) {
  if (is_filled_with(bank, 0x00)) {
    report(EdsProblem::all_zero, first, 0x00);
    return true;
  }
  if (is_filled_with(bank, 0xFF)) {
    report(EdsProblem::all_ones, first, 0xFF);
    return true;
  }
  return false;
}

template <class Report>
constexpr void check_sum(const EdsBank& bank, const Report& report) {
  const std::uint8_t stored = bank[eds_checksum_address];
  const std::uint8_t computed = eds_checksum(bank);
  if (stored != computed) report(EdsProblem::checksum, "CHKSUM", stored, {}, computed);
}

// Checks the range of a plain value, and bytes that must be 0.
template <class Report>
constexpr void check_value(const EdsField& field, std::uint32_t value,
                           const EdsCheckOptions& options, const Report& report) {
  switch (field.kind) {
    case EdsKind::reserved:
      if (options.reserved_zero && value != 0) {
        report(EdsProblem::reserved_not_zero, field.symbol, value);
      }
      return;
    case EdsKind::unnamed:
      if (options.unnamed_zero && value != 0) {
        report(EdsProblem::unnamed_not_zero, field.symbol, value);
      }
      return;
    case EdsKind::identifier:
    case EdsKind::feedback:
    case EdsKind::polynomial:
    case EdsKind::channel_format:
    case EdsKind::bus_coupler:
    case EdsKind::checksum:
      return;  // have checks of their own
    default:
      break;
  }
  if (field.in_range(value)) return;
  if (field.may_be_absent() && options.absent(value, field.all_ones())) return;
  report(EdsProblem::out_of_range, field.symbol, value);
}

template <class Report>
constexpr void check_values(const EdsBank& bank, std::span<const EdsField> fields,
                            const EdsCheckOptions& options, const Report& report) {
  for (const EdsField& field : fields) {
    check_value(field, field_value(bank, field), options, report);
  }
}

// Reports two given limits in the wrong order.
template <class Report>
constexpr void check_order(std::string_view low_symbol, std::uint32_t low,
                           std::string_view high_symbol, std::uint32_t high, std::uint32_t all_ones,
                           const EdsCheckOptions& options, const Report& report) {
  if (options.absent(low, all_ones) || options.absent(high, all_ones) || low <= high) return;
  report(EdsProblem::min_above_max, low_symbol, low, high_symbol, high);
}

}  // namespace biss::eds_detail

namespace biss {

// ---- Checks of a common part
namespace eds_detail {

// 0 and 0xFF: not filled in.
constexpr bool is_empty(std::uint8_t byte) { return byte == 0x00 || byte == 0xFF; }

template <class Report>
class CommonCheck {
 public:
  constexpr CommonCheck(const EdsBank& of_sheet, std::optional<std::uint8_t> eds_bank,
                        const EdsCheckOptions& rules, const Report& report)
      : bank_(of_sheet),
        part_(parse_common_part(of_sheet)),
        eds_bank_(eds_bank),
        options_(rules),
        report_(report) {}

  constexpr void run() const {
    if (check_filling(bank_, "EDS_VER", report_)) return;
    check_values(bank_, common_fields, options_, report_);
    order("TO_MIN", part_.to_min, "TO_MAX", part_.to_max);
    order("TOS_MIN", part_.tos_min, "TOS_MAX", part_.tos_max);
    order("TCLK_MIN", part_.tclk_min, "TCLK_MAX", part_.tclk_max);
    check_longest("TO_MAX", part_.to_max, biss_static_timeout_max);
    check_longest("TOS_MAX", part_.tos_max, biss_static_timeout_max);
    check_longest("TCLK_MAX", part_.tclk_max, biss_static_timeout_max);
    check_longest("TBUSY_MAX", part_.tbusy_max, biss_busy_max);
    if (part_.tma != 0 && rate_of(eds_time("TMA", part_.tma).time) > biss_clock_max) {
      report_(EdsProblem::out_of_range, "TMA", part_.tma);
    }
    if (part_.sl_num >= 1 && part_.sl_num <= 8 && part_.sl_off <= 7 &&
        part_.sl_off >= part_.sl_num) {
      report_(EdsProblem::slave_offset, "SL_OFF", part_.sl_off, "SL_NUM", part_.sl_num);
    }
    if (options_.unnamed_zero && (part_.bc_off & 0xE0U) != 0) {
      report_(EdsProblem::unnamed_not_zero, "BC_OFF", part_.bc_off);
    }
    if (part_.dc_num <= max_channels) {
      check_channels();
      check_banks();
    }
    check_sum(bank_, report_);
  }

 private:
  constexpr void order(std::string_view low_symbol, std::uint8_t low, std::string_view high_symbol,
                       std::uint8_t high) const {
    check_order(low_symbol, low, high_symbol, high, 0xFF, options_, report_);
  }

  // describe_device() uses no time that is longer than BiSS C allows.
  constexpr void check_longest(std::string_view symbol, std::uint8_t raw,
                               Picoseconds longest) const {
    if (options_.absent(raw, 0xFF) || eds_time(symbol, raw).time <= longest) return;
    report_(EdsProblem::out_of_range, symbol, raw);
  }

  constexpr void check_channels() const {
    bool count_wrong = false;
    for (std::size_t i = 0; i < max_channels; ++i) {
      const CommonChannel& channel = part_.channels[i];
      if (i < part_.dc_num) {
        const bool missing = is_empty(channel.bank) && is_empty(channel.dlen) &&
                             is_empty(channel.format) && is_empty(channel.cpoly);
        count_wrong = count_wrong || missing;
        if (!missing) check_used(i, channel);
      } else if (!is_empty(channel.bank) && !is_empty(channel.dlen)) {
        count_wrong = true;
      } else {
        check_unused(i, channel);
      }
    }
    if (count_wrong) {
      report_(EdsProblem::channel_count, "DC_NUM", part_.dc_num, {}, filled_channels());
    }
  }

  constexpr unsigned filled_channels() const {
    unsigned count = 0;
    for (const CommonChannel& channel : part_.channels) {
      if (!is_empty(channel.bank) || !is_empty(channel.dlen)) ++count;
    }
    return count;
  }

  constexpr void check_used(std::size_t i, const CommonChannel& channel) const {
    const auto& symbols = channel_symbols[i];
    if (channel.dlen == 0) report_(EdsProblem::out_of_range, symbols[1], channel.dlen);
    if (options_.unnamed_zero && (channel.format & ~known_channel_format_bits) != 0) {
      report_(EdsProblem::unnamed_not_zero, symbols[2], channel.format);
    }
    // 0 is checked in the profile's part: no CRC, or one too wide for this byte.
    if (channel.cpoly == 0) return;
    if (is_full_form_of_known(channel.cpoly)) {
      report_(EdsProblem::polynomial_full_form, symbols[3], channel.cpoly, {}, channel.cpoly >> 1U);
    } else if (stored_crc_bits(channel.cpoly) < min_crc_bits) {
      report_(EdsProblem::polynomial, symbols[3], channel.cpoly);
    }
  }

  constexpr void check_unused(std::size_t i, const CommonChannel& channel) const {
    const std::array bytes{channel.bank, channel.dlen, channel.format, channel.cpoly};
    for (std::size_t byte = 0; byte < bytes.size(); ++byte) {
      // A length above 64 bits is already reported.
      if (is_empty(bytes[byte]) || (byte == 1 && bytes[byte] > max_data_bits)) continue;
      report_(EdsProblem::channel_unused, channel_symbols[i][byte], bytes[byte], "DC_NUM",
              part_.dc_num);
    }
  }

  constexpr bool user_area_given() const {
    return !(part_.usr_sta == 0 && part_.usr_end == 0) &&
           !(part_.usr_sta == 0xFF && part_.usr_end == 0xFF);
  }
  constexpr bool in_user_area(unsigned bank) const {
    return user_area_given() && bank >= part_.usr_sta && bank <= part_.usr_end;
  }

  constexpr void check_banks() const {
    if (user_area_given() && part_.usr_sta > part_.usr_end) {
      report_(EdsProblem::min_above_max, "USR_STA", part_.usr_sta, "USR_END", part_.usr_end);
    }
    unsigned parts = 0;
    unsigned outside = 0;
    for (std::size_t i = 0; i < part_.dc_num; ++i) {
      const CommonChannel& channel = part_.channels[i];
      if (channel.bank == 0 && channel.dlen == 0) continue;  // counted under DC_NUM or DLEN_i
      ++parts;
      if (is_outside(channel.bank)) ++outside;
    }
    // Where every part lies outside, or there are fewer banks than parts, the length is wrong.
    const bool short_length = part_.eds_len != 0 && parts + 1 > part_.eds_len;
    const bool past_end = eds_bank_ && unsigned{*eds_bank_} + part_.eds_len > 256;
    if (short_length || past_end) {
      report_(EdsProblem::too_few_banks, "EDS_LEN", part_.eds_len, {}, parts + 1);
    }
    for (std::size_t i = 0; i < part_.dc_num; ++i) check_bank(i, !short_length);
    if (eds_bank_ && in_user_area(*eds_bank_)) {
      report_(EdsProblem::bank_in_user_area, "USR_STA", part_.usr_sta, {}, *eds_bank_);
    }
  }

  // Bank 0 holds no data sheet: EDS_BANK = 0 means none.
  constexpr bool is_outside(unsigned bank) const {
    if (bank == 0) return true;
    if (!eds_bank_ || part_.eds_len == 0) return false;
    return bank < *eds_bank_ || bank >= unsigned{*eds_bank_} + part_.eds_len;
  }

  constexpr void check_bank(std::size_t i, bool length_known) const {
    const unsigned bank = part_.channels[i].bank;
    const std::string_view symbol = channel_symbols[i][0];
    if (bank == 0 && part_.channels[i].dlen == 0) return;
    if (eds_bank_ && bank == *eds_bank_) {
      report_(EdsProblem::bank_is_common, symbol, bank);
      return;
    }
    for (std::size_t before = 0; before < i; ++before) {
      if (part_.channels[before].bank != bank) continue;
      report_(EdsProblem::bank_shared, symbol, bank, channel_symbols[before][0], bank);
      return;
    }
    if (in_user_area(bank)) {
      report_(EdsProblem::bank_in_user_area, symbol, bank, "USR_STA", part_.usr_sta);
    } else if (is_outside(bank) && (length_known || bank == 0)) {
      report_(EdsProblem::bank_outside, symbol, bank, "EDS_LEN", part_.eds_len);
    }
  }

  const EdsBank& bank_;
  CommonPart part_;
  std::optional<std::uint8_t> eds_bank_;
  const EdsCheckOptions& options_;
  const Report& report_;
};

}  // namespace eds_detail

/// Reports all findings of a common part. With its bank (register 0x41), the banks of the channels
/// are checked, too.
template <EdsSink Sink>
constexpr void check_common_part(const EdsBank& bank, Sink&& sink,
                                 std::optional<std::uint8_t> eds_bank = {},
                                 const EdsCheckOptions& options = {}) {
  const eds_detail::PartReport<std::remove_reference_t<Sink>> report{sink};
  eds_detail::CommonCheck(bank, eds_bank, options, report).run();
}

// ---- Checks of a BP3 part, alone and against what else is known about its channel

/// What is outside the part and should agree with it.
struct Bp3Context {
  std::uint8_t channel = 0;
  /// Registers 0x42 (upper byte) and 0x43 of the slave.
  std::optional<std::uint16_t> identifier{};
  /// DLEN_i of the common part.
  std::optional<std::uint8_t> dlen{};
  /// Whether the device sends a safety position word (BP3S), too; empty: not known.
  std::optional<bool> safety_encoder{};
};

namespace eds_detail {

// BP3 Rev A3, table 5: C = 1 is mandatory within a safety encoder, and C = 0 is expected within a
// standard encoder.
template <class Report>
constexpr void check_crc_bit(ProfileIdentifier id, std::optional<bool> safety_encoder,
                             const Report& report) {
  if (!safety_encoder || id.crc_is_data() == *safety_encoder) return;
  report(EdsProblem::crc_bit, "BP_ID", id.raw);
}

template <class Report>
class Bp3Check {
 public:
  constexpr Bp3Check(const EdsBank& of_sheet, const Bp3Context& context,
                     const EdsCheckOptions& rules, const Report& report)
      : bank_(of_sheet),
        part_(parse_bp3_part(of_sheet)),
        id_{part_.bp_id},
        context_(context),
        options_(rules),
        report_(report) {}

  constexpr void run() const {
    if (check_filling(bank_, "BP_VER", report_)) return;
    if (part_.bp_ver != 1) report_(EdsProblem::version, "BP_VER", part_.bp_ver, {}, 1);
    // The version row has the range 1…1 and would be reported twice.
    check_values(bank_, std::span(bp3_fields).subspan(1), options_, report_);
    check_feedback();
    check_polynomial();
    check_orders();
    if (part_.mt_len != 0 && part_.mt_fmt == 1) {
      report_(EdsProblem::alignment, "MT_FMT", part_.mt_fmt, "MT_LEN", 0);
    }
    const bool length_known = check_identifier();
    if (lengths_in_range()) check_counts(!length_known || check_lengths());
    check_sum(bank_, report_);
  }

 private:
  constexpr bool lengths_in_range() const {
    return part_.mt_len <= bp3_max_length_bits && part_.co_len <= bp3_max_length_bits &&
           part_.fi_len <= bp3_max_length_bits;
  }

  // True when DL can be compared with the lengths.
  constexpr bool check_identifier() const {
    const std::uint32_t id = part_.bp_id;
    const auto bad = [&](EdsProblem problem, std::uint32_t expected = 0) {
      report_(problem, "BP_ID", id, {}, expected);
      return false;
    };
    if (context_.identifier && *context_.identifier != id) {
      const bool swapped = bytes_swapped(id, 2) == *context_.identifier;
      return bad(swapped ? EdsProblem::little_endian : EdsProblem::identifier,
                 *context_.identifier);
    }
    if (id_.profile() != Profile::bp3) {
      if (is_swapped_bp3(part_.bp_id)) return bad(EdsProblem::little_endian, bytes_swapped(id, 2));
      return bad(EdsProblem::profile);
    }
    if (id_.version() != 1) return bad(EdsProblem::version);
    if (id_.bit7()) return bad(EdsProblem::reserved_bit);
    const unsigned most = id_.crc_is_data() && options_.length_counts_crc
                              ? bp3_max_length_crc_is_data
                              : bp3_max_data_bits;
    if (id_.data_length() < bp3_min_data_bits || id_.data_length() > most) {
      return bad(EdsProblem::data_length);
    }
    check_crc_bit(id_, context_.safety_encoder, report_);
    return true;
  }

  // Without nE (1) in either bit, nothing says which positions are good.
  constexpr void check_feedback() const {
    if (part_.fb1 != 1 && part_.fb2 != 1) {
      report_(EdsProblem::out_of_range, "FB1", part_.fb1, "FB2", part_.fb2);
    } else if (part_.fb1 != 1) {
      report_(EdsProblem::out_of_range, "FB1", part_.fb1);
    }
    if (part_.fb2 != 2) report_(EdsProblem::out_of_range, "FB2", part_.fb2);
  }

  // DL computed from the lengths.
  constexpr unsigned data_length_of_parts() const {
    const bool counted = id_.crc_is_data() && options_.length_counts_crc;
    return part_.position_bits() + 2 + (counted ? crc6.width_bits : 0U);
  }

  // The same sum decides which reading a decoder takes.
  constexpr bool fits_other_reading() const {
    const unsigned data = part_.position_bits() + 2;
    const unsigned other = options_.length_counts_crc ? data : data + crc6.width_bits;
    return id_.crc_is_data() && other == id_.data_length();
  }

  constexpr bool check_lengths() const {
    const unsigned sum = data_length_of_parts();
    if (sum == id_.data_length()) return true;
    if (fits_other_reading()) {
      report_(EdsProblem::length_reading, "BP_ID", part_.bp_id, "FI_LEN",
              (part_.bp_id & 0xFF80U) | sum);
      return false;
    }
    const std::string_view suspect = suspect_length(part_);
    const bool registers = context_.identifier.has_value();  // and they agree, or we were not here
    const bool outvoted = context_.dlen == sum;
    if (!registers && (outvoted || suspect.empty())) {
      report_(EdsProblem::lengths, "BP_ID", part_.bp_id, "FI_LEN", (part_.bp_id & 0xFF80U) | sum);
      return false;
    }
    const std::string_view symbol = suspect.empty() ? "FI_LEN" : suspect;
    const std::uint32_t value = symbol == "MT_LEN"   ? part_.mt_len
                                : symbol == "CO_LEN" ? part_.co_len
                                                     : part_.fi_len;
    const std::uint32_t expected = value + id_.data_length() - sum;
    report_(EdsProblem::lengths, symbol, value, "BP_ID", expected <= 57 ? expected : 0);
    return false;
  }

  // Only where the lengths are right: consequences of a wrong length are not reported.
  constexpr void check_counts(bool lengths_hold) const {
    if (!lengths_hold || part_.en_typ > 1) return;
    if (counts_of_type_fit(part_)) return check_alignment();
    if (type_is_wrong()) {
      report_(EdsProblem::encoder_type, "EN_TYP", part_.en_typ, "MT_CNT", 1U - part_.en_typ);
      return;
    }
    if (part_.linear()) {
      check_pair("MT_CNT", part_.mt_cnt, part_.position_bits());
      return;
    }
    if (!turns_fit(part_)) {
      const std::uint32_t swapped = bytes_swapped(part_.mt_cnt, 4);
      const bool order = looks_swapped(part_.mt_cnt, 1, part_.mt_len);
      report_(order ? EdsProblem::little_endian : EdsProblem::count_above_length, "MT_CNT",
              part_.mt_cnt, "MT_LEN", order ? swapped : part_.mt_len);
    }
    if (!periods_fit(part_)) {
      check_pair("SIP_CNT", part_.sip_cnt, singleturn_bits(part_));
    }
  }

  // A right-aligned singleturn value that fills its field is left-aligned, too.
  constexpr void check_alignment() const {
    const Bp3Zeros zeros = part_.linear() ? scale_zeros(part_) : singleturn_zeros(part_);
    const bool leading = zeros.leading != 0 && !(part_.linear() && part_.mt_len != 0);
    if (!leading && !zeros.inside) return;
    const bool fine = part_.fi_len != 0 && part_.fi_fmt != 1;
    const std::string_view symbol = fine ? "FI_FMT" : "CO_FMT";
    const std::string_view upper = part_.linear() && part_.mt_len != 0 ? "MT_FMT" : "CO_FMT";
    report_(EdsProblem::alignment, symbol, fine ? part_.fi_fmt : part_.co_fmt,
            zeros.inside ? upper
            : fine       ? "SIP_RES"
                         : "SIP_CNT",
            1);
  }

  // With the other type everything fits, including the checksum, and no count with one byte changed
  // fits as well.
  constexpr bool type_is_wrong() const {
    EdsBank other = bank_;
    other[0x08] ^= 1U;
    if (other[eds_checksum_address] != eds_checksum(other)) return false;
    if (!counts_of_type_fit(parse_bp3_part(other))) return false;
    for (std::size_t at = 0x10; at < 0x1C; ++at) {
      other = bank_;
      other[at] = static_cast<std::uint8_t>(other[at] + (part_.linear() ? -1 : 1));
      if (counts_of_type_fit(parse_bp3_part(other))) return false;
    }
    return true;
  }

  // Whether a count in the other byte order, times `other`, is what the length was chosen for. A
  // count that fits alone may be right, unless other fields are in the wrong order.
  constexpr bool looks_swapped(std::uint32_t given, std::uint64_t other, unsigned bits) const {
    const bool all_swapped =
        bytes_swapped(part_.cpoly, 4) == crc6.polynomial >> 1U || is_swapped_bp3(part_.bp_id);
    return bits != 0 && just_fits(count_or_one(bytes_swapped(given, 4)) * other, bits) &&
           (all_swapped || !counts_fit(count_or_one(given), bits));
  }

  // A count times SIP_RES is too large for `bits`: finds out whether the byte order is wrong, or
  // which value is.
  constexpr void check_pair(std::string_view symbol, std::uint32_t count, unsigned bits) const {
    const bool scale = symbol == "MT_CNT";
    const std::uint32_t res = part_.sip_res;
    const std::uint32_t count_swapped = bytes_swapped(count, 4);
    const std::uint32_t res_swapped = bytes_swapped(res, 4);
    const bool res_order = looks_swapped(res, count_or_one(count), bits);
    const bool count_order = looks_swapped(count, count_or_one(res), bits);
    const bool both = !res_order && !count_order &&
                      looks_swapped(res, count_or_one(count_swapped), bits) &&
                      looks_swapped(count, count_or_one(res_swapped), bits);
    if (count_order || both) {
      report_(EdsProblem::little_endian, symbol, count, "SIP_RES", count_swapped);
    }
    if ((res_order && !count_order) || both) {
      report_(EdsProblem::little_endian, "SIP_RES", part_.sip_res, symbol, res_swapped);
    }
    if (res_order || count_order || both) return;
    const bool count_alone = !counts_fit(count_or_one(count), bits) ||
                             (!scale && part_.co_len != 0 && !counts_fit(count, part_.co_len));
    // One period fills the length.
    const bool no_room = !scale && just_fits(count_or_one(part_.sip_res), bits);
    if (count_alone || no_room) {
      report_(EdsProblem::count_above_length, symbol, count, "SIP_RES", part_.sip_res);
    } else {
      report_(EdsProblem::count_above_length, "SIP_RES", part_.sip_res, symbol, count);
    }
  }

  constexpr void check_polynomial() const {
    const std::uint32_t stored = part_.cpoly;
    constexpr std::uint32_t due = crc6.polynomial >> 1U;
    if (stored == due) return;
    // BP3 states its polynomial with the condition C = 0.
    if (stored == 0 && id_.profile() == Profile::bp3 && id_.crc_is_data()) return;
    if (bytes_swapped(stored, 4) == due) {
      report_(EdsProblem::little_endian, "CPOLY", stored, {}, due);
    } else if (is_full_form_of_known(stored)) {
      report_(EdsProblem::polynomial_full_form, "CPOLY", stored, {}, stored >> 1U);
    } else {
      report_(EdsProblem::polynomial, "CPOLY", stored, {}, due);
    }
  }

  // No encoder works above this; with its bytes swapped, the value may be an ordinary temperature.
  static constexpr std::uint32_t plausible_kelvin_max = 1000;

  constexpr bool kelvin_swapped(std::string_view symbol, std::uint32_t value) const {
    const std::uint32_t swapped = bytes_swapped(value, 2);
    if (options_.absent(value, ones16) || value <= plausible_kelvin_max || swapped == 0 ||
        swapped > plausible_kelvin_max) {
      return false;
    }
    report_(EdsProblem::little_endian, symbol, value, {}, swapped);
    return true;
  }

  constexpr void check_orders() const {
    const bool low = kelvin_swapped("TMP_MIN", part_.tmp_min);
    const bool high = kelvin_swapped("TMP_MAX", part_.tmp_max);
    if (!low && !high) {
      check_order("TMP_MIN", part_.tmp_min, "TMP_MAX", part_.tmp_max, ones16, options_, report_);
    }
    check_order("VLT_MIN", part_.vlt_min, "VLT_MAX", part_.vlt_max, ones16, options_, report_);
  }

  const EdsBank& bank_;
  Bp3Part part_;
  ProfileIdentifier id_;
  const Bp3Context& context_;
  const EdsCheckOptions& options_;
  const Report& report_;
};

}  // namespace eds_detail

/// Reports all findings of a BP3 part. A field is reported once; consequences of another finding
/// are not reported.
template <EdsSink Sink>
constexpr void check_bp3_part(const EdsBank& bank, Sink&& sink, const Bp3Context& context = {},
                              const EdsCheckOptions& options = {}) {
  const eds_detail::PartReport<std::remove_reference_t<Sink>> report{sink, EdsPart::bp3,
                                                                     context.channel};
  eds_detail::Bp3Check(bank, context, options, report).run();
}

namespace eds_detail {

constexpr bool is_useless(const EdsBank& bank) {
  return is_filled_with(bank, 0x00) || is_filled_with(bank, 0xFF);
}

// Compares what channel i of the common part says with a BP3 part, or with the registers where that
// was not read. Differences of `length` and `polynomial` are reported only when the other side is
// consistent.
template <class Report>
constexpr void check_channel_against(const CommonChannel& channel, std::size_t i,
                                     ProfileIdentifier id, const Bp3Part* part,
                                     const EdsCheckOptions& options, const Report& report) {
  if (id.profile() != Profile::bp3 || !profile_channel(id.raw).ok()) return;
  const auto& symbols = channel_symbols[i];
  if (channel.actuator()) report(EdsProblem::actuator, symbols[2], channel.format, "BP_ID", id.raw);
  const bool counted = id.crc_is_data() && options.length_counts_crc;
  const unsigned crc_bits = counted ? crc6.width_bits : 0;
  const bool lengths_hold =
      part == nullptr || part->position_bits() + 2 + crc_bits == id.data_length();
  // With C = 1, the sources do not say whether DLEN_i counts the CRC, as DL does.
  const bool same = channel.dlen == id.data_length() ||
                    (counted && unsigned{channel.dlen} + crc_bits == id.data_length());
  if (!same && lengths_hold && channel.dlen != 0 && channel.dlen <= max_data_bits) {
    report(EdsProblem::data_length_differs, symbols[1], channel.dlen, "BP_ID", id.data_length());
  }
  constexpr std::uint32_t due = crc6.polynomial >> 1U;
  if (channel.cpoly == due || is_full_form_of_known(channel.cpoly)) return;
  if (channel.cpoly != 0 && stored_crc_bits(channel.cpoly) < min_crc_bits) return;
  if (channel.cpoly == 0 && id.crc_is_data()) return;
  if (part != nullptr && part->cpoly != due) return;
  report(EdsProblem::polynomial_differs, symbols[3], channel.cpoly, "CPOLY", due);
}

// The identifier of a channel: that of the registers, else that of its part; 0: not read.
constexpr ProfileIdentifier identifier_of(const EdsImage& image, std::size_t channel) {
  if (image.identifiers[channel].value_or(0) != 0) return {*image.identifiers[channel]};
  if (image.profiles[channel] == nullptr) return {};
  return {parse_bp3_part(*image.profiles[channel]).bp_id};
}

// Whether this is a safety encoder. A standard encoder is known as one when every slave of the
// device has a channel with a known profile, and none is BP3S.
constexpr std::optional<bool> is_safety_encoder(const EdsImage& image) {
  bool all_known = image.common != nullptr;
  for (std::size_t i = 0; i < max_channels; ++i) {
    const Profile profile = identifier_of(image, i).profile();
    if (profile == Profile::bp3s) return true;
    const bool known =
        profile == Profile::bp0 || profile == Profile::bp1 || profile == Profile::bp3;
    all_known = all_known && (i >= channel_count(image) || known);
  }
  if (!all_known || channel_count(image) < parse_common_part(*image.common).sl_num) {
    return std::nullopt;
  }
  return false;
}

template <class Sink>
constexpr void check_raw_part(const EdsBank& bank, std::size_t channel, ProfileIdentifier id,
                              Sink& sink, const EdsCheckOptions& options) {
  const PartReport<Sink> report{sink, EdsPart::raw, static_cast<std::uint8_t>(channel)};
  if (check_filling(bank, "BP_VER", report)) return;
  if (id.profile() == Profile::bp3s) check_crc_bit(id, true, report);
  if (options.raw_checksum) check_sum(bank, report);
}

template <class Sink>
constexpr void check_profile(const EdsImage& image, std::size_t i, const CommonPart* common,
                             std::optional<bool> safety, Sink& sink,
                             const EdsCheckOptions& options) {
  const EdsBank* bank = image.profiles[i];
  const PartReport<Sink> report{sink};
  const CommonChannel* channel =
      common != nullptr && i < common->dc_num && i < max_channels ? &common->channels[i] : nullptr;
  if (bank == nullptr) {
    if (channel != nullptr && image.identifiers[i]) {
      check_channel_against(*channel, i, {*image.identifiers[i]}, nullptr, options, report);
    }
    return;
  }
  if (profile_part(image, i) == EdsPart::raw) {
    check_raw_part(*bank, i, identifier_of(image, i), sink, options);
    return;
  }
  Bp3Context context{static_cast<std::uint8_t>(i), image.identifiers[i], std::nullopt, safety};
  if (channel != nullptr) context.dlen = channel->dlen;
  check_bp3_part(*bank, sink, context, options);
  if (channel == nullptr || is_useless(*bank)) return;
  const Bp3Part part = parse_bp3_part(*bank);
  const ProfileIdentifier id{image.identifiers[i].value_or(part.bp_id)};
  check_channel_against(*channel, i, id, &part, options, report);
}

}  // namespace eds_detail

/// Reports all findings of a data sheet: first those of the common part, then those of the
/// channels. What was not read is not checked.
template <EdsSink Sink>
constexpr void check_eds(const EdsImage& image, Sink&& sink, const EdsCheckOptions& options = {}) {
  CommonPart common;
  const bool common_read = image.common != nullptr && !eds_detail::is_useless(*image.common);
  if (image.common != nullptr) {
    check_common_part(*image.common, sink, image.eds_bank, options);
    common = parse_common_part(*image.common);
  }
  const std::optional<bool> safety = eds_detail::is_safety_encoder(image);
  for (std::size_t i = 0; i < max_channels; ++i) {
    eds_detail::check_profile(image, i, common_read ? &common : nullptr, safety, sink, options);
  }
}

}  // namespace biss
