// The output of a verb's rows: every format, and the chosen columns.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "report/table.hpp"
#include "verbs/common/output.hpp"

namespace biss::verbs {

/// How a verb writes its rows.
struct TableChoice {
  TableChoice(report::Format format, std::vector<std::string> names = {})
      : to(format), columns(std::move(names)) {}

  report::Format to;
  /// In this order; empty: all.
  std::vector<std::string> columns;
};

/// A writer to `output`, which must outlive it. It takes rows of all columns and writes the chosen
/// ones.
/// \return one line if the choice is wrong usage
tl::expected<std::unique_ptr<report::TableWriter>, std::string> make_table(
    const TableChoice& choice, std::span<const report::Column> columns, Output& output);

}  // namespace biss::verbs
