#include "archive/json.hpp"

#include <exception>

#include "archive/hash.hpp"

namespace biss::archive {

using decode::Limit;

namespace {

constexpr std::uint64_t exact_in_doubles = std::uint64_t{1} << 53U;
constexpr auto largest_time = static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());

// \pre not negative
Json time_json(std::int64_t value) { return json_of(static_cast<std::uint64_t>(value)); }

std::int64_t time_from(const Json& json, std::string_view name) {
  return static_cast<std::int64_t>(number_from(json, name, largest_time));
}

// The counts that are not 0, by name.
template <class Enum, std::size_t size>
Json named_counts(const std::array<std::uint64_t, size>& counts) {
  Json json = Json::object();
  for (std::size_t i = 0; i < size; ++i) {
    if (counts[i] != 0) json[std::string(name_of(static_cast<Enum>(i)))] = json_of(counts[i]);
  }
  return json;
}

template <class Enum, std::size_t size>
void read_named_counts(const Json& named, std::array<std::uint64_t, size>& counts) {
  for (std::size_t i = 0; i < size; ++i) {
    const std::string_view key = name_of(static_cast<Enum>(i));
    if (named.contains(key)) counts[i] = member_number(named, key);
  }
}

std::string shown(const Json& value) {
  return value.dump(-1, ' ', true, Json::error_handler_t::replace).substr(0, 40);
}

}  // namespace

Json json_of(std::uint64_t value) {
  if (value > exact_in_doubles) return fmt::format("{}", value);
  return value;
}

void to_json(Json& json, const Histogram& histogram) {
  Json buckets = Json::array();
  for (const auto& [begin, count] : histogram.buckets()) {
    buckets.push_back(Json::array({time_json(begin), json_of(count)}));
  }
  json = {{"count", json_of(histogram.count())}};
  if (histogram.count() != 0) {
    json["min"] = time_json(histogram.min());
    json["median"] = time_json(histogram.median());
    json["max"] = time_json(histogram.max());
  }
  json["buckets"] = std::move(buckets);
}

Json json_of(const Counts& counts) {
  return {{"cycles", json_of(counts.cycles)},
          {"faults", json_of(counts.faults())},
          {"status", named_counts<CycleStatus>(counts.by_status)},
          {"errors", json_of(counts.errors)},
          {"warnings", json_of(counts.warnings)},
          {"limited", json_of(counts.limited)},
          {"limits", named_counts<Limit>(counts.by_limit)},
          {"marginal", json_of(counts.marginal)},
          {"margin_judged", json_of(counts.margin_judged)}};
}

void to_json(Json& json, const LinkEntry& link) {
  json = {{"ma", link.ma},
          {"slo", link.slo},
          {"format", text_or_null(link.format)},
          {"encoders", link.encoders}};
  if (!link.other_format.empty()) json["other_format"] = link.other_format;
  json.update(json_of(link.counts));
  for (std::size_t i = 0; i < quantity_count; ++i) {
    const auto& range = link.ranges[i];
    if (!range) continue;
    json[std::string(name_of(static_cast<Quantity>(i)))] =
        Json::array({time_json(range->min), time_json(range->median), time_json(range->max)});
  }
  if (!link.histograms.empty()) json["histograms"] = link.histograms;
}

void to_json(Json& json, const FileEntry& entry) {
  json = {{"file", entry.path},
          {"place", json_of(entry.place)},
          {"bytes", json_of(entry.bytes)},
          {"date", text_or_null(entry.day ? day_text(*entry.day) : "")},
          {"date_from", entry.dated_by_path ? "path" : "file"},
          {"read", name_of(entry.reading)}};
  if (!entry.cause.empty()) {
    json["cause"] = entry.cause;
    json["message"] = entry.message;
  }
  json["links"] = entry.links;
}

std::string text_from(const Json& json) { return json.is_null() ? "" : json.get<std::string>(); }

std::uint64_t number_from(const Json& json, std::string_view name, std::uint64_t most) {
  std::optional<std::uint64_t> number;
  if (json.is_number_unsigned()) number = json.get<std::uint64_t>();
  if (json.is_string())
    number = report::number_in<std::uint64_t>(json.get_ref<const std::string&>());
  if (number && *number <= most) return *number;
  wrong_json(fmt::format("'{}' is {}, not a whole number from 0 to {}", name, shown(json), most));
}

