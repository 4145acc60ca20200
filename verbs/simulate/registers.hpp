// `--registers`: what the simulated encoders have in their registers.
#pragma once

#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "sim/encoder_registers.hpp"
#include "verbs/common/exit_status.hpp"
#include "verbs/common/format_option.hpp"

namespace biss::verbs {

class Host;

struct LoadedRegisters {
  /// By ID.
  std::vector<sim::EncoderRegisters> registers;
  /// The format that the encoders describe in their registers, and for one encoder with a data
  /// sheet its timing. Empty where nothing is described.
  FormatArguments device;
  /// What check_eds() finds in their data sheets, and the last of it that contradicts(); empty where
  /// there is none. The format of a contradictory data sheet may be wrong.
  std::vector<std::string> findings;
  std::string contradiction;
};

/// Reads `FILE` for the encoder with the next ID, `ID:FILE` for that ID; in a file with accesses to
/// several slaves, those to this ID. Prints one line and returns the status on an error.
///
/// Every byte in a file is readable. Writable are BSEL, where the file has it or more than one bank,
/// and all bytes that are neither in the register map (0x41 … 0x47, 0x78 … 0x7F) nor in a bank of
/// the data sheet. All other accesses are refused.
tl::expected<LoadedRegisters, ExitStatus> load_registers(const std::vector<std::string>& arguments,
                                                         Host& host);

/// The file that one of these arguments names.
std::string file_of_registers(const std::string& argument);

}  // namespace biss::verbs
