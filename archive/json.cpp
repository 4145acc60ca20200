#include "archive/json.hpp"

#include <algorithm>
#include <charconv>

namespace biss::archive {

using decode::CycleStatus;
using decode::Limit;

namespace {

constexpr std::uint64_t exact_in_doubles = std::uint64_t{1} << 53U;
constexpr auto largest_time = static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());

const Json& nothing() {
  static const Json empty = Json::object();
  return empty;
}

// \pre not negative
Json time_json(std::int64_t value) { return json_of(static_cast<std::uint64_t>(value)); }

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
void read_named_counts(JsonReader& reader, const Json& object, std::string_view name,
                       std::array<std::uint64_t, size>& counts) {
  const Json& named = reader.member(object, name);
  for (std::size_t i = 0; i < size; ++i) {
    const std::string_view key = name_of(static_cast<Enum>(i));
    if (named.contains(key)) counts[i] = reader.number(named, key);
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

Json json_of(const Histogram& histogram) {
  Json buckets = Json::array();
  for (const Histogram::Bucket& bucket : histogram.buckets()) {
    buckets.push_back(Json::array({time_json(bucket.begin), json_of(bucket.count)}));
  }
  Json json{{"count", json_of(histogram.count())}};
  if (histogram.count() != 0) {
    json["min"] = time_json(histogram.min());
    json["median"] = time_json(histogram.median());
    json["max"] = time_json(histogram.max());
  }
  json["buckets"] = std::move(buckets);
  return json;
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

Json json_of(const LinkEntry& link) {
  Json json{{"ma", link.ma}, {"slo", link.slo}, {"format", link.format}};
  if (link.format.empty()) json["format"] = nullptr;
  json["encoders"] = link.encoders;
  if (!link.other_format.empty()) json["other_format"] = link.other_format;
  json.update(json_of(link.counts));
  for (std::size_t i = 0; i < quantity_count; ++i) {
    const auto& range = link.ranges[i];
    if (!range) continue;
    json[std::string(name_of(static_cast<Quantity>(i)))] =
        Json::array({time_json(range->min), time_json(range->median), time_json(range->max)});
  }
  if (link.histograms.empty()) return json;
  Json histograms = Json::array();
  for (const Histogram& histogram : link.histograms) histograms.push_back(json_of(histogram));
  json["histograms"] = std::move(histograms);
  return json;
}

Json json_of(const FileEntry& entry) {
  Json json{{"file", entry.path},
            {"place", json_of(entry.place)},
            {"bytes", json_of(entry.bytes)},
            {"date", entry.day ? Json(day_text(*entry.day)) : Json(nullptr)},
            {"date_from", entry.dated_by_path ? "path" : "file"},
            {"read", name_of(entry.reading)}};
  if (!entry.cause.empty()) {
    json["cause"] = entry.cause;
    json["message"] = entry.message;
  }
  Json links = Json::array();
  for (const LinkEntry& link : entry.links) links.push_back(json_of(link));
  json["links"] = std::move(links);
  return json;
}

const Json& JsonReader::member(const Json& object, std::string_view name) {
  if (object.is_object()) {
    const auto at = object.find(name);
    if (at != object.end()) return *at;
  }
  fail(fmt::format("'{}' is missing", name));
  return nothing();
}

const Json& JsonReader::list(const Json& object, std::string_view name) {
  const Json& value = member(object, name);
  if (value.is_array()) return value;
  fail(fmt::format("'{}' is no list", name));
  return nothing();
}

std::string JsonReader::text(const Json& object, std::string_view name) {
  const Json& value = member(object, name);
  if (value.is_string()) return value.get<std::string>();
  fail(fmt::format("'{}' is no text", name));
  return {};
}

std::vector<std::string> JsonReader::texts(const Json& object, std::string_view name) {
  std::vector<std::string> texts;
  for (const Json& value : list(object, name)) {
    if (value.is_string()) {
      texts.push_back(value.get<std::string>());
    } else {
      fail(fmt::format("'{}' has an entry that is no text", name));
    }
  }
  return texts;
}

std::uint64_t JsonReader::value(const Json& json, std::string_view name, std::uint64_t most) {
  std::uint64_t number = 0;
  bool valid = false;
  if (json.is_number_unsigned()) {
    number = json.get<std::uint64_t>();
    valid = true;
  } else if (json.is_string()) {
    const std::string& digits = json.get_ref<const std::string&>();
    const char* const end = digits.data() + digits.size();
    const auto [rest, error] = std::from_chars(digits.data(), end, number);
    valid = error == std::errc() && rest == end;
  }
  if (valid && number <= most) return number;
  fail(fmt::format("'{}' is {}, not a whole number from 0 to {}", name, shown(json), most));
  return 0;
}

std::uint64_t JsonReader::number(const Json& object, std::string_view name, std::uint64_t most) {
  return value(member(object, name), name, most);
}

std::uint64_t JsonReader::element(const Json& list, std::size_t at, std::string_view name,
                                  std::uint64_t most) {
  if (list.is_array() && at < list.size()) return value(list[at], name, most);
  fail(fmt::format("'{}' has too few values", name));
  return 0;
}

Counts JsonReader::counts(const Json& object) {
  Counts counts;
  counts.cycles = number(object, "cycles");
  read_named_counts<CycleStatus>(*this, object, "status", counts.by_status);
  counts.errors = number(object, "errors", counts.cycles);
  counts.warnings = number(object, "warnings", counts.cycles);
  counts.limited = number(object, "limited", counts.cycles);
  read_named_counts<Limit>(*this, object, "limits", counts.by_limit);
  counts.margin_judged = number(object, "margin_judged", counts.cycles);
  counts.marginal = number(object, "marginal", counts.margin_judged);
  std::uint64_t left = counts.cycles;
  for (const std::uint64_t count : counts.by_status) {
    if (count > left) fail("'status' has more cycles than 'cycles'");
    left -= std::min(left, count);
  }
  if (left != 0) fail("'status' has fewer cycles than 'cycles'");
  for (const std::uint64_t count : counts.by_limit) {
    if (count > counts.limited) fail("'limits' has more cycles than 'limited'");
  }
  return counts;
}

Histogram JsonReader::histogram(const Json& object) {
  std::vector<Histogram::Bucket> buckets;
  for (const Json& bucket : list(object, "buckets")) {
    buckets.push_back({static_cast<std::int64_t>(element(bucket, 0, "buckets", largest_time)),
                       element(bucket, 1, "buckets")});
  }
  std::int64_t min = 0;
  std::int64_t max = 0;
  if (!buckets.empty()) {
    min = static_cast<std::int64_t>(number(object, "min", largest_time));
    max = static_cast<std::int64_t>(number(object, "max", largest_time));
  }
  Histogram histogram;
  if (!histogram.assign(std::move(buckets), min, max)) fail("'buckets' are no histogram");
  if (histogram.count() != number(object, "count")) fail("'count' is not that of the 'buckets'");
  return histogram;
}

LinkEntry JsonReader::link(const Json& object) {
  LinkEntry link;
  link.ma = text(object, "ma");
  link.slo = text(object, "slo");
  if (!member(object, "format").is_null()) link.format = text(object, "format");
  link.encoders = texts(object, "encoders");
  if (object.contains("other_format")) link.other_format = text(object, "other_format");
  link.counts = counts(object);
  for (std::size_t i = 0; i < quantity_count; ++i) {
    const std::string_view name = name_of(static_cast<Quantity>(i));
    if (!object.contains(name)) continue;
    const Json& values = list(object, name);
    const auto at = [&](std::size_t place) {
      return static_cast<std::int64_t>(element(values, place, name, largest_time));
    };
    const Range range{at(0), at(1), at(2)};
    if (range.min > range.median || range.median > range.max) {
      fail(fmt::format("'{}' is not in ascending order", name));
    }
    link.ranges[i] = range;
  }
  if (!object.contains("histograms")) return link;
  for (const Json& each : list(object, "histograms")) link.histograms.push_back(histogram(each));
  if (link.histograms.size() != quantity_count) fail("'histograms' are too few or too many");
  return link;
}

FileEntry JsonReader::entry(const Json& object) {
  FileEntry entry;
  entry.path = text(object, "file");
  entry.place = number(object, "place");
  entry.bytes = number(object, "bytes");
  if (!member(object, "date").is_null()) {
    entry.day = day_from(text(object, "date"));
    if (!entry.day) fail("'date' is no date");
  }
  entry.dated_by_path = text(object, "date_from") == "path";
  const std::string read = text(object, "read");
  for (const Reading reading : {Reading::whole, Reading::part, Reading::none}) {
    if (read == name_of(reading)) entry.reading = reading;
  }
  if (read != name_of(entry.reading)) fail(fmt::format("'read' is {}", shown(read)));
  if (object.contains("cause")) {
    entry.cause = text(object, "cause");
    entry.message = text(object, "message");
  }
  if (entry.cause.empty() != (entry.reading == Reading::whole)) {
    fail("'cause' and 'read' contradict each other");
  }
  for (const Json& each : list(object, "links")) entry.links.push_back(link(each));
  if (!entry.links.empty() && !entry.day) fail("'date' is missing");
  return entry;
}

}  // namespace biss::archive
