// `biss check`: an encoder, its master and their line judged by a capture, rule by rule.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <memory>
#include <vector>

#include "biss/catalogue/catalogue.hpp"
#include "biss/safety/configurations.hpp"
#include "biss/timing/renishaw.hpp"
#include "decode/check.hpp"
#include "report/summary.hpp"
#include "verbs/common/decoded_capture.hpp"
#include "verbs/common/fields.hpp"
#include "verbs/common/identified.hpp"
#include "verbs/common/table_output.hpp"
#include "verbs/common/verb.hpp"
#include "verbs/decode/safety.hpp"

namespace biss::verbs {

namespace {

using decode::Rule;
using decode::RuleResult;
using decode::Verdict;

constexpr std::string_view against_biss_c = "biss-c";
constexpr std::string_view against_renishaw = "renishaw";
constexpr std::string_view turns_suffix = "rpm";

// --speed-max, in counts per second or in turns per minute.
struct Speed {
  std::uint64_t value = 0;
  bool is_turns = false;
};

struct CheckOptions {
  CaptureArguments capture;
  SafetyArguments safety;
  std::string against{against_biss_c};
  Speed speed_max;
  std::string output;
  report::Format to = report::Format::table;
};

Picoseconds count_of(std::uint64_t count) {
  return nanoseconds(static_cast<std::int64_t>(std::min<std::uint64_t>(count, INT64_MAX / 1'000)));
}

// Limits are times for some rules and counts or shares for others. Thousandths of any unit are
// written like picoseconds as nanoseconds.
FieldRow rule_fields(Rule rule, const RuleResult& result) {
  const decode::RuleText& text = text_of(rule);
  std::optional<Picoseconds> limit, worst, margin;
  if (result.measured) {
    limit = picoseconds(result.measured->limit);
    worst = picoseconds(result.measured->worst);
    margin = picoseconds(result.measured->margin);
  } else if (!text.is_measured && result.verdict != Verdict::not_judged) {
    limit = Picoseconds{};
    worst = count_of(result.faults);
    margin = -count_of(result.faults);
  }
  return {{"rule", text.name},
          {"limit", limit},
          {"worst", worst},
          {"unit", text.unit},
          {"margin", margin},
          {"cycle", result.cycle},
          {"verdict", name_of(result.verdict)},
          {"cases", result.cases},
          {"source", text.source},
          {"note", unless_empty(result.note)}};
}

std::vector<report::Column> check_columns() { return columns_of(rule_fields(Rule{}, {})); }

// Reads --against into the limits and, if it names a type and -f is not given, the format.
// \return why that is wrong usage; empty if it is not
std::string apply_against(const std::string& against, CaptureArguments& capture) {
  if (against == against_biss_c) return {};
  if (against == against_renishaw) {
    capture.timing = renishaw_timing;
    return {};
  }
  const auto device = parse_device(against);
  if (!device || !device->timing_known()) {
    const std::string names = suggested_encoders(against);
    return fmt::format("--against: '{}' is not {}, {} or a name that 'biss encoders' lists{}",
                       against, against_renishaw, against_biss_c,
                       names.empty() ? "" : fmt::format("; did you mean {}?", names));
  }
  capture.timing = device->timing;
  if (capture.device.format.empty()) capture.device.format = against;
  return {};
}

// Counts of the first channel's position in a turn; 0 if it has no position, or if there are more
// than 2^63.
std::uint64_t counts_per_turn(const FrameFormat& format) {
  const ChannelFormat& channel = format.channels().front();
  const unsigned bits =
      channel.position.present() ? channel.position.bits : channel.singleturn.bits;
  return bits == 0 || bits > 63 ? 0 : std::uint64_t{1} << bits;
}

std::uint64_t counts_per_second(const Speed& speed, const std::optional<FrameFormat>& format) {
  // Without a format the rule is not judged, for any limit.
  if (!speed.is_turns || !format) return speed.value;
  const double counts =
      static_cast<double>(speed.value) * static_cast<double>(counts_per_turn(*format)) / 60.0;
  return static_cast<std::uint64_t>(std::min(counts, 9e18));
}

bool has_same_words(const FrameFormat& a, const FrameFormat& b) {
  const auto same = [](const ChannelFormat& one, const ChannelFormat& other) {
    return one.position_bits() == other.position_bits();
  };
  return std::equal(a.channels().begin(), a.channels().end(), b.channels().begin(),
                    b.channels().end(), same);
}

// Whether a data sheet has words of these lengths; empty if no data sheet states the lengths.
std::optional<bool> has_word_lengths(const FrameFormat& format, bool renishaw, bool fortis) {
  const auto matches = [&](const auto& each) {
    return has_same_words(each.frame_format(), format);
  };
  if (renishaw) {
    return std::any_of(std::begin(catalogue), std::end(catalogue), [&](const auto& entry) {
      const bool asked = !fortis || entry.product.starts_with("FORTiS");
      return entry.vendor == "Renishaw" && asked && matches(entry);
    });
  }
  if (!is_safety_format(format)) return std::nullopt;
  return std::any_of(std::begin(safety_configurations), std::end(safety_configurations), matches);
}

Speed read_speed(const std::string& text) {
  Speed speed;
  std::string_view digits = text;
  speed.is_turns = digits.ends_with(turns_suffix);
  if (speed.is_turns) digits.remove_suffix(turns_suffix.size());
  const auto value = parse_count(digits, UINT64_MAX);
  if (!value.ok() || *value == 0) {
    wrong_value("--speed-max", fmt::format("'{}': give counts per second (1000000) or turns per "
                                           "minute (6000rpm)",
                                           text));
  }
  speed.value = *value;
  return speed;
}

class CheckRun {
 public:
  CheckRun(const CheckOptions& options, Host& host) : options_(options), host_(host) {}

  ExitStatus run() {
    CaptureArguments arguments = options_.capture;
    arguments.identify = true;
    const std::string wrong = apply_against(options_.against, arguments);
    if (!wrong.empty()) return host_.fail(ExitStatus::usage, wrong);
    format_ = arguments.device.format;
    renishaw_ = arguments.timing == renishaw_timing;
    arguments.signal = true;
    const ExitStatus opened = capture_.open(arguments);
    if (opened != ExitStatus::done) return opened;
    return write_captures(capture_, options_.output, options_.to, check_columns, true,
                          std::bind_front(&CheckRun::judge, this));
  }

 private:
  // The names of the rules by verdict.
  using Verdicts = std::array<std::vector<std::string_view>, 4>;

  ExitStatus judge(report::TableWriter& writer, RunMessages& messages) {
    std::optional<SafetySetup> safety;
    if (options_.safety.given()) {
      const auto monitor = choose_monitor(options_.safety, format_, capture_);
      if (!monitor) return host_.fail(ExitStatus::usage, monitor.error());
      if (*monitor) safety = (*monitor)->setup;
    }
    const auto& format = capture_.format();
    const bool fortis = options_.against.starts_with("fortis") || format_.starts_with("fortis");
    decode::Check check(
        {.format = format,
         .timing = capture_.timing(),
         .unidirectional = renishaw_,
         .renishaw_cables = renishaw_,
         .has_word_lengths = format ? has_word_lengths(*format, renishaw_, fortis) : std::nullopt,
         .safety = safety,
         .compensated = capture_.margin().compensated,
         .resolution = capture_.margin().resolution,
         .speed_max = counts_per_second(options_.speed_max, capture_.format())});
    bool any = false;
    const bool read = capture_.read([&](std::uint64_t number, const decode::Cycle& cycle) {
      any = true;
      check.push(number, cycle);
      return true;
    });
    check.finish();
    if (!read) return messages.fail(ExitStatus::io, capture_.input().error());
    if (!any) return messages.fail(ExitStatus::data_failed, capture_.no_request());
    Verdicts verdicts{};
    for (std::size_t i = 0; i < decode::rule_count; ++i) {
      const auto rule = static_cast<Rule>(i);
      const RuleResult result = check.result(rule);
      verdicts[static_cast<std::size_t>(result.verdict)].push_back(text_of(rule).name);
      write_row(writer, rule_fields(rule, result));
    }
    messages.add_summary(summary(verdicts));
    if (!verdicts[static_cast<std::size_t>(Verdict::fail)].empty()) return ExitStatus::data_failed;
    const RuleResult frames = check.result(Rule::frame_structure);
    if (frames.cases != 0) return ExitStatus::done;
    return messages.fail(
        ExitStatus::data_failed,
        fmt::format("{}: no frame could be judged: {}", capture_.input().name(), frames.note));
  }

  std::string summary(const Verdicts& verdicts) const {
    std::string counted;
    for (std::size_t i = 0; i < verdicts.size(); ++i) {
      report::append_count(counted, verdicts[i].size(), name_of(static_cast<Verdict>(i)));
    }
    report::Summary out;
    out.title(fmt::format("{}: {} rules against {}", capture_.input().name(), decode::rule_count,
                          options_.against));
    add_used_format(out, capture_, !format_.empty());
    out.entry("verdict", counted);
    for (const Verdict named : {Verdict::fail, Verdict::marginal}) {
      const auto& rules = verdicts[static_cast<std::size_t>(named)];
      if (rules.empty()) continue;
      out.entry(std::string(name_of(named)), fmt::format("{}", fmt::join(rules, ", ")));
    }
    return out.text();
  }

  const CheckOptions& options_;
  Host& host_;
  DecodedCapture capture_{host_};
  // The limits come from Renishaw's data sheets.
  bool renishaw_ = false;
  // By -f or --against; empty if neither gives one.
  std::string format_;
};

}  // namespace

void add_check(Command& command) {
  const auto options = std::make_shared<CheckOptions>();
  Verb verb = command.add_verb(
      {.name = "check",
       .purpose = "Compare a capture, rule by rule, with the limits of BiSS C or of a data sheet",
       .examples = {"biss check capture.vcd --against resolute-26",
                    "biss check capture.sr --against renishaw -f pos26,nE,nW,crc6",
                    "biss check capture.vcd --against biss-c --to jsonl"}},
      [options](Host& host) { return CheckRun(*options, host).run(); });
  verb.add_option("--against", options->against,
                  "The limits: biss-c (the default: BiSS C and the name given to -f), "
                  "renishaw (its data sheets), or a name that 'biss encoders' lists, whose format "
                  "is then the default of -f")
      .type_name("LIMITS");
  add_capture_options(verb, options->capture);
  add_range_options(verb, options->capture);
  add_safety_options(verb, options->safety);
  verb.add_flag("--no-compensation", options->capture.no_compensation,
                "Judge the sampling points of a master that does not compensate the line delay");
  verb.add_text_option(
          "--speed-max",
          [options](const std::string& text) { options->speed_max = read_speed(text); },
          "Highest speed of the device, in counts per second (1000000) or turns per minute "
          "(6000rpm)")
      .type_name("SPEED");
  add_output_option(verb, options->output);
  add_to_option(verb, options->to);
}

}  // namespace biss::verbs
