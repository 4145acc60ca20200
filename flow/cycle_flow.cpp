// The threads that read a capture in pieces: each fetches a piece (one thread at a time), expands it
// (all at once) and settles it (in the order of the pieces).
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
      // The destructor of `others` waits for the threads.
    }
    if (failure_) std::rethrow_exception(failure_);
  }

 private:
  // Threads take turns in the order of the numbers that they wait for, from 0 on. Each number has
  // one thread.
  class Turns {
   public:
    // Waits for the turn of this number. False after end(): this turn never comes.
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

    // Passes the turn to the next number. \pre it is the turn of this thread; the same for end()
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

    // The number whose turn it is, or `over`.
    std::atomic<std::uint64_t> next_{0};
  };

  // One of the threads: each piece stays in its caches from the file to the decoder.
  void work(Piece& piece, std::size_t others) {
    std::uint64_t number = 0;
    try {
      while (fetch(piece, number)) {
        piece.expand(flow_.lines_, others);
        if (!turns_.wait(number)) return;
        if (!flow_.settle(piece) || (go_on_ && !go_on_())) {
          turns_.end();
          return;
        }
        turns_.pass();
      }
    } catch (...) {
      // The previous pieces are decoded first.
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
    fetched_all_ = true;  // stays if fetch() throws: the source cannot be read further
    fetched_all_ = !piece.fetch(flow_.source_);
    return !fetched_all_;
  }

  CycleFlow& flow_;
  const std::function<bool()>& go_on_;

  // For fetch(): it guards the two members after it and the reading from the source.
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
