#include "verbs/convert/losses.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "capture/seconds.hpp"
#include "device/quantity.hpp"

namespace biss::verbs {
namespace {

bool is_blank_or_control(char c) {
  const auto code = static_cast<unsigned char>(c);
  return code <= ' ' || code == 0x7F;
}

// The text for an option.
template <class Quantity>
std::string option_text(Quantity quantity) {
  std::string text = text_of(quantity);
  std::erase(text, ' ');
  return text;
}

bool is_line_end(char c) { return c == '\n' || c == '\r'; }

// The first name that the writer of the format has to change; null if there is none.
const std::string* changed_name(CaptureFormat format, const std::vector<std::string>& names) {
  bool (*changed)(char) = nullptr;
  if (format == CaptureFormat::vcd) changed = is_blank_or_control;
  if (format == CaptureFormat::event_csv || format == CaptureFormat::saleae_csv) {
    changed = is_line_end;
  }
  if (changed == nullptr) return nullptr;
  const auto found = std::find_if(names.begin(), names.end(), [changed](const std::string& name) {
    return std::any_of(name.begin(), name.end(), changed);
  });
  return found == names.end() ? nullptr : &*found;
}

}  // namespace

Losses::Losses(CaptureFormat format, const std::vector<std::string>& names, Hertz rate)
    : format_(format),
      names_(names),
      rate_(rate),
      last_sample_(names.size()),
      unknown_(names.size()) {
  if (is_sampled(format)) clock_.emplace(rate);
}

bool Losses::too_many_samples(Picoseconds time) const {
  return clock_ && time > Picoseconds{} &&
         time > clock_->time_of(std::min(most_samples, clock_->last_index()));
}

void Losses::add(const wire::Edge& edge) {
  ++edges_;
  unknown_[edge.line] = edge.level == wire::Level::unknown;
  if (unknown_[edge.line]) ++unknown_edges_;
  if (format_ == CaptureFormat::saleae_binary) {
    const auto back = capture::picoseconds_of(capture::seconds_of(edge.time));
    if (!back.ok() || *back != edge.time) ++inexact_;
  }
  if (!clock_) return;
  const std::uint64_t sample = clock_->first_at_or_after(edge.time);
  if (clock_->time_of(sample) != edge.time) ++moved_;
  // The sample shows the last of its changes.
  if (last_sample_[edge.line] == sample) ++lost_;
  last_sample_[edge.line] = sample;
}

void Losses::report_samples(report::Summary& summary) const {
  if (moved_ != 0) {
    summary.entry("moved", fmt::format("{} of {} changes", moved_, edges_),
                  fmt::format("to the next sample, at most {} later",
                              text_of(capture::longest_period(rate_))));
  }
  if (lost_ != 0) {
    summary.entry("lost", fmt::format("{} of {} changes", lost_, edges_),
                  "undone before the next sample: a higher --rate keeps them");
  }
  // Formats of changes hold them.
  if (clock_ && unknown_edges_ != 0) {
    summary.entry("lost", fmt::format("{} unknown levels", unknown_edges_), "written as 0");
  }
}

void Losses::report_names(report::Summary& summary, std::string_view path) const {
  if (const std::string* const name = changed_name(format_, names_)) {
    summary.entry("changed", fmt::format("name '{}'", *name),
                  "the format allows no such character; written as _");
  }
  if (format_ == CaptureFormat::raw) {
    const std::size_t unit_bytes = capture::packed_layout(names_, rate_).unit_bytes;
    summary.entry("not in it",
                  fmt::format("names and rate: bits 0 to {} are {}", names_.size() - 1,
                              fmt::join(names_, ", ")),
                  fmt::format("read it with --raw-rate {}{}", option_text(rate_),
                              unit_bytes == 1 ? "" : fmt::format(" --raw-bytes {}", unit_bytes)));
  }
  if (format_ == CaptureFormat::saleae_binary) {
    const std::string_view file = path.substr(path.rfind('/') + 1);
    if (!file.starts_with(names_.front() + '.')) {
      summary.entry("not in it", fmt::format("name '{}'", names_.front()),
                    "the line has the name of the file");
    }
  }
}

void Losses::report(report::Summary& summary, const CaptureClock& input,
                    std::string_view path) const {
  report_samples(summary);
  if (inexact_ != 0) {
    summary.entry("changed", fmt::format("{} of {} times", inexact_, edges_),
                  "beyond 75 minutes the format is coarser than a picosecond");
  }
  const bool unknown_at_end = std::find(unknown_.begin(), unknown_.end(), true) != unknown_.end();
  if (format_ == CaptureFormat::saleae_binary && unknown_at_end) {
    summary.entry("lost", "unknown level at the end",
                  "the file ends at the beginning of this level");
  }
  report_names(summary, path);
  if (input.period > Picoseconds{} && !is_sampled(format_) &&
      format_ != CaptureFormat::saleae_binary) {
    summary.entry("not in it",
                  input.rate.count != 0 ? "sample rate " + text_of(input.rate) : "sample rate",
                  "decode it with --resolution " + option_text(input.period));
  }
}

}  // namespace biss::verbs
