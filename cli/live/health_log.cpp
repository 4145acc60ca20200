#include "cli/live/health_log.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <array>
#include <fstream>
#include <utility>
#include <vector>

#include "report/summary.hpp"
#include "report/text.hpp"

namespace biss::cli {

using namespace live;
using namespace verbs;

namespace {

// The journal is written again when it is larger.
constexpr std::uint64_t journal_max = std::uint64_t{1} << 20U;

std::string time_text(std::int64_t time) {
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(static_cast<std::time_t>(time)));
}

std::vector<report::Column> health_columns(LinkUnit unit) {
  using report::Kind;
  const auto count = [](std::string_view name) {
    return report::Column{.name = std::string(name), .kind = Kind::unsigned_integer};
  };
  std::vector<report::Column> columns{
      {.name = "time", .kind = Kind::text}, count("cycles"), count("good")};
  for (std::size_t k = 0; k < event_count; ++k) {
    columns.push_back(count(name_of(static_cast<Event>(k))));
  }
  if (unit == LinkUnit::clock) {
    columns.push_back({.name = "line_delay_clocks", .kind = Kind::signed_integer});
    columns.push_back({.name = "ack_clocks", .kind = Kind::signed_integer});
  } else {
    columns.push_back({.name = "line_delay_ns", .kind = Kind::nanoseconds});
    columns.push_back({.name = "ack_ns", .kind = Kind::nanoseconds});
  }
  columns.push_back({.name = "margin_percent", .kind = Kind::real, .places = 1});
  columns.push_back({.name = "alarms", .kind = Kind::text, .role = report::Role::warnings});
  return columns;
}

std::string alarms_of(const HealthState& state) {
  std::string names;
  for (std::size_t k = 0; k < alarm_count; ++k) {
    if (state.reasons[k].empty()) continue;
    names += fmt::format("{}{}", names.empty() ? "" : ";", name_of(static_cast<Alarm>(k)));
  }
  return names;
}

bool write_row(report::TableWriter& writer, const HealthPoint& point, LinkUnit unit,
               const std::string& alarms) {
  const std::string time = time_text(point.time);
  std::vector<report::Cell> cells{time, point.cycles, point.good};
  for (const std::uint64_t count : point.events) cells.emplace_back(count);
  for (const Level level : {Level::delay, Level::ack}) {
    const auto& value = point.level(level);
    const bool is_time = unit == LinkUnit::picosecond && value;
    cells.push_back(is_time ? report::Cell(Picoseconds{*value}) : report::Cell(value));
  }
  const auto& margin = point.level(Level::margin);
  cells.push_back(margin ? report::Cell(static_cast<double>(*margin) / 10) : report::Cell());
  cells.emplace_back(alarms);
  return writer.row(cells);
}

std::string text_of(const AlarmChange& change) {
  if (!change.begins) return fmt::format("alarm {} ends", name_of(change.alarm));
  return fmt::format("alarm {}: {}; cycles with a fault so far: {}", name_of(change.alarm),
                     change.reason, change.faults);
}

std::string summary_of(const LinkHealth& health) {
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
  constexpr std::pair<Level, std::string_view> levels[] = {
      {Level::delay, "line delay"}, {Level::ack, "ACK"}, {Level::margin, "margin"}};
  for (const auto& [level, name] : levels) {
    const auto last = state.recent.empty() ? std::nullopt : state.recent.back().level(level);
    if (!last) continue;
    summary.entry(name, health.level_text(level, *last), health.trend_text(level));
  }
  const std::string alarms = alarms_of(state);
  summary.entry("alarms", alarms.empty() ? "none" : alarms);
  for (const AlarmChange& change : state.changes) {
    summary.entry("", fmt::format("{}  {}", time_text(change.time), text_of(change)));
  }
  return summary.text();
}

}  // namespace

