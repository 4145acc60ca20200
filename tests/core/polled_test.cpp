// Frames that are received without DMA. The encoder is a Slave at the end of a cable. It ends its
// frame after the shortest timeout that its type can have.
#include "biss/master/polled_read.hpp"

#include "biss/catalogue/catalogue.hpp"
#include "biss/frame/codec.hpp"
#include "biss/slave/slave.hpp"
#include "tests/core/scripted_slo.hpp"
#include "tests/core/slave_bench.hpp"
#include "tests/core/test.hpp"

namespace polled_test {

using namespace biss;

using Codec = test::TestCodec;
using Reader = SpiReader<Codec>;

// ---- The line: every edge of MA at its time, and the longest time between two of them

using Cable = test::BasicDelayLine<8>;

struct Line {
  Slave<Codec, test::Owner<Codec::Frame>, 0> encoder;
  Cable way_out;
  Cable way_back;
  Picoseconds now = microseconds(100);
  Picoseconds last_edge{};  // 0: none in this request
  Picoseconds longest{};
  StepOutput answered{};

  void wait(Picoseconds time) {
    const Picoseconds end = now + time;
    for (;;) {
      now = std::min(end, std::min(answered.deadline, way_out.next()));
      answered = encoder.step(now, way_out.level(now), false);
      way_back.put(now, answered.level);
      if (now == end) return;
    }
  }
  void set(bool level, Picoseconds later = {}) {
    if (last_edge.count != 0) longest = std::max(longest, now + later - last_edge);
    last_edge = now + later;
    wait({});
    way_out.put_at(now + later + way_out_delay, level);
    wait({});
  }
  bool slo() {
    wait({});
    return way_back.level(now);
  }
  Picoseconds way_out_delay{};
};

// An interrupt: it comes when the board's code is here for the `at`-th time; with `random` at any
// time, up to as long.
struct Interrupt {
  unsigned at = ~0U;
  Picoseconds time{};
  test::Random* random = nullptr;

  Picoseconds here() {
    if (random == nullptr) return at-- == 0 ? time : Picoseconds{};
    if (random->below(16) != 0) return {};
    return picoseconds(random->below(static_cast<std::uint32_t>(time.count)));
  }
};

// ---- The boards

struct Board {
  Line& line;
  SpiSetup setup;
  Interrupt before{};  // before the clocks of a byte, or an edge
  Interrupt after{};

  static constexpr Picoseconds time_step = nanoseconds(70);
  Picoseconds now() {
    line.wait(nanoseconds(1));
    return picoseconds(line.now.count / time_step.count * time_step.count);
  }
};

std::uint8_t transfer_byte(Board& board) {
  Line& line = board.line;
  const bool falling = board.setup.phase == SpiPhase::sample_on_falling;
  const Picoseconds half = board.setup.period / 2;
  unsigned byte = 0;
  line.wait(board.before.here());
  line.wait(std::max(Picoseconds{}, line.last_edge + half - line.now));
  for (int clock = 0; clock < 8; ++clock) {
    if (falling) byte = byte * 2 + (line.slo() ? 1U : 0U);
    line.set(false);
    if (falling && clock == 7) {  // the last edge comes later
      line.set(true, half);
      break;
    }
    line.wait(half);
    if (!falling) byte = byte * 2 + (line.slo() ? 1U : 0U);
    line.set(true);
    if (clock != 7) line.wait(half);
  }
  line.wait(board.after.here());
  return static_cast<std::uint8_t>(byte);
}

struct Spi : Board {
  std::uint8_t transfer() { return transfer_byte(*this); }
};

struct SpiWithoutClock : Board {
  void now() = delete;
  std::uint8_t transfer() { return transfer_byte(*this); }
};

struct Pins : Board {
  void set_ma(bool level) {
    line.wait(before.here());
    line.set(level);
    line.wait(after.here());
  }
  bool slo() { return line.slo(); }
};

static_assert(PolledSpi<Spi> && !PolledPins<Spi> && PolledClock<Spi>);
static_assert(PolledSpi<SpiWithoutClock> && !PolledClock<SpiWithoutClock>);
static_assert(!PolledSpi<Pins> && PolledPins<Pins> && PolledClock<Pins>);

// ---- An encoder, its master, and one request

constexpr Picoseconds board_cost = nanoseconds(310);  // of the readings of the clock

struct Case {
  FrameFormat format{};
  DeviceTiming timing{};
  SpiSetup setup{};
  Timeout shortest{};
  Picoseconds ready{};
  Picoseconds delay{};
};

template <class AnyBoard>
struct Bench {
  Codec codec;
  Reader reader;
  test::Log log{};
  Line line;
  AnyBoard board;
  PolledRequest<AnyBoard> request;
  std::array<std::uint8_t, 1200> buffer{};

