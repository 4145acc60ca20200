#include "tests/sim/clean_capture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "biss/timing/cable.hpp"
#include "decode/decoder.hpp"
#include "sim/line.hpp"
#include "sim/random.hpp"

namespace biss::campaign {

namespace {

// A number from `least` to `most`.
std::int64_t draw(sim::Random& random, std::int64_t least, std::int64_t most) {
  const auto width = static_cast<std::uint64_t>(most - least) + 1U;
  return least + static_cast<std::int64_t>(random.next() % width);
}

Hertz draw_clock(sim::Random& random, const DeviceTiming& timing) {
  constexpr std::array usual{80U,    250U,   500U,   1'000U, 2'000U,
                             2'500U, 4'000U, 5'000U, 8'000U, 10'000U};
  for (int i = 0; i < 50; ++i) {
    const bool is_usual = draw(random, 0, 1) == 0;
    const Hertz clock = is_usual
                            ? kilohertz(usual[random.next() % usual.size()])
                            : Hertz{static_cast<std::uint32_t>(draw(random, 80'000, 10'000'000))};
    if (clock >= timing.clock_min && clock <= timing.clock_max) return clock;
  }
  return timing.clock_max;
}

void draw_line(sim::Random& random, sim::LineSetup& setup) {
  const Picoseconds period = period_of(setup.clock);
  const Millimetres longest = *cable_max_compensated(setup.clock);
  const Picoseconds cable = cable_delay(millimetres(draw(random, 0, longest.count)));
  setup.ma_delay = cable / 2;
  setup.slo_delay = cable - cable / 2;
  setup.internal_delay = picoseconds(draw(random, 0, setup.timing.internal_delay_max.count));
  const Picoseconds jitter = std::min(period / 50, nanoseconds(4));
  setup.ma_jitter = std::min(jitter, setup.ma_delay);
  setup.slo_jitter = std::min(jitter, setup.slo_delay + setup.internal_delay);
  setup.processing = picoseconds(draw(random, 0, setup.timing.ack_max.count * 9 / 10));
  setup.clock_error_ppm = static_cast<std::int32_t>(draw(random, -300, 300));
  setup.duty_per_mille = static_cast<std::uint32_t>(draw(random, 430, 570));
  // Requests as soon as every decoder sees the pause between them, or later.
  if (draw(random, 0, 2) != 0) {
    setup.interval = sim::least_interval(setup) + nanoseconds(draw(random, 0, 300'000));
  }
  setup.motion = static_cast<sim::MotionKind>(draw(random, 0, 4));
  setup.life.first = draw(random, 0, 1) == 0 ? 0 : 1;
  setup.seed = random.next();
}

// The part of the capture that the analyser records.
std::vector<wire::Edge> recorded(const std::vector<wire::Edge>& edges,
                                 const CleanCapture& capture) {
  const Picoseconds length = edges.back().time;
  const Picoseconds begin = length / 1'000 * capture.from;
  const Picoseconds end = length / 1'000 * capture.to;
  std::vector<wire::Edge> seen{{begin, sim::ma_line, wire::Level::high},
                               {begin, sim::slo_line, wire::Level::high}};
  for (const wire::Edge& edge : edges) {
    if (edge.time <= begin) seen[edge.line].level = edge.level;
    if (edge.time > begin && (edge.time <= end || capture.to == 1'000)) seen.push_back(edge);
  }
  return seen;
}

// As an analyser with this sample period sees them: at the next sample. Of two in between, none.
std::vector<wire::Edge> sampled(const std::vector<wire::Edge>& edges, const CleanCapture& capture) {
  std::vector<wire::Edge> seen;
  std::array<wire::Level, 2> levels{};
  const auto sample_of = [&](const wire::Edge& edge) {
    return (edge.time - capture.phase).count / capture.sample.count + 1;
  };
  for (std::size_t i = 0; i < edges.size();) {
    const std::int64_t sample = sample_of(edges[i]);
    std::array<wire::Level, 2> now = levels;
    for (; i < edges.size() && sample_of(edges[i]) == sample; ++i) {
      now[edges[i].line] = edges[i].level;
    }
    for (const wire::LineIndex each : {sim::ma_line, sim::slo_line}) {
      if (now[each] == levels[each]) continue;
      seen.push_back({sample * capture.sample + capture.phase, each, now[each]});
    }
    levels = now;
  }
  return seen;
}

}  // namespace

CleanCapture clean_capture(std::uint64_t number) {
  sim::Random random(sim::scrambled(number + 1));
  CleanCapture capture;
  capture.entry = &catalogue[number % catalogue.size()];
  sim::LineSetup& setup = capture.setup;
  setup.format = capture.entry->frame_format();
  setup.timing = capture.entry->timing;
  setup.clock = draw_clock(random, setup.timing);
  draw_line(random, setup);
  capture.cycles = static_cast<std::uint64_t>(draw(random, 5, 80));
  if (draw(random, 0, 2) == 0) {
    capture.from = draw(random, 0, 400);
    capture.to = draw(random, 600, 1'000);
  }
  if (draw(random, 0, 3) == 0) return capture;
  // From 3 to 100 samples in a period.
  const std::int64_t samples = 3 + draw(random, 0, 97) * draw(random, 0, 100) / 100;
  capture.sample = std::max(period_of(setup.clock) / samples, picoseconds(500));
  capture.phase = picoseconds(draw(random, 0, capture.sample.count - 1));
  return capture;
}

std::string CleanCapture::name() const {
  return fmt::format(
      "{} {} Hz {} ppm, duty {}, line delay {}+{}+{} ps, jitter {} {} ps, "
      "processing {} ps, interval {} ps, {} cycles, {} to {} thousandths, sample {} ps + {} ps",
      entry->name, setup.clock.count, setup.clock_error_ppm, setup.duty_per_mille,
      setup.ma_delay.count, setup.internal_delay.count, setup.slo_delay.count,
      setup.ma_jitter.count, setup.slo_jitter.count, setup.processing.count, setup.interval.count,
      cycles, from, to, sample.count, phase.count);
}

std::vector<wire::Edge> edges_of(const CleanCapture& capture) {
  std::vector<wire::Edge> edges;
  sim::Line line(capture.setup);
  for (std::uint64_t i = 0; i < capture.cycles; ++i) {
    const sim::SimulatedCycle& cycle = line.next();
    edges.insert(edges.end(), cycle.edges.begin(), cycle.edges.end());
  }
  edges = recorded(edges, capture);
  return capture.sample == Picoseconds{} ? edges : sampled(edges, capture);
}

decode::CheckSetup own_limits(const CleanCapture& capture) {
  const bool renishaw = capture.entry->vendor == "Renishaw";
  return {.format = capture.setup.format,
          .timing = capture.setup.timing,
          .unidirectional = renishaw,
          .renishaw_cables = renishaw,
          .resolution = capture.sample};
}

std::string failing_rules(const CleanCapture& capture, const decode::CheckSetup& setup) {
  decode::Check check(setup);
  std::uint64_t number = 0;
  decode::Decoder decoder(
      decode::CycleReader(
          setup.format, setup.timing,
          {.compensated = setup.compensated, .resolution = setup.resolution, .signal = true}),
      [&](const decode::Cycle& cycle) { check.push(number++, cycle); });
  const std::vector<wire::Edge> edges = edges_of(capture);
  decoder.push(edges, {.ma = sim::ma_line, .slo = sim::slo_line});
  decoder.finish(edges.back().time + (capture.to == 1'000 ? microseconds(100) : Picoseconds{}));
  check.finish();
  std::string failing;
  for (std::size_t i = 0; i < decode::rule_count; ++i) {
    const auto rule = static_cast<decode::Rule>(i);
    const decode::RuleResult result = check.result(rule);
    if (result.verdict != decode::Verdict::fail) continue;
    const decode::Measured measured = result.measured.value_or(decode::Measured{});
    failing += fmt::format("{} limit {} worst {} in cycle {}, {} of {} cases; {}\n",
                           text_of(rule).name, measured.limit, measured.worst,
                           result.cycle.value_or(0), result.faults, result.cases, result.note);
  }
  return failing;
}

}  // namespace biss::campaign
