// The JSON of a summary, written.
#include <algorithm>
#include <set>

#include "archive/hash.hpp"
#include "archive/json.hpp"
#include "archive/summary.hpp"

namespace biss::archive {

namespace {

constexpr int summary_version = 1;

// Members of one object, each on a line of its own, and lists with an element a line.
class ObjectWriter {
 public:
  explicit ObjectWriter(report::TextSink& sink) : sink_(sink) {}

  void member(std::string_view name, const Json& value) {
    begin(name);
    write(value.dump());
  }
  // Calls each(add): add(json) writes an element.
  template <class Each>
  void list(std::string_view name, const Each& each) {
    begin(name);
    write("[");
    bool first = true;
    each([&](const Json& element) {
      write(first ? "\n" : ",\n");
      write(element.dump());
      first = false;
    });
    write(first ? "]" : "\n]");
  }
  bool finish() {
    write(checksum_end(hash_));
    return good_;
  }

 private:
  void begin(std::string_view name) {
    write(any_ ? ",\n" : "{");
    any_ = true;
    write(fmt::format("\"{}\":", name));
  }
  void write(std::string_view text) {
    hash_ = hash_of(text, hash_);
    good_ = good_ && sink_.write(text);
  }

  report::TextSink& sink_;
  std::uint64_t hash_ = hash_of("");
  bool any_ = false;
  bool good_ = true;
};

std::string hex(std::uint64_t hash) { return fmt::format("{:016x}", hash); }

Json number_or_null(const std::optional<std::int64_t>& value) {
  return value ? Json(*value) : Json(nullptr);
}

Json totals_json(const Totals& totals, std::size_t files) {
  Json json{{"files", json_of(std::uint64_t{files})}, {"bytes", json_of(totals.bytes)}};
  for (const Reading reading : {Reading::whole, Reading::part, Reading::none}) {
    json[std::string(name_of(reading))] =
        json_of(totals.by_reading[static_cast<std::size_t>(reading)]);
  }
  json["links"] = json_of(totals.links);
  json.update(json_of(totals.counts));
  return json;
}

std::set<std::string> encoders_of(const std::vector<PlacedLink>& captures) {
  std::set<std::string> names;
  for (const PlacedLink& each : captures) {
    names.insert(each.link->encoders.begin(), each.link->encoders.end());
  }
  return names;
}

constexpr std::array drifting{Quantity::line_delay, Quantity::ack, Quantity::period};

Json drift_json(const std::vector<PlacedLink>& captures) {
  Json json{{"faults_ppm_per_year", number_or_null(change_per_year(fault_rates_of(captures)))}};
  for (const Quantity quantity : drifting) {
    json[fmt::format("{}_per_year", name_of(quantity))] =
        number_or_null(change_per_year(medians_of(captures, quantity)));
  }
  return json;
}

// The lower median of the medians of the captures.
std::optional<std::int64_t> median_of(const std::vector<PlacedLink>& captures, Quantity quantity) {
  auto medians = medians_of(captures, quantity);
  if (medians.empty()) return std::nullopt;
  const auto middle = medians.begin() + static_cast<std::ptrdiff_t>((medians.size() - 1) / 2);
  std::nth_element(medians.begin(), middle, medians.end(),
                   [](const DatedValue& a, const DatedValue& b) { return a.value < b.value; });
  return middle->value;
}

Json day_json(Day day, const std::vector<PlacedLink>& captures) {
  Counts counts;
  for (const PlacedLink& each : captures) counts.add(each.link->counts);
  Json json{{"date", day_text(day)},
            {"captures", json_of(std::uint64_t{captures.size()})},
            {"cycles", json_of(counts.cycles)},
            {"faults", json_of(counts.faults())},
            {"errors", json_of(counts.errors)},
            {"warnings", json_of(counts.warnings)},
            {"limited", json_of(counts.limited)},
            {"marginal", json_of(counts.marginal)}};
  for (const Quantity quantity : drifting) {
    json[std::string(name_of(quantity))] = number_or_null(median_of(captures, quantity));
  }
  return json;
}

// Captures of one format.
struct FormatTotals {
  std::set<std::string> encoders;
  std::uint64_t captures = 0;
  Counts counts;
};

void add_totals(Json& json, const std::string& format, const FormatTotals& totals) {
  json["format"] = text_or_null(format);
  json["encoders"] = totals.encoders;
  json["captures"] = json_of(totals.captures);
  json.update(json_of(totals.counts));
}

Json group_json(const GroupKey& key, const Group& group, const std::vector<PlacedLink>& captures) {
  Json json{{"folder", key.folder}, {"ma", key.ma}, {"slo", key.slo}};
  add_totals(json, key.format, {encoders_of(captures), group.captures, group.counts});
  for (std::size_t i = 0; i < quantity_count; ++i) {
    json[std::string(name_of(static_cast<Quantity>(i)))] = group.histograms[i];
  }
  json["drift"] = drift_json(captures);
  std::map<Day, std::vector<PlacedLink>> by_day;
  for (const PlacedLink& each : captures) by_day[*each.file->day].push_back(each);
  json["days"] = Json::array();
  for (const auto& [day, of_day] : by_day) json["days"].push_back(day_json(day, of_day));
  return json;
}

}  // namespace

bool write_summary(const Summary& summary, report::TextSink& sink) {
  const auto captures = captures_of(summary);
  const Totals totals = totals_of(summary);
  std::map<std::string, FormatTotals> formats;
  for (const auto& [key, group] : summary.groups) {
    FormatTotals& format = formats[key.format];
    format.encoders.merge(encoders_of(captures.at(key)));
    format.captures += group.captures;
    format.counts.add(group.counts);
  }
  ObjectWriter writer(sink);
  writer.member("biss_archive", summary_version);
  writer.member("program", summary.setup.program);
  writer.member("settings", summary.setup.settings);
  writer.member("shards", {{"count", json_of(summary.parts.count)}, {"done", summary.parts.done}});
  writer.member("list", {{"files", json_of(summary.list.files)}, {"hash", hex(summary.list.hash)}});
  writer.member("totals", totals_json(totals, summary.files.size()));
  writer.member("causes", Json(totals.causes));
  writer.list("formats", [&](const auto& add) {
    for (const auto& [format, of_format] : formats) {
      Json json;
      add_totals(json, format, of_format);
      add(json);
    }
  });
  writer.list("encoders", [&](const auto& add) {
    for (const auto& [key, group] : summary.groups) add(group_json(key, group, captures.at(key)));
  });
  writer.list("files", [&](const auto& add) {
    for (const FileEntry& file : summary.files) add(file);
  });
  return writer.finish();
}

}  // namespace biss::archive