Counts counts_from(const Json& json) {
  Counts counts;
  counts.cycles = member_number(json, "cycles");
  read_named_counts<CycleStatus>(json.at("status"), counts.by_status);
  counts.errors = member_number(json, "errors", counts.cycles);
  counts.warnings = member_number(json, "warnings", counts.cycles);
  counts.limited = member_number(json, "limited", counts.cycles);
  read_named_counts<Limit>(json.at("limits"), counts.by_limit);
  counts.margin_judged = member_number(json, "margin_judged", counts.cycles);
  counts.marginal = member_number(json, "marginal", counts.margin_judged);
  std::uint64_t left = counts.cycles;
  for (const std::uint64_t count : counts.by_status) {
    if (count > left) wrong_json("'status' has more cycles than 'cycles'");
    left -= count;
  }
  if (left != 0) wrong_json("'status' has fewer cycles than 'cycles'");
  for (const std::uint64_t count : counts.by_limit) {
    if (count > counts.limited) wrong_json("'limits' has more cycles than 'limited'");
  }
  return counts;
}

void from_json(const Json& json, Histogram& histogram) {
  std::vector<Histogram::Bucket> buckets;
  for (const Json& bucket : json.at("buckets")) {
    buckets.emplace_back(time_from(bucket.at(0), "buckets"), number_from(bucket.at(1), "buckets"));
  }
  const bool any = !buckets.empty();
  const std::int64_t min = any ? time_from(json.at("min"), "min") : 0;
  const std::int64_t max = any ? time_from(json.at("max"), "max") : 0;
  if (!histogram.assign(buckets, min, max)) wrong_json("'buckets' are not a histogram");
  if (histogram.count() != member_number(json, "count")) {
    wrong_json("'count' does not match the 'buckets'");
  }
}

void from_json(const Json& json, LinkEntry& link) {
  json.at("ma").get_to(link.ma);
  json.at("slo").get_to(link.slo);
  link.format = text_from(json.at("format"));
  json.at("encoders").get_to(link.encoders);
  link.other_format = json.value("other_format", "");
  link.counts = counts_from(json);
  for (std::size_t i = 0; i < quantity_count; ++i) {
    const std::string_view name = name_of(static_cast<Quantity>(i));
    if (!json.contains(name)) continue;
    const Json& values = json.at(name);
    const Range range{time_from(values.at(0), name), time_from(values.at(1), name),
                      time_from(values.at(2), name)};
    if (range.min > range.median || range.median > range.max) {
      wrong_json(fmt::format("'{}' is not in ascending order", name));
    }
    link.ranges[i] = range;
  }
  if (!json.contains("histograms")) return;
  json.at("histograms").get_to(link.histograms);
  if (link.histograms.size() != quantity_count) wrong_json("'histograms' are too few or too many");
}

void from_json(const Json& json, FileEntry& entry) {
  json.at("file").get_to(entry.path);
  entry.place = member_number(json, "place");
  entry.bytes = member_number(json, "bytes");
  if (const std::string date = text_from(json.at("date")); !date.empty()) {
    entry.day = day_from(date);
    if (!entry.day) wrong_json("'date' is not a date");
  }
  entry.dated_by_path = json.at("date_from") == "path";
  const Json& read = json.at("read");
  for (const Reading reading : {Reading::whole, Reading::part, Reading::none}) {
    if (read == name_of(reading)) entry.reading = reading;
  }
  if (read != name_of(entry.reading)) wrong_json(fmt::format("'read' is {}", shown(read)));
  if (json.contains("cause")) {
    json.at("cause").get_to(entry.cause);
    json.at("message").get_to(entry.message);
  }
  if (entry.cause.empty() != (entry.reading == Reading::whole)) {
    wrong_json("'cause' and 'read' contradict each other");
  }
  json.at("links").get_to(entry.links);
  if (!entry.links.empty() && !entry.day) wrong_json("'date' is missing");
}

// ---- A line of the journal: a checksum, then the entry.

std::string journal_line(const StampedEntry& stamped) {
  // Times before 1970 are negative, so the time is text.
  const Json json{{"bytes", json_of(stamped.stamp.bytes)},
                  {"time_ns", fmt::format("{}", stamped.stamp.time)},
                  {"entry", stamped.entry}};
  const std::string text = json.dump();
  return fmt::format("{:016x} {}", hash_of(text), text);
}

tl::expected<StampedEntry, std::string> read_journal_line(std::string_view line) {
  constexpr std::size_t before_text = 17;
  if (line.size() < before_text) return tl::unexpected(std::string("it ends early"));
  const std::string_view text = line.substr(before_text);
  if (line.substr(0, before_text) != fmt::format("{:016x} ", hash_of(text))) {
    return tl::unexpected(std::string("its checksum is wrong"));
  }
  try {
    const Json json = Json::parse(text);
    const auto time = report::number_in<std::int64_t>(json.at("time_ns").get<std::string>());
    if (!time) wrong_json("'time_ns' is not a time");
    StampedEntry stamped{{member_number(json, "bytes"), *time}, json.at("entry").get<FileEntry>()};
    for (const LinkEntry& link : stamped.entry.links) {
      if (link.histograms.empty()) wrong_json("'histograms' is missing");
    }
    return stamped;
  } catch (const std::exception& error) {
    return tl::unexpected(std::string(error.what()));
  }
}

}  // namespace biss::archive
