// One reading of a capture for the report and for the verbs of its panels.
#pragma once

#include <condition_variable>
#include <deque>
#include <mutex>
#include <vector>

#include "flow/piece.hpp"
#include "verbs/common/decoded_capture.hpp"

namespace biss::verbs {

/// The reading of a capture in which verbs in other threads take part: each of them runs as if it
/// read the capture itself.
///
///     SharedReading reading(capture, watcher, guests);   // then a thread for each guest
///     reading.wait();
///     capture.read([&](…, const decode::Cycle& cycle) { reading.take(cycle); … }, &reading);
///     reading.end();
class SharedReading final : public flow::ChangeWatcher {
 public:
  /// \param watcher also sees the changes
  /// \param guests the number of guests that there will be
  SharedReading(const DecodedCapture& capture, flow::ChangeWatcher& watcher, std::size_t guests)
      : capture_(capture), watcher_(watcher), missing_(guests) {}

  /// Waits until each guest has joined, or will not join.
  void wait();
  void take(const decode::Cycle& cycle);
  void take(std::span<const wire::Edge> edges) override;
  void take(const capture::PairPiece& changes) override;
  /// The capture is read: the guests go on. Call it before their threads are joined, also after an
  /// exception.
  void end();

  /// The place of one verb, in the thread of the verb.
  class Guest final : public JointReading {
   public:
    explicit Guest(SharedReading& reading) : reading_(reading) {}
    ~Guest() override {
      if (!settled_) reading_.leave();
    }
    /// False for other lines, and for a further reading.
    bool join(DecodedCapture& capture) override;

   private:
    SharedReading& reading_;
    bool settled_ = false;
  };

 private:
  // A guest that has joined.
  struct Reader {
    Reader(DecodedCapture& capture, const DecodedCapture& host);
    void take(std::span<const wire::Edge> edges);
    void take(const capture::PairPiece& changes);

    DecodedCapture& capture;
    // The cycles are the same. Otherwise they are decoded again, from the changes.
    bool same_cycles;
    decode::Lines lines;
    decode::Decoder decoder;
    decode::CleanCycleFinder finder;
    decode::RunJoin join;
    std::vector<decode::CleanCycle> clean;
  };

  bool join(DecodedCapture& capture);
  void leave();

  const DecodedCapture& capture_;
  flow::ChangeWatcher& watcher_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::size_t missing_;
  bool ended_ = false;
  std::deque<Reader> readers_;
};

}  // namespace biss::verbs
