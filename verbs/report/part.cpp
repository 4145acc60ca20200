#include "verbs/report/part.hpp"

#include <fmt/format.h>
#include <openssl/evp.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <system_error>
#include <thread>

#include "biss/frame/format_text.hpp"
#include "capture/zip.hpp"
#include "decode/control_listener.hpp"
#include "verbs/common/verb.hpp"
#include "verbs/registers/access_rows.hpp"
#include "verbs/report/excerpt.hpp"
#include "verbs/report/overview.hpp"
#include "verbs/report/shared_reading.hpp"

namespace biss::verbs {

namespace {

using nlohmann::json;

constexpr std::uint64_t failed_max = 2000;
constexpr std::uint64_t first_max = 100;
constexpr std::uint64_t accesses_max = 2000;

// The row that was written last, as a line of CSV.
class LineRows final : public report::TableWriter {
 public:
  LineRows(std::span<const report::Column> columns, Overview& overview)
      : overview_(overview),
        writer_(report::make_table_writer(report::Format::csv, columns, sink_)) {
    header_ = take();
  }

  bool row(std::span<const report::Cell> cells) override {
    overview_.add(cells);
    return writer_->row(cells);
  }
  bool finish() override { return writer_->finish(); }
  std::string take() {
    writer_->finish();
    return sink_.take();
  }
  const std::string& header() const { return header_; }

 private:
  Overview& overview_;
  report::StringSink sink_;
  std::string header_;
  std::unique_ptr<report::TableWriter> writer_;
};

class PartMaker {
 public:
  PartMaker(const DecodeOptions& options, DecodeRun& run, std::string_view name)
      : options_(options), run_(run), name_(name) {}

  // Reads the capture, and runs the verbs of the page's panels on it.
  // \param given the options of the report
  ExitStatus read(const std::vector<const Option*>& given) {
    DecodedCapture& capture = run_.capture();
    const ExitStatus begun = run_.begin_rows();
    if (begun != ExitStatus::done) return begun;
    LineRows rows(run_.columns(), overview_);
    header_ = rows.header();
    std::vector<Panel> panels = panels_for(given);
    SharedReading reading(capture, excerpt_, panels.size());
    std::vector<std::jthread> threads;
    const EndOfReading at_end{reading};
    std::vector<Panel*> later;
    for (Panel& panel : panels) {
      try {
        threads.emplace_back([this, &panel, &reading] { answer(panel, reading); });
      } catch (const std::system_error&) {
        // The system gives no further threads.
        later.push_back(&panel);
        const SharedReading::Guest absent(reading);
      }
    }
    reading.wait();
    const auto take = [&](std::uint64_t number, const decode::Cycle& cycle) {
      reading.take(cycle);
      listener_.push(number, cycle);
      run_.take(number, cycle, rows);
      excerpt_.add({number, cycle.time, rows.take(), run_.took_error(), choose()});
      return true;
    };
    RunMessages messages;
    const ExitStatus ended = run_.end_rows(capture.read(take, &reading), messages);
    reading.end();
    threads.clear();
    for (Panel* panel : later) answer(*panel, reading);
    listener_.finish();
    access_rows_->finish();
    excerpt_.finish(capture.input().end_time());
    count_ = excerpt_.cycles().size();
    if (ended != ExitStatus::done) {
      messages.print(capture.host());
      return ended;
    }
    return collect(panels);
  }

  // \param room the most characters of both texts \pre read() was done
  CapturePart make(const std::vector<const Option*>& given, std::size_t room) {
    CapturePart part;
    part.settings = part_settings(page_settings(given));
    json report = report_with(part.settings);
    const auto pack = [&] {
      part.notes = notes();
      report["rows"] = rows();
      report["notes"] = part.notes;
      part.report = packed(report.dump(-1, ' ', false, json::error_handler_t::replace));
    };
    pack();
    const std::size_t chosen = count_;
    part.capture = packed_part(room - std::min(room, part.report.size()));
    if (count_ != chosen) pack();
    return part;
  }

