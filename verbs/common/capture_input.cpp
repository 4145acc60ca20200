#include "verbs/common/capture_input.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <system_error>
#include <utility>

#include "capture/edge_pairs.hpp"
#include "capture/merge.hpp"
#include "capture/open.hpp"
#include "verbs/common/host.hpp"
#include "verbs/common/terminal.hpp"

namespace biss::verbs {

namespace {

using decode::LineProblem;

struct FileAndName {
  std::string file;
  std::string name;
};

// `FILE:NAME`; without a colon there is no file. The last colon counts, so that a drive letter or a
// scope does no harm.
FileAndName split(const std::string& text) {
  const std::size_t colon = text.rfind(':');
  if (colon == std::string::npos || colon == 0) return {"", text};
  return {text.substr(0, colon), text.substr(colon + 1)};
}

// The line of this file that `text` names: empty if it names a line of another file.
std::string name_in(const std::string& file, const std::string& text) {
  const FileAndName parts = split(text);
  return parts.file.empty() || parts.file == file ? parts.name : std::string();
}

bool contains(const std::vector<std::string>& list, const std::string& item) {
  return std::find(list.begin(), list.end(), item) != list.end();
}

// The first items of a list, with dots if it has more.
std::string some_of(std::vector<std::string> list) {
  constexpr std::size_t most = 12;
  if (list.size() > most) {
    list.resize(most);
    list.emplace_back("...");
  }
  return fmt::format("{}", fmt::join(list, ", "));
}

// The channels of a file that --differential does not fit, for the message.
std::string channels_of(const std::string& path, capture::OpenOptions options) {
  options.analog.differentials.clear();
  // Only the names matter.
  options.analog.threshold.emplace();
  if (path == "-") return "other channels";
  const capture::Opened opened = capture::open_capture(path, options);
  return opened ? some_of((*opened)->lines()) : "no channels";
}

std::string open_error_text(const capture::CaptureError& error, const std::string& path,
                            const capture::OpenOptions& options) {
  switch (error.cause) {
    case capture::CaptureCause::layout_missing:
      return fmt::format(
          "{}: the sample rate of raw samples is not known; give --raw-rate, and --raw-bytes if "
          "a sample has more than one byte",
          path);
    case capture::CaptureCause::no_such_channel:
      return fmt::format(
          "--differential: {} does not have both analog channels of each pair; it has {}", path,
          channels_of(path, options));
    default:
      return capture::capture_error_text(error, path);
  }
}

// Prints why it cannot.
ExitStatus open_file(CaptureFile& file, const InputArguments& arguments, Host& host) {
  if (file.source) return ExitStatus::done;
  if (const GivenCapture* given = host.capture(file.path)) {
    capture::Opened opened = given->open(arguments);
    if (!opened) {
      file.cause = opened.error().cause;
      return host.fail(ExitStatus::io, capture::capture_error_text(opened.error(), file.path));
    }
    file.source = std::move(*opened);
    return ExitStatus::done;
  }
  capture::OpenOptions options{.no_verify = arguments.no_verify, .analog = arguments.raw.analog};
  if (arguments.raw.rate) {
    options.raw = layout_of(arguments.raw, name_in(file.path, arguments.ma),
                            name_in(file.path, arguments.slo));
  }
  capture::OpenedBytes bytes = capture::open_bytes(file.path);
  if (!bytes) {
    file.cause = bytes.error().cause;
    return host.fail(ExitStatus::io, capture::capture_error_text(bytes.error(), file.path));
  }
  file.position = ReadPosition((*bytes)->regular_file());
  capture::Opened opened = capture::open_capture(std::move(*bytes), file.path, options);
  if (!opened) {
    file.cause = opened.error().cause;
    const bool usage = opened.error().cause == capture::CaptureCause::no_such_channel;
    return host.fail(usage ? ExitStatus::usage : ExitStatus::io,
                     open_error_text(opened.error(), file.path, options));
  }
  file.source = std::move(*opened);
  return ExitStatus::done;
}

std::string pair_text(const std::vector<std::string>& names, const decode::Lines& lines) {
  if (lines.ma == lines.slo) return names[lines.ma];
  return fmt::format("{} with {}", names[lines.ma], names[lines.slo]);
}

}  // namespace

ReadPosition::ReadPosition(int descriptor) : descriptor_(descriptor < 0 ? -1 : ::dup(descriptor)) {}
ReadPosition::ReadPosition(ReadPosition&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)) {}
ReadPosition& ReadPosition::operator=(ReadPosition&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  return *this;
}
ReadPosition::~ReadPosition() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

