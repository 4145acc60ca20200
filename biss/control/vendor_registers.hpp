// What makers have put where the register map says something else, or says nothing. Each row is
// from one document, none has been seen on the line; a device that is not here may do as it likes
// too.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace biss {

/// A run of registers with a maker's own meaning.
struct VendorRegister {
  std::string_view vendor;
  std::string_view device;
  std::uint8_t first = 0;
  std::uint8_t last = 0;
  std::string_view meaning;

  constexpr bool contains(unsigned address) const { return address >= first && address <= last; }
};

/// Registers 0x40 to 0x47 in another meaning than the map's: do not write BSEL, do not believe the
/// serial number there.
inline constexpr std::array<VendorRegister, 4> map_quirks{{
    {"Lika", "AMM36", 0x40, 0x40, "preset enable, not BSEL"},
    {"Lika", "AMM36", 0x44, 0x47, "serial number, least significant byte first"},
    {"Lika", "SMA1", 0x44, 0x47, "year, week and serial number"},
    {"iC-Haus", "iC-MU", 0x41, 0x41, "0xFF means no EDS"},
}};

/// Registers of the free area.
inline constexpr std::array<VendorRegister, 13> vendor_registers{{
    {"Baumer", "", 0x60, 0x60, "command: 0x02 presets the position"},
    {"Baumer", "", 0x68, 0x68, "error"},
    {"TI", "example table", 0x60, 0x60, "status, command"},
    {"TI", "example table", 0x67, 0x67, "temperature"},
    {"TI", "example table", 0x68, 0x68, "error"},
    {"Lika, WayCon", "", 0x48, 0x48, "command: 1 save, 2 preset, 4 defaults"},
    {"Lika, WayCon", "", 0x4D, 0x4D, "resolution"},
    {"Lika, WayCon", "", 0x51, 0x53, "preset value"},
    {"iC-Haus", "iC-PVS, iC-PZ", 0x6C, 0x6E, "status"},
    {"iC-Haus", "iC-PVS, iC-PZ", 0x76, 0x76, "status of the command"},
    {"iC-Haus", "iC-PVS, iC-PZ", 0x77, 0x77, "command"},
    {"LENZ", "", 0x48, 0x48, "command"},
    {"LENZ", "", 0x4A, 0x4A, "data"},
}};

}  // namespace biss
