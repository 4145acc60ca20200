#include "verbs/simulate/write.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "biss/configure/configurator.hpp"
#include "biss/control/register_map.hpp"
#include "biss/frame/format_text.hpp"
#include "device/quantity.hpp"
#include "report/summary.hpp"
#include "sim/line.hpp"
#include "verbs/common/access_option.hpp"
#include "verbs/common/fields.hpp"
#include "verbs/common/output.hpp"
#include "verbs/common/terminal.hpp"
#include "verbs/eds/rows.hpp"
#include "verbs/simulate/line_output.hpp"
#include "verbs/simulate/truth.hpp"

namespace biss::verbs {

namespace {

using sim::AccessKind;

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
  std::vector<std::string_view> names;
  for (const sim::ControlRecord& record : records) names.push_back(outcome_name(record));
  names.resize(accesses, "not begun");
  std::vector<std::string> counts;
  while (!names.empty()) {
    const std::string_view name = names.front();
    counts.push_back(fmt::format("{} {}", std::erase(names, name), name));
  }
  return fmt::format("{} {}: {}\n", accesses, accesses == 1 ? "access" : "accesses",
                     fmt::join(counts, ", "));
}

// A row of --outcomes.
FieldRow fields_of(const sim::ControlAccess& access, const sim::ControlRecord& record,
                   std::optional<unsigned> id) {
  const bool reads = access.kind == AccessKind::read;
  const bool on_registers = reads || access.kind == AccessKind::write;
  return {{"cycle", record.cycle},
          {"time_ns", record.time},
          {"id", id},
          {"access", reads          ? "read"
                     : on_registers ? "write"
                                    : "command"},
          {"address", unless_empty(on_registers ? fmt::format("0x{:02X}", access.address) : "")},
          {"name", on_registers ? register_field(access.address).name : name_of(access.command)},
          {"data", unless_empty(fmt::format("{:02X}", fmt::join(record.data, " ")))},
          {"outcome", outcome_name(record)},
          {"cycles", record.cycles}};
}

// A command has a row for each slave that it addresses.
std::vector<FieldRow> outcome_rows(const sim::ControlMaster& control) {
  std::vector<FieldRow> rows;
  for (const sim::ControlRecord& record : control.records()) {
    const sim::ControlAccess& access = control.accesses()[record.access];
    if (access.kind == AccessKind::broadcast) rows.push_back(fields_of(access, record, {}));
    for (unsigned id = 0; id < control_max_slaves; ++id) {
      const bool addressed =
          access.kind == AccessKind::command ? (access.slaves >> id & 1U) != 0 : access.slave == id;
      if (access.kind != AccessKind::broadcast && addressed) {
        rows.push_back(fields_of(access, record, id));
      }
    }
  }
  return rows;
}

// True for the steps that concern one slave.
bool asks_one(ConfigureStep step) {
  return step >= ConfigureStep::identity && step <= ConfigureStep::restore_bank;
}

// "4D484D234400 (MHM#D)": the number, and its bytes as characters up to the first other byte.
std::string device_text(std::uint64_t device) {
  std::string letters;
  for (unsigned shift = 48; shift != 0;) {
    shift -= 8;
    const auto c = static_cast<char>(device >> shift & 0xFFU);
    if (c < 0x21 || c > 0x7E) break;
    letters += c;
  }
  const std::string number = fmt::format("{:012X}", device);
  return letters.empty() ? number : fmt::format("{} ({})", number, letters);
}

std::string maker_text(std::uint16_t id) {
  const auto name = manufacturer_name(id);
  return name ? fmt::format("0x{:04X} ({})", id, *name) : fmt::format("0x{:04X}", id);
}

std::string sheet_text(const SlaveDescription& slave) {
  if (slave.source == ValueSource::eds) return "read";
  if (slave.eds_unused) return fmt::format("in bank {}, not readable or wrong", slave.eds_bank);
  return "none";
}

void add_slave(report::Summary& out, std::size_t id, const SlaveDescription& slave) {
  const std::string key = fmt::format("ID {}", id);
  if (slave.identity) {
    out.entry(key, fmt::format("device {}", device_text(slave.identity->device)),
              fmt::format("maker {}", maker_text(slave.identity->manufacturer)));
  } else {
    out.entry(key, "no identity");
  }
  const std::string profile = slave.profile.value_or(0) != 0
                                  ? fmt::format("profile 0x{:04X}", *slave.profile)
                                  : "no profile identifier";
  const std::string serial = slave.serial ? fmt::format("serial number {}, ", *slave.serial) : "";
  out.entry("", profile, fmt::format("{}data sheet {}", serial, sheet_text(slave)));
}

void add_found(report::Summary& out, const Configuration& found) {
  for (std::size_t id = 0; id < found.slave_count; ++id) add_slave(out, id, found.slave_list[id]);
  const DeviceTiming& timing = found.timing;
  out.entry("format", format_text(found.format).view(), name_of(found.format_source));
  out.entry("clock", fmt::format("{} to {}", text_of(timing.clock_min), text_of(timing.clock_max)),
            name_of(found.clock_source));
  out.entry(
      "ACK",
      fmt::format("at most {} and {} clocks", text_of(timing.ack_max), found.start_delay_clocks),
      name_of(found.busy_source));
  out.entry("timeout", text_of(timing.timeout), name_of(found.timeout_source));
  out.entry("shortest cycle", timing.cycle_min.count == 0 ? "not given" : text_of(timing.cycle_min),
            name_of(found.cycle_source));
}

}  // namespace