std::optional<ReadPosition::Amount> ReadPosition::amount() const {
  struct stat file {};
  if (descriptor_ < 0 || ::fstat(descriptor_, &file) != 0 || file.st_size <= 0) return std::nullopt;
  off_t farthest = 0;
  std::error_code end;
  for (auto each = std::filesystem::directory_iterator("/proc/self/fd", end);
       !end && each != std::filesystem::directory_iterator(); each.increment(end)) {
    const int descriptor = std::atoi(each->path().filename().c_str());
    struct stat about {};
    if (::fstat(descriptor, &about) != 0 || about.st_dev != file.st_dev ||
        about.st_ino != file.st_ino) {
      continue;
    }
    farthest = std::max(farthest, ::lseek(descriptor, 0, SEEK_CUR));
  }
  if (farthest == 0) return std::nullopt;
  const auto all = static_cast<std::uint64_t>(file.st_size);
  return Amount{std::min(all, static_cast<std::uint64_t>(farthest)), all};
}

ExitStatus CaptureInput::open(std::vector<CaptureFile> files, const InputArguments& arguments) {
  *this = CaptureInput(*host_);
  most_beginning_ = arguments.beginning;
  std::vector<capture::NamedSource> sources;
  bool any_raw = arguments.one_of_many || files.size() < arguments.files.size();
  bool any_analog = any_raw;
  for (CaptureFile& file : files) {
    const ExitStatus opened = open_file(file, arguments, *host_);
    cause_ = file.cause;
    if (opened != ExitStatus::done) return opened;
    any_raw = any_raw || file.source->is_raw();
    any_analog = any_analog || file.source->is_analog();
    name_ += (name_.empty() ? "" : " + ") + file.path;
    paths_.push_back(file.path);
    positions_.push_back(std::move(file.position));
    sources.push_back({std::move(file.source), file.path});
  }
  if (arguments.raw.rate && !any_raw) {
    return host_->fail(
        ExitStatus::usage,
        fmt::format("--raw-rate: {} has times of its own; leave the option out", name_));
  }
  if (arguments.raw.analog.given() && !any_analog) {
    const char* const option = arguments.raw.analog.threshold ? "--threshold" : "--differential";
    return host_->fail(
        ExitStatus::usage,
        fmt::format("{}: {} has levels, not voltages; leave the option out", option, name_));
  }
  if (sources.size() == 1) {
    source_ = std::move(sources.front().source);
  } else {
    source_ = std::make_unique<capture::MergedSource>(std::move(sources));
  }
  return ExitStatus::done;
}

ExitStatus CaptureInput::reopen(const InputArguments& arguments) {
  if (contains(paths_, "-")) {
    return host_->fail(ExitStatus::usage,
                       "--each: standard input can be read only once; save it to a file");
  }
  std::vector<CaptureFile> files;
  for (std::string& path : paths_) files.push_back({.path = std::move(path)});
  return open(std::move(files), arguments);
}

bool CaptureInput::can_reopen() const {
  return std::all_of(paths_.begin(), paths_.end(), [this](const std::string& path) {
    if (const GivenCapture* given = host_->capture(path)) return given->again;
    struct stat about {};
    return ::stat(path.c_str(), &about) == 0 && S_ISREG(about.st_mode);
  });
}

std::uint64_t CaptureInput::bytes() const {
  std::uint64_t sum = 0;
  for (const std::string& path : paths_) {
    struct stat about {};
    if (::stat(path.c_str(), &about) == 0) sum += static_cast<std::uint64_t>(about.st_size);
  }
  return sum;
}

// The name of a line of this capture for a name given by the user; empty if it names a line of
// another capture.
std::string CaptureInput::request_for(const std::string& text,
                                      const InputArguments& arguments) const {
  if (paths_.size() > 1 || contains(lines(), text)) return text;
  const FileAndName parts = split(text);
  if (parts.file == paths_.front()) return parts.name;
  return contains(arguments.files, parts.file) ? std::string() : text;
}

