#include "verbs/common/decoded_capture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "biss/frame/format_text.hpp"
#include "decode/polarity.hpp"
#include "decode/statistics.hpp"
#include "flow/cycle_flow.hpp"
#include "identify/collector.hpp"
#include "report/summary.hpp"
#include "verbs/common/host.hpp"
#include "verbs/common/identified.hpp"
#include "verbs/common/terminal.hpp"

namespace biss::verbs {

namespace {

// `FILE` of `FILE:NAME`.
std::string file_of_line(const std::string& text) {
  const std::size_t colon = text.rfind(':');
  return colon == std::string::npos ? std::string() : text.substr(0, colon);
}

constexpr std::uint64_t least_contradiction = 20;

// The frame is whole, and not one of the format.
bool contradicts(CycleStatus status) {
  using enum CycleStatus;
  return status == crc || status == stop_bit || status == truncated || status == cds;
}

bool is_resolution(Picoseconds time) { return time >= Picoseconds{} && time <= milliseconds(1); }

// Adds the same cells at the end of each row.
class CaptureRows final : public report::TableWriter {
 public:
  CaptureRows(report::TableWriter& writer, std::size_t columns, const Output& output,
              bool needs_all)
      : writer_(writer), columns_(columns), output_(output), needs_all_(needs_all) {}

  void set_last_cells(std::vector<report::Cell> cells) { last_ = std::move(cells); }
  // False when the rows cannot be written, or are of no use because their reader has left.
  bool good() const { return good_; }

  bool row(std::span<const report::Cell> cells) override {
    if (!last_.empty()) {
      row_.assign(cells.begin(), cells.end());
      row_.resize(columns_ - last_.size());
      row_.insert(row_.end(), last_.begin(), last_.end());
      cells = row_;
    }
    good_ = writer_.row(cells) && (needs_all_ || !output_.reader_left());
    return good_;
  }
  bool finish() override { return writer_.finish(); }

