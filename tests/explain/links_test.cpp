// A sample of the captures of every cause; all of them are in the long tests.
#include "tests/explain/links.hpp"

#include <gtest/gtest.h>

#include "biss/frame/format_text.hpp"
#include "sim/line.hpp"
#include "tests/explain/matrix.hpp"

namespace biss::explain::test::links_test {

TEST(Explain, SampleOfEachCause_IsFoundFirst) {
  const Matrix matrix = measure_matrix(documented_seed + 5000, 12, 60);
  std::uint64_t first = 0;
  std::uint64_t all = 0;
  for (std::size_t c = 1; c < cause_count; ++c) {
    const auto cause = static_cast<Cause>(c);
    // A foreign frame on a fast axis is not a step beyond its motion.
    const std::uint64_t least = cause == Cause::position_implausible ? 3 : 6;
    EXPECT_GE(matrix.right(cause), least) << name_of(cause) << '\n' << matrix.misses;
    first += matrix.right(cause);
    all += matrix.links[c];
  }
  EXPECT_GE(100 * first, 85 * all) << matrix.misses;
  EXPECT_EQ(matrix.right(Cause::healthy), 60U) << matrix.misses;
}

TEST(Explain, Likelihoods_FallAndAddUpToLessThanOne) {
  for (std::size_t c = 0; c < cause_count; ++c) {
    const auto findings = explain_link(make_link(static_cast<Cause>(c), 77));
    ASSERT_FALSE(findings.empty());
    double sum = 0;
    double last = 1;
    for (const Finding& finding : findings) {
      EXPECT_LE(finding.likelihood, last);
      last = finding.likelihood;
      sum += finding.likelihood;
    }
    EXPECT_LT(sum, 1);
    EXPECT_GT(sum, 0.8);
  }
}

// A clock of 40 % has levels of two and three fifths of its period: no samples, though whole steps.
TEST(Explain, UnevenDutyInACaptureOfChanges_IsNoSampling) {
  sim::LineSetup setup;
  setup.format = parse_format("pos26,nE,nW,crc6").value();
  setup.clock = kilohertz(2'500);
  setup.duty_per_mille = 400;
  setup.internal_delay = nanoseconds(80);
  setup.motion = sim::MotionKind::random;
  Link link;
  link.edges = {{{}, 0, wire::Level::high}, {{}, 1, wire::Level::high}};
  sim::Line line(setup);
  for (int i = 0; i < 60; ++i) {
    const auto& edges = line.next().edges;
    link.edges.insert(link.edges.end(), edges.begin(), edges.end());
  }
  link.end = line.end() + microseconds(2);
  link.format = setup.format;
  link.timing = setup.timing;
  EXPECT_EQ(observe_link(link).resolution, Picoseconds{});
  EXPECT_EQ(explain_link(link).front().cause, Cause::healthy);
}

// What other rooms know decides where they are sure.
TEST(Explain, AnotherProtocolThatIsRecognised_IsNotBiss) {
  const Link link = make_link(Cause::wrong_format, 3);
  const Evidence evidence = observe_link(link);
  Context context;
  context.format = link.format;
  context.timing = link.timing;
  EXPECT_EQ(diagnose(evidence, context).front().cause, Cause::wrong_format);
  context.other = {.name = "ssi", .confidence = 0.95, .why = "bursts of 25 clocks"};
  EXPECT_EQ(diagnose(evidence, context).front().cause, Cause::not_biss);
}

TEST(Explain, IdentifiedFormatThatIsTheGivenOne_IsNoWrongFormat) {
  const Link link = make_link(Cause::master_stops_early, 4);
  const Evidence evidence = observe_link(link);
  Context context;
  context.format = link.format;
  context.timing = link.timing;
  context.identified = {.format = link.format, .confidence = 0.95};
  const auto findings = diagnose(evidence, context);
  EXPECT_EQ(findings.front().cause, Cause::master_stops_early);
  for (const Finding& finding : findings) EXPECT_NE(finding.cause, Cause::wrong_format);
}

TEST(Explain, WithoutFormat_HealthyIsNotLikelierThanHalf) {
  Evidence evidence = observe_link(make_link(Cause::healthy, 5));
  EXPECT_GT(diagnose(evidence, Context{}).front().likelihood, 0.5);
  evidence.has_format = false;
  const auto findings = diagnose(evidence, Context{});
  EXPECT_EQ(findings.front().cause, Cause::healthy);
  EXPECT_LE(findings.front().likelihood, 0.5);
}

TEST(Explain, NamesAndRemedies_AreThereForEachCause) {
  for (std::size_t c = 0; c < cause_count; ++c) {
    EXPECT_FALSE(name_of(static_cast<Cause>(c)).empty());
    EXPECT_FALSE(remedy_of(static_cast<Cause>(c)).empty());
  }
}

}  // namespace biss::explain::test::links_test
