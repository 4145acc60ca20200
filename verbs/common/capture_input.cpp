#include "verbs/common/capture_input.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <numeric>
#include <system_error>
#include <utility>

#include "capture/edge_pairs.hpp"
#include "capture/merge.hpp"
#include "capture/open.hpp"
#include "verbs/common/terminal.hpp"

namespace biss::verbs {

namespace {

using decode::LineProblem;

// The line of this file that `text` names: empty if it names a line of another file.
std::string name_in(const std::string& file, const std::string& text) {
  const std::string own = file_of_line(text);
  if (own.empty()) return text;
  return own == file ? text.substr(own.size() + 1) : std::string();
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
  capture::OpenOptions options{.no_verify = arguments.no_verify, .analog = arguments.raw.analog};
  if (arguments.raw.rate) {
    options.raw = layout_of(arguments.raw, name_in(file.path, arguments.ma),
                            name_in(file.path, arguments.slo));
  }
  const GivenCapture* const given = host.capture(file.path);
  capture::Opened opened =
      given != nullptr ? given->open(arguments) : capture::open_capture(file.path, options);
  if (opened) {
    file.source = std::move(*opened);
    return ExitStatus::done;
  }
  file.cause = opened.error().cause;
  if (given != nullptr) {
    return host.fail(ExitStatus::io, capture::capture_error_text(opened.error(), file.path));
  }
  const bool usage = opened.error().cause == capture::CaptureCause::no_such_channel;
  return host.fail(usage ? ExitStatus::usage : ExitStatus::io,
                   open_error_text(opened.error(), file.path, options));
}

std::string pair_text(const std::vector<std::string>& names, const decode::Lines& lines) {
  if (lines.ma == lines.slo) return names[lines.ma];
  return fmt::format("{} with {}", names[lines.ma], names[lines.slo]);
}

}  // namespace

std::string file_of_line(const std::string& text) {
  // The last colon counts, so that a drive letter or a scope does no harm.
  const std::size_t colon = text.rfind(':');
  return colon == std::string::npos ? std::string() : text.substr(0, colon);
}

std::optional<ReadAmount> read_amount(const std::string& path) {
  struct stat file {};
  if (::stat(path == "-" ? "/dev/stdin" : path.c_str(), &file) != 0 || file.st_size <= 0) {
    return std::nullopt;
  }
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
  return ReadAmount{std::min(all, static_cast<std::uint64_t>(farthest)), all};
}

ExitStatus CaptureInput::open(std::vector<CaptureFile> files, InputArguments arguments) {
  *this = CaptureInput(*host_);
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
  arguments_ = std::move(arguments);
  return ExitStatus::done;
}

ExitStatus CaptureInput::reopen() {
  if (contains(paths_, "-")) {
    return host_->fail(ExitStatus::usage,
                       "--each: standard input can be read only once; save it to a file");
  }
  std::vector<CaptureFile> files;
  for (std::string& path : paths_) files.push_back({.path = std::move(path)});
  return open(std::move(files), std::move(arguments_));
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
std::string CaptureInput::request_for(const std::string& text) const {
  if (paths_.size() > 1 || contains(lines(), text)) return text;
  const std::string file = file_of_line(text);
  const bool names_a_file = file == paths_.front() || contains(arguments_.files, file);
  return names_a_file ? name_in(paths_.front(), text) : text;
}

namespace {

// The line with the most edges as MA, the next one as SLO. \pre there are two
decode::Lines busiest_lines(std::size_t lines, std::span<const wire::Edge> edges) {
  std::vector<std::size_t> counts(lines, 0);
  for (const wire::Edge& edge : edges) ++counts[edge.line];
  std::vector<wire::LineIndex> order(lines);
  std::iota(order.begin(), order.end(), wire::LineIndex{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](wire::LineIndex a, wire::LineIndex b) { return counts[a] > counts[b]; });
  return {.ma = order[0], .slo = order[1]};
}

}  // namespace

tl::expected<std::vector<decode::FoundLines>, ExitStatus> CaptureInput::find_lines(
    const decode::CycleReader& reader, bool quiet) {
  const std::string ma = request_for(arguments_.ma);
  const std::string slo = request_for(arguments_.slo);
  auto found = decode::find_lines(lines(), beginning(), {ma, slo, arguments_.each}, reader);
  if (found) return std::move(*found);
  using enum LineProblem;
  const LineProblem problem = found.error().problem;
  const bool none = problem == too_few_lines || problem == nothing_behaves;
  if (arguments_.any_lines && none && error_.empty() && lines().size() >= 2) {
    return std::vector{decode::FoundLines{.lines = busiest_lines(lines().size(), beginning()),
                                          .origin = decode::LineOrigin::by_behaviour}};
  }
  if (quiet && (none || problem == ambiguous) && error_.empty()) {
    return tl::unexpected(ExitStatus::data_failed);
  }
  return tl::unexpected(report(found.error()));
}

tl::expected<wire::LineIndex, ExitStatus> CaptureInput::find_ma(const decode::CycleReader& reader) {
  const auto found = decode::find_ma(lines(), beginning(), request_for(arguments_.ma), reader);
  if (found) return *found;
  return tl::unexpected(report(found.error()));
}

ExitStatus CaptureInput::report(const decode::LineError& error) const {
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
                                     ma ? arguments_.ma : arguments_.slo, name_, some_of(lines())));
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
                  arguments_.has_each && error.each_helps ? ", or read all with --each" : ""));
}

