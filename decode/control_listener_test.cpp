#include "decode/control_listener.hpp"

#include <gtest/gtest.h>

#include <iostream>
#include <string>
#include <string_view>
#include <vector>

#include "biss/control/session.hpp"

namespace biss::decode {
namespace control_listener_test {

// A listener and the accesses that it reported; cycles of 31.25 us.
struct Bench {
  std::vector<SeenAccess> told;
  ControlListener listener{[this](const SeenAccess& access) { told.push_back(access); }};
  std::uint64_t number = 0;

  void push(std::optional<bool> cds, std::optional<bool> cdm) {
    listener.push(number, static_cast<std::int64_t>(number) * nanoseconds(31'250), cds, cdm);
    ++number;
  }
  void zeros(unsigned count) {
    for (unsigned i = 0; i < count; ++i) push(false, false);
  }
  // The CDS bit k comes one cycle after the CDM bit k.
  void access(std::string_view cdm, std::string_view cds) {
    for (std::size_t k = 0; k <= cds.size() || k < cdm.size(); ++k) {
      push(k >= 1 && k <= cds.size() && cds[k - 1] == '1', k < cdm.size() && cdm[k] == '1');
    }
  }
  const SeenAccess& only() const {
    static const SeenAccess none;
    EXPECT_EQ(told.size(), 1U);
    return told.empty() ? none : told.front();
  }
};

void expect_register(const SeenAccess& access, SeenAccess::Kind kind, unsigned id, unsigned address,
                     unsigned data) {
  EXPECT_EQ(name_of(access.outcome), "ok");
  EXPECT_EQ(name_of(access.kind), name_of(kind));
  EXPECT_EQ(access.id, id);
  EXPECT_EQ(access.address, address);
  ASSERT_TRUE(access.data);
  EXPECT_EQ(*access.data, data);
}

struct Printed {
  const char* cdm;
  const char* cds;
  SeenAccess::Kind kind;
  unsigned id, address, data;
};

// The control frames of one access each that the protocol's rules give.
constexpr Printed printed[] = {
    {"11000100001001111010000000000000", "10000000000000001010110001001000", SeenAccess::Kind::read,
     0, 0x42, 0x62},
    {"11000100001101001010000000000000", "10000000000000001010001111010110", SeenAccess::Kind::read,
     0, 0x43, 0x1E},
    {"11000111111011111010000000000000", "10000000000000001010110100110100", SeenAccess::Kind::read,
     0, 0x7E, 0x69},
    {"11001100000111001010000000000000", "11000000000000001010000001010010", SeenAccess::Kind::read,
     1, 0x41, 0x02},
    {"11000100000000010110000001010010", "10000000000000000110000001010010",
     SeenAccess::Kind::write, 0, 0x40, 0x02},
    {"11000000001000000110101010100100", "10000000000000000110101010100100",
     SeenAccess::Kind::write, 0, 0x02, 0x55},
};

TEST(ControlListener, PrintedFrames_AreTold) {
  for (const Printed& each : printed) {
    Bench bench;
    bench.zeros(14);
    bench.access(each.cdm, each.cds);
    expect_register(bench.only(), each.kind, each.id, each.address, each.data);
    EXPECT_EQ(bench.only().cycle, 14U);
    EXPECT_EQ(bench.only().cycles, 33U);
    EXPECT_TRUE(bench.only().next_available);
    EXPECT_EQ(bench.listener.stray_cds(), 0U);
  }
}

TEST(ControlListener, TooFewZerosBefore_IsNoAccess) {
  Bench bench;
  bench.zeros(13);
  bench.access(printed[0].cdm, printed[0].cds);
  EXPECT_TRUE(bench.told.empty());
  EXPECT_NE(bench.listener.stray_cdm(), 0U);
}

TEST(ControlListener, Commands_AreToldWithTheirSlaves) {
  Bench bench;
  bench.zeros(14);
  bench.access("100000000000111111", "1000000000000000");
  EXPECT_EQ(bench.only().kind, SeenAccess::Kind::command);
  EXPECT_EQ(bench.only().slaves, 0);
  EXPECT_EQ(bench.only().command, ControlCommand::channels);
  EXPECT_EQ(name_of(bench.only().outcome), "ok");
  bench.told.clear();
  bench.zeros(14);
  bench.access("1001000000010011100000001", "110000000000000001000000");
  EXPECT_EQ(bench.only().slaves, 2);
  EXPECT_EQ(bench.only().accepted, 2);
  EXPECT_EQ(bench.only().command, ControlCommand::control);
  EXPECT_EQ(name_of(bench.only().outcome), "ok");
  bench.told.clear();
  bench.zeros(14);
  bench.access("1001000000010011100000000", "110000000000000000000000");
  EXPECT_EQ(name_of(bench.only().outcome), "not_accepted");
  bench.told.clear();
  bench.zeros(14);
  bench.access("1001000000010011100000000", "110000000000000001000000");
  EXPECT_EQ(name_of(bench.only().outcome), "dropped");
}

// The read access of the table with another CDS.
std::string_view outcome_of(std::string_view cdm, std::string_view cds) {
  static Bench bench;
  bench.told.clear();
  bench.zeros(40);
  bench.access(cdm, cds);
  bench.zeros(40);
  return name_of(bench.only().outcome);
}

TEST(ControlListener, EveryRefusal_HasItsName) {
  const char* const read = printed[0].cdm;
  EXPECT_EQ(outcome_of(read, "00000000000000000000000000000000"), "no_answer");
  EXPECT_EQ(outcome_of(read, "10000000000000001100000000000000"), "refused");
  EXPECT_EQ(outcome_of(read, "10000000000000000000000000000000"), "not_addressed");
  EXPECT_EQ(outcome_of(read, "10000000000000000100000000000000"), "rw_pattern");
  EXPECT_EQ(outcome_of(read, "10100000000000001010110001001000"), "id_pattern");
  EXPECT_EQ(outcome_of(read, "10000000000100001010110001001000"), "id_pattern");
  EXPECT_EQ(outcome_of(read, "10000000000000001010110001001100"), "data_crc");
  EXPECT_EQ(outcome_of(read, "10000000000000001000000000000000"), "busy_too_long");
  EXPECT_EQ(outcome_of("11000100001001101010000000000000", printed[0].cds), "header_crc");
  EXPECT_EQ(outcome_of("11001100000111001010000000000000", "10000000000000000000000000000000"),
            "no_such_slave");
  const char* const write = printed[5].cdm;
  EXPECT_EQ(outcome_of(write, "10000000000000000000000000000000"), "refused_or_not_addressed");
  EXPECT_EQ(outcome_of(write, "10000000000000000100000000000000"), "start_missing");
  EXPECT_EQ(outcome_of(write, "10000000000000000110101010100110"), "echo");
  EXPECT_EQ(outcome_of("11000000001000000110101010100110", printed[5].cds), "write_crc");
}

TEST(ControlListener, AnyBitBehindTheIds_IsAnIdPattern) {
  for (std::size_t bit = 9; bit < 16; ++bit) {
    for (const bool answers : {false, true}) {
      std::string cds = printed[0].cds;
      cds[0] = answers ? '1' : '0';
      cds[bit] = '1';
      EXPECT_EQ(outcome_of(printed[0].cdm, cds), "id_pattern") << bit;
    }
  }
}

// The master's session with the bits of a slave, with a busy time before each byte.
TEST(ControlListener, SequenceWithBusyTimes_IsARowAByte) {
  Bench bench;
  ControlSession session;
  std::vector<std::uint8_t> to(5);
  session.read(0, 0x10, to);
  std::string queue;
  unsigned k = 0;
  bool cds = false;
  while (!session.done()) {
    const bool cdm = session.step({}, cds ? CdsBit::one : CdsBit::zero);
    bench.push(cds, cdm);
    if (k == 0 && !cdm) continue;
    cds = false;
    if (k < 18) cds = k == 0 || k == 16;
    if (k == 17) {
      for (unsigned i = 0; i < 5; ++i) {
        queue += "001";
        const unsigned data = 0xA0 + i;
        const unsigned word = data << 4U | byte_crc(static_cast<std::uint8_t>(data));
        for (unsigned b = 12; b-- > 0;) queue += (word >> b & 1U) != 0 ? '1' : '0';
        queue += '0';
      }
    }
    if (k >= 18 && k - 18 < queue.size()) cds = queue[k - 18] == '1';
    ++k;
  }
  ASSERT_FALSE(session.outcome().error);
  bench.zeros(1);
  ASSERT_EQ(bench.told.size(), 5U);
  for (unsigned i = 0; i < 5; ++i) {
    expect_register(bench.told[i], SeenAccess::Kind::read, 0, 0x10 + i, 0xA0 + i);
    EXPECT_EQ(bench.told[i].busy_cycles, 2U);
    EXPECT_EQ(bench.told[i].busy, nanoseconds(2 * 31'250));
  }
}

TEST(ControlListener, LostCycle_BreaksTheAccessAndTheNextOneIsTold) {
  for (std::size_t lost = 1; lost < 33; ++lost) {
    Bench bench;
    bench.zeros(14);
    for (std::size_t k = 0; k < lost; ++k) {
      bench.push(k != 0 && printed[0].cds[k - 1] == '1', printed[0].cdm[k] == '1');
    }
    bench.push(std::nullopt, std::nullopt);
    ASSERT_EQ(bench.told.size(), 1U) << lost;
    EXPECT_EQ(name_of(bench.told[0].outcome), "frame_lost");
    bench.zeros(14);
    bench.access(printed[1].cdm, printed[1].cds);
    ASSERT_EQ(bench.told.size(), 2U);
    expect_register(bench.told[1], SeenAccess::Kind::read, 0, 0x43, 0x1E);
  }
}

TEST(ControlListener, CycleCutByTheEndOfTheCapture_GivesCutEnd) {
  Cycle whole;
  whole.raw.append(0b10, 2);
  whole.cdm = false;
  Cycle start = whole;
  start.cdm = true;
  Cycle cut = whole;
  cut.status = CycleStatus::cut_end;
  Cycle without_rest = whole;
  without_rest.cdm.reset();
  Cycle silent = whole;
  silent.status = CycleStatus::no_response;
  silent.raw = {};
  for (const auto& [last, outcome] :
       {std::pair{cut, "cut_end"}, {without_rest, "cut_end"}, {silent, "frame_lost"}}) {
    Bench bench;
    for (unsigned k = 0; k < 14; ++k) bench.listener.push(bench.number++, whole);
    bench.listener.push(bench.number++, start);
    // A cut frame may contain its CDS, but not the level of MA after it.
    Cycle ends = last;
    if (ends.status == CycleStatus::cut_end) ends.cdm.reset();
    bench.listener.push(bench.number++, ends);
    bench.listener.finish();
    EXPECT_EQ(name_of(bench.only().outcome), outcome);
  }
}

TEST(ControlListener, ZerosBehindTheStartBit_AreADamagedHeader) {
  Bench bench;
  bench.zeros(14);
  bench.push(false, true);
  bench.zeros(14);
  EXPECT_EQ(name_of(bench.only().outcome), "header_crc");
  EXPECT_FALSE(bench.only().header_sent);
  bench.access(printed[0].cdm, printed[0].cds);
  ASSERT_EQ(bench.told.size(), 2U);
  expect_register(bench.told[1], SeenAccess::Kind::read, 0, 0x42, 0x62);
}

TEST(ControlListener, EndOfCapture_IsTold) {
  Bench bench;
  bench.zeros(14);
  bench.push(false, true);
  bench.listener.finish();
  EXPECT_EQ(name_of(bench.only().outcome), "cut_end");
}

// After any bits and fourteen zeros, an access is reported as sent, and `ok` implies a right CRC.
TEST(ControlListener, RandomBits_AreUnrestored) {
  std::uint64_t state = 0xB155;
  std::cout << "seed " << state << '\n';
  const auto random = [&] {
    state = state * 6364136223846793005U + 1442695040888963407U;
    return static_cast<unsigned>(state >> 33U);
  };
  for (unsigned round = 0; round < 2000; ++round) {
    Bench bench;
    for (unsigned i = random() % 400; i > 0; --i) {
      const unsigned dice = random();
      const bool lost = dice % 100 == 0;
      bench.push(lost ? std::nullopt : std::optional((dice & 256U) != 0),
                 lost ? std::nullopt : std::optional(dice % 37 != 0 && (dice & 512U) != 0));
    }
    bench.zeros(14);
    bench.told.clear();
    bench.access(printed[0].cdm, printed[0].cds);
    expect_register(bench.only(), SeenAccess::Kind::read, 0, 0x42, 0x62);
  }
}

// A reduced frame carries CDM alone: the accesses are found, but not what the slaves answered.
TEST(ControlListener, ReducedFrames_ShowTheAccessesWithoutAnAnswer) {
  Bench bench;
  const auto reduced = [&](std::string_view cdm) {
    for (const char bit : std::string(14, '0') + std::string(cdm)) {
      Cycle cycle;
      cycle.status = CycleStatus::no_start;
      cycle.time = static_cast<std::int64_t>(bench.number) * microseconds(28);
      cycle.rising_edges = 2;
      cycle.cdm = bit == '1';
      bench.listener.push(bench.number++, cycle);
    }
  };
  for (const Printed& each : printed) reduced(each.cdm);
  reduced("0");
  ASSERT_EQ(bench.told.size(), std::size(printed));
  for (std::size_t i = 0; i < std::size(printed); ++i) {
    const SeenAccess& access = bench.told[i];
    EXPECT_EQ(name_of(access.outcome), "cds_not_seen");
    EXPECT_EQ(access.kind, printed[i].kind);
    EXPECT_EQ(access.address, printed[i].address);
    EXPECT_EQ(access.data.has_value(), printed[i].kind == SeenAccess::Kind::write);
  }
}

}  // namespace control_listener_test
}  // namespace biss::decode
