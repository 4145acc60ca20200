// A RegisterDump as a file.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "dump/register_dump.hpp"

namespace biss::dump {

/// What a byte that nobody knows is in formats that cannot leave it out: erased memory.
inline constexpr std::uint8_t erased = 0xFF;

/// Banks and registers by address, as read_hex_page() reads them; reads back to the same dump.
std::string write_hex_page(const RegisterDump& dump);

/// Records of up to 16 bytes by offset, as read_intel_hex() reads them; reads back to the same
/// dump.
std::string write_intel_hex(const RegisterDump& dump);

/// The banks from `first` to the last that is known, 64 bytes each; a byte not known is erased. The
/// registers 0x40…0x7F have no place in it.
std::string write_binary(const RegisterDump& dump, unsigned first = 0);

/// The same bytes as a constant of C. \pre name is an identifier
std::string write_c_array(const RegisterDump& dump, std::string_view name, unsigned first = 0);

}  // namespace biss::dump
