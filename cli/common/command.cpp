// The one file with CLI11; see verb.hpp.
#include <CLI/CLI.hpp>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <exception>
#include <map>
#include <new>
#include <utility>

#include "cli/common/help.hpp"
#include "cli/common/program.hpp"
#include "cli/common/verb.hpp"
#include "device/nearest.hpp"

namespace biss::cli {

struct HelpOptions {
  std::vector<std::string> verb;
  std::string to = "text";
  std::string output;
};

// What the verbs have declared, in CLI11 and beside it.
struct Declarations {
  struct File {
    FileUse use;
    std::string (*path_of)(const std::string& value);
  };

  CLI::App app{"Read, simulate and judge encoders with the BiSS C interface", "biss"};
  std::map<const CLI::App*, std::vector<std::string>> examples;
  std::map<const CLI::Option*, File> files;
  std::vector<std::pair<const CLI::App*, Run>> runs;
  std::vector<std::pair<const CLI::App*, std::function<void()>>> checks;
};

namespace {

std::string one_line(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

std::vector<std::string> option_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  return names;
}

// The verb that was chosen, and the one below it where it has some; empty where none was.
std::vector<const CLI::App*> chosen_verbs(const CLI::App& app) {
  std::vector<const CLI::App*> chosen;
  for (auto below = app.get_subcommands(); !below.empty();) {
    chosen.push_back(below.front());
    below = chosen.back()->get_subcommands();
  }
  return chosen;
}

constexpr const char* empty_value = "empty; a value is needed";

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
std::vector<std::string> verb_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* below : app.get_subcommands({})) names.push_back(below->get_name());
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

OptionHelp help_of(const CLI::Option& option) {
  OptionHelp help;
  help.text = option.get_description();
  help.required = option.get_required();
  if (option.get_positional()) {
    const bool several = option.get_expected_max() > 1;
    help.name = option.get_name(true) + (several ? "..." : "");
    return help;
  }
  for (const std::string& name : option.get_snames()) help.name += '-' + name + ", ";
  for (const std::string& name : option.get_lnames()) help.name += "--" + name + ", ";
  help.name.resize(help.name.size() - 2);
  if (option.get_type_size() != 0) help.value = option.get_type_name();
  help.heading = option.get_group();
  return help;
}

VerbHelp help_of(const Declarations& declarations, const CLI::App& app, const std::string& path) {
  VerbHelp help;
  help.name = path;
  help.purpose = app.get_description();
  for (const CLI::Option* option : app.get_options()) help.options.push_back(help_of(*option));
  if (const auto found = declarations.examples.find(&app); found != declarations.examples.end()) {
    help.examples = found->second;
  }
  for (const CLI::App* below : app.get_subcommands({})) {
    help.verbs.push_back(help_of(declarations, *below, path + ' ' + below->get_name()));
    const VerbHelp& verb = help.verbs.back();
    const bool is_command = app.get_parent() == nullptr;
    if (is_command && !verb.examples.empty()) help.examples.push_back(verb.examples.front());
  }
  return help;
}

VerbHelp help_of(const Declarations& declarations) {
  return help_of(declarations, declarations.app, "biss");
}

// The verb of that name below a verb; null if there is none.
const VerbHelp* below(const VerbHelp& verb, const std::string& name) {
  const auto found = std::find_if(verb.verbs.begin(), verb.verbs.end(), [&](const VerbHelp& each) {
    return each.name == verb.name + ' ' + name;
  });
  return found == verb.verbs.end() ? nullptr : &*found;
}

// The files that the command line names, and standard output, which every verb may use.
std::vector<NamedFile> named_files(const Declarations& declarations) {
  std::vector<NamedFile> files;
  for (const CLI::App* app : chosen_verbs(declarations.app)) {
    for (const CLI::Option* option : app->get_options()) {
      const auto found = declarations.files.find(option);
      if (found == declarations.files.end()) continue;
      for (const std::string& value : option->results()) {
        const auto path_of = found->second.path_of;
        const std::string path = path_of == nullptr ? value : path_of(value);
        if (!path.empty()) files.push_back({option->get_name(), path, found->second.use});
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

Option Option::type_name(const std::string& name) {
  option_->type_name(name);
  return *this;
}

Option Option::required(bool is) {
  option_->required(is);
  return *this;
}

Option Option::group(const std::string& heading) {
  option_->group(heading);
  return *this;
}

Option Option::needs(const Option& other) {
  option_->needs(other.option_);
  return *this;
}

Option Option::excludes(const Option& other) {
  option_->excludes(other.option_);
  return *this;
}

Option Option::delimiter(char character) {
  option_->delimiter(character);
  return *this;
}

Option Option::one_of(const std::vector<std::string>& values) {
  option_->check([values](const std::string& text) -> std::string {
    const bool known = std::find(values.begin(), values.end(), text) != values.end();
    return known ? "" : fmt::format("'{}' is not one of {}", text, fmt::join(values, ", "));
  });
  return *this;
}

Option Option::file(FileUse use, std::string (*path_of)(const std::string& value)) {
  declarations_->files[option_] = {use, path_of};
  return *this;
}

Option Option::on_given(std::function<void()> given) {
  option_->each([given = std::move(given)](const std::string&) { given(); });
  return *this;
}

std::string Option::name() const { return option_->get_name(); }

bool Option::given() const { return option_->count() != 0; }

std::vector<std::string> Option::values() const { return option_->results(); }

Option Verb::add_option(const std::string& name, std::string& target,
                        const std::string& description) {
  return declared(app_->add_option(name, target, description));
}

Option Verb::add_option(const std::string& name, std::vector<std::string>& target,
                        const std::string& description) {
  return declared(app_->add_option(name, target, description));
}

Option Verb::add_option(const std::string& name, std::vector<double>& target,
                        const std::string& description) {
  return declared(app_->add_option(name, target, description));
}

Option Verb::add_option(const std::string& name, std::vector<std::uint64_t>& target,
                        const std::string& description) {
  return declared(app_->add_option(name, target, description));
}

Option Verb::add_option(const std::string& name, std::int64_t& target,
                        const std::string& description) {
  return declared(app_->add_option(name, target, description));
}

Option Verb::add_flag(const std::string& name, bool& target, const std::string& description) {
  return declared(app_->add_flag(name, target, description), false);
}

Option Verb::add_text_option(const std::string& name, std::function<void(const std::string&)> set,
                             const std::string& description) {
  return declared(app_->add_option_function(name, std::move(set), description));
}

Option Verb::add_repeated_option(const std::string& name,
                                 std::function<void(const std::string&)> set,
                                 const std::string& description) {
  const auto take = [set = std::move(set)](const std::vector<std::string>& values) {
    for (const std::string& value : values) set(value);
  };
  return declared(app_->add_option_function<std::vector<std::string>>(name, take, description));
}

Option Verb::declared(CLI::Option* option, bool is_value) const {
  option->group(heading_);
  if (is_value) {
    option->check(
        [](const std::string& text) -> std::string { return text.empty() ? empty_value : ""; });
    // An option takes one value each time that it is given: the next word may be an argument.
    if (!option->get_positional()) option->allow_extra_args(false);
  }
  return {option, declarations_};
}

void Verb::after_parsing(std::function<void()> check) const {
  declarations_->checks.emplace_back(app_, std::move(check));
}

Option Verb::get_option(const std::string& name) const {
  return {app_->get_option(name), declarations_};
}

std::vector<Option> Verb::given_options() const {
  std::vector<Option> given;
  for (CLI::Option* option : app_->get_options()) {
    if (option->count() != 0) given.emplace_back(option, declarations_);
  }
  return given;
}

Verb Verb::add_verb(const VerbText& text) {
  CLI::App* verb = app_->add_subcommand(text.name, text.purpose);
  declarations_->examples[verb] = text.examples;
  return {verb, declarations_};
}

bool Verb::parsed() const { return app_->parsed(); }

void wrong_value(const std::string& name, const std::string& why) {
  throw CLI::ValidationError(name, why);
}

void add_verb_group(Command& command, const VerbText& group, const std::vector<GroupVerb>& verbs) {
  const auto runs = std::make_shared<std::vector<std::pair<Verb, Run>>>();
  Verb above = command.add_verb(group, [runs, name = group.name](Host& host) {
    for (const auto& [verb, run] : *runs) {
      if (verb.parsed()) return run(host);
    }
    return host.fail(ExitStatus::usage,
                     fmt::format("no verb of {} given (see 'biss {} --help')", name, name));
  });
  above.app().require_subcommand(1);
  for (const GroupVerb& each : verbs) {
    const Verb below = above.add_verb(each.text);
    runs->emplace_back(below, each.add(below));
  }
}

Command::Command(Host& host) : host_(host), declarations_(std::make_unique<Declarations>()) {
  CLI::App& app = declarations_->app;
  app.set_help_flag("-h,--help", "Print this help");
  app.set_version_flag("-V,--version", program_text(), "Print the version and the commit");
  app.require_subcommand(1);
}

Command::~Command() = default;

Verb Command::add_verb(const VerbText& text, Run run) {
  const Verb verb = Verb(&declarations_->app, declarations_.get()).add_verb(text);
  declarations_->runs.emplace_back(&verb.app(), std::move(run));
  return verb;
}

ExitStatus Command::print_help(const HelpOptions& options) const {
  const VerbHelp command = help_of(*declarations_);
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
  CLI::App& app = declarations_->app;
  // Last, so that the help lists it last.
  if (below(help_of(*declarations_), "help") == nullptr) {
    const auto options = std::make_shared<HelpOptions>();
    declare_help(
        add_verb(help_verb(), [this, options](Host& /*host*/) { return print_help(*options); }),
        *options);
  }
  if (argc < 2) return wrong_usage("no verb given");
  const std::string first = argv[1];
  const std::vector<std::string> names = verb_names(app);
  const bool known = std::find(names.begin(), names.end(), first) != names.end();
  if (!known && !first.starts_with('-')) return unknown_verb(first);
  try {
    app.parse(argc, argv);
    for (const auto& [verb, check] : declarations_->checks) {
      if (verb->parsed()) check();
    }
  } catch (const CLI::CallForHelp&) {
    const VerbHelp command = help_of(*declarations_);
    const VerbHelp* verb = &command;
    for (const CLI::App* chosen : chosen_verbs(app)) verb = below(*verb, chosen->get_name());
    return print(host_, help_text(*verb));
  } catch (const CLI::CallForVersion& version) {
    return print(host_, std::string(version.what()) + "\n");
  } catch (const CLI::ParseError& error) {
    const std::string empty = empty_option(argc, argv);
    return wrong_usage(empty.empty() ? usage_text(error) : empty);
  }
  if (const std::string empty = empty_option(argc, argv); !empty.empty()) return wrong_usage(empty);
  const std::string conflict = file_conflict(named_files(*declarations_), host_);
  if (!conflict.empty()) return wrong_usage(conflict);
  for (const auto& [verb, run] : declarations_->runs) {
    if (verb->parsed()) return run(host_);
  }
  return wrong_usage("no verb given");
}

ExitStatus Command::unknown_verb(const std::string& name) const {
  return wrong_usage(unknown_verb_text(name, verb_names(declarations_->app)));
}

ExitStatus Command::wrong_usage(const std::string& what) const {
  std::string verb;
  for (const CLI::App* chosen : chosen_verbs(declarations_->app)) verb += chosen->get_name() + " ";
  return host_.fail(ExitStatus::usage,
                    fmt::format("{} (see 'biss {}--help')", one_line(what), verb));
}

std::string Command::usage_text(const CLI::ParseError& error) const {
  const auto chosen = chosen_verbs(declarations_->app);
  const CLI::App& app = chosen.empty() ? declarations_->app : *chosen.back();
  const std::vector<std::string> extras = app.remaining();
  if (!extras.empty()) {
    const std::string& extra = extras.front();
    const auto below = verb_names(app);
    if (!extra.starts_with('-') && !below.empty()) return unknown_verb_text(extra, below);
    if (!extra.starts_with('-')) return fmt::format("unexpected argument '{}'", extra);
    const std::string name = extra.substr(0, extra.find('='));
    const std::string meant = nearest(name, option_names(app));
    return meant.empty() ? fmt::format("unknown option '{}'", name)
                         : fmt::format("unknown option '{}'; did you mean '{}'?", name, meant);
  }
  if (app.get_require_subcommand_min() != 0) return "no verb given";
  const std::string text = error.what();
  if (dynamic_cast<const CLI::ArgumentMismatch*>(&error) == nullptr) return text;
  const bool repeated = text.find("At Most") != std::string::npos;
  return text.substr(0, text.find(':')) +
         (repeated ? " is given more than once" : " needs a value");
}

}  // namespace biss::cli
