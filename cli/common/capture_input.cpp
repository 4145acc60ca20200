#include "cli/common/capture_input.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <system_error>

#include "capture/merge.hpp"
#include "capture/open.hpp"
#include "cli/common/message.hpp"

namespace biss::cli {

namespace {

struct FileAndName {
  std::string file;
  std::string name;
};

// `FILE:NAME`; without a colon there is no file. A drive letter or scope is no problem: the last
// colon counts.
FileAndName split(const std::string& text) {
  const std::size_t colon = text.rfind(':');
  if (colon == std::string::npos || colon == 0) return {"", text};
  return {text.substr(0, colon), text.substr(colon + 1)};
}

// The name that `text` gives a line of this file: empty where it speaks of another one.
std::string name_in(const std::string& file, const std::string& text) {
  const FileAndName parts = split(text);
  return parts.file.empty() || parts.file == file ? parts.name : std::string();
}

capture::OpenOptions options_for(const std::string& file, const RawSamples& raw,
                                 const std::string& ma, const std::string& slo) {
  if (!raw.rate) return {};
  return {.raw = layout_of(raw, name_in(file, ma), name_in(file, slo))};
}

std::string why_not(const capture::CaptureError& error, const std::string& file) {
  if (error.cause != capture::CaptureCause::layout_missing) {
    return capture::capture_error_text(error, file);
  }
  return fmt::format(
      "{}: raw samples do not say their sample rate; give --raw-rate, and --raw-bytes where a "
      "sample has more than one",
      file);
}

bool contains(const std::vector<std::string>& list, const std::string& item) {
  return std::find(list.begin(), list.end(), item) != list.end();
}

}  // namespace

ExitStatus CaptureInput::open(std::vector<std::string> files, const std::string& ma,
                              const std::string& slo, const RawSamples& raw) {
  files_ = std::move(files);
  const bool files_given = !files_.empty();
  for (const std::string* text : {&ma, &slo}) {
    const std::string file = split(*text).file;
    if (!file.empty() && !files_given && !contains(files_, file)) files_.push_back(file);
  }
  if (files_.empty()) {
    return fail(ExitStatus::usage, "no capture given; name a file, or - for standard input");
  }
  std::vector<capture::NamedSource> sources;
  std::size_t lines = 0;
  bool any_raw = false;
  for (const std::string& file : files_) {
    capture::Opened opened = capture::open_capture(file, options_for(file, raw, ma, slo));
    if (!opened) return fail(ExitStatus::io, why_not(opened.error, file));
    any_raw = any_raw || opened.by_layout;
    first_line_.push_back(lines);
    lines += opened.source->lines().size();
    sources.push_back({std::move(opened.source), file});
  }
  if (raw.rate && !any_raw) {
    return fail(ExitStatus::usage,
                fmt::format("--raw-rate: {} says its times itself; leave the option out", name()));
  }
  if (sources.size() == 1) {
    source_ = std::move(sources.front().source);
  } else {
    source_ = std::make_unique<capture::MergedSource>(std::move(sources));
  }
  return ExitStatus::done;
}

bool CaptureInput::reads(const std::string& path) const {
  namespace fs = std::filesystem;
  std::error_code none;
  if (path.empty() || path == "-" || !fs::is_regular_file(path, none)) return false;
  return std::any_of(files_.begin(), files_.end(), [&](const std::string& file) {
    std::error_code missing;
    return fs::equivalent(file == "-" ? "/dev/stdin" : file, path, missing) && !missing;
  });
}

std::string CaptureInput::line_of(const std::string& text) const {
  if (contains(lines(), text)) return text;
  const FileAndName parts = split(text);
  const auto file = std::find(files_.begin(), files_.end(), parts.file);
  if (file == files_.end()) return text;
  const auto k = static_cast<std::size_t>(file - files_.begin());
  const std::size_t end = k + 1 < first_line_.size() ? first_line_[k + 1] : lines().size();
  for (std::size_t i = first_line_[k]; i < end; ++i) {
    if (lines()[i] == parts.name || lines()[i] == text) return lines()[i];
  }
  return text;
}

std::string CaptureInput::name() const {
  return files_.size() == 1 ? files_.front() : fmt::format("{} files", files_.size());
}

std::span<const wire::Edge> CaptureInput::pull() {
  if (ended_) return {};
  const auto block = source_->next_block();
  if (!block.ok()) {
    ended_ = true;
    const auto* merged = dynamic_cast<const capture::MergedSource*>(source_.get());
    const std::size_t which = merged != nullptr ? merged->failed_source() : 0;
    error_ = capture::capture_error_text(block.error(), files_[which]);
    return {};
  }
  ended_ = block->empty();
  return *block;
}

std::span<const wire::Edge> CaptureInput::look_at_beginning(std::size_t edges) {
  while (beginning_.size() < edges) {
    const auto block = pull();
    if (block.empty()) break;
    beginning_.insert(beginning_.end(), block.begin(), block.end());
  }
  beginning_pending_ = !beginning_.empty();
  return beginning_;
}

std::span<const wire::Edge> CaptureInput::next() {
  if (beginning_pending_) {
    beginning_pending_ = false;
    return beginning_;
  }
  if (!beginning_.empty()) beginning_ = {};
  return pull();
}

}  // namespace biss::cli
