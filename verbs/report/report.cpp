// `biss report`: the page with a capture in it, as one file.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>
#include <system_error>

#include "report/summary.hpp"
#include "verbs/common/page.hpp"
#include "verbs/common/text_file.hpp"
#include "verbs/common/verb.hpp"
#include "verbs/decode/decode_run.hpp"
#include "verbs/report/part.hpp"

namespace biss::verbs {

namespace {

namespace fs = std::filesystem;

// A capture is in the report as a whole up to these sizes: of the file, and of its text in the page.
constexpr std::uintmax_t whole_file_max = std::uintmax_t{16} << 20U;
constexpr std::size_t whole_text_max = 3'300'000;
// A report that has a part of a capture, with the page.
constexpr std::size_t report_max = 4'900'000;

struct ReportOptions {
  DecodeOptions decode;
  std::string output;
  std::string page;
  std::optional<Verb> verb;
};

class ReportRun {
 public:
  ReportRun(ReportOptions& options, Host& host) : options_(options), host_(host) {}

  ExitStatus run() {
    const std::vector<std::string>& files = options_.decode.capture.files;
    for (const std::string& file : files) {
      std::error_code problem;
      if (host_.capture(file) != nullptr ||
          (file != "-" && (!fs::exists(file, problem) || fs::is_regular_file(file, problem)))) {
        continue;
      }
      return host_.fail(
          ExitStatus::usage,
          fmt::format("{}: a report reads a capture several times; give a file", file));
    }
    const std::string page = read_page(options_.page);
    DecodeRun decode(options_.decode, host_);
    ExitStatus status = decode.open();
    if (status != ExitStatus::done) return status;
    if (decode.capture().several()) {
      return host_.fail(
          ExitStatus::usage,
          "a report has one capture and one pair of lines: give one file, or one for each "
          "line, and name the lines with --ma and --slo");
    }
    status = decode.next();
    if (status != ExitStatus::done) return status;
    const std::vector<const Option*> given = options_.verb->given_options();
    const std::string name = fs::path(files.front()).filename().string();
    if (const auto text = whole_capture()) {
      const std::string view = page_settings(given).link_text();
      return write(page_with(page, "biss-capture", {{"name", name}, {"view", view}}, *text),
                   "the whole capture");
    }
    const std::size_t room = report_max - std::min(report_max, page.size());
    const auto part = part_of_capture(options_.decode, decode, given, name, room);
    if (!part) return part.error();
    const std::string view = part->settings.link_text();
    return write(page_with(page_with(page, "biss-report", {}, part->report), "biss-capture",
                           {{"name", name}, {"view", view}}, part->capture),
                 fmt::format("{}", fmt::join(part->notes, " ")));
  }

 private:
  // The bytes of the capture as text; empty if there are too many.
  std::optional<std::string> whole_capture() const {
    const std::vector<std::string>& files = options_.decode.capture.files;
    std::error_code problem;
    if (files.size() != 1 || host_.capture(files.front()) != nullptr ||
        fs::file_size(files.front(), problem) > whole_file_max) {
      return std::nullopt;
    }
    const auto bytes = read_text_file(files.front());
    if (!bytes) return std::nullopt;
    std::string text = packed(*bytes);
    return text.size() > whole_text_max ? std::nullopt : std::optional(std::move(text));
  }

  ExitStatus write(const std::string& page, const std::string& contains) {
    const ExitStatus written =
        write_output(host_, options_.output, [&](Output& output) { return output.write(page); });
    if (written != ExitStatus::done) return written;
    report::Summary out;
    const bool is_file = options_.output != "-";
    out.title(fmt::format("{}: {:.2f} MB", is_file ? options_.output : "standard output",
                          static_cast<double>(page.size()) / 1e6));
    out.entry("contains", contains);
    host_.print_summary(out.text());
    return ExitStatus::done;
  }

  ReportOptions& options_;
  Host& host_;
};

}  // namespace

void add_report(Command& command) {
  const auto options = std::make_shared<ReportOptions>();
  const Verb verb = command.add_verb(
      {.name = "report",
       .purpose = "Write a page that shows a capture in any browser, in a single file",
       .examples = {"biss report capture.vcd -f resolute-26 -o report.html",
                    "biss report ma.csv slo.csv --ma ma.csv:D0 --slo slo.csv:D1 -o report.html",
                    "biss report samples.bin --raw-rate 100MHz --ma D0 --slo D3 -o report.html"}},
      [options](Host& host) { return ReportRun(*options, host).run(); });
  CaptureArguments& capture = options->decode.capture;
  capture.identify = true;
  // For the verbs that judge the same cycles.
  capture.signal = true;
  verb.add_option("FILE", capture.files,
                  "The capture (VCD, FST, event CSV, oscilloscope CSV, .sr, .dsl, Saleae CSV "
                  "and binary, raw samples; also compressed by gzip or zstd); files with one line "
                  "each are read as one capture")
      .file(FileUse::read);
  add_reading_options(verb, capture);
  add_output_option(verb, options->output, "The page to write").required();
  add_page_option(verb, options->page);
  options->verb = verb;
}

}  // namespace biss::verbs
