// Registers that tests can inspect, and a daisy chain of register servers, stepped by BiSS frames.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "biss/slave/banked_registers.hpp"
#include "biss/slave/register_server.hpp"

namespace biss::test {

/// One slave's registers: all 128 have the same protection, except those that a test changes.
struct TestRegisters {
  std::array<std::uint8_t, register_count> value{};
  std::array<RegisterProtection, register_count> protection{};
  std::uint32_t busy_frames = 0;  // of each byte but the first of a write
  std::uint32_t waited = 0;
  std::uint32_t writes = 0;
  bool accepts = true;
  std::array<std::uint32_t, 4> addressed{};  // commands executed, by number
  std::array<std::uint32_t, 4> broadcast{};

  constexpr TestRegisters() { protection.fill(RegisterProtection::read_write); }
};

/// The owner of a server: one TestRegisters for each of its slaves.
struct TestOwner {
  TestRegisters* slaves = nullptr;

  constexpr bool permits(unsigned slave, RegisterAccess access, std::uint8_t address) const {
    if (address >= register_count) return true;  // the server must not ask for these
    const RegisterProtection level = slaves[slave].protection[address];
    return level == RegisterProtection::read_write ||
           (level == RegisterProtection::read_only && access == RegisterAccess::read);
  }
  constexpr bool ready(unsigned slave) const {
    TestRegisters& registers = slaves[slave];
    if (registers.waited++ < registers.busy_frames) return false;
    registers.waited = 0;
    return true;
  }
  constexpr std::optional<std::uint8_t> read(unsigned slave, std::uint8_t address) const {
    if (!ready(slave)) return std::nullopt;
    return slaves[slave].value[address];
  }
  constexpr void write(unsigned slave, std::uint8_t address, std::uint8_t value) const {
    slaves[slave].value[address] = value;
    ++slaves[slave].writes;
  }
  constexpr bool accepts(unsigned slave, ControlCommand, bool) const {
    return slaves[slave].accepts;
  }
  constexpr void execute(unsigned slave, ControlCommand command, bool broadcast) const {
    auto& counts = broadcast ? slaves[slave].broadcast : slaves[slave].addressed;
    ++counts[static_cast<std::size_t>(command)];
  }
};

/// One BiSS frame through a daisy chain of servers: CDS of this frame, then CDM.
template <class Servers>
constexpr bool control_frame(Servers& servers, bool cdm) {
  bool cds = false;
  for (auto& server : servers) cds = server.cds(cds);
  for (auto& server : servers) server.cdm(cdm);
  return cds;
}

/// Compares the CDS bits of a control frame, spelled in '0' and '1' (blanks are ignored), with
/// `cds`. Each CDS bit is read in the frame after the CDM bit of the same index. If `cds` is
/// shorter than `cdm`, the rest is 0.
/// \return the index of the first difference; none if all bits are equal
template <class Servers>
constexpr std::optional<std::size_t> first_difference(Servers& servers, std::string_view cdm,
                                                      std::string_view cds) {
  std::optional<bool> due;
  std::size_t index = 0;
  std::size_t answer = 0;
  const auto judge = [&](bool seen) {
    const bool differs = due && seen != *due;
    while (answer < cds.size() && cds[answer] == ' ') ++answer;
    due = answer < cds.size() && cds[answer++] == '1';
    return differs;
  };
  for (const char bit : cdm) {
    if (bit == ' ') continue;
    if (judge(control_frame(servers, bit == '1'))) return index - 1;
    ++index;
  }
  if (judge(control_frame(servers, false))) return index - 1;
  return std::nullopt;
}

template <class Servers>
constexpr void send_zeros(Servers& servers, unsigned count = control_reset_zeros) {
  for (unsigned i = 0; i < count; ++i) control_frame(servers, false);
}

}  // namespace biss::test
