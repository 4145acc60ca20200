// A safety monitor on an encoder with faults, against an oracle of its verdicts. Every position
// belongs to a frame that the oracle accepts.
//
// Input: the setup's number (two bytes), the start of the clock, the encoder's range and counter;
// then the events, two bytes each: bits 0…3 of the first byte the kind (enum Op), the other bits
// the parameters.
#include <cstring>
#include <memory>
#include <random>

#include "biss/frame/encode.hpp"
#include "biss/frame/format_text.hpp"
#include "biss/safety/monitor.hpp"
#include "fuzz/safety_oracle.hpp"
#include "fuzz/target.hpp"

namespace {

using namespace biss;
using namespace biss::fuzz;

using Plan = SafetyPlan<4, CrcTable<8>>;
using Monitor = SafetyMonitor<Plan>;

// Words of all widths, orders and flags; further channels; every kind of checksum.
constexpr std::array<std::string_view, 16> formats{
    "pos36,nE,nW,crc6+pos28,nE,nW,lc6,crc16;cds0",
    "pos32,nE,nW,crc6+pos32,nE,nW,lc6,crc16;cds0",
    "st16,nE,nW,crc6+st12,nE,nW,lc6,crc16",
    "mt12,st16,nE,nW,crc6+mt12,st12,nE,nW,lc6,crc16",
    "mt24,st24,nE,nW,crc6+mt24,st16,nE,nW,lc6,crc16",
    "mt12,st24,nE,nW,crc6+st16,nE,nW,lc6,crc16",
    "st9,mt3,nE,nW,crc6+mt20,st30,E,W,lc6,crc8",
    "pos1,nE,crc3+pos1,nE,lc6,crc3",
    "pos3,nE,nW,crc6+pos5,nE,nW,lc6,crc16",
    "pos62,nE,nW,crc16+pos56,nE,nW,lc6,crc16:0x190D9:0xFFFF:plain;cds0",
    "pad3,pos20,W,E,lc6,crc16:0x190D9:0x0001+pos12,E,pad2,nW,crc6:0x43:0x3F:plain",
    "pos10,nE,nW,crc4+pos10,nE,nW,lc6,crc16+pos20,crc6+pad12",
    "pad7+pos20,crc6+mt12,st19,pad5,nW,E,crc8+st7,mt1,nE,lc6,crc5",
    "pos30,nE,crc6+pos30,nE,lc6,crc16+pad30,crc6",
    "lc6,pos40,nW,nE,crc5+lc6,nE,pos44,crc7",
    "mt2,st60,nE,nW,crc6+mt2,st54,nE,nW,lc6,crc16",
};
// The words of the setups whose words are not the first two channels.
constexpr std::uint8_t cpw_of(std::size_t k) { return k == 10 ? 1 : k == 12 ? 2 : 0; }
constexpr std::uint8_t spw_of(std::size_t k) { return k == 10 ? 0 : k == 12 ? 3 : 1; }

constexpr std::size_t setup_count = 4096;

SafetySetup random_setup(std::mt19937_64& random, std::size_t format) {
  const auto below = [&](unsigned most) { return static_cast<unsigned>(random() % most); };
  const auto byte = [&](unsigned most) { return static_cast<std::uint8_t>(random() % most); };
  SafetySetup setup{.cpw = cpw_of(format), .spw = spw_of(format)};
  setup.start_frames = static_cast<std::uint8_t>(below(8) == 0 ? below(256) : 2 + below(3));
  setup.latch = below(4) != 0;
  setup.comparison = {.compare_bits = below(2) == 0 ? std::uint8_t{0} : byte(30),
                      .tolerance_lsb = below(8) == 0 ? byte(255) : byte(4),
                      .multiturn = static_cast<MultiturnRule>(below(2))};
  setup.counter = {.mode = static_cast<CounterMode>(below(3)),
                   .missed = static_cast<MissedFrames>(below(2)),
                   .near_frames = below(4) == 0 ? byte(32) : std::uint8_t{8},
                   .learn_rollovers = byte(3)};
  setup.frame_gap_max = setup.cycle_min * (1 + below(8)) + setup.cycle_min / 2;
  setup.frame_gap_min = below(2) == 0 ? setup.cycle_min * below(3) / 2 : Picoseconds{};
  if (below(2) == 0) setup.clocks.tolerance = setup.frame_gap_max * below(8) / 8;
  setup.clocks.still_requests = below(2) == 0 ? std::uint8_t{0} : byte(4);
  if (below(8) == 0) setup.counter.first = byte(64);
  setup.budget = {.faults = below(2) == 0 ? std::uint8_t{0} : byte(6),
                  .window = setup.cycle_min * below(40)};
  if (below(4) == 0) {
    const auto clocks = [&](unsigned most) { return static_cast<std::uint16_t>(below(most)); };
    setup.bounds = {.lead_min_clocks = clocks(4),
                    .lead_max_clocks = static_cast<std::uint16_t>(4 + below(40)),
                    .ack_min_clocks = clocks(5),
                    .ack_max_clocks = static_cast<std::uint16_t>(5 + below(60)),
                    .late_max_clocks = clocks(4)};
  }
  return setup;
}

// A monitor after its self test, which takes longer than a run: its bytes are put into others, as no
// user may. Every setup that check_safety() accepts passes it.
const Monitor& tested_monitor(std::size_t number) {
  static std::vector<std::unique_ptr<Monitor>> made(setup_count);
  auto& monitor = made[number % setup_count];
  if (monitor) return *monitor;
  std::mt19937_64 random(number % setup_count);
  const std::size_t k = number % formats.size();
  const FrameFormat format = *parse_format(formats[k]);
  std::optional<UnratedSafetySetup> setup;
  while (!setup || check_safety(format, *setup)) setup.emplace(random_setup(random, k));
  monitor = std::make_unique<Monitor>(Plan(format, *setup));
  require(monitor->state() == SafetyState::untested);
  require(monitor->self_test({format, *setup}));
  return *monitor;
}

enum Op : std::uint8_t { good, good_run, flip, burst, counter, apart, flags, silent, lost, time };
// The operations beyond the ones above.
enum : std::uint8_t { tick = 10, button, shape, raw, differ, again };
// Bits of the first byte of `good`: what happens besides.
constexpr unsigned clocks_drift = 1;
constexpr unsigned clock_stops = 2;
constexpr unsigned expects_position = 4;

class Bench {
 public:
  Bench(const Monitor& tested, ByteSource& bytes)
      : tested_(tested), monitor_(tested.plan()), oracle_(format(), setup()), bytes_(bytes) {
    power_up();
    // A tested monitor waits for its first frame.
    const std::uint8_t begin = bytes.next();
    now_ = (Wide{begin} - 128) << 56U;
    if ((begin & 1U) != 0) now_ += (Wide{1} << 56U) - setup().cycle_min.count * (begin % 64U);
    const std::uint8_t encoder = bytes.next();
    latest_ = now_;
    lowest_ = encoder >> 7U;
    counter_ = encoder % 64U;
    position_ = 0x9E37'79B9'7F4A'7C15U * (encoder + 1U);
  }

