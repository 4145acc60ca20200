// The state file of `biss watch`: lines of JSON. The header has the options, a snapshot all figures;
// after that a line for each interval, and for each second within one.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include "live/link_health.hpp"

namespace biss::cli {

/// How much of a file was watched.
struct FileMark {
  std::uint64_t bytes = 0;
  std::int64_t time = 0;  ///< of the last change, in nanoseconds since 1970
  std::uint64_t cycles = 0;
};

/// The beginning of each state file.
inline constexpr std::string_view state_begins = R"({"biss_watch":1,)";

struct SavedHealth {
  SavedHealth(live::HealthSetup of, std::string options)
      : setup(of), settings(std::move(options)), health(of) {}
  /// Reads a header. Throws a std::exception if the line is not a header.
  static SavedHealth from_header(std::string_view line);

  std::string header() const;
  /// All figures.
  std::string snapshot() const;
  /// The figures that change within an interval, and a whole interval if there is one.
  std::string progress(std::uint64_t file, const live::HealthPoint* interval = nullptr) const;
  /// Takes a line of snapshot() or progress(). Throws a std::exception if it is neither.
  void take_line(std::string_view line);

  live::HealthSetup setup;
  /// The options by which cycles are read.
  std::string settings;
  live::LinkHealth health;
  /// By the hash of the path and the number of the file in its file system.
  std::map<std::uint64_t, FileMark> files;
};

}  // namespace biss::cli
