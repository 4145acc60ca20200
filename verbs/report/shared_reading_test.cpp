// Guests of a reading: each gets the cycles that it would read alone.
#include "verbs/report/shared_reading.hpp"

#include <gtest/gtest.h>

#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "capture/test_folder.hpp"

namespace biss::verbs {
namespace shared_reading_test {

using Seen = std::vector<std::pair<Picoseconds, CycleStatus>>;

// A capture with damaged frames, some of them of other lengths.
std::string simulated(const test::Folder& folder) {
  const std::string path = folder.path("line.vcd");
  MemoryHost host;
  Command command(host);
  add_verbs(command, "simulate");
  const ExitStatus status = command.run({"simulate"}, {{"--format", {"pos12,nE,nW,crc6"}},
                                                       {"--cycles", {"300"}},
                                                       {"--fault", {"flip:0.1", "lost_clock:0.1"}},
                                                       {"--output", {path}}});
  EXPECT_EQ(status, ExitStatus::done) << host.text();
  return path;
}

class Guests : public testing::Test {
 protected:
  Guests() {
    usual_.files = {simulated(folder_)};
    usual_.device.format = "pos12,nE,nW,crc6";
  }

  // All cycles that the capture reads; in a joint reading, if the host has one.
  static Seen read(const CaptureArguments& arguments, Host& host) {
    DecodedCapture capture(host);
    Seen seen;
    EXPECT_EQ(capture.open(arguments), ExitStatus::done);
    EXPECT_TRUE(capture.next());
    EXPECT_TRUE(capture.read([&](std::uint64_t, const decode::Cycle& cycle) {
      seen.emplace_back(cycle.time, cycle.status);
      return true;
    }));
    return seen;
  }

  // Whether a capture that is opened in this way reads the cycles of one opened in the other way.
  static bool reads_as(const CaptureArguments& arguments, const CaptureArguments& others) {
    MemoryHost host;
    DecodedCapture own(host);
    DecodedCapture other(host);
    EXPECT_EQ(own.open(arguments), ExitStatus::done);
    EXPECT_EQ(other.open(others), ExitStatus::done);
    EXPECT_TRUE(own.next() && other.next()) << host.text();
    return own.reads_as(other);
  }

  // The usual arguments after a change.
  template <class Change>
  CaptureArguments with(const Change& change) const {
    CaptureArguments arguments = usual_;
    change(arguments);
    return arguments;
  }

  const test::Folder folder_;
  CaptureArguments usual_;
};

TEST_F(Guests, SameArguments_ReadTheSameCycles) {
  EXPECT_TRUE(reads_as(usual_, usual_));
  EXPECT_TRUE(reads_as(with([](auto& own) { own.since = milliseconds(1); }), usual_));
}

TEST_F(Guests, OtherLinesFormatTimingOrJudgement_ReadOtherCycles) {
  EXPECT_FALSE(reads_as(with([](auto& own) {
                          own.ma = "SLO";
                          own.slo = "MA";
                        }),
                        usual_));
  EXPECT_FALSE(reads_as(with([](auto& own) { own.invert_slo = true; }), usual_));
  EXPECT_FALSE(
      reads_as(with([](auto& own) { own.device.format = "pos12,nE,nW,crc6:plain"; }), usual_));
  EXPECT_FALSE(reads_as(with([](auto& own) { own.device.timeout = "static:17us"; }), usual_));
  EXPECT_FALSE(reads_as(with([](auto& own) { own.no_compensation = true; }), usual_));
  EXPECT_FALSE(reads_as(with([](auto& own) { own.resolution = nanoseconds(40); }), usual_));
}

TEST_F(Guests, SignalThatIsNotAskedFor_IsIgnored) {
  const CaptureArguments measured = with([](auto& own) { own.signal = true; });
  EXPECT_FALSE(reads_as(measured, usual_));
  EXPECT_TRUE(reads_as(usual_, measured));
}

TEST_F(Guests, EachGuest_GetsTheCyclesOfItsOwnReading) {
  struct NoWatcher final : flow::ChangeWatcher {
    void take(std::span<const wire::Edge> /*edges*/) override {}
    void take(const capture::PairPiece& /*changes*/) override {}
  };
  const std::vector<CaptureArguments> guests{
      usual_, with([](auto& own) { own.device.format = "pos12,nE,nW,crc6:plain"; }),
      with([](auto& own) { own.device.format = "none"; })};
  MemoryHost alone;
  std::vector<Seen> expected;
  for (const CaptureArguments& guest : guests) expected.push_back(read(guest, alone));
  ASSERT_GE(expected[0].size(), 200U);
  ASSERT_NE(expected[1], expected[0]);
  ASSERT_NE(expected[2], expected[0]);

  MemoryHost host;
  DecodedCapture capture(host);
  ASSERT_EQ(capture.open(usual_), ExitStatus::done);
  ASSERT_TRUE(capture.next());
  NoWatcher watcher;
  SharedReading reading(capture, watcher, guests.size());
  std::vector<Seen> seen(guests.size());
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < guests.size(); ++i) {
    threads.emplace_back([&, i] {
      SharedReading::Guest guest(reading);
      MemoryHost own(nullptr, &guest);
      seen[i] = read(guests[i], own);
    });
  }
  reading.wait();
  const auto take = [&](std::uint64_t, const decode::Cycle& cycle) {
    reading.take(cycle);
    return true;
  };
  EXPECT_TRUE(capture.read(take, &reading));
  reading.end();
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(seen, expected);
}

}  // namespace shared_reading_test
}  // namespace biss::verbs
