// The output of a verb: a file that is replaced as a whole, a pipe, a device, stdout.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "report/sink.hpp"
#include "report/table.hpp"
#include "verbs/common/host.hpp"
#include "verbs/common/temporary_file.hpp"

namespace biss::verbs {

/// The destination of a verb's data:
/// * no path or `-` is stdout;
/// * a regular file, or a name that is free: the text goes to a TemporaryFile, and finish() gives
///   this file the target's name. The target is always the old file or the whole new one. A
///   symbolic link stays, and its target is replaced. A new file has the mode of any created file
///   (umask); a replaced file keeps its mode. Without a successful finish() the target is
///   untouched;
/// * anything else (pipe, device, /dev/fd/N) is written directly.
///
/// On a terminal, control characters and characters that change the direction of writing are
/// replaced as by report::append_printable(), except line feeds and tabs: a name from a file cannot
/// control the terminal.
///
/// When the reader of a pipe has left (`biss … | head`), further text is dropped and no error is
/// reported: the verb completes its other outputs and its judgement. A verb with nothing else to do
/// checks reader_left() and ends.
///
/// It cannot be copied or moved; use it in one thread at a time. SIGPIPE must be ignored, see
/// prepare_process().
class Output final : public report::TextSink, private report::FileSink {
 public:
  /// \param host gets the messages; its standard output is the verb's
  explicit Output(Host& host) : host_(host) {}
  ~Output() override;
  Output(const Output&) = delete;
  Output& operator=(const Output&) = delete;

  /// Opens the target; once. False if it cannot be written; error() has the reason.
  bool open(const std::string& path);

  /// Takes text; writes it in blocks of 64 KiB. False once anything has failed.
  bool write(std::string_view text) override;
  bool write_printable(std::string_view text) override;

  /// From now on, a row is not held back for longer than 100 ms while others follow, unless the
  /// target is a file.
  void write_soon() { soon_ = !temporary_.exists(); }
  bool wants_lines() const override { return soon_; }

  /// The same target as a file that is written at any place, instead of write(); null if it is not
  /// a regular file.
  report::FileSink* file() { return temporary_.exists() ? this : nullptr; }

  /// Writes the rest and gives the file its name. False if any of this failed. Call it once, after
  /// all rows are in and everything else that can fail has succeeded.
  bool finish();

  /// Ends without success after another error: a target that is written directly keeps all text so
  /// far, and a file is left as it was before open(). The destructor does the same.
  void abandon();

  /// The reader of the pipe has left.
  bool reader_left() const { return reader_left_; }
  Host& host() const { return host_; }
  /// One line without the `biss:`; empty when nothing failed.
  const std::string& error() const { return error_; }
  /// `done` when nothing failed; otherwise prints error() and is `io`.
  ExitStatus status() const;

  /// How a table looks here: with colour on a terminal that shows it, unless NO_COLOR is set, and no
  /// wider than the terminal; a message on stderr names the columns left out.
  report::TableOptions table_options() const;

 private:
  bool write_at(std::uint64_t offset, std::span<const std::byte> bytes) override;
  bool read_at(std::uint64_t offset, std::span<std::byte> bytes) override;
  void fail(std::string_view cause) override;

  bool write_held();
  bool write_through(std::string_view text);
  bool write_bytes(std::string_view text);
  bool fail(std::string_view what, int cause);
  void close();

  Host& host_;
  std::string name_;  // as the user calls it
  TemporaryFile temporary_;
  std::string held_;
  std::string error_;
  int descriptor_ = -1;
  // Takes all text in place of a descriptor.
  std::string* text_ = nullptr;
  bool owns_descriptor_ = false;
  bool is_terminal_ = false;
  bool reader_left_ = false;
  bool soon_ = false;
  std::chrono::steady_clock::time_point written_{};
};

/// Opens the target, calls write(output), which returns false on failure, and finishes.
/// \return `done`, or `io` after a message
template <class Write>
ExitStatus write_output(Host& host, const std::string& path, const Write& write) {
  Output output(host);
  return output.open(path) && write(output) && output.finish() ? ExitStatus::done : output.status();
}

/// Columns of the terminal that the text without a file goes to; 0 if it goes to none.
std::size_t output_columns(Host& host);

/// Once, at the start of the process: ignores SIGPIPE, reserves closed standard streams so that no
/// file takes their numbers, and has signals remove temporary files before they end the process.
void prepare_process();

}  // namespace biss::verbs
