#include "decode/decoder.hpp"

#include <algorithm>
#include <array>

namespace biss::decode {

namespace {

using wire::Level;

// Half a period at the slowest legal clock with the most uneven duty, and a little more.
constexpr Picoseconds longest_half = microseconds(8);
constexpr Picoseconds half_when_unknown = nanoseconds(6'250);

// Stillness in halves of a period: beyond the first a cycle may have ended, beyond the second it
// has.
constexpr std::int64_t still_tenths_maybe_end = 25;
constexpr std::int64_t still_halves_sure_end = 8;

}  // namespace

void Decoder::push_ma(LevelChange change) {
  if (!ma_seen_ || (ma_level_ == Level::unknown && !idle_known_ && ma_.empty())) {
    ma_seen_ = true;
    begin_time_ = change.time;
    ma_level_ = change.level;
    return;
  }
  if (change.level == ma_level_) return;
  ma_level_ = change.level;
  if (swallowing_) {
    const bool still = (change.time - end_time_).count * 10 > half_.count * still_tenths_maybe_end;
    end_time_ = change.time;
    if (!still) return;
    swallowing_ = false;
  }
  ma_.push_back(change);
  drain(false);
}

void Decoder::push(std::span<const wire::Edge> edges, const Lines& lines) {
  for (const wire::Edge& edge : edges) {
    if (edge.line == lines.ma) {
      push_ma({edge.time, edge.level});
    } else if (edge.line == lines.slo) {
      push_slo({edge.time, edge.level});
    }
  }
}

void Decoder::finish(Picoseconds end_time) {
  end_time_ = end_time;
  drain(true);
}

void Decoder::drain(bool at_end) {
  while (drop_to_begin(at_end) && take_cycle(at_end)) {
  }
}

// A rising edge that follows a cycle's end is MA going back to idle (CDM = 1), not a clock.
bool Decoder::drop_to_begin(bool at_end) {
  if (scanned_ != 0) return true;
  if (idle_known_) {
    const auto begin = std::find_if(ma_.begin(), ma_.end(), [](const LevelChange& change) {
      return change.level != Level::high;
    });
    ma_.erase(ma_.begin(), begin);
  }
  if (ma_.empty() || (ma_.size() < lookahead_edges && !at_end)) return false;
  half_ = half_period_ahead();
  scanned_ = 1;
  return true;
}

Picoseconds Decoder::half_period_ahead() const {
  std::array<Picoseconds, lookahead_edges> halves{};
  std::size_t count = 0;
  for (std::size_t i = 1; i < ma_.size() && i < lookahead_edges; ++i) {
    const Picoseconds half = ma_[i].time - ma_[i - 1].time;
    if (half <= longest_half) halves[count++] = half;
  }
  if (count < 4 && usual_half_.count != 0) return usual_half_;
  if (count == 0) return half_when_unknown;
  const auto middle = halves.begin() + static_cast<std::ptrdiff_t>(count / 2);
  std::nth_element(halves.begin(), middle, halves.begin() + static_cast<std::ptrdiff_t>(count));
  return std::max(*middle, picoseconds(1));
}

// Emits the cycle at the front when its end is in sight. False: more edges are needed.
bool Decoder::take_cycle(bool at_end) {
  for (; scanned_ < ma_.size(); ++scanned_) {
    if (scanned_ >= max_cycle_edges) {
      emit(scanned_, ma_[scanned_].time, false);
      end_time_ = ma_.empty() ? end_time_ : ma_.back().time;
      ma_.clear();
      swallowing_ = true;
      return false;
    }
    const Picoseconds still = ma_[scanned_].time - ma_[scanned_ - 1].time;
    if (still.count * 10 <= half_.count * still_tenths_maybe_end) continue;
    const std::size_t next_fall = scanned_ + (ma_[scanned_].level == Level::high ? 1 : 0);
    if (next_fall >= ma_.size() && !at_end) return false;
    const Picoseconds limit = next_fall < ma_.size() ? ma_[next_fall].time : end_time_;
    const bool sure = still > half_ * still_halves_sure_end;
    if (!sure && !reader_.read(span_of(scanned_, limit, false), slo_).complete) continue;
    emit(scanned_, limit, next_fall >= ma_.size());
    return true;
  }
  if (!at_end) return false;
  emit(scanned_, end_time_, true);
  return true;
}

CycleSpan Decoder::span_of(std::size_t edges, Picoseconds limit, bool last_of_capture) const {
  CycleSpan span;
  span.ma = std::span<const LevelChange>(ma_).first(edges);
  // 1.5 periods of idle before the first edge tell a beginning from the middle of a cycle.
  span.begins_idle = idle_known_ || (ma_.front().level == Level::low &&
                                     ma_.front().time - begin_time_ >= 3 * half_);
  span.limit = limit;
  span.last_of_capture = last_of_capture;
  return span;
}

void Decoder::emit(std::size_t edges, Picoseconds limit, bool last_of_capture) {
  const CycleReading reading = reader_.read(span_of(edges, limit, last_of_capture), slo_);
  if (reading.cycle.rising_edges >= 4) usual_half_ = *reading.cycle.period / 2;
  ma_.erase(ma_.begin(), ma_.begin() + static_cast<std::ptrdiff_t>(edges));
  slo_.forget_before(limit);
  scanned_ = 0;
  idle_known_ = true;
  on_cycle_(reading.cycle);
}

}  // namespace biss::decode
