// The results of one file of an archive.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "archive/date.hpp"
#include "archive/figures.hpp"
#include "archive/histogram.hpp"

namespace biss::archive {

/// A pair of MA and SLO in a capture.
struct LinkEntry {
  std::string ma;
  std::string slo;
  /// The frame format in its canonical text; empty if it is not known.
  std::string format;
  /// Encoders of the catalogue that the frames can be from.
  std::vector<std::string> encoders;
  /// The format of the frames if it differs from the given one; else empty.
  std::string other_format;
  Counts counts;
  /// By Quantity; absent if the quantity was not seen.
  std::array<std::optional<Range>, quantity_count> ranges;
  /// By Quantity. Empty in a summary: there, the histograms of each group hold the values.
  std::vector<Histogram> histograms;

  bool operator==(const LinkEntry&) const = default;
};

/// How much of a file was read.
enum class Reading : std::uint8_t {
  whole,
  part,  ///< the cycles before the cause are counted
  none,
};

constexpr std::string_view name_of(Reading reading) {
  constexpr std::array<std::string_view, 3> names{"whole", "part", "none"};
  return names[static_cast<std::size_t>(reading)];
}

/// Texts are valid UTF-8, see utf8_text().
struct FileEntry {
  std::string path;
  /// The hash of the path without links, from the root on: a file has one hash, whatever its names.
  /// 0: not computed.
  std::uint64_t place = 0;
  std::uint64_t bytes = 0;
  /// Absent if there is no file, for example at the end of a broken link.
  std::optional<Day> day;
  /// The day is from the path; else it is the day on which the file was last changed.
  bool dated_by_path = false;
  Reading reading = Reading::none;
  /// Why it was not read, or not to its end: one name for each cause, listed in docs/archive.md.
  /// Empty with Reading::whole.
  std::string cause;
  /// The same cause as a sentence.
  std::string message;
  std::vector<LinkEntry> links;

  bool operator==(const FileEntry&) const = default;
  /// A fault of the file or its links makes it a capture to examine. Files that hold no BiSS C at
  /// all have no finding.
  bool has_finding() const;
};

/// A capture without links that has this cause is not a capture of BiSS C, not a damaged one.
bool is_foreign(std::string_view cause);

/// `a` is worse than `b`: captures with a finding by the share of their faults, errors, limits,
/// marginal cycles and warnings; then damaged files of which nothing was read; then captures with
/// cycles that were not checked, because the format is not known; then good ones; foreign files
/// last. Equal captures are ordered by path.
bool is_worse(const FileEntry& a, const FileEntry& b);

/// Valid UTF-8, different for different texts. If the text is not UTF-8 or contains `\x`, the
/// invalid bytes and each backslash are written as `\xNN`.
std::string utf8_text(std::string_view text);

/// The state of a file when it was read. If both values are the same later, the file has not
/// changed.
struct FileStamp {
  std::uint64_t bytes = 0;
  /// Time of the last change, in nanoseconds since 1970.
  std::int64_t time = 0;
  bool operator==(const FileStamp&) const = default;
};

struct StampedEntry {
  FileStamp stamp;
  FileEntry entry;
};

/// One line without a line feed, with a checksum.
std::string journal_line(const StampedEntry& entry);
/// Reads the text of journal_line(); the cause if the line is damaged.
tl::expected<StampedEntry, std::string> read_journal_line(std::string_view line);

}  // namespace biss::archive
