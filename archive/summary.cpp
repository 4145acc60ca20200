#include "archive/summary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "archive/hash.hpp"
#include "archive/json.hpp"

namespace biss::archive {

std::string journal_header(const Setup& setup) {
  return Json{{"biss_archive_journal", 1}, {"program", setup.program}, {"settings", setup.settings}}
      .dump();
}

void ListMark::add(std::string_view path) {
  ++files;
  hash += hash_of(path);
}

void ListMark::add(const ListMark& other) {
  files += other.files;
  hash += other.hash;
}

std::uint64_t Parts::files_of(std::uint64_t all) const {
  std::uint64_t sum = 0;
  for (const std::uint64_t part : done) sum += all / count + (part <= all % count ? 1 : 0);
  return sum;
}

std::string Parts::missing() const {
  constexpr std::size_t most = 8;
  std::string text;
  std::size_t named = 0;
  for (std::uint64_t part = 1; part <= count && named <= most; ++part) {
    if (done.contains(part)) continue;
    text += named == most ? ", ..." : fmt::format("{}{}", named == 0 ? "" : ", ", part);
    ++named;
  }
  return text;
}

GroupKey group_of(const FileEntry& file, const LinkEntry& link) {
  const std::size_t slash = file.path.rfind('/');
  std::string folder = ".";
  if (slash != std::string::npos) folder = slash == 0 ? "/" : file.path.substr(0, slash);
  return {std::move(folder), link.ma, link.slo, link.format};
}

void Group::add(const Group& other) {
  captures += other.captures;
  counts.add(other.counts);
  for (std::size_t i = 0; i < quantity_count; ++i) histograms[i].add(other.histograms[i]);
}

void Summary::add(FileEntry entry) {
  for (LinkEntry& link : entry.links) {
    Group& group = groups[group_of(entry, link)];
    ++group.captures;
    group.counts.add(link.counts);
    for (std::size_t i = 0; i < link.histograms.size(); ++i) {
      group.histograms[i].add(link.histograms[i]);
    }
    link.histograms = {};
  }
  files.push_back(std::move(entry));
}

Totals totals_of(const Summary& summary) {
  Totals totals;
  for (const FileEntry& file : summary.files) {
    ++totals.by_reading[static_cast<std::size_t>(file.reading)];
    totals.bytes += file.bytes;
    totals.links += file.links.size();
    for (const LinkEntry& link : file.links) totals.counts.add(link.counts);
    if (!file.cause.empty()) ++totals.causes[file.cause];
  }
  return totals;
}

std::map<GroupKey, std::vector<PlacedLink>> captures_of(const Summary& summary) {
  std::map<GroupKey, std::vector<PlacedLink>> captures;
  for (const FileEntry& file : summary.files) {
    for (const LinkEntry& link : file.links) {
      captures[group_of(file, link)].push_back({&file, &link});
    }
  }
  return captures;
}

namespace {

using ListKey = std::pair<ListMark, std::uint64_t>;

// The names of a file that occurs twice, by path or by place; empty if there is no such file.
std::string file_of_two(const std::vector<FileEntry>& files) {
  std::vector<const FileEntry*> sorted;
  for (const FileEntry& file : files) sorted.push_back(&file);
  const auto twice_by = [&](auto of) {
    std::sort(sorted.begin(), sorted.end(), [&](auto* a, auto* b) { return of(a) < of(b); });
    return std::adjacent_find(sorted.begin(), sorted.end(),
                              [&](auto* a, auto* b) { return of(a) == of(b); });
  };
  auto twice = twice_by([](const FileEntry* file) { return std::string_view(file->path); });
  if (twice != sorted.end()) return (*twice)->path;
  std::erase_if(sorted, [](const FileEntry* file) { return file->place == 0; });
  twice = twice_by([](const FileEntry* file) { return file->place; });
  if (twice == sorted.end()) return {};
  return fmt::format("{}, also named {}", (*twice)->path, (*std::next(twice))->path);
}

}  // namespace

tl::expected<Summary, std::string> merge(std::vector<NamedSummary> parts) {
  const auto wrong = [](const std::string& name, const std::string& why) {
    return tl::make_unexpected(fmt::format("{}: {}", name, why));
  };
  Summary sum;
  sum.setup = parts.front().second.setup;
  std::map<ListKey, Parts> lists;
  for (auto& [name, part] : parts) {
    if (part.setup.program != sum.setup.program) {
      return wrong(name, fmt::format("made by {}, {} by {}", part.setup.program,
                                     parts.front().first, sum.setup.program));
    }
    if (part.setup != sum.setup) {
      return wrong(name, fmt::format("made with other options than {}", parts.front().first));
    }
    Parts& list = lists[{part.list, part.parts.count}];
    list.count = part.parts.count;
    for (const std::uint64_t each : part.parts.done) {
      if (!list.done.insert(each).second) {
        return wrong(name,
                     fmt::format("shard {} of {} is in an earlier file too", each, list.count));
      }
    }
    for (FileEntry& file : part.files) sum.files.push_back(std::move(file));
    for (const auto& [key, group] : part.groups) sum.groups[key].add(group);
    part = {};
  }
  for (const auto& [list, of_list] : lists) {
    sum.list.add(list.first);
    if (of_list.complete()) continue;
    if (lists.size() == 1) {
      sum.parts = of_list;
      return sum;
    }
    return wrong(
        parts.front().first,
        fmt::format("the shards are from different lists of files, or some are missing: {} of "
                    "{}; run all shards on the same files",
                    of_list.missing(), of_list.count));
  }
  if (const std::string twice = file_of_two(sum.files); !twice.empty()) {
    return wrong(twice, "this file is in two of the summaries");
  }
  sum.parts = {.count = 1, .done = {1}};
  return sum;
}

// ---- How a quantity changes over the days of an archive.

namespace {

using Wide = __int128;

constexpr std::int64_t largest_value = std::int64_t{1} << 53U;
// With this many values no sum below overflows.
constexpr std::size_t most_values = 10'000'000;
constexpr std::int64_t days_per_year = 365;
constexpr std::int64_t million = 1'000'000;

// Rounded half away from zero. \pre divisor > 0
std::int64_t rounded_ratio(Wide dividend, Wide divisor) {
  const Wide half = divisor / 2;
  return static_cast<std::int64_t>((dividend < 0 ? dividend - half : dividend + half) / divisor);
}

}  // namespace

std::optional<std::int64_t> change_per_year(std::span<const DatedValue> values) {
  if (values.empty() || values.size() > most_values) return std::nullopt;
  const Day first = values.front().day;
  const Wide count = static_cast<Wide>(values.size());
  Wide days = 0;
  Wide sum = 0;
  Wide squares = 0;
  Wide products = 0;
  for (const DatedValue& each : values) {
    const Wide day = Wide{each.day} - first;
    const Wide value = std::min(each.value, largest_value);
    days += day;
    sum += value;
    squares += day * day;
    products += day * value;
  }
  const Wide divisor = count * squares - days * days;
  if (divisor == 0) return std::nullopt;
  return rounded_ratio((count * products - days * sum) * days_per_year, divisor);
}

std::vector<DatedValue> medians_of(std::span<const PlacedLink> captures, Quantity quantity) {
  std::vector<DatedValue> values;
  for (const PlacedLink& each : captures) {
    const auto& range = each.link->ranges[static_cast<std::size_t>(quantity)];
    if (range) values.push_back({*each.file->day, range->median});
  }
  return values;
}

std::vector<DatedValue> fault_rates_of(std::span<const PlacedLink> captures) {
  std::vector<DatedValue> values;
  for (const PlacedLink& each : captures) {
    const Counts& counts = each.link->counts;
    if (counts.cycles == 0) continue;
    values.push_back(
        {*each.file->day, rounded_ratio(Wide{counts.faults()} * million, Wide{counts.cycles})});
  }
  return values;
}

}  // namespace biss::archive
