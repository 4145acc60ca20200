// The part of the standard encoder profile in a data sheet: "Standard Encoder Profile BP3", Rev A3,
// table 8.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <string_view>

#include "biss/base/big_endian.hpp"
#include "biss/eds/bank.hpp"
#include "biss/eds/field.hpp"

namespace biss {

/// The part as raw numbers, in the units of bp3_fields; the members have the names of its symbols,
/// and the bytes of the struct are the bytes of the bank. Reserved bytes and a wrong checksum are
/// kept.
struct Bp3Part {
  std::uint8_t bp_ver = 1;
  std::uint8_t bp_len = 1;
  /// In the form of the registers 0x42 (upper byte) and 0x43.
  BigEndian<std::uint16_t> bp_id = 0;
  std::uint8_t fb1 = 1;
  std::uint8_t fb2 = 2;
  std::uint8_t pon_pdl = 0;
  std::uint8_t reserved_07 = 0;
  std::uint8_t en_typ = 0;
  std::uint8_t pos_num = 1;
  std::uint8_t mt_len = 0;
  std::uint8_t mt_fmt = 0;
  std::uint8_t co_len = 0;
  std::uint8_t co_fmt = 0;
  std::uint8_t fi_len = 0;
  std::uint8_t fi_fmt = 0;
  BigEndian<std::uint32_t> mt_cnt = 0;
  BigEndian<std::uint32_t> sip_cnt = 0;
  BigEndian<std::uint32_t> sip_res = 0;
  BigEndian<std::uint32_t> cpoly = 0x21;
  BigEndian<std::uint32_t> cstart = 0;
  BigEndian<std::uint16_t> abs_acu = 0;
  BigEndian<std::uint16_t> rel_acu = 0;
  BigEndian<std::uint16_t> spd_acu = 0;
  BigEndian<std::uint16_t> hyst = 0;
  BigEndian<std::uint16_t> spd_max = 0;
  BigEndian<std::uint16_t> acc_max = 0;
  BigEndian<std::uint16_t> tmp_min = 0;
  BigEndian<std::uint16_t> tmp_max = 0;
  BigEndian<std::uint16_t> vlt_min = 0;
  BigEndian<std::uint16_t> vlt_max = 0;
  BigEndian<std::uint16_t> cur_max = 0;
  std::array<std::uint8_t, 5> reserved_3a{};
  std::uint8_t chksum = 0;

  constexpr bool operator==(const Bp3Part&) const = default;

