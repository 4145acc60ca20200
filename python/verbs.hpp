// The verbs of the command, run in this process: their arguments, rows, messages and files.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "biss/base/units.hpp"
#include "capture/buffer.hpp"
#include "report/row_store.hpp"
#include "verbs/common/exit_status.hpp"
#include "verbs/common/host.hpp"
#include "verbs/common/verb.hpp"

namespace biss::python {

/// Memory that NumPy takes over as it is.
template <class T>
using Values = std::vector<T, capture::Unfilled<T>>;
using StoredColumn = report::StoredColumn<Values>;

/// The output of a verb.
struct VerbResult {
  verbs::ExitStatus status = verbs::ExitStatus::done;
  /// The command's standard output; empty if `columns` has the rows.
  std::string output;
  std::string summary;
  std::vector<std::string> messages;
  std::vector<StoredColumn> columns;
};

/// How a verb runs.
struct VerbSetup {
  /// In place of files of these names.
  std::map<std::string, verbs::GivenCapture> captures;
  /// The rows go to VerbResult::columns if the verb reads captures to a table.
  bool keep_columns = false;
  /// The same as in MemoryHost::set_go_on(). After it has returned false, the result has no
  /// meaning.
  std::function<bool()> go_on = [] { return true; };
};

/// Runs a verb; `view` is not available. \param words,options see verbs::Command::run()
VerbResult run_verb(const std::vector<std::string>& words, const verbs::GivenOptions& options,
                    const VerbSetup& setup);

/// The edges of MA and SLO in a capture, as in EdgeArrays; an element for each edge.
struct CaptureEdges {
  VerbResult result;
  std::string ma_name;
  std::string slo_name;
  Picoseconds sample_period{};
  Values<std::int64_t> times;
  Values<std::uint8_t> ma;
  Values<std::uint8_t> slo;
};

/// Reads the capture that the words name as for `biss decode`, and finds MA and SLO in it. A line that
/// is inverted is inverted back. Also fails with `data_failed` if a level is neither 0 nor 1.
CaptureEdges read_edges(const std::vector<std::string>& words, const verbs::GivenOptions& options,
                        const VerbSetup& setup);

}  // namespace biss::python