  explicit Bench(const Case& c)
      : codec(c.format),
        reader(codec, c.setup, c.timing),
        line{.encoder = {codec, slave_timing_of(c), test::Owner<Codec::Frame>{&log}},
             .way_out = Cable(Picoseconds{}),
             .way_back = Cable(c.delay - c.delay / 2),
             .way_out_delay = c.delay / 2},
        board{Board{line, c.setup}},
        request(board, c.setup, c.timing) {}

  static SlaveTiming slave_timing_of(const Case& c) {
    SlaveTiming timing = slave_timing(c.timing, c.ready);
    timing.timeout = c.shortest;
    timing.static_timeout = biss_static_timeout_min;
    return timing;
  }

  std::span<std::uint8_t> bytes() { return std::span(buffer).first(reader.bytes()); }

  // Checks that there is a frame, the right one, exactly if no pause was too long. Returns whether
  // there is one.
  bool read(std::uint64_t position, Picoseconds between_bytes = {}) {
    log.position = position & low_mask(codec.format().channel_list[0].position_bits());
    line.wait(microseconds(100));
    line.last_edge = {};
    line.longest = {};
    BISS_EXPECT(request.start(bytes()));
    BISS_EXPECT(!request.start(bytes()));
    const Picoseconds begin = line.now;
    while (request.step() == PolledState::running) line.wait(between_bytes);
    const bool complete = request.state() == PolledState::complete;
    const auto frame = reader.read(bytes());
    BISS_EXPECT_EQ(frame.ok(), complete);
    if (complete && frame.ok()) {
      BISS_EXPECT(line.longest <= board.setup.max_pause);
      BISS_EXPECT_EQ(frame->channel_list[0].position, log.position);
      BISS_EXPECT(line.last_edge - begin < request.time_max(reader.bytes()) + board_cost);
    } else if (!complete) {
      BISS_EXPECT_EQ(frame.error().cause, FrameError::no_response);
    }
    return complete;
  }
};

// A pause at every `stride`-th place of a request, just short enough and a little too long.
template <class AnyBoard>
void pauses_everywhere(const Case& c, unsigned stride, test::Random& random) {
  Bench<AnyBoard> bench(c);
  BISS_ASSERT(!bench.reader.error());
  BISS_ASSERT(!bench.request.error());
  BISS_ASSERT(bench.reader.bytes() <= bench.buffer.size());
  constexpr bool pins = PolledPins<AnyBoard>;
  const auto places = static_cast<unsigned>(bench.reader.bytes() * (pins ? 16 : 1));
  // The rest of half a period between two edges counts, and also the one before the earlier byte.
  // In mode 2 transfer() returns early and then waits for the last edge.
  const bool falling = c.setup.phase == SpiPhase::sample_on_falling;
  const Picoseconds rests = (pins ? 1 : falling ? 3 : 2) * c.setup.period / 2;
  const Picoseconds most = c.setup.max_pause - rests - board_cost;
  if (most.count < 0) return;
  BISS_EXPECT(bench.read(random.bits(64)));
  for (unsigned at = 0; at < places; at += stride) {
    for (const bool after : {false, true}) {
      Interrupt& interrupt = after ? bench.board.after : bench.board.before;
      interrupt = {at, most};
      BISS_EXPECT(bench.read(random.bits(64))) << "a short pause at " << at;
      if (at == 0 && !after) continue;  // before the first edge
      interrupt = {at, c.setup.max_pause + (falling ? c.setup.period / 2 : nanoseconds(1))};
      BISS_EXPECT(!bench.read(random.bits(64))) << "a long pause at " << at;
    }
  }
}

Timeout shortest_of(const DeviceTiming& timing, bool adaptive) {
  const Timeout& timeout = timing.timeout;
  if (timeout.rule == TimeoutRule::cycle) return timeout;
  if (timeout.rule == TimeoutRule::adaptive || adaptive) return {TimeoutRule::adaptive, {}};
  return {TimeoutRule::fixed, std::min(timeout.time, nanoseconds(12'500))};
}

Case case_of(const CatalogueEntry& entry, SpiPhase phase, Picoseconds period, bool adaptive) {
  Case c{.format = entry.frame_format(), .timing = entry.timing};
  c.shortest = shortest_of(entry.timing, adaptive);
  const bool falling = phase == SpiPhase::sample_on_falling;
  c.delay = (falling ? period / 2 : period) - picoseconds(1);
  c.ready = std::min(entry.timing.ack_max, microseconds(16));
  c.setup = {.period = period,
             .phase = phase,
             .line_delay = {.max = c.delay},
             .no_error_flag = true,
             .unchecked = true,
             .max_pause = shortest_timeout(entry.timing.timeout, period) - picoseconds(1),
             .pause_anyway = true};
  return c;
}

// All types, the shortest delay that the phase has trouble with.
BISS_TEST(PolledRequest, PauseInEachEncodersFrame_EndsItOnlyAboveTheTimeout) {
  BISS_RANDOM(random, 0x9011);
  unsigned number = 0;
  for (const CatalogueEntry& entry : catalogue) {
    const Picoseconds period = std::max(microseconds(1), period_of(entry.timing.clock_max));
    for (const SpiPhase phase : {SpiPhase::sample_on_rising, SpiPhase::sample_on_falling}) {
      if (number++ % test::rounds(1, 16) != 0) continue;
      for (const bool adaptive : {false, true}) {
        if (adaptive && !(entry.timing.timeout == Timeout{})) continue;
        const Case c = case_of(entry, phase, period, adaptive);
        pauses_everywhere<Spi>(c, 3, random);
        pauses_everywhere<Pins>(c, 37, random);
      }
    }
  }
}

template <class AnyBoard>
bool has_bad_frames(const Case& c, test::Random& random) {
  Bench<AnyBoard> bench(c);
  bench.board.before = bench.board.after = {0, c.setup.max_pause, &random};
  std::uint64_t bad = 0;
  for (std::uint64_t i = 0; i < test::rounds(1000, 30); ++i) {
    bad += bench.read(random.bits(64)) ? 0U : 1U;
  }
  return bad != 0;
}

BISS_TEST(PolledRequest, InterruptsAtAnyTime_NeverGiveAWrongFrame) {
  BISS_RANDOM(random, 0x1217);
  for (const char* name : {"lenz-b3", "siko-msa213c", "resolute-26"}) {
    for (const SpiPhase phase : {SpiPhase::sample_on_rising, SpiPhase::sample_on_falling}) {
      const Case c = case_of(*find_encoder(name), phase, microseconds(2), false);
      BISS_EXPECT(has_bad_frames<Spi>(c, random));
      BISS_EXPECT(has_bad_frames<Pins>(c, random));
    }
  }
}

// ACK takes as long as before, in fewer clocks.
BISS_TEST(PolledRequest, PausesInAck_LeaveItFewerClocks) {
  constexpr CatalogueEntry entry = catalogue_encoder("resolute-26");
  Case c = case_of(entry, SpiPhase::sample_on_rising, nanoseconds(100), false);
  c.ready = {};
  c.setup.max_pause = nanoseconds(149);
  const Reader without_pause(Codec(c.format), {.period = c.setup.period}, c.timing);
  BISS_EXPECT_EQ(without_pause.bounds().ack_min_clocks, 32);
  Bench<SpiWithoutClock> bench(c);
  BISS_EXPECT_EQ(bench.reader.bounds().ack_min_clocks, 10);
  BISS_EXPECT(bench.read(0x155'5555, nanoseconds(140)));
  const auto frame = bench.reader.read(bench.bytes());
  BISS_ASSERT(frame.ok());
  BISS_EXPECT(frame->ack_clocks < 32);
}

// The encoder may release SLO after its cycle time, which is over after fewer clocks.
BISS_TEST(PolledRequest, PausesInTheTail_LeaveFewerClocksThatMustBeLow) {
  constexpr CatalogueEntry entry = catalogue_encoder("resolute-18");
  Case c = case_of(entry, SpiPhase::sample_on_rising, nanoseconds(100), false);
  c.ready = {};
  Bench<SpiWithoutClock> bench(c);
  BISS_EXPECT(bench.read(0x15555));
  const std::size_t last = bench.reader.bytes() - 1;
  for (const std::int64_t pause_ns : {0, 51, 149}) {
    c.setup.max_pause = nanoseconds(pause_ns);
    const Reader reader(bench.codec, c.setup, c.timing);
    BISS_EXPECT(reader.read(bench.bytes()).ok());
    bench.buffer[last] = 1;
    // The cycle has 312, 306 or 104 clocks; the buffer has about 190.
    BISS_EXPECT_EQ(reader.read(bench.bytes(), 8 * last + 8).ok(), pause_ns == 149);
    bench.buffer[last] = 0;
  }
}

// Without a clock, nothing detects the pause: the encoder begins a new cycle.
BISS_TEST(PolledRequest, PauseAboveTheTimeoutWithoutAClock_MixesTwoCycles) {
  const Case c = case_of(catalogue_encoder("lenz-b3"), {}, microseconds(1), false);
  for (const bool is_long : {false, true}) {
    Bench<SpiWithoutClock> bench(c);
    bench.board.before = {3, c.setup.max_pause + picoseconds(is_long ? 1 : 0)};
    bench.log.position = 0x5555;
    BISS_EXPECT(bench.request.start(bench.bytes()));
    while (!bench.request.done()) bench.request.step();
    BISS_EXPECT(bench.request.state() == PolledState::complete);
    BISS_EXPECT_EQ(bench.log.samples, is_long ? 2U : 1U);
    BISS_EXPECT_EQ(bench.reader.read(bench.bytes()).ok(), !is_long);
  }
}

// Why the line delay is limited.
BISS_TEST(PolledRequest, PauseWhileABitIsOnItsWay_LosesTheBit) {
  Case c = case_of(catalogue_encoder("lenz-b3"), {}, microseconds(1), false);
  for (const bool is_long : {false, true}) {
    Case line = c;
    if (is_long) line.delay = microseconds(1) + picoseconds(1);
    Bench<SpiWithoutClock> bench(line);
    bench.board.before = {3, microseconds(5)};
    bench.log.position = 0x55'5555;
    BISS_EXPECT(bench.request.start(bench.bytes()));
    while (!bench.request.done()) bench.request.step();
    line.setup.line_delay.max = line.delay;
    line.setup.max_pause = {};
    const auto frame = Reader(bench.codec, line.setup, line.timing).read(bench.bytes());
    BISS_EXPECT_EQ(frame.ok(), !is_long);
  }
}

BISS_TEST(PolledRequest, Pins_AreSampledAtTheEdgeOfThePhase) {
  for (const SpiPhase phase : {SpiPhase::sample_on_rising, SpiPhase::sample_on_falling}) {
    Case c = case_of(catalogue_encoder("lenz-b3"), phase, microseconds(1), false);
    c.delay = nanoseconds(900);
    Bench<Pins> bench(c);
    BISS_EXPECT(bench.request.start(bench.bytes()));
    while (!bench.request.done()) bench.request.step();
    BISS_EXPECT_EQ(bench.reader.read(bench.bytes()).ok(), phase == SpiPhase::sample_on_rising);
  }
}

// A counter of 32 bits, for example.
BISS_TEST(PolledRequest, ClockThatJumpsBack_IsAPause) {
  struct Jumping : Pins {
    Picoseconds now() { return picoseconds(Pins::now().count % microseconds(256).count); }
  };
  const Case c = case_of(catalogue_encoder("lenz-b3"), {}, microseconds(2), false);
  Bench<Jumping> bench(c);
  unsigned bad = 0;
  for (unsigned i = 0; i < 32; ++i) bad += bench.read(i) ? 0U : 1U;
  BISS_EXPECT(bad > 0 && bad < 32);
}

// ---- What is refused

constexpr Picoseconds us = microseconds(1);
constexpr DeviceTiming fixed_20{.timeout = {TimeoutRule::fixed, 20 * us}};
constexpr DeviceTiming fixed_2{.timeout = {TimeoutRule::fixed, 2 * us}};
constexpr DeviceTiming stated_15{
    .timeout = {TimeoutRule::fixed, 20 * us, biss_release_half_periods, 15 * us}};
constexpr DeviceTiming adaptive{.timeout = {TimeoutRule::adaptive, nanoseconds(500)}};
constexpr DeviceTiming constant{.timeout = fixed_20.timeout, .clock_constant = true};

static_assert(shortest_timeout(fixed_20.timeout, us) == nanoseconds(12'500));
static_assert(shortest_timeout(fixed_2.timeout, us) == 2 * us);
static_assert(shortest_timeout(stated_15.timeout, us) == 15 * us);
static_assert(shortest_timeout(adaptive.timeout, us) == nanoseconds(1'500));
static_assert(shortest_timeout(adaptive.timeout, 10 * us) == nanoseconds(12'500));
static_assert(shortest_timeout(Timeout{}, us) == nanoseconds(1'500));
static_assert(shortest_timeout(Timeout{.shortest = 9 * us}, us) == 9 * us);
static_assert(shortest_timeout(renishaw_timing.timeout, us) == nanoseconds(1'500));

BISS_TEST(Timeout, Shortest_IsWhatIsStatedOrPermitted) {
  for (const Timeout& stated : {stated_15.timeout, Timeout{.shortest = 15 * us}}) {
    BISS_EXPECT_EQ(shortest_timeout(stated, us).count, (15 * us).count);
  }
  for (const Timeout& open : {Timeout{}, adaptive.timeout, renishaw_timing.timeout}) {
    BISS_EXPECT_EQ(shortest_timeout(open, us).count, nanoseconds(1'500).count);
  }
  BISS_EXPECT_EQ(shortest_timeout(fixed_2.timeout, us).count, (2 * us).count);
}

constexpr SpiSetup pausing(std::int64_t pause_ns, std::int64_t delay_ns = 999,
                           SpiPhase phase = SpiPhase::sample_on_rising) {
  return {.period = us,
          .phase = phase,
          .line_delay = {.max = nanoseconds(delay_ns)},
          .max_pause = nanoseconds(pause_ns)};
}

static_assert(!check_pause(pausing(12'499), fixed_20) && !check_pause(pausing(500), fixed_20));
static_assert(check_pause(pausing(12'500), fixed_20) == SpiSetupError::pause);
static_assert(check_pause(pausing(499), fixed_20) == SpiSetupError::pause);
static_assert(check_pause(pausing(-1), fixed_20) == SpiSetupError::pause);
static_assert(!check_pause(pausing(14'999), stated_15) && !check_pause(pausing(1'499), adaptive));
static_assert(check_pause(pausing(1'500), adaptive) == SpiSetupError::pause);
static_assert(check_pause(pausing(1'500), {}) == SpiSetupError::pause);
static_assert(check_pause(pausing(1'000, 1'000), fixed_20) == SpiSetupError::pause_delay);
static_assert(!check_pause(pausing(1'000, 499, SpiPhase::sample_on_falling), fixed_20));
static_assert(check_pause(pausing(1'000, 500, SpiPhase::sample_on_falling), fixed_20) ==
              SpiSetupError::pause_delay);
static_assert(check_pause(pausing(1'000), constant) == SpiSetupError::clock_constant);
static_assert(check_pause({}, fixed_20) == SpiSetupError::period);
static_assert(!check_pause(pausing(0, 40'000), constant));  // DMA

constexpr FrameFormat format = test::format_of("pos18,nE,nW,crc6");

struct NoBoard {
  constexpr std::uint8_t transfer() { return 0; }
};

template <std::int64_t pause_ns>
constexpr bool make_reader() {
  return !SpiReader(FrameCodec<CrcBitwise, 1>(format), pausing(pause_ns), fixed_20).error();
}
template <std::int64_t pause_ns>
constexpr bool make_request() {
  NoBoard board;
  return !PolledRequest(board, pausing(pause_ns), fixed_20).error();
}
template <std::int64_t pause_ns>
concept ReaderCompiles = requires {
  typename std::bool_constant<make_reader<pause_ns>()>;
};
template <std::int64_t pause_ns>
concept RequestCompiles = requires {
  typename std::bool_constant<make_request<pause_ns>()>;
};
static_assert(ReaderCompiles<0> && ReaderCompiles<12'499> && !ReaderCompiles<12'500>);
static_assert(!RequestCompiles<0> && RequestCompiles<12'499> && !RequestCompiles<12'500>);

BISS_TEST(PolledRequest, SetupThatDoesNotFit_HasItsCauseAndStartsNothing) {
  NoBoard board;
  std::array<std::uint8_t, 8> buffer{};
  for (const std::int64_t pause : {0, 12'500}) {
    PolledRequest request(board, pausing(pause), fixed_20);
    BISS_EXPECT(request.error() == SpiSetupError::pause);
    BISS_EXPECT(!request.start(buffer));
    BISS_EXPECT(request.step() == PolledState::idle);
  }
  PolledRequest request(board, pausing(1'000), fixed_20);
  BISS_EXPECT(!request.start({}));
  BISS_EXPECT(request.start(buffer));
  BISS_EXPECT(!request.done());
}

}  // namespace polled_test
