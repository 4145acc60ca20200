// Rows of a data sheet: its parts, its fields, and its findings.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "biss/eds/check.hpp"
#include "biss/eds/field.hpp"
#include "dump/data_sheet.hpp"

namespace biss::verbs {

/// A part, and how its bytes are to be read.
struct EdsPartRow {
  EdsPart part{};
  /// The channel of a profile part.
  std::optional<unsigned> channel;
  const dump::FoundPart* found = nullptr;  // in the sheet
};

/// The common part, then the profile parts by channel.
std::vector<EdsPartRow> eds_parts(const dump::DataSheet& sheet);

/// "common", "bp3" (channel 0), "bp3 1".
std::string part_text(std::string_view part, std::optional<unsigned> channel);

struct EdsFieldRow {
  /// "common", "bp3", "raw".
  std::string_view part{};
  /// The channel of a profile part.
  std::optional<unsigned> channel{};
  unsigned bank = 0;
  unsigned address = 0;
  unsigned bytes = 1;
  std::string symbol{};
  /// As stored; empty unless all of its bytes are known.
  std::optional<std::uint32_t> value{};
  /// eds_meaning()
  std::string means{};
  std::string_view meaning{};
  /// is_unused()
  bool unused = false;
};

/// The fields by part and address. A part with an unknown layout has a row per byte, with the
/// address as symbol.
std::vector<EdsFieldRow> eds_fields(const dump::DataSheet& sheet);

/// The value of a field; empty unless all of its bytes are known.
std::optional<std::uint32_t> known_value(const dump::FoundPart& part, const EdsField& field);

/// Whether a field is reserved or unnamed, or of a channel that the device does not have.
bool is_unused(const EdsField& field, EdsPart part, const EdsBank& bank);

struct EdsFindingRow {
  std::string_view part{};
  std::optional<unsigned> channel{};
  std::string_view symbol{};
  /// name_of(EdsProblem), or `incomplete`: bytes of the bank are not in the dump.
  std::string_view problem{};
  std::optional<std::uint32_t> value{};
  std::string_view against{};
  /// The right value if `certain`, else the value of `against`.
  std::optional<std::uint32_t> expected{};
  bool certain = false;
  std::string text{};
};

EdsFindingRow finding_row(const EdsFinding& finding);

/// `CPOLY: the polynomial has its lowest bit … (67, expected 33)`
std::string finding_line(const EdsFindingRow& row);

/// Everything that is wrong, by part.
std::vector<EdsFindingRow> eds_findings(const dump::DataSheet& sheet,
                                        const EdsCheckOptions& rules = {});

}  // namespace biss::verbs
