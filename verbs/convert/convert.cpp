// `biss convert`: a capture in another format.
#include <fmt/format.h>

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "device/quantity.hpp"
#include "report/summary.hpp"
#include "verbs/common/capture_input.hpp"
#include "verbs/common/capture_output.hpp"
#include "verbs/common/terminal.hpp"
#include "verbs/common/verb.hpp"
#include "verbs/convert/losses.hpp"
#include "verbs/convert/part.hpp"

namespace biss::verbs {

namespace {

struct ConvertOptions {
  InputArguments input;
  std::string output;
  std::string to;
  std::vector<std::string> lines;
  std::optional<Hertz> rate;
  std::optional<Picoseconds> since;
  std::optional<Picoseconds> until;
  bool partial = false;
};

class ConvertRun {
 public:
  ConvertRun(ConvertOptions options, Host& host) : options_(std::move(options)), host_(host) {}

  ExitStatus run() {
    name_files();
    const ExitStatus opened = open_input();
    if (opened != ExitStatus::done) return opened;
    check_format();
    return copy();
  }

 private:
  // The last file is the output, unless -o names it.
  void name_files() {
    std::vector<std::string>& files = options_.input.files;
    std::string option = "-o";
    if (options_.output.empty()) {
      if (files.size() < 2) {
        throw wrong_usage("name the capture and then the file to write: biss convert IN OUT");
      }
      option = "OUT";
      options_.output = files.back();
      files.pop_back();
    }
    if (files.empty()) throw wrong_usage("no capture given; name a file, or - for standard input");
    std::vector<NamedFile> named{{option, options_.output, FileUse::write}};
    for (const std::string& file : files) named.push_back({"IN", file, FileUse::read});
    if (options_.output != "-") named.push_back({"standard output", "-", FileUse::write});
    fail_if(file_conflict(named, host_));
    choose_format();
  }

  void choose_format() {
    std::optional<CaptureFormat> format = capture_format_of(options_.output);
    for (std::size_t i = 0; i < capture_formats.size(); ++i) {
      if (options_.to == capture_formats[i].name) format = static_cast<CaptureFormat>(i);
    }
    if (!format && options_.output == "-") {
      throw wrong_usage("standard output has no extension; name its format with --to");
    }
    if (!format) {
      throw wrong_usage(
          "{}: the extension names no format that is written; use .vcd, .csv, .sr, .dsl, .bin, or "
          "--to",
          options_.output);
    }
    format_ = *format;
  }

  ExitStatus open_input() {
    fail_if(wrong_range(options_.since, options_.until));
    std::vector<CaptureFile> files;
    for (const std::string& file : options_.input.files) files.push_back({.path = file});
    const ExitStatus opened = input_.open(std::move(files), options_.input);
    if (opened != ExitStatus::done) return opened;
    LineSelection selection = value_or_fail(
        select_lines(plain_names(input_.lines(), options_.input.files), options_.lines));
    if (selection.names.empty()) {
      return host_.fail(
          ExitStatus::data_failed,
          fmt::format("{}: has no line of one bit; nothing to convert", input_.name()));
    }
    cutter_.emplace(std::move(selection), options_.since, options_.until);
    return ExitStatus::done;
  }

  void check_format() {
    const std::size_t lines = cutter_->names().size();
    if (!is_sampled(format_)) {
      if (options_.rate) {
        throw wrong_usage("--rate: this format stores changes, not samples; leave the option out");
      }
      if (format_ == CaptureFormat::saleae_binary && lines > 1) {
        throw wrong_usage(
            "Saleae's binary export has a file for each line, and this capture has {}; select one "
            "with --line",
            lines);
      }
      rate_ = input_.sample_rate();
      return;
    }
    constexpr std::size_t most_lines = 64;
    if (lines > most_lines) {
      throw wrong_usage("a sample holds 64 lines, and this capture has {}; select some with --line",
                        lines);
    }
    rate_ = options_.rate.value_or(input_.sample_rate());
    if (rate_.count != 0) return;
    throw wrong_usage("{}: holds changes, and the output holds samples; give their --rate",
                      input_.name());
  }

  ExitStatus copy() {
    Output output(host_);
    if (!output.open(options_.output)) return output.status();
    CaptureOutput capture(format_, cutter_->names(), rate_, output);
    losses_.emplace(format_, cutter_->names(), rate_);
    ExitStatus status = copy_edges(capture, output);
    if (status != ExitStatus::done) return status;
    const bool damaged = !input_.error().empty();
    if (damaged && !options_.partial) {
      return host_.fail(ExitStatus::io, input_.error() + " (--partial: convert the part before)");
    }
    if (cutter_->is_before(input_.end_time())) {
      return host_.fail(ExitStatus::data_failed,
                        fmt::format("--since: {} ends earlier, at {}; nothing to convert",
                                    input_.name(), text_of(input_.end_time())));
    }
    if (changes_ == 0 && cutter_->past_end()) {
      return host_.fail(
          ExitStatus::data_failed,
          fmt::format("--until: {} has no level of the lines before {}; nothing to convert",
                      input_.name(), text_of(*options_.until)));
    }
    status = finish(capture);
    if (status != ExitStatus::done) return status;
    if (!output.finish()) return output.status();
    host_.print_summary(summary());
    return damaged ? host_.fail(ExitStatus::io, input_.error()) : ExitStatus::done;
  }

