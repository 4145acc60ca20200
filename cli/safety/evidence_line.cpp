// Every fault of the line model on its own, read back by the decoder and judged by the monitor.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "biss/frame/format_text.hpp"
#include "cli/common/quantity.hpp"
#include "cli/safety/evidence.hpp"
#include "cli/simulate/setup.hpp"
#include "decode/decoder.hpp"
#include "lab/parallel.hpp"
#include "report/table.hpp"
#include "sim/line.hpp"

namespace biss::cli {
namespace {

// One request in so many has the fault.
constexpr std::uint64_t spacing = 32;
constexpr Hertz clock = megahertz(10);
constexpr Millimetres cable = metres(20);
// A fault shows in its own cycles, or, where it begins behind the bits of the last one, in the
// next.
constexpr std::uint64_t reaction_cycles = 1;

struct Truth {
  std::uint64_t number = 0;
  Picoseconds time{};
  std::uint64_t position = 0;
  bool struck = false;
  bool begins = false;  // a fault that has a place in the cycle; the others fill it
};

struct LineCounts {
  std::uint64_t committed = 0;
  std::uint64_t detected = 0;
  std::uint64_t accepted_wrong = 0;
  std::uint64_t reaction = 0;
  std::array<std::uint64_t, safety_verdict_count> verdicts{};
  /// Verdicts on requests that no fault has touched.
  std::uint64_t undamaged = 0;
  /// Of a fault: of one that was not there, or of one that was told late.
  std::uint64_t false_alarms = 0;
  /// Safe with a position that was not sent.
  std::uint64_t wrong_alone = 0;
};

// Follows one fault from the cycle it strikes until the monitor is safe again.
class FaultWatch {
 public:
  FaultWatch(const EvidenceQuestion& question, sim::FaultKind kind)
      : watch_(question.format, each_alone(question.setup)),
        kind_(kind),
        cpw_(question.setup.cpw) {}

  void expect(const Truth& truth) { waiting_.push_back(truth); }

  void row(const decode::Cycle& cycle, Picoseconds tolerance) {
    while (!waiting_.empty() && waiting_.front().time < cycle.time - tolerance) pass();
    const bool known = !waiting_.empty() && waiting_.front().time <= cycle.time + tolerance;
    const auto verdict = watch_.judge(cycle);
    if (known) pass();
    // Else it is a row of its own, where no request was.
    if (verdict) note(*verdict, known ? cycle.frame : std::nullopt);
  }

  LineCounts finish() {
    while (!waiting_.empty()) pass();
    close();
    return counts_;
  }

 private:
  static SafetySetup each_alone(SafetySetup setup) {
    setup.latch = false;
    if (setup.counter.mode == CounterMode::learned) setup.counter.mode = CounterMode::count_1_63;
    return setup;
  }

  struct Open {
    std::uint64_t begin = 0;
    std::uint64_t end = 0;  // its last cycle
    bool counts = false;
    std::uint64_t reaction = 0;
    std::optional<SafetyVerdict> verdict{};
    bool wrong = false;
  };

  // The next cycle that was made.
  void pass() {
    now_ = waiting_.front();
    waiting_.pop_front();
    if (open_ && now_.number > open_->end + reaction_cycles && is_over(*open_)) close();
    if (now_.struck) strike();
  }

  // Only where the monitor was safe can a fault do harm, and be the cause of what follows. One that
  // strikes before it is safe again counts with the one before; so does one in the next cycle if
  // nothing tells that it is not the same.
  void strike() {
    if (open_ && now_.begins && is_over(*open_)) close();
    if (!open_) open_ = Open{.begin = now_.number, .counts = safe_};
    open_->end = now_.number;
  }

  // It did no harm, or what it did is over.
  bool is_over(const Open& fault) const { return safe_ || !fault.verdict; }

  void note(SafetyVerdict verdict, const std::optional<Frame>& frame) {
    safe_ = verdict == SafetyVerdict::safe;
    const bool wrong = safe_ && frame && is_wrong(*frame);
    if (!open_) {
      ++counts_.undamaged;
      if (is_fault(verdict)) ++counts_.false_alarms;
      if (wrong) ++counts_.wrong_alone;
      return;
    }
    if (wrong) open_->wrong = true;
    if (!is_fault(verdict) || open_->verdict) return;
    open_->verdict = verdict;
    open_->reaction = now_.number - open_->begin;
  }

  // A frozen encoder means what it sends; it is the position of another moment all the same.
  bool is_wrong(const Frame& frame) const {
    if (kind_ == sim::FaultKind::frozen && now_.struck) return true;
    return frame.channel_list[cpw_].position != now_.position;
  }

  void close() {
    if (!open_) return;
    const Open fault = *std::exchange(open_, std::nullopt);
    if (!fault.counts) return;
    ++counts_.committed;
    if (fault.wrong) ++counts_.accepted_wrong;
    if (fault.verdict) {
      ++counts_.detected;
      ++counts_.verdicts[static_cast<std::size_t>(*fault.verdict)];
      counts_.reaction = std::max(counts_.reaction, fault.reaction);
    }
  }

