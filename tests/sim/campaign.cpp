#include "tests/sim/campaign.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <deque>
#include <span>

#include "decode/decoder.hpp"

namespace biss::campaign {

namespace {

struct Truth {
  std::uint64_t number = 0;
  Picoseconds time{};
  Frame sent;
  sim::FaultSet faults = 0;
  sim::FaultSet before = 0;
};

bool same_positions(const Frame& a, const Frame& b) {
  if (a.channel_count != b.channel_count) return false;
  return std::equal(a.channels().begin(), a.channels().end(), b.channels().begin());
}

void count(Tally& tally, const Truth& truth, const decode::Cycle* row) {
  ++tally.cycles;
  if (row == nullptr) {
    ++tally.missing;
  } else if (!row->frame || same_positions(*row->frame, truth.sent)) {
    ++tally.statuses[static_cast<std::size_t>(row->status)];
  } else {
    ++(row->frame->trusted() ? tally.wrong : tally.wrong_error);
  }
}

// Pairs the decoder's rows with the simulated cycles by time.
class Judge {
 public:
  explicit Judge(Picoseconds tolerance) : tolerance_(tolerance) {}

  void expect(const Truth& truth) { waiting_.push_back(truth); }

  void row(const decode::Cycle& cycle) {
    while (!waiting_.empty() && waiting_.front().time < cycle.time - tolerance_) settle(nullptr);
    if (waiting_.empty() || waiting_.front().time > cycle.time + tolerance_) {
      ++outcome_.extra_rows;
      return;
    }
    settle(&cycle);
  }

  Outcome finish() {
    while (!waiting_.empty()) settle(nullptr);
    return outcome_;
  }

  Outcome& outcome() { return outcome_; }

 private:
  void settle(const decode::Cycle* row) {
    const Truth truth = waiting_.front();
    waiting_.pop_front();
    count(tally_of(truth), truth, row);
    if (truth.faults == 0 && truth.before == 0) complain(truth, row);
  }

  Tally& tally_of(const Truth& truth) {
    if (truth.faults == 0) return truth.before == 0 ? outcome_.undamaged : outcome_.behind;
    std::size_t kinds = 0;
    std::size_t last = 0;
    for (std::size_t k = 0; k < sim::line_fault_kind_count; ++k) {
      if (((truth.faults >> k) & 1U) == 0) continue;
      ++outcome_.injected[k];
      ++kinds;
      last = k;
    }
    if (kinds > 1) return outcome_.several;
    // A lasting fault may have begun earlier.
    return (truth.before & ~truth.faults) == 0 ? outcome_.alone[last] : outcome_.several;
  }

  void complain(const Truth& truth, const decode::Cycle* row) {
    const bool good = row != nullptr && row->frame && same_positions(*row->frame, truth.sent);
    if (good || outcome_.complaints.size() > 2000) return;
    outcome_.complaints += fmt::format("cycle {} at {} ps: {}\n", truth.number, truth.time.count,
                                       row == nullptr ? "no row" : name_of(row->status));
  }

  Picoseconds tolerance_;
  std::deque<Truth> waiting_;
  Outcome outcome_;
};

// A recorder that exchanges its probes.
class Recorder {
 public:
  explicit Recorder(const ProbeExchange& probes) : probes_(probes) {}

  /// Whether the probes are exchanged during part of this cycle.
  bool spoils(std::uint64_t number) const {
    return probes_.every != 0 && number % probes_.every >= probes_.every - probes_.length;
  }

  std::span<const wire::Edge> record(std::uint64_t number, std::span<const wire::Edge> edges) {
    if (probes_.every == 0) return edges;
    recorded_.clear();
    // The exchange begins at any edge of the first cycle and ends at any edge of the last.
    std::size_t begin = edges.size();
    std::size_t end = edges.size();
    if (spoils(number)) {
      begin = exchanged_ ? 0 : number * 7 % edges.size();
      if (!spoils(number + 1)) end = begin + number * 11 % (edges.size() - begin);
    }
    for (std::size_t i = 0; i < edges.size(); ++i) {
      if ((i >= begin && i < end) != exchanged_) exchange(edges[i].time);
      put(edges[i]);
    }
    return recorded_;
  }

 private:
  void put(const wire::Edge& edge) {
    levels_[edge.line] = edge.level;
    const auto line = static_cast<wire::LineIndex>(exchanged_ ? 1 - edge.line : edge.line);
    recorded_.push_back({edge.time, line, edge.level});
  }

  void exchange(Picoseconds time) {
    exchanged_ = !exchanged_;
    if (levels_[sim::ma_line] == levels_[sim::slo_line]) return;
    for (const wire::LineIndex line : {sim::ma_line, sim::slo_line}) {
      put({time, line, levels_[line]});
    }
  }

  ProbeExchange probes_;
  bool exchanged_ = false;
  std::array<wire::Level, 2> levels_{wire::Level::high, wire::Level::high};
  std::vector<wire::Edge> recorded_;
};

}  // namespace

std::vector<sim::FaultRule> all_faults(std::uint64_t share) {
  std::vector<sim::FaultRule> rules;
  for (std::size_t k = 0; k < sim::line_fault_kind_count; ++k) {
    rules.push_back({.kind = static_cast<sim::FaultKind>(k), .share = share});
  }
  return rules;
}

Outcome run(const sim::LineSetup& setup, std::uint64_t cycles, const ProbeExchange& probes) {
  sim::Line line(setup);
  Recorder recorder(probes);
  Judge judge(period_of(setup.clock) / 2);
  decode::Decoder decoder(decode::CycleReader(setup.format, setup.timing),
                          [&](const decode::Cycle& cycle) { judge.row(cycle); });
  decoder.push_ma({{}, wire::Level::high});
  decoder.push_slo({{}, wire::Level::high});
  sim::FaultSet before = 0;
  for (std::uint64_t i = 0; i < cycles; ++i) {
    const sim::SimulatedCycle& cycle = line.next();
    const sim::FaultSet faults =
        cycle.faults | (recorder.spoils(i) ? set_of(sim::FaultKind::exchange) : sim::FaultSet{});
    judge.expect({i, cycle.time, cycle.sent, faults, before});
    if (faults == 0 && before == 0) {
      const auto& frame = cycle.reading.frame;
      if (!frame.ok()) ++judge.outcome().master_failed;
      if (frame.ok() && !same_positions(*frame, cycle.sent)) ++judge.outcome().master_wrong;
    }
    before = faults;
    decoder.push(recorder.record(i, cycle.edges), {.ma = sim::ma_line, .slo = sim::slo_line});
  }
  decoder.finish(line.end() + milliseconds(2));
  return judge.finish();
}

}  // namespace biss::campaign
