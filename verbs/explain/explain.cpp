// `biss explain`: why the link in a capture does not work, and what to do.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <vector>

#include "draw/text.hpp"
#include "explain/diagnose.hpp"
#include "report/summary.hpp"
#include "report/text.hpp"
#include "verbs/common/decoded_capture.hpp"
#include "verbs/common/explained.hpp"
#include "verbs/common/identified.hpp"
#include "verbs/common/table_output.hpp"
#include "verbs/common/terminal.hpp"
#include "verbs/common/verb.hpp"
#include "verbs/decode/safety.hpp"
#include "verbs/explain/drawing.hpp"
#include "verbs/explain/finding_text.hpp"

namespace biss::verbs {

namespace {

using explain::Finding;
using report::Cell;
using report::Kind;

struct ExplainOptions {
  CaptureArguments capture;
  SafetyArguments safety;
  std::optional<std::uint64_t> cycle;
  std::string output;
  report::Format to = report::Format::table;
};

constexpr std::size_t usual_columns = 80;

std::vector<report::Column> finding_columns() {
  return {{.name = "cause", .kind = Kind::text},
          {.name = "likelihood", .kind = Kind::real},
          {.name = "evidence", .kind = Kind::text},
          {.name = "remedy", .kind = Kind::text}};
}

// Two places: likelihoods are not more precise.
double rounded(double likelihood) {
  return static_cast<double>(static_cast<int>(likelihood * 100 + 0.5)) / 100;
}

// Whether its signs of life, if it has any, are as wide as in BiSS Safety.
bool has_usual_counter(const FrameFormat& format) {
  const auto channels = format.channels();
  return std::all_of(channels.begin(), channels.end(), [](const ChannelFormat& each) {
    return !each.life_counter.present() || each.life_counter.bits == safety_counter_bits;
  });
}

class ExplainRun {
 public:
  ExplainRun(const ExplainOptions& options, Host& host) : options_(options), host_(host) {}

  ExitStatus run() {
    CaptureArguments arguments = options_.capture;
    arguments.any_lines = true;
    arguments.identify = true;
    arguments.identify_besides = true;
    arguments.signal = true;
    const ExitStatus opened = capture_.open(arguments);
    if (opened != ExitStatus::done) return opened;
    if (options_.to == report::Format::table) return write_text();
    return write_captures(
        capture_, options_.output, options_.to, options_.cycle ? drawing_columns : finding_columns,
        true, [this](report::TableWriter& writer, RunMessages& messages) {
          return options_.cycle ? write_bits(writer, messages) : write_findings(writer, messages);
        });
  }

 private:
  ExitStatus write_findings(report::TableWriter& writer, RunMessages& messages) {
    const auto whole = find();
    if (!whole) return messages.fail(ExitStatus::usage, whole.error());
    for (const Finding& finding : findings_) {
      const std::string evidence = evidence_text(finding.cause, evidence_, context_);
      const std::string remedy = remedy_text(finding.cause, evidence_, context_);
      const Cell cells[] = {name_of(finding.cause), rounded(finding.likelihood), evidence, remedy};
      if (!writer.row(cells)) break;
    }
    return read_status(*whole, messages);
  }

  // The mistake in the options of the monitor, or an empty text.
  std::string choose_watch() {
    watch_.reset();
    if (!options_.safety.given()) return {};
    auto choice = choose_monitor(options_.safety, options_.capture.device.format, capture_);
    if (!choice) return choice.error();
    if (!*choice) return {};
    watch_.emplace(*capture_.format(), (*choice)->setup);
    watch_name_ = std::move((*choice)->name);
    return {};
  }

