#include "verbs/common/decoded_capture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "biss/frame/format_text.hpp"
#include "decode/polarity.hpp"
#include "decode/statistics.hpp"
#include "verbs/common/host.hpp"
#include "verbs/common/identified.hpp"
#include "verbs/common/terminal.hpp"

namespace biss::verbs {

namespace {

constexpr std::uint64_t least_contradiction = 20;

// The frame is whole, and not one of the format.
bool contradicts(CycleStatus status) {
  using enum CycleStatus;
  return status == crc || status == stop_bit || status == truncated || status == cds;
}

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

void add_reading_options(Verb verb, CaptureArguments& arguments) {
  add_decode_options(verb, arguments);
  add_raw_options(verb, arguments.raw);
}

void add_range_options(Verb verb, CaptureArguments& arguments) {
  add_time_option(verb, "--since", into(arguments.since),
                  "Skip cycles that begin before this time");
  add_time_option(verb, "--until", into(arguments.until), "Skip cycles that begin after this time");
}

ExitStatus DecodedCapture::open(const CaptureArguments& arguments) {
  const std::string range = wrong_range(arguments.since, arguments.until);
  if (!range.empty()) return host_.fail(ExitStatus::usage, range);
  const FormatArguments& device = arguments.device;
  const bool has_format = !device.format.empty() && device.format != "none";
  if (has_format) {
    const auto choice = choose_device(device);
    if (!choice) return host_.fail(ExitStatus::usage, choice.error());
    format_ = choice->format;
    timing_ = choice->timing;
  }
  if (!has_format || arguments.timing) {
    const auto timing = override_timing(device, arguments.timing.value_or(DeviceTiming{}));
    if (!timing) return host_.fail(ExitStatus::usage, timing.error());
    timing_ = *timing;
  }
  if (arguments.resolution &&
      (*arguments.resolution < Picoseconds{} || *arguments.resolution > milliseconds(1))) {
    return host_.fail(ExitStatus::usage, "--resolution: from 0s to 1ms");
  }
  arguments_ = arguments;
  margin_.compensated = !arguments.no_compensation;
  margin_.signal = arguments.signal;
  if (words() != nullptr) {
    // A word does not show how the device behaves in time.
    timing_ = {};
    return ExitStatus::done;
  }
  auto captures = list_captures(arguments_, host_);
  if (!captures) return captures.error();
  captures_ = std::move(*captures);
  return ExitStatus::done;
}

bool DecodedCapture::next() {
  if (words() != nullptr) return log_.empty() && open_words();
  outside_ = 0;
  if (pair_ + 1 < pairs_.size()) {
    ++pair_;
    ExitStatus opened = input_.reopen();
    if (opened == ExitStatus::done) opened = identify_format();
    status_ = std::max(status_, opened);
    return opened == ExitStatus::done;
  }
  while (status_ <= ExitStatus::data_failed && next_capture_ < captures_.size()) {
    if (open_next()) return true;
  }
  return false;
}

std::vector<std::string> DecodedCapture::files_left() const {
  std::vector<std::string> files;
  for (std::size_t i = next_capture_; i < captures_.size(); ++i) {
    for (const CaptureFile& file : captures_[i]) files.push_back(file.path);
  }
  return files;
}

bool DecodedCapture::open_words() {
  if (arguments_.words.next) {
    take_words(identifies() || arguments_.identify_besides ? 512 : 1);
    if (log_.empty()) status_ = host_.fail(ExitStatus::io, name() + ": nothing was read");
  } else if (auto log = read_word_log(arguments_.words)) {
    log_ = std::move(*log);
  } else {
    status_ = host_.fail(ExitStatus::io, log.error());
  }
  if (arguments_.words.reading.payload && !format_) {
    status_ =
        host_.fail(ExitStatus::usage, "--payload: the length of the frame is not known; give -f");
  }
  if (status_ != ExitStatus::done) return false;
  if (!identifies() && !arguments_.identify_besides) return true;
  identify::SampleCollector frames;
  read_log(decode::CycleReader(std::nullopt, {}),
           [&frames](std::uint64_t number, const auto& cycle) {
             frames.add(number, cycle);
             return true;
           });
  take_finding(frames.samples());
  if (const auto* sure = finding_->sure(); identifies() && sure != nullptr) format_ = sure->format;
  return true;
}

// Takes words of a live line until there are `count`, or the words of two seconds.
void DecodedCapture::take_words(std::size_t count) {
  while (log_.size() < count) {
    auto word = arguments_.words.next();
    if (!word) return;
    log_.push_back(std::move(*word));
    if (*log_.back().time - *log_.front().time > milliseconds(2'000)) return;
  }
}

bool DecodedCapture::read_log(const decode::CycleReader& reader, const OnCycle& on_cycle) {
  for (std::size_t i = 0; i < log_.size(); ++i) {
    timed_ = log_[i].time.has_value();
    if (!on_cycle(i, cycle_of(log_[i], arguments_.words.reading, reader, format_))) return false;
  }
  return true;
}

bool DecodedCapture::read_words(const decode::CycleReader& reader, const OnCycle& on_cycle) {
  good_ = contradict_ = 0;
  const OnCycle counted = [&](std::uint64_t number, const decode::Cycle& cycle) {
    count(cycle);
    return on_cycle(number, cycle);
  };
  bool wanted = read_log(reader, counted);
  for (std::uint64_t number = log_.size(); wanted && arguments_.words.next; ++number) {
    const auto word = arguments_.words.next();
    if (!word) break;
    wanted = counted(number, cycle_of(*word, arguments_.words.reading, reader, format_));
  }
  warn_of_contradictions();
  return true;
}

std::string DecodedCapture::fitting_options() const {
  std::vector<Word> words;
  std::size_t good = 0;
  for (const LoggedWord& logged : log_) {
    words.push_back(logged.word);
    if (is_good(logged.word, arguments_.words.reading, *format_)) ++good;
  }
  if (2 * good > words.size()) return {};
  return verbs::fitting_options({{arguments_.words.reading.digits, words}},
                                arguments_.words.reading, *format_);
}

bool DecodedCapture::open_next() {
  pairs_.clear();
  pair_ = 0;
  if (identifies()) format_.reset();
  ExitStatus status = input_.open(std::move(captures_[next_capture_++]), arguments_);
  if (status == ExitStatus::done) {
    margin_.resolution = arguments_.resolution.value_or(input_.sample_period());
    auto found = input_.find_lines(reader(), arguments_.keep_unknown);
    if (found) {
      pairs_ = std::move(*found);
      for (decode::FoundLines& pair : pairs_) measure_polarity(pair);
      status = identify_format();
    } else if (!arguments_.keep_unknown || found.error() != ExitStatus::data_failed) {
      status = found.error();
      if (identifies() && status == ExitStatus::data_failed) warn_of_protocol();
    }
  }
  status_ = std::max(status_, status);
  return status == ExitStatus::done;
}

// Collects the frames of the capture, or of its beginning, read without a format.
// \return the edges that were read
std::size_t DecodedCapture::collect_frames(bool all, identify::SampleCollector& frames) {
  std::uint64_t number = 0;
  decode::Decoder decoder(
      decode::CycleReader(std::nullopt, {.timeout = reading_timing().timeout}, margin_),
      [&](const decode::Cycle& cycle) {
        if (is_wanted(cycle)) frames.add(number, cycle);
        ++number;
      });
  if (!all) {
    const auto first = input_.beginning();
    decoder.push(first, lines().lines);
    decoder.finish(first.empty() ? Picoseconds{} : first.back().time);
    return first.size();
  }
  std::size_t edges = 0;
  Progress progress(host_);
  for (auto block = input_.next(); !block.empty(); block = input_.next()) {
    decoder.push(block, lines().lines);
    edges += block.size();
    if (progress.due()) {
      progress.show(input_.progress_text(progress.seconds()) + ", to identify the format");
    }
  }
  decoder.finish(input_.end_time());
  return edges;
}

// Identifies the format from the beginning of the capture; if that does not show it, or if the
// capture is short, from all of it. Fails if the capture cannot be opened a second time.
ExitStatus DecodedCapture::identify_format() {
  constexpr std::uint64_t short_bytes = std::uint64_t{64} << 20U;
  paused_timeout_.reset();
  if (identifies()) format_.reset();
  if (!format_ && !reader().knows_timeout()) {
    paused_timeout_ = decode::find_paused_timeout(lines().lines, input_.beginning());
  }
  if (!identifies() && !arguments_.identify_besides) return ExitStatus::done;
  identify::SampleCollector frames;
  collect_frames(false, frames);
  take_finding(frames.samples());
  ExitStatus status = ExitStatus::done;
  const bool all = finding_->sure() == nullptr || input_.bytes() <= short_bytes;
  if (identifies() && all && input_.can_reopen()) status = identify_from_all();
  const auto* sure = finding_->sure();
  if (identifies() && sure != nullptr) format_ = sure->format;
  return status;
}

ExitStatus DecodedCapture::identify_from_all() {
  identify::SampleCollector frames;
  const std::size_t first = input_.beginning().size();
  if (collect_frames(true, frames) > first) {
    const auto* sure = finding_->sure();
    const auto before = sure != nullptr ? std::optional(sure->format) : std::nullopt;
    take_finding(frames.samples());
    sure = finding_->sure();
    if (before && (sure == nullptr || sure->format != *before)) {
      host_.warn(fmt::format(
          "{}: later frames contradict {}, which was identified at the beginning; {}",
          input_.name(), format_text(*before).view(),
          sure == nullptr
              ? std::string("no format is certain for all: give -f")
              : fmt::format("all frames are judged by {}", format_text(sure->format).view())));
    }
  }
  return input_.reopen();
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
  if (!identifies()) return;
  host_.warn(
      fmt::format("{}: the format changes: {}; decode each part with -f and --since, --until",
                  name(), format_parts_));
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
  found.lines.ma_inverted = arguments_.invert_ma;
  found.lines.slo_inverted = arguments_.invert_slo;
  found.lines = decode::find_polarity(found.lines, input_.beginning(), reader());
  found.look_swapped = found.look_swapped && !found.lines.slo_inverted;
}

FieldRow DecodedCapture::fields() const {
  FieldRow fields;
  if (arguments_.keep_unknown) return fields;
  if (captures_.size() > 1) fields.emplace_back("file", input_.name());
  if (!arguments_.each) return fields;
  fields.emplace_back("ma", ma_name(), report::Column{.heading = "MA"});
  fields.emplace_back("slo", slo_name(), report::Column{.heading = "SLO"});
  return fields;
}

Picoseconds DecodedCapture::interval() {
  decode::Statistics first;
  const auto add = [&first](const decode::Cycle& cycle) { first.add(cycle); };
  if (words() != nullptr) {
    if (arguments_.words.next) take_words(64);
    read_log(reader(), [&](std::uint64_t, const auto& cycle) { return add(cycle), true; });
  } else {
    decode::Decoder decoder(reader(), add);
    decoder.push(beginning(), lines().lines);
  }
  const decode::Distribution& interval = first.interval();
  return interval.count() == 0 ? Picoseconds{} : picoseconds(interval.median());
}

void DecodedCapture::begin_reading(OnCycle on_cycle, flow::ChangeWatcher* watcher) {
  watcher_ = watcher;
  on_cycle_ = std::move(on_cycle);
  number_ = good_ = contradict_ = 0;
  wanted_ = true;
}

void DecodedCapture::begin_steps(OnCycle on_cycle, flow::ChangeWatcher* watcher) {
  begin_reading(std::move(on_cycle), watcher);
  decoder_.emplace(reader(), [this](const decode::Cycle& cycle) { take(cycle); });
  const decode::CleanCycleFinder finder(format_, reading_timing(), margin_);
  const decode::Lines& own = lines().lines;
  flow_.emplace(input_.pairs(own), finder, own, *decoder_, watcher_);
}

bool DecodedCapture::step() { return wanted_ && flow_->step(); }

bool DecodedCapture::end_steps() {
  input_.end_pairs();
  flow_->flush();
  end_time_ = input_.end_time();
  decoder_->finish(end_time_);
  flow_.reset();
  decoder_.reset();
  return input_.error().empty();
}

bool DecodedCapture::read(const OnCycle& on_cycle, flow::ChangeWatcher* watcher) {
  if (words() != nullptr) return read_words(reader(), on_cycle);
  if (JointReading* const joint = host_.joint_reading()) {
    begin_reading(on_cycle, watcher);
    if (joint->join(*this)) {
      warn_of_contradictions();
      return true;
    }
  }
  begin_steps(on_cycle, watcher);
  Progress progress(host_);
  const auto go_on = [&] {
    if (progress.due()) {
      const double seconds = progress.seconds();
      progress.show(fmt::format("{}, {} request cycles{}", input_.progress_text(seconds), number_,
                                rate_text(static_cast<double>(number_) / seconds, "cycles")));
    }
    return wanted_;
  };
  flow_->run(static_cast<unsigned>(std::min<std::uint64_t>(arguments_.threads, 1024)), go_on);
  const bool whole = end_steps();
  warn_of_contradictions();
  return whole;
}

bool DecodedCapture::reads_as(const DecodedCapture& other) const {
  return lines().lines == other.lines().lines && format_ == other.format_ &&
         reading_timing() == other.reading_timing() &&
         margin_.compensated == other.margin_.compensated &&
         margin_.resolution == other.margin_.resolution &&
         (other.margin_.signal || !margin_.signal);
}

void DecodedCapture::count(const decode::Cycle& cycle) {
  good_ += cycle.status == CycleStatus::ok ? 1U : 0U;
  contradict_ += contradicts(cycle.status) ? 1U : 0U;
}

void DecodedCapture::take(const decode::Cycle& cycle) {
  count(cycle);
  if (!wanted_) return;
  if (is_wanted(cycle)) {
    wanted_ = on_cycle_(number_, cycle);
  } else {
    ++outside_;
    wanted_ = !(arguments_.until && cycle.time > *arguments_.until);
  }
  ++number_;
}

void DecodedCapture::warn_of_contradictions() {
  if (!identifies() || !format_ || watcher_ != nullptr || contradict_ <= least_contradiction ||
      4 * contradict_ <= good_) {
    return;
  }
  host_.warn(
      fmt::format("{}: {} frames contradict {}, which was identified at the beginning; give -f",
                  name(), contradict_, format_text(*format_).view()));
  status_ = std::max(status_, ExitStatus::data_failed);
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

bool DecodedCapture::is_wanted(const decode::Cycle& cycle) const {
  return !(arguments_.since && cycle.time < *arguments_.since) &&
         !(arguments_.until && cycle.time > *arguments_.until);
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

}  // namespace biss::verbs
