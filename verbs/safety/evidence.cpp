// biss safety evidence: runs the safety verbs for one configuration and puts their tables, the
// commands and the hashes into a folder.
#include "verbs/safety/evidence.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>

#include "biss/frame/format_text.hpp"
#include "verbs/common/format_option.hpp"
#include "verbs/common/program.hpp"
#include "verbs/common/verb.hpp"
#include "verbs/safety/analysis.hpp"
#include "verbs/safety/safety.hpp"
#include "verbs/safety/setup_fields.hpp"

namespace biss::verbs {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::uint64_t most_frames = std::uint64_t{1} << 40U;
constexpr const char* configuration_name = "configuration.json";

struct VerbOptions {
  EvidenceOptions evidence;
  unsigned threads = 0;
  std::string folder;
  bool force = false;
  std::string checked;
};

Json version_json() {
  const std::string_view commit = build_commit;
  return {{"program", "biss"},
          {"version", BISS_VERSION},
          {"commit", commit.empty() ? Json() : Json(commit)},
          {"compiler", BISS_COMPILER},
          {"build_type", BISS_BUILD_TYPE}};
}

Json manifest_json(const std::vector<std::string>& made_by,
                   const std::vector<EvidenceCommand>& commands) {
  Json list = Json::array();
  for (const EvidenceCommand& each : commands) {
    list.push_back({{"file", each.file}, {"arguments", each.arguments}, {"status", each.status}});
  }
  return {{"made_by", made_by}, {"commands", list}};
}

// The shortest text that selects this monitor in the other verbs.
std::string format_argument(const EvidenceSubject& subject) {
  for (const std::string& text : {subject.options.format, subject.configuration}) {
    const auto known = parse_safety_format(text);
    if (known && known->format == subject.monitored.format &&
        known->setup == subject.monitored.setup) {
      return text;
    }
  }
  return configuration_name;
}

struct Bundle {
  std::vector<EvidenceFile> files;
  /// Done, or data_failed: a result is not as expected.
  ExitStatus status = ExitStatus::done;
};

Bundle make_bundle(const EvidenceSubject& subject, const std::vector<std::string>& made_by,
                   unsigned threads, Host& host) {
  constexpr auto csv = report::Format::csv;
  const EvidenceOptions& options = subject.options;
  // As a command reads its -f.
  const std::string format = format_argument(subject);
  const SafetyFormat monitored =
      format == configuration_name ? subject.monitored : *parse_safety_format(format);
  const ExperimentOptions shared{
      .format = options.format, .seed = options.seed, .threads = threads};
  SafetyQuestion question;
  SafetyAnalysis analysis;
  LineResult line{};
  lab::CampaignState campaign_state{lab::CampaignPlan{}};
  std::vector<CampaignRow> campaign;
  std::vector<lab::SequenceResult> sequences;
  // In the order of evidence_commands().
  const std::function<ExitStatus(std::string&)> experiments[] = {
      [&](std::string& text) {
        question = safety_question(monitored.format, {.rates = options.bit_error_rates,
                                                      .frame_rate = subject.rate,
                                                      .comparison = monitored.setup.comparison});
        analysis = analyse(question);
        warn_of_pair(analysis, host);
        text = analysis_jsonl(question, analysis);
        return ExitStatus::done;
      },
      [&](std::string& text) {
        warn_of_pair(analysis, host);
        text = analysis_text(question, analysis);
        return ExitStatus::done;
      },
      [&](std::string& text) {
        line = run_line_model(monitored, {shared, options.cycles, subject.rate}, host);
        text = text_of(line_table(line, options.cycles), csv);
        return judge_line(line, host);
      },
      [&](std::string& text) {
        const auto frame = lab::CampaignFrame::make(monitored.format, monitored.setup);
        if (!frame) throw wrong_format(shared.format);
        campaign_state = run_usual_campaign(*frame, options.frames, shared, host);
        campaign = campaign_rows(*frame, campaign_state);
        text = text_of(campaign_table(campaign, csv), csv);
        return judge_campaign(campaign, host);
      },
      [&](std::string& text) {
        sequences = run_sequence_plan(
            usual_sequences(monitored, options.frames, options.faults, shared.seed), shared, host);
        text = text_of(sequence_table(sequences, csv), csv);
        return judge_sequences(sequences, host);
      }};
  Bundle bundle;
  std::vector<EvidenceFile> tables;
  std::vector<EvidenceCommand> commands = evidence_commands(subject);
  for (std::size_t k = 0; k < commands.size(); ++k) {
    if (host.shows_progress()) host.print_summary(command_line(commands[k].arguments) + "\n");
    EvidenceFile& table = tables.emplace_back(EvidenceFile{commands[k].file, {}});
    const ExitStatus status = experiments[k](table.text);
    bundle.status = std::max(bundle.status, status);
    commands[k].status = static_cast<int>(status);
  }
  const std::vector<CoverageRow> coverage = coverage_of(monitored, line, campaign, sequences);
  bundle.files = {
      readme_file(subject, commands, coverage),
      {"version.json", version_json().dump(2) + "\n"},
      {"manifest.json", manifest_json(made_by, commands).dump(2) + "\n"},
      {configuration_name, configuration_json(subject.monitored, subject.configuration)}};
  std::move(tables.begin(), tables.end(), std::back_inserter(bundle.files));
  bundle.files.insert(bundle.files.end(),
                      {coverage_file(coverage),
                       matrix_file(),
                       {"safety.md", page_of_bundle(safety_page)},
                       {"safety-matrix.md", page_of_bundle(safety_matrix_page)}});
  return bundle;
}

// Information that the tables do not show.
void warn_of_choice(const EvidenceSubject& subject, Host& host) {
  const EvidenceOptions& options = subject.options;
  const SafetyFormat& monitored = subject.monitored;
  const auto named = choose_safety({}, options.format, monitored.format, {});
  if (options.setup.configuration.empty() && named && named->name != subject.configuration) {
    host.warn(
        fmt::format("a format given as text is monitored by the widths of its words; "
                    "-f {} is the configuration with these words",
                    named->name));
  }
  for (const std::string& each : not_run(options)) host.warn("nothing was run: " + each);
}

ExitStatus run_make(const VerbOptions& options, const std::vector<std::string>& made_by,
                    Host& host) {
  const EvidenceSubject subject = value_or_fail(choose_evidence(options.evidence));
  // Before the minutes that the commands take.
  check_target(options.folder, options.force);
  const Bundle bundle = make_bundle(subject, made_by, options.threads, host);
  warn_of_choice(subject, host);
  write_bundle(options.folder, bundle.files, options.force);
  host.print_summary(
      fmt::format("{}: {} files, see README.md in it\n", options.folder, bundle.files.size() + 1));
  return bundle.status;
}

// The options that the bundle was made with, read by the verb's own parser.
std::optional<EvidenceOptions> parse_made_by(const std::vector<std::string>& made_by, Host& host) {
  const auto options = std::make_shared<EvidenceOptions>();
  Command command(host);
  const Verb verb = command.add_verb(
      {.name = "evidence", .purpose = "Read manifest.json", .examples = {"biss evidence"}},
      [](Host& /*host*/) { return ExitStatus::done; });
  add_evidence_options(verb, *options);
  GivenOptions given;
  for (const std::string& each : made_by) {
    const std::size_t equals = std::min(each.find('='), each.size());
    auto& [name, values] = given.emplace_back(each.substr(0, equals), std::vector<std::string>());
    if (equals < each.size()) values.push_back(each.substr(equals + 1));
  }
  const ExitStatus status = command.run({"evidence"}, given);
  return status == ExitStatus::done ? std::optional(*options) : std::nullopt;
}

std::optional<std::vector<std::string>> read_made_by(const EvidenceFile* manifest) try {
  if (manifest == nullptr) return std::nullopt;
  auto made_by = Json::parse(manifest->text).at("made_by").get<std::vector<std::string>>();
  const auto is_option = [](const std::string& each) { return each.starts_with("--"); };
  if (!std::all_of(made_by.begin(), made_by.end(), is_option)) return std::nullopt;
  if (std::find(made_by.begin(), made_by.end(), "--help") != made_by.end()) return std::nullopt;
  return made_by;
} catch (const nlohmann::json::exception&) {
  return std::nullopt;
}

// Files that depend on the program and not on the configuration.
bool is_of_program(const std::string& name) {
  return name == "version.json" || name == "matrix.csv" || name == "safety.md" ||
         name == "safety-matrix.md";
}

ExitStatus run_check(const VerbOptions& options, Host& host) {
  const ReadBundle found = read_bundle(options.checked);
  for (const std::string& finding : found.findings) host.warn(finding);
  const auto made_by = read_made_by(found.find("manifest.json"));
  const auto asked = made_by ? parse_made_by(*made_by, host) : std::nullopt;
  const auto subject = asked ? choose_evidence(*asked) : tl::unexpected(std::string());
  if (!subject) {
    throw VerbError{ExitStatus::io,
                    fmt::format("'{}': manifest.json cannot be read as the options of a bundle",
                                options.checked)};
  }
  Bundle again;
  try {
    again = make_bundle(*subject, *made_by, options.threads, host);
  } catch (const VerbError& error) {
    throw VerbError{ExitStatus::io, error.text};
  }
  std::size_t same = 0;
  bool differs = !found.findings.empty();
  for (const EvidenceFile& file : again.files) {
    const EvidenceFile* before = found.find(file.name);
    if (before != nullptr && before->text == file.text) {
      ++same;
    } else if (before != nullptr && is_of_program(file.name)) {
      host.warn(file.name + ": from another build of the program");
    } else {
      differs = true;
      host.warn(file.name + (before != nullptr ? ": differs from the present output of its command"
                                               : ": missing, this program writes it"));
    }
  }
  host.print_summary(fmt::format("{}: {} of {} files are the same when made again\n",
                                 options.checked, same, again.files.size()));
  return differs ? ExitStatus::data_failed : again.status;
}

// The options that describe the bundle, in one form.
std::vector<std::string> made_by_of(const Verb& verb) {
  std::vector<std::string> made_by;
  for (const Option* each : verb.given_options()) {
    if (each->scope == Scope::command) continue;
    for (const std::string& value : each->given) made_by.push_back(each->name() + "=" + value);
  }
  std::sort(made_by.begin(), made_by.end());
  return made_by;
}

// For a command line: no space before the unit.
std::string typed(Hertz rate) {
  std::string text = text_of(rate);
  std::erase(text, ' ');
  return text;
}

}  // namespace

