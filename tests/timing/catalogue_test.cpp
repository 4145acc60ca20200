// Every encoder of the catalogue: the slaves of the core and of the oracle compared, edge by edge,
// at each clock rate, with each permitted cable, as fast and as slow as the data sheet permits.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "biss/catalogue/catalogue.hpp"
#include "biss/timing/cable.hpp"
#include "biss/timing/cycle.hpp"
#include "tests/core/random.hpp"
#include "tests/exhaustive/scale.hpp"
#include "tests/timing/scenario.hpp"

namespace timing_test::catalogue_test {

using biss::CatalogueEntry;
using biss::Picoseconds;
using biss::test::Random;
using oracle::Time;

constexpr std::size_t requests = 4;

/// An encoder, its clock rate, its cable.
struct Installation {
  const CatalogueEntry* entry = nullptr;
  biss::Hertz clock;
  biss::Millimetres cable;
  Picoseconds ready;  ///< from ACK until it has its answer

  std::string text() const {
    return std::string(entry->name) + " at " + std::to_string(clock.count / 1000) + " kHz, " +
           std::to_string(cable.count / 1000) + " m, ready after " + std::to_string(ready.count) +
           " ps";
  }
};

/// The expected answers of the encoder, one for each request.
using Said = std::vector<std::vector<oracle::Values>>;

oracle::Checksum checksum_of(unsigned bits) {
  if (bits != 6 && bits != 16) throw std::invalid_argument("a checksum without polynomial");
  return {oracle::bits_of(bits == 6 ? 0x43 : 0x190D9, bits + 1U), oracle::Bits(bits, false), true};
}

void add_item(oracle::ChannelDescription& channel, const std::string& text) {
  using oracle::Kind;
  const std::size_t digits = std::min(text.find_first_of("0123456789"), text.size());
  const std::string name = text.substr(0, digits);
  const std::size_t bits = digits == text.size() ? 1 : std::stoul(text.substr(digits));
  if (name + std::to_string(bits) != text && name != text) throw std::invalid_argument(text);
  if (name == "crc") {
    channel.checksum = checksum_of(static_cast<unsigned>(bits));
    return;
  }
  const std::array<std::pair<const char*, Kind>, 8> kinds{{{"pos", Kind::position},
                                                           {"mt", Kind::multiturn},
                                                           {"st", Kind::singleturn},
                                                           {"pad", Kind::padding},
                                                           {"nE", Kind::nE},
                                                           {"nW", Kind::nW},
                                                           {"E", Kind::E},
                                                           {"lc", Kind::counter}}};
  for (const auto& [kind_name, kind] : kinds) {
    if (name == kind_name) return channel.items.push_back({kind, bits});
  }
  throw std::invalid_argument(text);
}

// Reads the catalogue's text without the core, limited to the grammar that the catalogue uses.
oracle::Description description_of(std::string text) {
  oracle::Description description;
  const std::size_t options = text.find(';');
  if (options != std::string::npos) {
    if (text.substr(options) != ";cds0") throw std::invalid_argument(text);
    description.cds_must_be_0 = true;
    text.resize(options);
  }
  description.channels.emplace_back();
  std::string item;
  for (const char letter : text + ",") {
    if (letter != ',' && letter != '+') {
      item += letter;
      continue;
    }
    add_item(description.channels.back(), item);
    item.clear();
    if (letter == '+') description.channels.emplace_back();
  }
  return description;
}

std::size_t width_of(const oracle::ChannelDescription& channel, bool counter) {
  std::size_t bits = 0;
  for (const oracle::Item& item : channel.items) {
    const bool position = item.kind == oracle::Kind::position ||
                          item.kind == oracle::Kind::multiturn ||
                          item.kind == oracle::Kind::singleturn;
    if (counter ? item.kind == oracle::Kind::counter : position) bits += item.bits;
  }
  return bits;
}

Said random_values(const oracle::Description& description, Random& random) {
  Said said(requests);
  for (auto& values : said) {
    for (const oracle::ChannelDescription& channel : description.channels) {
      const auto has = [&](oracle::Kind kind) {
        return std::any_of(channel.items.begin(), channel.items.end(),
                           [&](const oracle::Item& item) { return item.kind == kind; });
      };
      values.push_back({random.bits(static_cast<unsigned>(width_of(channel, false))),
                        random.bits(static_cast<unsigned>(width_of(channel, true))),
                        !(has(oracle::Kind::nE) || has(oracle::Kind::E)) || random.flip(),
                        !has(oracle::Kind::nW) || random.flip()});
    }
  }
  return said;
}

biss::CycleBudget budget_of(const Installation& place) {
  const biss::DeviceTiming& timing = place.entry->timing;
  return biss::cycle_budget({.payload_bits = place.entry->frame_format().payload_bits()}, timing,
                            place.clock, biss::line_delay(place.cable, timing.internal_delay_max));
}

/// MA at the encoder.
struct Clocks {
  Time period = 0;
  std::int64_t count = 0;               ///< a request
  std::array<Time, requests> begins{};  ///< the first falling edges
  oracle::Line ma;
};

// Every other request with a CDM of 1. Each comes just when the encoder must be ready, or sooner;
// after a CDM of 1 MA is high for half a period first.
Clocks clocks_of(const Installation& place, Picoseconds sooner = {}) {
  const biss::CycleBudget budget = budget_of(place);
  const Time period = budget.period.count;
  Clocks clocks{.period = period, .count = budget.clocks_to_send, .begins = {}, .ma = {}};
  Time begin = 5 * period + biss::cable_delay(place.cable).count / 2;
  for (std::size_t request = 0; request < requests; ++request) {
    clocks.begins[request] = begin;
    Time now = begin;
    for (std::int64_t clock = 0; clock < clocks.count; ++clock, now += period) {
      clocks.ma.push_back({now, false});
      clocks.ma.push_back({now + period / 2, true});
    }
    begin += budget.total.count - sooner.count;
    if (request % 2 == 0 || sooner.count != 0) continue;
    clocks.ma.push_back({now, false});
    clocks.ma.push_back({begin, true});
    begin += period / 2;
  }
  return clocks;
}

oracle::SlaveAnswer answer_of_core(const Installation& place, const oracle::Line& ma,
                                   const Said& said, bool cds) {
  const auto frame = [&said](std::size_t number) {
    biss::Frame sent;
    for (std::size_t k = 0; k < said.at(number).size(); ++k) {
      const oracle::Values& values = said[number][k];
      sent.channel_list[k] = {.position = values.position,
                              .life_counter = static_cast<std::uint32_t>(values.counter),
                              .nE = values.nE,
                              .nW = values.nW};
    }
    return sent;
  };
  return answers_of_core({{place.entry->frame_format(),
                           biss::slave_timing(place.entry->timing, place.ready), frame, cds}},
                         ma)
      .front();
}

oracle::SlaveDescription timing_of(const Installation& place) {
  const biss::DeviceTiming& device = place.entry->timing;
  oracle::SlaveDescription slave;
  slave.sampling = device.sampling_typical.count;
  slave.start_min = device.start_min.count;
  slave.ready = place.ready.count;
  slave.ack_clocks = device.ack_clocks;
  slave.timeout = device.timeout.time.count;
  switch (device.timeout.rule) {
    case biss::TimeoutRule::adaptive:
      slave.kind = oracle::TimeoutKind::adaptive;
      break;
    case biss::TimeoutRule::fixed:
      slave.kind = oracle::TimeoutKind::fixed;
      break;
    case biss::TimeoutRule::cycle:
      slave.kind = oracle::TimeoutKind::cycle;
      break;
  }
  return slave;
}

oracle::SlaveAnswer answer_of_oracle(const Installation& place, const oracle::Line& ma,
                                     const oracle::Description& description, const Said& said,
                                     bool cds) {
  const auto payload = [&](std::size_t number) {
    const oracle::Bits line = oracle::encode(description, said.at(number), 1, 1, cds);
    return oracle::Bits(line.begin() + 4, line.end() - 1);  // without lead, ACK, START, CDS, STOP
  };
  return oracle::answer(timing_of(place), ma, {}, payload, cds);
}

// The errors in the bits that a master reads at MA's falling edges, STOP included: two equal
// answers could still both be missing.
std::string unread(const oracle::SlaveAnswer& answer, const Clocks& clocks,
                   const oracle::Description& description, const Said& said) {
  auto change = answer.slo.begin();
  bool level = true;
  for (std::size_t request = 0; request < requests; ++request) {
    oracle::Bits line;
    for (std::int64_t clock = 1; clock <= clocks.count; ++clock) {
      const Time sampled = clocks.begins[request] + clock * clocks.period;
      for (; change != answer.slo.end() && change->time <= sampled; ++change) level = change->level;
      line.push_back(level);
    }
    const oracle::Reading reading = oracle::decode(description, {}, line);
    const std::string number = "request " + std::to_string(request) + ": ";
    if (!reading.cause.empty()) return number + reading.cause;
    if (!reading.stop_seen) return number + "no STOP";
    if (reading.values != said.at(request)) return number + "other values";
  }
  return {};
}

std::string judged(const Installation& place, const oracle::Description& description,
                   Random& random) {
  const Said said = random_values(description, random);
  const bool cds = !description.cds_must_be_0 && random.flip();
  const Clocks clocks = clocks_of(place);
  const oracle::SlaveAnswer judge = answer_of_oracle(place, clocks.ma, description, said, cds);
  const oracle::SlaveAnswer core = answer_of_core(place, clocks.ma, said, cds);
  const std::string what = difference({core}, {judge});
  if (!what.empty()) return what + "MA " + text_of(clocks.ma);
  return unread(judge, clocks, description, said);
}

// In slow builds, one of five installations. The number divides no encoder's number of
// installations.
constexpr std::size_t thin = exhaustive::slow_build ? 5 : 1;

std::vector<Installation> installations_of(const CatalogueEntry& entry, std::size_t& passed) {
  std::vector<Installation> places;
  for (const biss::Hertz clock : {biss::kilohertz(250), biss::megahertz(1), biss::megahertz(2),
                                  biss::megahertz(5), biss::megahertz(10)}) {
    if (!biss::accepts_clock(entry.timing, clock)) continue;
    for (const int length : {0, 10, 50, 100}) {
      const biss::Millimetres cable = biss::metres(length);
      if (cable > biss::cable_max_compensated(clock)) continue;
      for (const Picoseconds ack : {Picoseconds{}, entry.timing.ack_max}) {
        if (passed++ % thin == 0) places.push_back({&entry, clock, cable, ack});
      }
    }
  }
  return places;
}

// The time before `total` at which the encoder is certainly not ready. A timeout that ends in the
// middle of a clock is rounded up, and half a period is reserved for CDM 1; a fixed cycle time is
// exact. None if the device's shortest cycle is longer than its timeout, because no request is
// refused then.
std::optional<Picoseconds> too_soon(const Installation& place) {
  const biss::CycleBudget budget = budget_of(place);
  if (budget.idle.count != 0) return std::nullopt;
  const biss::Timeout& timeout = place.entry->timing.timeout;
  const bool fixed_time = timeout.rule == biss::TimeoutRule::cycle && budget.total == timeout.time;
  return fixed_time ? biss::picoseconds(1) : 2 * budget.period;
}

TEST(CatalogueAgainstOracle, EveryEncoderClockAndCable_IsAnsweredAlike) {
  constexpr std::uint64_t seed = 0xCA7A'0001;
  std::printf("[   seed   ] 0x%llX\n", static_cast<unsigned long long>(seed));
  Random random(seed);
  std::size_t places = 0;
  std::size_t passed = 0;
  for (const CatalogueEntry& entry : biss::catalogue) {
    const oracle::Description description = description_of(std::string(entry.format));
    for (const Installation& place : installations_of(entry, passed)) {
      ASSERT_EQ(judged(place, description, random), "") << place.text();
      ++places;
    }
  }
  std::printf("[  places  ] %zu of %zu encoders\n", places, biss::catalogue.size());
  EXPECT_GE(places * thin, 2 * 10 * biss::catalogue.size());
}

TEST(CatalogueAgainstOracle, RequestsSoonerThanTheBudget_AreNotAnswered) {
  Random random(0xCA7A'0002);
  std::size_t places = 0;
  std::size_t passed = 0;
  for (const CatalogueEntry& entry : biss::catalogue) {
    const oracle::Description description = description_of(std::string(entry.format));
    for (const Installation& place : installations_of(entry, passed)) {
      const auto sooner = too_soon(place);
      if (!sooner) continue;
      const Said said = random_values(description, random);
      const Clocks clocks = clocks_of(place, *sooner);
      ASSERT_EQ(answer_of_core(place, clocks.ma, said, false).samples.size(), 1U) << place.text();
      ASSERT_EQ(answer_of_oracle(place, clocks.ma, description, said, false).samples.size(), 1U)
          << place.text();
      ++places;
    }
  }
  std::printf("[  places  ] %zu\n", places);
  EXPECT_GE(places * thin, 2 * 8 * biss::catalogue.size());
}

}  // namespace timing_test::catalogue_test
