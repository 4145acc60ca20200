// Every encoder of the catalogue on an SPI peripheral: the slave of the core at the end of a cable,
// requested at the interval of the cycle budget, read by SpiReader.
#include <gtest/gtest.h>

#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

#include "biss/catalogue/catalogue.hpp"
#include "biss/frame/codec.hpp"
#include "biss/master/spi_read.hpp"
#include "biss/slave/slave.hpp"
#include "biss/timing/cable.hpp"
#include "biss/timing/cycle.hpp"
#include "tests/core/random.hpp"
#include "tests/spi/effort.hpp"
#include "tests/spi/line_model.hpp"

namespace biss::test::spi::total_test {

constexpr std::size_t requests = 4;

/// Random positions, stored for the comparison.
struct Encoder {
  const FrameFormat* format = nullptr;
  Random* random = nullptr;
  std::vector<Frame>* sent = nullptr;

  Frame sample(Picoseconds) const {
    Frame frame;
    frame.channel_count = format->channel_count;
    for (std::size_t k = 0; k < frame.channel_count; ++k) {
      frame.channel_list[k].position = random->bits(format->channel_list[k].position_bits());
    }
    sent->push_back(frame);
    return frame;
  }
  bool cds(bool predecessor) const { return predecessor; }
  void cdm(bool) const {}
};

struct Place {
  const CatalogueEntry* entry = nullptr;
  Hertz clock;
  Picoseconds cable{};  ///< there and back
  SpiPhase phase = SpiPhase::sample_on_rising;

  Picoseconds delay() const { return cable + entry->timing.internal_delay_max; }
  CycleBudget budget() const {
    return cycle_budget({entry->frame_format().payload_bits()}, entry->timing, clock, delay());
  }
  std::string text() const {
    return std::string(entry->name) + " at " + std::to_string(clock.count / 1000) + " kHz, " +
           std::to_string(cable.count / 10'000'000) + " m, " +
           (phase == SpiPhase::sample_on_rising ? "rising" : "falling");
  }
};

/// A level that changes, as the master sees it.
class Slo {
 public:
  void put(Picoseconds time, bool level) {
    if (changes_.empty() ? !level : changes_.back().level != level)
      changes_.push_back({time, level});
  }
  /// \pre not before the last call; a change at that very moment is not seen yet
  bool at(Picoseconds time) {
    while (next_ < changes_.size() && changes_[next_].time < time) level_ = changes_[next_++].level;
    return level_;
  }

 private:
  struct Change {
    Picoseconds time;
    bool level;
  };
  std::vector<Change> changes_;
  std::size_t next_ = 0;
  bool level_ = true;
};

/// The first error of a series of requests at the given interval; empty if every reading is right.
std::string judged(const Place& place, Picoseconds interval, Random& random) {
  const DeviceTiming& timing = place.entry->timing;
  const FrameFormat format = place.entry->frame_format();
  const FrameCodec<> codec(format);
  const CycleBudget budget = place.budget();
  const Picoseconds period = budget.period;
  std::vector<Frame> sent;
  Slave<FrameCodec<>, Encoder, 0> slave(codec, slave_timing(timing, timing.ack_max),
                                        Encoder{&format, &random, &sent});
  Slo slo;
  StepOutput out;
  const auto step = [&](Picoseconds time, bool ma) {
    out = slave.step(time, ma, false);
    slo.put(time + place.delay(), out.level);
  };
  const Picoseconds first = 10 * period;
  bool ma = true;
  const auto edge = [&](Picoseconds time) {
    while (out.deadline <= time) step(out.deadline, ma);
    ma = !ma;
    step(time, ma);
  };
  for (std::size_t request = 0; request < requests; ++request) {
    const Picoseconds begin = first + interval * static_cast<std::int64_t>(request);
    for (std::int64_t k = 0; k < budget.clocks_to_send; ++k) {
      edge(begin + k * period);
      edge(begin + k * period + period / 2);
    }
  }
  const bool falling = place.phase == SpiPhase::sample_on_falling;
  const SpiReader reader(codec,
                         {.period = period,
                          .phase = place.phase,
                          .line_delay = {{}, place.delay()},
                          .no_error_flag = true,
                          .unchecked = true},
                         timing);
  for (std::size_t request = 0; request < requests; ++request) {
    const Picoseconds begin = first + interval * static_cast<std::int64_t>(request);
    std::vector<std::uint8_t> samples;
    for (std::int64_t k = 0; k < budget.clocks_to_send; ++k) {
      const Picoseconds time = begin + k * period + (falling ? Picoseconds{} : period / 2);
      samples.push_back(slo.at(time) ? 1 : 0);
    }
    std::vector<std::uint8_t> bytes;
    pack(samples, 0, 0, bytes);
    const auto frame = reader.read(bytes, samples.size());
    const std::string number = "request " + std::to_string(request) + ": ";
    if (!frame.ok()) return number + std::string(name_of(frame.error().cause));
    if (request >= sent.size() || frame->channel_list != sent[request].channel_list) {
      return number + "another position";
    }
  }
  return {};
}

template <class Check>
std::size_t for_each_place(Check check) {
  std::size_t places = 0;
  for (const CatalogueEntry& entry : catalogue) {
    for (const Hertz clock :
         {kilohertz(250), megahertz(1), megahertz(2), megahertz(5), megahertz(10)}) {
      if (!accepts_clock(entry.timing, clock)) continue;
      for (const int length : {0, 10, 50, 100}) {
        if (metres(length) > cable_max_compensated(clock)) continue;
        for (const SpiPhase phase : {SpiPhase::sample_on_rising, SpiPhase::sample_on_falling}) {
          check(Place{&entry, clock, cable_delay(metres(length)), phase});
          ++places;
        }
      }
    }
  }
  return places;
}

/// With a fixed cycle time the request comes after exactly `total`; otherwise when SLO is read
/// high, a line delay later.
TEST(SpiTotal, EveryEncoderClockAndCable_IsReadAtOnce) {
  constexpr std::uint64_t seed = 0x70741;
  std::printf("seed 0x%llX\n", static_cast<unsigned long long>(seed));
  Random random(seed);
  const std::size_t places = for_each_place([&](const Place& place) {
    const bool by_time = place.entry->timing.timeout.rule == TimeoutRule::cycle;
    const Picoseconds total = place.budget().total;
    EXPECT_EQ(judged(place, by_time ? total : total + place.delay(), random), "") << place.text();
  });
  std::printf("%zu places\n", places);
  EXPECT_GT(places, 600U);
}

/// Two periods earlier no frame is read if the encoder's timeout is the limit.
TEST(SpiTotal, RequestsSoonerThanThat_AreNotRead) {
  Random random(0x70742);
  const std::size_t places = for_each_place([&](const Place& place) {
    const CycleBudget budget = place.budget();
    if (budget.idle.count != 0) return;
    EXPECT_NE(judged(place, budget.total - 2 * budget.period, random), "") << place.text();
  });
  EXPECT_GT(places, 600U);
}

}  // namespace biss::test::spi::total_test
