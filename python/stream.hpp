// A capture that comes in while it is decoded: rows as soon as they are finished, with the fields on the
// line.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <tl/expected.hpp>
#include <variant>
#include <vector>

#include "decode/cycle_edges.hpp"
#include "draw/layout.hpp"
#include "python/arrays.hpp"
#include "verbs/common/host.hpp"
#include "verbs/decode/decode_run.hpp"

namespace biss::python {

/// A cell that owns its text; bits are a text as the command writes them.
using StreamValue =
    std::variant<std::monostate, std::uint64_t, std::int64_t, double, Picoseconds, std::string>;

/// A stretch of the line, and the name of its track.
struct StreamField {
  draw::Part part;
  std::string track;
};

/// A row of `biss decode`.
struct StreamRow {
  /// The first edge of MA and the last one.
  Picoseconds begin{};
  Picoseconds end{};
  std::vector<StreamValue> values{};
  /// In the order of time; of all tracks.
  std::vector<StreamField> fields{};
};

struct StreamSetup {
  /// Rows have fields.
  bool fields = false;
  /// As InputArguments::beginning.
  std::size_t beginning = verbs::edges_at_beginning;
  Picoseconds sample_period{};
};

/// `biss decode` on edges that are pushed. If the format is given, the rows are the same as from
/// the command on the same capture; else the format is found in the beginning alone.
class Stream {
 public:
  /// \param options of `biss decode`
  Stream(const verbs::GivenOptions& options, const StreamSetup& setup);
  ~Stream();
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;

  /// Why nothing can be read: wrong usage, or the capture has no data that can be decoded.
  const std::optional<verbs::VerbError>& failure() const { return failure_; }

  /// \pre time is not before the last one, and not ended()
  void push(Picoseconds time, bool ma, bool slo) { queue_.push(time, ma, slo); }
  /// Decodes the pushed edges, unless they may belong to the beginning; a few edges wait for more.
  void decode(bool few = false);
  /// decode() has nothing to do.
  bool waits() const;
  /// The capture ends here, or at its last edge if that is later.
  void finish(Picoseconds end);
  bool ended() const { return ended_; }

  /// Rows that are finished, each once.
  std::vector<StreamRow> take_rows();
  /// Empty before the beginning has been read.
  const std::vector<report::Column>& columns() const { return columns_; }
  /// Empty if it is not known.
  const std::string& format() const { return format_; }
  const std::string& summary() const { return host_.summary(); }
  const std::vector<std::string>& messages() const { return host_.lines(); }
  verbs::ExitStatus status() const { return status_; }

 private:
  class Rows;
  static constexpr std::size_t few_edges = 512;

  void begin();
  verbs::ExitStatus open();
  void read();
  void end();
  void put_row(std::uint64_t number, const decode::Cycle& cycle);
  void fail(verbs::ExitStatus status);

  StreamSetup setup_;
  verbs::MemoryHost host_;
  verbs::DecodeOptions options_;
  EdgeQueue queue_;
  std::optional<verbs::DecodeRun> run_;
  // With fields: reads the cycles in place of the capture's own decoder.
  std::optional<decode::CycleEdgeReader> edges_;
  std::unique_ptr<Rows> writer_;
  std::vector<report::Column> columns_;
  std::vector<StreamRow> rows_;
  bool begun_ = false;
  bool ended_ = false;
  std::optional<verbs::VerbError> failure_;
  std::string format_;
  verbs::ExitStatus status_ = verbs::ExitStatus::done;
};

}  // namespace biss::python
