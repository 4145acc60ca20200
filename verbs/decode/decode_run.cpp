#include "verbs/decode/decode_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <tuple>

#include "verbs/common/host.hpp"

namespace biss::verbs {

namespace {

// The options that make the limit known.
std::string_view source_of(decode::Limit limit) {
  return limit == decode::Limit::cycle_min ? "-f NAME or --cycle-min"
         : limit == decode::Limit::release ? "-f NAME or --timeout"
                                           : "-f NAME";
}

// The rows of --only-errors: the rows of `--fail-on any` that a format does not explain, and faults
// of the safety monitor.
bool is_error(const decode::Cycle& cycle, std::optional<SafetyVerdict> verdict,
              decode::LimitSet exceeded) {
  return is_fault(cycle.status) || exceeded != 0 || (cycle.frame && !cycle.frame->trusted()) ||
         (verdict && is_fault(*verdict));
}

}  // namespace

ExitStatus DecodeRun::open() {
  for (const std::string& wrong :
       {wrong_cause(options_.fail_on), wrong_range(options_.capture.since, options_.capture.until),
        options_.motion.wrong_usage()}) {
    if (!wrong.empty()) return host_.fail(ExitStatus::usage, wrong);
  }
  CaptureArguments capture = options_.capture;
  // The values of a row depend on the cycles before it: take() leaves cycles out.
  capture.since = capture.until = std::nullopt;
  capture.words.needs_times = needs_times();
  const bool is_words = !capture.words.file.empty();
  if (is_words && asks_line(options_.fail_on)) {
    return host_.fail(ExitStatus::usage,
                      "--fail-on: words show neither limits nor margins of a line");
  }
  const ExitStatus opened = capture_.open(capture);
  if (opened != ExitStatus::done) return opened;
  if (options_.to == report::Format::vcd && capture_.several()) {
    return host_.fail(ExitStatus::usage, "--to vcd: only for one capture and one pair of lines");
  }
  if (const auto limit = unknown_limit(options_.fail_on, capture_.timing())) {
    return host_.fail(ExitStatus::usage,
                      fmt::format("--fail-on: {} is not known for this encoder; give {}",
                                  name_of(*limit), source_of(*limit)));
  }
  return ExitStatus::done;
}

// The option for which each word needs a time; empty if no option does.
std::string DecodeRun::needs_times() const {
  if (options_.capture.since) return "--since";
  if (options_.capture.until) return "--until";
  if (options_.motion.velocity) return "--velocity";
  if (options_.to == report::Format::vcd) return "--to vcd";
  return options_.safety.given() || asks_safety(options_.fail_on) ? "the safety monitor" : "";
}

ExitStatus DecodeRun::run() {
  const ExitStatus opened = open();
  if (opened != ExitStatus::done) return opened;
  return write_captures(
      capture_, options_.output, options_.to, [this] { return columns(); },
      !options_.fail_on.empty(), std::bind_front(&DecodeRun::write_rows, this), options_.columns);
}

ExitStatus DecodeRun::next() { return capture_.next() ? ExitStatus::done : capture_.status(); }

const std::vector<report::Column>& DecodeRun::columns() {
  if (!table_) table_.emplace(table_of_capture());
  return table_->columns();
}

rows::DecodeTable DecodeRun::table_of_capture() const {
  const bool varies = capture_.several() && options_.capture.device.format.empty();
  return rows::DecodeTable(capture_.format(), varies, options_.motion.columns(),
                           options_.to == report::Format::vcd);
}

// The rows of all captures have the columns of the first one. A capture whose format needs others
// is judged by its structure.
void DecodeRun::choose_table() {
  rows::DecodeTable own = table_of_capture();
  const auto same_name = [](const report::Column& a, const report::Column& b) {
    return a.name == b.name;
  };
  if (std::equal(own.columns().begin(), own.columns().end(), table_->columns().begin(),
                 table_->columns().end(), same_name)) {
    table_ = std::move(own);
  } else {
    capture_.judge_structure();
  }
}

// Returns the mistake as one line, or an empty text. The watchdog depends on the rate of requests
// at the beginning of the capture.
std::string DecodeRun::choose_monitor() {
  const auto& format = capture_.format();
  const bool asked = options_.safety.given() || asks_safety(options_.fail_on);
  if (capture_.words() != nullptr && !asked) return "";
  auto choice = verbs::choose_monitor(options_.safety, options_.capture.device.format, capture_);
  if (!choice) return choice.error();
  if (*choice) {
    now_.safety.emplace(*format, (*choice)->setup);
    now_.safety_name = std::move((*choice)->name);
  } else if (asks_safety(options_.fail_on) && options_.safety.configuration != "off") {
    return format ? "--fail-on: this format is not one of BiSS Safety"
                  : "BiSS Safety: the contents of the words are unknown without -f";
  }
  return "";
}

// Returns the mistake as one line, or an empty text.
std::string DecodeRun::choose_motion() {
  const MotionArguments& asked = options_.motion;
  if (!asked.columns().any()) return "";
  const auto& format = capture_.format();
  if (!format) return "--unwrap, --scale and --velocity need the format of the frame; give -f";
  const std::string& name = options_.capture.device.format;
  const auto device = parse_device(name.empty() ? "none" : name);
  auto motion = make_motion(asked, format->channel_list[0], device ? device->entry : nullptr);
  if (!motion) return motion.error();
  now_.motion.emplace(std::move(*motion));
  return "";
}

ExitStatus DecodeRun::begin_rows() {
  choose_table();
  now_ = {};
  std::string wrong = choose_monitor();
  if (wrong.empty()) wrong = choose_motion();
  if (!wrong.empty()) return host_.fail(ExitStatus::usage, wrong);
  now_.limits.emplace(capture_.timing(), capture_.margin().resolution);
  return ExitStatus::done;
}

bool DecodeRun::take(std::uint64_t number, const decode::Cycle& cycle,
                     report::TableWriter& writer) {
  const decode::LimitSet exceeded = now_.limits->judge(cycle);
  const auto& [since, until] = std::tie(options_.capture.since, options_.capture.until);
  const bool too_late = until && cycle.time > *until;
  const bool wanted = !too_late && (!since || cycle.time >= *since);
  if (!wanted) ++now_.outside;
  if (too_late) return true;
  const auto verdict = now_.safety ? now_.safety->judge(cycle, wanted) : std::nullopt;
  const std::uint64_t uncertain = now_.motion ? now_.motion->uncertain() : 0;
  const rows::MotionValues motion =
      now_.motion ? take_position(number, cycle) : rows::MotionValues{};
  if (!wanted) return true;
  if (now_.motion) now_.uncertain += now_.motion->uncertain() - uncertain;
  now_.statistics.add(cycle, exceeded);
  now_.took_error = is_error(cycle, verdict, exceeded);
  if (options_.only_errors && !now_.took_error) return true;
  if (options_.every > 1 && now_.written++ % options_.every != 0) return true;
  if (options_.to == report::Format::vcd && cycle.time < Picoseconds{}) {
    now_.before_zero = true;
    return false;
  }
  return writer.row(table_->cells(number, cycle, verdict, exceeded, motion, capture_.timed()));
}

ExitStatus DecodeRun::end_rows(bool read, RunMessages& messages) {
  if (now_.before_zero) {
    return messages.fail(ExitStatus::usage,
                         "--to vcd: the capture begins before 0; give --since 0s");
  }
  if (!read) {
    messages.add_summary(summary());
    return messages.fail(ExitStatus::io, capture_.input().error());
  }
  const std::string name = capture_.name();
  if (now_.statistics.cycles() == 0 && now_.outside != 0) {
    return messages.fail(
        ExitStatus::data_failed,
        fmt::format("{}: no request cycle between --since and --until; outside: {}", name,
                    now_.outside));
  }
  if (!has_request()) return messages.fail(ExitStatus::data_failed, capture_.no_request());
  messages.add_summary(summary());
  if (now_.motion) report_motion(messages);
  if (!capture_.format() && asks_format(options_.fail_on)) {
    return messages.fail(ExitStatus::usage,
                         fmt::format("{}: --fail-on: nE, nW and crc are not known without the "
                                     "format of the frame; give -f",
                                     name));
  }
  return is_met(options_.fail_on, now_.statistics, safety()) ? ExitStatus::data_failed
                                                             : ExitStatus::done;
}

// Reports why a column of motion is empty although there is a position.
void DecodeRun::report_motion(RunMessages& messages) const {
  const std::string name = capture_.name();
  const std::string why = fmt::format(
      "a step is larger than {} counts, or too many rows have no position; give the "
      "largest step as --max-step",
      now_.motion->max_step());
  if (now_.lost) {
    messages.fail(ExitStatus::done,
                  fmt::format("{}: unwrapped is not known from cycle {} on: {}", name, *now_.lost,
                              now_.beyond ? "64 bits with a sign do not hold it" : why));
  }
  if (options_.motion.velocity && now_.uncertain != 0) {
    messages.fail(ExitStatus::done, fmt::format("{}: velocity is not known in {} of its rows: {}",
                                                name, now_.uncertain, why));
  }
}

// The rows of one capture.
ExitStatus DecodeRun::write_rows(report::TableWriter& writer, RunMessages& messages) {
  const ExitStatus begun = begin_rows();
  if (begun != ExitStatus::done) return begun;
  const bool read = capture_.read([&](std::uint64_t number, const decode::Cycle& cycle) {
    return take(number, cycle, writer);
  });
  return end_rows(read, messages);
}

rows::MotionValues DecodeRun::take_position(std::uint64_t number, const decode::Cycle& cycle) {
  const auto position =
      cycle.frame ? std::optional(cycle.frame->channel_list[0].position) : std::nullopt;
  const rows::MotionValues values = now_.motion->take(cycle.time, position);
  if (options_.motion.unwrap && !now_.lost && position && !values.unwrapped) {
    now_.lost = number;
    now_.beyond = !now_.motion->lost();
  }
  return values;
}

// Pulses are not requests, and neither is a piece of a request among pulses alone.
bool DecodeRun::has_request() const {
  const std::uint64_t glitches = now_.statistics.count(CycleStatus::ma_glitch);
  const std::uint64_t pieces =
      now_.statistics.count(CycleStatus::cut_start) + now_.statistics.count(CycleStatus::cut_end);
  return now_.statistics.cycles() > glitches + (glitches != 0 ? pieces : 0);
}

}  // namespace biss::verbs
