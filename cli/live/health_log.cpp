#include "cli/live/health_log.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

#include "report/summary.hpp"
#include "verbs/common/fields.hpp"

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
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Baseline, intervals, ranges, shares)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(AlarmChange, time, alarm, begins, reason, faults)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(HealthState, counts, baseline, intervals, reference, period,
                                   recent, history, joined, last_joined, reasons, quiet, changes)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(HealthSetup, unit, baseline)
}  // namespace biss::live

namespace biss::cli {

using namespace live;
using namespace verbs;
using nlohmann::json;

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(FileMark, bytes, time, cycles, head, hash)

namespace {

// The beginning of each state file.
constexpr std::string_view state_begins = R"({"biss_watch":1,)";

// The journal is written again when it is larger.
constexpr std::uint64_t journal_max = std::uint64_t{1} << 20U;

std::string time_text(std::int64_t time) {
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(static_cast<std::time_t>(time)));
}

std::string alarms_of(const HealthState& state) {
  std::string names;
  for (std::size_t k = 0; k < alarm_count; ++k) {
    if (state.reasons[k].empty()) continue;
    names += fmt::format("{}{}", names.empty() ? "" : ";", name_of(static_cast<Alarm>(k)));
  }
  return names;
}

FieldRow health_fields(const HealthPoint& point, LinkUnit unit, const std::string& alarms = {}) {
  FieldRow fields{{"time", time_text(point.time)}, {"cycles", point.cycles}, {"good", point.good}};
  for (std::size_t k = 0; k < event_count; ++k) {
    fields.emplace_back(std::string(name_of(static_cast<Event>(k))), point.events[k]);
  }
  for (const auto& [level, name] : {std::pair(Level::delay, "line_delay"), {Level::ack, "ack"}}) {
    const auto& value = point.level(level);
    if (unit == LinkUnit::clock) {
      fields.emplace_back(fmt::format("{}_clocks", name), value);
    } else {
      fields.emplace_back(fmt::format("{}_ns", name),
                          value ? std::optional(Picoseconds{*value}) : std::nullopt);
    }
  }
  std::optional<double> margin;
  if (const auto& value = point.level(Level::margin)) margin = static_cast<double>(*value) / 10;
  fields.push_back({"margin_percent", margin, {.places = 1}});
  fields.push_back({"alarms", alarms, {.role = report::Role::warnings}});
  return fields;
}

std::string text_of(const AlarmChange& change) {
  if (!change.begins) return fmt::format("alarm {} ends", name_of(change.alarm));
  return fmt::format("alarm {}: {}; cycles with a fault so far: {}", name_of(change.alarm),
                     change.reason, change.faults);
}

std::string summary_of(const LinkHealth& health, std::uint64_t baseline) {
  const HealthState& state = health.state();
  report::Summary summary;
  summary.title(report::counted(state.counts.cycles, "cycle"));
  std::string causes;
  for (std::size_t k = 0; k < cycle_status_count; ++k) {
    report::append_count(causes, state.counts.by_status[k], cycle_status_names[k]);
  }
  summary.entry("status", causes);
  summary.entry("flags", fmt::format("{} with nE = 0, {} with nW = 0", state.counts.errors,
                                     state.counts.warnings));
  for (const Level level : {Level::delay, Level::ack, Level::margin}) {
    const auto last = state.recent.empty() ? std::nullopt : state.recent.back().level(level);
    if (!last) continue;
    summary.entry(name_of(level), health.level_text(level, *last), health.trend_text(level));
  }
  const std::string alarms = alarms_of(state);
  if (state.baseline.intervals < baseline) {
    summary.entry("baseline", fmt::format("{} of {} intervals", state.baseline.intervals, baseline),
                  "until it is complete, `silent` is the only alarm");
  }
  summary.entry("alarms", alarms.empty() ? "none" : alarms);
  for (const AlarmChange& change : state.changes) {
    summary.entry("", fmt::format("{}  {}", time_text(change.time), text_of(change)));
  }
  return summary.text();
}

// Takes a line of a state file. Throws a std::exception if it is damaged.
void take_line(SavedHealth& saved, std::string_view text) {
  const json line = json::parse(text);
  if (line.contains("state")) {
    auto state = line.at("state").get<HealthState>();
    for (const AlarmChange& change : state.changes) {
      if (static_cast<std::size_t>(change.alarm) >= alarm_count) throw std::out_of_range("alarm");
    }
    saved.health.restore(line.at("now").get<HealthPoint>(), state.counts);
    saved.health.restore(std::move(state));
    saved.files = line.at("files").get<std::map<std::uint64_t, FileMark>>();
    saved.format = line.at("format").get<std::string>();
    return;
  }
  const auto counts = line.at("counts").get<decode::Counts>();
  if (line.contains("interval")) {
    // Its alarms have the counts at its end.
    saved.health.restore(HealthPoint{}, counts);
    saved.health.take(line.at("interval").get<HealthPoint>());
  }
  saved.health.restore(line.at("now").get<HealthPoint>(), counts);
  saved.format = line.at("format").get<std::string>();
  if (line.contains("file")) {
    const auto [key, mark] = line.at("file").get<std::pair<std::uint64_t, FileMark>>();
    saved.files[key] = mark;
  }
}

}  // namespace

