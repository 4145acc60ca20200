// The one file with CLI11; see verb.hpp.
#include <CLI/CLI.hpp>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <exception>
#include <new>
#include <numeric>
#include <utility>

#include "cli/common/verb.hpp"

namespace biss::cli {
namespace {

// Changes, insertions, deletions and swaps of neighbours that make one word of the other.
std::size_t typing_slips(const std::string& a, const std::string& b) {
  std::vector<std::size_t> before(b.size() + 1);
  std::vector<std::size_t> last(b.size() + 1);
  std::vector<std::size_t> now(b.size() + 1);
  std::iota(last.begin(), last.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    now[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t change = last[j - 1] + (a[i - 1] == b[j - 1] ? 0U : 1U);
      now[j] = std::min({change, last[j] + 1, now[j - 1] + 1});
      const bool swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
      if (swapped) now[j] = std::min(now[j], before[j - 2] + 1);
    }
    std::swap(before, last);
    std::swap(last, now);
  }
  return last[b.size()];
}

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

// Of the verbs below a verb, or of the command.
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

ExitStatus print(const std::string& text) {
  Output output;
  const bool good = output.open("-") && output.write(text) && output.finish();
  return good ? ExitStatus::done : output.status();
}

}  // namespace

std::string nearest(const std::string& name, const std::vector<std::string>& candidates) {
  constexpr std::size_t longest_name = 64;
  if (name.size() > longest_name) return {};
  std::size_t fewest = std::max<std::size_t>(1, name.size() / 3);
  std::string best;
  for (const std::string& candidate : candidates) {
    const bool shortened = name.size() >= 3 && candidate.starts_with(name);
    const std::size_t slips = shortened ? 1 : typing_slips(name, candidate);
    if (slips > fewest || (slips == fewest && !best.empty())) continue;
    fewest = slips;
    best = candidate;
  }
  return best;
}

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

Option Option::one_value_each() {
  option_->allow_extra_args(false);
  return *this;
}

Option Option::one_of(const std::vector<std::string>& values) {
  option_->check(CLI::IsMember(values));
  return *this;
}

Option Option::on_given(std::function<void()> given) {
  option_->each([given = std::move(given)](const std::string&) { given(); });
  return *this;
}

std::string Option::name() const { return option_->get_name(); }

bool Option::given() const { return option_->count() != 0; }

Option Verb::add_option(const std::string& name, std::string& target,
                        const std::string& description) {
  return Option(app_->add_option(name, target, description));
}

Option Verb::add_option(const std::string& name, std::vector<std::string>& target,
                        const std::string& description) {
  return Option(app_->add_option(name, target, description));
}

Option Verb::add_option(const std::string& name, std::vector<double>& target,
                        const std::string& description) {
  return Option(app_->add_option(name, target, description));
}

Option Verb::add_option(const std::string& name, std::vector<std::uint64_t>& target,
                        const std::string& description) {
  return Option(app_->add_option(name, target, description));
}

Option Verb::add_option(const std::string& name, std::int64_t& target,
                        const std::string& description) {
  return Option(app_->add_option(name, target, description));
}

Option Verb::add_flag(const std::string& name, bool& target, const std::string& description) {
  return Option(app_->add_flag(name, target, description));
}

Option Verb::add_text_option(const std::string& name, std::function<void(const std::string&)> set,
                             const std::string& description) {
  return Option(app_->add_option_function(name, std::move(set), description));
}

Option Verb::get_option(const std::string& name) const { return Option(app_->get_option(name)); }

std::vector<Option> Verb::given_options() const {
  std::vector<Option> given;
  for (CLI::Option* option : app_->get_options()) {
    if (option->count() != 0) given.emplace_back(option);
  }
  return given;
}

Verb Verb::add_verb(const VerbText& text) {
  CLI::App* verb = app_->add_subcommand(text.name, text.purpose);
  verb->group("Verbs");
  if (!text.examples.empty()) {
    verb->footer(fmt::format("{}:\n  {}", text.examples.size() == 1 ? "Example" : "Examples",
                             fmt::join(text.examples, "\n  ")));
  }
  return Verb(verb);
}

bool Verb::parsed() const { return app_->parsed(); }

void wrong_value(const std::string& name, const std::string& why) {
  throw CLI::ValidationError(name, why);
}

void add_verb_group(Command& command, const VerbText& group, const std::vector<GroupVerb>& verbs) {
  const auto runs = std::make_shared<std::vector<std::pair<Verb, Run>>>();
  Verb above = command.add_verb(group, [runs, name = group.name] {
    for (const auto& [verb, run] : *runs) {
      if (verb.parsed()) return run();
    }
    return fail(ExitStatus::usage,
                fmt::format("no verb of {} given (see 'biss {} --help')", name, name));
  });
  above.app().require_subcommand(1);
  for (const GroupVerb& each : verbs) {
    const Verb below = above.add_verb(each.text);
    runs->emplace_back(below, each.add(below));
  }
}

Command::Command()
    : app_(std::make_unique<CLI::App>("The open toolkit for the BiSS C encoder interface.",
                                      "biss")) {
  app_->set_help_flag("-h,--help", "Print this help");
  app_->set_version_flag("--version", "biss " BISS_VERSION, "Print the version");
  app_->require_subcommand(1);
  app_->get_formatter()->label("SUBCOMMAND", "VERB");
  app_->get_formatter()->column_width(28);
}

Command::~Command() = default;

Verb Command::add_verb(const VerbText& text, Run run) {
  const Verb verb = Verb(app_.get()).add_verb(text);
  if (!text.examples.empty()) examples_ += "\n  " + text.examples.front();
  app_->footer("Examples:" + examples_ + "\n\nRun 'biss VERB --help' for the options of a verb.");
  verbs_.push_back({&verb.app(), std::move(run)});
  return verb;
}

ExitStatus Command::run(int argc, const char* const* argv) {
  try {
    return parse_and_run(argc, argv);
  } catch (const std::bad_alloc&) {
    return fail(ExitStatus::io, "out of memory");
  } catch (const std::exception& error) {
    return fail(ExitStatus::io, fmt::format("stopped by an error inside: {}", error.what()));
  } catch (...) {
    return fail(ExitStatus::io, "stopped by an error inside");
  }
}

ExitStatus Command::parse_and_run(int argc, const char* const* argv) {
  if (argc < 2) return wrong_usage("no verb given");
  const std::string first = argv[1];
  const bool known = std::any_of(verbs_.begin(), verbs_.end(), [&first](const Entry& entry) {
    return entry.app->get_name() == first;
  });
  if (!known && !first.starts_with('-')) return unknown_verb(first);
  try {
    app_->parse(argc, argv);
  } catch (const CLI::CallForHelp&) {
    return print(app_->help());
  } catch (const CLI::CallForVersion& version) {
    return print(std::string(version.what()) + "\n");
  } catch (const CLI::ParseError& error) {
    return wrong_usage(usage_text(error));
  }
  for (const Entry& entry : verbs_) {
    if (entry.app->parsed()) return entry.run();
  }
  return wrong_usage("no verb given");
}

ExitStatus Command::unknown_verb(const std::string& name) const {
  return wrong_usage(unknown_verb_text(name, verb_names(*app_)));
}

ExitStatus Command::wrong_usage(const std::string& what) const {
  std::string verb;
  for (const CLI::App* chosen : chosen_verbs(*app_)) verb += chosen->get_name() + " ";
  return fail(ExitStatus::usage, fmt::format("{} (see 'biss {}--help')", one_line(what), verb));
}

std::string Command::usage_text(const CLI::ParseError& error) const {
  const auto chosen = chosen_verbs(*app_);
  const CLI::App& app = chosen.empty() ? *app_ : *chosen.back();
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
