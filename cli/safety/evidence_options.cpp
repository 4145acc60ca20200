// The options of `biss safety evidence`: declared, kept in the bundle, and made a question of.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>

#include "biss/safety/configurations.hpp"
#include "cli/common/format_option.hpp"
#include "cli/common/verb.hpp"
#include "cli/safety/evidence.hpp"

namespace biss::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::uint64_t most_frames = std::uint64_t{1} << 40U;
constexpr std::uint64_t most_cycles = std::uint64_t{1} << 32U;
const std::vector<std::string> missed_names{"counted", "perhaps"};

template <class T>
Json json_of(const std::optional<T>& value) {
  return value ? Json(*value) : Json();
}

Json json_of(const std::optional<Picoseconds>& value) {
  return value ? Json(value->count) : Json();
}

// Of type_error where it is no whole number from 0: get() would make one of -1 or 0.5.
std::uint64_t count_in(const Json& json) { return json.get_ref<const Json::number_unsigned_t&>(); }

void read(const Json& json, std::optional<std::uint64_t>& value) {
  if (!json.is_null()) value = count_in(json);
}

void read(const Json& json, std::optional<Picoseconds>& value) {
  if (!json.is_null()) value = Picoseconds{static_cast<std::int64_t>(count_in(json))};
}

template <class Names>
bool is_known(const std::string& name, const Names& names) {
  return name.empty() || std::find(names.begin(), names.end(), name) != names.end();
}

bool is_duration(Picoseconds time) { return time.count >= 0 && time <= milliseconds(1'000'000); }

// What CLI11 refuses of a command line, a file may hold all the same.
bool is_sound(const EvidenceOptions& options) {
  const SafetyArguments& setup = options.setup;
  return options.frames <= most_frames && options.faults <= most_frames &&
         options.cycles <= most_cycles && is_known(setup.counter, counter_mode_names) &&
         is_known(options.missed, missed_names) && setup.compare_bits.value_or(0) <= 64 &&
         setup.tolerance.value_or(0) <= 255 && setup.start_frames.value_or(0) <= 255 &&
         is_duration(setup.watchdog.value_or(Picoseconds{})) &&
         is_duration(setup.shortest.value_or(Picoseconds{})) && options.budget <= 255 &&
         is_duration(options.budget_window) && options.rate.value_or(Hertz{1}).count != 0 &&
         (setup.configuration.empty() || find_safety_configuration(setup.configuration) != nullptr);
}

// A number like 1e-3, whatever the locale.
std::optional<double> parse_bit_error_rate(const std::string& text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return {};
  return value > 0 && value <= 0.5 ? std::optional(value) : std::nullopt;
}

std::string put_bit_error_rates(EvidenceQuestion& question) {
  for (const std::string& text : question.options.bit_error_rates) {
    const auto rate = parse_bit_error_rate(text);
    if (!rate) return fmt::format("--ber '{}': a number above 0, up to 0.5, is needed", text);
    question.bit_error_rates.push_back(*rate);
  }
  if (question.bit_error_rates.empty()) question.bit_error_rates = {1e-2, 1e-3, 1e-4};
  return {};
}

std::string put_format(EvidenceQuestion& question) {
  const std::string& name = question.options.format;
  if (name.empty()) return "--format is required";
  if (const auto* known = find_safety_configuration(name)) {
    question.format = known->frame_format();
    return {};
  }
  const DeviceChoice device = parse_device(name);
  if (!device) return device.error;
  question.format = device.device->format;
  if (is_safety_format(question.format)) return {};
  return fmt::format("'{}' is not the format of a control and a safety word; fs-36-28 is, or rxm",
                     name);
}

// The configuration's shortest cycle is the rate's default, so it is asked for twice.
std::string put_setup(EvidenceQuestion& question) {
  const EvidenceOptions& options = question.options;
  const std::string text = options.format;
  SafetyArguments alone;
  alone.configuration = options.setup.configuration;
  // As parse_safety_format(), and so `biss safety campaign`: only a name stands for a
  // configuration.
  const DeviceChoice device = parse_device(text);
  alone.by_widths =
      find_safety_configuration(text) == nullptr && device && device.device->entry == nullptr;
  const SafetyChoice known = choose_safety(alone, text, question.format, {});
  if (!known.setup) return known.error;
  const Picoseconds shortest = known.setup->cycle_min;
  question.rate = options.rate.value_or(
      Hertz{static_cast<std::uint32_t>(picoseconds_per_second / shortest.count)});
  SafetyArguments arguments = options.setup;
  arguments.latch = true;
  arguments.by_widths = alone.by_widths;
  SafetyChoice choice = choose_safety(arguments, text, question.format, period_of(question.rate));
  if (!choice.setup) return choice.error;
  SafetySetup& setup = *choice.setup;
  if (options.missed == "perhaps") setup.counter.missed = MissedFrames::perhaps;
  if (options.ignore_turns) setup.comparison.multiturn = MultiturnRule::ignored;
  setup.budget = {static_cast<std::uint8_t>(options.budget), options.budget_window};
  if (options.budget != 0 && options.budget_window.count == 0) {
    setup.budget.window = setup.frame_gap_max * 64;
  }
  if (const auto mistake = check_safety(question.format, setup)) {
    return *mistake == SafetySetupError::budget
               ? fmt::format(
                     "--budget: at most {} faults, in a --budget-window not shorter than "
                     "the watchdog",
                     max_tolerated_faults)
               : "--ignore-turns: nothing is left to be compared";
  }
  question.setup = setup;
  question.configuration = choice.name;
  return {};
}

}  // namespace

