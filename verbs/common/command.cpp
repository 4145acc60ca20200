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

std::string program_text() {
  const std::string_view commit = build_commit;
  return fmt::format("biss {}{}{}", BISS_VERSION, commit.empty() ? "" : " ", commit);
}

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
  for (const Option& option : verb.options) {
    if (!option.is_argument()) names.push_back(option.name());
  }
  return names;
}

// The command, the verb that was chosen, and the verb below it if it has any.
std::vector<const DeclaredVerb*> chosen_verbs(const DeclaredVerb& command) {
  std::vector<const DeclaredVerb*> chosen;
  const auto is_chosen = [](const DeclaredVerb& each) { return each.parsed; };
  for (const auto* verb = &command; verb != nullptr; verb = find_record(verb->verbs, is_chosen)) {
    chosen.push_back(verb);
  }
  return chosen;
}

// The verbs below a verb or the command.
std::vector<std::string> verb_names(const DeclaredVerb& verb) {
  std::vector<std::string> names;
  for (const DeclaredVerb& below : verb.verbs) names.push_back(below.text.name);
  return names;
}

std::string unknown_text(std::string_view kind, const std::string& name,
                         const std::vector<std::string>& known) {
  const std::string meant = nearest(name, known);
  return fmt::format("unknown {} '{}'{}", kind, name,
                     meant.empty() ? "" : fmt::format("; did you mean '{}'?", meant));
}

// Removes the values of an earlier run.
void forget_given(DeclaredVerb& verb) {
  verb.parsed = false;
  for (Option& option : verb.options) option.given.clear();
  for (DeclaredVerb& below : verb.verbs) forget_given(below);
}

// Words that name the verb, then its arguments.
WrongWords take_given(DeclaredVerb& command, const std::vector<std::string>& words,
                      const GivenOptions& options) {
  const auto takes_argument = [](const Option& each) {
    return each.is_argument() && (each.repeats || each.given.empty());
  };
  WrongWords wrong;
  DeclaredVerb* verb = &command;
  for (const std::string& word : words) {
    if (DeclaredVerb* const below = find_named(verb->verbs, word)) {
      verb = below;
      verb->parsed = true;
    } else if (Option* const argument = find_record(verb->options, takes_argument)) {
      give(*argument, word);
    } else {
      wrong.further.push_back(word);
    }
  }
  for (const GivenOption& given : options) {
    const std::string& name = given.first;
    Option* const option = find_named(verb->options, name);
    if (option == nullptr) {
      wrong.further.push_back(name);
    } else if (!given.second.empty()) {
      for (const std::string& value : given.second) give(*option, value);
    } else if (option->is_flag()) {
      option->given.emplace_back("true");
    } else {
      wrong.missing_value = name + " needs a value";
    }
  }
  return wrong;
}

ExitStatus print(Host& host, const std::string& text, const std::string& path = "-") {
  return write_output(host, path, [&](Output& output) { return output.write(text); });
}

// The files that the command line names, and standard output, which every verb may use.
std::vector<NamedFile> named_files(const std::vector<const DeclaredVerb*>& verbs) {
  std::vector<NamedFile> files;
  for (const DeclaredVerb* verb : verbs) {
    for (const Option& option : verb->options) {
      if (!option.file_use) continue;
      for (const std::string& value : option.given) {
        const std::string path = option.path_of == nullptr ? value : option.path_of(value);
        if (!path.empty()) files.push_back({option.name(), path, *option.file_use});
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
  const std::vector<std::string> options = option_names(verb);
  // The name of an option is an argument after `--`.
  if (extra.starts_with('-') && nearest(name, options) != name) {
    return unknown_text("option", name, options);
  }
  return verb.verbs.empty() ? fmt::format("unexpected argument '{}'", extra)
                            : unknown_text("verb", extra, verb_names(verb));
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
  if (options.to == "man") return print(host_, man_page(*root_, BISS_VERSION), options.output);
  if (options.to == "bash") return print(host_, bash_completion(*root_), options.output);
  const DeclaredVerb* verb = root_.get();
  std::string path = verb->text.name;
  for (const std::string& name : options.verb) {
    const DeclaredVerb* const next = find_named(verb->verbs, name);
    if (next == nullptr) {
      return host_.fail(
          ExitStatus::usage,
          fmt::format("{} (see '{} --help')", unknown_text("verb", name, verb_names(*verb)), path));
    }
    verb = next;
    path += ' ' + name;
  }
  return print(host_, help_text(*verb, path), options.output);
}

void Command::add_help() {
  if (!root_->verbs.empty() && root_->verbs.back().text.name == "help") return;
  const auto options = std::make_shared<HelpOptions>();
  const Verb verb = add_verb(
      {.name = "help",
       .purpose = "Print the help of a verb, or all of it as a manual page",
       .examples = {"biss help decode", "biss help eds show", "biss help --to man -o biss.1"}},
      [this, options](Host& /*host*/) { return print_help(*options); });
  verb.add_option("VERB", options->verb,
                  "Verb whose help is printed; by default the help of biss itself");
  add_name_option(verb, "--to", options->to, {"text", "man", "bash"},
                  "A verb's help (the default), the manual page, or a completion script for bash");
  add_output_option(verb, options->output);
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
  } catch (const VerbError& error) {
    return host_.fail(error);
  } catch (const std::bad_alloc&) {
    return host_.fail(ExitStatus::io, "out of memory");
  } catch (const std::exception& error) {
    return host_.fail(ExitStatus::io,
                      fmt::format("stopped by an internal error: {}", error.what()));
  } catch (...) {
    return host_.fail(ExitStatus::io, "stopped by an internal error");
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
