// The one file with CLI11, which splits the command line into the values of the options.
#include <CLI/CLI.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <new>
#include <utility>

#include "cli/common/declared.hpp"
#include "cli/common/help.hpp"
#include "cli/common/program.hpp"
#include "cli/common/verb.hpp"
#include "device/nearest.hpp"

namespace biss::cli {

struct HelpOptions {
  std::vector<std::string> verb;
  std::string to = "text";
  std::string output{};
};

// What is wrong with the words of a command line before any value is read.
struct WrongWords {
  std::string missing_value{};
  std::string unexpected{};
  /// Words that the verb does not take.
  std::vector<std::string> further{};
  std::string empty_option{};
};

namespace {

std::string one_line(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

std::vector<std::string> option_names(const DeclaredVerb& verb) {
  std::vector<std::string> names;
  for (const DeclaredOption& option : verb.options) {
    if (!option.is_argument()) names.push_back(option.name());
  }
  return names;
}

// The command, the verb that was chosen, and the one below it where it has some.
std::vector<const DeclaredVerb*> chosen_verbs(const DeclaredVerb& command) {
  std::vector<const DeclaredVerb*> chosen{&command};
  for (bool found = true; found;) {
    const auto& verbs = chosen.back()->verbs;
    const auto below = std::find_if(verbs.begin(), verbs.end(),
                                    [](const DeclaredVerb& each) { return each.parsed; });
    found = below != verbs.end();
    if (found) chosen.push_back(&*below);
  }
  return chosen;
}

void declare(CLI::App& app, const DeclaredVerb& verb) {
  app.set_help_flag();
  app.require_subcommand(0, 1);
  for (const DeclaredOption& option : verb.options) {
    if (option.is_flag()) {
      app.add_flag(option.names);
      continue;
    }
    CLI::Option* const added = app.add_option(option.names);
    added->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)->delimiter(option.delimiter);
    if (option.repeats) added->expected(CLI::detail::expected_max_vector_size);
    // An option takes one value each time that it is given: the next word may be an argument.
    added->allow_extra_args(option.repeats && option.is_argument());
  }
  for (const DeclaredVerb& below : verb.verbs) {
    declare(*app.add_subcommand(below.text.name), below);
  }
}

void take_values(const CLI::App& app, DeclaredVerb& verb) {
  verb.parsed = app.parsed();
  auto option = verb.options.begin();
  for (const CLI::Option* each : app.get_options()) {
    option->given = each->results();
    for (std::string& value : option->given) {
      bool is = false;
      if (option->is_flag() && CLI::detail::lexical_cast(value, is)) value = is ? "true" : "false";
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
    return fmt::format("{}: {}", word.substr(0, word.size() - 1), empty_value);
  }
  return {};
}

// The verbs below a verb or the command.
std::vector<std::string> verb_names(const DeclaredVerb& verb) {
  std::vector<std::string> names;
  for (const DeclaredVerb& below : verb.verbs) names.push_back(below.text.name);
  return names;
}

std::string unknown_verb_text(const std::string& name, const std::vector<std::string>& verbs) {
  const std::string meant = nearest(name, verbs);
  return meant.empty() ? fmt::format("unknown verb '{}'", name)
                       : fmt::format("unknown verb '{}'; did you mean '{}'?", name, meant);
}

ExitStatus print(Host& host, const std::string& text, const std::string& path = "-") {
  Output output(host);
  const bool good = output.open(path) && output.write(text) && output.finish();
  return good ? ExitStatus::done : output.status();
}

OptionHelp help_of(const DeclaredOption& option) {
  OptionHelp help{.name = option.names,
                  .value = option.value,
                  .text = option.meaning,
                  .heading = option.heading,
                  .required = option.required};
  if (option.is_argument()) {
    help.name += option.repeats ? "..." : "";
    help.value.clear();
    help.heading.clear();
  } else if (const std::size_t comma = help.name.find(','); comma != std::string::npos) {
    help.name.insert(comma + 1, " ");
  }
  return help;
}

VerbHelp help_of(const DeclaredVerb& verb, const std::string& above = {}) {
  VerbHelp help;
  help.name = above + verb.text.name;
  help.purpose = verb.text.purpose;
  help.examples = verb.text.examples;
  for (const DeclaredOption& option : verb.options) help.options.push_back(help_of(option));
  for (const DeclaredVerb& below : verb.verbs) {
    help.verbs.push_back(help_of(below, help.name + ' '));
    const std::vector<std::string>& examples = below.text.examples;
    if (above.empty() && !examples.empty()) help.examples.push_back(examples.front());
  }
  return help;
}

// The verb of that name below a verb; null if there is none.
const VerbHelp* below(const VerbHelp& verb, const std::string& name) {
  const auto found = std::find_if(verb.verbs.begin(), verb.verbs.end(), [&](const VerbHelp& each) {
    return each.name == verb.name + ' ' + name;
  });
  return found == verb.verbs.end() ? nullptr : &*found;
}

// The files that the command line names, and standard output, which every verb may use.
std::vector<NamedFile> named_files(const std::vector<const DeclaredVerb*>& verbs) {
  std::vector<NamedFile> files;
  for (const DeclaredVerb* verb : verbs) {
    for (const DeclaredOption& option : verb->options) {
      if (!option.file) continue;
      for (const std::string& value : option.given) {
        const std::string path = option.path_of == nullptr ? value : option.path_of(value);
        if (!path.empty()) files.push_back({option.name(), path, *option.file});
      }
    }
  }
  const auto is_stdout = [](const NamedFile& file) {
    return file.use != FileUse::read && file.path == "-";
  };
  if (std::none_of(files.begin(), files.end(), is_stdout)) {
    files.push_back({"standard output", "-", FileUse::write});
  }
  return files;
}

// The names of the verbs below the command.
std::vector<std::string> names_of(const std::vector<const DeclaredVerb*>& verbs) {
  std::vector<std::string> names;
  for (std::size_t i = 1; i < verbs.size(); ++i) names.push_back(verbs[i]->text.name);
  return names;
}

std::string usage_text(const DeclaredVerb& verb, const WrongWords& words, const std::string& text) {
  if (words.further.empty()) return verb.needs_verb() ? "no verb given" : text;
  const std::string& extra = words.further.front();
  if (!extra.starts_with('-')) {
    return verb.verbs.empty() ? fmt::format("unexpected argument '{}'", extra)
                              : unknown_verb_text(extra, verb_names(verb));
  }
  const std::string name = extra.substr(0, extra.find('='));
  const std::string meant = nearest(name, option_names(verb));
  return meant.empty() ? fmt::format("unknown option '{}'", name)
                       : fmt::format("unknown option '{}'; did you mean '{}'?", name, meant);
}

VerbText help_verb() {
  return {.name = "help",
          .purpose = "Print the help of a verb, or all of it as a manual page",
          .examples = {"biss help decode", "biss help eds show", "biss help --to man -o biss.1"}};
}

void declare_help(Verb verb, HelpOptions& options) {
  verb.add_option("VERB", options.verb,
                  "Verb whose help is printed; by default the help of biss itself");
  add_name_option(verb, "--to", options.to, {"text", "man", "bash"},
                  "A verb's help (the default), the manual page, or a completion script for bash");
  add_output_option(verb, options.output);
}

}  // namespace

Command::Command(Host& host)
    : host_(host),
      root_(std::make_unique<DeclaredVerb>(DeclaredVerb{
          .text = {.name = "biss",
                   .purpose = "Read, simulate and judge encoders with the BiSS C interface",
                   .examples = {}}})) {
  Verb(root_.get()).add_help_flag();
  Verb(root_.get()).add_flag("-V,--version", version_, "Print the version and the commit");
}

Command::~Command() = default;

Verb Command::add_verb(const VerbText& text, Run run) {
  return Verb(root_.get()).add_verb(text, std::move(run));
}

ExitStatus Command::print_help(const HelpOptions& options) const {
  const VerbHelp command = help_of(*root_);
  if (options.to == "man") return print(host_, man_page(command, BISS_VERSION), options.output);
  if (options.to == "bash") return print(host_, bash_completion(command), options.output);
  const VerbHelp* verb = &command;
  for (const std::string& name : options.verb) {
    const VerbHelp* const next = below(*verb, name);
    if (next == nullptr) {
      std::vector<std::string> names;
      for (const VerbHelp& each : verb->verbs) {
        names.push_back(each.name.substr(verb->name.size() + 1));
      }
      return host_.fail(ExitStatus::usage, fmt::format("{} (see '{} --help')",
                                                       unknown_verb_text(name, names), verb->name));
    }
    verb = next;
  }
  return print(host_, help_text(*verb), options.output);
}

ExitStatus Command::run(int argc, const char* const* argv) {
  try {
    return parse_and_run(argc, argv);
  } catch (const std::bad_alloc&) {
    return host_.fail(ExitStatus::io, "out of memory");
  } catch (const std::exception& error) {
    return host_.fail(ExitStatus::io, fmt::format("stopped by an error inside: {}", error.what()));
  } catch (...) {
    return host_.fail(ExitStatus::io, "stopped by an error inside");
  }
}

ExitStatus Command::parse_and_run(int argc, const char* const* argv) {
  // Last, so that the help lists it last.
  if (root_->verbs.empty() || root_->verbs.back().text.name != "help") {
    const auto options = std::make_shared<HelpOptions>();
    declare_help(
        add_verb(help_verb(), [this, options](Host& /*host*/) { return print_help(*options); }),
        *options);
  }
  if (argc < 2) return wrong_usage("no verb given");
  const std::string first = argv[1];
  const std::vector<std::string> names = verb_names(*root_);
  const bool known = std::find(names.begin(), names.end(), first) != names.end();
  if (!known && !first.starts_with('-')) return wrong_usage(unknown_verb_text(first, names));

  CLI::App app("", "biss");
  declare(app, *root_);
  WrongWords wrong{.empty_option = empty_option(argc, argv)};
  try {
    app.parse(argc, argv);
  } catch (const CLI::ExtrasError& error) {
    wrong.unexpected = error.what();
  } catch (const CLI::ParseError& error) {
    const std::string text = error.what();
    wrong.missing_value = text.substr(0, text.find(':')) + " needs a value";
  }
  take_values(app, *root_);
  const CLI::App* chosen = &app;
  while (!chosen->get_subcommands().empty()) chosen = chosen->get_subcommands().front();
  wrong.further = chosen->remaining();
  return run_given(wrong);
}

ExitStatus Command::run_given(const WrongWords& words) {
  const std::vector<const DeclaredVerb*> verbs = chosen_verbs(*root_);
  version_ = false;
  try {
    if (!words.missing_value.empty()) throw WrongUsage(words.missing_value);
    bool asks_help = false;
    for (const DeclaredVerb* verb : verbs) {
      set_given(*verb);
      if (version_) return print(host_, program_text() + "\n");
      asks_help = asks_help || !verb->options.front().given.empty();
    }
    if (asks_help) return print_help({.verb = names_of(verbs)});
    for (const DeclaredVerb* verb : verbs) check_given(*verb);
    if (!words.unexpected.empty()) throw WrongUsage(words.unexpected);
    for (const DeclaredVerb* verb : verbs) {
      for (const auto& check : verb->checks) check();
    }
    if (!words.empty_option.empty()) throw WrongUsage(words.empty_option);
  } catch (const WrongUsage& error) {
    return wrong_usage(words.empty_option.empty() ? usage_text(*verbs.back(), words, error.what())
                                                  : words.empty_option);
  }
  const std::string conflict = file_conflict(named_files(verbs), host_);
  if (!conflict.empty()) return wrong_usage(conflict);
  const auto runs = std::find_if(verbs.rbegin(), verbs.rend(),
                                 [](const DeclaredVerb* verb) { return bool(verb->run); });
  return (*runs)->run(host_);
}

ExitStatus Command::wrong_usage(const std::string& what) const {
  std::string verbs;
  for (const std::string& name : names_of(chosen_verbs(*root_))) verbs += name + ' ';
  return host_.fail(ExitStatus::usage,
                    fmt::format("{} (see 'biss {}--help')", one_line(what), verbs));
}

}  // namespace biss::cli
