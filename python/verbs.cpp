#include "python/verbs.hpp"

#include <array>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>

#include "cli/common/host.hpp"
#include "cli/common/verb.hpp"
#include "cli/common/verbs.hpp"
#include "cli/decode/decode_run.hpp"

namespace biss::python {
namespace {

using AddVerb = void (*)(cli::Command&);
constexpr auto verbs = std::to_array<std::pair<std::string_view, AddVerb>>({
    {"archive", cli::add_archive},
    {"check", cli::add_check},
    {"compare", cli::add_compare},
    {"convert", cli::add_convert},
    {"crc", cli::add_crc},
    {"decode", cli::add_decode},
    {"draw", cli::add_draw},
    {"eds", cli::add_eds},
    {"encoders", cli::add_encoders},
    {"explain", cli::add_explain},
    {"identify", cli::add_identify},
    {"plan", cli::add_plan},
    {"registers", cli::add_registers},
    {"report", cli::add_report},
    {"safety", cli::add_safety},
    {"simulate", cli::add_simulate},
});

// To declare all of them takes milliseconds. An unknown verb gets all, for the message.
void add_verb_of(cli::Command& command, std::string_view name) {
  for (const auto& [each, add] : verbs) {
    if (each == name) return add(command);
  }
  for (const auto& [each, add] : verbs) add(command);
}

cli::ExitStatus run_words(const std::vector<std::string>& words, cli::Host& host) {
  cli::Command command(host);
  add_verb_of(command, words.empty() ? std::string_view() : std::string_view(words.front()));
  const std::vector<const char*> arguments = arguments_of(words);
  return command.run(static_cast<int>(arguments.size()), arguments.data());
}

// What a verb prints and reads is in memory, and its rows if they are asked for.
class VerbHost final : public cli::MemoryHost {
 public:
  VerbHost(const VerbSetup& setup, VerbResult& result)
      : keeps_columns_(setup.keep_columns), result_(result) {
    set_go_on(setup.go_on);
    for (const auto& [name, capture] : setup.captures) give(name, capture);
  }

  std::unique_ptr<report::TableWriter> keep_rows(std::span<const report::Column> columns) override {
    if (!keeps_columns_) return nullptr;
    return std::make_unique<ColumnStore>(columns, result_.columns);
  }

  void end(cli::ExitStatus status) {
    result_.status = status;
    result_.output = output_text();
    result_.summary = summary();
    result_.messages = lines();
  }

 private:
  bool keeps_columns_;
  VerbResult& result_;
};

// The levels of both lines, once both are known.
class EdgeCollector {
 public:
  EdgeCollector(const decode::Lines& lines, CaptureEdges& into) : lines_(lines), into_(into) {}

  // False at a level that is neither 0 nor 1.
  bool take(const wire::Edge& edge) {
    if (edge.line != lines_.ma && edge.line != lines_.slo) return true;
    if (edge.level == wire::Level::unknown) return false;
    const bool is_ma = edge.line == lines_.ma;
    const bool inverted = is_ma ? lines_.ma_inverted : lines_.slo_inverted;
    (is_ma ? ma_ : slo_) = (edge.level == wire::Level::high) != inverted;
    if (!ma_ || !slo_) return true;
    into_.times.push_back(edge.time.count);
    into_.ma.push_back(*ma_ ? 1 : 0);
    into_.slo.push_back(*slo_ ? 1 : 0);
    return true;
  }

 private:
  decode::Lines lines_;
  CaptureEdges& into_;
  std::optional<bool> ma_;
  std::optional<bool> slo_;
};

cli::ExitStatus collect_edges(const cli::DecodeOptions& options, CaptureEdges& edges,
                              cli::Host& host) {
  cli::CaptureArguments arguments = options.capture;
  arguments.identify = false;
  cli::DecodedCapture capture(host);
  const cli::ExitStatus opened = capture.open(arguments);
  if (opened != cli::ExitStatus::done) return opened;
  if (capture.several()) return host.fail(cli::ExitStatus::usage, "one capture at a time");
  if (!capture.next()) return capture.status();
  edges.ma_name = capture.ma_name();
  edges.slo_name = capture.slo_name();
  edges.sample_period = capture.input().sample_period();
  EdgeCollector collector(capture.lines().lines, edges);
  bool known = true;
  const bool read = capture.read_edges([&](std::span<const wire::Edge> block) {
    for (const wire::Edge& edge : block) known = known && collector.take(edge);
    return known;
  });
  if (!known) {
    return host.fail(cli::ExitStatus::data_failed,
                     capture.input().name() + ": MA or SLO has a level that is neither 0 nor 1");
  }
  return read ? cli::ExitStatus::done : host.fail(cli::ExitStatus::io, capture.input().error());
}

}  // namespace

std::vector<const char*> arguments_of(const std::vector<std::string>& words) {
  std::vector<const char*> arguments{"biss"};
  for (const std::string& word : words) arguments.push_back(word.c_str());
  return arguments;
}

VerbResult run_verb(const std::vector<std::string>& words, const VerbSetup& setup) {
  VerbResult result;
  VerbHost host(setup, result);
  host.end(run_words(words, host));
  return result;
}

CaptureEdges read_edges(const std::vector<std::string>& words, const VerbSetup& setup) {
  CaptureEdges edges;
  VerbHost host(setup, edges.result);
  cli::Command command(host);
  cli::DecodeOptions options;
  const cli::Verb verb = command.add_verb(
      cli::decode_text(), [&](cli::Host& of_run) { return collect_edges(options, edges, of_run); });
  cli::add_decode_options(verb, options);
  const std::vector<const char*> arguments = arguments_of(words);
  host.end(command.run(static_cast<int>(arguments.size()), arguments.data()));
  return edges;
}

}  // namespace biss::python