 private:
  // The lines of the part have different names and their own polarity.
  PageSettings part_settings(const PageSettings& given) const {
    DecodedCapture& capture = run_.capture();
    PageSettings settings;
    settings.format = given.format;
    if (settings.format.empty()) {
      settings.format =
          capture.format() ? std::string(format_text(*capture.format()).view()) : "none";
    }
    settings.ma = "MA";
    settings.slo = "SLO";
    settings.invert_ma = capture.lines().lines.ma_inverted;
    settings.invert_slo = capture.lines().lines.slo_inverted;
    for (const PageOption& option : given.further) {
      if (option.scope != Scope::file) settings.further.push_back(option);
    }
    const Picoseconds resolution = capture.margin().resolution;
    if (resolution != Picoseconds{}) {
      settings.further.push_back(
          {Scope::file, {"--resolution", fmt::format("{}ps", resolution.count)}});
    }
    return settings;
  }

  // All cycles of the excerpt for which there is room.
  std::string packed_part(std::size_t room) {
    for (;;) {
      std::string text = packed(excerpt_.vcd(count_));
      if (text.size() <= room || count_ == 0) return text;
      const double share = static_cast<double>(room) / static_cast<double>(text.size());
      count_ = static_cast<std::size_t>(static_cast<double>(count_) * share * 0.97);
    }
  }

  // The rows of the cycles in the part, as `biss decode --to csv` writes them.
  std::string rows() const {
    std::string text = header_;
    for (std::size_t i = 0; i < count_; ++i) text += excerpt_.cycles()[i].row;
    return text;
  }

  // The report without rows and notes.
  json report_with(const PageSettings& settings) const {
    return {{"name", name_},
            {"settings",
             {{"format", settings.format},
              {"ma", settings.ma},
              {"slo", settings.slo},
              {"invertMa", settings.invert_ma},
              {"invertSlo", settings.invert_slo},
              {"units", "counts"},
              {"further", settings.further_text()}}},
            {"cycles", overview_.rows()},
            {"failed", failed_},
            {"summary", plain(run_.summary())},
            {"envelope", overview_.envelope()},
            {"causes", overview_.causes()},
            {"verbs", answers_}};
  }

  std::vector<std::string> notes() const {
    std::vector<std::string> notes;
    notes.push_back(fmt::format(
        "This report has the waveform and the rows of {} of {} request cycles: the first "
        "ones, and failed ones with their neighbours.",
        count_, overview_.rows()));
    notes.push_back(failed_shown() == failed_
                        ? fmt::format("All {} failed cycles are in it.", failed_)
                        : fmt::format("{} of {} failed cycles are in it, the earliest ones.",
                                      failed_shown(), failed_));
    if (excerpt_.lost() != 0) {
      notes.push_back(fmt::format(
          "{} of the cycles chosen are not in it, because they have too many edges or are "
          "before 0.",
          excerpt_.lost()));
    }
    if (accesses_ > accesses_max) {
      notes.push_back(fmt::format("The first {1} of {0} accesses to registers are in it.",
                                  accesses_, accesses_max));
    }
    notes.emplace_back(
        "Plots, causes, summary, identify, check, explain and accesses to registers cover "
        "the whole capture; the eye and the margins cover the cycles in the report.");
    return notes;
  }

  // After an exception, the threads end before their variables do.
  struct EndOfReading {
    SharedReading& reading;
    ~EndOfReading() { reading.end(); }
  };

  // A panel of the page, and the verb whose answer it shows.
  struct Panel {
    std::string name;
    std::string verb;
    GivenOptions options;
    ExitStatus status = ExitStatus::done;
    std::string out{};
    std::string err{};
    // The error of a verb that could not judge the capture.
    std::string error{};
    std::exception_ptr thrown{};
  };

  // `check` runs with the limits of the profiles, and with the limits of the encoder that the format
  // names.
  std::vector<Panel> panels_for(const std::vector<const Option*>& given) const {
    GivenOptions options{{"--to", {"jsonl"}}};
    for (const Option* option : given) {
      if (option->scope == Scope::command || option->name() == "--format") continue;
      options.emplace_back(option->name(), option->given);
    }
    std::vector<Panel> panels{{"identify", "identify", options}};
    std::vector<std::string> limits{"biss-c", "renishaw"};
    const std::string& format = options_.capture.device.format;
    if (!format.empty()) options.emplace_back("--format", std::vector{format});
    const auto device = parse_device(format.empty() ? "none" : format);
    if (device && device->timing_known()) limits.push_back(format);
    panels.push_back({"explain", "explain", options});
    for (const std::string& each : limits) {
      panels.push_back({"check " + each, "check", options});
      panels.back().options.emplace_back("--against", std::vector{each});
    }
    return panels;
  }