namespace {

// The line with the most edges as MA, the next one as SLO. \pre there are two
decode::Lines busiest_lines(std::size_t lines, std::span<const wire::Edge> edges) {
  std::vector<std::size_t> counts(lines, 0);
  for (const wire::Edge& edge : edges) ++counts[edge.line];
  decode::Lines busiest{.ma = 0, .slo = 1};
  if (counts[1] > counts[0]) std::swap(busiest.ma, busiest.slo);
  for (std::size_t i = 2; i < lines; ++i) {
    const auto line = static_cast<wire::LineIndex>(i);
    if (counts[i] > counts[busiest.ma]) {
      busiest = {.ma = line, .slo = busiest.ma};
    } else if (counts[i] > counts[busiest.slo]) {
      busiest.slo = line;
    }
  }
  return busiest;
}

}  // namespace

tl::expected<std::vector<decode::FoundLines>, ExitStatus> CaptureInput::find_lines(
    const InputArguments& arguments, const decode::CycleReader& reader, bool quiet) {
  const std::string ma = request_for(arguments.ma, arguments);
  const std::string slo = request_for(arguments.slo, arguments);
  auto found = decode::find_lines(lines(), beginning(), {ma, slo, arguments.each}, reader);
  if (found) return std::move(*found);
  using enum LineProblem;
  const LineProblem problem = found.error().problem;
  const bool none = problem == too_few_lines || problem == nothing_behaves;
  if (arguments.any_lines && none && error_.empty() && lines().size() >= 2) {
    return std::vector{decode::FoundLines{.lines = busiest_lines(lines().size(), beginning()),
                                          .origin = decode::LineOrigin::by_behaviour}};
  }
  if (quiet && (none || problem == ambiguous) && error_.empty()) {
    return tl::unexpected(ExitStatus::data_failed);
  }
  return tl::unexpected(report(found.error(), arguments));
}

tl::expected<wire::LineIndex, ExitStatus> CaptureInput::find_ma(const InputArguments& arguments,
                                                                const decode::CycleReader& reader) {
  const auto found =
      decode::find_ma(lines(), beginning(), request_for(arguments.ma, arguments), reader);
  if (found) return *found;
  return tl::unexpected(report(found.error(), arguments));
}

ExitStatus CaptureInput::report(const decode::LineError& error,
                                const InputArguments& arguments) const {
  if (!error_.empty()) return host_->fail(ExitStatus::io, error_);
  std::vector<std::string> pairs;
  for (const decode::Lines& candidate : error.candidates) {
    pairs.push_back(pair_text(lines(), candidate));
  }
  switch (error.problem) {
    case LineProblem::no_such_ma:
    case LineProblem::no_such_slo: {
      const bool ma = error.problem == LineProblem::no_such_ma;
      return host_->fail(ExitStatus::usage,
                         fmt::format("{}: no line '{}' in {}; it has {}", ma ? "--ma" : "--slo",
                                     ma ? arguments.ma : arguments.slo, name_, some_of(lines())));
    }
    case LineProblem::same_line:
      return host_->fail(ExitStatus::usage,
                         "MA and SLO cannot be the same line; name both with --ma and --slo");
    case LineProblem::too_few_lines:
      return host_->fail(
          ExitStatus::data_failed,
          fmt::format("{}: fewer than two lines change; MA and SLO are needed", name_));
    case LineProblem::nothing_behaves:
      return host_->fail(
          ExitStatus::data_failed,
          fmt::format("{}: no pair of lines behaves like MA and SLO; it has {}; name them "
                      "with --ma and --slo",
                      name_, some_of(lines())));
    case LineProblem::ambiguous:
      break;
  }
  return host_->fail(
      ExitStatus::data_failed,
      fmt::format("{}: several lines can be MA and SLO: {}; name one pair with --ma and "
                  "--slo{}{}",
                  name_, some_of(pairs), paths_.size() > 1 ? ", and give only its files" : "",
                  arguments.has_each && error.each_helps ? ", or read all with --each" : ""));
}

std::string CaptureInput::progress_text(double seconds) const {
  double read = 0;
  double all = 0;
  bool known = true;
  for (const ReadPosition& position : positions_) {
    const auto amount = position.amount();
    known = known && amount;
    if (!amount) continue;
    read += static_cast<double>(amount->read);
    all += static_cast<double>(amount->all);
  }
  known = known && read > 0;
  const std::int64_t milliseconds = end_time().count / 1'000'000'000;
  std::string text =
      fmt::format("{}: {}{} ms of the capture read", name_,
                  known ? fmt::format("{:.0f} %, ", read / all * 100) : "", milliseconds);
  if (known) text += rate_text(read / seconds, "B") + left_text((all - read) / read * seconds);
  return text;
}

