// A data sheet field by field, in the order of parts and addresses, for tables and comparisons.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "biss/eds/field.hpp"
#include "dump/data_sheet.hpp"

namespace biss::cli {

struct EdsEntry {
  /// "common", "bp3", "raw".
  std::string_view part;
  /// Of a profile's part.
  std::optional<unsigned> channel;
  unsigned bank = 0;
  unsigned address = 0;
  std::string symbol;
  /// As stored; empty where not all of its bytes are known.
  std::optional<std::uint32_t> value;
  /// eds_meaning()
  std::string means;
  std::string_view meaning;
  /// Reserved or unnamed, or of a channel that the device has not.
  bool unused = false;
};

/// A part whose layout is not known has an entry a byte, with its address as symbol.
std::vector<EdsEntry> eds_entries(const dump::DataSheet& sheet);

/// A part with what it is called: for those who want the parts and not the fields.
struct EdsPartEntry {
  EdsPart part{};
  std::optional<unsigned> channel;
  const dump::FoundPart* found = nullptr;  // of the sheet
};
std::vector<EdsPartEntry> eds_parts(const dump::DataSheet& sheet);

/// The number of a field where all of its bytes are known.
std::optional<std::uint32_t> known_value(const dump::FoundPart& part, const EdsField& field);

}  // namespace biss::cli
