#include "flow/cycle_flow.hpp"

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <deque>
#include <exception>
#include <limits>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

namespace biss::flow {

class CycleFlow::Workers {
 public:
  Workers(CycleFlow& flow, const std::function<bool()>& go_on) : flow_(flow), go_on_(go_on) {}

  void run(unsigned threads) {
    std::deque<Piece> pieces;
    while (pieces.size() < threads) pieces.emplace_back(flow_.finder_);
    {
      std::vector<std::jthread> others;
      try {
        for (Piece& piece : pieces) {
          if (&piece != &pieces.front()) others.emplace_back([&] { work(piece, threads - 1); });
        }
      } catch (const std::system_error&) {
        // The system gives no further threads: the running ones do all the work.
      }
      work(pieces.front(), threads - 1);
    }
    if (failure_) std::rethrow_exception(failure_);
  }

 private:
  // Threads that have a number each take turns in the order of their numbers.
  class Turns {
   public:
    // Waits for the turn of this number. False: no further turn comes.
    bool wait(std::uint64_t number) {
      std::uint64_t now = next_.load(std::memory_order_acquire);
      for (int i = 0; now != number && now != over && i < most_yields; ++i) {
        std::this_thread::yield();
        now = next_.load(std::memory_order_acquire);
      }
      while (now != number && now != over) {
        next_.wait(now, std::memory_order_acquire);
        now = next_.load(std::memory_order_acquire);
      }
      return now == number;
    }

    // Passes the turn to the next number. \pre it is the caller's turn; the same for end()
    void pass() {
      next_.fetch_add(1, std::memory_order_release);
      next_.notify_all();
    }
    void end() {
      next_.store(over, std::memory_order_release);
      next_.notify_all();
    }

   private:
    static constexpr std::uint64_t over = std::numeric_limits<std::uint64_t>::max();
    // The previous thread usually passes its turn soon; sleeping would take longer.
    static constexpr int most_yields = 100;

    std::atomic<std::uint64_t> next_{0};
  };

  // One thread: each piece stays in its caches from the file to the decoder.
  void work(Piece& piece, std::size_t others) {
    std::uint64_t number = 0;
    try {
      while (fetch(piece, number)) {
        piece.expand(flow_.lines_, others);
        if (!turns_.wait(number)) return;
        if (!flow_.settle(piece) || (go_on_ && !go_on_())) return turns_.end();
        turns_.pass();
      }
    } catch (...) {
      // The pieces before are decoded first.
      if (!turns_.wait(number)) return;
      failure_ = std::current_exception();
      turns_.end();
    }
  }

  // The next piece and its number; false if there is none.
  bool fetch(Piece& piece, std::uint64_t& number) {
    const std::lock_guard lock(fetching_);
    if (fetched_all_) return false;
    number = fetched_++;
    fetched_all_ = true;  // also after an exception
    fetched_all_ = !piece.fetch(flow_.source_);
    return !fetched_all_;
  }

  CycleFlow& flow_;
  const std::function<bool()>& go_on_;

  std::mutex fetching_;
  std::uint64_t fetched_ = 0;
  bool fetched_all_ = false;

  // The turns for settle().
  Turns turns_;
  std::exception_ptr failure_;
};

void CycleFlow::run(unsigned threads, const std::function<bool()>& go_on) {
  if (threads == 0) threads = std::max(1U, std::thread::hardware_concurrency());
  Workers(*this, go_on).run(threads);
}

}  // namespace biss::flow