std::string CaptureInput::progress_text(double seconds) const {
  double read = 0;
  double all = 0;
  bool known = true;
  for (const std::string& path : paths_) {
    const auto amount = read_amount(path);
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
  const bool pending = std::exchange(state_, Beginning::delivered) == Beginning::pending;
  auto first = std::exchange(beginning_, {});
  if (!pending) first.clear();
  pairs_ = capture::pairs_of(std::move(first), *source_, lines.ma, lines.slo);
  return *pairs_;
}

bool CaptureInput::end_pairs() {
  if (const auto& error = pairs_->error()) note_error(*error);
  return error_.empty();
}

std::span<const wire::Edge> CaptureInput::beginning() {
  while (state_ == Beginning::unread && beginning_.size() < arguments_.beginning) {
    const auto block = pull();
    if (block.empty()) break;
    if (!beginning_.empty()) beginning_.reserve(arguments_.beginning + arguments_.beginning / 4);
    beginning_.insert(beginning_.end(), block.begin(), block.end());
  }
  if (state_ == Beginning::unread) state_ = Beginning::pending;
  return beginning_;
}

std::span<const wire::Edge> CaptureInput::next() {
  if (std::exchange(state_, Beginning::delivered) == Beginning::pending) return beginning_;
  if (!beginning_.empty()) beginning_ = {};
  return pull();
}

tl::expected<std::vector<std::vector<CaptureFile>>, ExitStatus> list_captures(
    InputArguments& arguments, Host& host) {
  const auto wrong = [&host](const std::string& text) {
    return tl::unexpected(host.fail(ExitStatus::usage, text));
  };
  std::vector<std::string>& files = arguments.files;
  const std::string ma_file = file_of_line(arguments.ma);
  const std::string slo_file = file_of_line(arguments.slo);
  const bool files_given = !files.empty();
  for (const std::string& file : {ma_file, slo_file}) {
    if (file.empty() || contains(files, file)) continue;
    if (files_given && files.size() == 1) continue;  // a line of this name, or of none
    if (files_given) {
      return wrong(fmt::format("{}: '{}' is not among the captures given",
                               file == ma_file ? "--ma" : "--slo", file));
    }
    files.push_back(file);
  }
  if (files.empty()) {
    return wrong("no capture given; name a file, or - for standard input");
  }
  std::vector<CaptureFile> opened;
  for (const std::string& file : files) opened.push_back({.path = file});
  bool joined = files.size() > 1;
  if (joined && contains(files, ma_file) && contains(files, slo_file) && ma_file != slo_file) {
    for (const std::string& file : files) {
      if (file == ma_file || file == slo_file) continue;
      return wrong(
          fmt::format("{}: neither --ma nor --slo names a line of it; leave it out", file));
    }
  } else {
    for (std::size_t i = 0; joined && i < opened.size(); ++i) {
      const ExitStatus status = open_file(opened[i], arguments, host);
      if (status != ExitStatus::done) return tl::unexpected(status);
      joined = opened[i].source->lines().size() == 1;
    }
  }
  std::vector<std::vector<CaptureFile>> captures;
  if (joined) {
    captures.push_back(std::move(opened));
  } else {
    for (CaptureFile& file : opened) captures.emplace_back().push_back(std::move(file));
  }
  return captures;
}

}  // namespace biss::verbs
