// The figures of an archive: what each file is, and the sums of each encoder. The summaries of all
// parts add up to the summary of the whole, byte for byte.
#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <istream>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <tl/expected.hpp>
#include <utility>
#include <vector>

#include "archive/entry.hpp"
#include "report/sink.hpp"

namespace biss::archive {

/// The settings that two summaries must share, so that their figures mean the same.
struct Setup {
  /// The program and its version.
  std::string program;
  /// The options that decide how captures are read, as typed.
  std::vector<std::string> settings;
  bool operator==(const Setup&) const = default;
};

/// The line that a journal begins with.
std::string journal_header(const Setup& setup);

/// Files named *.json and *.journal that begin with this were written by this program.
inline constexpr std::string_view own_files_begin = R"({"biss_archive)";

/// Names a list of files, in any order: how many, and the sum of the hashes of their paths.
struct ListMark {
  std::uint64_t files = 0;
  std::uint64_t hash = 0;

  auto operator<=>(const ListMark&) const = default;
  void add(std::string_view path);
  void add(const ListMark& other);
};

/// Which parts of a list are in a summary: part k of n holds the files k, k + n, k + 2n, …, counted
/// from 1.
struct Parts {
  std::uint64_t count = 1;
  std::set<std::uint64_t> done;

  bool complete() const { return done.size() == count; }
  /// The numbers of the first ones that are missing: `3, 5`.
  std::string missing() const;
  /// The files of these parts of a list.
  std::uint64_t files_of(std::uint64_t all) const;
};

/// An encoder: the links in the captures of one folder with the same line names and frame format.
struct GroupKey {
  std::string folder;
  std::string ma;
  std::string slo;
  std::string format;
  auto operator<=>(const GroupKey&) const = default;
};
GroupKey group_of(const FileEntry& file, const LinkEntry& link);

struct Group {
  std::uint64_t captures = 0;
  Counts counts;
  /// By Quantity.
  std::array<Histogram, quantity_count> histograms;

  void add(const Group& other);
};

struct Summary {
  Setup setup;
  /// The whole list, even if some of its parts are missing.
  ListMark list;
  Parts parts;
  std::vector<FileEntry> files;
  std::map<GroupKey, Group> groups;

  /// Takes the histograms out of the entry.
  void add(FileEntry entry);
};

/// The sums of all files.
struct Totals {
  std::array<std::uint64_t, 3> by_reading{};
  std::uint64_t bytes = 0;
  std::uint64_t links = 0;
  Counts counts;
  std::map<std::string, std::uint64_t> causes;
};

Totals totals_of(const Summary& summary);

/// A summary and the user's name for it.
using NamedSummary = std::pair<std::string, Summary>;

/// Adds up parts of one list of files, and complete lists that have no file in common.
/// \param parts at least one
/// \return the sum; if parts of the only list are missing, the sum of the others. Else one line:
///   which file does not fit, and why
tl::expected<Summary, std::string> merge(std::vector<NamedSummary> parts);

/// Writes the summary as JSON, in the order of its files: see is_worse(). False when the sink has failed.
bool write_summary(const Summary& summary, report::TextSink& sink);

/// Reads the text of write_summary(). Sums are compared with the files, and files with the list.
/// \return the summary, or the cause why the text is not a summary
tl::expected<Summary, std::string> read_summary(std::istream& text);

// ---- How a quantity changes over the days of an archive.

/// The value of a quantity in one capture.
struct DatedValue {
  Day day = 0;
  std::int64_t value = 0;
};

/// The slope of the line of least squares through the values, in units a year of 365 days, rounded.
/// Nothing if all values are of one day. The result is exact, so it is the same on every machine.
/// Values above 2^53 count as 2^53.
std::optional<std::int64_t> change_per_year(std::span<const DatedValue> values);

/// A link of a capture, and the file it is in, which has a day.
struct PlacedLink {
  const FileEntry* file = nullptr;
  const LinkEntry* link = nullptr;
};

/// The medians of a quantity, a value for each capture that has it.
std::vector<DatedValue> medians_of(std::span<const PlacedLink> captures, Quantity quantity);
/// Faults in a million cycles, a value for each capture with cycles.
std::vector<DatedValue> fault_rates_of(std::span<const PlacedLink> captures);

/// The links of each group, in the order of the files.
std::map<GroupKey, std::vector<PlacedLink>> captures_of(const Summary& summary);

}  // namespace biss::archive
