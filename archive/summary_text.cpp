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

Json format_json(const std::string& format) {
  return format.empty() ? Json(nullptr) : Json(format);
}

Json number_or_null(const std::optional<std::int64_t>& value) {
  return value ? Json(*value) : Json(nullptr);
}

struct Totals {
  std::array<std::uint64_t, 3> by_reading{};
  std::uint64_t bytes = 0;
  std::uint64_t links = 0;
  Counts counts;
  std::map<std::string, std::uint64_t> causes;
};

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

Json json_of(const Totals& totals, std::size_t files) {
  Json json{{"files", archive::json_of(std::uint64_t{files})},
            {"bytes", archive::json_of(totals.bytes)}};
  for (const Reading reading : {Reading::whole, Reading::part, Reading::none}) {
    json[std::string(name_of(reading))] =
        archive::json_of(totals.by_reading[static_cast<std::size_t>(reading)]);
  }
  json["links"] = archive::json_of(totals.links);
  json.update(archive::json_of(totals.counts));
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
            {"captures", archive::json_of(day.captures)},
            {"cycles", archive::json_of(day.counts.cycles)},
            {"faults", archive::json_of(day.counts.faults())},
            {"errors", archive::json_of(day.counts.errors)},
            {"warnings", archive::json_of(day.counts.warnings)},
            {"limited", archive::json_of(day.counts.limited)},
            {"marginal", archive::json_of(day.counts.marginal)}};
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
            {"format", format_json(key.format)},
            {"encoders", encoders_of(captures)},
            {"captures", archive::json_of(group.captures)}};
  json.update(archive::json_of(group.counts));
  for (std::size_t i = 0; i < quantity_count; ++i) {
    json[std::string(name_of(static_cast<Quantity>(i)))] = archive::json_of(group.histograms[i]);
  }
  json["drift"] = drift_json(captures);
  Json days = Json::array();
  for (const DayFigures& day : days_of(captures)) days.push_back(day_json(day));
  json["days"] = std::move(days);
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
  writer.member("shards",
                {{"count", archive::json_of(summary.parts.count)}, {"done", summary.parts.done}});
  writer.member(
      "list", {{"files", archive::json_of(summary.list.files)}, {"hash", hex(summary.list.hash)}});
  writer.member("totals", json_of(totals, summary.files.size()));
  writer.member("causes", Json(totals.causes));
  writer.list("formats", [&](const auto& add) {
    for (const auto& [format, of_format] : formats) {
      Json json{{"format", format_json(format)},
                {"encoders", of_format.encoders},
                {"captures", archive::json_of(of_format.captures)}};
      json.update(archive::json_of(of_format.counts));
      add(json);
    }
  });
  writer.list("encoders", [&](const auto& add) {
    for (const auto& [key, group] : summary.groups) add(group_json(key, group, captures.at(key)));
  });
  writer.list("files", [&](const auto& add) {
    for (const FileEntry& file : summary.files) add(archive::json_of(file));
  });
  return writer.finish();
}

}  // namespace biss::archive
