#include "cli/command_line.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <string_view>

#include "verbs/common/declared.hpp"

namespace biss::cli {
namespace {

void declare(CLI::App& app, const verbs::DeclaredVerb& verb) {
  app.set_help_flag();
  app.require_subcommand(0, 1);
  for (const verbs::Option& option : verb.options) {
    if (option.is_flag()) {
      app.add_flag(option.names);
      continue;
    }
    CLI::Option* const added = app.add_option(option.names);
    added->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    if (option.repeats) added->expected(CLI::detail::expected_max_vector_size);
    // An option takes one value each time that it is given: the next word may be an argument.
    added->allow_extra_args(option.repeats && option.is_argument());
  }
  for (const verbs::DeclaredVerb& below : verb.verbs) {
    declare(*app.add_subcommand(below.text.name), below);
  }
}

void take_values(const CLI::App& app, verbs::DeclaredVerb& verb) {
  verb.parsed = app.parsed();
  auto option = verb.options.begin();
  for (const CLI::Option* each : app.get_options()) {
    for (std::string value : each->results()) {
      bool is = false;
      if (option->is_flag() && CLI::detail::lexical_cast(value, is)) value = is ? "true" : "false";
      give(*option, value);
    }
    ++option;
  }
  auto below = verb.verbs.begin();
  for (const CLI::App* each : app.get_subcommands({})) take_values(*each, *below++);
}

// CLI11 takes `--name=` for an option without a value, and the next word for the value.
std::string empty_option(int argc, const char* const* argv) {
  for (int i = 2; i < argc && std::string_view(argv[i]) != "--"; ++i) {
    const std::string word = argv[i];
    if (!word.starts_with("--") || word.find('=') != word.size() - 1) continue;
    return fmt::format("{}: {}", word.substr(0, word.size() - 1), verbs::empty_value);
  }
  return {};
}

}  // namespace

verbs::ExitStatus run_command_line(verbs::Command& command, int argc, const char* const* argv) {
  verbs::DeclaredVerb& verbs = command.declared();
  const auto is_first = [&](const verbs::DeclaredVerb& verb) { return verb.text.name == argv[1]; };
  if (argc > 1 && argv[1][0] != '-' &&
      std::none_of(verbs.verbs.begin(), verbs.verbs.end(), is_first)) {
    return command.run_given({.further = {argv[1]}});
  }
  CLI::App app("", "biss");
  bool extra = false;
  declare(app, verbs);
  verbs::WrongWords wrong{.empty_option = empty_option(argc, argv)};
  try {
    app.parse(argc, argv);
  } catch (const CLI::ExtrasError&) {
    extra = true;
  } catch (const CLI::ParseError& error) {
    const std::string text = error.what();
    wrong.missing_value = text.substr(0, text.find(':')) + " needs a value";
  }
  take_values(app, verbs);
  const CLI::App* chosen = &app;
  while (!chosen->get_subcommands().empty()) chosen = chosen->get_subcommands().front();
  wrong.further = chosen->remaining();
  if (extra && wrong.further.empty()) wrong.further = app.remaining(true);
  std::erase(wrong.further, "--");
  return command.run_given(wrong);
}

}  // namespace biss::cli
