// The device itself: the meaning of its registers, and its electronic data sheet.
//
// An example of an encoder maker's own part: a rotary encoder of 24 bits with profile BP3, an
// electronic data sheet in bank 1, 32 user bytes in bank 0, and a preset command.
//
//   0x48        command: 0x02 = preset; reads 0 once it is done
//   0x49…0x4B   the position that the preset makes of the present one, 24 bits
//   0x4C        status: bit 0 the last command was unknown
//   0x4D        temperature in °C above -40
#pragma once

#include <array>
#include <cstdint>

#include "biss/base/bits.hpp"
#include "biss/control/register_map.hpp"
#include "biss/eds/bank.hpp"
#include "biss/eds/bp3_part.hpp"
#include "biss/eds/common_part.hpp"
#include "biss/frame/format_text.hpp"
#include "biss/slave/banked_registers.hpp"

namespace encoder_maker {

inline constexpr unsigned position_bits = 24;
inline constexpr biss::FrameFormat format = *biss::parse_format("pos24,nE,nW,crc6");
/// BP3, version 1; DL is the position and the two flags.
inline constexpr std::uint16_t profile = 0x6200 + position_bits + 2;
inline constexpr std::uint8_t user_bank = 0;
inline constexpr std::uint8_t eds_bank = 1;
inline constexpr std::uint8_t profile_bank = 2;

namespace address {
inline constexpr std::uint8_t command = 0x48;
inline constexpr std::uint8_t preset = 0x49;
inline constexpr std::uint8_t status = 0x4C;
inline constexpr std::uint8_t temperature = 0x4D;
}  // namespace address

inline constexpr std::uint8_t preset_command = 0x02;
inline constexpr std::uint8_t unknown_command = 0x01;

/// The common part. Times are in the units that the EDS hypotheses give; enter the device's own
/// figures here.
inline constexpr biss::EdsBank common_part = biss::sealed(biss::build_bank(biss::CommonPart{
    .eds_len = 2,
    .usr_sta = user_bank,
    .usr_end = user_bank,
    .tma = 200,
    .to_min = 50,
    .to_max = 80,
    .tcyc = 200,
    .dc_num = 1,
    .sl_num = 1,
    .channels = {{{.bank = profile_bank, .dlen = position_bits + 2, .cpoly = 0x21}}}}));

inline constexpr biss::EdsBank profile_part =
    biss::sealed(biss::build_bank(biss::Bp3Part{.bp_id = profile,
                                                .pon_pdl = 10,
                                                .co_len = position_bits,
                                                .co_fmt = 1,
                                                .mt_cnt = 1,
                                                .sip_cnt = 1,
                                                .sip_res = 1U << position_bits,
                                                .tmp_min = 233,
                                                .tmp_max = 378}));

/// The effects of register accesses. They run within the interrupts of MA, so slow work (the flash)
/// is only requested here. The main loop does it and reports its end.
struct Hooks : biss::NoRegisterHooks {
  bool preset_ordered = false;
  bool channels_active = true;
  std::uint8_t temperature = 0;
  std::uint8_t command_byte = 0;
  std::uint8_t status = 0;

  constexpr void reading(std::uint8_t, std::uint8_t at, std::uint8_t& value) const {
    if (at == address::temperature) value = temperature;
    if (at == address::command) value = command_byte;
    if (at == address::status) value = status;
  }
  constexpr void written(std::uint8_t, std::uint8_t at, std::uint8_t value) {
    if (at != address::command) return;
    preset_ordered = value == preset_command;
    command_byte = preset_ordered ? value : 0;
    status = preset_ordered ? 0 : unknown_command;
  }
  /// A read after a preset returns the state after it.
  constexpr bool busy() const { return preset_ordered; }

  constexpr bool accepts(biss::ControlCommand command, bool) const {
    return command == biss::ControlCommand::channels || command == biss::ControlCommand::control;
  }
  constexpr void execute(biss::ControlCommand command, bool broadcast) {
    if (command == biss::ControlCommand::channels) channels_active = !broadcast;
  }
};

using Registers = biss::BankedRegisters<3, Hooks>;

/// The state as delivered.
constexpr Registers factory_registers(std::uint32_t serial_number) {
  using enum biss::RegisterProtection;
  namespace reg = biss::reg;
  Registers registers;
  registers.bank(user_bank).put(0, std::array<std::uint8_t, 32>{}, read_write);
  registers.bank(eds_bank).put(0, common_part, read_only);
  registers.bank(profile_bank).put(0, profile_part, read_only);
  registers.put_number<1>(reg::eds_bank, eds_bank, read_only);
  registers.put_number<2>(reg::bp_id, profile, read_only);
  registers.put_number<4>(reg::dev_sn, serial_number, read_only);
  registers.put_number<1>(address::command, 0, read_write);
  registers.put_number<3>(address::preset, 0, read_write);
  registers.put_number<1>(address::status, 0, read_only);
  registers.put_number<1>(address::temperature, 0, read_only);
  registers.put_number<6>(reg::dev_id, 0x45584D'504C31, read_only);  // "EXMPL1"
  registers.put_number<2>(reg::mfr_id, 0x5858, read_only);  // "XX": ask the BiSS Association
  return registers;
}

}  // namespace encoder_maker
