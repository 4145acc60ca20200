// `--registers`: what the simulated encoders have in their registers.
#pragma once

#include <string>
#include <vector>

#include "biss/base/units.hpp"
#include "cli/common/exit_status.hpp"
#include "cli/common/format_option.hpp"
#include "sim/encoder_registers.hpp"

namespace biss::cli {

/// Registers by ID; with a status other than `done` the one line why not was printed.
struct LoadedRegisters {
  std::vector<sim::EncoderRegisters> registers;
  ExitStatus status = ExitStatus::done;
  /// What the encoders say of themselves, as a user would: the format, and of one encoder alone
  /// with a data sheet its timing. Empty where nothing is said.
  FormatArguments device;
};

/// Reads `FILE` for the encoder with the next ID, `ID:FILE` for that one; of a file with accesses
/// to several slaves, those to this ID.
///
/// Every byte that a file knows can be read. Written can be BSEL, where the file knows it or more
/// than one bank, and what is neither of the register map's own (0x41 … 0x47, 0x78 … 0x7F) nor a
/// bank of the data sheet. All else is refused.
LoadedRegisters load_registers(const std::vector<std::string>& arguments);

/// The file that one of these arguments names.
std::string file_of_registers(const std::string& argument);

/// `--register-busy`: frames by which each byte is late, `12`, or those that begin in a time,
/// `3ms`. \return an empty text, or the one line why it is neither
std::string read_busy(const std::string& text, Picoseconds interval, RegisterBusy& busy);

}  // namespace biss::cli
