#include "cli/simulate/write.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "cli/common/capture_output.hpp"
#include "cli/common/message.hpp"
#include "cli/common/output.hpp"
#include "cli/common/quantity.hpp"
#include "cli/simulate/configure_log.hpp"
#include "cli/simulate/outcome_table.hpp"
#include "cli/simulate/truth.hpp"
#include "sim/line.hpp"

namespace biss::cli {

namespace {

// How long a run lasts: as told, or until all accesses are over and the encoders at rest again.
class Duration {
 public:
  explicit Duration(std::optional<std::uint64_t> told) : told_(told) {}

  bool more(std::uint64_t cycle, const sim::ControlMaster* control) {
    if (told_) return cycle < *told_;
    if (control != nullptr && !control->done()) return true;
    if (control != nullptr && end_ == 0) end_ = cycle + control_reset_zeros;
    return cycle < std::max(usual_cycles, end_);
  }

 private:
  std::optional<std::uint64_t> told_;
  std::uint64_t end_ = 0;
};

std::vector<std::string> names_of(const sim::LineSetup& setup) {
  std::vector<std::string> names{"MA", "SLO"};
  if (setup.record_at_slave) names.insert(names.end(), {"MA_at_slave", "SLO_at_slave"});
  return names;
}

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
  LineWriter(const sim::LineSetup& setup, const WriteOptions& options)
      : setup_(setup), options_(options), line_(setup), truth_(setup.format) {}

  ExitStatus run() {
    const ExitStatus opened = open();
    if (opened != ExitStatus::done) return opened;
    if (options_.configure && !configure()) return edges_->status();
    const bool lost = line_.configuration() && !line_.configuration()->ok();
    if (!lost) {
      const ExitStatus written = write_cycles();
      if (written != ExitStatus::done) return written;
    }
    if (!edges_->finish(line_.end() + 20 * period_of(setup_.clock))) return edges_->status();
    if (!output_.finish()) return output_.status();
    if (rows_ && (!rows_->finish() || !truth_output_.finish())) return truth_output_.status();
    if (line_.control() != nullptr && !outcomes_.finish(*line_.control())) {
      return outcomes_.status();
    }
    if (!lost) return ExitStatus::done;
    return fail(ExitStatus::data_failed,
                fmt::format("no configuration: {}", text_of(line_.configuration()->error())));
  }

 private:
  ExitStatus open() {
    if (!output_.open(options_.output)) return output_.status();
    if (!options_.truth.empty() && !truth_output_.open(options_.truth)) {
      return truth_output_.status();
    }
    if (!outcomes_.open(options_.outcomes)) return outcomes_.status();
    const std::vector<std::string> names = names_of(setup_);
    edges_.emplace(options_.output, names,
                   options_.sample_rate.value_or(usual_sample_rate(setup_.clock)), output_);
    if (!options_.truth.empty()) {
      rows_ = report::make_table_writer(report::Format::csv, truth_.columns(), truth_output_);
    }
    return edges_->write(idle_levels(names.size())) ? ExitStatus::done : edges_->status();
  }

  // Says what was found. False: the capture cannot be written.
  bool configure() {
    ConfigureLog log;
    const Picoseconds begin = line_.end();
    line_.begin_configuration({}, common_clock_max);
    while (line_.configuring()) {
      log.note(line_.configurator());
      if (!edges_->write(line_.configure_next())) return false;
    }
    log.note(line_.configurator());
    const auto& found = *line_.configuration();
    print_summary(log.text(found, line_.end() - begin));
    if (!found.ok()) return true;
    const DeviceTiming& timing = found->timing;
    if (setup_.clock < timing.clock_min || setup_.clock > timing.clock_max) {
      warn(fmt::format("--clock: {} is not what was found, {} to {}", text_of(setup_.clock),
                       text_of(timing.clock_min), text_of(timing.clock_max)));
    }
    return true;
  }

  ExitStatus write_cycles() {
    Duration duration(options_.cycles);
    for (std::uint64_t i = 0; duration.more(i, line_.control()); ++i) {
      const sim::SimulatedCycle& cycle = line_.next();
      if (!edges_->write(cycle.edges)) return edges_->status();
      if (rows_ && !rows_->row(truth_.cells(i, cycle))) return truth_output_.status();
      const bool more_outputs = rows_ || !options_.outcomes.empty();
      if (output_.reader_left() && !more_outputs) break;
    }
    return ExitStatus::done;
  }

  const sim::LineSetup& setup_;
  const WriteOptions& options_;
  sim::Line line_;
  TruthTable truth_;
  Output output_;
  Output truth_output_;
  OutcomeLog outcomes_;
  std::optional<CaptureOutput> edges_;
  std::unique_ptr<report::TableWriter> rows_;
};

}  // namespace

ExitStatus write_line(const sim::LineSetup& setup, const WriteOptions& options) {
  return LineWriter(setup, options).run();
}

}  // namespace biss::cli
