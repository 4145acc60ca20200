// A recorded master with our encoder, and a recorded encoder with our master.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <string_view>
#include <vector>

#include "biss/frame/decode.hpp"
#include "biss/frame/format_text.hpp"
#include "sim/ma_replay.hpp"
#include "sim/slo_replay.hpp"

namespace biss::sim {
namespace replay_test {

using testing::ElementsAre;
using wire::Edge;
using wire::Level;

constexpr wire::LineIndex recorded_ma = 4;
constexpr wire::LineIndex recorded_slo = 2;
constexpr Picoseconds period = microseconds(1);

// `clocks` periods of MA from `begin` on, as in a capture.
void add_request(std::vector<Edge>& edges, Picoseconds begin, int clocks) {
  for (int i = 0; i < clocks; ++i) {
    edges.push_back({begin + i * period, recorded_ma, Level::low});
    edges.push_back({begin + i * period + period / 2, recorded_ma, Level::high});
  }
}

std::vector<Edge> idle() { return {{{}, recorded_ma, Level::high}, {{}, 0, Level::low}}; }

// The position of each request is its number.
class Answers {
 public:
  explicit Answers(std::string_view format, SlaveTiming timing = {}, Picoseconds line_delay = {})
      : format_(*parse_format(format)),
        replay_(
            {FrameCodec<>(format_), timing, line_delay}, [this](Picoseconds) { return sample(); },
            [this](const Answer& answer) { answers.push_back(answer); }) {}

  void run(const std::vector<Edge>& edges, Picoseconds end_time) {
    // In two blocks, as a reader may deliver them.
    const std::span<const Edge> all(edges);
    replay_.push(all.first(all.size() / 2), recorded_ma, made);
    replay_.push(all.subspan(all.size() / 2), recorded_ma, made);
    end = replay_.finish(end_time, made);
  }

  // SLO as a master that compensates the line delay samples it.
  Result<Frame, FrameFault> frame(Picoseconds begin, int clocks, Picoseconds line_delay) const {
    BitBuffer<2000> bits;
    for (int i = 0; i < clocks; ++i) {
      const Picoseconds at = begin + i * period + period + line_delay;
      Level level = Level::unknown;
      for (const Edge& edge : made) {
        if (edge.line == slo_line && edge.time <= at) level = edge.level;
      }
      bits.append(level == Level::high);
    }
    return decode_frame(bits.view(), FrameCodec<>(format_));
  }

  std::vector<Answer> answers;
  std::vector<Edge> made;
  Picoseconds end{};

 private:
  Frame sample() {
    Frame frame;
    frame.channel_count = format_.channel_count;
    for (Channel& channel : frame.channel_list) channel.position = number_;
    ++number_;
    return frame;
  }

