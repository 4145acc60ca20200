// The captures that a verb reads, one after the other, and MA and SLO in each.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "capture/edge_source.hpp"
#include "capture/pair_source.hpp"
#include "decode/lines.hpp"
#include "verbs/common/host.hpp"
#include "verbs/common/raw_samples.hpp"

namespace biss::verbs {

/// InputArguments::beginning of the command.
inline constexpr std::size_t edges_at_beginning = std::size_t{1} << 18U;

/// The options about captures and their lines.
struct InputArguments {
  std::vector<std::string> files;
  /// NAME, or FILE:NAME; empty when not given.
  std::string ma;
  std::string slo;
  /// Read every pair of MA and SLO, not one.
  bool each = false;
  /// If no lines look like MA and SLO, take the two busiest ones.
  bool any_lines = false;
  /// The verb has the option --each.
  bool has_each = false;
  /// The capture is one of many that the command line does not name: options for raw samples and
  /// voltages do not need to fit it.
  bool one_of_many = false;
  /// As OpenOptions::no_verify.
  bool no_verify = false;
  RawSamples raw;
  /// This much of the beginning of a capture is used to find MA and SLO, their polarity, the format
  /// and the rate of requests.
  std::size_t beginning = edges_at_beginning;
};

/// `FILE` of `FILE:NAME`; empty for a name without a file.
std::string file_of_line(const std::string& text);

/// How much of a file has been read: up to the furthest of its descriptors, because readers of
/// archives open it again.
struct ReadAmount {
  std::uint64_t read = 0;
  std::uint64_t all = 0;
};
/// Empty if the file has no size, like a pipe, or is not open. \param path `-` for standard input
std::optional<ReadAmount> read_amount(const std::string& path);

/// A file of the command line, and its reader once it is open.
struct CaptureFile {
  std::string path;
  std::unique_ptr<capture::EdgeSource> source = nullptr;
  /// Why it could not be opened.
  std::optional<capture::CaptureCause> cause = std::nullopt;
};

/// The files of each capture of a command line. Files are read as one capture if each has one line,
/// or if --ma and --slo name lines of different files; otherwise each file is a separate capture.
/// \param arguments also gets the files that --ma and --slo name
/// \return or the status, after printing the mistake in the command line, or the file that cannot be
///   read
tl::expected<std::vector<std::vector<CaptureFile>>, ExitStatus> list_captures(
    InputArguments& arguments, Host& host);

/// A capture: one file, or several that are read as one.
class CaptureInput {
 public:
  explicit CaptureInput(Host& host) : host_(&host) {}

  /// Opens what is not open yet. Prints why it cannot be read.
  ExitStatus open(std::vector<CaptureFile> files, InputArguments arguments);
  /// Opens the capture again from its beginning. Prints why it cannot.
  ExitStatus reopen();

  /// reopen() is possible: every file is a regular one.
  bool can_reopen() const;
  /// The bytes of the files that have a size; 0 if no file has a size.
  std::uint64_t bytes() const;

  /// Names of the lines; with several files FILE:NAME.
  const std::vector<std::string>& lines() const { return source_->lines(); }
  /// The name that the user gave; with several files FILE + FILE.
  const std::string& name() const { return name_; }

  /// MA and SLO: one pair, or every pair with `each`. If there is none, prints why: `usage` for a
  /// name that the capture does not have, `data_failed` if no lines or several pairs look like MA
  /// and SLO, `io` if reading failed.
  /// \param quiet prints nothing with `data_failed`
  tl::expected<std::vector<decode::FoundLines>, ExitStatus> find_lines(
      const decode::CycleReader& reader, bool quiet = false);
  /// MA alone.
  tl::expected<wire::LineIndex, ExitStatus> find_ma(const decode::CycleReader& reader);

  /// The first edges, at most InputArguments::beginning and one block; next() delivers them again.
  /// Valid until next().
  std::span<const wire::Edge> beginning();
  /// The next edges; empty at the end, or when reading failed: then error() is not empty.
  std::span<const wire::Edge> next();

  /// The remaining edges as arrays in pieces, in place of next(). Afterwards end_time() and error()
  /// refer to the pieces that are settled.
  capture::PairSource& pairs(const decode::Lines& lines);
  /// No piece of pairs() is left. False when reading failed; error() has the reason.
  bool end_pairs();

  Picoseconds end_time() const { return pairs_ ? pairs_->end_time() : source_->end_time(); }
  /// The same as EdgeSource::sample_period().
  Picoseconds sample_period() const { return source_->sample_period(); }
  /// The same as EdgeSource::sample_rate().
  Hertz sample_rate() const { return source_->sample_rate(); }
  /// The same as EdgeSource::is_analog().
  bool is_analog() const { return source_->is_analog(); }
  /// For a progress line: how much has been read in `seconds`, how fast, and the time left.
  std::string progress_text(double seconds) const;
  /// One line, empty while reading succeeds.
  const std::string& error() const { return error_; }
  /// Why the capture could not be opened, or not read further.
  const std::optional<capture::CaptureCause>& cause() const { return cause_; }

 private:
  std::string request_for(const std::string& text) const;
  std::span<const wire::Edge> pull();
  void note_error(const capture::CaptureError& error);
  ExitStatus report(const decode::LineError& error) const;

  Host* host_;
  InputArguments arguments_;
  std::vector<std::string> paths_;
  std::string name_;
  std::unique_ptr<capture::EdgeSource> source_;
  std::unique_ptr<capture::PairSource> pairs_;
  std::vector<wire::Edge> beginning_;
  enum class Beginning : std::uint8_t { unread, pending, delivered };
  Beginning state_ = Beginning::unread;
  bool failed_ = false;
  std::string error_;
  std::optional<capture::CaptureCause> cause_;
};

}  // namespace biss::verbs
