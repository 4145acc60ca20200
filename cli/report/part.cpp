#include "cli/report/part.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <deque>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "biss/frame/format_text.hpp"
#include "capture/bytes.hpp"
#include "capture/open.hpp"
#include "cli/common/host.hpp"
#include "cli/common/terminal.hpp"
#include "cli/registers/access_rows.hpp"
#include "cli/report/asked.hpp"
#include "cli/report/excerpt.hpp"
#include "cli/report/overview.hpp"
#include "cli/report/packed.hpp"
#include "decode/control_listener.hpp"

namespace biss::cli {

namespace {

using nlohmann::json;

constexpr std::uint64_t failed_max = 2000;
constexpr std::uint64_t first_max = 100;
constexpr std::uint64_t accesses_max = 2000;

// The row that was written last, as text.
class LineRows final : public report::TableWriter {
 public:
  explicit LineRows(std::span<const report::Column> columns, Overview* overview = nullptr)
      : overview_(overview),
        writer_(report::make_table_writer(report::Format::csv, columns, sink_)) {
    writer_->finish();
    sink_.take();
  }

  bool row(std::span<const report::Cell> cells) override {
    if (overview_ != nullptr) overview_->add(cells);
    return writer_->row(cells);
  }
  bool finish() override { return writer_->finish(); }
  // Without the end of the line.
  std::string take() {
    writer_->finish();
    std::string line = sink_.take();
    if (line.ends_with('\n')) line.pop_back();
    return line;
  }

 private:
  Overview* overview_;
  report::StringSink sink_;
  std::unique_ptr<report::TableWriter> writer_;
};

std::vector<std::string> cells_of(const std::string& row) {
  std::vector<std::string> cells;
  std::size_t from = 0;
  for (;;) {
    const std::size_t comma = std::min(row.find(',', from), row.size());
    cells.push_back(row.substr(from, comma - from));
    if (comma == row.size()) return cells;
    from = comma + 1;
  }
}

class PartMaker final : private ChangeWatcher {
 public:
  PartMaker(DecodeOptions& options, DecodeRun& run, std::string_view name, Host& host)
      : options_(options), run_(run), name_(name), host_(host) {}

  // And asks what the verbs of the page's panels say of the whole capture: `check` with the limits of
  // the profiles, and of the encoder that the format names.
  ExitStatus read() {
    DecodedCapture& capture = run_.capture();
    const auto& format = capture.format();
    options_.motion.velocity = format && format->channel_list[0].position_bits() != 0;
    excerpt_.emplace(capture.lines().lines);
    overview_.emplace(run_.columns());
    ask();
    for (AskedVerb& verb : asked_) verb.open(capture);
    capture.watch(*this);
    const ExitStatus begun = run_.begin_rows();
    if (begun != ExitStatus::done) return begun;
    LineRows rows(run_.columns(), &*overview_);
    const bool read = capture.read([&](std::uint64_t number, const decode::Cycle& cycle) {
      listener_.push(number, cycle);
      run_.take(number, cycle, rows);
      excerpt_->add({number, cycle.time, rows.take(), run_.took_error(), choose()});
      for (AskedVerb& verb : asked_) verb.take(number, cycle);
      return true;
    });
    RunMessages messages;
    const ExitStatus ended = run_.end_rows(read, messages);
    listener_.finish();
    access_rows_->finish();
    excerpt_->finish(capture.input().end_time());
    if (ended != ExitStatus::done) messages.print(host_);
    return ended;
  }

  // The lines of the part have names and a polarity of their own.
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
    for (const std::vector<std::string>& option : given.further) {
      const std::string& name = option.front();
      const bool of_file = name == "--raw-rate" || name == "--raw-bytes" || name == "--threshold" ||
                           name == "--differential";
      if (!of_file && name != "--resolution") settings.further.push_back(option);
    }
    const Picoseconds resolution = capture.margin().resolution;
    if (resolution != Picoseconds{}) {
      settings.further.push_back({"--resolution", fmt::format("{}ps", resolution.count)});
    }
    return settings;
  }

  // As many cycles of the excerpt as there is room for.
  std::string packed_part(std::size_t room) {
    count_ = excerpt_->cycles().size();
    for (;;) {
      vcd_ = excerpt_->vcd(count_);
      std::string text = packed(vcd_);
      if (text.size() <= room || count_ == 0) return text;
      const double share = static_cast<double>(room) / static_cast<double>(text.size());
      count_ = static_cast<std::size_t>(static_cast<double>(count_) * share * 0.97);
    }
  }

