// The common part of a data sheet: the banks of all parts, and the timing of the device.
//
// The document was not available. Names and addresses are from NXP's driver (fsl_biss 1.0.2), and
// the first four also from Balluff. If no source gives a range, it is the full range of the bytes.
// Most units of time are hypotheses. The checksum is assumed to be the one of BP3.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "biss/base/big_endian.hpp"
#include "biss/base/units.hpp"
#include "biss/eds/bank.hpp"
#include "biss/eds/field.hpp"
#include "biss/frame/format.hpp"

namespace biss {

// ---- The value of one step of a time. The document was not available: all but TMA's are
// hypotheses, kept in one table.

struct EdsScale {
  std::string_view symbol{};
  /// One step.
  Picoseconds step{};
  /// No source was available that confirms it.
  bool hypothesis = true;
};

/// TMA: a comment in NXP's driver (100 is 10 MHz); in these units, a byte cannot describe a device
/// slower than 3.9 MHz. BUSY_S is in clocks (NXP, D2) and therefore not listed.
inline constexpr std::array<EdsScale, 10> eds_scales{{
    {"TMA", nanoseconds(1), false},
    {"TO_MIN", nanoseconds(250), true},
    {"TO_MAX", nanoseconds(250), true},
    {"TOS_MIN", nanoseconds(25), true},
    {"TOS_MAX", nanoseconds(25), true},
    {"TCLK_MIN", nanoseconds(1), true},
    {"TCLK_MAX", nanoseconds(1), true},
    {"TCYC", nanoseconds(250), true},
    {"TBUSY_MAX", nanoseconds(250), true},
    {"PON_DLY", milliseconds(1), true},
}};

/// The scale of a field of the common part; null if it has none.
constexpr const EdsScale* find_scale(std::string_view symbol) {
  for (const EdsScale& scale : eds_scales) {
    if (scale.symbol == symbol) return &scale;
  }
  return nullptr;
}

/// A time of the common part by the table above. \pre find_scale(symbol) is not null
constexpr Picoseconds eds_time(std::string_view symbol, std::uint32_t raw) {
  return find_scale(symbol)->step * std::int64_t{raw};
}

/// The description of one data channel in the common part.
struct CommonChannel {
  /// Absolute number of the bank that holds the profile's part (NXP's interpretation).
  std::uint8_t bank = 0;
  /// Data bits, flags included, CRC excluded.
  std::uint8_t dlen = 0;
  /// Bits 2 and 4…7 are not known.
  std::uint8_t format = 0;
  /// Bits 8…1 of the CRC polynomial (inferred); a 16-bit polynomial does not fit.
  std::uint8_t cpoly = 0;

  constexpr bool operator==(const CommonChannel&) const = default;
  constexpr bool actuator() const { return (format & 0x01U) != 0; }
  constexpr bool left_aligned() const { return (format & 0x02U) != 0; }
  constexpr bool leading_stop_bit() const { return (format & 0x08U) != 0; }
};

/// The bits of FORMAT_i with a known meaning.
inline constexpr std::uint8_t known_channel_format_bits = 0x0B;

/// The part as raw numbers; the members have the names of the symbols of common_fields, and the
/// bytes of the struct are the bytes of the bank. Unnamed bytes and a wrong checksum are kept.
struct CommonPart {
  std::uint8_t eds_ver = 1;
  std::uint8_t eds_len = 0;
  std::uint8_t usr_sta = 0;
  std::uint8_t usr_end = 0;
  std::uint8_t tma = 0;
  std::uint8_t to_min = 0;
  std::uint8_t to_max = 0;
  std::uint8_t tos_min = 0;
  std::uint8_t tos_max = 0;
  std::uint8_t tclk_min = 0;
  std::uint8_t tclk_max = 0;
  std::uint8_t tcyc = 0;
  std::uint8_t tbusy_max = 0;
  std::uint8_t busy_s = 0;
  BigEndian<std::uint16_t> pon_dly = 0;
  std::uint8_t dc_num = 0;
  std::uint8_t sl_num = 0;
  std::uint8_t sl_off = 0;
  std::uint8_t unnamed_13 = 0;
  std::array<CommonChannel, max_channels> channels{};
  std::uint8_t bc_off = 0;
  std::array<std::uint8_t, 10> reserved_35{};
  std::uint8_t chksum = 0;

  constexpr bool operator==(const CommonPart&) const = default;

