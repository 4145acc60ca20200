// What a register server asks of the device it speaks for.
//
//   struct Registers {
//     bool permits(unsigned slave, RegisterAccess access, std::uint8_t address);
//     std::optional<std::uint8_t> read(unsigned slave, std::uint8_t address);
//     bool ready(unsigned slave);
//     void write(unsigned slave, std::uint8_t address, std::uint8_t value);
//     bool accepts(unsigned slave, ControlCommand command, bool broadcast);
//     void execute(unsigned slave, ControlCommand command, bool broadcast);
//   };
//
// All are called from within the server's cdm(), which a Slave calls when its timeout is over: the
// answer goes out with the next frame, so they must be short. `slave` counts within the device.
#pragma once

#include <concepts>
#include <cstdint>
#include <optional>

#include "biss/control/control_frame.hpp"

namespace biss {

/// The owner of a register server; see the top of this file.
///
/// * `permits`: asked at R and W for the first address, and for each further one when the byte
/// before
///   it is done (that makes P). False: refused; the protocol has one word for protected and absent.
/// * `read`: the byte to send; nothing: busy, asked again with the next frame, for as long as the
///   master waits (20 ms by D2).
/// * `ready`: whether the next byte of a sequential write may come; asked again with the next
/// frame.
///   The first byte cannot be delayed, it is not asked for that: a device that is still busy with
///   an earlier write keeps the byte, or does not permit.
/// * `write`: a byte whose CRC was right.
/// * `accepts`: whether it would execute the command; asked once for each slave addressed, and at a
///   broadcast once for each slave of the device. `execute` follows where the master says so.
template <class Owner>
concept RegisterOwner = requires(Owner owner, unsigned slave, std::uint8_t byte) {
  { owner.permits(slave, RegisterAccess::read, byte) } -> std::same_as<bool>;
  { owner.read(slave, byte) } -> std::same_as<std::optional<std::uint8_t>>;
  { owner.ready(slave) } -> std::same_as<bool>;
  owner.write(slave, byte, byte);
  { owner.accepts(slave, ControlCommand::channels, true) } -> std::same_as<bool>;
  owner.execute(slave, ControlCommand::channels, true);
};

/// How a register server behaves where devices differ.
struct RegisterServerOptions {
  /// R = W says "refused" (D2). Old devices repeat W as it was sent; their start bit never comes.
  bool w_inversion = true;
  /// S of every byte but the first comes this many frames later than it could (an iC-MHM: 1; AN22).
  std::uint16_t busy_frames = 0;
  /// P = 1 behind so many bytes of one access (D2: up to 64).
  std::uint8_t sequence_bytes = sequential_max_bytes;
};

}  // namespace biss
