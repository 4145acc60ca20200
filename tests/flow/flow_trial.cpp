#include "tests/flow/flow_trial.hpp"

#include <array>
#include <string>

#include "biss/frame/format_text.hpp"
#include "capture/bytes.hpp"
#include "capture/dsl.hpp"
#include "capture/edge_pairs.hpp"
#include "capture/event_csv.hpp"
#include "capture/open.hpp"
#include "capture/saleae_binary.hpp"
#include "capture/sr.hpp"
#include "capture/vcd.hpp"
#include "decode/test_cycle_text.hpp"
#include "flow/cycle_flow.hpp"
#include "sim/line.hpp"
#include "sim/random.hpp"

namespace biss::flow_trial {

namespace {

const std::vector<std::string>& line_names() {
  static const std::vector<std::string> names{"MA", "SLO"};
  return names;
}

template <class Writer, class... Arguments>
std::string written(const Trial& trial, const Arguments&... arguments) {
  std::string text;
  capture::StringSink sink(text);
  Writer writer(arguments..., sink);
  const bool good = writer.write(trial.edges).ok() && writer.finish(trial.end).ok();
  return good ? text : std::string();
}

std::int64_t among(sim::Random& random, std::int64_t least, std::int64_t most) {
  return least +
         static_cast<std::int64_t>(random.next() % static_cast<std::uint64_t>(most - least + 1));
}

capture::Opened open(const Trial& trial, const Container& container, std::size_t piece_bytes) {
  capture::OpenOptions options;
  options.piece_bytes = piece_bytes;
  if (container.name.ends_with(".raw")) {
    options.raw = capture::packed_layout(line_names(), trial.sample_rate);
  }
  return capture::open_capture(capture::memory_bytes(container.bytes), container.name, options);
}

// The master pauses its clock now and then, mostly within a request.
void add_pauses(std::vector<wire::Edge>& edges, sim::Random& random) {
  Picoseconds paused{};
  for (wire::Edge& edge : edges) {
    edge.time += paused;
    const bool rises = edge.line == sim::ma_line && edge.level == wire::Level::high;
    if (rises && random.next() % 64 == 0) paused += nanoseconds(among(random, 50, 9'000));
  }
}

// Decodes what `read` pushes.
template <class Read>
std::vector<std::string> rows(const Trial& trial, capture::EdgeSource& source, Read read) {
  std::vector<std::string> texts;
  const decode::MarginSetup margin{.resolution = source.sample_period(),
                                   .signal = trial.setup.seed % 2 == 0};
  decode::Decoder decoder(
      decode::CycleReader(trial.setup.format, trial.setup.timing, margin),
      [&](const decode::Cycle& cycle) { texts.push_back(decode::test::text_of(cycle)); });
  decoder.finish(read(decoder, margin));
  return texts;
}

}  // namespace

Trial::Trial(std::uint64_t number) {
  sim::Random random(sim::scrambled(number + 13));
  constexpr std::array formats{"pos26,nE,nW,crc6", "pos32,nE,nW,crc6", "mt12,st24,nE,nW,crc6",
                               "pos36,nE,nW,crc6+pos28,nE,nW,lc6,crc16;cds0"};
  constexpr std::array clocks{1'000U, 2'500U, 9'830U, 10'000U};
  setup.format = *parse_format(formats[random.next() % formats.size()]);
  setup.clock = kilohertz(clocks[random.next() % clocks.size()]);
  setup.timing.clock_constant = random.next() % 2 == 0;
  setup.ma_delay = nanoseconds(among(random, 5, 200));
  setup.slo_delay = nanoseconds(among(random, 5, 200));
  setup.ma_jitter = nanoseconds(among(random, 0, 4));
  setup.slo_jitter = nanoseconds(among(random, 0, 4));
  setup.duty_per_mille = static_cast<std::uint32_t>(among(random, 430, 570));
  setup.processing = nanoseconds(among(random, 0, 5'000));
  setup.motion = static_cast<sim::MotionKind>(among(random, 0, 4));
  setup.seed = random.next();
  if (number % 4 != 0) {
    const auto kind = static_cast<sim::FaultKind>(number % sim::simulated_fault_count);
    setup.faults.push_back({.kind = kind, .share = std::uint64_t{1} << 29U});
  }
  constexpr std::array rates{100U, 80U, 48U};
  sample_rate = megahertz(rates[random.next() % rates.size()]);
  sim::Line line(setup);
  for (const wire::LineIndex each : {sim::ma_line, sim::slo_line}) {
    edges.push_back({{}, each, wire::Level::high});
  }
  for (int i = 0; i < 40; ++i) {
    const auto& cycle = line.next();
    edges.insert(edges.end(), cycle.edges.begin(), cycle.edges.end());
  }
  if (number % 3 == 0) add_pauses(edges, random);
  if (number % 5 == 0) setup.timing.timeout = {TimeoutRule::fixed, microseconds(10)};
  end = edges.back().time + microseconds(100);
}

std::vector<Container> change_containers(const Trial& trial) {
  return {{"x.vcd", written<capture::VcdWriter>(trial, line_names())},
          {"x.csv", written<capture::EventCsvWriter>(trial, line_names())}};
}

std::vector<Container> sampled_containers(const Trial& trial) {
  return {{"x.raw", written<capture::RawWriter>(
                        trial, capture::packed_layout(line_names(), trial.sample_rate))},
          {"x.sr", written<capture::SrWriter>(trial, line_names(), trial.sample_rate)},
          {"x.dsl", written<capture::DslWriter>(trial, line_names(), trial.sample_rate)}};
}

std::vector<std::string> by_edges(const Trial& trial, const Container& container) {
  const auto source = open(trial, container, 1024);
  if (!source) return {};
  return rows(trial, **source, [&](decode::Decoder& decoder, const decode::MarginSetup&) {
    for (auto block = (*source)->next_block(); block.ok() && !block->empty();
         block = (*source)->next_block()) {
      decoder.push(*block, {0, 1});
    }
    return (*source)->end_time();
  });
}

std::vector<std::string> by_flow(const Trial& trial, const Container& container, unsigned threads,
                                 std::size_t piece_bytes) {
  const auto source = open(trial, container, piece_bytes);
  if (!source) return {};
  return rows(trial, **source, [&](decode::Decoder& decoder, const decode::MarginSetup& margin) {
    // The same as the command, which has read the beginning.
    const auto first = (*source)->next_block();
    std::vector<wire::Edge> beginning;
    if (first.ok()) beginning.assign(first->begin(), first->end());
    const auto pairs = capture::pairs_of(std::move(beginning), **source, 0, 1);
    const decode::CleanCycleFinder finder(trial.setup.format, trial.setup.timing, margin);
    flow::CycleFlow flow(*pairs, finder, {0, 1}, decoder);
    flow.run(threads, {});
    flow.flush();
    return pairs->end_time();
  });
}

}  // namespace biss::flow_trial
