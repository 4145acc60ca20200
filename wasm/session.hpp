// One capture, read step by step for a page: its rows, and its lines as they are to be drawn.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "decode/control_listener.hpp"
#include "report/row_store.hpp"
#include "verbs/decode/decode_run.hpp"
#include "wasm/command.hpp"
#include "wasm/line_store.hpp"

namespace biss::wasm {

template <class T>
using Blocks = std::deque<T>;
/// A deque grows without copying all rows.
using Rows = report::RowStore<Blocks>;

/// A capture as `biss decode` reads it. Messages are the same as on the command's stderr.
///
/// Memory: about two bytes for each change of MA and SLO, and about 100 for each request cycle and for
/// each access to a register.
class Session final : private flow::ChangeWatcher {
 public:
  /// Opens the capture that a request of `decode` names.
  /// \param any_lines if no lines look like MA and SLO, take the two busiest ones
  Session(const Request& request, bool any_lines);
  ~Session() override;
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  /// `done` when the capture is open; otherwise nothing below may be called. After the end of the
  /// capture the exit status of the command.
  verbs::ExitStatus status() const { return status_; }

  /// Reads on for at most about this time. False at the end of the capture; then the messages of the
  /// command are on stderr.
  bool advance(double milliseconds);

  /// Facts about the capture, as a JSON object; see biss.d.mts.
  std::string about();
  /// The columns, as a JSON array.
  std::string columns_text() const;
  const Rows& rows() const { return *rows_; }
  /// \param ma of MA, otherwise of SLO; as the capture shows it
  const LineStore& line(bool ma) const { return ma ? ma_ : slo_; }
  /// The text that the command prints.
  std::string summary() const { return run_->summary(); }
  /// Accesses to registers, and commands, that take place within the cycles from number `first` to
  /// before number `end`, as `biss registers --to jsonl` writes them.
  std::string accesses(std::uint64_t first, std::uint64_t end) const;
  /// A cycle bit by bit and part by part, as a JSON object. Empty if its edges do not show it
  /// again.
  /// \param number the number of the cycle; by default the number in its row
  /// \pre row < rows().rows()
  std::optional<std::string> cycle(std::uint64_t row, std::optional<std::uint64_t> number);

 private:
  Picoseconds time_of(std::uint64_t row) const;
  verbs::ExitStatus begin();
  void take(std::span<const wire::Edge> edges) override;
  void take(const capture::PairPiece& changes) override;
  void end();

  verbs::ProcessHost host_;
  verbs::DecodeOptions options_;
  std::unique_ptr<verbs::DecodeRun> run_;
  std::optional<Rows> rows_;
  Blocks<decode::SeenAccess> accesses_;
  // Rows of `biss registers`: a command has one for each slave.
  std::size_t access_rows_ = 0;
  decode::ControlListener listener_;
  LineStore ma_;
  LineStore slo_;
  verbs::ExitStatus status_ = verbs::ExitStatus::done;
  bool ended_ = false;
};

}  // namespace biss::wasm
