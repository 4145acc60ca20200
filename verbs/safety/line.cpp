// biss safety line: every fault of the line model, read by the decoder and judged by the monitor.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <deque>
#include <memory>
#include <mutex>
#include <utility>

#include "biss/frame/format_text.hpp"
#include "decode/decoder.hpp"
#include "decode/safety_watch.hpp"
#include "lab/experiment.hpp"
#include "sim/line.hpp"
#include "verbs/common/terminal.hpp"
#include "verbs/common/verb.hpp"
#include "verbs/decode/safety.hpp"
#include "verbs/safety/experiments.hpp"
#include "verbs/safety/safety.hpp"
#include "verbs/simulate/setup.hpp"

namespace biss::verbs {
namespace {

// One cycle of this many has the fault.
constexpr std::uint64_t spacing = 32;
constexpr Hertz line_clock = megahertz(10);
constexpr Millimetres line_cable = metres(20);
// A fault shows in its own cycles, or in the next one if it begins after the last bit.
constexpr std::uint64_t reaction_cycles = 1;
// The simulator's times hold 106 days.
constexpr Picoseconds longest_run = milliseconds(100LL * 24 * 3600 * 1000);

struct Truth {
  std::uint64_t number = 0;
  Picoseconds time{};
  std::optional<std::uint64_t> position;  // nothing was sent
  bool faulty = false;
  bool begins = false;  // the fault has a place in this cycle; others affect whole cycles
};

// Follows each fault from its first cycle until the monitor is safe again.
class FaultWatch {
 public:
  FaultWatch(const SafetyFormat& monitored, sim::FaultKind kind)
      : watch_(monitored.format, without_latch(monitored.setup)),
        kind_(kind),
        cpw_(monitored.setup.cpw) {}

  void expect(const Truth& truth) { waiting_.push_back(truth); }

  void row(const decode::Cycle& cycle, Picoseconds tolerance) {
    while (!waiting_.empty() && waiting_.front().time < cycle.time - tolerance) pass();
    const bool known = !waiting_.empty() && waiting_.front().time <= cycle.time + tolerance;
    const auto verdict = watch_.judge(cycle);
    if (known) pass();
    // Otherwise this is a row at a time without a request.
    if (verdict) note(*verdict, known ? cycle.frame : std::nullopt);
  }

  LineCounts finish() {
    while (!waiting_.empty()) pass();
    close();
    return counts_;
  }

