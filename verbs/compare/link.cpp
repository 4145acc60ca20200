#include "verbs/compare/compare.hpp"

#include <algorithm>

#include "biss/base/bits.hpp"
#include "decode/times.hpp"
#include "verbs/common/explained.hpp"

namespace biss::verbs {

namespace {

using decode::Cycle;

// The cycles of a link in their order.
class LinkReader {
 public:
  LinkReader(Link& link, const DecodedCapture& capture)
      : link_(link),
        format_(capture.format()),
        check_({.format = capture.format(),
                .timing = capture.timing(),
                .compensated = capture.margin().compensated,
                .resolution = capture.margin().resolution}) {}

  void add(const Cycle& cycle) {
    check_.push(number_++, cycle);
    link_.statistics.add(cycle);
    add_rest(cycle);
    add_signal(cycle);
    add_position(cycle);
  }

  void finish() {
    check_.finish();
    for (std::size_t i = 0; i < decode::rule_count; ++i) {
      link_.rules[i] = check_.result(static_cast<decode::Rule>(i));
    }
  }

 private:
  void add_rest(const Cycle& cycle) {
    if (last_edge_) link_.rest.add(decode::elapsed(*last_edge_, cycle.time).count);
    last_edge_ = cycle.time + cycle.clocked;
  }

  void add_signal(const Cycle& cycle) {
    if (!cycle.signal || !cycle.period) return;
    const std::int64_t period = cycle.period->count;
    if (cycle.signal->ma_shortest && cycle.duty_per_mille) {
      const auto duty = static_cast<std::int64_t>(*cycle.duty_per_mille);
      const std::int64_t usual = std::min(duty, 1000 - duty) * (period / 1000);
      link_.jitter_ma.add(usual - cycle.signal->ma_shortest->count);
    }
    if (!cycle.signal->changes || period == 0) return;
    const decode::LineSignal::Changes& changes = *cycle.signal->changes;
    link_.jitter_slo.add((changes.latest - changes.earliest).count);
    const std::int64_t before = (changes.sampled - changes.latest).count + period / 2;
    const std::int64_t after = (changes.earliest - changes.sampled).count + period / 2;
    const auto nearest = static_cast<double>(std::min(before, after));
    link_.margin.add(static_cast<std::int64_t>(1000 * nearest / static_cast<double>(period)));
  }

  // The shorter way around the ring of positions is the least that the encoder has moved.
  void add_position(const Cycle& cycle) {
    const auto before = last_position_;
    last_position_.reset();
    if (!cycle.frame || !format_) return;
    const unsigned bits = format_->channels().front().position_bits();
    if (bits == 0) return;
    const std::uint64_t position = cycle.frame->channels().front().position;
    last_position_ = position;
    const std::int64_t time = decode::elapsed(position_time_, cycle.time).count;
    position_time_ = cycle.time;
    if (!before || time <= 0) return;
    const std::uint64_t moved =
        std::min((position - *before) & low_mask(bits), (*before - position) & low_mask(bits));
    const double speed = static_cast<double>(moved) * 1e12 / static_cast<double>(time);
    link_.step.add(static_cast<std::int64_t>(std::min<std::uint64_t>(moved, INT64_MAX)));
    link_.speed.add(static_cast<std::int64_t>(std::min(speed, 9e18)));
  }

  Link& link_;
  std::optional<FrameFormat> format_;
  decode::Check check_;
  std::uint64_t number_ = 0;
  std::optional<Picoseconds> last_edge_;
  std::optional<std::uint64_t> last_position_;
  Picoseconds position_time_{};
};

}  // namespace

std::optional<Link> read_link(DecodedCapture& capture) {
  Link link;
  link.context = explain_context(capture);
  link.context.given = true;
  const decode::Lines& lines = link.context.reading.lines;
  link.resolution = capture.margin().resolution;
  link.ma = capture.input().lines()[lines.ma];
  link.slo = capture.input().lines()[lines.slo];
  LinkReader reader(link, capture);
  const auto add = [&reader](const Cycle& cycle) { reader.add(cycle); };
  if (!observe(capture, lines, add, link.evidence)) return std::nullopt;
  reader.finish();
  return link;
}

}  // namespace biss::verbs