 private:
  report::TableWriter& writer_;
  std::size_t columns_;
  const Output& output_;
  bool needs_all_;
  std::vector<report::Cell> last_;
  std::vector<report::Cell> row_;
  bool good_ = true;
};

}  // namespace

namespace {

constexpr auto any_format = "; none: check the structure alone";

void add_decode_options(Verb verb, CaptureArguments& arguments,
                        const std::string& about_format = any_format) {
  add_format_option(verb, arguments.device, false, about_format);
  add_timing_options(verb, arguments.device);
  verb.add_option("--ma", arguments.ma, "The line that is MA")
      .type_name("NAME|FILE:NAME")
      .file(FileUse::read, file_of_line);
  verb.add_option("--slo", arguments.slo, "The line that is SLO")
      .type_name("NAME|FILE:NAME")
      .file(FileUse::read, file_of_line);
  const Verb of_file = verb.scope(Scope::file);
  of_file.add_flag("--invert-ma", arguments.invert_ma, "Treat MA as inverted; detected by default");
  of_file.add_flag("--invert-slo", arguments.invert_slo,
                   "Treat SLO as inverted; detected by default");
  add_duration_option(
      of_file, "--resolution", into(arguments.resolution),
      "Edge timing uncertainty of the capture; by default the sample period that the "
      "file gives, else 0");
}

}  // namespace

void add_capture_options(Verb verb, CaptureArguments& arguments, bool finds_format) {
  verb.add_option("FILE", arguments.files,
                  "Captures (VCD, FST, event CSV, oscilloscope CSV, .sr, .dsl, Saleae CSV and "
                  "binary, raw samples; also compressed by gzip or zstd), read one after the "
                  "other; files with one line each are read as one capture; - is standard input")
      .file(FileUse::read);
  add_decode_options(verb, arguments,
                     finds_format ? "; refused here: this verb finds the format" : any_format);
  arguments.has_each = true;
  verb.scope(Scope::file)
      .add_flag("--each", arguments.each,
                "Read every encoder of a capture: all pairs of MA and SLO, one after the other");
  add_raw_options(verb, arguments.raw);
}

void add_single_capture_options(Verb verb, CaptureArguments& arguments) {
  verb.add_option("FILE", arguments.files,
                  "The capture (VCD, FST, event CSV, oscilloscope CSV, .sr, .dsl, Saleae CSV "
                  "and binary, raw samples; also compressed by gzip or zstd); files with one line "
                  "each are read as one capture")
      .file(FileUse::read);
  add_decode_options(verb, arguments);
  add_raw_options(verb, arguments.raw);
}

void add_page_capture_options(Verb verb, CaptureArguments& arguments) {
  verb.add_text_option(
          "FILE", [&arguments](const std::string& file) { arguments.files = {file}; },
          "The capture (VCD, FST, event CSV, oscilloscope CSV, .sr, .dsl, Saleae CSV and "
          "binary, raw samples; also compressed by gzip). Drop several files with one line each on "
          "the page")
      .required()
      .file(FileUse::read);
  add_decode_options(verb, arguments);
  add_raw_options(verb, arguments.raw);
}

void add_folder_options(Verb verb, CaptureArguments& arguments) {
  verb.add_option("DIR", arguments.files,
                  "Folders with captures of any format, and the folders in them; also single files")
      .file(FileUse::read);
  add_decode_options(verb, arguments);
  add_raw_options(verb, arguments.raw);
}

void add_pair_options(Verb verb, CaptureArguments& arguments) {
  verb.add_option("FILE", arguments.files,
                  "The capture GOOD and the capture BAD; if each file has one line: the two "
                  "files of GOOD, then the two of BAD; - is standard input")
      .file(FileUse::read);
  add_decode_options(verb, arguments);
  add_raw_options(verb, arguments.raw);
}

void add_range_options(Verb verb, CaptureArguments& arguments) {
  add_time_option(verb, "--since", into(arguments.since),
                  "Skip cycles that begin before this time");
  add_time_option(verb, "--until", into(arguments.until), "Skip cycles that begin after this time");
}

ExitStatus DecodedCapture::open(const CaptureArguments& arguments, const MarginArguments& margin) {
  const std::string range = wrong_range(arguments.since, arguments.until);
  if (!range.empty()) return host_.fail(ExitStatus::usage, range);
  range_ = {arguments.since, arguments.until};
  identifies_ = arguments.identify && arguments.device.format.empty();
  finds_format_ = identifies_ || (arguments.identify_besides && !arguments.device.format.empty());
  if (arguments.device.format.empty() || arguments.device.format == "none") {
    const auto timing =
        override_timing(arguments.device, arguments.timing.value_or(DeviceTiming{}));
    if (!timing) return host_.fail(ExitStatus::usage, timing.error());
    timing_ = *timing;
  } else {
    auto choice = choose_device(arguments.device);
    if (!choice) return host_.fail(ExitStatus::usage, choice.error());
    if (arguments.timing) {
      const auto timing = override_timing(arguments.device, *arguments.timing);
      if (!timing) return host_.fail(ExitStatus::usage, timing.error());
      choice->timing = *timing;
    }
    format_ = choice->format;
    timing_ = choice->timing;
  }
  keeps_unknown_ = arguments.keep_unknown;
  resolution_ = arguments.resolution;
  threads_ = arguments.threads;
  invert_ma_ = arguments.invert_ma;
  invert_slo_ = arguments.invert_slo;
  margin_.compensated = !margin.no_compensation;
  margin_.signal = margin.signal;
  if (resolution_ && !is_resolution(*resolution_)) {
    return host_.fail(ExitStatus::usage, "--resolution: from 0s to 1ms");
  }
  if (arguments.words.file.empty()) return list_.open(arguments);
  words_ = arguments.words;
  // A word does not show how the device behaves in time.
  timing_ = {};
  return ExitStatus::done;
}

bool DecodedCapture::next() {
  if (words_) return log_.empty() && open_words();
  decoder_.reset();
  outside_ = 0;
  if (pair_ + 1 < pairs_.size()) {
    ++pair_;
    ExitStatus opened = input_.reopen(list_.arguments());
    if (opened == ExitStatus::done) opened = identify_format();
    status_ = std::max(status_, opened);
    return opened == ExitStatus::done;
  }
  while (status_ <= ExitStatus::data_failed && !list_.at_end()) {
    if (open_next()) return true;
  }
  return false;
}

bool DecodedCapture::open_words() {
  auto log = read_word_log(*words_);
  if (!log) status_ = host_.fail(ExitStatus::io, log.error());
  if (words_->reading.payload && !format_) {
    status_ =
        host_.fail(ExitStatus::usage, "--payload: the length of the frame is not known; give -f");
  }
  if (status_ != ExitStatus::done) return false;
  log_ = std::move(*log);
  if (!finds_format_) return true;
  identify::SampleCollector frames;
  read_words(decode::CycleReader(std::nullopt, {}),
             [&frames](std::uint64_t number, const auto& cycle) {
               frames.add(number, cycle);
               return true;
             });
  take_finding(frames.samples());
  if (const auto* sure = finding_->sure(); identifies_ && sure != nullptr) format_ = sure->format;
  return true;
}

bool DecodedCapture::read_words(const decode::CycleReader& reader, const OnCycle& on_cycle) {
  for (std::size_t i = 0; i < log_.size(); ++i) {
    timed_ = log_[i].time.has_value();
    if (!on_cycle(i, cycle_of(log_[i], words_->reading, reader, format_))) break;
  }
  return true;
}

std::string DecodedCapture::fitting_options() const {
  std::vector<Word> words;
  std::size_t good = 0;
  for (const LoggedWord& logged : log_) {
    words.push_back(logged.word);
    if (is_good(logged.word, words_->reading, *format_)) ++good;
  }
  if (2 * good > words.size()) return {};
  return verbs::fitting_options({{words_->reading.digits, words}}, words_->reading, *format_);
}

bool DecodedCapture::open_next() {
  pairs_.clear();
  pair_ = 0;
  if (identifies_) format_.reset();
  ExitStatus status = list_.open_next(input_);
  if (status == ExitStatus::done) {
    margin_.resolution = resolution_.value_or(input_.sample_period());
    auto found = input_.find_lines(list_.arguments(), reader(), keeps_unknown_);
    if (found) {
      pairs_ = std::move(*found);
      for (decode::FoundLines& pair : pairs_) measure_polarity(pair);
      status = identify_format();
    } else if (!keeps_unknown_ || found.error() != ExitStatus::data_failed) {
      status = found.error();
      if (identifies_ && status == ExitStatus::data_failed) warn_of_protocol();
    }
  }
  status_ = std::max(status_, status);
  return status == ExitStatus::done;
}

namespace {

// The frames of a capture, read without a format.
class FrameCollection {
 public:
  explicit FrameCollection(const DecodedCapture& capture)
      : lines_(capture.lines().lines),
        decoder_(decode::CycleReader(std::nullopt, {.timeout = capture.reading_timing().timeout},
                                     capture.margin()),
                 [this, &capture](const decode::Cycle& cycle) {
                   if (capture.is_wanted(cycle)) collector_.add(number_, cycle);
                   ++number_;
                 }) {}

