// Counts the instructions and the stack of every row over many samples, and checks the result of
// each call. Prints `row NAME|TITLE|MEAN|MOST|STACK` for firmware/sizes.
#include <algorithm>
#include <array>
#include <cstdint>

#include "firmware/cost/c_reader.hpp"
#include "firmware/cost/prepare.hpp"
#include "firmware/cost/row.hpp"
#include "firmware/cost/sample.hpp"
#include "firmware/platform/console.hpp"
#include "firmware/platform/startup.hpp"

extern "C" {
extern const cost::Row __start_biss_rows[];
extern const cost::Row __stop_biss_rows[];
}

namespace cost {

namespace {

// ---- The ruler: counts instructions with SysTick under QEMU's -icount, which gives every
// instruction the same virtual time. The ticks per instruction are measured on blocks of known
// length in the same run.

constexpr std::uint32_t long_block = 8000;
constexpr std::uint32_t clock_mask = 0xFF'FFFFU;

// Arm v6-M and v7-M: SYST_CSR, SYST_RVR, SYST_CVR.
volatile std::uint32_t* systick() {
  return reinterpret_cast<volatile std::uint32_t*>(0xE000'E010U);
}

// Only the block and the return, so that a block of 0 measures the cost of a call.
template <std::uint32_t Count>
[[gnu::naked, gnu::noinline]] std::uint64_t nops(const Sample&) {
  asm volatile(".rept %c0\n nop\n .endr\n bx lr" ::"i"(Count));
}

/// The ticks and the result of a call.
struct Timed {
  std::uint32_t ticks = 0;
  std::uint64_t answer = 0;
};

// Calls `run` between two readings of the clock.
[[gnu::noinline]] Timed timed(Run run, const Sample& sample) {
  volatile std::uint32_t* const now = systick() + 2;
  const std::uint32_t before = *now;
  const std::uint64_t answer = run(sample);
  return {.ticks = (before - *now) & clock_mask, .answer = answer};
}

/// Ticks = ticks_of_none + slope * instructions; a call and its return are part of ticks_of_none.
struct Ruler {
  std::uint32_t ticks_of_none = 0;
  std::uint32_t ticks_of_long_block = 0;
  /// The other blocks are measured to the exact instruction.
  bool straight = false;

  /// Instructions of a call that took this number of ticks, rounded; call and return not counted.
  std::uint32_t instructions(std::uint32_t ticks) const {
    if (ticks <= ticks_of_none) return 0;
    const std::uint64_t slope = ticks_of_long_block - ticks_of_none;
    const std::uint64_t scaled = std::uint64_t{ticks - ticks_of_none} * long_block;
    return static_cast<std::uint32_t>((scaled + slope / 2U) / slope);
  }
};

// Starts SysTick and measures blocks of 0, 1, 10, 100, 1000, 3000 and 8000 NOPs.
Ruler calibrate() {
  systick()[1] = clock_mask;
  systick()[2] = 0;
  systick()[0] = 5;  // processor clock, no interrupt, on

  const Sample sample;
  Ruler ruler{.ticks_of_none = timed(nops<0>, sample).ticks,
              .ticks_of_long_block = timed(nops<long_block>, sample).ticks};
  if (ruler.ticks_of_long_block <= ruler.ticks_of_none) return ruler;
  struct Block {
    std::uint32_t length;
    Run run;
  };
  const std::array<Block, 5> blocks{
      {{1, nops<1>}, {10, nops<10>}, {100, nops<100>}, {1000, nops<1000>}, {3000, nops<3000>}}};
  ruler.straight = true;
  for (const Block& block : blocks) {
    const std::uint32_t counted = ruler.instructions(timed(block.run, sample).ticks);
    ruler.straight = ruler.straight && counted == block.length;
  }
  return ruler;
}

// ---- The cost of a row

constexpr std::uint64_t seed = 0xB155'C057;
constexpr std::uint32_t paint = 0xA5A5'A5A5U;

struct Cost {
  std::uint64_t sum = 0;
  std::uint32_t most = 0;
  std::uint32_t stack_bytes = 0;
  bool right = true;
};

// From the caller's stack pointer down to the lowest word the call changed.
[[gnu::noinline]] std::uint32_t stack_of_call(Run run, const Sample& sample) {
  std::uint32_t* top = nullptr;
  asm volatile("mov %0, sp" : "=r"(top));
  for (volatile std::uint32_t* at = stack_bottom; at != top; ++at) *at = paint;
  run(sample);
  const std::uint32_t* lowest = stack_bottom;
  while (lowest != top && *const_cast<const volatile std::uint32_t*>(lowest) == paint) ++lowest;
  return static_cast<std::uint32_t>(top - lowest) * 4U;
}

Cost cost_of(const Row& row, const Ruler& ruler, const biss::SpiReader<Codec>& reader) {
  Cost cost;
  biss::test::Random random(seed);
  biss::TurnCounter counter(26);
  EncoderSlave slave({}, {}, {});
  EncoderMaster master({}, master_setup);
  Pins pins;
  biss::PolledRequest polled(pins, pins_setup, pins_timing);
  biss::ControlSession control;
  EncoderServer server{biss::BankedRegisters<2>()};
  SafetyMonitor safety;
  cost.right = safety.self_test();
  const MonitorBytes tested(safety);
  Sample sample{.reader = &reader,
                .pins = &pins,
                .polled = &polled,
                .counter = &counter,
                .slave = &slave,
                .master = &master,
                .control = &control,
                .server = &server,
                .safety = &safety,
                .tested = &tested};
  for (std::uint32_t i = 0; i < row.samples; ++i) {
    row.prepare(sample, random);
    const Timed call = timed(row.run, sample);
    const std::uint32_t instructions = ruler.instructions(call.ticks);
    cost.sum += instructions;
    cost.most = std::max(cost.most, instructions);
    cost.right = cost.right && call.answer == sample.expected;
    // Painting the stack takes longer than the call.
    if (i >= usual_samples) continue;
    cost.stack_bytes = std::max(cost.stack_bytes, stack_of_call(row.run, sample));
  }
  return cost;
}

void print(const Row& row, const Cost& cost) {
  firmware::print("row ", row.name, "|", row.title, "|",
                  (cost.sum + row.samples / 2U) / row.samples, "|", cost.most, "|",
                  cost.stack_bytes, cost.right ? "\n" : "|WRONG ANSWER\n");
}

}  // namespace
}  // namespace cost

int firmware_main() {
  using namespace cost;
  const Ruler ruler = calibrate();
  firmware::print(
      "ruler ", ruler.ticks_of_long_block - ruler.ticks_of_none, " ticks for 8000 instructions, ",
      ruler.ticks_of_none,
      ruler.straight ? " for 0 instructions, linear\n" : " for 0 instructions, NOT LINEAR\n");
  if (!ruler.straight) return 1;

  // Through a volatile pointer, so that the format is unknown to the compiler.
  const biss::FrameFormat* volatile hidden = &format;
  const biss::SpiReader<Codec> reader(Codec(*hidden), setup, encoder.timing);

  bool right = make_c_reader() == BISS_OK;
  for (const Row* row = __start_biss_rows; row != __stop_biss_rows; ++row) {
    const Cost cost = cost_of(*row, ruler, reader);
    print(*row, cost);
    right = right && cost.right;
  }
  return right ? 0 : 1;
}
