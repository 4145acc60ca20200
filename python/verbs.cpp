#include "python/verbs.hpp"

#include <memory>
#include <optional>
#include <utility>

#include "verbs/common/host.hpp"
#include "verbs/common/verb.hpp"
#include "verbs/decode/decode_run.hpp"

namespace biss::python {
namespace {

class KeptRows final : public report::RowStore<Values> {
 public:
  KeptRows(std::span<const report::Column> columns, std::vector<StoredColumn>& into)
      : RowStore(columns), into_(into) {}

  bool finish() override {
    into_ = take_columns();
    return true;
  }

 private:
  std::vector<StoredColumn>& into_;
};

// Keeps the input and output of a verb in memory, and its rows on request.
class VerbHost final : public verbs::MemoryHost {
 public:
  VerbHost(const VerbSetup& setup, VerbResult& result)
      : keeps_columns_(setup.keep_columns), result_(result) {
    set_go_on(setup.go_on);
    for (const auto& [name, capture] : setup.captures) give(name, capture);
  }

  std::unique_ptr<report::TableWriter> keep_rows(std::span<const report::Column> columns) override {
    if (!keeps_columns_) return nullptr;
    return std::make_unique<KeptRows>(columns, result_.columns);
  }

  void end(verbs::ExitStatus status) {
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

verbs::ExitStatus collect_edges(const verbs::DecodeOptions& options, CaptureEdges& edges,
                                verbs::Host& host) {
  verbs::CaptureArguments arguments = options.capture;
  arguments.identify = false;
  verbs::DecodedCapture capture(host);
  const verbs::ExitStatus opened = capture.open(arguments);
  if (opened != verbs::ExitStatus::done) return opened;
  if (capture.several()) return host.fail(verbs::ExitStatus::usage, "one capture at a time");
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
    return host.fail(verbs::ExitStatus::data_failed,
                     capture.input().name() + ": MA or SLO has a level that is neither 0 nor 1");
  }
  return read ? verbs::ExitStatus::done : host.fail(verbs::ExitStatus::io, capture.input().error());
}

}  // namespace

VerbResult run_verb(const std::vector<std::string>& words, const verbs::GivenOptions& options,
                    const VerbSetup& setup) {
  VerbResult result;
  VerbHost host(setup, result);
  verbs::Command command(host);
  verbs::add_verbs(command, words.empty() ? "" : words.front());
  host.end(command.run(words, options));
  return result;
}

CaptureEdges read_edges(const std::vector<std::string>& words, const verbs::GivenOptions& given,
                        const VerbSetup& setup) {
  CaptureEdges edges;
  VerbHost host(setup, edges.result);
  verbs::Command command(host);
  verbs::DecodeOptions options;
  const verbs::Verb verb = command.add_verb(verbs::decode_text(), [&](verbs::Host& of_run) {
    return collect_edges(options, edges, of_run);
  });
  verbs::add_decode_options(verb, options);
  host.end(command.run(words, given));
  return edges;
}

}  // namespace biss::python
