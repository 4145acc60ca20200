#include "verbs/draw/simulated.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "decode/cycle_edges.hpp"
#include "device/quantity.hpp"
#include "sim/line.hpp"
#include "verbs/simulate/fault_option.hpp"

namespace biss::verbs {

namespace {

tl::unexpected<VerbError> wrong_usage(std::string text) {
  return tl::unexpected(VerbError{ExitStatus::usage, std::move(text)});
}

std::uint64_t first_fault(const sim::LineSetup& setup) {
  std::optional<std::uint64_t> first;
  for (const sim::FaultRule& rule : setup.faults) {
    if (rule.cycle) first = std::min(first.value_or(*rule.cycle), *rule.cycle);
  }
  return first.value_or(0);
}

// Faults of the requests that a drawn cycle begins with: it may begin with a pulse.
std::string faults_of(const std::vector<sim::SimulatedCycle>& requests, Picoseconds time) {
  const auto after =
      std::find_if(requests.begin(), requests.end(),
                   [&](const sim::SimulatedCycle& request) { return request.time > time; });
  if (after == requests.begin()) return {};
  const sim::SimulatedCycle& request = *std::prev(after);
  const std::string placed = text_of(request.injected);
  return placed.empty() ? sim::text_of(request.faults) : placed;
}

// Runs the line up to this many requests, and draws the cycles from `first` on.
std::vector<SimulatedDrawing> run_line(const sim::LineSetup& setup, std::uint64_t first,
                                       std::uint64_t requests) {
  std::vector<SimulatedDrawing> drawn;
  const decode::MarginSetup margin{.compensated = setup.compensate};
  decode::CycleEdgeReader reader(
      decode::CycleReader(setup.format, setup.timing, margin),
      {.ma = sim::ma_line, .slo = sim::slo_line}, [&](const decode::CycleEdges& edges) {
        if (edges.number < first || drawn.size() >= requests - first) return;
        drawn.push_back(
            {draw::draw_cycle(edges, setup.format, setup.timing, margin, draw::DrawnExtent::cycle),
             {}});
      });
  const wire::Edge idle[] = {{{}, sim::ma_line, wire::Level::high},
                             {{}, sim::slo_line, wire::Level::high}};
  reader.push(idle);
  sim::Line line(setup);
  std::vector<sim::SimulatedCycle> kept;
  for (std::uint64_t i = 0; i < requests; ++i) {
    const sim::SimulatedCycle& cycle = line.next();
    reader.push(cycle.edges);
    if (i + 1 < first) continue;
    kept.push_back(cycle);
    kept.back().edges.clear();
  }
  reader.finish(line.end());
  for (SimulatedDrawing& each : drawn) each.faults = faults_of(kept, each.drawing.cycle.time);
  return drawn;
}

// Clocks from ACK to START, if START was found.
std::optional<std::size_t> ack_of(const draw::CycleDrawing& drawing) {
  for (const draw::DrawnBit& bit : drawing.bits) {
    if (bit.name == "START") return bit.clock - 1;
  }
  return std::nullopt;
}

}  // namespace

tl::expected<SimulatedCycles, VerbError> draw_simulated(LineOptions line,
                                                        std::optional<std::uint64_t> ack_clocks,
                                                        std::optional<std::uint64_t> first,
                                                        std::uint64_t count) {
  auto setup = line_setup(line);
  if (!setup) return wrong_usage(setup.error());
  if (const std::string wrong = wrong_start(*setup); !wrong.empty()) return wrong_usage(wrong);
  if (ack_clocks) {
    const Picoseconds period = period_of(line.clock);
    setup->processing = static_cast<std::int64_t>(*ack_clocks) * period - period / 2;
  }
  const std::uint64_t begin = first.value_or(first_fault(*setup));
  if (begin + count > simulated_cycles_max) {
    return wrong_usage(fmt::format("--cycle: a simulated line has {} cycles here; draw a capture",
                                   simulated_cycles_max));
  }
  const std::uint64_t requests = begin + count;
  const auto checked = check_faults(setup->faults, sim::Line(*setup).nominal(), requests);
  if (!checked) return wrong_usage(checked.error());
  SimulatedCycles cycles{setup->format, run_line(*setup, begin, requests)};
  if (cycles.cycles.empty()) {
    return tl::unexpected(VerbError{
        ExitStatus::data_failed,
        fmt::format("no cycle {}: with these faults fewer cycles are on the line", begin)});
  }
  const auto ack = ack_of(cycles.cycles.front().drawing);
  if (ack_clocks && setup->faults.empty() && ack && *ack != *ack_clocks) {
    return wrong_usage(
        fmt::format("--ack: this encoder answers after {} clock{} at {}, not after {}", *ack,
                    *ack == 1 ? "" : "s", text_of(line.clock), *ack_clocks));
  }
  return cycles;
}

}  // namespace biss::verbs