  constexpr bool linear() const { return en_typ == 1; }
  /// Turns, coarse and fine: the position on the line.
  constexpr unsigned position_bits() const { return unsigned{mt_len} + co_len + fi_len; }
};

/// Longest MT, CO or FI (BP3 Rev A3, table 8).
inline constexpr std::uint8_t bp3_max_length_bits = 57;

namespace eds_detail {

inline constexpr std::uint32_t ones16 = 0xFFFF;
inline constexpr std::uint32_t ones32 = 0xFFFF'FFFF;

inline constexpr auto bp3_rows() {
  using enum EdsKind;
  using enum EdsUnit;
  constexpr std::uint8_t len = bp3_max_length_bits;
  return std::to_array<EdsField>({
      {"BP_VER", "version of the profile", 0x00, 1, number, none, 1, 1},
      {"BP_LEN", "length of this part", 0x01, 1, number, banks, 1, 1},
      // Table 8 prints 0x62; the identifier scheme also allows C = 1: 0x63.
      {"BP_ID", "profile identifier, as registers 0x42 and 0x43", 0x02, 2, identifier, none, 0x6202,
       0x633F},
      {"FB1", "first feedback bit", 0x04, 1, feedback, none, 1, 1},
      {"FB2", "second feedback bit", 0x05, 1, feedback, none, 2, 2},
      {"PON_PDL", "from power-on to position data, at most", 0x06, 1, number, milliseconds, 1, 254},
      {"RES_07", "reserved", 0x07, 1, reserved, none, 0, 0},
      {"EN_TYP", "encoder type", 0x08, 1, encoder_type, none, 0, 1},
      {"POS_NUM", "which position value", 0x09, 1, position_value, none, 1, 2},
      {"MT_LEN", "length of the multiturn data", 0x0A, 1, number, bits, 0, len},
      {"MT_FMT", "alignment of the multiturn data", 0x0B, 1, alignment, none, 0, 1},
      {"CO_LEN", "length of the coarse data", 0x0C, 1, number, bits, 0, len},
      {"CO_FMT", "alignment of the coarse data", 0x0D, 1, alignment, none, 0, 1},
      {"FI_LEN", "length of the fine data", 0x0E, 1, number, bits, 0, len},
      {"FI_FMT", "alignment of the fine data", 0x0F, 1, alignment, none, 0, 1},
      {"MT_CNT", "revolutions or periods that can be distinguished", 0x10, 4, number, none, 1,
       ones32 - 1},
      {"SIP_CNT", "signal periods a revolution, or length of one", 0x14, 4, number,
       per_revolution_or_nanometre, 1, ones32 - 1},
      {"SIP_RES", "counts a signal period", 0x18, 4, number, lsb, 1, ones32 - 1},
      {"CPOLY", "CRC polynomial without its lowest bit", 0x1C, 4, polynomial, none, 0x21, 0x21},
      {"CSTART", "CRC start value", 0x20, 4, number, none, 0, 0},
      {"ABS_ACU", "absolute accuracy", 0x24, 2, number, half_lsb_or_micrometre, 1, ones16 - 1},
      {"REL_ACU", "repeatability", 0x26, 2, number, half_lsb, 1, ones16 - 1},
      {"SPD_ACU", "accuracy that depends on speed", 0x28, 2, number, half_lsb, 1, ones16 - 1},
      {"HYST", "hysteresis", 0x2A, 2, number, half_lsb, 1, ones16 - 1},
      {"SPD_MAX", "highest speed", 0x2C, 2, number, per_minute_or_metre_per_minute, 1, ones16 - 1},
      {"ACC_MAX", "highest acceleration", 0x2E, 2, number, per_minute2_or_metre_per_minute2, 1,
       ones16 - 1},
      {"TMP_MIN", "lowest operating temperature", 0x30, 2, number, kelvin, 1, ones16 - 1},
      {"TMP_MAX", "highest operating temperature", 0x32, 2, number, kelvin, 1, ones16 - 1},
      {"VLT_MIN", "lowest operating voltage", 0x34, 2, number, millivolt, 1, ones16 - 1},
      {"VLT_MAX", "highest operating voltage", 0x36, 2, number, millivolt, 1, ones16 - 1},
      {"CUR_MAX", "highest current", 0x38, 2, number, milliampere, 1, ones16 - 1},
      {"RES_3A", "reserved", 0x3A, 1, reserved, none, 0, 0},
      {"RES_3B", "reserved", 0x3B, 1, reserved, none, 0, 0},
      {"RES_3C", "reserved", 0x3C, 1, reserved, none, 0, 0},
      {"RES_3D", "reserved", 0x3D, 1, reserved, none, 0, 0},
      {"RES_3E", "reserved", 0x3E, 1, reserved, none, 0, 0},
      {"CHKSUM", "sum of the bytes before it", 0x3F, 1, checksum, none, 0, 255},
  });
}

}  // namespace eds_detail

/// Every byte of the part. If rows are shifted in the extracted document, the addresses follow
/// from the byte counts.
inline constexpr auto bp3_fields = eds_detail::bp3_rows();
static_assert(eds_detail::covers_a_bank(bp3_fields));

/// The part as a bank holds it, right or wrong.
constexpr Bp3Part parse_bp3_part(const EdsBank& bank) { return std::bit_cast<Bp3Part>(bank); }
/// The bank of a part, byte for byte; sealed() sets the checksum.
constexpr EdsBank build_bank(const Bp3Part& part) { return std::bit_cast<EdsBank>(part); }

}  // namespace biss