tl::expected<EvidenceSubject, std::string> choose_evidence(const EvidenceOptions& options) {
  const std::string& name = options.format;
  if (name.empty()) return tl::unexpected(std::string("--format is required"));
  const auto device = parse_device(name);
  const auto* named = find_safety_configuration(name);
  if (named == nullptr && !device) return tl::unexpected(device.error());
  const FrameFormat format = named != nullptr ? named->frame_format() : device->format;
  if (named == nullptr && !is_safety_format(format)) {
    return tl::unexpected(fmt::format(
        "'{}' is not the format of a control and a safety word; fs-36-28 is, or rxm", name));
  }
  // The setup is chosen twice: the configuration's shortest cycle is the default of the rate. As in
  // parse_safety_format(), only a name stands for a configuration.
  SafetyArguments alone;
  alone.configuration = options.setup.configuration;
  alone.by_widths = named == nullptr && device->entry == nullptr;
  const auto known = choose_safety(alone, name, format, {});
  if (!known) return tl::unexpected(known.error());
  const Hertz rate = options.rate.value_or(rate_of_cycle(known->setup));
  SafetyArguments arguments = options.setup;
  arguments.latch = true;
  arguments.by_widths = alone.by_widths;
  if (!arguments.shortest) {
    arguments.shortest = std::max(known->setup.frame_gap_min, shortest_gap(period_of(rate)));
  }
  const auto choice = choose_safety(arguments, name, format, period_of(rate));
  if (!choice) return tl::unexpected(choice.error());
  SafetySetup setup = choice->setup;
  if (options.missed == missed_names[1]) setup.counter.missed = MissedFrames::perhaps;
  if (options.ignore_turns) setup.comparison.multiturn = MultiturnRule::ignored;
  setup.budget = {static_cast<std::uint8_t>(options.budget), options.budget_window};
  if (options.budget != 0 && options.budget_window.count == 0) {
    setup.budget.window = setup.frame_gap_max * 64;
  }
  if (const auto mistake = check_safety(format, UnratedSafetySetup(setup))) {
    return tl::unexpected(
        *mistake == SafetySetupError::budget
            ? fmt::format("--budget: at most {} faults, in a --budget-window that is not shorter "
                          "than the watchdog time",
                          max_tolerated_faults)
            : "--ignore-turns: nothing is left to compare");
  }
  return EvidenceSubject{options, {format, setup, name}, choice->name, rate};
}

