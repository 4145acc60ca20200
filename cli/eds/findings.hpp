// Findings of check_eds() as rows.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "biss/eds/check.hpp"
#include "cli/common/output.hpp"
#include "dump/data_sheet.hpp"
#include "report/table.hpp"

namespace biss::cli {

struct EdsFindingRow {
  std::string_view part;
  std::optional<unsigned> channel;
  std::string_view symbol;
  /// name_of(EdsProblem), or `incomplete`: bytes of the bank are not in the dump.
  std::string_view problem;
  std::optional<std::uint32_t> value;
  std::string_view against;
  /// What the value should be where `certain`, else the value of `against`.
  std::optional<std::uint32_t> expected;
  bool certain = false;
  std::string text;
};

/// Everything that is wrong, in the order of parts.
std::vector<EdsFindingRow> eds_findings(const dump::DataSheet& sheet,
                                        const EdsCheckOptions& rules = {});

/// `CPOLY: the polynomial has its lowest bit … (67, expected 33)`
std::string finding_line(const EdsFindingRow& row);

/// The rows as a table; nothing at all where there are none. False when the output failed.
bool write_findings(const std::vector<EdsFindingRow>& rows, report::Format format, Output& output);

}  // namespace biss::cli