namespace biss::eds_detail {

// ---- Whether the lengths of a BP3 position agree with its counts
//
// Rotary: MT counts MT_CNT revolutions; coarse and fine count the SIP_CNT x SIP_RES counts of one.
// Both may have spare bits: leading zeros of MT, trailing zeros of the singleturn value. Linear:
// SIP_CNT is a length in nm and multiplies nothing; the MT_CNT distinguishable periods of SIP_RES
// counts each must fit into the whole position, however it is divided. A count that is not given
// (0, all ones) counts as one.

// Whether this number of bits can hold this number of counts; more than 63 bits always can.
constexpr bool counts_fit(std::uint64_t counts, unsigned bits) {
  return bits > 63 || counts <= std::uint64_t{1} << bits;
}

// Whether this is the shortest length for the counts, which makers usually choose.
constexpr bool just_fits(std::uint64_t counts, unsigned bits) {
  return counts_fit(counts, bits) && (bits == 0 || !counts_fit(counts, bits - 1));
}

constexpr bool count_given(std::uint32_t count) { return count != 0 && count != ones32; }
constexpr std::uint64_t count_or_one(std::uint32_t count) { return count_given(count) ? count : 1; }

constexpr unsigned singleturn_bits(const Bp3Part& part) {
  return unsigned{part.co_len} + part.fi_len;
}
constexpr std::uint64_t counts_a_turn(const Bp3Part& part) {
  return count_or_one(part.sip_cnt) * count_or_one(part.sip_res);
}

constexpr bool turns_fit(const Bp3Part& part) {
  return counts_fit(count_or_one(part.mt_cnt), part.mt_len);
}
constexpr bool periods_fit(const Bp3Part& part) {
  return counts_fit(counts_a_turn(part), singleturn_bits(part));
}
constexpr bool scale_fits(const Bp3Part& part) {
  return counts_fit(count_or_one(part.mt_cnt) * count_or_one(part.sip_res), part.position_bits());
}
constexpr bool counts_of_type_fit(const Bp3Part& part) {
  return part.linear() ? scale_fits(part) : turns_fit(part) && periods_fit(part);
}

// The one length of a rotary encoder that does not match its count; empty when the counts give no
// answer.
constexpr std::string_view suspect_length(const Bp3Part& part) {
  if (part.linear()) return {};
  if (count_given(part.mt_cnt) && !just_fits(part.mt_cnt, part.mt_len)) return "MT_LEN";
  if (!count_given(part.sip_cnt) || !count_given(part.sip_res)) return {};
  if (just_fits(counts_a_turn(part), singleturn_bits(part))) return {};
  return part.co_len != 0 && !just_fits(part.sip_cnt, part.co_len) ? "CO_LEN" : "FI_LEN";
}

}  // namespace biss::eds_detail

namespace biss {

// ---- Zeros in a BP3 position whose fields are longer than their counts need
//
// Table F: right-aligned values have leading zeros, left-aligned ones trailing zeros. Coarse and
// fine are one value, the singleturn value; on a scale, turns, coarse and fine are one value.

/// The zeros of one value. All 0 if a count is not given, is 1, or does not fit.
struct Bp3Zeros {
  unsigned leading = 0;
  unsigned trailing = 0;
  /// The upper field is left-aligned and the lower one right-aligned: the zeros are between them,
  /// which no frame format expresses.
  bool inside = false;
};

namespace eds_detail {

struct Bp3Run {
  unsigned bits = 0;
  bool left = false;
  std::uint32_t count = 1;
};

constexpr unsigned bits_for(std::uint64_t counts) {
  return static_cast<unsigned>(std::bit_width(counts - 1));
}

// The zeros of one value in one field or two.
constexpr Bp3Zeros zeros_of(const Bp3Run& upper, const Bp3Run& lower) {
  if (!count_given(upper.count) || !count_given(lower.count)) return {};
  const unsigned bits = upper.bits + lower.bits;
  const unsigned upper_used = bits_for(upper.count);
  const unsigned lower_used = bits_for(lower.count);
  const bool apart =
      upper.bits != 0 && lower.bits != 0 && upper_used <= upper.bits && lower_used <= lower.bits;
  const unsigned used =
      apart ? upper_used + lower_used : bits_for(std::uint64_t{upper.count} * lower.count);
  if (used == 0 || used >= bits) return {};
  const bool upper_left = upper.bits != 0 ? upper.left : lower.left;
  const bool lower_left = lower.bits != 0 ? lower.left : upper.left;
  if (upper_left && !lower_left) return {.inside = true};
  if (!lower_left) return {.leading = bits - used};
  if (upper_left || !apart) return {.trailing = bits - used};
  return {.leading = upper.bits - upper_used, .trailing = lower.bits - lower_used};
}

}  // namespace eds_detail

/// The zeros of MT.
constexpr Bp3Zeros turns_zeros(const Bp3Part& part) {
  return eds_detail::zeros_of({part.mt_len, part.mt_fmt == 1, part.mt_cnt}, {});
}
/// The zeros of CO and FI of a rotary encoder.
constexpr Bp3Zeros singleturn_zeros(const Bp3Part& part) {
  return eds_detail::zeros_of({part.co_len, part.co_fmt == 1, part.sip_cnt},
                              {part.fi_len, part.fi_fmt == 1, part.sip_res});
}
/// The zeros of the whole position of a scale: MT_CNT periods of SIP_RES counts.
constexpr Bp3Zeros scale_zeros(const Bp3Part& part) {
  const std::uint8_t upper_fmt = part.mt_len != 0 ? part.mt_fmt : part.co_fmt;
  return eds_detail::zeros_of({unsigned{part.mt_len} + part.co_len, upper_fmt == 1, part.mt_cnt},
                              {part.fi_len, part.fi_fmt == 1, part.sip_res});
}

}  // namespace biss
