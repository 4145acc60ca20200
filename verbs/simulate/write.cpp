#include "verbs/simulate/write.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "biss/control/register_map.hpp"
#include "device/quantity.hpp"
#include "sim/line.hpp"
#include "verbs/common/access_option.hpp"
#include "verbs/common/capture_output.hpp"
#include "verbs/common/host.hpp"
#include "verbs/common/output.hpp"
#include "verbs/common/terminal.hpp"
#include "verbs/simulate/configure_log.hpp"
#include "verbs/simulate/truth.hpp"

namespace biss::verbs {

namespace {

using report::Cell;
using report::Kind;
using sim::AccessKind;

// The length of a run: the given number of cycles, or until all accesses are finished and the
// encoders are idle again.
class Duration {
 public:
  explicit Duration(std::optional<std::uint64_t> cycles) : cycles_(cycles) {}

  bool more(std::uint64_t cycle, const sim::ControlMaster* control) {
    if (cycles_) return cycle < *cycles_;
    if (control != nullptr && !control->done()) return true;
    if (control != nullptr && end_ == 0) end_ = cycle + control_reset_zeros;
    return cycle < std::max(usual_cycles, end_);
  }

 private:
  std::optional<std::uint64_t> cycles_;
  std::uint64_t end_ = 0;
};

std::vector<std::string> names_of(const sim::LineSetup& setup) {
  std::vector<std::string> names{"MA", "SLO"};
  if (setup.record_at_slave) names.insert(names.end(), {"MA_at_slave", "SLO_at_slave"});
  return names;
}

// `ok`, the cause's name, or `unfinished`.
std::string_view outcome_name(const sim::ControlRecord& record) {
  if (!record.finished) return "unfinished";
  return record.outcome.error ? name_of(*record.outcome.error) : "ok";
}

// One line: "12 accesses: 10 ok, 2 refused".
std::string outcome_summary(const std::vector<sim::ControlRecord>& records, std::size_t accesses) {
  std::vector<std::pair<std::string_view, std::size_t>> counts;
  const auto count = [&](std::string_view name, std::size_t by) {
    const auto same = std::find_if(counts.begin(), counts.end(),
                                   [name](const auto& one) { return one.first == name; });
    if (same != counts.end()) {
      same->second += by;
    } else if (by != 0) {
      counts.emplace_back(name, by);
    }
  };
  for (const sim::ControlRecord& record : records) count(outcome_name(record), 1);
  count("not begun", accesses - records.size());
  std::string text = fmt::format("{} {}: ", accesses, accesses == 1 ? "access" : "accesses");
  for (std::size_t i = 0; i < counts.size(); ++i) {
    text += fmt::format("{}{} {}", i == 0 ? "" : ", ", counts[i].second, counts[i].first);
  }
  return text + "\n";
}

// The rows of --outcomes, written at the end of the run, and their summary.
class OutcomeWriter {
 public:
  explicit OutcomeWriter(Host& host) : host_(host) {}

  /// \param path empty: no rows. False: it cannot be written.
  bool open(const std::string& path) {
    if (path.empty()) return true;
    if (!output_.open(path)) return false;
    const std::vector<report::Column> columns = {
        {.name = "cycle", .kind = Kind::unsigned_integer},
        {.name = "time_ns", .kind = Kind::nanoseconds},
        {.name = "id", .kind = Kind::unsigned_integer},
        {.name = "access"},
        {.name = "address"},
        {.name = "name"},
        {.name = "data"},
        {.name = "outcome"},
        {.name = "cycles", .kind = Kind::unsigned_integer}};
    const auto format = path.ends_with(".jsonl") ? report::Format::jsonl : report::Format::csv;
    rows_ = report::make_table_writer(format, columns, output_);
    return true;
  }

  bool finish(const sim::ControlMaster& control) {
    const auto records = control.records();
    for (const sim::ControlRecord& record : records) {
      if (rows_ && !write(control.accesses()[record.access], record)) return false;
    }
    if (rows_ && (!rows_->finish() || !output_.finish())) return false;
    if (!control.accesses().empty()) {
      host_.print_summary(outcome_summary(records, control.accesses().size()));
    }
    return true;
  }

  ExitStatus status() const { return output_.status(); }

 private:
  // A command has a row for each slave that it addresses.
  bool write(const sim::ControlAccess& access, const sim::ControlRecord& record) {
    if (access.kind == AccessKind::broadcast) return write(access, record, Cell());
    if (access.kind != AccessKind::command) return write(access, record, Cell(access.slave));
    for (unsigned id = 0; id < control_max_slaves; ++id) {
      if ((access.slaves >> id & 1U) != 0 && !write(access, record, Cell(id))) return false;
    }
    return true;
  }

  bool write(const sim::ControlAccess& access, const sim::ControlRecord& record, Cell id) {
    const bool reads = access.kind == AccessKind::read;
    const bool on_registers = reads || access.kind == AccessKind::write;
    const std::string address = fmt::format("0x{:02X}", access.address);
    const std::string data = fmt::format("{:02X}", fmt::join(record.data, " "));
    const Cell cells[] = {
        record.cycle,
        record.time,
        id,
        reads          ? "read"
        : on_registers ? "write"
                       : "command",
        on_registers ? Cell(address) : Cell(),
        on_registers ? register_field(access.address).name : name_of(access.command),
        data.empty() ? Cell() : Cell(data),
        outcome_name(record),
        record.cycles};
    return rows_->row(cells);
  }

