// The output of a verb's rows: one table of all captures, in every format, and its chosen columns.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "report/table.hpp"
#include "verbs/common/decoded_capture.hpp"
#include "verbs/common/host.hpp"

namespace biss::verbs {

/// The text that a run prints on stderr after its rows.
class RunMessages {
 public:
  void add_summary(std::string_view text);
  /// Keeps the line with the reason why the run fails; returns `status`.
  ExitStatus fail(ExitStatus status, std::string line);
  void print(Host& host) const;

 private:
  std::string summaries_;
  std::vector<std::string> lines_;
};

/// Writes one table of all captures: calls `write` for each, which writes the rows of the current
/// capture. Columns that name the capture of a row are added.
/// \param output as for Output::open()
/// \param columns of the rows; called when the first capture is open
/// \param chosen the names of the columns that are written, in this order; empty: all
/// \param needs_all the status depends on every row, also when the reader of a pipe has left
/// \return the worst status of all captures; with `usage` and `io` the output file is left as it was
ExitStatus write_captures(
    DecodedCapture& capture, const std::string& output, report::Format to,
    const std::function<std::vector<report::Column>()>& columns, bool needs_all,
    const std::function<ExitStatus(report::TableWriter& writer, RunMessages& messages)>& write,
    const std::vector<std::string>& chosen = {});

}  // namespace biss::verbs