HealthLog::HealthLog(HealthLogOptions options, Host& host)
    : options_(std::move(options)),
      host_(host),
      saved_{LinkHealth(options_.health)},
      journal_(host),
      output_(host),
      publisher_(options_.publish, options_.health.unit) {
  if (!options_.state.empty()) {
    std::uint64_t number = 1;
    const auto take = [&](std::string_view line) {
      ++number;
      try {
        take_line(saved_, line);
      } catch (const std::exception&) {
        throw wrong_file("{}: line {} is damaged; give another --state, or delete this file",
                         options_.state, number);
      }
      return true;
    };
    journal_.open(options_.state,
                  {.owner = "biss watch",
                   .begins = std::string(state_begins),
                   // In this order, so that it begins with state_begins.
                   .header = nlohmann::ordered_json{{"biss_watch", 1},
                                                    {"settings", options_.settings},
                                                    {"setup", json(options_.health)}}
                                 .dump(),
                   .refusal = "it was written with other options; give the same ones, or another "
                              "--state"},
                  take);
  }
  if (!output_.open(options_.output)) throw VerbError{ExitStatus::io, output_.error()};
  output_.write_soon();
  rows_ =
      report::make_table_writer(options_.to, columns_of(health_fields({}, options_.health.unit)),
                                output_, output_.table_options());
  publisher_.set(saved_.health);
  // A broker may still have the alarms of an earlier run.
  for (std::size_t k = 0; k < alarm_count; ++k) {
    publisher_.send(fmt::format("alarm/{}", name_of(static_cast<Alarm>(k))),
                    saved_.health.state().reasons[k]);
  }
}

void HealthLog::wait(Picoseconds time, std::int64_t now) {
  if (began_ && time - *began_ < options_.interval) return;
  if (began_) end_interval(true);
  began_ = time;
  began_at_ = now;
}

void HealthLog::add(const HealthSample& sample, Picoseconds time, std::int64_t now) {
  if (!began_ || (time - *began_ >= options_.interval && end_interval())) {
    began_ = time;
    began_at_ = now;
  }
  saved_.health.add(sample);
  if (file_ != nullptr) ++file_->second.cycles;
  // Not for each cycle.
  if (++unsaved_ % 64 != 0) return;
  const auto clock = std::chrono::steady_clock::now();
  if (clock - saved_at_ >= std::chrono::milliseconds(500)) save();
}

void HealthLog::end_capture() {
  if (began_) end_interval();
  began_.reset();
}

FileMark& HealthLog::begin_file(std::uint64_t key) {
  file_ = &*saved_.files.try_emplace(key).first;
  return file_->second;
}