  ExitStatus copy_edges(CaptureOutput& capture, const Output& output) {
    Progress progress(host_);
    while (!cutter_->past_end() && !output.reader_left()) {
      if (progress.due()) progress.show(input_.progress_text(progress.seconds()));
      const auto block = input_.next();
      if (block.empty()) break;
      const ExitStatus written = write(cutter_->push(block), capture);
      if (written != ExitStatus::done) return written;
    }
    return write(cutter_->finish(input_.end_time()), capture);
  }

  // The time of an edge, or of the end, in the output; fails if the output cannot have it.
  Picoseconds shifted(Picoseconds time) const {
    if (shift_.count > 0 && time.count > std::numeric_limits<std::int64_t>::max() - shift_.count) {
      throw wrong_file("{}: times of more than 106 days; cut a part out of it with --since",
                       input_.name());
    }
    const Picoseconds moved = time + shift_;
    if (!losses_->too_many_samples(moved)) return moved;
    throw wrong_file(
        "{}: more than {} samples at {}; give a lower --rate, or cut a part out with --until",
        input_.name(), most_samples, text_of(rate_));
  }

  // A capture that begins before zero, or at --since in samples, is moved as a whole.
  void choose_shift(Picoseconds first) {
    if (holds_negative_times(format_)) return;
    if (is_sampled(format_) && options_.since) {
      shift_ = -*options_.since;
    } else if (first < Picoseconds{}) {
      shift_ = -first;
    }
  }

  ExitStatus write(std::span<const wire::Edge> edges, CaptureOutput& capture) {
    if (edges.empty()) return ExitStatus::done;
    if (changes_ == 0) {
      first_ = edges.front().time;
      choose_shift(first_);
    }
    made_.clear();
    for (wire::Edge edge : edges) {
      edge.time = shifted(edge.time);
      losses_->add(edge);
      made_.push_back(edge);
    }
    changes_ += edges.size();
    return capture.write(made_) ? ExitStatus::done : capture.status();
  }

  ExitStatus finish(CaptureOutput& capture) {
    end_ = cutter_->end_of(input_.end_time());
    if (changes_ == 0) choose_shift(end_);
    return capture.finish(shifted(end_)) ? ExitStatus::done : capture.status();
  }

  std::string summary() const {
    report::Summary out;
    out.title(fmt::format("{}: {} changes of {}",
                          options_.output == "-" ? "standard output" : options_.output, changes_,
                          report::counted(cutter_->names().size(), "line")));
    out.entry("format", text_of(format_).name,
              is_sampled(format_) ? "samples at " + text_of(rate_) : "changes");
    if (changes_ != 0) out.entry("time", fmt::format("{} to {}", text_of(first_), text_of(end_)));
    if (shift_ != Picoseconds{}) {
      out.entry("moved", "every time by " + text_of(shift_), "the format begins at 0");
    }
    losses_->report(out, {input_.sample_rate(), input_.sample_period()}, options_.output);
    return out.text();
  }

  ConvertOptions options_;
  Host& host_;
  CaptureFormat format_ = CaptureFormat::vcd;
  CaptureInput input_{host_};
  std::optional<PartCutter> cutter_;
  std::optional<Losses> losses_;
  Hertz rate_;
  Picoseconds shift_;
  Picoseconds first_;
  Picoseconds end_;
  std::uint64_t changes_ = 0;
  std::vector<wire::Edge> made_;
};

}  // namespace

void add_convert(Command& command) {
  const auto options = std::make_shared<ConvertOptions>();
  Verb verb = command.add_verb(
      {.name = "convert",
       .purpose = "Write a capture in another format, or a part of it",
       .examples = {"biss convert capture.vcd capture.sr --rate 100MHz",
                    "biss convert ma.csv slo.csv line.vcd --line D0=MA --line D1=SLO",
                    "biss convert capture.csv part.csv --since 1ms --until 2ms",
                    "biss convert capture.sr - --to vcd"}},
      [options](Host& host) { return ConvertRun(*options, host).run(); });
  verb.add_option(
      "FILE", options->input.files,
      "Captures, read as one capture, with times from the same moment; the last file is "
      "the one to write, unless -o names it; - is standard input or output");
  verb.add_option("-o,--output", options->output, "Output file; the last FILE by default")
      .type_name("FILE");
  std::vector<std::string> names;
  for (const CaptureFormatText& text : capture_formats) names.emplace_back(text.name);
  add_name_option(verb, "--to", options->to, names,
                  "Output format; by default the one that the extension names");
  verb.add_option("--line", options->lines,
                  "Convert this line, and rename it; repeat it for several; all by default")
      .type_name("NAME|NAME=NEW");
  add_rate_option(verb, "--rate", into(options->rate),
                  "Sample rate of .sr, .dsl and raw samples; by default the rate of the capture");
  add_time_option(verb, "--since", into(options->since), "Begin at this time of the capture");
  add_time_option(verb, "--until", into(options->until), "End at this time of the capture");
  verb.add_flag("--partial", options->partial,
                "Convert the part before the damage of a damaged capture; the exit status is 3");
  add_raw_options(verb, options->input.raw);
}

}  // namespace biss::verbs