std::vector<EvidenceCommand> evidence_commands(const EvidenceSubject& subject) {
  const EvidenceOptions& options = subject.options;
  const std::string format = format_argument(subject);
  const SafetyComparison& comparison = subject.monitored.setup.comparison;
  std::vector<std::string> analyse{"safety", "analyse", "-f",
                                   std::string(format_text(subject.monitored.format).view())};
  const auto add = [&](const char* name, const std::string& value) {
    analyse.insert(analyse.end(), {name, value});
  };
  for (const std::string& rate : options.bit_error_rates) add("--ber", rate);
  add("--rate", typed(subject.rate));
  if (comparison.compare_bits != 0) add("--compare", std::to_string(comparison.compare_bits));
  if (comparison.tolerance_lsb != 1) add("--tolerance", std::to_string(comparison.tolerance_lsb));
  if (comparison.multiturn == MultiturnRule::ignored) analyse.emplace_back("--ignore-turns");
  std::vector<std::string> analyse_jsonl = analyse;
  analyse_jsonl.insert(analyse_jsonl.end(), {"--to", "jsonl"});
  const auto table = [&](const char* verb, const std::vector<std::string>& counts) {
    std::vector<std::string> arguments{"safety", verb, "-f", format};
    arguments.insert(arguments.end(), counts.begin(), counts.end());
    arguments.insert(arguments.end(), {"--seed", std::to_string(options.seed), "--to", "csv"});
    return EvidenceCommand{std::string(verb) + ".csv", arguments};
  };
  const std::string frames = std::to_string(options.frames);
  // The commands that can refuse an option come first.
  return {
      {"analysis.jsonl", analyse_jsonl},
      {"analysis.txt", analyse},
      table("line", {"--cycles", std::to_string(options.cycles), "--rate", typed(subject.rate)}),
      table("campaign", {"--frames", frames}),
      table("sequences", {"--frames", frames, "--faults", std::to_string(options.faults)})};
}