// False if the interval goes on.
bool HealthLog::end_interval(bool even_if_few) {
  const auto point = saved_.health.end_interval(began_at_, even_if_few);
  if (!point) return false;
  const FieldRow row =
      health_fields(*point, options_.health.unit, alarms_of(saved_.health.state()));
  if (!write_row(*rows_, row)) throw VerbError{ExitStatus::io, output_.error()};
  std::string message = verbs::text_of({row}, report::Format::jsonl);
  message.pop_back();
  publisher_.send("interval", message);
  for (const AlarmChange& change : saved_.health.changes()) {
    host_.warn(fmt::format("{}  {}", time_text(change.time), text_of(change)));
    publisher_.send(fmt::format("alarm/{}", name_of(change.alarm)),
                    change.begins ? change.reason : "");
  }
  save(&*point);
  return true;
}

void HealthLog::save(const HealthPoint* interval) {
  saved_at_ = std::chrono::steady_clock::now();
  publisher_.set(saved_.health);
  if (!journal_.is_open()) return;
  try {
    write_state(interval);
    state_failed_ = false;
  } catch (const VerbError& error) {
    if (!std::exchange(state_failed_, true)) {
      host_.warn(error.text + "; watching goes on, and the state is tried again");
    }
  }
}

void HealthLog::write_state(const HealthPoint* interval) {
  const LinkHealth& health = saved_.health;
  json line{{"now", health.interval()}, {"counts", health.state().counts}};
  if (interval != nullptr) line["interval"] = *interval;
  if (file_ != nullptr) line["file"] = *file_;
  line["format"] = saved_.format;
  // A line that is missing would be missing for ever.
  if (!state_failed_) journal_.append(line.dump());
  if (!state_failed_ && journal_.bytes() <= journal_max + 2 * snapshot_bytes_) return;
  const std::string all = json{
      {"state", health.state()},
      {"now", health.interval()},
      {"files", saved_.files},
      {"format",
       saved_.format}}.dump();
  snapshot_bytes_ = all.size();
  journal_.replace(all);
}

ExitStatus HealthLog::finish() {
  end_capture();
  save();
  if (!rows_->finish() || !output_.finish()) return output_.status();
  if (const std::uint64_t lost = publisher_.finish(); lost != 0) {
    host_.warn(fmt::format("--mqtt {}: the broker has not taken {}", options_.publish.mqtt,
                           report::counted(lost, "message")));
  }
  host_.print_summary(summary_of(saved_.health, options_.health.baseline));
  const bool any = saved_.health.state().counts.cycles != 0;
  if (!any) host_.warn("no cycle was read");
  return any && alarms_of(saved_.health.state()).empty() ? ExitStatus::done
                                                         : ExitStatus::data_failed;
}

ExitStatus show_health(const std::string& path, const std::string& output, report::Format to,
                       Host& host) {
  std::ifstream file(path, std::ios::binary);
  std::string line;
  if (!file) throw wrong_file("{}: cannot open it", path);
  if (!std::getline(file, line) || !line.starts_with(state_begins)) {
    throw wrong_file("{}: not a state of biss watch", path);
  }
  std::uint64_t number = 1;
  try {
    const auto setup = json::parse(line).at("setup").get<HealthSetup>();
    SavedHealth saved{LinkHealth(setup)};
    // The last line may not be complete.
    while (std::getline(file, line) && !file.eof()) {
      ++number;
      take_line(saved, line);
    }
    const ExitStatus written = write_output(host, output, [&](Output& rows) {
      std::vector<FieldRow> fields;
      for (const HealthPoint& point : saved.health.state().history) {
        fields.push_back(health_fields(point, setup.unit));
      }
      return write_rows(health_fields({}, setup.unit), fields, to, rows, rows.table_options());
    });
    if (written == ExitStatus::done) host.print_summary(summary_of(saved.health, setup.baseline));
    return written;
  } catch (const std::exception&) {
    throw wrong_file("{}: line {} is damaged", path, number);
  }
}

}  // namespace biss::cli
