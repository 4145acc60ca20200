// The JSON of a summary, written.
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
    write(text_of(value));
  }
  // Calls each(add): add(json) writes an element.
  template <class Each>
  void list(std::string_view name, const Each& each) {
    begin(name);
    write("[");
    bool first = true;
    each([&](const Json& element) {
      write(first ? "\n" : ",\n");
      write(text_of(element));
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

Json drift_json(const std::vector<PlacedLink>& captures) {
  Json json{{"faults_ppm_per_year", number_or_null(change_per_year(fault_rates_of(captures)))}};
  for (const Quantity quantity : {Quantity::line_delay, Quantity::ack, Quantity::period}) {
    json[fmt::format("{}_per_year", name_of(quantity))] =
        number_or_null(change_per_year(medians_of(captures, quantity)));
  }
  return json;
}

Json day_json(const DayFigures& day) {
  Json json{{"date", day_text(day.day)},
            {"captures", json_of(day.captures)},
            {"cycles", json_of(day.counts.cycles)},
            {"faults", json_of(day.counts.faults())},
            {"errors", json_of(day.counts.errors)},
            {"warnings", json_of(day.counts.warnings)},
            {"limited", json_of(day.counts.limited)},
            {"marginal", json_of(day.counts.marginal)}};
  for (const Quantity quantity : {Quantity::line_delay, Quantity::ack, Quantity::period}) {
    json[std::string(name_of(quantity))] =
        number_or_null(day.medians[static_cast<std::size_t>(quantity)]);
  }
  return json;
}

Json group_json(const GroupKey& key, const Group& group, const std::vector<PlacedLink>& captures) {
  Json json{{"folder", key.folder},
            {"ma", key.ma},
            {"slo", key.slo},
            {"format", text_or_null(key.format)},
            {"encoders", encoders_of(captures)},
            {"captures", json_of(group.captures)}};
  json.update(json_of(group.counts));
  for (std::size_t i = 0; i < quantity_count; ++i) {
    json[std::string(name_of(static_cast<Quantity>(i)))] = group.histograms[i];
  }
  json["drift"] = drift_json(captures);
  json["days"] = Json::array();
  for (const DayFigures& day : days_of(captures)) json["days"].push_back(day_json(day));
  return json;
}

struct FormatTotals {
  std::set<std::string> encoders;
  std::uint64_t captures = 0;
  Counts counts;
};

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
      Json json{{"format", text_or_null(format)},
                {"encoders", of_format.encoders},
                {"captures", json_of(of_format.captures)}};
      json.update(json_of(of_format.counts));
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
