// A control frame: one CDM bit and one CDS bit per BiSS frame, numbered k = 0, 1, 2 … from the
// start bit. CDM bit k ends a frame; CDS bit k comes with the next one.
//
//   k          0   1    2…4  5…11  12…15   16  17  18   19…26  27…30  31
//   read  CDM  S  CTS=1  ID   ADR   CRC     1   0   S     0      0     0
//         CDS  IDL0 … IDL8   0  …   0       1   0   S    DATA   CRC    P
//   write CDM  S  CTS=1  ID   ADR   CRC     0   1   S    DATA   CRC    0
//         CDS  IDL0 … IDL8   0  …   0       0   1   S    DATA   CRC    P    (the echo)
//
//   k              0   1     2…9    10…11  12…15  16  17…23  24
//   addressed CDM  S  CTS=0  IDS0…7  CMD    CRC   S     0    EX      CDS 16…23: IDA0 … IDA7
//   broadcast CDM  S  CTS=0    0     CMD    CRC   S   EX (k = 17)
//
// The S of a further byte follows at k = 32, as CDM bit of the frame in which P = 0 came.
//
// Protocol description D2, chapter control communication.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "biss/base/units.hpp"
#include "biss/crc/spec.hpp"

namespace biss {

/// This many CDM = 0 return every slave's control logic to idle, and must precede a control frame.
inline constexpr unsigned control_reset_zeros = 14;
/// Slaves that one control frame can address; IDL8 indicates more.
inline constexpr unsigned control_max_slaves = 8;
/// Bytes of one sequential access, at most.
inline constexpr std::size_t sequential_max_bytes = 64;
/// Register addresses are 7 bits.
inline constexpr unsigned register_count = 128;
/// The longest that a slave may delay S of a byte (D2, table of characteristics, row 11).
inline constexpr Picoseconds register_busy_max = milliseconds(20);

/// The CRC of the header (CTS and ten bits of addressing, without the start bit) and of a byte.
inline constexpr CrcSpec control_crc{.polynomial = 0x13, .start = 0, .width_bits = 4};

/// Index of a bit in a control frame.
namespace control_bit {
inline constexpr unsigned start = 0;
inline constexpr unsigned cts = 1;
inline constexpr unsigned addressing = 2;  // ten bits
inline constexpr unsigned idl_end = 9;     // after IDL8
inline constexpr unsigned header_crc = 12;
inline constexpr unsigned header_end = 16;
inline constexpr unsigned read = 16;        // R
inline constexpr unsigned write = 17;       // W
inline constexpr unsigned byte_start = 18;  // S of the first byte; later if the slave is busy
inline constexpr unsigned ida = 16;         // IDA0 … IDA7 on CDS
inline constexpr unsigned ex_addressed = 24;
inline constexpr unsigned ex_broadcast = 17;
}  // namespace control_bit

/// A byte's bits: S, DATA7 … DATA0, CRC3 … CRC0, P.
inline constexpr unsigned control_byte_bits = 14;

/// The BiSS frames of an access: the 14 zeros before it, and the last CDS after it if one is
/// needed, without busy slaves.
constexpr std::uint32_t register_access_frames(std::size_t bytes) {
  return control_reset_zeros + control_bit::byte_start +
         control_byte_bits * static_cast<std::uint32_t>(bytes) + 1;
}
inline constexpr std::uint32_t addressed_command_frames =
    control_reset_zeros + control_bit::ex_addressed + 1;
inline constexpr std::uint32_t broadcast_command_frames =
    control_reset_zeros + control_bit::ex_broadcast + 1;
static_assert(register_access_frames(1) == 47 && register_access_frames(64) == 929 &&
              addressed_command_frames == 39 && broadcast_command_frames == 32);

/// The four commands. Their meaning depends on whether slaves are addressed or all are meant. All
/// are optional for slaves.
enum class ControlCommand : std::uint8_t {
  channels = 0b00,  ///< addressed: activate data channels; broadcast: deactivate all data channels
  control = 0b01,   ///< addressed: deactivate control communication; broadcast: activate it in all
                    ///< slaves
  bypass = 0b10,    ///< bus couplers: addressed to standard operation; broadcast to feedback
  user = 0b11,      ///< addressed: the device's own; broadcast: reserved
};

/// The direction of an access to a register.
enum class RegisterAccess : std::uint8_t { read, write };

/// The 11 bits after the start bit, in line order from the top: CTS, then ten bits of addressing.
/// The header's CRC covers these bits.
constexpr std::uint16_t register_header(unsigned slave, unsigned address) {
  return static_cast<std::uint16_t>(0x400U | (slave & 7U) << 7U | (address & 0x7FU));
}
/// \param slaves bit k is the slave with ID k; 0: broadcast. IDS0 is sent first.
constexpr std::uint16_t command_header(std::uint8_t slaves, ControlCommand command) {
  unsigned ids = 0;
  for (unsigned k = 0; k < control_max_slaves; ++k) ids = ids << 1U | (slaves >> k & 1U);
  return static_cast<std::uint16_t>(ids << 2U | static_cast<unsigned>(command));
}

/// CRC of the control channel over the lowest `bits` bits of `data`, as sent (inverted).
constexpr std::uint8_t control_crc_of(std::uint32_t data, unsigned bits) {
  unsigned reg = 0;
  for (unsigned i = bits; i-- > 0;) {
    const unsigned feedback = (reg >> 3U ^ data >> i) & 1U;
    reg = (reg << 1U & 0xFU) ^ (feedback != 0 ? control_crc.polynomial & 0xFU : 0U);
  }
  return static_cast<std::uint8_t>(reg ^ 0xFU);
}

namespace control_detail {

// The CRC register after four zeros that follow each of its values: one nibble per step.
inline constexpr std::array<std::uint8_t, 16> crc_after_nibble = [] {
  std::array<std::uint8_t, 16> table{};
  for (unsigned i = 0; i < 16; ++i) {
    table[i] = static_cast<std::uint8_t>(control_crc_of(i, 4) ^ 0xFU);
  }
  return table;
}();

}  // namespace control_detail

constexpr std::uint8_t byte_crc(std::uint8_t data) {
  const auto& table = control_detail::crc_after_nibble;
  return table[table[data >> 4U] ^ (data & 0xFU)] ^ 0xFU;
}
constexpr std::uint8_t header_crc(std::uint16_t header) {
  const auto& table = control_detail::crc_after_nibble;
  const unsigned high = table[table[header >> 8U & 0x7U] ^ (header >> 4U & 0xFU)];
  return table[high ^ (header & 0xFU)] ^ 0xFU;
}

static_assert(header_crc(register_header(0, 0x00)) == 0x6 &&
              header_crc(register_header(0, 0x20)) == 0xC && byte_crc(0x48) == 0x3 &&
              byte_crc(0x55) == 0x2);  // published in AN22

// ---- A control frame's header as received: the 15 bits after the start bit

/// The request of a header.
struct ControlHeader {
  /// CTS = 1. False: a command.
  bool register_access = false;
  /// Register access: ID and address.
  std::uint8_t slave = 0;
  std::uint8_t address = 0;
  /// Command: bit k is the slave with ID k (IDS0 came first on the line); 0: broadcast.
  std::uint8_t slaves = 0;
  ControlCommand command = ControlCommand::channels;

  constexpr bool operator==(const ControlHeader&) const = default;
};

/// \param bits the 15 bits in line order, CTS topmost (bit 14), CRC0 lowest; higher bits are
///   ignored
/// \return nothing when the CRC is wrong: a slave then acts as if it was not addressed
constexpr std::optional<ControlHeader> parse_header(std::uint32_t bits) {
  const auto covered = static_cast<std::uint16_t>(bits >> 4U & 0x7FFU);
  if (header_crc(covered) != (bits & 0xFU)) return std::nullopt;
  ControlHeader header{.register_access = (covered >> 10U) != 0};
  if (header.register_access) {
    header.slave = static_cast<std::uint8_t>(covered >> 7U & 7U);
    header.address = static_cast<std::uint8_t>(covered & 0x7FU);
    return header;
  }
  header.command = static_cast<ControlCommand>(covered & 3U);
  for (unsigned k = 0; k < control_max_slaves; ++k) {
    if ((covered >> (9U - k) & 1U) != 0) header.slaves |= static_cast<std::uint8_t>(1U << k);
  }
  return header;
}

}  // namespace biss
