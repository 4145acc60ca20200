// `biss compare`: the differences between a link that works and one that does not.
#include "verbs/compare/compare.hpp"

#include <fmt/format.h>

#include <cmath>
#include <memory>

#include "report/summary.hpp"
#include "verbs/common/fields.hpp"
#include "verbs/common/identified.hpp"
#include "verbs/common/verb.hpp"

namespace biss::verbs {

namespace {

struct CompareOptions {
  CaptureArguments capture;
  std::string output;
  report::Format to = report::Format::table;
};

// Whole numbers are written without an exponent: 1000000 and not 1e+06.
Field value_field(const char* name, const Difference::Value& value) {
  if (const auto* words = std::get_if<std::string>(&value)) return {name, *words};
  const double number = std::get<double>(value);
  const bool is_whole = std::abs(number) < 9e15 && number == std::floor(number);
  return is_whole ? Field(name, static_cast<std::int64_t>(number)) : Field(name, number);
}

FieldRow fields_of(const Difference& difference) {
  return {{"property", difference.property},
          {"unit", unless_empty(difference.unit)},
          value_field("good", difference.good),
          value_field("bad", difference.bad),
          {"effect", difference.effect}};
}

// One of the two captures.
struct Side {
  explicit Side(Host& host) : capture(host) {}

  CaptureArguments arguments;
  DecodedCapture capture;
  std::optional<Link> link;
};

class CompareRun {
 public:
  CompareRun(const CompareOptions& options, Host& host) : options_(options), host_(host) {}

  ExitStatus run() {
    choose_files();
    ExitStatus status = open_both();
    if (status != ExitStatus::done) return status;
    read(good_);
    read(bad_);
    const bool good_asks = good_.link->evidence.cycles != 0;
    const bool bad_asks = bad_.link->evidence.cycles != 0;
    std::vector<Difference> found;
    if (good_asks && bad_asks) found = differences(*good_.link, *bad_.link);
    status = write(found);
    if (status != ExitStatus::done) return status;
    host_.print_summary(summary(found));
    if (!good_asks) status = host_.fail(ExitStatus::data_failed, good_.capture.no_request());
    if (!bad_asks) status = host_.fail(ExitStatus::data_failed, bad_.capture.no_request());
    return status;
  }

 private:
  void choose_files() {
    const auto& files = options_.capture.files;
    if (files.size() != 2 && files.size() != 4) {
      throw wrong_usage(
          "compare needs two captures, GOOD and BAD, or four files with one line each; {} given",
          files.size());
    }
    const auto middle = files.begin() + static_cast<std::ptrdiff_t>(files.size() / 2);
    for (Side* side : {&good_, &bad_}) {
      side->arguments = options_.capture;
      side->arguments.any_lines = true;
      side->arguments.identify = true;
      side->arguments.identify_besides = true;
      side->arguments.signal = true;
    }
    good_.arguments.files.assign(files.begin(), middle);
    bad_.arguments.files.assign(middle, files.end());
  }

  // Both are judged by one format: the given one, else the format of GOOD, else the format of BAD.
  ExitStatus open_both() {
    ExitStatus status = open(good_);
    if (status != ExitStatus::done) return status;
    const bool is_identified = good_.arguments.device.format.empty() && good_.capture.format();
    if (is_identified) bad_.arguments.device.format = text_of(*good_.capture.format());
    status = open(bad_);
    if (status != ExitStatus::done) return status;
    if (!good_.capture.format() && bad_.capture.format()) {
      good_.capture.judge_by(*bad_.capture.format());
    }
    return ExitStatus::done;
  }

  static ExitStatus open(Side& side) {
    const ExitStatus status = side.capture.open(side.arguments);
    if (status != ExitStatus::done) return status;
    if (side.capture.several()) {
      throw wrong_usage("{} and {} are two captures; name one GOOD and one BAD",
                        side.arguments.files.front(), side.arguments.files.back());
    }
    return side.capture.next() ? ExitStatus::done : side.capture.status();
  }

  static void read(Side& side) {
    side.link = read_link(side.capture);
    if (!side.link) throw VerbError{ExitStatus::io, side.capture.input().error()};
  }

  ExitStatus write(const std::vector<Difference>& found) const {
    std::vector<FieldRow> rows;
    for (const Difference& each : found) rows.push_back(fields_of(each));
    return write_output(host_, options_.output, [&](Output& output) {
      return write_rows(fields_of({}), rows, options_.to, output, output.table_options());
    });
  }

  static void add_side(report::Summary& out, std::string_view key, const Side& side) {
    const explain::Evidence& evidence = side.link->evidence;
    out.entry(key, side.capture.input().name(),
              fmt::format("{}, {} good", report::counted(evidence.cycles, "request cycle"),
                          evidence.good));
  }

  std::string summary(const std::vector<Difference>& found) const {
    report::Summary out;
    add_side(out, "good", good_);
    add_side(out, "bad", bad_);
    const auto& format = bad_.capture.format();
    out.entry("format", format ? text_of(*format) : "not known: structure alone");
    const bool judged = good_.link->evidence.cycles != 0 && bad_.link->evidence.cycles != 0;
    if (judged) {
      out.entry("differs", found.empty() ? "nothing" : found.front().property,
                found.empty() ? std::string() : fmt::format("effect {:.2f}", found.front().effect));
    }
    const auto causes = diagnose(bad_.link->evidence, bad_.link->context);
    if (!causes.empty()) {
      const explain::Finding& cause = causes.front();
      out.entry("cause", fmt::format("{} {:.2f}", name_of(cause.cause), cause.likelihood),
                remedy_of(cause.cause));
    }
    return out.text();
  }

  const CompareOptions& options_;
  Host& host_;
  Side good_{host_};
  Side bad_{host_};
};

}  // namespace

void add_compare(Command& command) {
  const auto options = std::make_shared<CompareOptions>();
  Verb verb = command.add_verb(
      {.name = "compare",
       .purpose = "Show what differs between a link that works and one that does not",
       .examples = {"biss compare good.vcd bad.vcd",
                    "biss compare good.vcd bad.vcd -f resolute-26 --to jsonl"}},
      [options](Host& host) { return CompareRun(*options, host).run(); });
  verb.add_option("FILE", options->capture.files,
                  "The capture GOOD and the capture BAD; if each file has one line: the two "
                  "files of GOOD, then the two of BAD; - is standard input")
      .file(FileUse::read);
  add_reading_options(verb, options->capture);
  verb.add_flag("--no-compensation", options->capture.no_compensation,
                "The masters of these links sample half a period after their own edges of MA");
  add_output_option(verb, options->output);
  add_to_option(verb, options->to);
}

}  // namespace biss::verbs
