// The results of other verbs on the same capture, from one reading of it.
#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <tl/expected.hpp>

#include "verbs/common/cycle_run.hpp"
#include "verbs/common/host.hpp"

namespace biss::verbs {

/// A verb that runs on the reading of another one: open(), then take() and watcher() for the cycles
/// and the changes of another capture of the same file, then answer(). It reads the file itself if
/// it uses other lines.
class AskedVerb {
 public:
  /// \param make makes its run
  template <class Make>
  AskedVerb(std::string name, Host& outer, Make make)
      : name_(std::move(name)), host_(&outer), run_(make(host_)) {}

  const std::string& name() const { return name_; }
  /// Goes to the capture, and decides which parts of the reading are needed.
  void open(const DecodedCapture& reading);
  /// The next cycle of the reading.
  void take(std::uint64_t number, const decode::Cycle& cycle);
  /// The object that gets the changes; may be null.
  ChangeWatcher* watcher() { return following_ ? &*following_ : run_->capture().watcher(); }
  /// \return `status`, `out` and `err`, as RunResult of wasm/biss.d.mts; its own error if it could
  ///   not judge the capture
  tl::expected<nlohmann::json, VerbError> answer(Picoseconds end_time);

 private:
  ExitStatus begin(const DecodedCapture& reading);
  void end(Picoseconds end_time);

  std::string name_;
  MemoryHost host_;
  std::unique_ptr<CycleRun> run_;
  report::StringSink out_;
  std::unique_ptr<report::TableWriter> writer_ =
      report::make_table_writer(report::Format::jsonl, run_->columns(), out_);
  RunMessages messages_;
  ExitStatus status_ = ExitStatus::done;
  // It uses the cycles of the reading, or its changes.
  bool shares_ = false;
  std::optional<FollowingCapture> following_;
  bool ended_ = false;
};

}  // namespace biss::verbs
