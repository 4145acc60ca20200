// A RegisterDump as a file.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "dump/register_dump.hpp"

namespace biss::dump {

/// The value of an unknown byte in formats that cannot leave it out: erased memory.
inline constexpr std::uint8_t erased = 0xFF;

/// Appends `0x40: 00 -- …`, 16 bytes per line, without lines of unknown bytes only. `separator`
/// follows the address.
void append_hex_rows(std::string& out, const DumpedBytes& bytes, unsigned first_address,
                     std::string_view separator);

/// Banks and registers by address as hex text; reads back to the same dump.
std::string write_hex_page(const RegisterDump& dump);

/// Intel HEX, records of up to 16 bytes by offset; reads back to the same dump.
std::string write_intel_hex(const RegisterDump& dump);

/// The banks from `first` to the last known one, 64 bytes each; an unknown byte is `erased`. The
/// registers 0x40…0x7F have no place in it.
std::string write_binary(const RegisterDump& dump, unsigned first = 0);

/// The same bytes as a constant in C. \pre name is an identifier
std::string write_c_array(const RegisterDump& dump, std::string_view name, unsigned first = 0);

/// The format of a file by its extension: "bin", "ihex" or "c", else "hex".
std::string_view format_of(std::string_view file);

/// Whether a format has no place for the registers from 0x40 on: "bin" and "c".
bool holds_banks_only(std::string_view format);

/// The dump in one of these formats. `name` and `first` are for the formats of banks only.
std::string write_as(std::string_view format, const RegisterDump& dump, std::string_view name,
                     unsigned first = 0);

/// The content of a file that has only banks, and the registers that it lacks; a line of text.
/// \pre dump.banks()
std::string text_of_banks(const RegisterDump& dump, unsigned first = 0);

/// How many registers are left out because their bank is not known; a message without a full stop.
std::string text_without_bank(const RegisterDump& dump);

}  // namespace biss::dump
