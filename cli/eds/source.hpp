// Where the verbs of `biss eds` have their data sheet from: a dump of registers or a description.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "biss/eds/device.hpp"
#include "cli/common/exit_status.hpp"
#include "dump/data_sheet.hpp"
#include "dump/register_dump.hpp"

namespace biss::cli {

class Verb;

/// What the user typed.
struct EdsArguments {
  std::string file;
  std::optional<std::uint8_t> bank;
  std::optional<std::uint8_t> eds_bank;
  std::optional<std::uint8_t> slave;
  std::optional<std::uint16_t> identifier;
  std::vector<std::string> overrides;
};

/// Declares FILE.
void add_eds_file(Verb verb, std::string& file, bool required = true);
/// Declares --bank, --eds-bank, --slave, --id and --override.
void add_eds_options(Verb verb, EdsArguments& arguments);

/// What was found in a file. No part needs to be there.
struct EdsSource {
  dump::RegisterDump dump;
  /// As stored.
  dump::DataSheet stored;
  /// With the overrides made; a checksum that was right is right again.
  dump::DataSheet sheet;
  /// Symbols are static.
  std::vector<EdsOverride> overrides;
};

/// Reads a file, or prints the one line why not: `status` counts exactly when `source` is empty.
struct LoadedEds {
  std::optional<EdsSource> source;
  ExitStatus status = ExitStatus::done;
};
LoadedEds load_eds(const EdsArguments& arguments);

/// The same, and a failure too where there is no part of a data sheet at all.
LoadedEds load_eds_with_part(const EdsArguments& arguments);

}  // namespace biss::cli