  decode::SafetyWatch watch_;
  sim::FaultKind kind_;
  std::size_t cpw_;
  std::deque<Truth> waiting_;
  Truth now_;
  std::optional<Open> open_;
  bool safe_ = false;
  LineCounts counts_;
};

LineCounts count(const EvidenceQuestion& question, sim::LineSetup setup, sim::FaultKind kind) {
  setup.faults = {{.kind = kind, .share = (std::uint64_t{1} << 32U) / spacing}};
  sim::Line line(setup);
  FaultWatch watch(question, kind);
  decode::Decoder decoder(
      decode::CycleReader(setup.format, setup.timing),
      [&](const decode::Cycle& cycle) { watch.row(cycle, period_of(clock) / 2); });
  decoder.push_ma({{}, wire::Level::high});
  decoder.push_slo({{}, wire::Level::high});
  for (std::uint64_t i = 0; i < question.options.cycles; ++i) {
    const sim::SimulatedCycle& cycle = line.next();
    watch.expect({i, cycle.time, cycle.sent.channel_list[question.setup.cpw].position,
                  (cycle.faults & sim::set_of(kind)) != 0, !cycle.strikes.empty()});
    decoder.push(cycle.edges, {.ma = sim::ma_line, .slo = sim::slo_line});
  }
  decoder.finish(line.end() + milliseconds(2));
  return watch.finish();
}

CoverageRow row_of(sim::FaultKind kind, const LineCounts& counts) {
  CoverageRow row{.kind = iec_kind_of(name_of(kind)),
                  .by = "line",
                  .fault = std::string(name_of(kind)),
                  .committed = counts.committed,
                  .detected = counts.detected,
                  .accepted_wrong = counts.accepted_wrong,
                  .theory = {},
                  .reaction = {},
                  .verdicts = verdicts_text(counts.verdicts)};
  if (counts.detected != 0) row.reaction = counts.reaction;
  set_share(row);
  return row;
}

LineChoice line_of(const EvidenceQuestion& question) {
  LineOptions options;
  const std::string name(format_text(question.format).view());
  const DeviceChoice named = parse_device(question.options.format);
  options.device.format = named ? question.options.format : name;
  if (!named || named.device->entry == nullptr) options.device.timeout = "adaptive";
  options.clock = clock;
  options.cable = cable;
  options.rate = question.rate;
  options.motion = "random";
  options.seed = question.options.seed;
  if (question.setup.counter.mode == CounterMode::count_0_63) options.counter = "count_0_63";
  LineChoice choice = choose_line(options);
  if (!choice.error.empty()) choice.error = "the line model, 10 MHz, 20 m: " + choice.error;
  return choice;
}

std::vector<LineCounts> count_all(const EvidenceQuestion& question, const sim::LineSetup& setup) {
  std::vector<LineCounts> counts(sim::simulated_fault_count);
  lab::parallel_for(question.threads, counts.size(), [&](std::size_t k) {
    counts[k] = count(question, setup, static_cast<sim::FaultKind>(k));
  });
  return counts;
}

}  // namespace

std::string_view iec_kind_of(std::string_view sim_fault) {
  static const std::map<std::string_view, std::string_view> kinds{{"no_answer", "loss"},
                                                                  {"cut", "loss"},
                                                                  {"ma_low", "loss"},
                                                                  {"ma_high", "loss"},
                                                                  {"exchange", "loss"},
                                                                  {"brown_out", "loss"},
                                                                  {"loss", "loss"},
                                                                  {"repeat", "repetition"},
                                                                  {"lc_frozen", "repetition"},
                                                                  {"reorder", "sequence"},
                                                                  {"lc_restart", "sequence"},
                                                                  {"delay", "delay"},
                                                                  {"insert", "insertion"},
                                                                  {"masquerade", "masquerade"},
                                                                  {"other_encoder", "addressing"},
                                                                  {"nE", "(encoder's word)"},
                                                                  {"nW", "(encoder's word)"},
                                                                  {"frozen", "(encoder)"}};
  const auto found = kinds.find(sim_fault);
  return found == kinds.end() ? "corruption" : found->second;
}

EvidencePart evidence_line(const EvidenceQuestion& question) {
  EvidencePart part;
  const LineChoice line = line_of(question);
  if (!line) {
    part.error = line.error;
    return part;
  }
  report::StringSink sink;
  using report::Kind;
  const std::vector<report::Column> columns = {
      {.name = "fault"},
      {.name = "cycles", .kind = Kind::unsigned_integer},
      {.name = "undamaged", .kind = Kind::unsigned_integer},
      {.name = "false_alarms", .kind = Kind::unsigned_integer},
      {.name = "committed", .kind = Kind::unsigned_integer},
      {.name = "detected", .kind = Kind::unsigned_integer},
      {.name = "accepted_wrong", .kind = Kind::unsigned_integer},
      {.name = "reaction_cycles", .kind = Kind::unsigned_integer},
      {.name = "verdicts"}};
  const auto table = report::make_table_writer(report::Format::csv, columns, sink);
  const std::vector<LineCounts> all = count_all(question, *line.setup);
  for (std::size_t k = 0; k < all.size(); ++k) {
    const LineCounts& counts = all[k];
    CoverageRow row = row_of(static_cast<sim::FaultKind>(k), counts);
    const report::Cell cells[] = {
        row.fault,     question.options.cycles, counts.undamaged,   counts.false_alarms,
        row.committed, counts.detected,         row.accepted_wrong, report::Cell(row.reaction),
        row.verdicts};
    table->row(cells);
    if (counts.false_alarms != 0) {
      part.findings.push_back(
          fmt::format("line.csv, {}: {} undamaged frames were a fault, or a fault was told late",
                      row.fault, counts.false_alarms));
    }
    if (counts.wrong_alone != 0) {
      part.findings.push_back(
          fmt::format("line.csv, {}: {} frames away from any fault were safe "
                      "with a position that was not sent",
                      row.fault, counts.wrong_alone));
    }
    part.coverage.push_back(std::move(row));
  }
  table->finish();
  part.files.push_back({"line.csv", sink.text()});
  return part;
}

}  // namespace biss::cli
