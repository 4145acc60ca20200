// The journal of an archive: the entry of each file that was read, as soon as it was read.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "archive/entry.hpp"
#include "verbs/common/host.hpp"

namespace biss::verbs {

/// A file of lines that only grows, so that a run that is killed at any time loses the line at its
/// end at most. One process at a time.
class Journal {
 public:
  /// True: the entry is used. Any other entry is no longer of use.
  using OnEntry = std::function<bool(archive::StampedEntry entry)>;

  explicit Journal(Host& host) : host_(host) {}
  ~Journal();
  Journal(const Journal&) = delete;
  Journal& operator=(const Journal&) = delete;

  /// Opens or makes the file and reads its content. Entries under another header are dropped, and
  /// if most lines are useless, the file is written again. Prints why it cannot: another process
  /// has it open, the file is not a journal, it cannot be written.
  ExitStatus open(const std::string& path, const std::string& header, const OnEntry& on_entry);

  /// Adds an entry. Prints why it cannot.
  ExitStatus append(const archive::StampedEntry& entry);

 private:
  struct Line {
    std::uint64_t begin = 0;
    std::uint64_t bytes = 0;
  };

  ExitStatus open_and_lock(const std::string& path);
  ExitStatus read_lines(const std::string& header, const OnEntry& on_entry);
  ExitStatus rewrite(const std::string& header);
  ExitStatus begin(const std::string& header);
  ExitStatus write(std::string_view text);
  ExitStatus fail_with(int cause) const;
  void close();

  Host& host_;
  std::string path_;
  int file_ = -1;
  std::vector<Line> used_;
  std::uint64_t unused_ = 0;
};

}  // namespace biss::verbs
