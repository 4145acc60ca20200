// Output for terminals only: the progress of a long run, and the width of tables.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace biss::verbs {

class Host;

/// The width of the terminal `descriptor` in columns; 0 if it is not a terminal, or its width is
/// unknown.
std::size_t terminal_columns(int descriptor);

/// Printable text, cut off at this many columns of a terminal.
std::string cut_off(std::string_view text, std::size_t columns);

/// One line on stderr that a long run replaces while it runs:
///
///     Progress progress(host);
///     while (…) if (progress.due()) progress.show(fmt::format("{} of {} blocks", done, all));
///
/// Nothing is shown when stderr is not a terminal, nor in the first second. One thread at a time.
/// The destructor removes the line.
class Progress {
 public:
  explicit Progress(Host& host);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// True five times a second at most: time to call show(). Cheap enough for every block.
  /// Throws as Host::check().
  bool due();
  void show(std::string_view text);
  /// Since it exists.
  double seconds() const;

 private:
  Host& host_;
  std::chrono::steady_clock::time_point began_;
  std::chrono::steady_clock::time_point next_;
  bool wanted_;
};

/// The end of a progress line: `, 1.25 M cycles/s`, `, 210.00 MB/s`; empty if there is no rate.
std::string rate_text(double per_second, std::string_view unit);
/// The end of a progress line: `, 0:12 left`, `, 1:02:03 left`; empty if the time is unknown, or
/// above 100 days.
std::string left_text(double seconds);

/// The progress of a run; `all` is 0 if unknown, `before` is the part done when the run began.
struct ProgressCount {
  std::uint64_t done = 0;
  std::uint64_t all = 0;
  std::uint64_t before = 0;
};
/// `312 of 1000 frames, 85.3 frames/s, 0:08 left`.
std::string progress_text(const ProgressCount& count, std::string_view unit, double seconds);

/// Removes the progress line, if there is one. To be called before anything else is written to the
/// terminal.
void clear_progress();

}  // namespace biss::verbs
