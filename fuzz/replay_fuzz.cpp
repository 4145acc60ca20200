// A recorded master with our encoder, and a recorded encoder with our master, on any train of
// edges. With both in series and an even clock, every position must be read back.
//
// Input: the format's number in frame_formats; bits 0 and 1 the timeout's rule, bit 2 no
// compensation, bit 3 another clock for the simulated master, bit 4 also requests at an even clock,
// bits 5…7 the start time of the train; the line delay, the time until the answer is ready and the
// period, one byte each; then one byte for each event: bits 0…4 the time to it in eighths of a
// period (the last eight values are other times), bits 5…7 its kind.
#include "fuzz/frame_formats.hpp"
#include "fuzz/target.hpp"
#include "sim/ma_replay.hpp"
#include "sim/slo_replay.hpp"

namespace {

using namespace biss;
using namespace biss::fuzz;
using namespace biss::wire;

constexpr std::size_t header_bytes = 5;
// The line numbers of the capture; the replays have their own.
constexpr LineIndex ma = 3;
constexpr LineIndex slo = 1;
// Trains up to this length are passed in two blocks and in one; the results must be equal.
constexpr std::size_t short_train = 64;

using Codec = FrameCodec<>;

struct Setup {
  const Codec* codec;
  SlaveTiming slave;
  MasterSetup master;
  Picoseconds line_delay;
  Picoseconds period;
  bool even;
  Picoseconds begin;