std::string fault_text(const ConfigureFault& fault) {
  std::string text = fmt::format("{} at {}", name_of(fault.cause), name_of(fault.step));
  if (asks_one(fault.step)) text += fmt::format(" of ID {}", fault.slave);
  if (fault.control) text += fmt::format(": {}", name_of(*fault.control));
  if (fault.profile) text += fmt::format(": {}", biss::text_of(*fault.profile));
  if (!fault.field.empty()) {
    text += fmt::format(
        ": {}: {}", fault.field,
        fault.problem ? biss::text_of(*fault.problem) : "does not fit the slaves on the line");
  }
  if (fault.eds) text += fmt::format(": {}", biss::text_of(*fault.eds));
  return text;
}

EdsFindingTaker lines_of_findings(std::vector<std::string>& lines) {
  return {[](void* list, std::uint8_t slave, const EdsFinding& finding) {
            static_cast<std::vector<std::string>*>(list)->push_back(
                fmt::format("ID {}: {}", slave, finding_line(finding_row(finding))));
          },
          &lines};
}

void add_configuration(report::Summary& out, const Result<Configuration, ConfigureFault>& found,
                       const std::vector<std::string>& findings) {
  if (found.ok()) add_found(out, *found);
  for (const std::string& finding : findings) {
    out.entry(&finding == findings.data() ? "data sheet" : "", finding);
  }
}

namespace {

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
        format_(setup.format) {}

  ExitStatus run() {
    const std::vector<std::string> names = names_of(setup_);
    if (!output_.open(options_.output, names, setup_.clock, options_.sample_rate, options_.truth,
                      columns_of(truth(0, {})))) {
      return output_.status();
    }
    if (!options_.outcomes.empty() && !outcomes_.open(options_.outcomes)) {
      return outcomes_.status();
    }
    if (!output_.write(idle_levels(names.size()))) return output_.status();
    if (options_.configure && !configure()) return output_.status();
    const bool lost = line_->configuration() && !line_->configuration()->ok();
    if (!lost && !write_cycles()) return output_.status();
    if (!output_.finish(line_->end() + 20 * period_of(setup_.clock))) return output_.status();
    if (line_->control() != nullptr && !write_outcomes(*line_->control())) {
      return outcomes_.status();
    }
    if (!lost) return ExitStatus::done;
    return host_.fail(
        ExitStatus::data_failed,
        fmt::format("no configuration: {}", fault_text(line_->configuration()->error())));
  }