 private:
  // So that each fault is counted.
  static SafetySetup without_latch(SafetySetup setup) {
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

  // Goes on to the next simulated cycle.
  void pass() {
    now_ = waiting_.front();
    waiting_.pop_front();
    if (open_ && now_.number > open_->end + reaction_cycles && is_over(*open_)) close();
    if (now_.faulty) begin_or_extend();
  }

  // Only a fault that begins while the monitor is safe counts: it can do harm, and it is the cause
  // of the next verdicts. A fault that begins before the monitor is safe again belongs to the one
  // before; so does a fault in the next cycle if nothing shows that it is another one.
  void begin_or_extend() {
    if (open_ && now_.begins && is_over(*open_)) close();
    if (!open_) open_ = Open{.begin = now_.number, .counts = safe_};
    open_->end = now_.number;
  }

  // The fault had no effect, or its effect is over.
  bool is_over(const Open& fault) const { return safe_ || !fault.verdict; }

  void note(SafetyVerdict verdict, const std::optional<Frame>& frame) {
    safe_ = verdict == SafetyVerdict::safe;
    const bool wrong = safe_ && frame && is_wrong(*frame);
    if (!open_) {
      ++counts_.undamaged;
      if (is_fault(verdict)) ++counts_.false_alarms;
      if (wrong) ++counts_.wrong_undamaged;
      return;
    }
    if (wrong) open_->wrong = true;
    if (!is_fault(verdict) || open_->verdict) return;
    open_->verdict = verdict;
    open_->reaction = now_.number - open_->begin;
  }

  // A frozen encoder sends the frame that it means to send, but with the position of an earlier
  // cycle.
  bool is_wrong(const Frame& frame) const {
    if (kind_ == sim::FaultKind::frozen && now_.faulty) return true;
    return frame.channel_list[cpw_].position != now_.position;
  }

  void close() {
    if (!open_) return;
    const Open fault = *std::exchange(open_, std::nullopt);
    if (!fault.counts) return;
    ++counts_.injected;
    if (fault.wrong) ++counts_.accepted_wrong;
    if (fault.verdict) {
      ++counts_.detected;
      ++counts_.verdicts[index_of(*fault.verdict)];
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

LineCounts count(const SafetyFormat& monitored, sim::LineSetup setup, sim::FaultKind kind,
                 std::uint64_t cycles, Host& host) {
  setup.faults = {{.kind = kind, .share = (std::uint64_t{1} << 32U) / spacing}};
  sim::Line line(setup);
  FaultWatch watch(monitored, kind);
  decode::Decoder decoder(
      decode::CycleReader(setup.format, setup.timing),
      [&](const decode::Cycle& cycle) { watch.row(cycle, period_of(line_clock) / 2); });
  decoder.push_ma({{}, wire::Level::high});
  decoder.push_slo({{}, wire::Level::high});
  for (std::uint64_t i = 0; i < cycles; ++i) {
    if (i % 256 == 0) host.check();
    const sim::SimulatedCycle& cycle = line.next();
    const std::size_t cpw = monitored.setup.cpw;
    watch.expect(
        {i, cycle.time,
         cycle.taken[cpw] ? std::optional(cycle.sent.channel_list[cpw].position) : std::nullopt,
         (cycle.faults & sim::set_of(kind)) != 0, !cycle.injected.empty()});
    decoder.push(cycle.edges, {.ma = sim::ma_line, .slo = sim::slo_line});
  }
  decoder.finish(line.end() + milliseconds(2));
  return watch.finish();
}

sim::LineSetup line_of(const SafetyFormat& monitored, const LineRequest& request) {
  LineOptions line;
  const auto device = parse_device(monitored.device);
  line.device.format =
      device ? monitored.device : std::string(format_text(monitored.format).view());
  if (!device || !device->timing_known()) line.device.timeout = "adaptive";
  line.setup.clock = line_clock;
  line.cable = line_cable;
  line.rate = request.rate.value_or(rate_of_cycle(monitored.setup));
  line.motion = "random";
  line.setup.seed = request.seed;
  if (monitored.setup.counter.mode == CounterMode::count_0_63) line.counter = "count_0_63";
  return value_or_fail(line_setup(line).map_error(
      [](const std::string& error) { return "the line model, 10 MHz, 20 m: " + error; }));
}

ExitStatus run_line(const LineRequest& request, Host& host) {
  const LineResult counts = run_line_model(monitored_by(request.format), request, host);
  const ExitStatus status = print_rows(line_table(counts, request.cycles), request, host);
  return status == ExitStatus::done ? judge_line(counts, host) : status;
}

}  // namespace

LineResult run_line_model(const SafetyFormat& monitored, const LineRequest& request, Host& host) {
  const sim::LineSetup line = line_of(monitored, request);
  const Picoseconds interval = sim::Line(line).nominal().interval;
  const auto most = static_cast<std::uint64_t>(longest_run.count / interval.count);
  if (request.cycles > most) {
    throw wrong_usage("--cycles: the line model holds 100 days, {} cycles at this rate", most);
  }
  LineResult all;
  Progress progress(host);
  std::mutex mutex;
  std::size_t done = 0;
  lab::parallel_for(request.threads, all.size(), [&](std::size_t k) {
    all[k] = count(monitored, line, static_cast<sim::FaultKind>(k), request.cycles, host);
    const std::lock_guard lock(mutex);
    ++done;
    if (progress.due()) {
      progress.show(progress_text({.done = done, .all = all.size()}, "faults", progress.seconds()));
    }
  });
  return all;
}

std::vector<FieldRow> line_table(const LineResult& result, std::uint64_t cycles) {
  std::vector<FieldRow> table;
  for (std::size_t k = 0; k < result.size(); ++k) {
    const LineCounts& counts = result[k];
    table.push_back(
        {{"fault", name_of(static_cast<sim::FaultKind>(k))},
         {"cycles", cycles},
         {"undamaged", counts.undamaged},
         {"false_alarms", counts.false_alarms},
         {"injected", counts.injected},
         {"detected", counts.detected},
         {"accepted_wrong", counts.accepted_wrong},
         {"reaction_cycles", counts.detected == 0 ? std::nullopt : std::optional(counts.reaction)},
         {"verdicts", verdicts_text(counts.verdicts)}});
  }
  return table;
}

ExitStatus judge_line(const LineResult& result, Host& host) {
  ExitStatus status = ExitStatus::done;
  for (std::size_t k = 0; k < result.size(); ++k) {
    const auto name = name_of(static_cast<sim::FaultKind>(k));
    const auto judge = [&](std::uint64_t count, const char* what) {
      if (count == 0) return;
      status = host.fail(ExitStatus::data_failed,
                         fmt::format("{}: {} frames without a fault {}", name, count, what));
    };
    judge(result[k].false_alarms, "have a fault verdict");
    judge(result[k].wrong_undamaged, "are safe with a wrong position");
  }
  return status;
}

std::string verdicts_text(const std::array<std::uint64_t, safety_verdict_count>& counts) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (counts[i] != 0) order.push_back(i);
  }
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return counts[a] > counts[b]; });
  std::string text;
  for (const std::size_t i : order) {
    text += fmt::format("{}{}:{}", text.empty() ? "" : " ", name_of(verdict_of(i)), counts[i]);
  }
  return text;
}

Run add_safety_line(Verb verb) {
  const auto options = std::make_shared<LineRequest>();
  add_safety_format_option(verb, options->format).required();
  add_count_option(verb, "--cycles", into(options->cycles),
                   "Cycles for each kind of fault, one in 32 with the fault; 50000 by default",
                   most_line_cycles);
  add_rate_option(verb, "--rate", into(options->rate),
                  "Requests per second; by default 1 / the configuration's shortest cycle");
  add_seed_option(verb, options->seed);
  add_threads_option(verb, options->threads);
  add_to_option(verb, options->to);
  add_output_option(verb, options->output);
  return [options](Host& host) { return run_line(*options, host); };
}

}  // namespace biss::verbs