  const FrameFormat& format() const { return codec->format(); }
};

Setup setup_of(const std::uint8_t* header) {
  constexpr Picoseconds most = sim::replay_time_max;
  constexpr std::array<Picoseconds, 8> begins{{{}, {}, {}, {}, -most, -most / 2, most / 2, most}};
  constexpr std::array rules{TimeoutRule::fixed, TimeoutRule::adaptive, TimeoutRule::cycle};
  const std::uint8_t flags = header[1];
  const Picoseconds period = nanoseconds(50 + 100 * (header[4] % 125));
  const Picoseconds line_delay = period * header[2] / 8;
  const TimeoutRule rule = rules[(flags & 3U) % rules.size()];
  const Timeout timeout{rule, rule == TimeoutRule::adaptive ? Picoseconds{} : microseconds(40)};
  MasterSetup master{.timing = {.timeout = timeout}, .compensate = (flags & 4U) == 0};
  if ((flags & 8U) != 0) master.period = nanoseconds(50 + 7 * header[3]);
  return {
      .codec = &codec_of<Codec>(header[0]),
      .slave = {.ready = std::min(period * header[3] / 8, microseconds(39)), .timeout = timeout},
      .master = master,
      .line_delay = std::min(line_delay, microseconds(39)),
      .period = period,
      .even = (flags & 16U) != 0,
      .begin = begins[flags >> 5U]};
}

/// The edges of the input's events.
std::vector<Edge> train(std::span<const std::uint8_t> events, const Setup& setup) {
  constexpr unsigned eighths = 24;
  constexpr std::array<Picoseconds, 8> others{{{},
                                               picoseconds(1),
                                               picoseconds(40),
                                               nanoseconds(6),
                                               microseconds(13),
                                               microseconds(41),
                                               milliseconds(10),
                                               sim::replay_time_max / 2}};
  std::vector<Edge> edges{{setup.begin, ma, Level::high}, {setup.begin, slo, Level::high}};
  edges.reserve(2 + 2 * events.size());
  bool ma_high = true;
  bool slo_high = true;
  const auto level = [](bool high) { return high ? Level::high : Level::low; };
  Picoseconds now = setup.begin;
  for (const std::uint8_t event : events) {
    const unsigned steps = event & 31U;
    now += steps < eighths ? setup.period * steps / 8 : others[steps - eighths];
    now = std::min(now, sim::replay_time_max);
    const unsigned kind = event >> 5U;
    if (kind <= 3) edges.push_back({now, ma, level(ma_high = !ma_high)});
    if (kind >= 3 && kind <= 4) edges.push_back({now, slo, level(slo_high = !slo_high)});
    if (kind == 5) edges.push_back({now, ma, Level::unknown});
    if (kind == 6) edges.push_back({now, slo, Level::unknown});
    if (kind == 7) edges.push_back({now, 0, Level::low});
  }
  return edges;
}

void require_time_order(const std::vector<Edge>& edges) {
  require(std::is_sorted(edges.begin(), edges.end(),
                         [](const Edge& a, const Edge& b) { return a.time < b.time; }));
}

// The edges of one line equal those of another line in other edges.
void require_same(const std::vector<Edge>& edges, LineIndex line, const std::vector<Edge>& others,
                  LineIndex other_line) {
  auto other = others.begin();
  const auto next = [&] {
    while (other != others.end() && other->line != other_line) ++other;
    return other != others.end();
  };
  for (const Edge& edge : edges) {
    if (edge.line != line) continue;
    require(next() && edge.time == other->time && edge.level == other->level);
    ++other;
  }
  require(!next());
}

// The replayed line begins high, and each of its edges inverts it. Returns the number of edges.
std::size_t require_turns(const std::vector<Edge>& edges, LineIndex line) {
  std::size_t turns = 0;
  for (const Edge& edge : edges) {
    if (edge.line != line) continue;
    require(edge.level == (turns % 2 == 0 ? Level::high : Level::low));
    ++turns;
  }
  return turns;
}

struct Answered {
  std::vector<Edge> edges;
  std::vector<sim::Answer> answers;
  Picoseconds end{};
};

/// The position of a request: a hash of its number, limited to the width of the position.
std::uint64_t position(const Setup& setup, std::size_t channel, std::uint64_t number) {
  return number * 0x9E37'79B9'7F4A'7C15U &
         low_mask(setup.format().channel_list[channel].position_bits());
}

Answered answer(const Setup& setup, std::span<const Edge> recorded, std::size_t cut) {
  Answered made;
  made.edges.reserve(2 * recorded.size());
  std::uint64_t number = 0;
  sim::MaReplay replay(
      {*setup.codec, setup.slave, setup.line_delay},
      [&](Picoseconds) {
        Frame frame;
        frame.channel_count = setup.format().channel_count;
        for (std::size_t k = 0; k < frame.channel_count; ++k) {
          frame.channel_list[k].position = position(setup, k, number);
        }
        ++number;
        return frame;
      },
      [&](const sim::Answer& told) { made.answers.push_back(told); });
  replay.push(recorded.first(cut), ma, made.edges);
  replay.push(recorded.subspan(cut), ma, made.edges);
  made.end = replay.finish(recorded.back().time, made.edges);
  return made;
}

void check_ma_replay(const Setup& setup, const std::vector<Edge>& recorded) {
  const Answered made = answer(setup, recorded, recorded.size() / 2);
  require_time_order(made.edges);
  require_same(made.edges, sim::ma_line, recorded, ma);
  require_turns(made.edges, sim::slo_line);
  // An edge of MA causes at most one edge of SLO, and so does the end of an answer.
  require(made.edges.size() <= 3 * recorded.size());
  require(made.end >= recorded.back().time && made.end >= made.edges.back().time);
  require(made.end - recorded.back().time <= microseconds(200));
  require(made.answers.size() <= recorded.size());
  Picoseconds last = setup.begin;
  for (const sim::Answer& told : made.answers) {
    require(told.time >= last && told.time <= recorded.back().time);
    last = told.time;
    const bool sampled = told.sent.channel_count == setup.format().channel_count;
    require(told.kind != sim::AnswerKind::complete || sampled);
  }
  if (recorded.size() > short_train) return;
  require(answer(setup, recorded, recorded.size()).edges == made.edges);
}

struct Readings {
  std::vector<Edge> edges;
  std::vector<sim::ReplayReading> readings;
};

Readings read(const Setup& setup, std::span<const Edge> recorded, std::size_t cut) {
  Readings made;
  made.edges.reserve(2 * recorded.size());
  sim::SloReplay replay({*setup.codec, setup.master}, [&](const sim::ReplayReading& reading) {
    made.readings.push_back(reading);
  });
  replay.push(recorded.first(cut), ma, slo, made.edges);
  replay.push(recorded.subspan(cut), ma, slo, made.edges);
  replay.finish(recorded.back().time, made.edges);
  return made;
}

// A truncated reading does not contain its number of clocks.
bool is_truncated(const BasicReading<Frame>& reading) {
  return !reading.frame.ok() && reading.frame.error().cause == FrameError::truncated;
}

Readings check_slo_replay(const Setup& setup, const std::vector<Edge>& recorded) {
  const Readings made = read(setup, recorded, recorded.size() / 3);
  require_time_order(made.edges);
  require_same(made.edges, sim::slo_line, recorded, slo);
  const std::size_t turns = require_turns(made.edges, sim::ma_line);
  require(made.edges.empty() || made.edges.back().time <= recorded.back().time);
  require(made.readings.size() <= recorded.size());
  std::size_t clocks = 1;
  Picoseconds last = setup.begin;
  for (const auto& [reading, period] : made.readings) {
    require(reading.begin >= last && reading.begin <= recorded.back().time);
    last = reading.begin;
    // Line delay, ACK and frame at their maximum.
    const std::int64_t in_flight = period.count == 0 ? 0 : biss_line_delay_max.count / period.count;
    const auto most = static_cast<std::size_t>(900 + 2 * in_flight);
    require(reading.clocks <= most);
    clocks += 2 + 2 * (is_truncated(reading) ? most : reading.clocks);
    require((period.count == 0) == (reading.refusal != Refusal::none));
    if (!reading.frame.ok()) {
      require(!name_of(reading.frame.error().cause).empty());
      continue;
    }
    require(reading.line_delay && *reading.line_delay <= biss_line_delay_max);
  }
  require(turns <= clocks);
  if (recorded.size() > short_train) return made;
  require(read(setup, recorded, recorded.size()).edges == made.edges);
  return made;
}

/// The master of the core reads the answers of the core's encoder to requests at an even clock.
void check_pair(Setup setup) {
  constexpr int requests = 2;
  setup.line_delay = std::min(setup.line_delay, 8 * setup.period);
  setup.slave.ready = std::min(setup.slave.ready, 16 * setup.period);
  setup.begin = {};
  setup.master.period = {};
  setup.master.compensate = true;
  const int clocks = 40 + static_cast<int>(setup.format().payload_bits());
  const Picoseconds distance = setup.period * clocks + microseconds(100);
  std::vector<Edge> asked{{{}, ma, Level::high}};
  asked.reserve(static_cast<std::size_t>(1 + 2 * requests * clocks));
  for (int k = 0; k < requests; ++k) {
    for (int i = 0; i < clocks; ++i) {
      const Picoseconds fall = (k + 1) * distance + i * setup.period;
      asked.push_back({fall, ma, Level::low});
      asked.push_back({fall + setup.period / 2, ma, Level::high});
    }
  }
  std::vector<Edge> recorded = answer(setup, asked, 1).edges;
  for (Edge& edge : recorded) edge.line = edge.line == sim::ma_line ? ma : slo;
  const Readings made = check_slo_replay(setup, recorded);
  require(made.readings.size() == requests);
  for (std::uint64_t k = 0; k < requests; ++k) {
    const auto& [reading, period] = made.readings[k];
    require(reading.frame.ok() && period == setup.period);
    require(reading.line_delay == setup.line_delay);
    for (std::size_t c = 0; c < setup.format().channel_count; ++c) {
      require(reading.frame->channel_list[c].position == position(setup, c, k));
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < header_bytes) return 0;
  const Setup setup = setup_of(data);
  const std::vector<Edge> recorded = train(std::span(data, size).subspan(header_bytes), setup);
  check_ma_replay(setup, recorded);
  check_slo_replay(setup, recorded);
  if (setup.even) check_pair(setup);
  return 0;
}