  // The thread of a panel.
  void answer(Panel& panel, SharedReading& reading) const {
    try {
      SharedReading::Guest guest(reading);
      MemoryHost host(&run_.capture().host(), &guest);
      Command command(host);
      add_verbs(command, panel.verb);
      std::vector<std::string> words{panel.verb};
      const std::vector<std::string>& files = options_.capture.files;
      words.insert(words.end(), files.begin(), files.end());
      panel.status = command.run(words, panel.options);
      panel.out = plain(host.output_text());
      panel.err = plain(host.text());
      if (panel.status >= ExitStatus::usage) {
        panel.error = host.lines().empty() ? "no message" : host.lines().back();
      }
    } catch (...) {
      panel.thrown = std::current_exception();
    }
  }

  // \return the status of the first verb that could not judge the capture
  ExitStatus collect(const std::vector<Panel>& panels) {
    answers_["registers"] = {{"status", 0}, {"out", access_text_.text()}, {"err", ""}};
    for (const Panel& panel : panels) {
      if (panel.thrown) std::rethrow_exception(panel.thrown);
      if (panel.status >= ExitStatus::usage) {
        return run_.capture().host().fail(panel.status, panel.name + ": " + panel.error);
      }
      answers_[panel.name] = {
          {"status", static_cast<int>(panel.status)}, {"out", panel.out}, {"err", panel.err}};
    }
    return ExitStatus::done;
  }

  bool choose() {
    const bool failed = run_.took_error();
    if (!failed) return good_++ < first_max;
    return failed_++ < failed_max;
  }

  std::uint64_t failed_shown() const {
    const auto begin = excerpt_.cycles().begin();
    return static_cast<std::uint64_t>(
        std::count_if(begin, begin + static_cast<std::ptrdiff_t>(count_),
                      [](const ExcerptCycle& cycle) { return cycle.failed; }));
  }

  // The text without the folders of this machine.
  std::string plain(std::string text) const {
    for (const std::string& file : options_.capture.files) {
      const std::string name = std::filesystem::path(file).filename().string();
      if (file == name) continue;
      for (std::size_t at = text.find(file); at != std::string::npos; at = text.find(file, at)) {
        text.replace(at, file.size(), name);
        at += name.size();
      }
    }
    return text;
  }

  const DecodeOptions& options_;
  DecodeRun& run_;
  std::string name_;
  Excerpt excerpt_{run_.capture().lines().lines};
  Overview overview_{run_.columns()};
  std::uint64_t good_ = 0;
  std::uint64_t failed_ = 0;
  std::string header_;
  // Cycles of the excerpt that are in the part.
  std::size_t count_ = 0;
  // The results of the verbs by the names of their panels.
  json answers_ = json::object();
  // The text that `biss registers --to jsonl` writes.
  report::StringSink access_text_;
  std::unique_ptr<report::TableWriter> access_rows_ =
      report::make_table_writer(report::Format::jsonl, access_columns(), access_text_);
  std::uint64_t accesses_ = 0;
  decode::ControlListener listener_{[this](const decode::SeenAccess& access) {
    if (accesses_++ < accesses_max) write_access(*access_rows_, access);
  }};
};

}  // namespace

std::string packed(std::string_view bytes) {
  const std::string zipped = capture::Deflater().gzip(bytes);
  std::string out((zipped.size() + 2) / 3 * 4 + 1, '\0');
  EVP_EncodeBlock(reinterpret_cast<unsigned char*>(out.data()),
                  reinterpret_cast<const unsigned char*>(zipped.data()),
                  static_cast<int>(zipped.size()));
  out.pop_back();  // the zero that it writes
  return out;
}

tl::expected<CapturePart, ExitStatus> part_of_capture(DecodeOptions& options, DecodeRun& run,
                                                      const std::vector<const Option*>& given,
                                                      std::string_view name, std::size_t room) {
  const auto& format = run.capture().format();
  options.motion.velocity = format && format->channel_list[0].position_bits() != 0;
  PartMaker maker(options, run, name);
  const ExitStatus status = maker.read(given);
  if (status != ExitStatus::done) return tl::unexpected(status);
  return maker.make(given, room);
}

}  // namespace biss::verbs
