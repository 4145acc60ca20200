// The log of `biss read --record`: a line for each transfer, its time and its bytes.
#pragma once

#include <chrono>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "biss/base/units.hpp"
#include "verbs/common/host.hpp"

namespace biss::cli {

/// Written as it comes, so that it is there up to the last tenth of a second whatever ends this
/// program. A disk that is full ends the log and not the reading.
class Record {
 public:
  /// Throws a VerbError if the file cannot be written.
  Record(const std::string& path, verbs::Host& host);
  ~Record();
  Record(const Record&) = delete;
  Record& operator=(const Record&) = delete;

  const std::string& path() const { return path_; }
  void add(Picoseconds time, std::span<const std::uint8_t> bytes);
  /// A line that is not a transfer, written at once.
  void comment(std::string_view text);
  /// Writes the rest. False if a line is missing; the reason was printed.
  bool finish();

 private:
  void write();
  void end(std::size_t done);

  std::string path_;
  verbs::Host& host_;
  int descriptor_ = -1;
  std::string held_;
  std::size_t size_ = 0;  // of the lines that are written
  bool ended_ = false;
  std::uint64_t lost_ = 0;
  std::chrono::steady_clock::time_point written_{};
};

}  // namespace biss::cli
