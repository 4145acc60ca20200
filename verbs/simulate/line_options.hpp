// The options of a simulated line, as verbs declare them.
#pragma once

#include <string>
#include <vector>

#include "verbs/common/verb.hpp"
#include "verbs/simulate/setup.hpp"

namespace biss::verbs {

/// The master at the end of the line: simulated with it, or a program that reads the encoder.
enum class MasterKind : std::uint8_t { simulated, foreign };

/// Declares the format, the cable, the timing, the motion and the faults. A foreign master has its
/// own clock, pauses and sampling point, and one encoder.
void add_line_options(Verb all, LineOptions& line, MasterKind master);

/// Declares `--registers` and `--register-busy`. \param files gets the arguments of `--registers`
void add_register_options(Verb verb, std::vector<std::string>& files, LineOptions& line);

/// Loads the registers of these files. Without a format given, they also give format and timing.
void put_registers(const std::vector<std::string>& files, LineOptions& line, Host& host);

}  // namespace biss::verbs
