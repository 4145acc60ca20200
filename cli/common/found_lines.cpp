#include "cli/common/found_lines.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

namespace biss::cli {

namespace {

bool is_wrong_usage(decode::LineProblem problem) {
  return problem == decode::LineProblem::no_such_ma ||
         problem == decode::LineProblem::no_such_slo || problem == decode::LineProblem::same_line;
}

std::string text_of(decode::LineProblem problem, const CaptureInput& input, const std::string& ma,
                    const std::string& slo) {
  const auto& lines = input.lines();
  const auto shown = static_cast<std::ptrdiff_t>(std::min<std::size_t>(lines.size(), 12));
  const std::string names =
      fmt::format("{}", fmt::join(lines.begin(), lines.begin() + shown, ", "));
  switch (problem) {
    case decode::LineProblem::no_such_ma:
      return fmt::format("--ma: no line '{}' in {}; it has {}", ma, input.name(), names);
    case decode::LineProblem::no_such_slo:
      return fmt::format("--slo: no line '{}' in {}; it has {}", slo, input.name(), names);
    case decode::LineProblem::same_line:
      return "MA and SLO cannot be the same line; name both with --ma and --slo";
    case decode::LineProblem::too_few_lines:
      return fmt::format("{}: fewer than two lines change; MA and SLO are needed", input.name());
    case decode::LineProblem::nothing_behaves:
      return fmt::format(
          "{}: no pair of lines behaves like MA and SLO; it has {}; name them with --ma and --slo",
          input.name(), names);
  }
  return {};
}

}  // namespace

LinesFound find_capture_lines(CaptureInput& input, const std::string& ma, const std::string& slo,
                              const decode::CycleReader& reader) {
  LinesFound result;
  result.beginning = input.look_at_beginning(edges_at_beginning);
  const auto found =
      find_lines(input.lines(), result.beginning, input.line_of(ma), input.line_of(slo), reader);
  if (found.ok()) {
    result.found = *found;
  } else if (!input.error().empty()) {
    result.status = ExitStatus::io;
    result.problem = input.error();
  } else {
    const bool usage = is_wrong_usage(found.error());
    result.status = usage ? ExitStatus::usage : ExitStatus::data_failed;
    result.problem = text_of(found.error(), input, ma, slo);
  }
  return result;
}

}  // namespace biss::cli