  ExitStatus verify(const PageSettings& settings) {
    MemoryHost host(&host_);
    const std::string file = "part.vcd";
    host.give(file, {[&](const InputArguments&) {
                return capture::open_capture(capture::memory_bytes(vcd_), file, {});
              }});
    DecodeOptions options;
    options.capture = options_.capture;
    options.capture.files = {file};
    options.capture.device.format = settings.format;
    options.capture.ma = "MA";
    options.capture.slo = "SLO";
    options.capture.invert_ma = settings.invert_ma;
    options.capture.invert_slo = settings.invert_slo;
    options.capture.resolution = run_.capture().margin().resolution;
    options.capture.raw = {};
    options.motion = options_.motion;
    DecodeRun run(options, host);
    std::map<std::int64_t, std::string> rows;
    ExitStatus status = run.open();
    if (status == ExitStatus::done) status = run.next();
    if (status != ExitStatus::done) return status;
    LineRows writer(run.columns());
    status = run.begin_rows();
    if (status != ExitStatus::done) return status;
    run.capture().read([&](std::uint64_t number, const decode::Cycle& cycle) {
      run.take(number, cycle, writer);
      rows.emplace(cycle.time.count, writer.take());
      return true;
    });
    compare(rows);
    return ExitStatus::done;
  }

  // Of the part, after verify().
  json rows() const {
    json rows{{"times", json::array()}, {"numbers", json::array()}, {"cells", cells_}};
    for (const ExcerptCycle* cycle : shown_) {
      rows["times"].push_back(std::to_string(cycle->time.count));
      rows["numbers"].push_back(cycle->number);
    }
    return rows;
  }

  // But for rows, verbs and notes.
  json report(const PageSettings& settings) const {
    return {{"name", name_},
            {"settings",
             {{"format", settings.format},
              {"ma", settings.ma},
              {"slo", settings.slo},
              {"invertMa", settings.invert_ma},
              {"invertSlo", settings.invert_slo},
              {"units", "counts"},
              {"further", settings.further_text()}}},
            {"cycles", overview_->rows()},
            {"failed", failed_},
            {"summary", plain(run_.summary())},
            {"envelope", overview_->envelope()},
            {"causes", overview_->causes()}};
  }

  // What the verbs say, by their names: `check` by that of its limits too.
  tl::expected<json, VerbError> verbs() {
    json answers = json::object();
    for (AskedVerb& verb : asked_) {
      auto answer = verb.answer(run_.capture().input().end_time());
      if (!answer) return answer;
      for (const char* text : {"out", "err"}) {
        (*answer)[text] = plain((*answer)[text].get<std::string>());
      }
      answers[verb.name()] = std::move(*answer);
    }
    answers["registers"] = {{"status", 0}, {"out", access_text_.text()}, {"err", ""}};
    return answers;
  }

  std::vector<std::string> notes() const {
    std::vector<std::string> notes;
    notes.push_back(fmt::format(
        "This report has the waveform and the rows of {} of {} request cycles: the first "
        "ones, and failed ones with their neighbours.",
        shown_.size(), overview_->rows()));
    notes.push_back(failed_shown() == failed_
                        ? fmt::format("All {} failed cycles are in it.", failed_)
                        : fmt::format("{} of {} failed cycles are in it, the earliest ones.",
                                      failed_shown(), failed_));
    if (!unlike_.empty()) {
      notes.push_back(fmt::format(
          "{} failed cycles cannot be shown without the rest of the capture, the first is {}.",
          unlike_.size(), unlike_.front()));
    }
    if (excerpt_->lost() != 0) {
      notes.push_back(fmt::format(
          "{} of the cycles chosen are not in it, because they have too many edges or are "
          "before 0.",
          excerpt_->lost()));
    }
    if (accesses_ > accesses_max) {
      notes.push_back(fmt::format("Of {} accesses to registers the first {} are in it.", accesses_,
                                  accesses_max));
    }
    notes.emplace_back(
        "Plots, causes, summary, identify, check, explain and accesses to registers are those of "
        "the whole capture; the eye and the margins are those of the cycles in the report.");
    return notes;
  }

