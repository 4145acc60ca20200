#include "live/spi_bus.hpp"

#include <algorithm>

namespace biss::live {

namespace {

constexpr std::uint32_t largest_divider = 65'536;
constexpr Hertz slowest_clock = kilohertz(1);
constexpr Hertz fastest_clock = megahertz(100);

}  // namespace

Hertz SpiBus::rate_min() const {
  if (setup_.clock.count == 0) return slowest_clock;
  return Hertz{(setup_.clock.count - 1) / largest_divider + 1};
}

Hertz SpiBus::rate_max() const {
  if (setup_.clock.count == 0) return fastest_clock;
  return std::min(Hertz{setup_.clock.count / 2}, fastest_clock);
}

Picoseconds SpiBus::period_at(Hertz rate) const {
  const std::int64_t clock = setup_.clock.count;
  if (clock == 0) return period_of(rate);
  const std::int64_t least = (clock - 1) / rate.count + 1;
  const std::int64_t divider = std::max<std::int64_t>(least + least % 2, 2);
  return picoseconds((picoseconds_per_second * divider + clock / 2) / clock);
}

void SpiBus::begin(Picoseconds now, SpiMode mode, Picoseconds period) {
  time_ = std::max(time_, now);
  mode_ = mode;
  if (setup_.ma == MaSource::mosi || sck_ == mode.clock_idle) return;
  sck_ = mode.clock_idle;
  encoder_.put_ma(time_, sck_);
  time_ += period;
}

std::uint32_t SpiBus::exchange(std::uint32_t out, unsigned bits, Picoseconds period,
                               Picoseconds more_gap) {
  std::uint32_t in = 0;
  for (unsigned k = 0; k < bits; ++k) {
    const unsigned place = mode_.lsb_first ? k : bits - 1U - k;
    if (exchange_bit((out >> place & 1U) != 0, period)) in |= std::uint32_t{1} << place;
  }
  time_ += setup_.word_gap + more_gap;
  return in;
}

// MISO is sampled in the middle of each clock, MOSI holds its level for a whole one.
bool SpiBus::exchange_bit(bool out, Picoseconds period) {
  const bool clocks = setup_.ma == MaSource::sck;
  const Picoseconds middle = time_ + period / 2;
  if (!clocks) encoder_.put_ma(time_, out);
  if (clocks && mode_.second_edge) encoder_.put_ma(time_, !mode_.clock_idle);
  const bool in = encoder_.slo(middle);
  if (clocks) encoder_.put_ma(middle, mode_.second_edge == mode_.clock_idle);
  time_ += period;
  if (clocks && !mode_.second_edge) encoder_.put_ma(time_, mode_.clock_idle);
  return in;
}

}  // namespace biss::live
