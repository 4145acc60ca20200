#include "cli/live/saved_health.hpp"

#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <utility>

namespace nlohmann {
template <class T>
struct adl_serializer<std::optional<T>> {
  static void to_json(json& json, const std::optional<T>& value) {
    json = value ? nlohmann::json(*value) : nlohmann::json(nullptr);
  }
  static void from_json(const json& json, std::optional<T>& value) {
    value.reset();
    if (!json.is_null()) value = json.get<T>();
  }
};
}  // namespace nlohmann

namespace biss::decode {
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Counts, cycles, by_status, errors, warnings)
}  // namespace biss::decode

namespace biss::live {
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(HealthPoint, time, cycles, good, events, levels)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Baseline, intervals, sum, ranges, shares)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(AlarmChange, time, alarm, begins, reason, faults)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(HealthState, counts, baseline, intervals, period, recent,
                                   history, joined, last_joined, reasons, quiet, changes)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(HealthSetup, unit, baseline)
}  // namespace biss::live

namespace biss::cli {

using nlohmann::json;

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(FileMark, bytes, time, cycles)

SavedHealth SavedHealth::from_header(std::string_view line) {
  const json header = json::parse(line);
  return SavedHealth(header.at("setup").get<live::HealthSetup>(),
                     header.at("settings").get<std::string>());
}

std::string SavedHealth::header() const {
  // In this order, so that it begins with state_begins.
  return nlohmann::ordered_json{{"biss_watch", 1}, {"settings", settings}, {"setup", json(setup)}}
      .dump();
}

std::string SavedHealth::snapshot() const {
  return json{{"state", health.state()}, {"now", health.interval()}, {"files", files}}.dump();
}

std::string SavedHealth::progress(std::uint64_t file, const live::HealthPoint* interval) const {
  json line{{"now", health.interval()}, {"counts", health.state().counts}};
  if (interval != nullptr) line["interval"] = *interval;
  if (const auto at = files.find(file); at != files.end()) line["file"] = *at;
  return line.dump();
}

void SavedHealth::take_line(std::string_view text) {
  const json line = json::parse(text);
  if (line.contains("state")) {
    auto state = line.at("state").get<live::HealthState>();
    for (const live::AlarmChange& change : state.changes) {
      if (static_cast<std::size_t>(change.alarm) >= live::alarm_count) {
        throw std::out_of_range("alarm");
      }
    }
    health.restore(line.at("now").get<live::HealthPoint>(), state.counts);
    health.restore(std::move(state));
    files = line.at("files").get<std::map<std::uint64_t, FileMark>>();
    return;
  }
  const auto counts = line.at("counts").get<decode::Counts>();
  if (line.contains("interval")) {
    // Its alarms have the counts at its end.
    health.restore(live::HealthPoint{}, counts);
    health.take(line.at("interval").get<live::HealthPoint>());
  }
  health.restore(line.at("now").get<live::HealthPoint>(), counts);
  if (line.contains("file")) {
    const auto [key, mark] = line.at("file").get<std::pair<std::uint64_t, FileMark>>();
    files[key] = mark;
  }
}

}  // namespace biss::cli
