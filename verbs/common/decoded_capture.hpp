// A capture read down to its request cycles, for the verbs that look at all of them.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "decode/cycle.hpp"
#include "decode/decoder.hpp"
#include "flow/cycle_flow.hpp"
#include "identify/collector.hpp"
#include "identify/format.hpp"
#include "identify/protocol.hpp"
#include "report/table.hpp"
#include "verbs/common/capture_input.hpp"
#include "verbs/common/fields.hpp"
#include "verbs/common/format_option.hpp"
#include "verbs/common/verb.hpp"
#include "verbs/common/word_log.hpp"

namespace biss::verbs {

/// The options about captures and the device in them.
struct CaptureArguments : InputArguments {
  FormatArguments device;
  /// The capture shows the inverse of the line. If the option is not given, the polarity is
  /// measured.
  bool invert_ma = false;
  bool invert_slo = false;
  /// When not given, the sample period of the capture, or 0.
  std::optional<Picoseconds> resolution;
  /// If no format is given, use the format that the frames show.
  bool identify = false;
  /// If a format is given, also find the format that the frames show.
  bool identify_besides = false;
  /// Also deliver a capture in which no lines are MA and SLO; has_lines() is then false.
  bool keep_unknown = false;
  /// Threads that read the cycles; 0: one for each processor of the machine.
  std::uint64_t threads = 0;
  /// Words in place of a capture.
  WordArguments words;
  /// Only the cycles that begin within these times are read; their numbers stay.
  std::optional<Picoseconds> since;
  std::optional<Picoseconds> until;
  /// `marginal` is judged for a master without compensation of the line delay.
  bool no_compensation = false;
  /// Also measure Cycle::signal.
  bool signal = false;
  /// Takes the place of the timing that a name in `device` has; the options override it.
  std::optional<DeviceTiming> timing;
};

/// FILE…, -f, --ma, --slo, --invert-ma, --invert-slo, --each, --resolution, the timing and the raw
/// options.
/// \param finds_format the verb identifies the format itself; the help states this
void add_capture_options(Verb verb, CaptureArguments& arguments, bool finds_format = false);
/// The same without --each, for a verb that declares FILE… itself.
void add_reading_options(Verb verb, CaptureArguments& arguments);

/// --since and --until, for the verbs that only read the cycles between them.
void add_range_options(Verb verb, CaptureArguments& arguments);

/// The captures of a command line, decoded one after the other:
///
///     DecodedCapture capture(host);
///     const ExitStatus opened = capture.open(…);
///     if (opened != ExitStatus::done) return opened;
///     return write_captures(capture, …, [&](report::TableWriter& writer, RunMessages& messages) {
///       capture.read(…);
///     });
class DecodedCapture {
 public:
  /// False ends the reading.
  using OnCycle = std::function<bool(std::uint64_t number, const decode::Cycle& cycle)>;

  explicit DecodedCapture(Host& host) : host_(host), input_(host) {}
  Host& host() const { return host_; }

  /// Prints why the command line makes no sense.
  ExitStatus open(const CaptureArguments& arguments);

  const CaptureArguments& arguments() const { return arguments_; }

  /// Goes to the next capture, or with --each to the next pair of lines of the same one. Prints why
  /// a capture is left out, and tries the next one. False at the end, or when a file cannot be
  /// read.
  bool next();
  /// The files that next() has not reached.
  std::vector<std::string> files_left() const;
  /// The worst status of the captures that next() left out.
  ExitStatus status() const { return status_; }

  /// More than one capture or pair of lines may be read.
  bool several() const { return captures_.size() > 1 || arguments_.each; }
  /// Columns that name the capture and the lines of a row, with their cells: `file` if there are
  /// several captures, `ma` and `slo` with --each; otherwise none. \pre next() was true
  FieldRow fields() const;

  /// Reads to the end, with a progress line.
  /// \param watcher sees the changes that are read; null: none
  /// \return false if reading failed; input().error() then has the reason, and the cycles before
  ///   the failure have been delivered
  bool read(const OnCycle& on_cycle, flow::ChangeWatcher* watcher = nullptr);
  /// read() in steps, without a progress line and in this thread: begin_steps(), then step() until it
  /// is false, then end_steps(), which returns as read().
  void begin_steps(OnCycle on_cycle, flow::ChangeWatcher* watcher = nullptr);
  bool step();
  bool end_steps();
  /// The end of the capture. \pre read() has returned
  Picoseconds end_time() const { return end_time_; }
  /// Reads the edges alone, in place of read(), until `on_edges` returns false.
  /// \return as read()
  bool read_edges(const std::function<bool(std::span<const wire::Edge>)>& on_edges);
  /// The same as CaptureInput::beginning(). \pre next() was true and nothing has been read since
  std::span<const wire::Edge> beginning() { return input_.beginning(); }
  /// A reader of cycles as read() uses it.
  decode::CycleReader reader() const {
    return decode::CycleReader(format_, reading_timing(), margin_);
  }
  /// The timing by which cycles are read: if no format was given, with the timeout that the capture
  /// shows if the master pauses its clock.
  DeviceTiming reading_timing() const;
  /// The protocol of the lines at the beginning of the capture. \pre next() was true and read() has
  /// not been called since
  identify::ProtocolGuess protocol();

