// Counts the instructions and the stack of every row over many samples, and checks the result of
// each call. Prints `row NAME|TITLE|MEAN|MOST|STACK` for firmware/sizes.
#include <algorithm>
#include <array>
#include <cstdint>

#include "firmware/cost/prepare.hpp"
#include "firmware/cost/row.hpp"
#include "firmware/cost/ruler.hpp"
#include "firmware/cost/sample.hpp"
#include "firmware/platform/console.hpp"
#include "firmware/platform/startup.hpp"

extern "C" {
extern const cost::Row __start_biss_rows[];
extern const cost::Row __stop_biss_rows[];
}

namespace cost {

namespace {

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
  biss::ControlSession control;
  EncoderServer server{biss::BankedRegisters<2>()};
  SafetyMonitor safety;
  cost.right = safety.self_test();
  const MonitorBytes tested(safety);
  Sample sample;
  sample.reader = &reader;
  sample.counter = &counter;
  sample.slave = &slave;
  sample.master = &master;
  sample.control = &control;
  sample.server = &server;
  sample.safety = &safety;
  sample.tested = &tested;
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

  bool right = true;
  for (const Row* row = __start_biss_rows; row != __stop_biss_rows; ++row) {
    const Cost cost = cost_of(*row, ruler, reader);
    print(*row, cost);
    right = right && cost.right;
  }
  return right ? 0 : 1;
}
