// The rows of `biss simulate --outcomes`: how each access of the simulated master went.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "cli/common/exit_status.hpp"
#include "cli/common/output.hpp"
#include "report/table.hpp"
#include "sim/control_master.hpp"

namespace biss::cli {

/// `cycle,time_ns,id,access,address,name,data,outcome`, as `biss registers` has them, and `cycles`.
/// `cycle` and `time_ns` are those with which the master began, zeros before the control frame
/// included; `cycles` is how many it took. `data` is what was read or written with a good echo.
/// `outcome` is `ok`, the one cause, or `unfinished` where the run ended first. A command has a row
/// for each slave it addresses; a broadcast has one without an ID.
class OutcomeTable {
 public:
  OutcomeTable();

  const std::vector<report::Column>& columns() const { return columns_; }
  /// The rows of an access: each is valid until `row` returns. False as soon as that is.
  template <class Row>
  bool rows(const sim::ControlAccess& access, const sim::ControlRecord& record, Row row) {
    if (access.kind != sim::AccessKind::command) return row(cells(access, record, access.slave));
    for (unsigned id = 0; id < control_max_slaves; ++id) {
      if ((access.slaves >> id & 1U) != 0 && !row(cells(access, record, id))) return false;
    }
    return true;
  }

 private:
  const std::vector<report::Cell>& cells(const sim::ControlAccess& access,
                                         const sim::ControlRecord& record, unsigned id);

  std::vector<report::Column> columns_;
  std::vector<report::Cell> cells_;
  std::string address_;
  std::string data_;
};

/// `--outcomes`: the rows of a whole run, written at its end, and the summary.
class OutcomeLog {
 public:
  /// \param path empty: no rows. False: it cannot be written.
  bool open(const std::string& path);
  bool finish(const sim::ControlMaster& control);
  ExitStatus status() const { return output_.status(); }

 private:
  OutcomeTable table_;
  Output output_;
  std::unique_ptr<report::TableWriter> rows_;
};

/// `ok`, the cause's name, or `unfinished`.
std::string_view outcome_name(const sim::ControlRecord& record);

/// One line of all: "12 accesses: 10 ok, 2 refused".
std::string outcome_summary(const std::vector<sim::ControlRecord>& records, std::size_t accesses);

}  // namespace biss::cli