  void run() {
    while (!bytes_.done() && frames_left_ != 0) {
      const unsigned what = bytes_.next();
      happen(what, bytes_.next());
    }
    require(monitor_.state() == oracle_.state());
  }

 private:
  const FrameFormat& format() const { return monitor_.plan().format(); }
  const SafetySetup& setup() const { return monitor_.plan().setup(); }
  const ChannelFormat& cpw() const { return format().channel_list[setup().cpw]; }
  const ChannelFormat& spw() const { return format().channel_list[setup().spw]; }

  void power_up() {
    std::memcpy(static_cast<void*>(&monitor_), static_cast<const void*>(&tested_), sizeof monitor_);
  }
  void happen(unsigned what, unsigned how);
  void press(unsigned how);
  Frame next_frame();
  FrameBits bits_of(const Frame& frame) const;
  void send(const Frame& frame, unsigned flips = 0);
  void show(const std::vector<std::uint8_t>& bytes, unsigned first, std::size_t size_bits,
            int change = -1);
  static std::vector<bool> levels_of(const FrameBits& bits) {
    std::vector<bool> levels;
    for (std::size_t i = 0; i < bits.size_bits(); ++i) levels.push_back(bits.view()[i]);
    return levels;
  }
  void show(const FrameBits& bits) {
    const auto stored = bits.bytes();
    show({stored.begin(), stored.end()}, 0, bits.size_bits());
  }
  static Picoseconds wrapped(Wide time) {
    return Picoseconds{static_cast<std::int64_t>(static_cast<std::uint64_t>(time))};
  }
  TwoClocks clocks() const { return {wrapped(now_), wrapped(now_ + ahead_)}; }
  // At the limits of the setup.
  Wide gap(unsigned how) const {
    const Wide edges[] = {setup().frame_gap_min.count, setup().frame_gap_max.count,
                          setup().budget.window.count, 0};
    if ((how & 0x80U) != 0) return Wide{1} << (how % 48U);
    return edges[how % 4U] + (Wide{how / 4U % 4U} - 1);
  }

