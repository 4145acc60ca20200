// Finds the verb in the words of a command, gives it its options and runs it.
#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <new>
#include <utility>

#include "device/nearest.hpp"
#include "verbs/common/declared.hpp"
#include "verbs/common/help.hpp"
#include "verbs/common/program.hpp"
#include "verbs/common/verb.hpp"

namespace biss::verbs {

struct HelpOptions {
  std::vector<std::string> verb;
  std::string to = "text";
  std::string output{};
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

// The command, the verb that was chosen, and the verb below it if it has any.
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

// Removes the values of an earlier run.
void forget_given(DeclaredVerb& verb) {
  verb.parsed = false;
  for (DeclaredOption& option : verb.options) option.given.clear();
  for (DeclaredVerb& below : verb.verbs) forget_given(below);
}

DeclaredOption* option_of(DeclaredVerb& verb, const std::string& name) {
  const auto found = std::find_if(verb.options.begin(), verb.options.end(),
                                  [&](const DeclaredOption& each) { return each.name() == name; });
  return found == verb.options.end() ? nullptr : &*found;
}

// The argument that the next word is for; null if the verb takes no further argument.
DeclaredOption* next_argument(DeclaredVerb& verb) {
  const auto found =
      std::find_if(verb.options.begin(), verb.options.end(), [](const DeclaredOption& each) {
        return each.is_argument() && (each.repeats || each.given.empty());
      });
  return found == verb.options.end() ? nullptr : &*found;
}

// Words that name the verb, then its arguments.
WrongWords take_given(DeclaredVerb& command, const std::vector<std::string>& words,
                      const GivenOptions& options) {
  WrongWords wrong;
  DeclaredVerb* verb = &command;
  for (const std::string& word : words) {
    const auto below =
        std::find_if(verb->verbs.begin(), verb->verbs.end(),
                     [&](const DeclaredVerb& each) { return each.text.name == word; });
    if (below != verb->verbs.end()) {
      verb = &*below;
      verb->parsed = true;
    } else if (DeclaredOption* const argument = next_argument(*verb)) {
      give(*argument, word);
    } else {
      wrong.further.push_back(word);
    }
  }
  for (const auto& [name, values] : options) {
    DeclaredOption* const option = option_of(*verb, name);
    if (option == nullptr) {
      wrong.further.push_back(name);
    } else if (!values.empty()) {
      for (const std::string& value : values) give(*option, value);
    } else if (option->is_flag()) {
      option->given.emplace_back("true");
    } else {
      wrong.missing_value = name + " needs a value";
    }
  }
  return wrong;
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
  const std::string name = extra.substr(0, extra.find('='));
  const std::string meant = nearest(name, option_names(verb));
  // The name of an option is an argument after `--`.
  if (!extra.starts_with('-') || meant == name) {
    return verb.verbs.empty() ? fmt::format("unexpected argument '{}'", extra)
                              : unknown_verb_text(extra, verb_names(verb));
  }
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

void Command::add_help() {
  if (!root_->verbs.empty() && root_->verbs.back().text.name == "help") return;
  const auto options = std::make_shared<HelpOptions>();
  declare_help(
      add_verb(help_verb(), [this, options](Host& /*host*/) { return print_help(*options); }),
      *options);
}

DeclaredVerb& Command::declared() {
  add_help();
  forget_given(*root_);
  return *root_;
}

ExitStatus Command::run(const std::vector<std::string>& words, const GivenOptions& options) {
  return run_given(take_given(declared(), words, options));
}

ExitStatus Command::run_given(const WrongWords& words) {
  try {
    return check_and_run(words);
  } catch (const std::bad_alloc&) {
    return host_.fail(ExitStatus::io, "out of memory");
  } catch (const std::exception& error) {
    return host_.fail(ExitStatus::io, fmt::format("stopped by an error inside: {}", error.what()));
  } catch (...) {
    return host_.fail(ExitStatus::io, "stopped by an error inside");
  }
}

ExitStatus Command::check_and_run(const WrongWords& words) {
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
    if (!words.further.empty()) throw WrongUsage(words.further.front());
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

}  // namespace biss::verbs
