// The verbs of `biss eds`, and the data sheet that they work on, from a dump of registers or a description.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "biss/eds/device.hpp"
#include "verbs/common/verb.hpp"
#include "verbs/eds/description.hpp"

namespace biss::verbs {

// The verbs, one file each: see verbs/common/verb.hpp.
Run add_eds_show(Verb verb);
Run add_eds_check(Verb verb);
Run add_eds_build(Verb verb);
Run add_eds_diff(Verb verb);
Run add_eds_advise(Verb verb);

/// The user's arguments.
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

/// The contents of a file; it may hold no part of a data sheet.
struct EdsSource : Description {
  /// As stored.
  dump::DataSheet stored;
  /// With the overrides; a checksum that was right is updated.
  dump::DataSheet sheet;
  /// Symbols are static text.
  std::vector<EdsOverride> overrides;
};

/// Reads a file; throws a VerbError if it cannot.
EdsSource load_eds(const EdsArguments& arguments, Host& host);

/// The same; a file without any part of a data sheet is an error too (data_failed).
EdsSource load_eds_with_part(const EdsArguments& arguments, Host& host);

}  // namespace biss::verbs