HealthLog::HealthLog(HealthLogOptions options, Host& host)
    : options_(std::move(options)),
      host_(host),
      saved_(options_.health, options_.settings),
      journal_(host),
      output_(host),
      publisher_(options_.publish, options_.health.unit) {
  if (!options_.state.empty()) {
    std::uint64_t number = 1;
    const auto take = [&](std::string_view line) {
      ++number;
      try {
        saved_.take_line(line);
      } catch (const std::exception&) {
        throw wrong_file("{}: line {} is damaged; give another --state, or delete this file",
                         options_.state, number);
      }
      return true;
    };
    journal_.open(options_.state,
                  {.owner = "biss watch",
                   .begins = std::string(state_begins),
                   .header = saved_.header(),
                   .refusal = "it was written with other options; give the same ones, or another "
                              "--state"},
                  take);
  }
  if (!output_.open(options_.output)) throw VerbError{ExitStatus::io, output_.error()};
  output_.write_soon();
  rows_ = report::make_table_writer(options_.to, health_columns(options_.health.unit), output_,
                                    output_.table_options());
  publisher_.set(saved_.health);
}

void HealthLog::add(const HealthSample& sample, Picoseconds time, std::int64_t now) {
  if (!began_) {
    began_ = time;
    began_at_ = now;
  }
  if (time - *began_ >= options_.interval) {
    end_interval();
    began_ = time;
    began_at_ = now;
  }
  saved_.health.add(sample);
  if (mark_ != nullptr) ++mark_->cycles;
  // Not for each cycle.
  if (++unsaved_ % 64 != 0) return;
  const auto clock = std::chrono::steady_clock::now();
  if (clock - saved_at_ >= std::chrono::milliseconds(500)) save(nullptr);
}

void HealthLog::end_capture() {
  if (began_) end_interval();
  began_.reset();
}

FileMark& HealthLog::begin_file(std::uint64_t key) {
  file_ = key;
  mark_ = &saved_.files[key];
  return *mark_;
}

void HealthLog::end_interval() {
  const auto point = saved_.health.end_interval(began_at_);
  if (!point) return;
  const std::string alarms = alarms_of(saved_.health.state());
  if (!write_row(*rows_, *point, options_.health.unit, alarms)) {
    throw VerbError{ExitStatus::io, output_.error()};
  }
  report::StringSink text;
  const auto message =
      report::make_table_writer(report::Format::jsonl, health_columns(options_.health.unit), text);
  write_row(*message, *point, options_.health.unit, alarms);
  message->finish();
  publisher_.send("interval", text.text().substr(0, text.text().find('\n')));
  for (const AlarmChange& change : saved_.health.changes()) {
    host_.warn(fmt::format("{}  {}", time_text(change.time), text_of(change)));
    publisher_.send(fmt::format("alarm/{}", name_of(change.alarm)),
                    change.begins ? change.reason : "");
  }
  save(&*point);
}

void HealthLog::save(const HealthPoint* interval) {
  saved_at_ = std::chrono::steady_clock::now();
  publisher_.set(saved_.health);
  if (!journal_.is_open()) return;
  journal_.append(saved_.progress(file_, interval));
  if (journal_.bytes() > journal_max) journal_.replace(saved_.snapshot());
}

ExitStatus HealthLog::finish() {
  end_capture();
  save(nullptr);
  if (!rows_->finish() || !output_.finish()) return output_.status();
  if (const std::uint64_t lost = publisher_.finish(); lost != 0) {
    host_.warn(fmt::format("--mqtt {}: the broker has not taken {}", options_.publish.mqtt,
                           report::counted(lost, "message")));
  }
  host_.print_summary(summary_of(saved_.health));
  return alarms_of(saved_.health.state()).empty() ? ExitStatus::done : ExitStatus::data_failed;
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
    SavedHealth saved = SavedHealth::from_header(line);
    // The last line may not be complete.
    while (std::getline(file, line) && !file.eof()) {
      ++number;
      saved.take_line(line);
    }
    const ExitStatus written = write_output(host, output, [&](Output& rows) {
      const auto table = report::make_table_writer(to, health_columns(saved.setup.unit), rows,
                                                   rows.table_options());
      for (const HealthPoint& point : saved.health.state().history) {
        if (!write_row(*table, point, saved.setup.unit, "")) return false;
      }
      return table->finish();
    });
    if (written == ExitStatus::done) host.print_summary(summary_of(saved.health));
    return written;
  } catch (const std::exception&) {
    throw wrong_file("{}: line {} is damaged", path, number);
  }
}

}  // namespace biss::cli