 private:
  void ask() {
    const CaptureArguments& capture = options_.capture;
    const auto ask = [this](std::string name, auto make) {
      asked_.emplace_back(std::move(name), host_, make);
    };
    ask("identify", [&](Host& host) { return identify_run(capture, host); });
    ask("explain", [&](Host& host) { return explain_run(capture, host); });
    std::vector<std::string> limits{"biss-c", "renishaw"};
    const std::string& format = capture.device.format;
    const auto device = parse_device(format.empty() ? "none" : format);
    if (device && device->timing_known()) limits.push_back(format);
    for (const std::string& each : limits) {
      ask("check " + each, [&](Host& host) { return check_run(capture, each, host); });
    }
  }

  void take(std::span<const wire::Edge> edges) override { show(edges); }
  void take(const capture::PairPiece& changes) override { show(changes); }
  template <class Changes>
  void show(const Changes& changes) {
    excerpt_->take(changes);
    for (AskedVerb& verb : asked_) {
      if (verb.watcher() != nullptr) verb.watcher()->take(changes);
    }
  }

  bool choose() {
    const bool failed = run_.took_error();
    if (!failed) return good_++ < first_max;
    return failed_++ < failed_max;
  }

  std::uint64_t failed_shown() const {
    return static_cast<std::uint64_t>(std::count_if(
        shown_.begin(), shown_.end(), [](const ExcerptCycle* cycle) { return cycle->failed; }));
  }

  // Without the folders of this machine.
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

  void compare(const std::map<std::int64_t, std::string>& rows) {
    const auto& columns = run_.columns();
    for (std::size_t i = 0; i < count_; ++i) {
      const ExcerptCycle& cycle = excerpt_->cycles()[i];
      const auto found = rows.find(cycle.time.count);
      json other = json::array();
      bool same = found != rows.end();
      if (same) {
        const auto whole = cells_of(cycle.row);
        const auto part = cells_of(found->second);
        same = whole.size() == columns.size() && part.size() == columns.size();
        // The first one is the number of the row.
        for (std::size_t k = 1; same && k < columns.size(); ++k) {
          if (whole[k] == part[k]) continue;
          same = columns[k].of_other_rows;
          other.push_back({shown_.size(), columns[k].name, whole[k]});
        }
      }
      if (same) {
        shown_.push_back(&cycle);
        cells_.insert(cells_.end(), other.begin(), other.end());
      } else if (cycle.failed && cycle.chosen) {
        unlike_.push_back(cycle.number);
      }
    }
  }

  DecodeOptions& options_;
  DecodeRun& run_;
  std::string name_;
  Host& host_;
  std::optional<Excerpt> excerpt_;
  std::optional<Overview> overview_;
  std::deque<AskedVerb> asked_;
  std::uint64_t good_ = 0;
  std::uint64_t failed_ = 0;
  std::string vcd_;
  std::size_t count_ = 0;
  std::vector<const ExcerptCycle*> shown_;
  // Cells that the part alone does not give: place in shown_, column, text.
  json cells_ = json::array();
  std::vector<std::uint64_t> unlike_;
  // As `biss registers --to jsonl` writes them.
  report::StringSink access_text_;
  std::unique_ptr<report::TableWriter> access_rows_ =
      report::make_table_writer(report::Format::jsonl, access_columns(), access_text_);
  std::uint64_t accesses_ = 0;
  decode::ControlListener listener_{[this](const decode::SeenAccess& access) {
    if (accesses_++ < accesses_max) write_access(*access_rows_, access);
  }};
};

}  // namespace

tl::expected<CapturePart, ExitStatus> part_of_capture(DecodeOptions& options, DecodeRun& run,
                                                      const PageSettings& settings,
                                                      std::string_view name, std::size_t room,
                                                      Host& host) {
  PartMaker maker(options, run, name, host);
  ExitStatus status = maker.read();
  if (status != ExitStatus::done) return tl::unexpected(status);
  CapturePart part;
  part.settings = maker.part_settings(settings);
  const auto verbs = maker.verbs();
  if (!verbs) return tl::unexpected(host.fail(verbs.error()));
  json report = maker.report(part.settings);
  report["verbs"] = *verbs;
  const auto dumped = [&report] {
    return report.dump(-1, ' ', false, json::error_handler_t::replace);
  };
  // Numbers of rows and times take little room beside the edges.
  constexpr std::size_t rows_room = 150'000;
  const std::size_t fixed = packed(dumped()).size() + rows_room;
  part.capture = maker.packed_part(room - std::min(room, fixed));
  status = maker.verify(part.settings);
  if (status != ExitStatus::done) return tl::unexpected(status);
  part.notes = maker.notes();
  report["rows"] = maker.rows();
  report["notes"] = part.notes;
  part.report = packed(dumped());
  return part;
}

}  // namespace biss::cli
