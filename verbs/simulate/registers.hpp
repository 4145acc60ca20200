// `--registers`: the contents of the simulated encoders' registers.
#pragma once

#include <string>
#include <vector>

#include "sim/encoder_registers.hpp"
#include "verbs/common/format_option.hpp"
#include "verbs/common/host.hpp"

namespace biss::verbs {

struct LoadedRegisters {
  /// By ID.
  std::vector<sim::EncoderRegisters> registers;
  /// The format that the encoders describe in their registers, and for one encoder with a data
  /// sheet its timing. Empty if the registers describe nothing.
  FormatArguments device;
  /// The findings of check_eds() in their data sheets, and the last one that contradicts(); empty
  /// if there is none. The format of a contradictory data sheet may be wrong.
  std::vector<std::string> findings;
  std::string contradiction;
};

/// Reads `FILE` for the encoder with the next ID, `ID:FILE` for that ID. From a file with accesses
/// to several slaves it takes the accesses to this ID. Prints one line and returns the status on an
/// error.
///
/// Every byte in a file is readable. BSEL is writable if the file has it or has more than one bank;
/// so are all bytes that are neither in the register map (0x41 … 0x47, 0x78 … 0x7F) nor in a bank
/// of the data sheet. All other accesses are refused.
LoadedRegisters load_registers(const std::vector<std::string>& arguments, Host& host);

/// The file that one of these arguments names.
std::string file_of_registers(const std::string& argument);

}  // namespace biss::verbs
