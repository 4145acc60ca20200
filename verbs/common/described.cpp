// Describes a command, its verbs and their options as JSON.
#include <array>
#include <nlohmann/json.hpp>

#include "verbs/common/declared.hpp"

namespace biss::verbs {
namespace {

constexpr std::array<const char*, 5> scope_names{"reading", "file", "judging", "rows", "command"};

nlohmann::json json_of(const DeclaredVerb& verb) {
  nlohmann::json options = nlohmann::json::array();
  for (const DeclaredOption& option : verb.options) {
    options.push_back({{"names", option.names},
                       {"name", option.name()},
                       {"value", option.value},
                       {"meaning", option.meaning},
                       {"heading", option.heading},
                       {"scope", scope_names[static_cast<std::size_t>(option.scope)]},
                       {"repeats", option.repeats},
                       {"required", option.required},
                       {"choices", option.choices}});
  }
  nlohmann::json below = nlohmann::json::array();
  for (const DeclaredVerb& each : verb.verbs) below.push_back(json_of(each));
  return {{"name", verb.text.name}, {"options", options}, {"verbs", below}};
}

}  // namespace

std::string described(const DeclaredVerb& verb) { return json_of(verb).dump(); }

}  // namespace biss::verbs
