#include <fmt/format.h>
#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <new>
#include <optional>

#include "capture/pair_source.hpp"
#include "decode/clean_cycles.hpp"
#include "decode/decoder.hpp"
#include "flow/cycle_flow.hpp"
#include "tests/common/long_run.hpp"
#include "tests/flow/flow_trial.hpp"

namespace biss::flow_trial::flow_test {

void expect_same(const std::vector<std::string>& rows, const std::vector<std::string>& expected) {
  ASSERT_EQ(rows.size(), expected.size());
  for (std::size_t i = 0; i < rows.size(); ++i) ASSERT_EQ(rows[i], expected[i]) << "row " << i;
}

// Threads and sizes are drawn: all combinations of all captures are too many.
void compare(const Trial& trial, const Container& container, std::uint64_t number) {
  SCOPED_TRACE(fmt::format("trial {}, {}", number, container.name));
  const auto expected = by_edges(trial, container);
  ASSERT_FALSE(expected.empty());
  constexpr std::array<unsigned, 4> threads{1, 2, 3, 7};
  constexpr std::array<std::size_t, 6> sizes{64, 1'000, 4'096, 65'536, 1U << 20U, 64U << 20U};
  for (std::size_t i = 0; i < 2; ++i) {
    const std::size_t draw = number * 2 + i;
    const unsigned count = threads[draw % threads.size()];
    const std::size_t size = sizes[draw % sizes.size()];
    SCOPED_TRACE(fmt::format("{} threads, pieces of {} bytes", count, size));
    expect_same(by_flow(trial, container, count, size), expected);
  }
}

TEST(Flow, EveryFaultInEveryContainer_SameCyclesAsEdgeByEdge) {
  const std::uint64_t trials = test::rounds(500, 20);
  for (std::uint64_t number = 0; number < trials; ++number) {
    const Trial trial(number);
    for (const Container& container : change_containers(trial)) {
      compare(trial, container, number);
      if (HasFatalFailure()) return;
    }
    std::vector<std::string> first;
    for (const Container& container : sampled_containers(trial)) {
      compare(trial, container, number);
      if (HasFatalFailure()) return;
      // Sampled alike, they show the same.
      const auto rows = by_flow(trial, container, 2, 4'096);
      if (first.empty()) first = rows;
      expect_same(rows, first);
      if (HasFatalFailure()) return;
    }
  }
}

// A capture of pieces without changes, of which one fails.
enum class Place { fetch, expand, settle, none };
constexpr std::size_t piece_count = 60;
constexpr std::size_t failing = 41;

class QuietPiece final : public capture::PairPiece {
 public:
  explicit QuietPiece(bool fails) : fails_(fails) {}
  void expand() override {
    if (fails_) throw std::bad_alloc();
  }

 private:
  bool fails_;
};

class QuietSource final : public capture::PairSource {
 public:
  explicit QuietSource(Place place) : place_(place) {}

  std::unique_ptr<capture::PairPiece> fetch(std::unique_ptr<capture::PairPiece>) override {
    if (fetched_ == piece_count) return nullptr;
    const bool fails = fetched_++ == failing;
    if (fails && place_ == Place::fetch) throw std::bad_alloc();
    return std::make_unique<QuietPiece>(fails && place_ == Place::expand);
  }
  bool settle(capture::PairPiece&, const OnEdges&) override {
    if (settled_ == failing && place_ == Place::settle) throw std::bad_alloc();
    ++settled_;
    return true;
  }
  Picoseconds end_time() const override { return {}; }
  const std::optional<capture::CaptureError>& error() const override { return error_; }
  std::size_t settled() const { return settled_; }

 private:
  Place place_;
  std::size_t fetched_ = 0;
  std::size_t settled_ = 0;
  std::optional<capture::CaptureError> error_;
};

void decode(QuietSource& source, unsigned threads, const std::function<bool()>& go_on = {}) {
  decode::Decoder decoder(decode::CycleReader(std::nullopt, {}, {}), [](const decode::Cycle&) {});
  flow::CycleFlow(source, decode::CleanCycleFinder(std::nullopt, {}, {}), {0, 1}, decoder)
      .run(threads, go_on);
}

TEST(Flow, ExceptionInAnyThread_ComesAfterThePiecesBefore) {
  for (const Place place : {Place::fetch, Place::expand, Place::settle}) {
    for (const unsigned threads : {1U, 2U, 3U, 7U}) {
      QuietSource source(place);
      EXPECT_THROW(decode(source, threads), std::bad_alloc);
      EXPECT_EQ(source.settled(), failing);
    }
  }
}

TEST(Flow, CallerThatHasEnough_NoFurtherPieceIsDecoded) {
  for (const unsigned threads : {1U, 2U, 3U, 7U}) {
    QuietSource source(Place::none);
    decode(source, threads, [&] { return source.settled() != 5; });
    EXPECT_EQ(source.settled(), 5U);
    QuietSource whole(Place::none);
    decode(whole, threads);
    EXPECT_EQ(whole.settled(), piece_count);
  }
}

}  // namespace biss::flow_trial::flow_test
