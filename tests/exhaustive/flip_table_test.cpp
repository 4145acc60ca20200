// The table of lab/reports/flips.md: its counts compared with decode_frame(), its text with the
// document.
#include "tests/exhaustive/flip_table.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <string>

#include "lab/test_slip.hpp"
#include "tests/core/test.hpp"
#include "tests/exhaustive/scale.hpp"
#include "tests/exhaustive/twin.hpp"

namespace exhaustive::flip_table_test {

using Codec = biss::FrameCodec<biss::CrcFast, 1>;

oracle::Description description_of(const Case& what) {
  using oracle::Kind;
  return {{{{{Kind::position, what.position_bits}, {Kind::nE, 1}, {Kind::nW, 1}},
            checksum_of(6, true, 0)}},
          what.cds0};
}

// The core encodes, one bit is flipped, the core decodes.
class Core {
 public:
  explicit Core(const Case& what)
      : what_(what), format_(twin_of(description_of(what)).format), codec_(format_) {}

  const biss::FrameFormat& format() const { return format_; }

  Outcome outcome_of(std::uint64_t position) const {
    biss::Frame sent;
    sent.channel_count = 1;
    sent.channel_list[0].position = position;
    sent.lead_clocks = Case::lead_clocks;
    sent.ack_clocks = static_cast<std::uint16_t>(what_.ack_clocks);
    biss::FrameBits bits = *biss::encode_frame(sent, codec_);
    bits.flip(what_.flip);
    if (what_.clock_goes_on) bits.append_run(false, bits.size_bits());
    const auto frame = biss::decode_frame(bits.view(), codec_, what_.bounds);
    if (!frame.ok()) return outcome(frame.error().cause);
    if (!frame->trusted()) return untrusted;
    return frame->channel_list[0].position == position ? right : wrong;
  }

