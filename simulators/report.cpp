#include "simulators/report.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "device/quantity.hpp"

namespace biss::simulators {

namespace {

constexpr std::size_t printed_mismatches = 10;

const char* name_of(Role role) { return role == Role::encoder ? "encoder" : "master"; }

std::string time_text(std::int64_t time_ps) { return biss::text_of(picoseconds(time_ps), 3); }

std::string mismatch_text(const Mismatch& one) {
  return fmt::format("  request {} at {}: {}: sent {}, read {}\n", one.request,
                     time_text(one.time_ps), one.what, one.sent, one.read);
}

// A line for each group: how many of its cases occurred, and the missing cases.
std::string coverage_text(const Coverage& coverage) {
  std::string text;
  const auto& cases = coverage.cases();
  for (std::size_t k = 0; k < cases.size();) {
    const std::string& group = cases[k].group;
    std::size_t all = 0;
    std::size_t hit = 0;
    std::string missed;
    for (; k < cases.size() && cases[k].group == group; ++k, ++all) {
      if (cases[k].hits != 0) {
        ++hit;
      } else {
        missed += fmt::format("{}{}", missed.empty() ? "; not: " : ", ", cases[k].name);
      }
    }
    text += fmt::format("  {}: {} of {}{}\n", group, hit, all, missed);
  }
  return text;
}

std::uint64_t failures_of(const Instances& instances, std::uint64_t errors) {
  for (const auto& instance : instances) errors += simulators::failures_of(*instance);
  return errors;
}

}  // namespace

std::uint64_t failures_of(const Instance& instance) {
  return instance.board().mismatches() + (instance.board().compared() == 0 ? 1U : 0U);
}

std::string report_text(const Instances& instances, std::uint64_t errors) {
  std::string text;
  for (const auto& owner : instances) {
    const Instance* instance = owner.get();
    const Scoreboard& board = instance->board();
    text += fmt::format("{} {}: {}\n", name_of(instance->role()), instance->name(),
                        instance->settings().format_text);
    text += fmt::format("  requests {}, compared {}, mismatches {}\n", instance->requests(),
                        board.compared(), board.mismatches());
    if (board.compared() == 0) text += "  nothing was compared\n";
    const auto& listed = board.listed();
    for (std::size_t k = 0; k < listed.size() && k < printed_mismatches; ++k) {
      text += mismatch_text(listed[k]);
    }
    text += coverage_text(instance->coverage());
  }
  if (errors != 0) text += fmt::format("wrong calls {}\n", errors);
  const std::uint64_t failures = failures_of(instances, errors);
  text += failures == 0 ? "passed\n" : fmt::format("FAILED: {}\n", failures);
  return text;
}

std::string report_json(const Instances& instances, std::uint64_t errors) {
  nlohmann::ordered_json report;
  report["failures"] = failures_of(instances, errors);
  report["wrong_calls"] = errors;
  report["instances"] = nlohmann::ordered_json::array();
  for (const auto& owner : instances) {
    const Instance* instance = owner.get();
    const Scoreboard& board = instance->board();
    nlohmann::ordered_json one{{"name", instance->name()},
                               {"role", name_of(instance->role())},
                               {"format", instance->settings().format_text},
                               {"requests", instance->requests()},
                               {"compared", board.compared()},
                               {"mismatches", board.mismatches()}};
    one["listed"] = nlohmann::ordered_json::array();
    for (const Mismatch& mismatch : board.listed()) {
      one["listed"].push_back({{"request", mismatch.request},
                               {"time_ps", mismatch.time_ps},
                               {"what", mismatch.what},
                               {"sent", mismatch.sent},
                               {"read", mismatch.read}});
    }
    const Coverage& coverage = instance->coverage();
    one["cases"] = coverage.cases().size();
    one["cases_hit"] = coverage.hit_count();
    one["coverage"] = nlohmann::ordered_json::array();
    for (const Case& tried : coverage.cases()) {
      one["coverage"].push_back(
          {{"group", tried.group}, {"case", tried.name}, {"hits", tried.hits}});
    }
    report["instances"].push_back(std::move(one));
  }
  // Names come from the simulation, in any encoding.
  return report.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

}  // namespace biss::simulators