std::string command_line(const std::vector<std::string>& arguments) {
  std::string line = "biss";
  for (const std::string& each : arguments) {
    const bool plain = each.find_first_of(";,+") == std::string::npos;
    line += plain ? " " + each : " '" + each + "'";
  }
  return line;
}

void add_evidence_options(Verb verb, EvidenceOptions& options) {
  verb.add_option("-f,--format", options.format,
                  "Safety configuration, catalogue name, or the format of a control and a safety "
                  "word");
  add_count_option(verb, "--frames", into(options.frames),
                   "Frames of each fault of the campaign, and of each undamaged sequence; "
                   "10 million by default",
                   most_frames);
  add_count_option(verb, "--faults", into(options.faults),
                   "Faults of each kind in the sequences; 1 million by default", most_frames);
  add_count_option(
      verb, "--cycles", into(options.cycles),
      "Cycles of the line model for each kind of fault, one in 32 with the fault; 50000 by "
      "default",
      most_line_cycles);
  add_seed_option(verb, options.seed);
  verb.add_option("--ber", options.bit_error_rates,
                  "Bit error rate. May be repeated; 1e-2, 1e-3 and 1e-4 by default")
      .type_name("P");
  add_rate_option(verb, "--rate", into(options.rate),
                  "Requests per second; by default 1 / the configuration's shortest cycle");
  SafetyArguments& setup = options.setup;
  std::vector<std::string> names;
  for (const SafetyConfiguration& each : safety_configurations) names.emplace_back(each.name);
  add_name_option(verb, "--safety", setup.configuration, names,
                  "Safety configuration of the monitor; by default from the format");
  add_check_options(verb, setup);
  add_name_option(verb, "--missed", options.missed, {missed_names.begin(), missed_names.end()},
                  "Whether the encoder counts requests without a good frame; counted by default");
  verb.add_flag("--ignore-turns", options.ignore_turns, "Do not compare the turns");
  add_duration_option(verb, "--watchdog", into(setup.watchdog),
                      "Longest time between two good frames; 1.5 cycles by default");
  add_duration_option(
      verb, "--shortest-gap", into(setup.shortest),
      "Shortest time between two good frames; 0: not checked. By default a cycle less a 32nd, at "
      "least the shortest time of the configuration");
  add_count_option(verb, "--budget", into(options.budget),
                   "Faults that are tolerated within --budget-window; 0 by default", 255);
  add_duration_option(verb, "--budget-window", into(options.budget_window),
                      "Time window of --budget; by default 64 times the watchdog time");
}

Run add_safety_evidence(Verb verb) {
  const auto options = std::make_shared<VerbOptions>();
  add_evidence_options(verb, options->evidence);
  const Verb own = verb.scope(Scope::command);
  add_threads_option(own, options->threads);
  const Option& folder = own.add_option("-o,--output", options->folder,
                                        "Create this folder; it must be empty or not exist")
                             .type_name("DIR");
  own.add_flag("--force", options->force, "Replace an existing bundle").needs(folder);
  own.add_option("--check", options->checked,
                 "Check the hashes of a bundle, make it again and compare; the only other option "
                 "allowed is --threads")
      .type_name("DIR");
  return [options, verb](Host& host) {
    if (!options->checked.empty()) {
      for (const Option* each : verb.given_options()) {
        if (each->name() == "--check" || each->name() == "--threads") continue;
        throw wrong_usage("--check does not go with {}", each->name());
      }
      return run_check(*options, host);
    }
    if (options->folder.empty()) {
      throw wrong_usage("no folder given: -o DIR makes a bundle, --check DIR checks one");
    }
    return run_make(*options, made_by_of(verb), host);
  };
}

}  // namespace biss::verbs