std::span<const wire::Edge> CaptureInput::pull() {
  if (failed_) return {};
  const auto block = source_->next_block();
  if (!block.ok()) {
    failed_ = true;
    note_error(block.error());
    return {};
  }
  return *block;
}

void CaptureInput::note_error(const capture::CaptureError& error) {
  const auto* merged = dynamic_cast<const capture::MergedSource*>(source_.get());
  const std::size_t which = merged != nullptr ? merged->failed_source() : 0;
  error_ = capture::capture_error_text(error, paths_[which]);
  cause_ = error.cause;
}

capture::PairSource& CaptureInput::pairs(const decode::Lines& lines) {
  auto first = beginning_pending_ ? std::move(beginning_) : std::vector<wire::Edge>{};
  beginning_ = {};
  beginning_pending_ = false;
  pairs_ = capture::pairs_of(std::move(first), *source_, lines.ma, lines.slo);
  return *pairs_;
}

bool CaptureInput::end_pairs() {
  if (const auto& error = pairs_->error()) note_error(*error);
  return error_.empty();
}

std::span<const wire::Edge> CaptureInput::beginning() {
  while (!beginning_read_ && beginning_.size() < most_beginning_) {
    const auto block = pull();
    if (block.empty()) break;
    if (!beginning_.empty()) beginning_.reserve(most_beginning_ + most_beginning_ / 4);
    beginning_.insert(beginning_.end(), block.begin(), block.end());
  }
  beginning_pending_ = beginning_pending_ || (!beginning_read_ && !beginning_.empty());
  beginning_read_ = true;
  return beginning_;
}

std::span<const wire::Edge> CaptureInput::next() {
  if (std::exchange(beginning_pending_, false)) return beginning_;
  if (!beginning_.empty()) beginning_ = {};
  return pull();
}

ExitStatus CaptureList::open(InputArguments arguments) {
  arguments_ = std::move(arguments);
  std::vector<std::string>& files = arguments_.files;
  const std::string ma_file = split(arguments_.ma).file;
  const std::string slo_file = split(arguments_.slo).file;
  const bool files_given = !files.empty();
  for (const std::string& file : {ma_file, slo_file}) {
    if (file.empty() || contains(files, file)) continue;
    if (files_given && files.size() == 1) continue;  // a line of this name, or of none
    if (files_given) {
      return host_.fail(ExitStatus::usage, fmt::format("{}: '{}' is not among the captures given",
                                                       file == ma_file ? "--ma" : "--slo", file));
    }
    files.push_back(file);
  }
  if (files.empty()) {
    return host_.fail(ExitStatus::usage, "no capture given; name a file, or - for standard input");
  }
  std::vector<CaptureFile> opened;
  for (const std::string& file : files) opened.push_back({.path = file});
  bool joined = files.size() > 1;
  if (joined && contains(files, ma_file) && contains(files, slo_file) && ma_file != slo_file) {
    for (const std::string& file : files) {
      if (file == ma_file || file == slo_file) continue;
      return host_.fail(
          ExitStatus::usage,
          fmt::format("{}: neither --ma nor --slo names a line of it; leave it out", file));
    }
  } else {
    for (std::size_t i = 0; joined && i < opened.size(); ++i) {
      const ExitStatus status = open_file(opened[i], arguments_, host_);
      if (status != ExitStatus::done) return status;
      joined = opened[i].source->lines().size() == 1;
    }
  }
  if (joined || opened.size() == 1) {
    captures_.push_back(std::move(opened));
  } else {
    for (CaptureFile& file : opened) captures_.emplace_back().push_back(std::move(file));
  }
  several_ = captures_.size() > 1;
  return ExitStatus::done;
}

std::vector<std::string> CaptureList::files_left() const {
  std::vector<std::string> files;
  for (std::size_t i = next_; i < captures_.size(); ++i) {
    for (const CaptureFile& file : captures_[i]) files.push_back(file.path);
  }
  return files;
}

ExitStatus CaptureList::open_next(CaptureInput& input) {
  return input.open(std::move(captures_[next_++]), arguments_);
}

}  // namespace biss::verbs