void add_evidence_options(Verb verb, EvidenceOptions& options) {
  verb.add_option("-f,--format", options.format,
                  "Safety configuration, catalogue name, or the format of a control and a safety "
                  "word");
  add_count_option(
      verb, "--frames", into(options.frames),
      "Frames of each fault of the campaign, and of each undamaged sequence; 10 million by "
      "default",
      most_frames);
  add_count_option(verb, "--faults", into(options.faults),
                   "Faults of each kind in the sequences; a million by default", most_frames);
  add_count_option(verb, "--cycles", into(options.cycles),
                   "Cycles of the line model with each kind of fault; 50000 by default",
                   most_cycles);
  add_count_option(verb, "--seed", into(options.seed), "Of all that is drawn; 1 by default");
  verb.add_option("--ber", options.bit_error_rates,
                  "Bit error rate, as often as you like; 1e-2, 1e-3 and 1e-4 by default")
      .type_name("P");
  add_rate_option(verb, "--rate", into(options.rate),
                  "Requests a second; by default what the configuration's shortest cycle allows");
  SafetyArguments& setup = options.setup;
  std::vector<std::string> names;
  for (const SafetyConfiguration& each : safety_configurations) names.emplace_back(each.name);
  add_name_option(verb, "--safety", setup.configuration, names,
                  "How the encoder is monitored; by the format by default");
  add_check_options(verb, setup);
  add_name_option(verb, "--missed", options.missed, missed_names,
                  "Whether the encoder counts requests without a good frame; counted by default");
  verb.add_flag("--ignore-turns", options.ignore_turns, "Turns are not compared");
  add_duration_option(verb, "--watchdog", into(setup.watchdog),
                      "From one good frame to the next at most; one and a half cycles by default");
  add_duration_option(verb, "--shortest-gap", into(setup.shortest),
                      "From one good frame to the next at least; 0s by default");
  add_count_option(verb, "--budget", into(options.budget),
                   "Faults that are tolerated within --budget-window; none by default", 255);
  add_duration_option(verb, "--budget-window", into(options.budget_window),
                      "64 times the watchdog's time by default");
}

std::string options_json(const EvidenceOptions& options) {
  const SafetyArguments& setup = options.setup;
  return Json{{"format", options.format},
              {"frames", options.frames},
              {"faults", options.faults},
              {"cycles", options.cycles},
              {"seed", options.seed},
              {"ber", options.bit_error_rates},
              {"rate_hz", options.rate ? Json(options.rate->count) : Json()},
              {"safety", setup.configuration},
              {"counter", setup.counter},
              {"missed", options.missed},
              {"compare_bits", json_of(setup.compare_bits)},
              {"tolerance", json_of(setup.tolerance)},
              {"ignore_turns", options.ignore_turns},
              {"start_frames", json_of(setup.start_frames)},
              {"watchdog_ps", json_of(setup.watchdog)},
              {"shortest_gap_ps", json_of(setup.shortest)},
              {"budget", options.budget},
              {"budget_window_ps", options.budget_window.count}}
      .dump();
}

std::optional<EvidenceOptions> read_options(const std::string& configuration) try {
  const Json json = Json::parse(configuration).at("options");
  EvidenceOptions options;
  SafetyArguments& setup = options.setup;
  json.at("format").get_to(options.format);
  options.frames = count_in(json.at("frames"));
  options.faults = count_in(json.at("faults"));
  options.cycles = count_in(json.at("cycles"));
  options.seed = count_in(json.at("seed"));
  json.at("ber").get_to(options.bit_error_rates);
  if (const Json& rate = json.at("rate_hz"); !rate.is_null()) {
    if (count_in(rate) > UINT32_MAX) return std::nullopt;
    options.rate = Hertz{static_cast<std::uint32_t>(count_in(rate))};
  }
  json.at("safety").get_to(setup.configuration);
  json.at("counter").get_to(setup.counter);
  json.at("missed").get_to(options.missed);
  read(json.at("compare_bits"), setup.compare_bits);
  read(json.at("tolerance"), setup.tolerance);
  json.at("ignore_turns").get_to(options.ignore_turns);
  read(json.at("start_frames"), setup.start_frames);
  read(json.at("watchdog_ps"), setup.watchdog);
  read(json.at("shortest_gap_ps"), setup.shortest);
  options.budget = count_in(json.at("budget"));
  options.budget_window.count = static_cast<std::int64_t>(count_in(json.at("budget_window_ps")));
  if (!is_sound(options)) return std::nullopt;
  return options;
} catch (const nlohmann::json::exception&) {
  return std::nullopt;
}

EvidenceChoice choose_evidence(const EvidenceOptions& options, unsigned threads) {
  EvidenceQuestion question;
  question.options = options;
  question.threads = threads;
  for (const auto put : {put_format, put_bit_error_rates, put_setup}) {
    if (std::string wrong = put(question); !wrong.empty()) return {{}, std::move(wrong)};
  }
  return {std::move(question), {}};
}

UncheckedBits unchecked_bits(const EvidenceQuestion& question) {
  using safety_detail::singleturn_bits;
  const auto alignment =
      safety_detail::alignment_of(question.cpw(), question.spw(), question.setup.comparison);
  const unsigned cpw_bits = singleturn_bits(question.cpw());
  const unsigned both = std::min(cpw_bits, singleturn_bits(question.spw()));
  return {cpw_bits - both, both - alignment.singleturn_bits,
          question.cpw().multiturn.bits - (alignment.bits - alignment.singleturn_bits)};
}

}  // namespace biss::cli