 private:
  Case what_;
  biss::FrameFormat format_;
  Codec codec_;
};

Outcome predicted(const Verdict& verdict, std::uint64_t position) {
  for (const Leaf& leaf : verdict.leaves) {
    if (leaf.positions.contains(position)) return leaf.outcome;
  }
  return outcome(biss::FrameError::crc);
}

std::vector<Case> all_cases(unsigned width) {
  std::vector<Case> cases;
  for (const bool cds0 : {false, true}) {
    for (const Setting& setting : settings()) {
      for (std::size_t i = 0; i < fault_count; ++i) {
        for (const Case& what : cases_of(static_cast<Fault>(i), setting, width, cds0)) {
          cases.push_back(what);
        }
      }
    }
    cases.push_back(lone_ack_case(width, cds0, false));
    cases.push_back(lone_ack_case(width, cds0, true));
  }
  return cases;
}

std::uint64_t accepted(const Verdict& verdict, std::size_t start_bit) {
  std::uint64_t sum = 0;
  for (const Leaf& leaf : verdict.leaves) {
    const bool used = leaf.outcome == right || leaf.outcome == wrong;
    if (used && leaf.start_bit == start_bit) sum += leaf.positions.count();
  }
  return sum;
}

class FlipTable : public testing::TestWithParam<unsigned> {};

TEST_P(FlipTable, EveryOutcome_AddsUpToAllPositions) {
  for (const Case& what : all_cases(GetParam())) {
    std::uint64_t sum = 0;
    for (const std::uint64_t count : judge_all(what).tally) sum += count;
    ASSERT_EQ(sum, std::uint64_t{1} << GetParam()) << "flip " << what.flip;
  }
}

TEST_P(FlipTable, RandomPositions_HaveTheCountedOutcome) {
  BISS_RANDOM(random, 0xF11B'0000 + GetParam());
  const std::vector<Case> cases = all_cases(GetParam());
  std::uint64_t tried = 0;
  const std::uint64_t each = rounds(1'000'000) / cases.size() + 1;
  for (const Case& what : cases) {
    const Core core(what);
    const Verdict verdict = judge_all(what);
    for (std::uint64_t i = 0; i < each; ++i, ++tried) {
      const std::uint64_t position = random.bits(what.position_bits);
      ASSERT_EQ(name_of(core.outcome_of(position)), name_of(predicted(verdict, position)))
          << "position " << position << " flip " << what.flip << " ACK " << what.ack_clocks;
    }
  }
  EXPECT_GE(tried, rounds(1'000'000));
}

// For outcomes too rare for random positions, positions are drawn from the set of each outcome.
TEST_P(FlipTable, PositionsOfEachOutcome_HaveIt) {
  BISS_RANDOM(random, 0xF11C'0000 + GetParam());
  for (const Case& what : all_cases(GetParam())) {
    const Core core(what);
    for (const Leaf& leaf : judge_all(what).leaves) {
      for (unsigned i = 0; i < 8; ++i) {
        const std::uint64_t position = leaf.positions.any(random);
        ASSERT_EQ(name_of(core.outcome_of(position)), name_of(leaf.outcome))
            << "position " << position << " flip " << what.flip << " ACK " << what.ack_clocks;
      }
    }
  }
}

// The shares that the core computes for a format are those of the table.
TEST_P(FlipTable, SharesOfSlips_AreTheCoresOwn) {
  const biss::lab::SlipModel model{.trusted_only = true};
  const auto count = [](std::optional<unsigned> conditions) {
    return conditions ? std::uint64_t{1} << (GetParam() - *conditions) : 0;
  };
  for (const bool cds0 : {false, true}) {
    const Setting& loose = settings()[0];
    const Case lost = cases_of(Fault::start_clock_goes_on, loose, GetParam(), cds0).front();
    const biss::FrameFormat format = Core(lost).format();
    const Verdict verdict = judge_all(lost);
    for (unsigned distance = 1; distance < GetParam() + 9; ++distance) {
      EXPECT_EQ(accepted(verdict, lost.start_bit() + distance),
                count(biss::lab::slip_conditions(format, biss::lab::lost_start(distance), model)))
          << "distance " << distance;
    }
    for (const Case& early : cases_of(Fault::ack_between, loose, GetParam(), cds0)) {
      const auto clocks = static_cast<unsigned>(early.start_bit() - early.flip);
      EXPECT_EQ(accepted(judge_all(early), early.flip),
                count(biss::lab::slip_conditions(format, biss::lab::false_start(clocks), model)))
          << "early by " << clocks;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Widths, FlipTable, testing::ValuesIn(table_widths),
                         testing::PrintToStringParamName());

// All 2^18 positions of every line of the table; of the ACK bits those whose slip differs.
TEST(FlipTableOf18Bits, EveryPosition_IsCountedRight) {
  for (const Case& what : all_cases(18)) {
    const bool inside_ack = what.flip > Case::lead_clocks && what.flip < what.start_bit();
    if (inside_ack && (what.ack_clocks != 96 || what.start_bit() - what.flip > 32)) continue;
    if (slow_build && what.flip != what.start_bit()) continue;
    const Core core(what);
    Tally tally{};
    for (std::uint64_t position = 0; position < 1U << 18U; ++position) {
      ++tally[static_cast<std::size_t>(core.outcome_of(position))];
    }
    ASSERT_EQ(tally, judge_all(what).tally) << "flip " << what.flip << " ACK " << what.ack_clocks;
  }
}

TEST(FlipTableOf18Bits, StartLostBefore010_IsAcceptedAndNothingElseIs) {
  const Case lost = cases_of(Fault::start_clock_goes_on, settings()[0], 18, true).front();
  const Core core(lost);
  for (std::uint64_t position = 0; position < 1U << 18U; ++position) {
    const Outcome seen = core.outcome_of(position);
    ASSERT_EQ(seen == wrong || seen == untrusted, position >> 15U == 0b010) << position;
    ASSERT_NE(seen, right);
  }
}

TEST(FlipTable, Document_HasTheTablesAsComputed) {
  std::ifstream file(BISS_FLIPS_DOCUMENT);
  ASSERT_TRUE(file) << BISS_FLIPS_DOCUMENT;
  const std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  const std::string begin = "<!-- printed by biss_flip_table -->\n\n";
  const auto at = text.find(begin);
  ASSERT_NE(at, std::string::npos);
  EXPECT_EQ(text.substr(at + begin.size()), flip_tables())
      << "print the tables again with the target biss_flip_table";
}

}  // namespace exhaustive::flip_table_test