  FrameFormat format_;
  MaReplay replay_;
  std::uint64_t number_ = 1;
};

std::vector<AnswerKind> kinds(const std::vector<Answer>& answers) {
  std::vector<AnswerKind> result;
  for (const Answer& answer : answers) result.push_back(answer.kind);
  return result;
}

TEST(MaReplay, EveryCompleteRequest_IsAnsweredWithAFrame) {
  const Picoseconds delay = nanoseconds(2'300);
  Answers answers("pos12,nE,nW,crc6", {}, delay);
  std::vector<Edge> edges = idle();
  for (int i = 0; i < 5; ++i) add_request(edges, (100 * i + 7) * period, 25);
  answers.run(edges, microseconds(600));
  ASSERT_EQ(answers.answers.size(), 5U);
  for (int i = 0; i < 5; ++i) {
    const Answer& answer = answers.answers[static_cast<std::size_t>(i)];
    EXPECT_EQ(answer.time, (100 * i + 7) * period);
    EXPECT_EQ(answer.kind, AnswerKind::complete);
    EXPECT_EQ(answer.sent.channel_list[0].position, static_cast<std::uint64_t>(i) + 1);
    const auto frame = answers.frame(answer.time, 25, delay);
    ASSERT_TRUE(frame.ok()) << name_of(frame.error().cause);
    EXPECT_EQ(frame->channel_list[0].position, static_cast<std::uint64_t>(i) + 1);
  }
}

TEST(MaReplay, Edges_AreTheRecordedMaAndOurSloInTimeOrder) {
  Answers answers("pos12,nE,nW,crc6", {}, nanoseconds(700));
  std::vector<Edge> edges = idle();
  add_request(edges, microseconds(3), 25);
  add_request(edges, microseconds(90), 25);
  answers.run(edges, microseconds(95));
  std::vector<Edge> ma;
  for (Edge edge : answers.made) {
    if (edge.line != ma_line) continue;
    edge.line = recorded_ma;
    ma.push_back(edge);
  }
  edges.erase(edges.begin() + 1);  // another line's
  EXPECT_EQ(ma, edges);
  EXPECT_TRUE(std::is_sorted(answers.made.begin(), answers.made.end(),
                             [](const Edge& a, const Edge& b) { return a.time < b.time; }));
  EXPECT_EQ(answers.made[1], (Edge{{}, slo_line, Level::high}));
  // The answer goes on to its timeout: 40 µs after the last edge.
  EXPECT_EQ(answers.end, microseconds(90 + 24 + 40) + period / 2 + nanoseconds(700));
  EXPECT_EQ(answers.made.back(), (Edge{answers.end, slo_line, Level::high}));
}

TEST(MaReplay, RequestsThatCannotBeAnswered_HaveTheirCause) {
  Answers answers("pos12,nE,nW,crc6");
  std::vector<Edge> edges = idle();
  add_request(edges, microseconds(10), 25);
  add_request(edges, microseconds(50), 25);   // within the timeout of 40 µs
  add_request(edges, microseconds(90), 25);   // and again
  add_request(edges, microseconds(200), 12);  // stops within the data
  add_request(edges, microseconds(300), 1);   // a pulse
  add_request(edges, microseconds(400), 25);
  answers.run(edges, microseconds(500));
  EXPECT_THAT(kinds(answers.answers),
              ElementsAre(AnswerKind::complete, AnswerKind::not_ready, AnswerKind::not_ready,
                          AnswerKind::cut, AnswerKind::cut, AnswerKind::complete));
  EXPECT_EQ(answers.answers[1].time, microseconds(50));
  EXPECT_EQ(answers.answers[2].time, microseconds(90));
  EXPECT_EQ(answers.answers[2].sent.channel_count, 0);
  EXPECT_EQ(answers.answers[3].time, microseconds(200));
  EXPECT_TRUE(answers.frame(microseconds(400), 25, {}).ok());
}

TEST(MaReplay, EndWhileSloIsOnItsWay_IsNotBeforeItsLastEdge) {
  SlaveTiming timing;
  timing.timeout = {TimeoutRule::fixed, nanoseconds(12'500)};
  const Picoseconds delay = microseconds(39);
  Answers answers("pos12,nE,nW,crc6", timing, delay);
  std::vector<Edge> edges = idle();
  add_request(edges, microseconds(3), 25);
  // The encoder is idle by then, and SLO shows it.
  const Picoseconds idle_at = microseconds(3 + 24) + period / 2 + nanoseconds(12'500);
  edges.push_back({idle_at, recorded_ma, Level::unknown});
  answers.run(edges, idle_at);
  EXPECT_EQ(answers.made.back(), (Edge{idle_at + delay, slo_line, Level::high}));
  EXPECT_EQ(answers.end, idle_at + delay);
}

TEST(MaReplay, UnknownLevels_AreRecordedAndNotAnswered) {
  Answers answers("pos12,nE,nW,crc6");
  std::vector<Edge> edges = idle();
  edges.push_back({microseconds(1), recorded_ma, Level::unknown});
  edges.push_back({microseconds(2), recorded_ma, Level::high});
  add_request(edges, microseconds(10), 25);
  answers.run(edges, microseconds(100));
  EXPECT_THAT(kinds(answers.answers), ElementsAre(AnswerKind::complete));
  EXPECT_EQ(answers.made[2], (Edge{microseconds(1), ma_line, Level::unknown}));
}

// A recorded pair: a request of ours, answered by our encoder, as another capture would have it.
std::vector<Edge> recorded_pair(std::string_view format, int requests, int clocks,
                                Picoseconds line_delay) {
  SlaveTiming timing;
  timing.timeout = {TimeoutRule::fixed, microseconds(20)};
  Answers answers(format, timing, line_delay);
  std::vector<Edge> edges = idle();
  for (int i = 0; i < requests; ++i) add_request(edges, (100 * i + 5) * period, clocks);
  answers.run(edges, microseconds(100 * requests + 100));
  for (Edge& edge : answers.made) edge.line = edge.line == ma_line ? recorded_ma : recorded_slo;
  return answers.made;
}

class Readings {
 public:
  explicit Readings(std::string_view format, Picoseconds own_period = {})
      : replay_({FrameCodec<>(*parse_format(format)), {.period = own_period}},
                [this](const ReplayReading& reading) { readings.push_back(reading); }) {}

  void run(const std::vector<Edge>& edges, Picoseconds end) {
    const std::span<const Edge> all(edges);
    replay_.push(all.first(all.size() / 3), recorded_ma, recorded_slo, made);
    replay_.push(all.subspan(all.size() / 3), recorded_ma, recorded_slo, made);
    replay_.finish(end, made);
  }

  std::vector<ReplayReading> readings;
  std::vector<Edge> made;

 private:
  SloReplay replay_;
};

TEST(SloReplay, RecordedAnswers_AreRead) {
  const char* format = "pos12,nE,nW,crc6";
  for (const Picoseconds delay : {nanoseconds(0), nanoseconds(480), nanoseconds(2'300)}) {
    Readings readings(format);
    readings.run(recorded_pair(format, 6, 25, delay), microseconds(800));
    ASSERT_EQ(readings.readings.size(), 6U);
    for (std::size_t i = 0; i < 6; ++i) {
      const auto& reading = readings.readings[i].reading;
      ASSERT_TRUE(reading.frame.ok()) << name_of(reading.frame.error().cause);
      EXPECT_EQ(reading.frame->channel_list[0].position, i + 1);
      EXPECT_EQ(reading.line_delay, delay);
      EXPECT_EQ(reading.begin, static_cast<std::int64_t>(100 * i + 5) * period);
      EXPECT_EQ(readings.readings[i].period, period);
      EXPECT_TRUE(reading.ready);
    }
    EXPECT_TRUE(std::is_sorted(readings.made.begin(), readings.made.end(),
                               [](const Edge& a, const Edge& b) { return a.time < b.time; }));
  }
}

TEST(SloReplay, OurOwnClock_ReadsNothingWhereItIsAnother) {
  const char* format = "pos12,nE,nW,crc6";
  Readings readings(format, nanoseconds(900));
  readings.run(recorded_pair(format, 3, 25, nanoseconds(480)), microseconds(800));
  ASSERT_EQ(readings.readings.size(), 3U);
  for (const ReplayReading& reading : readings.readings) {
    EXPECT_FALSE(reading.reading.frame.ok());
    EXPECT_EQ(reading.period, nanoseconds(900));
  }
}

TEST(SloReplay, NearlyOurClock_ReadsAll) {
  const char* format = "pos12,nE,nW,crc6";
  Readings readings(format, nanoseconds(1'010));
  readings.run(recorded_pair(format, 3, 25, nanoseconds(480)), microseconds(800));
  ASSERT_EQ(readings.readings.size(), 3U);
  for (const ReplayReading& reading : readings.readings) EXPECT_TRUE(reading.reading.frame.ok());
}

TEST(SloReplay, CaptureThatEndsInARequest_IsTruncated) {
  const char* format = "pos12,nE,nW,crc6";
  std::vector<Edge> edges = recorded_pair(format, 2, 25, nanoseconds(480));
  std::erase_if(edges, [](const Edge& edge) { return edge.time > microseconds(115); });
  Readings readings(format);
  readings.run(edges, microseconds(115));
  ASSERT_EQ(readings.readings.size(), 2U);
  EXPECT_TRUE(readings.readings[0].reading.frame.ok());
  ASSERT_FALSE(readings.readings[1].reading.frame.ok());
  EXPECT_EQ(readings.readings[1].reading.frame.error().cause, FrameError::truncated);
}

TEST(SloReplay, RequestsWhileOursRuns_AreToldBehindIt) {
  // Our clock is slow: it still runs when the recorded encoder is requested again.
  const char* format = "pos12,nE,nW,crc6";
  std::vector<Edge> edges = recorded_pair(format, 1, 25, nanoseconds(480));
  add_request(edges, microseconds(60), 4);
  add_request(edges, microseconds(80), 4);
  Readings readings(format, microseconds(12));
  readings.run(edges, microseconds(2'000));
  ASSERT_EQ(readings.readings.size(), 3U);
  const std::array begins{microseconds(5), microseconds(60), microseconds(80)};
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(readings.readings[i].reading.begin, begins[i]);
  EXPECT_EQ(readings.readings[0].reading.refusal, Refusal::none);
  EXPECT_EQ(readings.readings[2].reading.refusal, Refusal::slo_low);
}

TEST(SloReplay, NoiseFasterThanAnyClock_IsNoRequest) {
  std::vector<Edge> edges = idle();
  edges.push_back({{}, recorded_slo, Level::high});
  for (int i = 0; i < 8; ++i) {
    const Level level = i % 2 == 0 ? Level::low : Level::high;
    edges.push_back({microseconds(5) + i * nanoseconds(4), recorded_ma, level});
  }
  Readings readings("pos12,nE,nW,crc6");
  readings.run(edges, microseconds(200));
  EXPECT_TRUE(readings.readings.empty());
  EXPECT_EQ(readings.made.size(), 2U);
}

TEST(SloReplay, BusyRecordedEncoder_IsNotReady) {
  std::vector<Edge> edges = idle();
  edges.push_back({{}, recorded_slo, Level::low});
  add_request(edges, microseconds(5), 25);
  add_request(edges, microseconds(100), 1);  // a pulse is not a request
  Readings readings("pos12,nE,nW,crc6");
  readings.run(edges, microseconds(200));
  ASSERT_EQ(readings.readings.size(), 1U);
  EXPECT_EQ(readings.readings[0].reading.refusal, Refusal::slo_low);
  EXPECT_EQ(readings.readings[0].period, Picoseconds{});
}

}  // namespace replay_test
}  // namespace biss::sim
