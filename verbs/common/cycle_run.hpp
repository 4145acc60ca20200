// Verbs that judge the request cycles of a capture, in steps, so that several verbs can share one
// reading.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "verbs/common/decoded_capture.hpp"

namespace biss::verbs {

/// A run of such a verb, and its capture. For each capture that capture().next() goes to, either
/// judge(), or begin(), take() for each cycle, and end(); then watcher() sees the changes.
class CycleRun {
 public:
  explicit CycleRun(Host& host) : host_(host), capture_(host) {}
  virtual ~CycleRun() = default;

  /// Prints why the command line makes no sense.
  virtual ExitStatus open() = 0;
  virtual std::vector<report::Column> columns() const = 0;
  /// \return the status of the capture, if none of its cycles is of use
  virtual std::optional<ExitStatus> begin(report::TableWriter& writer, RunMessages& messages) = 0;
  virtual void take(std::uint64_t number, const decode::Cycle& cycle) = 0;
  /// The object that also gets the changes of the capture, after begin(); may be null.
  virtual ChangeWatcher* watcher() { return nullptr; }
  /// \param read as DecodedCapture::read() returns it
  virtual ExitStatus end(bool read, Picoseconds end_time, report::TableWriter& writer,
                         RunMessages& messages) = 0;

  DecodedCapture& capture() { return capture_; }
  /// The verb: open(), then judge() for each capture.
  ExitStatus write(const std::string& output, const TableChoice& to) {
    const ExitStatus opened = open();
    if (opened != ExitStatus::done) return opened;
    return write_captures(
        capture_, output, to, [this] { return columns(); }, true,
        [this](report::TableWriter& writer, RunMessages& messages) {
          return judge(writer, messages);
        });
  }
  /// Reads the capture.
  ExitStatus judge(report::TableWriter& writer, RunMessages& messages) {
    if (const auto status = begin(writer, messages)) return *status;
    const bool read = read_cycles();
    return end(read, capture_.input().end_time(), writer, messages);
  }

 protected:
  // The same as DecodedCapture::read(), after begin().
  bool read_cycles() {
    if (ChangeWatcher* const own = watcher()) capture_.watch(*own);
    const bool read = capture_.read([this](std::uint64_t number, const decode::Cycle& cycle) {
      take(number, cycle);
      return true;
    });
    capture_.unwatch();
    return read;
  }

  Host& host_;
  DecodedCapture capture_;
};

/// `check`, `explain` and `identify` with these captures and these options; all other options have
/// their defaults. Rows are as for JSON lines.
std::unique_ptr<CycleRun> check_run(const CaptureArguments& capture, const std::string& against,
                                    Host& host);
std::unique_ptr<CycleRun> explain_run(const CaptureArguments& capture, Host& host);
std::unique_ptr<CycleRun> identify_run(const CaptureArguments& capture, Host& host);

}  // namespace biss::verbs
