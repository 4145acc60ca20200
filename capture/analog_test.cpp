#include "capture/analog.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <random>
#include <utility>
#include <vector>

#include "capture/test_capture.hpp"
#include "tests/common/long_run.hpp"

namespace biss::capture {
namespace analog_test {

using testing::ElementsAre;
using testing::IsEmpty;

constexpr Threshold at_one_volt{millivolts(1'000), millivolts(200)};

// Rows from memory, at most `block` at a time; one row a microsecond where no times are given.
class Rows final : public AnalogSamples {
 public:
  Rows(std::vector<AnalogChannel> channels, std::vector<std::vector<Nanovolts>> rows,
       std::vector<Picoseconds> times = {}, std::size_t block = 1'000)
      : channels_(std::move(channels)),
        rows_(std::move(rows)),
        times_(std::move(times)),
        block_(block) {}

  const std::vector<AnalogChannel>& channels() const override { return channels_; }
  std::optional<CaptureError> next(SampleRows& rows) override {
    for (; next_ < rows_.size() && rows.times.size() < block_; ++next_) {
      rows.times.push_back(times_.empty() ? microseconds(static_cast<std::int64_t>(next_))
                                          : times_[next_]);
      rows.values.insert(rows.values.end(), rows_[next_].begin(), rows_[next_].end());
    }
    return std::nullopt;
  }

 private:
  std::vector<AnalogChannel> channels_;
  std::vector<std::vector<Nanovolts>> rows_;
  std::vector<Picoseconds> times_;
  std::size_t block_;
  std::size_t next_ = 0;
};

std::vector<std::vector<Nanovolts>> column(const std::vector<int>& mv) {
  std::vector<std::vector<Nanovolts>> rows;
  for (const int value : mv) rows.push_back({millivolts(value)});
  return rows;
}

Read read_rows(std::vector<AnalogChannel> channels, std::vector<std::vector<Nanovolts>> rows,
               const AnalogOptions& options, std::size_t block = 1'000) {
  return read_all(open_analog(std::make_unique<Rows>(std::move(channels), std::move(rows),
                                                     std::vector<Picoseconds>(), block),
                              options));
}

// `periods` of a square wave of that many samples a half, with noise.
std::vector<Nanovolts> square(std::size_t periods, std::size_t half, int low, int high, int noise,
                              unsigned seed = 1) {
  std::mt19937 random(seed);
  std::vector<Nanovolts> samples;
  for (std::size_t i = 0; i < 2 * half * periods; ++i) {
    const int level = i / half % 2 == 0 ? high : low;
    samples.push_back(millivolts(
        level + static_cast<int>(random() % (2U * static_cast<unsigned>(noise) + 1)) - noise));
  }
  return samples;
}

TEST(Threshold, SamplesInsideTheHysteresis_KeepTheLevel) {
  const Read read =
      read_rows({{.name = "MA"}}, column({0, 950, 1'090, 1'100, 1'000, 910, 900, 899}),
                {.threshold = at_one_volt});
  EXPECT_FALSE(read.error);
  EXPECT_THAT(read.lines, ElementsAre("MA"));
  // 1.1 V is reached at the sample of 3 us, 0.9 V is passed just after that of 6 us.
  EXPECT_THAT(read.edges,
              ElementsAre(edge(0, 0, '0'), edge(3'000'000, 0, '1'), edge(6'000'000, 0, '0')));
  EXPECT_EQ(read.end_time, microseconds(7));
}

TEST(Threshold, CrossingBetweenSamples_IsInterpolated) {
  const Read read =
      read_rows({{.name = "MA"}}, column({100, 2'100, 100}), {.threshold = at_one_volt});
  EXPECT_THAT(read.edges,
              ElementsAre(edge(0, 0, '0'), edge(500'000, 0, '1'), edge(1'600'000, 0, '0')));
}

TEST(Threshold, MissingAndBadSamples_AreNotInterpolated) {
  std::vector<std::vector<Nanovolts>> rows = column({0, 0, 2'000, 0, 2'000, 0});
  rows[1] = {no_sample};
  rows[3] = {bad_sample};
  rows[5] = {Nanovolts{-over_range.count}};
  const Read read = read_rows({{.name = "MA"}}, rows, {.threshold = at_one_volt});
  EXPECT_THAT(read.edges,
              ElementsAre(edge(0, 0, '0'), edge(2'000'000, 0, '1'), edge(3'000'000, 0, 'x'),
                          edge(4'000'000, 0, '1'), edge(5'000'000, 0, '0')));
}

TEST(Threshold, EdgesOfOneRow_ComeInTimeOrder) {
  const auto v = [](int a, int b) { return std::vector<Nanovolts>{millivolts(a), millivolts(b)}; };
  const Read read = read_rows({{.name = "MA"}, {.name = "SLO"}}, {v(100, 100), v(1'200, 2'100)},
                              {.threshold = at_one_volt});
  EXPECT_THAT(read.edges, ElementsAre(edge(0, 0, '0'), edge(0, 1, '0'), edge(500'000, 1, '1'),
                                      edge(909'091, 0, '1')));
}

TEST(Threshold, LogicChannels_HaveTheTimeOfTheirSample) {
  const auto v = [](int a) { return std::vector<Nanovolts>{millivolts(a)}; };
  const Read read = read_rows({{.name = "D0", .logic = true}}, {v(0), v(1'000), v(0)}, {});
  EXPECT_THAT(read.edges,
              ElementsAre(edge(0, 0, '0'), edge(1'000'000, 0, '1'), edge(2'000'000, 0, '0')));
}

TEST(Levels, SquareWavesWithNoise_AreFound) {
  for (const auto& [low, high] : {std::pair{0, 3'300}, {-2'000, 2'000}, {4'600, 5'000}}) {
    for (const std::size_t half : {2U, 10U, 500U}) {
      const auto levels = estimate_levels(square(40, half, low, high, 30));
      ASSERT_TRUE(levels) << low << ' ' << half;
      EXPECT_NEAR(static_cast<double>(levels->low.count), low * 1e6, 15e6);
      EXPECT_NEAR(static_cast<double>(levels->high.count), high * 1e6, 15e6);
    }
  }
}

TEST(Levels, RareSecondLevel_IsFound) {
  // 60 samples of 2^20, beside noise.
  std::vector<Nanovolts> samples(1U << 20U, millivolts(3'300));
  for (std::size_t i = 0; i < samples.size(); ++i) {
    samples[i].count += static_cast<std::int64_t>(i % 7) * 5'000'000;
  }
  for (std::size_t i = 900'000; i < 900'060; ++i) samples[i] = millivolts(10);
  const auto levels = estimate_levels(samples);
  ASSERT_TRUE(levels);
  EXPECT_EQ(levels->low.count / 1'000'000, 10);
  EXPECT_NEAR(static_cast<double>(levels->high.count), 3.315e9, 0.02e9);
}

TEST(Levels, NoiseConstantsAndSingleGlitches_HaveNone) {
  std::mt19937 random(5);
  std::normal_distribution<double> noise(1e9, 0.4e9);
  std::vector<Nanovolts> samples(5'000);
  for (Nanovolts& sample : samples) sample = Nanovolts{static_cast<std::int64_t>(noise(random))};
  EXPECT_FALSE(estimate_levels(samples));
  EXPECT_FALSE(estimate_levels(std::vector<Nanovolts>(5'000, millivolts(3'300))));
  EXPECT_FALSE(estimate_levels({}));
  // The last bit of a converter.
  for (std::size_t i = 0; i < samples.size(); ++i) {
    samples[i] = millivolts(3'300 + 40 * static_cast<std::int64_t>(i % 2));
  }
  EXPECT_FALSE(estimate_levels(samples));
  for (std::size_t i = 100; i < 107; ++i) samples[i] = millivolts(0);
  EXPECT_FALSE(estimate_levels(samples));
  samples[107] = millivolts(0);
  EXPECT_TRUE(estimate_levels(samples));
}

TEST(AutomaticThreshold, IsTheMiddleOfTheLevels) {
  std::vector<std::vector<Nanovolts>> rows;
  for (const Nanovolts sample : square(20, 4, 1'000, 2'000, 0)) rows.push_back({sample});
  // The hysteresis is a fifth of 1 V: 1.62 V and 1.39 V change the level, 1.58 V does not.
  for (const int mv : {1'000, 1'000, 1'580, 1'620, 1'420, 1'390}) rows.push_back({millivolts(mv)});
  const Read read = read_rows({{.name = "MA"}}, rows, {});
  ASSERT_GE(read.edges.size(), 2U);
  const auto& rise = read.edges[read.edges.size() - 2];
  EXPECT_EQ(rise.time.count / 1'000'000, 162);
  EXPECT_EQ(read.edges.back().time.count / 1'000'000, 164);
  EXPECT_EQ(read.edges.back().level, wire::Level::low);
}

TEST(AutomaticThreshold, IdleBeginningOfAnyLength_IsSkipped) {
  if (!test::long_run()) GTEST_SKIP() << "make test-long runs it";
  std::vector<std::vector<Nanovolts>> rows(2'500'000, {millivolts(3'300)});
  for (std::size_t i = 0; i < rows.size(); i += 3) rows[i][0].count += 40'000'000;
  for (const Nanovolts sample : square(20, 4, 0, 3'300, 20)) rows.push_back({sample});
  const Read read = read_rows({{.name = "MA"}}, rows, {}, 60'000);
  EXPECT_FALSE(read.error);
  EXPECT_EQ(read.edges.size(), 40U);
  EXPECT_EQ(read.edges.at(0), edge(0, 0, '1'));
  EXPECT_EQ(read.edges.at(1).time.count / 1'000'000, 2'500'003);
}

TEST(AutomaticThreshold, BlockSize_DoesNotMatter) {
  std::vector<std::vector<Nanovolts>> rows;
  for (const Nanovolts sample : square(2'000, 3, 0, 3'300, 300)) {
    rows.push_back({sample, millivolts(3'400)});
  }
  const std::vector<AnalogChannel> channels{{.name = "MA"}, {.name = "SLO"}};
  const Read whole = read_rows(channels, rows, {}, 1'000'000);
  EXPECT_EQ(whole.edges.size(), 4'001U);
  for (const std::size_t block : {1U, 7U, 4'096U}) {
    EXPECT_EQ(read_rows(channels, rows, {}, block).edges, whole.edges) << block;
  }
}

TEST(AutomaticThreshold, LineThatNeverChanges_TakesTheThresholdOfTheOther) {
  const std::vector<Nanovolts> clock = square(20, 4, 0, 3'300, 20);
  for (const auto& [mv, level] : {std::pair{3'250, '1'}, {40, '0'}, {1'600, 'x'}}) {
    std::vector<std::vector<Nanovolts>> rows;
    for (const Nanovolts sample : clock) rows.push_back({sample, millivolts(mv)});
    const Read read = read_rows({{.name = "MA"}, {.name = "SLO"}}, rows, {});
    std::vector<wire::Edge> slo;
    for (const wire::Edge& e : read.edges) {
      if (e.line == 1) slo.push_back(e);
    }
    EXPECT_THAT(slo, ElementsAre(edge(0, 1, level))) << mv;
  }
}

TEST(AutomaticThreshold, NoLineChanges_IsRefused) {
  const Read read = read_rows({{.name = "MA"}}, column(std::vector<int>(10'000, 3'300)), {});
  EXPECT_EQ(read.cause(), CaptureCause::no_two_levels);
  EXPECT_THAT(read.edges, IsEmpty());
  EXPECT_EQ(read_rows({{.name = "MA"}}, {}, {}).cause(), CaptureCause::empty);
}

TEST(Differential, TwoChannels_AreOneLine) {
  std::vector<std::vector<Nanovolts>> rows;
  // 1.5 V of common noise, far more than the 0.8 V between the levels of each.
  std::size_t i = 0;
  for (const Nanovolts sample : square(20, 4, -400, 400, 10)) {
    const std::int64_t common = millivolts(1'500).count * static_cast<std::int64_t>(i++ % 3);
    rows.push_back(
        {Nanovolts{common + sample.count}, millivolts(0), Nanovolts{common - sample.count}});
  }
  const std::vector<AnalogChannel> channels{{.name = "MA+"}, {.name = "aux"}, {.name = "MA-"}};
  const Read read =
      read_rows(channels, rows, {.threshold = {}, .differentials = {{"MA+-MA-", "MA"}}});
  EXPECT_FALSE(read.error);
  EXPECT_THAT(read.lines, ElementsAre("aux", "MA"));
  std::size_t changes = 0;
  for (const wire::Edge& e : read.edges) changes += e.line == 1 ? 1 : 0;
  EXPECT_EQ(changes, 40U);
}

TEST(Differential, ChannelsThatAreNotThere_AreRefused) {
  const std::vector<AnalogChannel> channels{
      {.name = "A"}, {.name = "B"}, {.name = "D", .logic = true}};
  for (const char* pair : {"A-C", "A-D", "A-A", "AB", "-A", "A-"}) {
    const Read read =
        read_rows(channels, {{{}, {}, {}}}, {.threshold = {}, .differentials = {{pair, "x"}}});
    EXPECT_EQ(read.cause(), CaptureCause::no_such_channel) << pair;
  }
}

TEST(SamplePeriod, IsTheLongestTimeBetweenSamples) {
  auto source = open_analog(
      std::make_unique<Rows>(
          std::vector<AnalogChannel>{{.name = "MA"}}, column({0, 1, 2, 3}),
          std::vector<Picoseconds>{{}, Picoseconds{10}, Picoseconds{25}, Picoseconds{35}}),
      {.threshold = at_one_volt});
  ASSERT_TRUE(source);
  EXPECT_EQ((*source)->sample_period(), Picoseconds{15});
  EXPECT_TRUE((*source)->is_analog());
}

}  // namespace analog_test
}  // namespace biss::capture
