#include "tests/explain/matrix.hpp"

#include <fmt/format.h>

#include <iterator>

#include "tests/explain/links.hpp"

namespace biss::explain::test {

namespace {

std::string kinds_text(const Evidence& evidence) {
  std::string text = fmt::format("{} cycles of {} ps, edges to {} ps", evidence.cycles,
                                 evidence.period.count() == 0 ? 0 : evidence.period.median(),
                                 evidence.resolution.count);
  for (std::size_t s = 1; s < kind_count; ++s) {
    if (evidence.kinds[s].count == 0) continue;
    fmt::format_to(std::back_inserter(text), ", {} {}", evidence.kinds[s].count,
                   text_of(static_cast<RequestKind>(s)));
  }
  return text;
}

void count(const Link& link, std::uint64_t seed, Matrix& matrix) {
  const auto truth = static_cast<std::size_t>(link.truth);
  const std::vector<Finding> findings = explain_link(link);
  ++matrix.links[truth];
  ++matrix.first[truth][static_cast<std::size_t>(findings.front().cause)];
  for (std::size_t i = 0; i < 2 && i < findings.size(); ++i) {
    if (findings[i].cause == link.truth) ++matrix.among_two[truth];
  }
  if (findings.front().cause == link.truth) return;
  fmt::format_to(std::back_inserter(matrix.misses), "{} {}: {}\n   ", name_of(link.truth), seed,
                 link.story);
  for (const Finding& finding : findings) {
    fmt::format_to(std::back_inserter(matrix.misses), " {} {:.2f}", name_of(finding.cause),
                   finding.likelihood);
  }
  fmt::format_to(std::back_inserter(matrix.misses), "\n    {}\n", kinds_text(observe_link(link)));
}

}  // namespace

Matrix measure_matrix(std::uint64_t seed, std::uint64_t links, std::uint64_t clean) {
  Matrix matrix;
  for (std::size_t c = 0; c < cause_count; ++c) {
    const auto cause = static_cast<Cause>(c);
    const std::uint64_t number = cause == Cause::healthy ? clean : links;
    for (std::uint64_t i = 0; i < number; ++i) count(make_link(cause, seed + i), seed + i, matrix);
  }
  return matrix;
}

std::string matrix_text(const Matrix& matrix) {
  std::string text = "| true cause | captures | first | among two | taken for |\n";
  text += "|---|---:|---:|---:|---|\n";
  for (std::size_t c = 0; c < cause_count; ++c) {
    std::string others;
    for (std::size_t other = 0; other < cause_count; ++other) {
      if (other == c || matrix.first[c][other] == 0) continue;
      fmt::format_to(std::back_inserter(others), "{}`{}` {}", others.empty() ? "" : ", ",
                     name_of(static_cast<Cause>(other)), matrix.first[c][other]);
    }
    fmt::format_to(std::back_inserter(text), "| `{}` | {} | {} | {} | {} |\n",
                   name_of(static_cast<Cause>(c)), matrix.links[c],
                   matrix.right(static_cast<Cause>(c)), matrix.among_two[c], others);
  }
  return text;
}

}  // namespace biss::explain::test
