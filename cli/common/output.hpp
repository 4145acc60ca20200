// Where a verb's data goes: a file that is replaced as a whole, a pipe, a device, stdout.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "cli/common/exit_status.hpp"
#include "report/sink.hpp"

namespace biss::cli {

/// Output of the rule for `-o`:
/// * no path or `-` is stdout;
/// * a regular file, or a name where nothing is yet: the text goes to a temporary file beside it,
///   and finish() renames that to the target, so that there is the old file or the whole new one,
///   never half. A symbolic link stays, its target is replaced. A new file has the mode of any
///   created file (umask), one that is replaced keeps its mode. Without a good finish() the
///   temporary file is removed, by the destructor or by a signal that ends the process;
/// * anything else (pipe, device, /dev/fd/N) is written straight.
///
/// When the reader of a pipe has left (`biss … | head`), it has all it wanted: writes fail so that
/// the verb stops, nothing is said, and the status is `done`.
///
/// Not to be copied or moved; one thread at a time. SIGPIPE must be ignored, see prepare_process().
class Output final : public report::TextSink {
 public:
  Output() = default;
  ~Output() override;
  Output(const Output&) = delete;
  Output& operator=(const Output&) = delete;

  /// Opens the target; once. False when it cannot be written, error() says why.
  bool open(const std::string& path);

  /// Takes text; held back in blocks of 64 KiB. False once anything has failed.
  bool write(std::string_view text) override;

  /// Writes what is held back, closes and renames. False when any of it failed. Call it once, after
  /// all rows are in and everything else that could still fail has succeeded.
  bool finish();

  /// Ends without success, after an error elsewhere: what was written straight keeps all text taken
  /// so far, a file is left as it was before open(). The destructor does the same.
  void abandon();

  /// The reader of the pipe has left.
  bool reader_left() const { return reader_left_; }
  /// One line without the `biss:`; empty when nothing failed or only the reader left.
  const std::string& error() const { return error_; }
  /// done when nothing failed or the reader left; otherwise prints error() and is io.
  ExitStatus status() const;

  /// The output is a terminal that shows colour, and NO_COLOR is not set.
  bool wants_colour() const;
  /// The output is stdout.
  bool is_stdout() const { return name_ == "stdout"; }

 private:
  bool open_temporary(const std::string& target);
  bool write_through(std::string_view text);
  bool fail(std::string_view what, int cause);
  void discard();

  std::string name_;       // as the user calls it
  std::string target_;     // what the temporary file will replace; empty when written straight
  std::string temporary_;  // empty when there is none (any more)
  std::string held_;
  std::string error_;
  int descriptor_ = -1;
  bool owns_descriptor_ = false;
  bool failed_ = false;
  bool reader_left_ = false;
};

/// Once, at the start of the process: SIGPIPE is ignored; closed standard streams are reserved so
/// that no file takes their numbers; signals that end the process remove temporary files first.
void prepare_process();

}  // namespace biss::cli
