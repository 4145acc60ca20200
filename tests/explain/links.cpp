#include "tests/explain/links.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "biss/catalogue/catalogue.hpp"
#include "biss/frame/format_text.hpp"
#include "biss/timing/cable.hpp"
#include "sim/line.hpp"
#include "sim/ma_replay.hpp"
#include "sim/random.hpp"

namespace biss::explain::test {

namespace {

using sim::FaultKind;
using sim::Random;
using wire::Edge;
using wire::Level;

constexpr std::uint64_t shares = std::uint64_t{1} << 32U;

std::uint64_t between(Random& random, std::uint64_t least, std::uint64_t most) {
  return least + random.below(most - least + 1U);
}
bool one_in(Random& random, std::uint64_t n) { return random.below(n) == 0; }

const CatalogueEntry& any_encoder(Random& random) {
  return catalogue[static_cast<std::size_t>(random.below(catalogue.size()))];
}

// A random encoder at a random clock with a random cable that a compensating master allows.
sim::LineSetup any_line(Random& random, Link& link) {
  const CatalogueEntry& entry = any_encoder(random);
  sim::LineSetup setup;
  setup.format = entry.frame_format();
  setup.timing = entry.timing;
  const std::uint64_t least = std::max<std::uint64_t>(entry.timing.clock_min.count, 100'000);
  const std::uint64_t most = entry.timing.clock_max.count;
  // Even on a logarithmic scale.
  std::uint64_t clock = most;
  for (std::uint64_t i = random.below(6); i > 0; --i) clock = std::max(least, clock / 2);
  clock = between(random, std::max(least, clock / 2), clock);
  setup.clock = hertz(static_cast<std::uint32_t>(clock));
  const auto longest = cable_max_compensated(setup.clock).value_or(metres(10));
  const auto cable = millimetres(static_cast<std::int64_t>(
      random.below(static_cast<std::uint64_t>(longest.count) / (one_in(random, 3) ? 1 : 5) + 1)));
  setup.ma_delay = setup.slo_delay = cable_delay(cable) / 2;
  setup.internal_delay = entry.timing.internal_delay_max;
  setup.processing = picoseconds(static_cast<std::int64_t>(
      random.below(static_cast<std::uint64_t>(entry.timing.ack_max.count) / 2 + 1)));
  setup.motion = static_cast<sim::MotionKind>(random.below(5));
  setup.seed = random.next();
  const Picoseconds jitter = std::min(period_of(setup.clock) / 60, setup.slo_delay);
  if (one_in(random, 3)) setup.ma_jitter = setup.slo_jitter = jitter;
  link.format = setup.format;
  link.timing = setup.timing;
  link.story = fmt::format("{} at {} kHz, {} m, motion {}", entry.name, clock / 1000,
                           cable.count / 1000, static_cast<int>(setup.motion));
  return setup;
}

void begin(Link& link) { link.edges = {{{}, 0, Level::high}, {{}, 1, Level::high}}; }

struct Run {
  std::uint64_t cycles = 0;
  std::uint64_t affected = 0;
};

Run run_line(const sim::LineSetup& setup, std::uint64_t cycles, Link& link) {
  begin(link);
  sim::Line line(setup);
  Run result{.cycles = cycles};
  for (std::uint64_t i = 0; i < cycles; ++i) {
    const sim::SimulatedCycle& cycle = line.next();
    if (cycle.faults != 0) ++result.affected;
    link.edges.insert(link.edges.end(), cycle.edges.begin(), cycle.edges.end());
  }
  link.end = line.end() + 4 * period_of(setup.clock);
  return result;
}

// Adds the faults at this share of cycles, until at least 10 of them are affected.
void run_faults(sim::LineSetup setup, const std::vector<FaultKind>& kinds, Random& random,
                Link& link) {
  const std::uint64_t percent = between(random, 4, 50);
  for (const FaultKind kind : kinds) {
    setup.faults.push_back({.kind = kind, .share = shares * percent / 100 / kinds.size()});
    link.story += fmt::format(", {}", sim::name_of(kind));
  }
  link.story += fmt::format(" in {} %", percent);
  for (std::uint64_t cycles = 1200 / percent + between(random, 20, 100);; cycles *= 2) {
    if (run_line(setup, cycles, link).affected >= 10) return;
  }
}

std::uint64_t some_cycles(Random& random) { return between(random, 30, 250); }

// The lines as an analyser sees them that samples this often.
void sample(Link& link, Picoseconds step, Picoseconds phase) {
  std::vector<Edge> sampled;
  std::array<Level, 2> seen{Level::high, Level::high};
  std::array<Level, 2> now = seen;
  std::int64_t slot = 0;
  sampled.assign({{{}, 0, Level::high}, {{}, 1, Level::high}});
  const auto flush = [&](std::int64_t next) {
    if (next == slot) return;
    for (const wire::LineIndex line : {0U, 1U}) {
      if (now[line] == seen[line]) continue;
      seen[line] = now[line];
      sampled.push_back({slot * step + phase, line, now[line]});
    }
    slot = next;
  };
  for (const Edge& edge : link.edges) {
    if (edge.time <= phase) continue;
    flush((edge.time - phase).count / step.count + 1);
    now[edge.line] = edge.level;
  }
  flush(slot + 1);
  link.edges = std::move(sampled);
}

void invert(Link& link, wire::LineIndex line) {
  for (Edge& edge : link.edges) {
    if (edge.line == line) edge.level = edge.level == Level::high ? Level::low : Level::high;
  }
}

// Records some healthy captures with an analyser that is fast enough.
void sample_some(const sim::LineSetup& setup, Random& random, Link& link) {
  if (!one_in(random, 3)) return;
  const Picoseconds step =
      period_of(setup.clock) / static_cast<std::int64_t>(between(random, 8, 40));
  sample(link, step, step / 3);
  if (one_in(random, 2)) link.resolution = step;
  link.story += ", sampled";
}

// ---- A master of its own, answered by the simulated encoder

struct Request {
  /// Rising edges of MA.
  std::uint64_t clocks = 0;
  /// From the last edge of MA to the next request.
  Picoseconds rest{};
  /// After each 8 clocks.
  Picoseconds pause{};
};

std::vector<Edge> master_edges(Picoseconds period, const std::vector<Request>& requests,
                               Picoseconds& end) {
  std::vector<Edge> edges{{{}, 0, Level::high}};
  Picoseconds now = 20 * period;
  for (const Request& request : requests) {
    for (std::uint64_t i = 0; i < request.clocks; ++i) {
      edges.push_back({now, 0, Level::low});
      edges.push_back({now + period / 2, 0, Level::high});
      now += period + (i % 8 == 7 && i + 1 < request.clocks ? request.pause : Picoseconds{});
    }
    now += request.rest - period / 2;
  }
  end = now;
  return edges;
}

// \param ready the processing time of each request; cycles through the list
void answer(const sim::LineSetup& setup, const std::vector<Request>& requests, Link& link) {
  const Picoseconds period = period_of(setup.clock);
  Picoseconds end{};
  const std::vector<Edge> ma = master_edges(period, requests, end);
  sim::Motion motion(setup.motion, setup.format.channel_list[0], 100 * period, setup.seed);
  SlaveTiming timing = slave_timing(setup.timing, setup.processing);
  const Picoseconds delay = setup.ma_delay + setup.slo_delay + setup.internal_delay;
  std::uint64_t frames = 0;
  sim::MaReplay replay(
      {.codec = FrameCodec<>(setup.format), .timing = timing, .line_delay = delay},
      [&](Picoseconds moment) {
        Frame frame;
        frame.channel_count = setup.format.channel_count;
        const std::uint64_t position = motion.sample(moment);
        for (std::size_t k = 0; k < frame.channel_count; ++k) {
          const ChannelFormat& channel = setup.format.channel_list[k];
          frame.channel_list[k].position = position & low_mask(channel.position_bits());
          if (!channel.life_counter.present()) continue;
          frame.channel_list[k].life_counter =
              static_cast<std::uint32_t>(1 + frames % low_mask(channel.life_counter.bits));
        }
        ++frames;
        return frame;
      },
      {});
  link.edges.clear();
  replay.push(ma, 0, link.edges);
  link.end = replay.finish(end, link.edges);
}

// Clocks of a whole frame, line delay included.
std::uint64_t clocks_of(const sim::LineSetup& setup) {
  const Picoseconds period = period_of(setup.clock);
  const auto ack = static_cast<std::uint64_t>(
      setup.timing.ack_clocks != 0 ? setup.timing.ack_clocks
                                   : std::max(clocks_to_cover(setup.processing, period),
                                              clocks_to_cover(setup.timing.start_min, period)) +
                                         1);
  return 4 + ack + setup.format.payload_bits();
}

Picoseconds safe_rest(const sim::LineSetup& setup) {
  const Picoseconds period = period_of(setup.clock);
  const Picoseconds timeout = setup.timing.timeout.rule == TimeoutRule::adaptive
                                  ? 2 * period + setup.timing.timeout.time
                                  : setup.timing.timeout.time;
  return timeout + 2 * setup.ma_delay + setup.internal_delay + 4 * period + microseconds(1);
}

// ---- The causes

void make_healthy(Random& random, Link& link) {
  const sim::LineSetup setup = any_line(random, link);
  run_line(setup, some_cycles(random), link);
  sample_some(setup, random, link);
}

// A format that differs from the true one.
FrameFormat other_format(const FrameFormat& format, Random& random) {
  if (one_in(random, 3)) return any_encoder(random).frame_format();
  std::string text(format_text(format).view());
  const auto put = [&](std::string_view from, std::string_view to) {
    const std::size_t at = text.find(from);
    if (at != std::string::npos) text.replace(at, from.size(), to);
  };
  switch (random.below(5)) {
    case 0:
      put("nE,", "");
      break;
    case 1:
      put(",crc6", ",crc5");
      break;
    case 2:
      put("crc6", "crc6:0x61");
      break;
    case 3:
      put("crc6", "crc6:plain");
      put("crc16", "crc16:plain");
      break;
    default:
      put("pos", "pad3,pos");
      put("st", "pad2,st");
      break;
  }
  const auto parsed = parse_format(text);
  return parsed.ok() ? *parsed : format;
}

std::uint64_t bad_cycles(const Link& link) {
  const Evidence evidence = observe_link(link);
  return evidence.cycles - evidence.good;
}

void make_wrong_format(Random& random, Link& link) {
  for (;;) {
    const sim::LineSetup setup = any_line(random, link);
    run_line(setup, some_cycles(random), link);
    link.format = other_format(setup.format, random);
    if (one_in(random, 2)) link.timing = {};
    link.story += fmt::format(", read as {}", format_text(link.format).view());
    if (bad_cycles(link) >= 10) return;
  }
}

void make_swapped(Random& random, Link& link) {
  const sim::LineSetup setup = any_line(random, link);
  run_line(setup, some_cycles(random), link);
  link.lines = {.ma = 1, .slo = 0};
}

void make_slo_inverted(Random& random, Link& link) {
  const sim::LineSetup setup = any_line(random, link);
  if (one_in(random, 2)) return run_faults(setup, {FaultKind::swap_slo}, random, link);
  run_line(setup, some_cycles(random), link);
  invert(link, 1);
  sample_some(setup, random, link);
}

void make_ma_inverted(Random& random, Link& link) {
  const sim::LineSetup setup = any_line(random, link);
  if (one_in(random, 3)) return run_faults(setup, {FaultKind::swap_ma}, random, link);
  run_line(setup, some_cycles(random), link);
  invert(link, 0);
}

void make_too_fast(Random& random, Link& link) {
  for (;;) {
    sim::LineSetup setup = any_line(random, link);
    const Picoseconds period = period_of(setup.clock);
    switch (random.below(3)) {
      case 0: {  // a master without compensation samples beside the changes of SLO
        const auto periods = static_cast<std::int64_t>(random.below(3));
        const Picoseconds delay =
            periods * period + period * static_cast<std::int64_t>(between(random, 52, 65)) / 100;
        if (delay <= setup.internal_delay) continue;
        setup.ma_delay = setup.slo_delay = (delay - setup.internal_delay) / 2;
        setup.ma_jitter = setup.slo_jitter = {};
        setup.compensate = false;
        link.story += ", no compensation";
        run_line(setup, some_cycles(random), link);
        return;
      }
      case 1: {  // the cable smears the edges
        const Picoseconds jitter =
            period * static_cast<std::int64_t>(between(random, 30, 48)) / 100;
        setup.slo_delay = std::max(setup.slo_delay, jitter);
        setup.slo_jitter = jitter;
        link.story += ", smeared";
        run_line(setup, some_cycles(random) + 60, link);
        if (bad_cycles(link) >= 10) return;
        break;
      }
      default:
        return run_faults(setup, {FaultKind::delay_step}, random, link);
    }
  }
}

// Another line 100 us after the end of this one.
void append(Link& link, const Link& other) {
  const Picoseconds later = link.end + microseconds(100);
  for (Edge edge : other.edges) {
    if (edge.time.count == 0) continue;
    edge.time += later;
    link.edges.push_back(edge);
  }
  link.end = later + other.end;
}

void make_fixed_clocks(Random& random, Link& link) {
  sim::LineSetup setup = any_line(random, link);
  // The master always sends as many clocks as some of the answers need.
  std::vector<Request> requests;
  const std::uint64_t clocks = clocks_of(setup);
  const std::uint64_t fewer = between(random, 2, 12);
  for (std::uint64_t i = 0; i < some_cycles(random) + 20; ++i) {
    requests.push_back({clocks - fewer, safe_rest(setup), {}});
  }
  // Longer ACK in some of them: two encoders' times, one after the other.
  Link fast = link;
  sim::LineSetup quick = setup;
  const Picoseconds period = period_of(setup.clock);
  if (setup.timing.ack_clocks != 0 || setup.processing < 14 * period) {
    quick.timing.ack_clocks = setup.timing.ack_clocks = 0;
    setup.timing.start_min = quick.timing.start_min = {};
    setup.timing.ack_max = std::max(setup.timing.ack_max, 30 * period);
    setup.processing = 20 * period;
    for (Request& request : requests) request.clocks = clocks_of(setup) - fewer;
  }
  quick.processing = setup.processing - static_cast<std::int64_t>(fewer + 1) * period;
  link.timing = {};
  answer(quick, requests, fast);
  answer(setup, requests, link);
  append(fast, link);
  link.edges = std::move(fast.edges);
  link.end = fast.end;
  link.story += ", half of them in time";
}

void make_long_ack(Random& random, Link& link) {
  if (one_in(random, 2)) {
    const sim::LineSetup setup = any_line(random, link);
    return run_faults(setup, {FaultKind::late_start}, random, link);
  }
  do {
    make_fixed_clocks(random, link);
  } while (observe_link(link).truncated < 10 || observe_link(link).good < 10);
}

void stop_early(Random& random, Link& link) {
  const sim::LineSetup setup = any_line(random, link);
  const std::uint64_t clocks = clocks_of(setup);
  const std::uint64_t payload = setup.format.payload_bits();
  const std::uint64_t kind = random.below(3);
  const std::uint64_t fixed = between(random, 2, payload - 1);
  std::vector<Request> requests;
  for (std::uint64_t i = 0; i < some_cycles(random) + 30; ++i) {
    std::uint64_t fewer = 0;
    if (kind == 0) fewer = fixed;
    if (kind == 1 && one_in(random, 3)) fewer = fixed;
    if (kind == 2 && one_in(random, 2)) fewer = between(random, 2, payload - 1);
    requests.push_back({clocks - fewer, safe_rest(setup), {}});
  }
  link.story += fmt::format(", kind {}, {} clocks fewer", kind, fixed);
  answer(setup, requests, link);
}

void make_stops_early(Random& random, Link& link) {
  do {
    stop_early(random, link);
  } while (bad_cycles(link) < 10);
}

void make_too_soon(Random& random, Link& link) {
  for (;;) {
    const sim::LineSetup setup = any_line(random, link);
    const std::uint64_t clocks = clocks_of(setup);
    const Picoseconds period = period_of(setup.clock);
    const Picoseconds safe = safe_rest(setup);
    const std::uint64_t one = between(random, 1, 5);
    std::vector<Request> requests;
    for (std::uint64_t i = 0; i < some_cycles(random) + 60; ++i) {
      Picoseconds rest = safe;
      if (one_in(random, one)) {
        rest = std::max(period * 3 / 2,
                        safe * static_cast<std::int64_t>(between(random, 5, 60)) / 100);
      }
      requests.push_back({clocks, rest, {}});
    }
    link.story += ", too soon";
    answer(setup, requests, link);
    if (bad_cycles(link) >= 10) return;
  }
}

void make_noise_on_slo(Random& random, Link& link) {
  const sim::LineSetup setup = any_line(random, link);
  const std::vector<FaultKind> all{FaultKind::flip, FaultKind::burst, FaultKind::glitch_slo};
  const std::uint64_t which = random.below(4);
  run_faults(setup, which == 3 ? all : std::vector{all[which]}, random, link);
}

void make_noise_on_ma(Random& random, Link& link) {
  const sim::LineSetup setup = any_line(random, link);
  const std::vector<FaultKind> all{FaultKind::glitch_ma, FaultKind::double_clock,
                                   FaultKind::extra_clock, FaultKind::lost_clock};
  const std::uint64_t which = random.below(5);
  run_faults(setup, which == 4 ? all : std::vector{all[which]}, random, link);
}

void make_intermittent(Random& random, Link& link) {
  const sim::LineSetup setup = any_line(random, link);
  const FaultKind kind = one_in(random, 2) ? FaultKind::brown_out : FaultKind::cut;
  run_faults(setup, {kind}, random, link);
}

void make_no_encoder(Random& random, Link& link) {
  sim::LineSetup setup = any_line(random, link);
  setup.faults.push_back({.kind = FaultKind::no_answer, .share = shares});
  run_line(setup, some_cycles(random), link);
}

void make_stuck_low(Random& random, Link& link) {
  const sim::LineSetup setup = any_line(random, link);
  if (one_in(random, 2)) return run_faults(setup, {FaultKind::slo_low}, random, link);
  const std::uint64_t cycles = some_cycles(random);
  run_line(setup, cycles, link);
  const Picoseconds from = one_in(random, 2) ? Picoseconds{} : link.end / 2;
  std::vector<Edge> kept;
  for (const Edge& edge : link.edges) {
    if (edge.line != 1 || edge.time < from) kept.push_back(edge);
    if (edge.line == 1 && edge.time.count == 0 && from.count == 0) {
      kept.push_back({{}, 1, Level::low});
    }
  }
  const auto at = std::find_if(kept.begin(), kept.end(),
                               [from](const Edge& edge) { return edge.time >= from; });
  if (from.count != 0) kept.insert(at, {from, 1, Level::low});
  link.edges = std::move(kept);
}

void make_encoder_error(Random& random, Link& link) {
  for (;;) {
    const sim::LineSetup setup = any_line(random, link);
    if (!setup.format.channel_list[0].error.present) continue;
    return run_faults(setup, {FaultKind::nE}, random, link);
  }
}

void make_slow_sampling(Random& random, Link& link) {
  for (;;) {
    const sim::LineSetup setup = any_line(random, link);
    link.resolution = {};
    run_line(setup, some_cycles(random) + 30, link);
    const Picoseconds step =
        period_of(setup.clock) * 100 / static_cast<std::int64_t>(between(random, 120, 290));
    sample(link, step, step / 3);
    if (one_in(random, 2)) link.resolution = step;
    link.story += fmt::format(", sampled every {} ns", step.count / 1000);
    if (bad_cycles(link) >= 10) return;
  }
}

// The encoder does not invert its checksum.
void make_wrong_checksum(Random& random, Link& link) {
  for (;;) {
    sim::LineSetup setup = any_line(random, link);
    if (setup.format.channel_count != 1 || !setup.format.channel_list[0].crc.present()) continue;
    setup.format.channel_list[0].crc.inverted = false;
    setup.motion = sim::MotionKind::ramp;
    run_line(setup, some_cycles(random), link);
    if (bad_cycles(link) >= 10) return;
  }
}

// From some request on, another encoder answers.
void make_format_change(Random& random, Link& link) {
  Link other;
  const sim::LineSetup first = any_line(random, link);
  sim::LineSetup second = any_line(random, other);
  while (second.format.payload_bits() == first.format.payload_bits()) {
    second = any_line(random, other);
  }
  second.clock = first.clock;
  second.timing = first.timing;
  second.ma_delay = first.ma_delay;
  second.slo_delay = first.slo_delay;
  second.internal_delay = first.internal_delay;
  second.processing = first.processing;
  run_line(first, some_cycles(random), link);
  run_line(second, some_cycles(random), other);
  append(link, other);
  link.story += ", then another length";
}

// SPI: MA rests after each byte.
void make_pauses(Random& random, Link& link) {
  const sim::LineSetup setup = any_line(random, link);
  const Picoseconds period = period_of(setup.clock);
  std::vector<Request> requests;
  const std::uint64_t clocks = (clocks_of(setup) + 7) / 8 * 8;
  const Picoseconds pause = period * static_cast<std::int64_t>(between(random, 60, 130)) / 100;
  for (std::uint64_t i = 0; i < some_cycles(random) + 20; ++i) {
    requests.push_back({clocks, safe_rest(setup), pause});
  }
  sim::LineSetup patient = setup;
  patient.timing.timeout = {.rule = TimeoutRule::fixed, .time = microseconds(20) + 4 * period};
  link.timing = patient.timing;
  answer(patient, requests, link);
  link.story += ", pauses after each byte";
}

void make_implausible(Random& random, Link& link) {
  for (;;) {
    sim::LineSetup setup = any_line(random, link);
    if (setup.format.channel_list[0].life_counter.present()) continue;
    setup.motion = sim::MotionKind::ramp;
    return run_faults(setup, {FaultKind::insert}, random, link);
  }
}

void make_limits(Random& random, Link& link) {
  for (;;) {
    const sim::LineSetup setup = any_line(random, link);
    link.timing.clock_max = hertz(static_cast<std::uint32_t>(setup.clock.count / 10 * 7));
    run_line(setup, some_cycles(random), link);
    if (bad_cycles(link) == 0) return;
  }
}

// ---- Other protocols

class OtherLine {
 public:
  explicit OtherLine(Random& random) : random_(random) {}

  std::vector<Edge> edges{{{}, 0, Level::high}, {{}, 1, Level::high}};
  Picoseconds now = microseconds(100);

  void put(wire::LineIndex line, bool level) {
    if (levels_[line] == level) return;
    levels_[line] = level;
    edges.push_back({now, line, level ? Level::high : Level::low});
  }

  // SSI: a bit with each rising edge, the first one with the first; low until the monoflop ends.
  void ssi(Picoseconds half, std::uint64_t word, unsigned bits, Picoseconds monoflop) {
    for (unsigned i = 0; i <= bits; ++i) {
      put(0, false);
      now += half;
      put(0, true);
      now += half / 8;
      put(1, i < bits && ((word >> (bits - 1 - i)) & 1U) != 0);
      now += half - half / 8;
    }
    now += monoflop;
    put(1, true);
    now += monoflop;
  }

  // SPI: bytes with the clock high or low between them, data changes with an edge.
  void spi(Picoseconds half, unsigned bytes, bool idle_high) {
    put(0, idle_high);
    now += 4 * half;
    for (unsigned i = 0; i < 8 * bytes; ++i) {
      put(0, !idle_high);
      if (idle_high) put(1, random_.below(2) != 0);
      now += half;
      put(0, idle_high);
      if (!idle_high) put(1, random_.below(2) != 0);
      now += half;
    }
    now += 30 * half;
  }

  // UART: a line each way.
  void uart(Picoseconds bit, wire::LineIndex line, unsigned bytes) {
    for (unsigned k = 0; k < bytes; ++k) {
      const std::uint64_t byte = random_.below(256);
      put(line, false);
      now += bit;
      for (unsigned i = 0; i < 8; ++i) {
        put(line, ((byte >> i) & 1U) != 0);
        now += bit;
      }
      put(line, true);
      now += 2 * bit;
    }
    now += 20 * bit;
  }

 private:
  Random& random_;
  std::array<bool, 2> levels_{true, true};
};

void make_not_biss(Random& random, Link& link) {
  OtherLine line(random);
  const std::uint64_t kind = random.below(3);
  const Picoseconds half =
      picoseconds(static_cast<std::int64_t>(between(random, 100'000, 2'000'000)));
  const std::uint64_t cycles = some_cycles(random);
  const auto bits = static_cast<unsigned>(between(random, 12, 32));
  std::uint64_t position = random.next();
  const std::uint64_t step = random.below(std::uint64_t{1} << (bits - 4)) + 1;
  for (std::uint64_t i = 0; i < cycles; ++i) {
    position += step;
    if (kind == 0) line.ssi(half, position & low_mask(bits), bits, microseconds(20));
    if (kind == 1) line.spi(half, 2 + static_cast<unsigned>(i % 3), bits % 2 == 0);
    if (kind == 2) line.uart(half, static_cast<wire::LineIndex>(i % 2), 4);
  }
  link.edges = line.edges;
  link.end = line.now;
  link.format = any_encoder(random).frame_format();
  link.story = kind == 0 ? fmt::format("SSI, {} bits", bits) : kind == 1 ? "SPI" : "UART";
}

void make_lost_frames(Random& random, Link& link) {
  for (;;) {
    const sim::LineSetup setup = any_line(random, link);
    const auto channels = setup.format.channels();
    if (std::none_of(channels.begin(), channels.end(),
                     [](const ChannelFormat& each) { return each.life_counter.present(); })) {
      continue;
    }
    const std::vector<FaultKind> all{FaultKind::loss, FaultKind::repeat, FaultKind::lc_frozen};
    const std::uint64_t which = random.below(4);
    do {
      run_faults(setup, which == 3 ? all : std::vector{all[which]}, random, link);
    } while (observe_link(link).count(RequestKind::life_jump) < 10);
    return;
  }
}

}  // namespace

Link make_link(Cause truth, std::uint64_t seed) {
  using Make = void (*)(Random&, Link&);
  constexpr std::array<Make, cause_count> makers{
      make_healthy,      make_wrong_format,  make_wrong_checksum, make_format_change,
      make_swapped,      make_slo_inverted,  make_ma_inverted,    make_too_fast,
      make_long_ack,     make_stops_early,   make_pauses,         make_too_soon,
      make_noise_on_slo, make_noise_on_ma,   make_intermittent,   make_no_encoder,
      make_stuck_low,    make_encoder_error, make_lost_frames,    make_implausible,
      make_limits,       make_slow_sampling, make_not_biss};
  // A cause that is added leaves the captures of the others as they are.
  constexpr std::uint64_t seeds_apart = 17;
  Random random(sim::scrambled(seed * seeds_apart + static_cast<std::uint64_t>(truth)));
  Link link;
  link.truth = truth;
  makers[static_cast<std::size_t>(truth)](random, link);
  return link;
}

namespace {

Evidence observe(const Link& link, const Reading& reading) {
  const decode::MarginSetup margin{.resolution = link.resolution, .signal = true};
  Observer observer(
      {.format = link.format, .timing = link.timing, .margin = margin, .lines = reading.lines},
      link.edges);
  std::uint64_t number = 0;
  decode::Decoder decoder(decode::CycleReader(link.format, link.timing, margin),
                          [&](const decode::Cycle& cycle) { observer.add(number++, cycle); });
  for (std::span<const Edge> rest = link.edges; !rest.empty();) {
    const auto now = rest.first(std::min<std::size_t>(rest.size(), 4096));
    observer.take(now);
    decoder.push(now, reading.lines);
    observer.settle();
    rest = rest.subspan(now.size());
  }
  decoder.finish(link.end);
  return observer.finish(link.end);
}

Reading reading_of(const Link& link) {
  const decode::CycleReader reader(link.format, link.timing, {.resolution = link.resolution});
  return choose_reading(link.lines, link.edges, reader);
}

}  // namespace

Evidence observe_link(const Link& link) { return observe(link, reading_of(link)); }

std::vector<Finding> explain_link(const Link& link) {
  const Reading reading = reading_of(link);
  Context context;
  context.format = link.format;
  context.timing = link.timing;
  context.reading = reading;
  return diagnose(observe(link, reading), context);
}

}  // namespace biss::explain::test
