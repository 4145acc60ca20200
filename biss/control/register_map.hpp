// The register map of every BiSS C slave with register access: 128 bytes, of which the first 64 are
// a window to one of 256 banks. All numbers are big-endian.
//
// Protocol description D2, chapter registers.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "biss/base/big_endian.hpp"

namespace biss {

/// Addresses of the map.
namespace reg {
inline constexpr std::uint8_t bank = 0x00;      ///< 64 bytes of the bank that BSEL chooses
inline constexpr std::uint8_t bsel = 0x40;      ///< bank select; refused if there is only one bank
inline constexpr std::uint8_t eds_bank = 0x41;  ///< bank of the EDS
inline constexpr std::uint8_t bp_id = 0x42;     ///< profile identifier, 2 bytes
inline constexpr std::uint8_t dev_sn = 0x44;    ///< serial number, 4 bytes
inline constexpr std::uint8_t free = 0x48;      ///< 48 bytes for the device, for any BSEL
inline constexpr std::uint8_t dev_id = 0x78;    ///< device ID, 6 bytes
inline constexpr std::uint8_t mfr_id = 0x7E;    ///< manufacturer ID, 2 bytes; mandatory
}  // namespace reg

/// Bytes of a bank, and the number of banks that BSEL can select.
inline constexpr std::size_t bank_bytes = 64;
inline constexpr std::size_t bank_count = 256;

/// The access to a field of a device that follows the map. A device may protect any register; the
/// register then seems to be absent.
enum class FieldAccess : std::uint8_t {
  device,           ///< depends on the device
  read_only,        ///< writing is refused
  write_or_absent,  ///< readable and writable, or refused as a whole
};

/// A run of registers with one meaning.
struct RegisterField {
  std::string_view name;
  std::uint8_t address = 0;
  std::uint8_t bytes = 0;
  FieldAccess access = FieldAccess::device;

  constexpr bool contains(unsigned at) const { return at >= address && at - address < bytes; }
};

/// All 128 addresses, in order.
inline constexpr std::array<RegisterField, 8> register_fields{{
    {"BANK", reg::bank, 64, FieldAccess::device},
    {"BSEL", reg::bsel, 1, FieldAccess::write_or_absent},
    {"EDS_BANK", reg::eds_bank, 1, FieldAccess::read_only},
    {"BP_ID", reg::bp_id, 2, FieldAccess::read_only},
    {"DEV_SN", reg::dev_sn, 4, FieldAccess::read_only},
    {"FREE", reg::free, 48, FieldAccess::device},
    {"DEV_ID", reg::dev_id, 6, FieldAccess::read_only},
    {"MFR_ID", reg::mfr_id, 2, FieldAccess::read_only},
}};

/// The field that an address lies in. \pre address is below 128; others give the last field
constexpr const RegisterField& register_field(unsigned address) {
  for (const RegisterField& field : register_fields) {
    if (field.contains(address)) return field;
  }
  return register_fields.back();
}

/// A maker's entry in MFR_ID. The known IDs are two ASCII letters.
struct Manufacturer {
  std::uint16_t id = 0;
  std::string_view name;
  std::string_view source;
};

/// The makers that a source names. There are many more; Renishaw's encoders have no registers.
inline constexpr std::array<Manufacturer, 2> manufacturers{{
    {0x6943, "iC-Haus", "read from an iC-MHM (AN22); its description file is idbiss6943.xml"},
    {0x4C69, "Lika", "manuals name the description file idbiss4C69.xml"},
}};

/// The maker's name; nothing for an unknown ID.
constexpr std::optional<std::string_view> manufacturer_name(std::uint16_t id) {
  for (const Manufacturer& maker : manufacturers) {
    if (maker.id == id) return maker.name;
  }
  return std::nullopt;
}

/// The contents of registers 0x40 to 0x47.
struct DeviceRegisters {
  std::uint8_t bsel = 0;
  std::uint8_t eds_bank = 0;
  /// 0: none.
  std::uint16_t profile = 0;
  /// Empty if the device has no serial number.
  std::optional<std::uint32_t> serial;
};

/// DEV_SN as a number. 0 means none by the protocol; 0xFFFFFFFF is reserved and is found on devices
/// without a serial number (AN22).
constexpr std::optional<std::uint32_t> serial_number(std::span<const std::uint8_t, 4> bytes) {
  const auto number = static_cast<std::uint32_t>(from_big_endian(bytes));
  if (number == 0 || number == 0xFFFF'FFFFU) return std::nullopt;
  return number;
}

/// \param bytes registers 0x40 to 0x47
constexpr DeviceRegisters device_registers(std::span<const std::uint8_t, 8> bytes) {
  return {.bsel = bytes[0],
          .eds_bank = bytes[1],
          .profile = static_cast<std::uint16_t>(from_big_endian(bytes.subspan<2, 2>())),
          .serial = serial_number(bytes.subspan<4, 4>())};
}

/// The contents of registers 0x78 to 0x7F.
struct DeviceIdentity {
  /// 48 bits; often ASCII from the top byte on.
  std::uint64_t device = 0;
  std::uint16_t manufacturer = 0;

  constexpr bool operator==(const DeviceIdentity&) const = default;
};

/// \param bytes registers 0x78 to 0x7F
constexpr DeviceIdentity device_identity(std::span<const std::uint8_t, 8> bytes) {
  return {.device = from_big_endian(bytes.subspan<0, 6>()),
          .manufacturer = static_cast<std::uint16_t>(from_big_endian(bytes.subspan<6, 2>()))};
}

/// The meaning of EDS_BANK.
enum class EdsPresence : std::uint8_t {
  none,      ///< 0x00
  present,   ///< in this bank
  doubtful,  ///< 0xFF: a bank by the protocol, "none" on iC-MU; no EDS if the checksum fails
};

constexpr EdsPresence eds_presence(std::uint8_t eds_bank) {
  if (eds_bank == 0) return EdsPresence::none;
  return eds_bank == 0xFF ? EdsPresence::doubtful : EdsPresence::present;
}

// ---- Deviations of makers: each row is from one document, none was seen on the line. There may be
// others.

/// A run of registers with a maker's own meaning.
struct VendorRegister {
  std::string_view vendor;
  std::string_view device;
  std::uint8_t first = 0;
  std::uint8_t last = 0;
  std::string_view meaning;

  constexpr bool contains(unsigned address) const { return address >= first && address <= last; }
};

/// Registers 0x40 to 0x47 with a meaning that is not the meaning in the map. For these devices,
/// BSEL must not be written and the serial number there must not be used.
inline constexpr std::array<VendorRegister, 4> map_quirks{{
    {"Lika", "AMM36", 0x40, 0x40, "preset enable, not BSEL"},
    {"Lika", "AMM36", 0x44, 0x47, "serial number, least significant byte first"},
    {"Lika", "SMA1", 0x44, 0x47, "year, week and serial number"},
    {"iC-Haus", "iC-MU", 0x41, 0x41, "0xFF means no EDS"},
}};

}  // namespace biss