  // To be called before the cycles are read.
  void choose_context() {
    context_ = explain_context(capture_);
    // Frames are judged by the likeliest format with a usual checksum, if none is certain.
    const auto* finding = capture_.finding();
    const bool moves = finding != nullptr && !finding->still;
    if (!capture_.format() && !context_.given && moves && !context_.candidates.empty() &&
        finding->candidates.front().confidence > 0.05) {
      // A position at constant speed may look like a sign of life.
      const auto plain =
          std::find_if(context_.candidates.begin(), context_.candidates.end(), has_usual_counter);
      const FrameFormat& likeliest =
          plain == context_.candidates.end() ? context_.candidates.front() : *plain;
      const CrcSpec& crc = likeliest.channel_list[0].crc;
      const CrcSpec usual{.polynomial = default_polynomial(crc.width_bits),
                          .width_bits = crc.width_bits};
      if (crc.present() && crc == usual) {
        capture_.judge_by(likeliest);
        context_.format = capture_.format();
        context_.assumed = true;
      }
    }
    // A master refuses a checksum with an error of the encoder's maker, though `decode` reads it.
    if (auto usual = capture_.format(); usual && !context_.given && usual->deviates()) {
      for (ChannelFormat& channel : usual->channel_list) {
        CrcSpec& crc = channel.crc;
        crc.reversed = crc.without_flags = crc.with_cds = crc.of_previous = false;
      }
      capture_.judge_by(*usual);
      context_.format = usual;
    }
  }

  // Reads the capture: false if not to its end. Without a cycle there is no finding.
  // \return or the mistake in the options of the monitor
  tl::expected<bool, std::string> find() {
    std::string wrong = choose_watch();
    if (!wrong.empty()) return tl::unexpected(std::move(wrong));
    choose_context();
    const auto judge = [this](const decode::Cycle& cycle) {
      if (watch_) watch_->judge(cycle);
    };
    const bool whole = observe(capture_, context_.reading.lines, judge, evidence_);
    findings_.clear();
    if (whole || evidence_.cycles != 0) findings_ = diagnose(evidence_, context_);
    return whole;
  }

  // Reads until the requested cycle. The status if the capture has fewer cycles.
  tl::expected<draw::CycleDrawing, ExitStatus> draw_cycle(RunMessages& messages) {
    std::optional<draw::CycleDrawing> drawing;
    std::uint64_t count = 0;
    decode::CycleEdgeReader cycles(
        capture_.reader(), choose_reading(capture_).lines, [&](const decode::CycleEdges& edges) {
          count = edges.number + 1;
          if (edges.number != *options_.cycle) return;
          drawing =
              draw::draw_cycle(edges, capture_.format(), capture_.timing(), capture_.margin());
        });
    capture_.read_edges([&](std::span<const wire::Edge> edges) {
      cycles.push(edges);
      return !drawing;
    });
    if (!drawing) cycles.finish(capture_.input().end_time());
    if (drawing) return std::move(*drawing);
    const std::string& error = capture_.input().error();
    if (!error.empty()) return tl::unexpected(messages.fail(ExitStatus::io, error));
    return tl::unexpected(messages.fail(
        ExitStatus::data_failed,
        fmt::format("{}: no cycle {}; the capture has {}, counted from 0", capture_.input().name(),
                    *options_.cycle, report::counted(count, "request cycle"))));
  }

  // The cycles before the damage of a capture are explained, too.
  ExitStatus read_status(bool whole, RunMessages& messages) const {
    if (!whole) return messages.fail(ExitStatus::io, capture_.input().error());
    if (evidence_.cycles == 0) return messages.fail(ExitStatus::data_failed, capture_.no_request());
    if (!findings_.empty()) return ExitStatus::done;
    return messages.fail(
        ExitStatus::data_failed,
        fmt::format("{}: no cause was found, because no cycle is good and none shows a fault; see "
                    "the status of each with decode",
                    capture_.input().name()));
  }

  ExitStatus write_bits(report::TableWriter& writer, RunMessages& messages) {
    const auto drawing = draw_cycle(messages);
    if (!drawing) return drawing.error();
    write_drawing(*drawing, writer);
    return ExitStatus::done;
  }

