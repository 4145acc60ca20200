// The services of the program that runs a verb: the command, Python, a page, another verb.
#pragma once

#include <fmt/format.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <thread>
#include <tl/expected.hpp>
#include <utility>
#include <vector>

#include "capture/edge_source.hpp"
#include "report/table.hpp"

namespace biss::verbs {

/// Exit status of every verb.
enum class ExitStatus : int {
  done = 0,         ///< the verb did its work
  data_failed = 1,  ///< the data failed: a check with findings, or no request cycle
  usage = 2,        ///< the command line is wrong; nothing was read or written
  io = 3,           ///< input unreadable or malformed, output not written, out of memory
};

class DecodedCapture;
struct InputArguments;

/// Why a verb ends early: the exit status, and one line with the reason. A verb that throws it ends
/// as by Host::fail().
struct VerbError {
  ExitStatus status = ExitStatus::usage;
  std::string text;
};

/// The error of wrong usage, with a text as for fmt::format().
template <class... Arguments>
VerbError wrong_usage(fmt::format_string<Arguments...> text, Arguments&&... arguments) {
  return {ExitStatus::usage, fmt::format(text, std::forward<Arguments>(arguments)...)};
}
/// The error of a file or a folder.
template <class... Arguments>
VerbError wrong_file(fmt::format_string<Arguments...> text, Arguments&&... arguments) {
  return {ExitStatus::io, fmt::format(text, std::forward<Arguments>(arguments)...)};
}
/// The value; throws a VerbError if there is none.
template <class Value>
Value value_or_fail(tl::expected<Value, std::string> result,
                    ExitStatus otherwise = ExitStatus::usage) {
  if (!result) throw VerbError{otherwise, std::move(result.error())};
  return *std::move(result);
}
/// Throws a VerbError unless the text, the reason of a failure, is empty.
inline void fail_if(std::string why, ExitStatus otherwise = ExitStatus::usage) {
  if (!why.empty()) throw VerbError{otherwise, std::move(why)};
}

/// A capture that a program has in memory; the verbs name it as they name files.
struct GivenCapture {
  std::function<capture::Opened(const InputArguments& arguments)> open;
  /// It can be opened more than once.
  bool again = true;
};

/// A reading that several verbs share.
class JointReading {
 public:
  virtual ~JointReading() = default;
  /// Waits until the capture is read, and gives it its cycles and changes, in other threads. False:
  /// the capture has to be read for itself.
  virtual bool join(DecodedCapture& capture) = 0;
};

/// Thrown by Host::check(). No std::exception: it must not look like a failure of one file.
struct Interrupted {};

/// The destination of a verb's messages, text and rows; the captures that it reads in addition to
/// files; and whether it continues. It has no state of a thread: verbs of two hosts can run at the
/// same time.
class Host {
 public:
  Host() = default;
  virtual ~Host() = default;
  Host(const Host&) = delete;
  Host& operator=(const Host&) = delete;

  /// A message: exactly one line, `biss: text`. Control characters are replaced, so that a file name
  /// cannot make two lines of it.
  virtual void warn(std::string_view text) = 0;
  /// Text of several lines in addition to the rows: a summary block. Control characters are
  /// replaced.
  virtual void print_summary(std::string_view text) = 0;
  /// warn(), then the status to return: `return host.fail(ExitStatus::io, "…");` An error names the
  /// fault, its place in the file, and the remedy.
  ExitStatus fail(ExitStatus status, std::string_view text) {
    warn(text);
    return status;
  }
  ExitStatus fail(const VerbError& error) { return fail(error.status, error.text); }

  /// Takes the text that the verb writes to standard output; null: the standard output of the
  /// process.
  virtual std::string* output() { return nullptr; }
  /// Takes the rows of a table without conversion; null: they are written as text.
  virtual std::unique_ptr<report::TableWriter> keep_rows(
      std::span<const report::Column> /*columns*/) {
    return nullptr;
  }
  /// Null if no capture is given by that name; the name then belongs to a file.
  virtual const GivenCapture* capture(const std::string& /*name*/) const { return nullptr; }
  /// Null if the verb reads its captures alone.
  virtual JointReading* joint_reading() { return nullptr; }
  /// Progress lines may be shown.
  virtual bool shows_progress() const { return false; }
  /// Throws Interrupted if the run has to end; in any thread. Progress::due() calls it, so that
  /// every long run checks it.
  virtual void check() {}
};

/// The command: standard output and standard error of the process.
class ProcessHost final : public Host {
 public:
  void warn(std::string_view text) override;
  void print_summary(std::string_view text) override;
  bool shows_progress() const override;
};

/// Keeps all output in memory: for programs other than the command, for verbs that run other verbs,
/// and for many captures that are read at the same time.
class MemoryHost : public Host {
 public:
  /// \param outer the host of the calling verb: its captures are available here, too, and its end
  /// also ends this run
  /// \param reading as joint_reading()
  explicit MemoryHost(Host* outer = nullptr, JointReading* reading = nullptr)
      : outer_(outer), reading_(reading) {}

  void warn(std::string_view text) override;
  void print_summary(std::string_view text) override;
  std::string* output() override { return &output_; }
  const GivenCapture* capture(const std::string& name) const override;
  JointReading* joint_reading() override { return reading_; }
  void check() override;

  void give(const std::string& name, GivenCapture capture) { captures_[name] = std::move(capture); }
  /// \param go_on called 50 times a second at most, and only in the thread that calls this; after
  /// false the run ends in every thread
  void set_go_on(std::function<bool()> go_on);

  /// The messages in the order in which they came, without `biss:`.
  const std::vector<std::string>& lines() const { return lines_; }
  /// The summaries, one after the other.
  const std::string& summary() const { return summary_; }
  /// Both, as the command prints them on standard error.
  const std::string& text() const { return text_; }
  /// The text written to standard output.
  const std::string& output_text() const { return output_; }

 private:
  Host* outer_;
  JointReading* reading_;
  std::map<std::string, GivenCapture> captures_;
  std::function<bool()> go_on_;
  std::thread::id asks_;
  std::chrono::steady_clock::time_point next_;
  std::atomic<bool> ended_ = false;
  std::vector<std::string> lines_;
  std::string summary_;
  std::string text_;
  std::string output_;
};

}  // namespace biss::verbs
