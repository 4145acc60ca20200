// A file of lines that only grows, so that a run that is killed at any time loses the line at its end
// at most. One process at a time.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "verbs/common/host.hpp"
#include "verbs/common/output.hpp"

namespace biss::verbs {

/// Which files are journals of a verb, and of this run.
struct JournalKind {
  std::string owner;   ///< `biss archive`
  std::string begins;  ///< the beginning of each header
  std::string header;  ///< the first line
  /// A journal with another header is refused with this text; empty: it begins again.
  std::string refusal{};
};

/// Every function throws a VerbError if it cannot.
class Journal {
 public:
  /// Gets each line after the header. True: it is used. Any other line is no longer of use.
  using OnLine = std::function<bool(std::string_view line)>;

  explicit Journal(Host& host) : host_(host) {}
  ~Journal() { close(); }
  Journal(const Journal&) = delete;
  Journal& operator=(const Journal&) = delete;

  /// Opens or makes the file and reads its lines; if most of them are useless, the file is written
  /// again. Fails also if another process has it open, or it is not a journal of this kind.
  void open(const std::string& path, JournalKind kind, const OnLine& on_line);
  bool is_open() const { return file_ >= 0; }

  void append(std::string_view line);
  /// Replaces all lines by this one.
  void replace(std::string_view line);
  std::uint64_t bytes() const { return bytes_; }

 private:
  struct Line {
    std::uint64_t begin = 0;
    std::uint64_t bytes = 0;
  };

  void open_and_lock();
  void read_lines(const OnLine& on_line);
  void begin();
  void rewrite(const std::function<bool(Output&)>& write_lines);
  bool copy_used(Output& output) const;
  void write(std::string_view text);
  [[noreturn]] void fail(const std::string& why) const;
  [[noreturn]] void fail_with(int cause) const;
  void close();

  Host& host_;
  std::string path_;
  JournalKind kind_;
  int file_ = -1;
  std::uint64_t bytes_ = 0;
  std::vector<Line> used_;
  std::uint64_t unused_ = 0;
};

}  // namespace biss::verbs