  Host& host_;
  Output output_{host_};
  std::unique_ptr<report::TableWriter> rows_;
};

// All lines are high from time 0 on.
std::vector<wire::Edge> idle_levels(std::size_t lines) {
  std::vector<wire::Edge> levels;
  for (std::size_t line = 0; line < lines; ++line) {
    levels.push_back({{}, static_cast<wire::LineIndex>(line), wire::Level::high});
  }
  return levels;
}

class LineWriter {
 public:
  LineWriter(const sim::LineSetup& setup, const WriteOptions& options, Host& host)
      : setup_(setup),
        options_(options),
        host_(host),
        line_(std::in_place, setup),
        truth_(setup.format, options.then.has_value()) {}

  ExitStatus run() {
    const ExitStatus opened = open();
    if (opened != ExitStatus::done) return opened;
    if (options_.configure && !configure()) return edges_->status();
    const bool lost = line_->configuration() && !line_->configuration()->ok();
    if (!lost) {
      const ExitStatus written = write_cycles();
      if (written != ExitStatus::done) return written;
    }
    if (!edges_->finish(line_->end() + 20 * period_of(setup_.clock))) return edges_->status();
    if (!output_.finish()) return output_.status();
    if (rows_ && (!rows_->finish() || !truth_output_.finish())) return truth_output_.status();
    if (line_->control() != nullptr && !outcomes_.finish(*line_->control())) {
      return outcomes_.status();
    }
    if (!lost) return ExitStatus::done;
    return host_.fail(
        ExitStatus::data_failed,
        fmt::format("no configuration: {}", text_of(line_->configuration()->error())));
  }

 private:
  ExitStatus open() {
    if (!output_.open(options_.output)) return output_.status();
    if (!options_.truth.empty() && !truth_output_.open(options_.truth)) {
      return truth_output_.status();
    }
    if (!outcomes_.open(options_.outcomes)) return outcomes_.status();
    const std::vector<std::string> names = names_of(setup_);
    edges_.emplace(capture_format_of(options_.output).value_or(CaptureFormat::vcd), names,
                   options_.sample_rate.value_or(usual_sample_rate(setup_.clock)), output_);
    if (options_.sample_rate) warn_of_lost_clocks(*options_.sample_rate, setup_.clock, host_);
    if (!options_.truth.empty()) {
      rows_ = report::make_table_writer(report::Format::csv, truth_.columns(), truth_output_);
    }
    return edges_->write(idle_levels(names.size())) ? ExitStatus::done : edges_->status();
  }

  // Prints the result. False: the capture cannot be written.
  bool configure() {
    ConfigureLog log;
    const Picoseconds begin = line_->end();
    line_->begin_configuration(log.options(), common_clock_max);
    while (line_->configuring()) {
      log.note(line_->configurator());
      if (!edges_->write(line_->configure_next())) return false;
    }
    log.note(line_->configurator());
    const auto& found = *line_->configuration();
    host_.print_summary(log.text(found, line_->end() - begin));
    if (!found.ok()) return true;
    const DeviceTiming& timing = found->timing;
    if (setup_.clock < timing.clock_min || setup_.clock > timing.clock_max) {
      host_.warn(fmt::format("--clock: {} is outside the range that was found, {} to {}",
                             text_of(setup_.clock), text_of(timing.clock_min),
                             text_of(timing.clock_max)));
    }
    return true;
  }

  ExitStatus write_cycles() {
    Duration duration(options_.cycles);
    Progress progress(host_);
    for (std::uint64_t i = 0; duration.more(i, line_->control()); ++i) {
      if (i % 1024 == 0 && progress.due()) {
        progress.show(progress_text({.done = i, .all = options_.cycles.value_or(0)},
                                    "request cycles", progress.seconds()));
      }
      if (options_.then && i == options_.then_cycle && !change_format(i)) return edges_->status();
      const sim::SimulatedCycle& cycle = line_->next();
      if (!edges_->write(cycle.edges)) return edges_->status();
      for (const wire::Edge& edge : cycle.edges) {
        const std::uint32_t line = std::uint32_t{1} << edge.line;
        low_lines_ = edge.level == wire::Level::low ? low_lines_ | line : low_lines_ & ~line;
      }
      if (rows_ && !rows_->row(truth_.cells(i, cycle))) return truth_output_.status();
      const bool more_outputs = rows_ || !options_.outcomes.empty();
      if (output_.reader_left() && !more_outputs) break;
    }
    return ExitStatus::done;
  }

  // The new line begins idle. False: the capture cannot be written.
  bool change_format(std::uint64_t cycle) {
    sim::LineSetup changed = *options_.then;
    changed.first_cycle = cycle;
    changed.begin = line_->end();
    std::vector<wire::Edge> rises;
    for (wire::LineIndex line = 0; low_lines_ >> line != 0; ++line) {
      if ((low_lines_ >> line & 1U) != 0) rises.push_back({changed.begin, line, wire::Level::high});
    }
    low_lines_ = 0;
    line_.emplace(changed);
    truth_.set_format(changed.format);
    return edges_->write(rises);
  }

  const sim::LineSetup& setup_;
  const WriteOptions& options_;
  Host& host_;
  std::optional<sim::Line> line_;
  std::uint32_t low_lines_ = 0;  // bit k: line k is low
  TruthTable truth_;
  Output output_{host_};
  Output truth_output_{host_};
  OutcomeWriter outcomes_{host_};
  std::optional<CaptureOutput> edges_;
  std::unique_ptr<report::TableWriter> rows_;
};

}  // namespace

ExitStatus write_line(const sim::LineSetup& setup, const WriteOptions& options, Host& host) {
  return LineWriter(setup, options, host).run();
}

}  // namespace biss::verbs
