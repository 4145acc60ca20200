// Every fault of the line model on its own, read back by the decoder and judged by the monitor.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "biss/frame/format_print.hpp"
#include "decode/decoder.hpp"
#include "report/table.hpp"
#include "sim/line.hpp"
#include "tools/quantity.hpp"
#include "tools/safety_evidence.hpp"
#include "tools/simulate_setup.hpp"

namespace biss::tools {
namespace {

// One request in so many has the fault.
constexpr std::uint64_t spacing = 32;
constexpr Hertz clock = megahertz(10);
constexpr Millimetres cable = metres(20);
// Behind the longest fault, three cycles, and what it does to the next one.
constexpr std::uint64_t settled_cycles = 6;

struct Truth {
  std::uint64_t number = 0;
  Picoseconds time{};
  std::uint64_t position = 0;
  bool struck = false;
};

struct LineCounts {
  std::uint64_t committed = 0;
  std::uint64_t detected = 0;
  std::uint64_t accepted_wrong = 0;
  std::uint64_t reaction = 0;
  std::array<std::uint64_t, safety_verdict_count> verdicts{};
  /// Verdicts on requests that no fault has touched.
  std::uint64_t undamaged = 0;
  std::uint64_t false_alarms = 0;
};

// Follows one fault from the cycle it strikes until the monitor is safe again.
class FaultWatch {
 public:
  FaultWatch(const EvidenceQuestion& question, sim::FaultKind kind)
      : watch_(question.format, each_alone(question.setup)),
        kind_(kind),
        cpw_(question.setup.cpw),
        settled_(settled_cycles + question.setup.start_frames) {}

  void expect(const Truth& truth) { waiting_.push_back(truth); }

  void row(const decode::Cycle& cycle, Picoseconds tolerance) {
    while (!waiting_.empty() && waiting_.front().time < cycle.time - tolerance) pass();
    const bool known = !waiting_.empty() && waiting_.front().time <= cycle.time + tolerance;
    const auto verdict = watch_.judge(cycle);
    if (!known) {  // a row of its own, where no request was
      if (verdict) note(*verdict, cycle, nullptr);
      return;
    }
    const Truth truth = pass();
    if (verdict) note(*verdict, cycle, &truth);
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

  // The next cycle that was made.
  Truth pass() {
    const Truth truth = waiting_.front();
    waiting_.pop_front();
    if (open_ && truth.number >= quiet_until_) close();
    // Only where the monitor was safe can a fault do harm, and be the cause of what follows. One
    // that strikes again before that counts with the one before.
    if (truth.struck && !open_ && safe_) open_ = Open{.begin = truth.number};
    if (truth.struck) quiet_until_ = truth.number + settled_;
    return truth;
  }

  void note(SafetyVerdict verdict, const decode::Cycle& cycle, const Truth* truth) {
    safe_ = verdict == SafetyVerdict::safe;
    if (!open_) {
      if (truth == nullptr || truth->number < quiet_until_) return;
      ++counts_.undamaged;
      if (is_fault(verdict)) ++counts_.false_alarms;
      return;
    }
    if (is_fault(verdict) && !open_->verdict) {
      open_->verdict = verdict;
      if (truth != nullptr) open_->reaction = truth->number - open_->begin;
    }
    if (safe_ && truth != nullptr && cycle.frame && is_wrong(*cycle.frame, *truth)) {
      open_->wrong = true;
    }
  }

  // A frozen encoder means what it sends; it is the position of another moment all the same.
  bool is_wrong(const Frame& frame, const Truth& truth) const {
    if (kind_ == sim::FaultKind::frozen && truth.struck) return true;
    return frame.channel_list[cpw_].position != truth.position;
  }

  void close() {
    if (!open_) return;
    ++counts_.committed;
    if (open_->wrong) ++counts_.accepted_wrong;
    if (open_->verdict) {
      ++counts_.detected;
      ++counts_.verdicts[static_cast<std::size_t>(*open_->verdict)];
      counts_.reaction = std::max(counts_.reaction, open_->reaction);
    }
    open_.reset();
  }

  struct Open {
    std::uint64_t begin = 0;
    std::uint64_t reaction = 0;
    std::optional<SafetyVerdict> verdict{};
    bool wrong = false;
  };

  SafetyWatch watch_;
  sim::FaultKind kind_;
  std::size_t cpw_;
  std::uint64_t settled_;
  std::deque<Truth> waiting_;
  std::optional<Open> open_;
  std::uint64_t quiet_until_ = 0;
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
                  (cycle.faults & sim::set_of(kind)) != 0});
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
  std::vector<LineCounts> counts(sim::fault_kind_count);
  std::atomic<std::size_t> next = 0;
  std::vector<std::jthread> threads;
  const unsigned cores = std::max(1U, std::thread::hardware_concurrency());
  for (unsigned n = 0; n < (question.threads == 0 ? cores : question.threads); ++n) {
    threads.emplace_back([&] {
      for (std::size_t k = next++; k < counts.size(); k = next++) {
        counts[k] = count(question, setup, static_cast<sim::FaultKind>(k));
      }
    });
  }
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
      part.findings.push_back(fmt::format("line.csv, {}: {} undamaged frames were a fault",
                                          row.fault, counts.false_alarms));
    }
    part.coverage.push_back(std::move(row));
  }
  table->finish();
  part.files.push_back({"line.csv", sink.text()});
  return part;
}

}  // namespace biss::tools