  // Text for people: a paragraph for each cause, or the drawing.
  ExitStatus write_text() {
    if (!capture_.next()) return capture_.status();
    Output output(host_);
    if (!output.open(options_.output)) return output.status();
    RunMessages messages;
    ExitStatus status = ExitStatus::done;
    do {
      std::string text;
      const ExitStatus one =
          options_.cycle ? drawn_text(text, messages) : findings_text(text, messages);
      status = std::max(status, one);
      if (!output.write(text)) return output.status();
    } while (status < ExitStatus::usage && capture_.next());
    status = std::max(status, capture_.status());
    if (status >= ExitStatus::usage) {
      output.abandon();
    } else if (!output.finish()) {
      return output.status();
    }
    messages.print(host_);
    return status;
  }

  std::size_t text_columns() const {
    const std::size_t terminal = output_columns(host_);
    return terminal == 0 || !options_.output.empty() ? usual_columns : terminal;
  }

  void append_entry(std::string& text, std::string_view label, std::string_view entry) const {
    text += label;
    report::append_wrapped(text, entry, {label.size(), label.size(), text_columns()});
    text += '\n';
  }

  ExitStatus findings_text(std::string& text, RunMessages& messages) {
    const auto whole = find();
    if (!whole) return messages.fail(ExitStatus::usage, whole.error());
    if (!*whole && evidence_.cycles == 0) return read_status(*whole, messages);
    report::Summary head;
    head.title(fmt::format("{}: {}, {} {}", capture_.input().name(),
                           report::counted(evidence_.cycles, "request cycle"), evidence_.good,
                           evidence_.has_format ? "good" : "unchecked"));
    add_used_format(head, capture_, !options_.capture.device.format.empty());
    if (watch_) add_safety(head, *watch_, watch_name_);
    text = head.text();
    std::size_t number = 0;
    for (const Finding& finding : findings_) {
      text +=
          fmt::format("\n{}. {}  {:.2f}\n", ++number, name_of(finding.cause), finding.likelihood);
      const std::string seen = evidence_text(finding.cause, evidence_, context_);
      if (!seen.empty()) append_entry(text, "   seen  ", seen);
      append_entry(text, "   do    ", remedy_text(finding.cause, evidence_, context_));
    }
    return read_status(*whole, messages);
  }

  ExitStatus drawn_text(std::string& text, RunMessages& messages) {
    const auto drawing = draw_cycle(messages);
    if (!drawing) return drawing.error();
    text = drawing_title(*drawing) + '\n' + draw::drawing_text(*drawing, text_columns());
    return ExitStatus::done;
  }

  const ExplainOptions& options_;
  Host& host_;
  DecodedCapture capture_{host_};
  // The evidence of the current capture.
  explain::Evidence evidence_;
  explain::Context context_;
  std::vector<Finding> findings_;
  std::optional<decode::SafetyWatch> watch_;
  std::string watch_name_;
};

}  // namespace

void add_explain(Command& command) {
  const auto options = std::make_shared<ExplainOptions>();
  Verb verb = command.add_verb(
      {.name = "explain",
       .purpose = "Find out why a link does not work: likely causes, evidence, and what to do",
       .examples = {"biss explain capture.vcd -f resolute-26",
                    "biss explain capture.vcd -f pos26,nE,nW,crc6 --cycle 12",
                    "biss explain capture.sr -f resolute-26 --to jsonl"}},
      [options](Host& host) { return ExplainRun(*options, host).run(); });
  add_capture_options(verb, options->capture);
  add_range_options(verb, options->capture);
  add_safety_options(verb, options->safety);
  verb.add_flag("--no-compensation", options->capture.no_compensation,
                "The master of this link samples half a period after its own edges of MA");
  add_count_option(verb, "--cycle", into(options->cycle),
                   "Draw this cycle bit by bit, counted from 0 as the rows of decode")
      .type_name("N");
  add_output_option(verb, options->output);
  add_to_option(verb, options->to);
}

}  // namespace biss::verbs