  const Monitor& tested_;
  Monitor monitor_;
  SafetyOracle oracle_;
  ByteSource& bytes_;
  Wide now_ = 0;
  // The second clock less the first one.
  Wide ahead_ = 0;
  Wide latest_ = 0;
  unsigned lowest_ = 1;
  unsigned counter_ = 0;
  std::uint64_t position_ = 0;
  std::uint16_t lead_ = 2;
  std::uint16_t ack_ = 5;
  FrameBits last_;
  // Two rounds of the counter, and the learned range.
  unsigned frames_left_ = 200;
};

Frame Bench::next_frame() {
  counter_ = counter_ == 63 ? lowest_ : counter_ + 1U;
  position_ += 0x1234'5678'9ABCU;
  now_ += setup().cycle_min.count;
  Frame frame;
  frame.channel_count = format().channel_count;
  frame.lead_clocks = std::max(lead_, std::max(setup().bounds.lead_min_clocks, std::uint16_t{1}));
  frame.ack_clocks = std::max(ack_, std::max(setup().bounds.ack_min_clocks, std::uint16_t{1}));
  const std::uint64_t position = position_ & low_mask(cpw().position_bits());
  frame.channel_list[setup().cpw].position = position;
  frame.channel_list[setup().spw].position = spw_position(cpw(), spw(), position);
  frame.channel_list[setup().spw].life_counter = counter_;
  return frame;
}

FrameBits Bench::bits_of(const Frame& frame) const {
  const auto bits = encode_frame(frame, monitor_.plan().codec());
  require(bits.ok());
  return *bits;
}

void Bench::send(const Frame& frame, unsigned flips) {
  FrameBits bits = bits_of(frame);
  // Measured from the end of the frame.
  for (unsigned i = 0; i < 8; ++i) {
    if ((flips >> i & 1U) != 0)
      bits.flip((bits.size_bits() - 1U + i + flips / 8U) % bits.size_bits());
  }
  last_ = bits;
  show(bits);
}

// \param change a part of the second finding that is made another, or none
void Bench::show(const std::vector<std::uint8_t>& bytes, unsigned first, std::size_t size_bits,
                 int change) {
  if (frames_left_ == 0) return;
  --frames_left_;
  // Storage of exactly that size, then the bits one by one.
  const std::vector<std::uint8_t> tight(bytes);
  const BitView view(tight, first, size_bits);
  std::vector<bool> levels;
  for (std::size_t i = 0; i < view.size_bits(); ++i) {
    const std::size_t at = first + i;
    levels.push_back((tight[at / 8U] >> (7U - at % 8U) & 1U) != 0);
  }
  const OracleFrame frame = oracle_.read(levels);
  const Plan& plan = monitor_.plan();
  const SafetyFinding one = FieldEvaluation<Plan>::find(plan, view);
  SafetyFinding other = LineEvaluation<Plan>::find(plan, view);
  require(one == other);
  require(one.cause == frame.cause && one.cpw_position == frame.position);
  require(one.spw_position == frame.spw_position);
  require(one.difference_lsb == frame.apart && one.life_counter == frame.life_counter);
  if (change == 0) other.cpw_position ^= 1U;
  if (change == 1) other.difference_lsb ^= 1;
  if (change == 2) other.life_counter ^= 1U;
  if (change == 3) other.nW ^= 2U;
  if (change == 4) other.spw_position ^= 1U;
  if (change == 5)
    other.cause =
        other.cause == SafetyVerdict::safe ? SafetyVerdict::no_frame : SafetyVerdict::safe;
  const SafetyJudgement judged =
      change < 0 ? monitor_.step(clocks(), view) : monitor_.step(clocks(), one, other);
  const SafetyJudgement due = oracle_.step(now_, ahead_, frame, change >= 0);
  require(judged.verdict == due.verdict && judged.state == due.state);
  require(judged.tolerated == due.tolerated);
  require(judged.position.has_value() == due.position.has_value());
  require(!judged.position || *judged.position == *due.position);
  require(!judged.position || control_position(plan, *judged.position) == frame.position);
  require(judged.cpw_nW == due.cpw_nW && judged.spw_nW == due.spw_nW);
  require(judged.life_counter == due.life_counter && judged.difference_lsb == due.difference_lsb);
  require(judged.position.has_value() == (judged.verdict == SafetyVerdict::safe));
  require(!judged.position ||
          (judged.state == SafetyState::safe && frame.cause == SafetyVerdict::safe));
  require(monitor_.counter_mode() == oracle_.range());
  // The budget's content is undefined after a clock that went backwards.
  if (now_ < latest_) press(0);
  latest_ = now_;
  const auto deadline = oracle_.deadline();
  require(monitor_.deadline().has_value() == deadline.has_value());
  if (deadline) {
    require(static_cast<std::uint64_t>(monitor_.deadline()->count) ==
            static_cast<std::uint64_t>(*deadline));
  }
}

void Bench::press(unsigned how) {
  if (how % 8U == 0) {
    // The next power-up.
    power_up();
    oracle_ = SafetyOracle(format(), setup());
  } else if (how % 8U == 1) {
    monitor_.encoder_restarted();
    oracle_.encoder_restarted();
  } else {
    if (monitor_.state() == SafetyState::latched) {
      require(monitor_.acknowledge(monitor_.latched_cause()));
    }
    oracle_.acknowledge();
  }
}

void Bench::happen(unsigned what, unsigned how) {
  const unsigned more = what >> 4U;
  switch (what % 16U) {
    case good_run:
      for (unsigned left = how % 96U; left != 0 && frames_left_ != 0; --left) send(next_frame());
      break;
    case flip: {
      FrameBits bits = bits_of(next_frame());
      bits.flip((how | more << 8U) % bits.size_bits());
      show(bits);
      break;
    }
    case burst:
      send(next_frame(), how);
      break;
    case counter: {
      Frame frame = next_frame();
      frame.channel_list[setup().spw].life_counter = how % 64U;
      if ((how & 64U) != 0) counter_ = how % 64U;
      send(frame);
      break;
    }
    case apart: {
      Frame frame = next_frame();
      std::uint64_t& value = frame.channel_list[setup().spw].position;
      const std::uint64_t tolerance = setup().comparison.tolerance_lsb;
      const std::uint64_t by = tolerance + how % 4U - 1U;
      const std::uint64_t step = std::uint64_t{1} << monitor_.plan().alignment().spw_shift;
      value += ((how & 4U) != 0 ? by : 0U - by) * step + (more == 1 ? how : 0U);
      value &= low_mask(spw().position_bits());
      send(frame);
      break;
    }
    case flags: {
      Frame frame = next_frame();
      Channel& one = frame.channel_list[setup().cpw];
      Channel& other = frame.channel_list[setup().spw];
      one.nE = !cpw().error.present || (how & 1U) != 0;
      other.nE = !spw().error.present || (how & 2U) != 0;
      one.nW = (how & 4U) != 0;
      other.nW = (how & 8U) != 0;
      send(frame);
      break;
    }
    case silent:
      // A missing answer; the encoder counts it or not.
      if ((how & 1U) != 0) next_frame();
      show({}, 0, 0);
      break;
    case lost:
      for (unsigned left = how % 12U; left != 0; --left) {
        next_frame();
        if ((how & 64U) != 0) now_ -= setup().cycle_min.count;
      }
      send(next_frame());
      break;
    case time: {
      const Frame frame = next_frame();
      now_ += ((how & 64U) != 0 ? -1 : 1) * gap(how & ~64U) - setup().cycle_min.count;
      send(frame);
      break;
    }
    case tick: {
      now_ += gap(how) / 2;
      const SafetyJudgement judged = monitor_.watch(clocks());
      const SafetyJudgement due = oracle_.watch(now_, ahead_);
      require(judged.verdict == due.verdict && judged.state == due.state && !judged.position);
      latest_ = std::max(latest_, now_);
      break;
    }
    case button:
      press(how);
      break;
    case shape: {
      lead_ = static_cast<std::uint16_t>(1U + (more < 8 ? how % 8U : how));
      ack_ = static_cast<std::uint16_t>(1U + (more < 8 ? how / 8U : how));
      Frame frame = next_frame();
      frame.cds = more % 4U == 3;
      FrameBits bits = bits_of(frame);
      if (more % 4U == 2) bits.truncate(bits.size_bits() - how % 5U);
      if (more % 4U == 1) {
        for (unsigned i = 0; i < how % 8U; ++i) bits.flip(i);
      }
      show(bits);
      break;
    }
    case raw: {
      std::vector<std::uint8_t> bytes(how % 32U);
      bytes_.fill(bytes);
      now_ += setup().cycle_min.count;
      show(bytes, more % 8U, bytes.size() * 8U);
      break;
    }
    case differ: {
      const auto bits = bits_of(next_frame());
      const auto stored = bits.bytes();
      show({stored.begin(), stored.end()}, 0, bits.size_bits(), static_cast<int>(how % 6U));
      break;
    }
    case again:
      now_ += setup().cycle_min.count;
      if (last_.size_bits() != 0) show(last_);
      break;
    default: {
      if ((more & clocks_drift) != 0) {
        const Wide tolerance = setup().clocks.tolerance.count;
        ahead_ += ((how & 1U) != 0 ? 1 : -1) * (tolerance + how / 2U % 4U - 1);
      }
      const Wide before = now_;
      const Frame frame = next_frame();
      if ((more & clock_stops) != 0) now_ = before;
      if ((more & expects_position) != 0) {
        const std::uint64_t value = oracle_.read(levels_of(bits_of(frame))).safe.value;
        const std::uint64_t low = value + how % 3U - 1U;
        const std::uint64_t high = value + how / 3U % 3U - 1U;
        monitor_.expect_position(low, high);
        // A monitor that judges nothing keeps the expectation, too.
        oracle_.expect(low, high);
      }
      send(frame);
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  ByteSource bytes(data, size);
  const std::size_t number = bytes.next_16();
  Bench(tested_monitor(number), bytes).run();
  return 0;
}
