// The results of one file of an archive.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <utility>
#include <vector>

#include "decode/distribution.hpp"
#include "decode/statistics.hpp"

namespace biss::archive {

/// Days since 1970-01-01.
using Day = std::int32_t;

/// The last date in a path, of a folder or of the file: `2024-03-17`, `2024_03_17`, `2024.03.17`,
/// `2024/03/17`, `20240317`, also followed by a time of six digits. Years 1990 to 2099.
std::optional<Day> day_in(std::string_view path);

/// \param time nanoseconds since 1970-01-01 00:00 UTC
Day day_of(std::int64_t time);

/// `2024-03-17`.
std::string day_text(Day day);
/// Reads the text of day_text(); nothing if it is not a date.
std::optional<Day> day_from(std::string_view text);

/// Non-negative values. Minimum and maximum are exact, the others within 0.1 %. The sum of two
/// histograms is the histogram of the values of both, in any order.
class Histogram {
 public:
  /// The smallest possible value of a bucket, and how many values it has.
  using Bucket = std::pair<std::int64_t, std::uint64_t>;

  Histogram() = default;
  explicit Histogram(const decode::Distribution& values);

  bool operator==(const Histogram&) const = default;
  void add(const Histogram& other);

  std::uint64_t count() const { return count_; }
  /// \pre count() > 0
  std::int64_t min() const { return min_; }
  std::int64_t max() const { return max_; }
  /// The lower median. \pre count() > 0
  std::int64_t median() const;

  const std::map<std::int64_t, std::uint64_t>& buckets() const { return buckets_; }
  /// The histogram of these buckets, as read from a file.
  /// \return false, and nothing changes, if the buckets are not valid: out of order or empty,
  ///   limits outside of the first and the last bucket, more than 2^64 values
  [[nodiscard]] bool assign(const std::vector<Bucket>& buckets, std::int64_t min, std::int64_t max);

 private:
  std::map<std::int64_t, std::uint64_t> buckets_;
  std::uint64_t count_ = 0;
  std::int64_t min_ = 0;
  std::int64_t max_ = 0;
};

using decode::Counts;

/// The quantities that are measured in the cycles of a capture. Times are in picoseconds.
enum class Quantity : std::uint8_t { period, interval, line_delay, ack, ack_clocks, duty };

inline constexpr std::size_t quantity_count = 6;

/// Users and scripts see the names; docs/archive.md explains each.
constexpr std::string_view name_of(Quantity quantity) {
  constexpr std::array<std::string_view, quantity_count> names{
      "period_ps", "interval_ps", "line_delay_ps", "ack_ps", "ack_clocks", "duty_per_mille"};
  return names[static_cast<std::size_t>(quantity)];
}

/// A measured quantity in one capture.
struct Range {
  std::int64_t min = 0;
  /// The same as decode::Distribution::median().
  std::int64_t median = 0;
  std::int64_t max = 0;
  bool operator==(const Range&) const = default;
};

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
