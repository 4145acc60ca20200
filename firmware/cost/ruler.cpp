#include "firmware/cost/ruler.hpp"

#include <array>
#include <cstddef>

namespace cost {
namespace {

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

}  // namespace

[[gnu::noinline]] Timed timed(Run run, const Sample& sample) {
  volatile std::uint32_t* const now = systick() + 2;
  const std::uint32_t before = *now;
  const std::uint64_t answer = run(sample);
  return {.ticks = (before - *now) & clock_mask, .answer = answer};
}

std::uint32_t Ruler::instructions(std::uint32_t ticks) const {
  if (ticks <= ticks_of_none) return 0;
  const std::uint64_t slope = ticks_of_long_block - ticks_of_none;
  const std::uint64_t scaled = std::uint64_t{ticks - ticks_of_none} * long_block;
  return static_cast<std::uint32_t>((scaled + slope / 2U) / slope);
}

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

}  // namespace cost
