// A run of `biss decode`: its options, and the rows of each capture.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "decode/limits.hpp"
#include "decode/safety_watch.hpp"
#include "decode/statistics.hpp"
#include "rows/motion.hpp"
#include "rows/table.hpp"
#include "verbs/common/decoded_capture.hpp"
#include "verbs/common/table_output.hpp"
#include "verbs/decode/fail_on.hpp"
#include "verbs/decode/motion_options.hpp"
#include "verbs/decode/safety.hpp"

namespace biss::verbs {

struct DecodeOptions {
  CaptureArguments capture;
  SafetyArguments safety;
  FailOn fail_on;
  std::string output;
  report::Format to = report::Format::table;
  std::vector<std::string> columns;
  bool only_errors = false;
  std::uint64_t every = 1;
  MotionArguments motion;
};

/// The help of the verb.
VerbText decode_text();
/// Declares all options of the verb. \pre options outlives the parsing
void add_decode_options(Verb verb, DecodeOptions& options);
/// The part that is not about captures: --fail-on, the choice of rows and columns, motion, -o, --to.
void add_judged_row_options(Verb verb, DecodeOptions& options);

/// One run of the verb; it must live as long as its rows. Either run(), or in steps:
///
///     if (run.open() == ExitStatus::done && run.next() == ExitStatus::done) {
///       … a writer for run.columns()
///       run.begin_rows();
///       … run.take(number, cycle, writer) for each cycle of run.capture()
///       run.end_rows(read, messages);
///     }
class DecodeRun {
 public:
  /// \param options outlive the run
  DecodeRun(const DecodeOptions& options, Host& host) : options_(options), host_(host) {}

  ExitStatus run();

  /// Prints why the command line makes no sense.
  ExitStatus open();
  /// Goes to the first capture. Prints why there is none.
  ExitStatus next();
  /// \pre next() was done
  const std::vector<report::Column>& columns();
  /// Before the first cycle of a capture. Prints what is wrong.
  ExitStatus begin_rows();
  /// Writes the row of a cycle, if it is wanted. False when no further row is of use.
  bool take(std::uint64_t number, const decode::Cycle& cycle, report::TableWriter& writer);
  /// The cycle taken last is one that --only-errors writes.
  bool took_error() const { return now_.took_error; }
  /// After the last cycle. \param read the capture was read to its end
  ExitStatus end_rows(bool read, RunMessages& messages);
  /// The summary of the cycles taken so far.
  std::string summary() const;
  DecodedCapture& capture() { return capture_; }

 private:
  std::string needs_times() const;
  rows::DecodeTable table_of_capture() const;
  void choose_table();
  std::string choose_monitor();
  std::string choose_motion();
  ExitStatus write_rows(report::TableWriter& writer, RunMessages& messages);
  rows::MotionValues take_position(std::uint64_t number, const decode::Cycle& cycle);
  void report_motion(RunMessages& messages) const;
  bool has_request() const;
  const decode::SafetyWatch* safety() const { return now_.safety ? &*now_.safety : nullptr; }

  const DecodeOptions& options_;
  Host& host_;
  DecodedCapture capture_{host_};
  std::optional<rows::DecodeTable> table_;
  // The state for the current capture: each capture begins with a new one.
  struct OfCapture {
    decode::Statistics statistics;
    std::optional<decode::LimitWatch> limits;
    std::optional<decode::SafetyWatch> safety;
    std::string safety_name;
    std::uint64_t outside = 0;
    std::optional<rows::Motion> motion;
    // The first cycle with an unknown unwrapped position.
    std::optional<std::uint64_t> lost;
    // The position is known, but too large for 64 bits with a sign.
    bool beyond = false;
    // Rows without a velocity, because the distance to them is not certain.
    std::uint64_t uncertain = 0;
    // Rows that --every counts.
    std::uint64_t written = 0;
    bool before_zero = false;
    bool took_error = false;
  };
  OfCapture now_;
};

}  // namespace biss::verbs