 private:
  // Prints the steps with their requests, and format, timing and identity, each with its source, if
  // they were found. False: the capture cannot be written.
  bool configure() {
    struct Step {
      ConfigureStep step{};
      std::string slave;
      std::uint32_t requests = 0;
    };
    std::vector<Step> steps;
    std::vector<std::string> findings;
    const ConfigureOptions options{.findings = lines_of_findings(findings)};
    const Picoseconds begin = line_->end();
    line_->begin_configuration(options, common_clock_max);
    const Configurator& asking = line_->configurator();
    while (line_->configuring()) {
      const std::uint32_t before = asking.requests();
      const ConfigureStep step = asking.step();
      const std::string slave = asks_one(step) ? fmt::format("ID {}", asking.slave()) : "";
      if (steps.empty() || steps.back().step != step || steps.back().slave != slave) {
        steps.push_back({step, slave});
      }
      if (!output_.write(line_->configure_next())) return false;
      steps.back().requests += asking.requests() - before;
    }
    const auto& found = *line_->configuration();
    report::Summary out;
    out.title(fmt::format("configuration: {}, {}", report::counted(asking.requests(), "request"),
                          biss::text_of(line_->end() - begin, 3)));
    for (const auto& [step, slave, requests] : steps) {
      if (requests != 0) out.entry(name_of(step), report::counted(requests, "request"), slave);
    }
    add_configuration(out, found, findings);
    host_.print_summary(out.text());
    if (!found.ok()) return true;
    const DeviceTiming& timing = found->timing;
    if (setup_.clock < timing.clock_min || setup_.clock > timing.clock_max) {
      host_.warn(fmt::format("--clock: {} is outside the range that was found, {} to {}",
                             text_of(setup_.clock), text_of(timing.clock_min),
                             text_of(timing.clock_max)));
    }
    return true;
  }

  // False: the capture or its rows cannot be written.
  bool write_cycles() {
    // Without a given number of cycles, until all accesses are finished and the encoders are idle
    // again.
    std::uint64_t end = options_.cycles.value_or(usual_cycles);
    const auto accessing = [&] {
      return !options_.cycles && line_->control() != nullptr && !line_->control()->done();
    };
    Progress progress(host_);
    for (std::uint64_t i = 0; i < end || accessing(); ++i) {
      if (accessing()) end = std::max(usual_cycles, i + 1 + control_reset_zeros);
      if (i % 1024 == 0 && progress.due()) {
        progress.show(progress_text({.done = i, .all = options_.cycles.value_or(0)},
                                    "request cycles", progress.seconds()));
      }
      if (options_.then && i == options_.then_cycle && !change_format(i)) return false;
      const sim::SimulatedCycle& cycle = line_->next();
      for (const wire::Edge& edge : cycle.edges) {
        const std::uint32_t line = std::uint32_t{1} << edge.line;
        low_lines_ = edge.level == wire::Level::low ? low_lines_ | line : low_lines_ & ~line;
      }
      if (output_.has_rows()) output_.row(truth(i, cycle));
      if (!output_.write(cycle.edges)) return false;
      const bool more_outputs = output_.has_rows() || !options_.outcomes.empty();
      if (output_.reader_left() && !more_outputs) break;
    }
    return true;
  }

  FieldRow truth(std::uint64_t number, const sim::SimulatedCycle& cycle) const {
    FieldRow row = truth_row(format_, number, cycle, sim::text_of(cycle.faults));
    if (options_.then) row.emplace_back("format", std::string(format_text(format_).view()));
    return row;
  }

  // At the end of the run; and their summary.
  bool write_outcomes(const sim::ControlMaster& control) {
    if (!options_.outcomes.empty()) {
      const auto format =
          options_.outcomes.ends_with(".jsonl") ? report::Format::jsonl : report::Format::csv;
      const FieldRow columns = fields_of({}, {}, {});
      if (!write_rows(columns, outcome_rows(control), format, outcomes_) || !outcomes_.finish()) {
        return false;
      }
    }
    if (!control.accesses().empty()) {
      host_.print_summary(outcome_summary(control.records(), control.accesses().size()));
    }
    return true;
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
    format_ = changed.format;
    return output_.write(rises);
  }

  const sim::LineSetup& setup_;
  const WriteOptions& options_;
  Host& host_;
  std::optional<sim::Line> line_;
  std::uint32_t low_lines_ = 0;  // bit k: line k is low
  FrameFormat format_;
  LineOutput output_{host_};
  Output outcomes_{host_};
};

}  // namespace

ExitStatus write_line(const sim::LineSetup& setup, const WriteOptions& options, Host& host) {
  return LineWriter(setup, options, host).run();
}

}  // namespace biss::verbs
