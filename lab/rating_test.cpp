// The ratings of safety configurations: the table of the core, and random configurations.
#include "lab/pair.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "biss/frame/format_text.hpp"
#include "biss/safety/configurations.hpp"
#include "sim/random.hpp"
#include "tests/common/long_run.hpp"

namespace biss::lab {
namespace rating_test {

TEST(SafetyRatings, Table_IsWhatTheAnalysisGives) {
  std::vector<SafetyRating> expected;
  for (const SafetyConfiguration& each : safety_configurations) {
    const auto rating = safety_rating(each.frame_format(), each.setup.comparison);
    ASSERT_TRUE(rating) << each.name;
    // The rows of FORTiS have the words of RESOLUTE.
    if (each.name.starts_with("fortis")) continue;
    expected.push_back(*rating);
  }
  ASSERT_EQ(expected.size(), safety_ratings.size());
  for (std::size_t k = 0; k < expected.size(); ++k) {
    EXPECT_EQ(safety_ratings[k], expected[k])
        << fmt::format("{} is 0x{:X}, {}, 0x{:X}", k, expected[k].words, expected[k].residual_e24,
                       expected[k].check);
  }
}

TEST(SafetyRatings, OfAWideTolerance_DoNotExist) {
  const FrameFormat format = safety_configuration("fs-36-28").frame_format();
  EXPECT_FALSE(safety_rating(format, {.tolerance_lsb = 2}));
  EXPECT_FALSE(safety_rating(*parse_format("pos26,nE,nW,crc6"), {}));
}

// A word's position, and the text of it in a format.
struct Widths {
  unsigned turns;
  unsigned single;

  std::string text() const {
    return turns == 0 ? fmt::format("pos{}", single) : fmt::format("mt{},st{}", turns, single);
  }
};

struct Candidate {
  FrameFormat format;
  SafetySetup setup;
};

// Few kinds of words, because the exact analysis of one takes a tenth of a second; in the quick tests
// only the first that come up.
const std::size_t words_max = test::rounds(1'000, 64);

Candidate random_candidate(sim::Random& random) {
  const auto one_of = [&](auto... values) {
    const unsigned list[] = {static_cast<unsigned>(values)...};
    return list[random.below(sizeof...(values))];
  };
  const Widths cpw{one_of(0, 0, 12), one_of(16, 28, 36)};
  const Widths spw{cpw.turns == 0 ? 0 : one_of(0, 12), one_of(12, 16)};
  const char* crc_of_cpw = random.below(16) == 0 ? "crc5" : "crc6";
  const char* crc_of_spw = random.below(16) == 0 ? "crc3" : "crc16";
  Candidate candidate;
  candidate.format = *parse_format(
      fmt::format("{},nE,nW,{}+{},nE,nW,lc6,{}", cpw.text(), crc_of_cpw, spw.text(), crc_of_spw));
  SafetySetup& setup = candidate.setup;
  setup.comparison.compare_bits = static_cast<std::uint8_t>(one_of(0, 0, 2, 9, 12));
  setup.comparison.tolerance_lsb = static_cast<std::uint8_t>(one_of(1, 1, 1, 0, 2, 255));
  setup.cycle_min = nanoseconds(1'000) * one_of(10, 31, 62, 125, 1000);
  setup.frame_gap_min = random.below(8) == 0 ? Picoseconds{} : setup.cycle_min;
  setup = at_cycle(setup, setup.cycle_min);
  setup.residual_max_e15 = std::uint64_t{1} << (10U + random.below(18));
  return candidate;
}

// Every configuration is refused by name, or has at most the undetected errors that it claims: with
// its own rating, that of other words, a changed one, or none.
TEST(SafetyRatings, RandomConfigurations_AreRefusedOrHoldWhatTheyClaim) {
  constexpr std::uint64_t seed = 0x5AFE'1161;
  constexpr int count = 100'000;
  RecordProperty("seed", std::to_string(seed));
  sim::Random random(seed);
  std::map<std::uint64_t, std::optional<SafetyRating>> exact;
  SafetyRating last;
  std::map<SafetySetupError, int> refused;
  int accepted = 0;
  for (int n = 0; n < count; ++n) {
    Candidate candidate = random_candidate(random);
    SafetySetup& setup = candidate.setup;
    if (check_safety(candidate.format, UnratedSafetySetup(setup))) continue;
    const std::uint64_t words = rated_words(candidate.format.channel_list[0],
                                            candidate.format.channel_list[1], setup.comparison);
    auto found = exact.find(words);
    if (found == exact.end()) {
      if (exact.size() == words_max) continue;
      found = exact.emplace(words, safety_rating(candidate.format, setup.comparison)).first;
    }
    switch (random.below(4)) {
      case 0:
        break;
      case 1:
        setup.rating = last;
        break;
      case 2:
        setup.rating = found->second.value_or(last);
        setup.rating.residual_e24 >>= 1U + random.below(4);
        break;
      default:
        setup.rating = found->second.value_or(last);
    }
    if (found->second) last = *found->second;
    if (const auto mistake = check_safety(candidate.format, setup)) {
      ++refused[*mistake];
      continue;
    }
    ++accepted;
    ASSERT_TRUE(found->second) << n;
    const long double frames = 3600e12L / static_cast<long double>(setup.frame_gap_min.count);
    const long double errors =
        static_cast<long double>(found->second->residual_e24) * 1e-24L * frames;
    ASSERT_LE(errors, static_cast<long double>(setup.residual_max_e15) * 1e-15L) << n;
  }
  EXPECT_GT(accepted, count / 100);
  for (const SafetySetupError mistake :
       {SafetySetupError::checksum, SafetySetupError::weak_comparison, SafetySetupError::unrated,
        SafetySetupError::residual}) {
    EXPECT_GT(refused[mistake], count / 100);
  }
  fmt::print(
      "{} accepted, {} weak checksums, {} weak comparisons, {} unrated, {} above the limit\n",
      accepted, refused[SafetySetupError::checksum], refused[SafetySetupError::weak_comparison],
      refused[SafetySetupError::unrated], refused[SafetySetupError::residual]);
}

}  // namespace rating_test
}  // namespace biss::lab