  // For a JointReading, while this capture waits in read().
  /// The next cycle of the capture.
  void take(const decode::Cycle& cycle);
  flow::ChangeWatcher* watcher() const { return watcher_; }
  void set_end_time(Picoseconds end_time) { end_time_ = end_time; }
  /// The cycles that `other` reads are the cycles that this one would read.
  bool reads_as(const DecodedCapture& other) const;

  /// Whether the cycle begins between --since and --until.
  bool is_wanted(const decode::Cycle& cycle) const;
  /// One line for users: no cycle was found, and what to check.
  std::string no_request() const;

  /// Empty if no format was given and none was identified: frames are then judged by their
  /// structure alone.
  const std::optional<FrameFormat>& format() const { return format_; }
  /// The format that the frames of this capture show; null if not requested. If no format was
  /// given, format() is the first candidate if it is certain.
  const identify::FormatFinding* finding() const { return finding_ ? &*finding_ : nullptr; }
  /// If the frames change their length: each format, and its cycles; otherwise empty.
  const std::string& format_parts() const { return format_parts_; }
  /// The format that is certain; null if its checksums have the same verdicts as the checksums of the
  /// given format.
  const identify::FormatCandidate* better_format() const;
  /// Does not use the format that was identified.
  void judge_structure() { format_.reset(); }
  /// Reads these lines, in this polarity. \pre as beginning()
  void read_as(const decode::Lines& lines) { pairs_[pair_].lines = lines; }
  /// Uses this format for the capture at hand. \pre as beginning()
  void judge_by(const FrameFormat& format) { format_ = format; }
  const DeviceTiming& timing() const { return timing_; }
  const decode::MarginSetup& margin() const { return margin_; }
  const CaptureInput& input() const { return input_; }
  CaptureInput& input() { return input_; }
  /// The capture or the log of words, for a message.
  std::string name() const { return words() != nullptr ? words()->file : input_.name(); }
  /// The words that are read in place of a capture; null for a capture.
  const WordArguments* words() const {
    return arguments_.words.file.empty() ? nullptr : &arguments_.words;
  }
  /// The cycle that was read last has a time.
  bool timed() const { return timed_; }
  /// The same as verbs::fitting_options(), if at most half of the words are good frames; else empty.
  std::string fitting_options() const;
  bool has_lines() const { return !pairs_.empty(); }
  const decode::FoundLines& lines() const { return pairs_[pair_]; }
  const std::string& ma_name() const { return input_.lines()[lines().lines.ma]; }
  const std::string& slo_name() const { return input_.lines()[lines().lines.slo]; }
  /// The median time from request to request at the beginning of the capture; 0 if there is none.
  /// \pre next() was true and read() has not been called since
  Picoseconds interval();

 private:
  void begin_reading(OnCycle on_cycle, flow::ChangeWatcher* watcher);
  bool identifies() const { return arguments_.identify && arguments_.device.format.empty(); }
  bool open_next();
  bool open_words();
  void take_words(std::size_t count);
  void count(const decode::Cycle& cycle);
  bool read_log(const decode::CycleReader& reader, const OnCycle& on_cycle);
  bool read_words(const decode::CycleReader& reader, const OnCycle& on_cycle);
  void warn_of_protocol();
  ExitStatus identify_format();
  ExitStatus identify_from_all();
  std::size_t collect_frames(bool all, identify::SampleCollector& frames);
  void take_finding(std::span<const identify::Sample> samples);
  void warn_of_contradictions();
  void measure_polarity(decode::FoundLines& found);

  Host& host_;
  CaptureArguments arguments_;
  std::optional<FrameFormat> format_;
  DeviceTiming timing_;
  std::optional<identify::FormatFinding> finding_;
  bool finding_agrees_ = false;
  std::string format_parts_;
  std::optional<Timeout> paused_timeout_;
  // Cycles that read() has left out.
  std::uint64_t outside_ = 0;
  // Cycles with a good frame, and cycles with a frame that does not fit the format.
  std::uint64_t good_ = 0;
  std::uint64_t contradict_ = 0;
  decode::MarginSetup margin_;
  std::vector<std::vector<CaptureFile>> captures_;
  // The place of the next one.
  std::size_t next_capture_ = 0;
  CaptureInput input_;
  std::vector<LoggedWord> log_;
  bool timed_ = true;
  std::vector<decode::FoundLines> pairs_;
  std::size_t pair_ = 0;
  // The reading of the current capture.
  OnCycle on_cycle_;
  std::uint64_t number_ = 0;
  bool wanted_ = true;
  std::optional<decode::Decoder> decoder_;
  std::optional<flow::CycleFlow> flow_;
  flow::ChangeWatcher* watcher_ = nullptr;
  Picoseconds end_time_{};
  ExitStatus status_ = ExitStatus::done;
};

}  // namespace biss::verbs