  void push(std::span<const wire::Edge> edges) {
    decoder_.push(edges, lines_);
    edges_ += edges.size();
  }
  std::span<const identify::Sample> finish(Picoseconds end) {
    decoder_.finish(end);
    return collector_.samples();
  }
  std::size_t edges() const { return edges_; }

 private:
  decode::Lines lines_;
  identify::SampleCollector collector_;
  std::uint64_t number_ = 0;
  std::size_t edges_ = 0;
  decode::Decoder decoder_;
};

}  // namespace

// Identifies the format from the beginning of the capture; if that does not show it, or if the
// capture is short, from all of it. Fails if the capture cannot be opened a second time.
ExitStatus DecodedCapture::identify_format() {
  constexpr std::uint64_t short_bytes = std::uint64_t{64} << 20U;
  paused_timeout_.reset();
  if (identifies_) format_.reset();
  if (!format_ && !reader().knows_timeout()) {
    paused_timeout_ = decode::find_paused_timeout(lines().lines, input_.beginning());
  }
  if (!finds_format_) return ExitStatus::done;
  FrameCollection frames(*this);
  frames.push(input_.beginning());
  const auto first = input_.beginning();
  take_finding(frames.finish(first.empty() ? Picoseconds{} : first.back().time));
  ExitStatus status = ExitStatus::done;
  const bool all = finding_->sure() == nullptr || input_.bytes() <= short_bytes;
  if (identifies_ && all && input_.can_reopen()) status = identify_from_all();
  const auto* sure = finding_->sure();
  if (identifies_ && sure != nullptr) format_ = sure->format;
  return status;
}

ExitStatus DecodedCapture::identify_from_all() {
  FrameCollection frames(*this);
  const std::size_t first = input_.beginning().size();
  Progress progress(host_);
  for (auto block = input_.next(); !block.empty(); block = input_.next()) {
    frames.push(block);
    if (progress.due()) {
      progress.show(input_.progress_text(progress.seconds()) + ", to identify the format");
    }
  }
  const auto samples = frames.finish(input_.end_time());
  if (frames.edges() > first) {
    const auto* sure = finding_->sure();
    const auto before = sure != nullptr ? std::optional(sure->format) : std::nullopt;
    take_finding(samples);
    sure = finding_->sure();
    if (before && (sure == nullptr || sure->format != *before)) {
      host_.warn(fmt::format("{}: later frames contradict {}, which the beginning shows; {}",
                             input_.name(), format_text(*before).view(),
                             sure == nullptr ? std::string("no format is sure for all: give -f")
                                             : fmt::format("all frames are judged by {}",
                                                           format_text(sure->format).view())));
    }
  }
  return input_.reopen(list_.arguments());
}

// If the frames change their length, this is the format of the longest part.
void DecodedCapture::take_finding(std::span<const identify::Sample> samples) {
  std::vector<identify::FormatPart> parts = identify::find_parts(samples);
  const auto longest =
      std::max_element(parts.begin(), parts.end(), [](const auto& a, const auto& b) {
        return a.to_cycle - a.from_cycle < b.to_cycle - b.from_cycle;
      });
  finding_ = longest == parts.end() ? identify::FormatFinding{} : longest->finding;
  const auto* sure = finding_->sure();
  finding_agrees_ =
      sure != nullptr && format_ && identify::same_verdicts(*format_, sure->format, samples);
  format_parts_.clear();
  if (parts.size() < 2) return;
  for (const identify::FormatPart& part : parts) {
    const auto* format = part.finding.sure();
    format_parts_ += fmt::format("{}{} from cycle {} to {}", format_parts_.empty() ? "" : ", ",
                                 format == nullptr ? "an unknown format" : text_of(format->format),
                                 part.from_cycle, part.to_cycle);
  }
  if (!identifies_) return;
  host_.warn(
      fmt::format("{}: the format changes: {}; decode each part with -f and --since, --until",
                  input_.name(), format_parts_));
}

const identify::FormatCandidate* DecodedCapture::better_format() const {
  return finding_ && !finding_agrees_ ? finding_->sure() : nullptr;
}

identify::ProtocolGuess DecodedCapture::protocol() {
  const auto first = input_.beginning();
  const Picoseconds end = first.empty() ? Picoseconds{} : first.back().time;
  return identify::recognise_protocol(first, input_.lines().size(), input_.sample_period(), end)
      .front();
}

void DecodedCapture::warn_of_protocol() {
  const identify::ProtocolGuess guess = protocol();
  if (guess.protocol == identify::Protocol::unknown ||
      guess.protocol == identify::Protocol::biss_c) {
    return;
  }
  host_.warn(fmt::format("{}: the lines look like {} ({})", input_.name(), name_of(guess.protocol),
                         guess.why));
}

void DecodedCapture::measure_polarity(decode::FoundLines& found) {
  found.lines.ma_inverted = invert_ma_;
  found.lines.slo_inverted = invert_slo_;
  found.lines = decode::find_polarity(found.lines, input_.beginning(), reader());
  found.look_swapped = found.look_swapped && !found.lines.slo_inverted;
}

std::vector<report::Column> DecodedCapture::columns() const {
  std::vector<report::Column> columns;
  if (list_.several() && !keeps_unknown_) columns.push_back({.name = "file"});
  if (!list_.arguments().each || keeps_unknown_) return columns;
  columns.push_back({.name = "ma", .heading = "MA"});
  columns.push_back({.name = "slo", .heading = "SLO"});
  return columns;
}

std::vector<report::Cell> DecodedCapture::cells() const {
  std::vector<report::Cell> cells;
  if (list_.several() && !keeps_unknown_) cells.emplace_back(input_.name());
  if (!list_.arguments().each || keeps_unknown_) return cells;
  cells.emplace_back(ma_name());
  cells.emplace_back(slo_name());
  return cells;
}

decode::Decoder& DecodedCapture::decoder() {
  if (!decoder_) {
    decoder_.emplace(reader(), [this](const decode::Cycle& cycle) { deliver_(cycle); });
  }
  return *decoder_;
}

Picoseconds DecodedCapture::interval() {
  decode::Statistics first;
  const auto add = [&first](const decode::Cycle& cycle) { first.add(cycle); };
  if (words_) {
    read_words(reader(), [&](std::uint64_t, const auto& cycle) { return add(cycle), true; });
  } else {
    decode::Decoder decoder(reader(), add);
    decoder.push(beginning(), lines().lines);
  }
  const decode::Distribution& interval = first.interval();
  return interval.count() == 0 ? Picoseconds{} : picoseconds(interval.median());
}

void DecodedCapture::push(std::span<const wire::Edge> edges) {
  if (watcher_ != nullptr) watcher_->take(edges);
  decoder().push(edges, lines().lines);
}

void DecodedCapture::begin_steps(OnCycle on_cycle) {
  on_step_ = std::move(on_cycle);
  step_number_ = 0;
  step_wanted_ = true;
  deliver_ = [this](const decode::Cycle& cycle) {
    step_wanted_ = step_wanted_ && hand_out(step_number_++, cycle, on_step_);
  };
  const decode::CleanCycleFinder finder(format_, reading_timing(), margin_);
  if (!finder.may_find()) return;
  piece_.emplace(finder);
  join_.emplace(finder, decoder());
  pair_source_ = &input_.pairs(lines().lines);
}

bool DecodedCapture::step() {
  if (!step_wanted_) return false;
  if (piece_) return step_piece();
  const auto block = input_.next();
  if (block.empty()) return false;
  push(block);
  return true;
}

bool DecodedCapture::step_piece() {
  if (!piece_->fetch(*pair_source_)) return false;
  piece_->expand(lines().lines);
  piece_->settle(*pair_source_, lines().lines, *join_, watch_of_pieces());
  return !pair_source_->error();
}

bool DecodedCapture::end_steps() {
  if (piece_) {
    input_.end_pairs();
    join_->flush();
  }
  decoder().finish(input_.end_time());
  join_.reset();
  decoder_.reset();
  piece_.reset();
  return input_.error().empty();
}

bool DecodedCapture::read(const OnCycle& on_cycle) {
  if (words_) return read_words(reader(), on_cycle);
  good_ = contradict_ = 0;
  std::uint64_t number = 0;
  bool wanted = true;
  Progress progress(host_);
  deliver_ = [&](const decode::Cycle& cycle) {
    count(cycle);
    wanted = wanted && hand_out(number++, cycle, on_cycle);
  };
  const auto go_on = [&] {
    if (progress.due()) {
      const double seconds = progress.seconds();
      progress.show(fmt::format("{}, {} request cycles{}", input_.progress_text(seconds), number,
                                rate_text(static_cast<double>(number) / seconds, "cycles")));
    }
    return wanted;
  };
  const decode::CleanCycleFinder finder(format_, reading_timing(), margin_);
  if (finder.may_find()) {
    read_pieces(finder, go_on);
  } else {
    read_blocks(go_on);
  }
  decoder().finish(input_.end_time());
  decoder_.reset();
  end_following();
  return input_.error().empty();
}

void DecodedCapture::count(const decode::Cycle& cycle) {
  good_ += cycle.status == CycleStatus::ok ? 1U : 0U;
  contradict_ += contradicts(cycle.status) ? 1U : 0U;
}

void DecodedCapture::follow(std::uint64_t number, const decode::Cycle& cycle,
                            const OnCycle& on_cycle) {
  count(cycle);
  hand_out(number, cycle, on_cycle);
}

void DecodedCapture::end_following() {
  if (!identifies_ || !format_ || watcher_ != nullptr || contradict_ <= least_contradiction ||
      4 * contradict_ <= good_) {
    return;
  }
  host_.warn(fmt::format("{}: {} frames contradict {}, which the beginning shows; give -f",
                         input_.name(), contradict_, format_text(*format_).view()));
  status_ = std::max(status_, ExitStatus::data_failed);
}

bool DecodedCapture::reads_as(const DecodedCapture& other) const {
  return lines().lines == other.lines().lines && format_ == other.format_ &&
         reading_timing() == other.reading_timing() &&
         margin_.compensated == other.margin_.compensated &&
         margin_.resolution == other.margin_.resolution &&
         (other.margin_.signal || !margin_.signal);
}

FollowingCapture::FollowingCapture(DecodedCapture& capture, DecodedCapture::OnCycle on_cycle)
    : capture_(capture),
      on_cycle_(std::move(on_cycle)),
      lines_(capture.lines().lines),
      decoder_(
          capture.reader(),
          [this](const decode::Cycle& cycle) { capture_.follow(number_++, cycle, on_cycle_); }),
      finder_(capture.format(), capture.reading_timing(), capture.margin()),
      join_(finder_, decoder_) {}

void FollowingCapture::take(std::span<const wire::Edge> edges) {
  if (capture_.watcher() != nullptr) capture_.watcher()->take(edges);
  join_.push(edges, lines_);
}

void FollowingCapture::take(const capture::PairPiece& changes) {
  const decode::PairRun run{{changes.ma.times, changes.ma.first_high != lines_.ma_inverted},
                            {changes.slo.times, changes.slo.first_high != lines_.slo_inverted}};
  finder_.find(run, clean_);
  join_.push(run, clean_);
  if (capture_.watcher() != nullptr) capture_.watcher()->take(changes);
}

void FollowingCapture::finish(Picoseconds end) {
  join_.flush();
  decoder_.finish(end);
  capture_.end_following();
}

void DecodedCapture::read_blocks(const std::function<bool()>& go_on) {
  for (auto block = input_.next(); !block.empty() && go_on(); block = input_.next()) {
    push(block);
  }
}

void DecodedCapture::read_pieces(const decode::CleanCycleFinder& finder,
                                 const std::function<bool()>& go_on) {
  const auto threads = static_cast<unsigned>(std::min<std::uint64_t>(threads_, 1024));
  const flow::FlowSetup setup{
      .lines = lines().lines, .threads = threads, .watch = watch_of_pieces(), .go_on = go_on};
  flow::decode_pieces(input_.pairs(lines().lines), finder, setup, decoder());
  input_.end_pairs();
}

flow::Watch DecodedCapture::watch_of_pieces() const {
  if (watcher_ == nullptr) return {};
  return {[this](std::span<const wire::Edge> edges) { watcher_->take(edges); },
          [this](const capture::PairPiece& changes) { watcher_->take(changes); }};
}

bool DecodedCapture::read_edges(const std::function<bool(std::span<const wire::Edge>)>& on_edges) {
  Progress progress(host_);
  for (auto block = input_.next(); !block.empty() && on_edges(block); block = input_.next()) {
    if (progress.due()) progress.show(input_.progress_text(progress.seconds()));
  }
  return input_.error().empty();
}

DeviceTiming DecodedCapture::reading_timing() const {
  DeviceTiming timing = timing_;
  if (paused_timeout_) timing.timeout = *paused_timeout_;
  return timing;
}

bool DecodedCapture::hand_out(std::uint64_t number, const decode::Cycle& cycle,
                              const OnCycle& on_cycle) {
  if (is_wanted(cycle)) return on_cycle(number, cycle);
  ++outside_;
  return !(range_.until && cycle.time > *range_.until);
}

bool DecodedCapture::is_wanted(const decode::Cycle& cycle) const {
  return !(range_.since && cycle.time < *range_.since) &&
         !(range_.until && cycle.time > *range_.until);
}

std::string DecodedCapture::no_request() const {
  if (outside_ != 0) {
    return fmt::format("{}: no request cycle between --since and --until; outside: {}",
                       input_.name(), outside_);
  }
  return fmt::format(
      "{}: no request cycle found on MA ({}); is it the right line, is the time unit "
      "right, and did the master send requests?",
      input_.name(), ma_name());
}

void RunMessages::add_summary(std::string_view text) {
  if (text.empty()) return;
  if (!summaries_.empty()) summaries_ += '\n';
  summaries_ += text;
}

ExitStatus RunMessages::fail(ExitStatus status, std::string line) {
  lines_.push_back(std::move(line));
  return status;
}

void RunMessages::print(Host& host) const {
  host.print_summary(summaries_);
  for (const std::string& line : lines_) host.warn(line);
}

namespace {

// The outputs and files that are left undone by a run that ends at an unreadable capture.
std::string rest_text(const DecodedCapture& capture, const std::string& output) {
  report::Summary text;
  if (!output.empty()) {
    text.entry("not written", output,
               "biss convert --partial keeps the part of a damaged capture before the damage");
  }
  const auto files = capture.files_left();
  if (!files.empty()) {
    const std::string more = files.size() == 1 ? "" : fmt::format(" and {} more", files.size() - 1);
    text.entry("not read", files.front() + more, "the run ends at a capture that cannot be read");
  }
  return text.empty() ? "" : text.text();
}

}  // namespace

ExitStatus write_captures(
    DecodedCapture& capture, const std::string& output_path, const TableChoice& to,
    const std::function<std::vector<report::Column>()>& columns, bool needs_all,
    const std::function<ExitStatus(report::TableWriter& writer, RunMessages& messages)>& write) {
  if (!capture.next()) {
    if (capture.status() == ExitStatus::io) capture.host().print_summary(rest_text(capture, ""));
    return capture.status();
  }
  Output output(capture.host());
  if (!output.open(output_path)) return output.status();
  std::vector<report::Column> all = columns();
  for (report::Column& column : capture.columns()) {
    const bool taken = std::any_of(all.begin(), all.end(), [&](const report::Column& each) {
      return each.name == column.name;
    });
    if (taken) column.name += "_line";
    all.push_back(std::move(column));
  }
  const auto made = make_table(to, all, output);
  if (!made) return capture.host().fail(ExitStatus::usage, made.error());
  report::TableWriter* const writer = made->get();
  CaptureRows rows(*writer, all.size(), output, needs_all);
  RunMessages messages;
  ExitStatus status = ExitStatus::done;
  do {
    rows.set_last_cells(capture.cells());
    status = std::max(status, write(rows, messages));
  } while (rows.good() && status < ExitStatus::usage && capture.next());
  if (!rows.good()) return output.status();
  status = std::max(status, capture.status());
  if (status < ExitStatus::usage) {
    if (!writer->finish() || !output.finish()) return output.status();
  } else if (status == ExitStatus::io) {
    const bool is_file = output.file() != nullptr;
    writer->finish();
    output.abandon();
    messages.add_summary(rest_text(capture, is_file ? output_path : ""));
  }
  messages.print(capture.host());
  return status;
}

}  // namespace biss::verbs