  constexpr bool has_bus_coupler() const { return (bc_off & 0x10U) != 0; }
  constexpr unsigned bus_coupler_slave() const { return bc_off & 0x0FU; }
  /// The first ID of the device, computed from the ID of the slave that holds the EDS. Undefined
  /// when SL_OFF is wrong, which check.hpp reports.
  constexpr unsigned first_slave(unsigned this_slave) const { return this_slave - sl_off; }
};

/// The address of a channel's four fields: BANK_i, then DLEN_i, FORMAT_i, CPOLY_i.
constexpr std::uint8_t common_channel_address(std::size_t channel) {
  return static_cast<std::uint8_t>(0x14 + 4 * channel);
}

namespace eds_detail {

inline constexpr std::array<std::array<std::string_view, 4>, max_channels> channel_symbols{{
    {"BANK_0", "DLEN_0", "FORMAT_0", "CPOLY_0"},
    {"BANK_1", "DLEN_1", "FORMAT_1", "CPOLY_1"},
    {"BANK_2", "DLEN_2", "FORMAT_2", "CPOLY_2"},
    {"BANK_3", "DLEN_3", "FORMAT_3", "CPOLY_3"},
    {"BANK_4", "DLEN_4", "FORMAT_4", "CPOLY_4"},
    {"BANK_5", "DLEN_5", "FORMAT_5", "CPOLY_5"},
    {"BANK_6", "DLEN_6", "FORMAT_6", "CPOLY_6"},
    {"BANK_7", "DLEN_7", "FORMAT_7", "CPOLY_7"},
}};

constexpr auto common_rows() {
  using enum EdsKind;
  using enum EdsUnit;
  constexpr auto head = std::to_array<EdsField>({
      {"EDS_VER", "version of the data sheet", 0x00, 1, number, none, 1, 255},
      {"EDS_LEN", "length of the data sheet", 0x01, 1, number, banks, 1, 255},
      {"USR_STA", "first user bank", 0x02, 1, number, bank_number, 0, 255},
      {"USR_END", "last user bank", 0x03, 1, number, bank_number, 0, 255},
      {"TMA", "shortest clock period", 0x04, 1, number, time_step, 1, 255},
      {"TO_MIN", "timeout, shortest", 0x05, 1, number, time_step, 0, 255},
      {"TO_MAX", "timeout, longest", 0x06, 1, number, time_step, 0, 255},
      {"TOS_MIN", "short or adaptive timeout, shortest", 0x07, 1, number, time_step, 0, 255},
      {"TOS_MAX", "short or adaptive timeout, longest", 0x08, 1, number, time_step, 0, 255},
      {"TCLK_MIN", "sampling period of the slave, shortest", 0x09, 1, number, time_step, 0, 255},
      {"TCLK_MAX", "sampling period of the slave, longest", 0x0A, 1, number, time_step, 0, 255},
      {"TCYC", "shortest cycle", 0x0B, 1, number, time_step, 0, 255},
      {"TBUSY_MAX", "processing time of a frame, longest", 0x0C, 1, number, time_step, 0, 255},
      // At most 8 clocks: protocol description D2, table of characteristics, row 10b.
      {"BUSY_S", "clocks by which START is later", 0x0D, 1, number, clocks, 0, 8},
      {"PON_DLY", "from power-on to control communication", 0x0E, 2, number, time_step, 0, 0xFFFF},
      {"DC_NUM", "data channels", 0x10, 1, number, none, 0, 8},
      {"SL_NUM", "slaves (IDs) of the device", 0x11, 1, number, none, 1, 8},
      {"SL_OFF", "which of them this one is", 0x12, 1, number, none, 0, 7},
      {"RES_13", "not named by any source", 0x13, 1, unnamed, none, 0, 255},
  });
  constexpr auto of_channel = std::to_array<EdsField>({
      {"", "bank of the channel's profile part", 0, 1, number, bank_number, 0, 255},
      {"", "data bits, flags included", 1, 1, number, bits, 0, 64},
      {"", "sensor or actuator, alignment, leading stop bit", 2, 1, channel_format, none, 0, 255},
      {"", "CRC polynomial without its lowest bit", 3, 1, polynomial, none, 0, 255},
  });
  constexpr auto tail = std::to_array<EdsField>({
      {"BC_OFF", "bus coupler", 0x34, 1, bus_coupler, none, 0, 255},
      {"RES_35", "reserved", 0x35, 1, reserved, none, 0, 0},
      {"RES_36", "reserved", 0x36, 1, reserved, none, 0, 0},
      {"RES_37", "reserved", 0x37, 1, reserved, none, 0, 0},
      {"RES_38", "reserved", 0x38, 1, reserved, none, 0, 0},
      {"RES_39", "reserved", 0x39, 1, reserved, none, 0, 0},
      {"RES_3A", "reserved", 0x3A, 1, reserved, none, 0, 0},
      {"RES_3B", "reserved", 0x3B, 1, reserved, none, 0, 0},
      {"RES_3C", "reserved", 0x3C, 1, reserved, none, 0, 0},
      {"RES_3D", "reserved", 0x3D, 1, reserved, none, 0, 0},
      {"RES_3E", "reserved", 0x3E, 1, reserved, none, 0, 0},
      {"CHKSUM", "sum of the bytes before it", 0x3F, 1, checksum, none, 0, 255},
  });
  std::array<EdsField, head.size() + 4 * max_channels + tail.size()> rows{};
  auto at = std::copy(head.begin(), head.end(), rows.begin());
  for (std::size_t channel = 0; channel < max_channels; ++channel) {
    for (EdsField field : of_channel) {
      field.symbol = channel_symbols[channel][field.address];
      field.address = static_cast<std::uint8_t>(field.address + common_channel_address(channel));
      *at++ = field;
    }
  }
  std::copy(tail.begin(), tail.end(), at);
  return rows;
}

}  // namespace eds_detail

/// Every byte of the part.
inline constexpr auto common_fields = eds_detail::common_rows();
static_assert(eds_detail::covers_a_bank(common_fields));

/// The part as a bank holds it, right or wrong.
constexpr CommonPart parse_common_part(const EdsBank& bank) {
  return std::bit_cast<CommonPart>(bank);
}
/// The bank of a part, byte for byte; sealed() sets the checksum.
constexpr EdsBank build_bank(const CommonPart& part) { return std::bit_cast<EdsBank>(part); }

}  // namespace biss
