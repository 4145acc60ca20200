#include "sim/ideal_line.hpp"

#include <algorithm>

namespace biss::sim {

namespace {

using wire::Level;

Level level_of(bool high) { return high ? Level::high : Level::low; }

// Rising edges of MA for a whole frame: LAT, ACK, START, CDS, channels, STOP.
std::int64_t clocks_of(const FrameFormat& format, std::uint16_t ack_clocks) {
  return 1 + std::int64_t{ack_clocks} + 2 + format.payload_bits() + 1;
}

}  // namespace

IdealLine::IdealLine(const IdealLineSetup& setup)
    : setup_(setup),
      codec_(setup.format),
      motion_(setup.motion, setup.format.channel_list[0].position_bits(), setup.seed),
      random_(setup.seed ^ 0x5DEECE66DULL),
      period_(period_of(setup.clock)),
      ack_clocks_(ack_bounds(setup.timing, period_).min_clocks),
      begin_(20 * period_) {}

// SLO goes back to 1 at the encoder's timeout, seen later by the line delay.
Picoseconds IdealLine::release_time(Picoseconds begin, Picoseconds last_edge) const {
  const Timeout& timeout = setup_.timing.timeout;
  const Picoseconds soonest = last_edge + period_ + period_ / 2;
  switch (timeout.rule) {
    case TimeoutRule::adaptive:
      return soonest;
    case TimeoutRule::fixed:
      return std::max(soonest, last_edge + timeout.time);
    case TimeoutRule::cycle:
      return std::max(soonest, begin + timeout.time);
  }
  return soonest;
}

Picoseconds IdealLine::least_interval() const {
  const std::int64_t clocks = clocks_of(setup_.format, ack_clocks_);
  const Picoseconds last_edge = clocks * period_ - period_ / 2;
  const Picoseconds ready = release_time({}, last_edge) + setup_.line_delay + period_;
  return std::max(ready, setup_.timing.cycle_min);
}

Frame IdealLine::next_frame() {
  Frame frame;
  frame.channel_count = setup_.format.channel_count;
  frame.ack_clocks = ack_clocks_;
  frame.lead_clocks = 1;
  const auto channels = setup_.format.channels();
  const unsigned first_bits = channels[0].position_bits();
  const std::uint64_t position = motion_.next();
  life_counter_ = life_counter_ % 63 + 1;
  for (std::size_t k = 0; k < channels.size(); ++k) {
    // Further words repeat the position with their own resolution, aligned at the top.
    const unsigned bits = channels[k].position_bits();
    Channel& channel = frame.channel_list[k];
    channel.position = bits <= first_bits ? (bits == 0 ? 0 : position >> (first_bits - bits))
                                          : position << (bits - first_bits);
    channel.life_counter =
        static_cast<std::uint32_t>(life_counter_ & low_mask(channels[k].life_counter.bits));
  }
  return frame;
}

void IdealLine::put_edges(const FrameBits& bits, Picoseconds begin, SimulatedCycle& cycle) const {
  std::vector<wire::Edge>& edges = cycle.edges;
  const BitView view = bits.view();
  bool slo = true;
  Picoseconds rise{};
  for (std::size_t i = 0; i < view.size_bits(); ++i) {
    const Picoseconds fall = begin + static_cast<std::int64_t>(i) * period_;
    rise = fall + period_ / 2;
    edges.push_back({fall, ma_line, Level::low});
    edges.push_back({rise, ma_line, Level::high});
    if (view.bit(i) == slo) continue;
    slo = view.bit(i);
    edges.push_back({rise + setup_.line_delay, slo_line, level_of(slo)});
  }
  if (!slo) {
    edges.push_back({release_time(begin, rise) + setup_.line_delay, slo_line, Level::high});
  }
  std::stable_sort(edges.begin(), edges.end(),
                   [](const wire::Edge& a, const wire::Edge& b) { return a.time < b.time; });
}

SimulatedCycle IdealLine::next() {
  SimulatedCycle cycle;
  cycle.time = begin_;
  cycle.sent = next_frame();
  FrameBits bits = *encode_frame(cycle.sent, codec_);
  // Both draws are made each time, so that a share changes which cycles are hit and nothing else.
  const bool hit = (random_() >> 32U) < setup_.flip_share;
  const std::size_t place = random_() % codec_.payload_bits();
  if (hit) {
    bits.flip(1U + ack_clocks_ + 2U + place);
    cycle.flipped = true;
  }
  put_edges(bits, begin_, cycle);
  begin_ += std::max(setup_.interval, least_interval());
  return cycle;
}

}  // namespace biss::sim
