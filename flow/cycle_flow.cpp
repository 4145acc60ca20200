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

namespace biss::flow {

namespace {

// A piece on its way, with what a thread needs for it.
struct Load {
  explicit Load(const decode::CleanCycleFinder& like) : finder(like) {}

  std::unique_ptr<capture::PairPiece> piece;
  decode::CleanCycleFinder finder;
  std::vector<decode::CleanCycle> clean;
};

class Flow {
 public:
  Flow(capture::PairSource& source, const decode::CleanCycleFinder& finder, const FlowSetup& setup,
       decode::Decoder& decoder)
      : source_(source),
        finder_(finder),
        setup_(setup),
        decoder_(decoder),
        join_(finder, decoder) {}

  void run_here() {
    Load load(finder_);
    while ((load.piece = source_.fetch(std::move(load.piece)))) {
      expand(load);
      if (!settle(load)) return;
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
          threads + 1, tbb::make_filter<void, Load*>(tbb::filter_mode::serial_in_order,
                                                     [this](tbb::flow_control& control) {
                                                       Load* load = stopped() ? nullptr : next();
                                                       if (load == nullptr) control.stop();
                                                       return load;
                                                     }) &
                           tbb::make_filter<Load*, Load*>(tbb::filter_mode::parallel,
                                                          [this](Load* load) {
                                                            expand(*load);
                                                            return load;
                                                          }) &
                           tbb::make_filter<Load*, void>(tbb::filter_mode::serial_in_order,
                                                         [this](Load* load) { take(load); }));
    });
  }

  void finish() { join_.flush(); }

 private:
  decode::PairRun run_of(const capture::PairPiece& piece) const {
    return {{piece.ma.times, piece.ma.first_high != setup_.lines.ma_inverted},
            {piece.slo.times, piece.slo.first_high != setup_.lines.slo_inverted}};
  }

  void expand(Load& load) const {
    load.piece->expand();
    load.finder.find(run_of(*load.piece), load.clean);
  }

  // False where no further piece counts.
  bool settle(Load& load) {
    const bool regular = source_.settle(*load.piece, [this](std::span<const wire::Edge> edges) {
      join_.flush();
      decoder_.push(edges, setup_.lines);
    });
    if (regular) join_.push(run_of(*load.piece), load.clean);
    return !source_.error() && (!setup_.go_on || setup_.go_on());
  }

  void take(Load* load) {
    const bool done = stopped() || !settle(*load);
    const std::lock_guard lock(mutex_);
    stopped_ = stopped_ || done;
    free_.push_back(load);
  }

  bool stopped() {
    const std::lock_guard lock(mutex_);
    return stopped_;
  }

  // The next piece, in a load that is free; null at the end.
  Load* next() {
    Load* load = nullptr;
    {
      const std::lock_guard lock(mutex_);
      if (free_.empty()) {
        loads_.push_back(std::make_unique<Load>(finder_));
        free_.push_back(loads_.back().get());
      }
      load = free_.back();
      free_.pop_back();
    }
    load->piece = source_.fetch(std::move(load->piece));
    return load->piece ? load : nullptr;
  }

  capture::PairSource& source_;
  const decode::CleanCycleFinder& finder_;
  const FlowSetup& setup_;
  decode::Decoder& decoder_;
  decode::RunJoin join_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<Load>> loads_;
  std::vector<Load*> free_;
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
