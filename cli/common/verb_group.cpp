#include "cli/common/verb_group.hpp"

#include <fmt/format.h>

#include <memory>
#include <utility>

namespace biss::cli {

void add_verb_group(Command& command, const VerbText& group, const std::vector<GroupVerb>& verbs) {
  using Chosen = std::vector<std::pair<CLI::App*, Run>>;
  const auto runs = std::make_shared<Chosen>();
  CLI::App& app = command.add_verb(group, [runs, name = group.name] {
    for (const auto& [verb, run] : *runs) {
      if (verb->parsed()) return run();
    }
    return fail(ExitStatus::usage,
                fmt::format("no verb of {} given (see 'biss {} --help')", name, name));
  });
  app.require_subcommand(1);
  for (const GroupVerb& verb : verbs) {
    CLI::App* const below = app.add_subcommand(verb.text.name, verb.text.purpose);
    below->group("Verbs");
    std::string footer = "Examples:";
    for (const std::string& example : verb.text.examples) footer += "\n  " + example;
    below->footer(footer);
    runs->emplace_back(below, verb.add(*below));
  }
}

}  // namespace biss::cli
