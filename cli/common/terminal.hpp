// What the command shows on a terminal only: how far a long run is, and how wide tables may be.
#pragma once

#include <chrono>
#include <cstddef>
#include <string_view>

namespace biss::cli {

/// Columns of the terminal that `descriptor` is; 0 when it is none, or its width is not known.
std::size_t terminal_columns(int descriptor);

/// One line on stderr that a long run replaces as it goes on:
///
///     Progress progress;
///     while (…) if (progress.due()) progress.show(fmt::format("{} of {} blocks", done, all));
///
/// Nothing is shown when stderr is no terminal, nor in the first second. One thread at a time. The
/// destructor removes the line.
class Progress {
 public:
  Progress();
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// True five times a second at most: time to call show(). Cheap enough for every block.
  bool due();
  void show(std::string_view text);

 private:
  std::chrono::steady_clock::time_point next_;
  bool wanted_;
};

/// Removes the progress line, if there is one. To be called before anything else is written to the
/// terminal.
void clear_progress();

}  // namespace biss::cli
