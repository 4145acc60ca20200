#include "verbs/report/shared_reading.hpp"

namespace biss::verbs {

SharedReading::Reader::Reader(DecodedCapture& own, const DecodedCapture& host)
    : capture(own),
      same_cycles(own.reads_as(host)),
      lines(own.lines().lines),
      decoder(own.reader(), [&own](const decode::Cycle& cycle) { own.take(cycle); }),
      finder(own.format(), own.reading_timing(), own.margin()),
      join(finder, decoder) {}

void SharedReading::Reader::take(std::span<const wire::Edge> edges) {
  if (capture.watcher() != nullptr) capture.watcher()->take(edges);
  if (!same_cycles) join.push(edges, lines);
}

void SharedReading::Reader::take(const capture::PairPiece& changes) {
  if (!same_cycles) {
    const decode::PairRun run{{changes.ma.times, changes.ma.first_high != lines.ma_inverted},
                              {changes.slo.times, changes.slo.first_high != lines.slo_inverted}};
    finder.find(run, clean);
    join.push(run, clean);
  }
  if (capture.watcher() != nullptr) capture.watcher()->take(changes);
}

void SharedReading::wait() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return missing_ == 0; });
}

void SharedReading::take(const decode::Cycle& cycle) {
  for (Reader& reader : readers_) {
    if (reader.same_cycles) reader.capture.take(cycle);
  }
}

void SharedReading::take(std::span<const wire::Edge> edges) {
  watcher_.take(edges);
  for (Reader& reader : readers_) reader.take(edges);
}

void SharedReading::take(const capture::PairPiece& changes) {
  watcher_.take(changes);
  for (Reader& reader : readers_) reader.take(changes);
}

void SharedReading::end() {
  const std::lock_guard lock(mutex_);
  if (ended_) return;
  ended_ = true;
  for (Reader& reader : readers_) {
    const Picoseconds end_time = capture_.end_time();
    if (!reader.same_cycles) {
      reader.join.flush();
      reader.decoder.finish(end_time);
    }
    reader.capture.set_end_time(end_time);
  }
  changed_.notify_all();
}

bool SharedReading::Guest::join(DecodedCapture& capture) {
  if (settled_) return false;
  settled_ = true;
  return reading_.join(capture);
}

bool SharedReading::join(DecodedCapture& capture) {
  const decode::Lines& own = capture.lines().lines;
  const decode::Lines& read = capture_.lines().lines;
  std::unique_lock lock(mutex_);
  --missing_;
  changed_.notify_all();
  if (ended_ || own.ma != read.ma || own.slo != read.slo) return false;
  readers_.emplace_back(capture, capture_);
  changed_.wait(lock, [this] { return ended_; });
  return true;
}

void SharedReading::leave() {
  const std::lock_guard lock(mutex_);
  --missing_;
  changed_.notify_all();
}

}  // namespace biss::verbs
