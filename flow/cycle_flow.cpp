#include "flow/cycle_flow.hpp"

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/parallel_pipeline.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "decode/run_join.hpp"
#include "flow/piece.hpp"

namespace biss::flow {

namespace {

class Flow {
 public:
  Flow(capture::PairSource& source, const decode::CleanCycleFinder& finder, const FlowSetup& setup,
       decode::Decoder& decoder)
      : source_(source), finder_(finder), setup_(setup), join_(finder, decoder) {}

  void run_here() {
    Piece piece(finder_);
    while (piece.fetch(source_)) {
      piece.expand(setup_.lines);
      if (!settle(piece)) return;
    }
  }

  void run_on_all(unsigned threads) {
    namespace tbb = oneapi::tbb;
    // More than the processors, where the caller asks for it.
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    tbb::task_arena arena(static_cast<int>(threads));
    arena.execute([&] {
      tbb::parallel_pipeline(
          // One piece is fetched or decoded while each thread has one.
          threads + 1, tbb::make_filter<void, Piece*>(tbb::filter_mode::serial_in_order,
                                                      [this](tbb::flow_control& control) {
                                                        Piece* piece = stopped() ? nullptr : next();
                                                        if (piece == nullptr) control.stop();
                                                        return piece;
                                                      }) &
                           tbb::make_filter<Piece*, Piece*>(tbb::filter_mode::parallel,
                                                            [this](Piece* piece) {
                                                              piece->expand(setup_.lines);
                                                              return piece;
                                                            }) &
                           tbb::make_filter<Piece*, void>(tbb::filter_mode::serial_in_order,
                                                          [this](Piece* piece) { take(piece); }));
    });
  }

  void finish() { join_.flush(); }

 private:
  // False where no further piece counts.
  bool settle(Piece& piece) {
    piece.settle(source_, setup_.lines, join_);
    return !source_.error() && (!setup_.go_on || setup_.go_on());
  }

  void take(Piece* piece) {
    const bool done = stopped() || !settle(*piece);
    const std::lock_guard lock(mutex_);
    stopped_ = stopped_ || done;
    free_.push_back(piece);
  }

  bool stopped() {
    const std::lock_guard lock(mutex_);
    return stopped_;
  }

  // The next piece, in an object that is free; null at the end.
  Piece* next() {
    Piece* piece = nullptr;
    {
      const std::lock_guard lock(mutex_);
      if (free_.empty()) {
        pieces_.push_back(std::make_unique<Piece>(finder_));
        free_.push_back(pieces_.back().get());
      }
      piece = free_.back();
      free_.pop_back();
    }
    return piece->fetch(source_) ? piece : nullptr;
  }

  capture::PairSource& source_;
  const decode::CleanCycleFinder& finder_;
  const FlowSetup& setup_;
  decode::RunJoin join_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<Piece>> pieces_;
  std::vector<Piece*> free_;
  bool stopped_ = false;
};

}  // namespace

void decode_pieces(capture::PairSource& source, const decode::CleanCycleFinder& finder,
                   const FlowSetup& setup, decode::Decoder& decoder) {
  Flow flow(source, finder, setup, decoder);
  const unsigned threads =
      setup.threads != 0 ? setup.threads
                         : static_cast<unsigned>(oneapi::tbb::this_task_arena::max_concurrency());
  if (threads == 1) {
    flow.run_here();
  } else {
    flow.run_on_all(threads);
  }
  flow.finish();
}

}  // namespace biss::flow
