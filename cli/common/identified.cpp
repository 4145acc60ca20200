#include "cli/common/identified.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <bit>

#include "biss/frame/format_text.hpp"
#include "cli/common/decoded_capture.hpp"
#include "report/summary.hpp"

namespace biss::cli {

namespace {

using identify::Doubt;
using identify::FormatCandidate;
using identify::FormatFinding;

std::string_view sentence_of(Doubt doubt) {
  switch (doubt) {
    case Doubt::still:
      return "a position did not move: capture while the axis moves";
    case Doubt::order:
      return "the motion does not show the order of the bits of the position, or Gray code: "
             "capture "
             "a slower and longer motion";
    case Doubt::scale:
      return "the lowest bits of the position do not move: padding, or a coarse position; capture "
             "another speed";
    case Doubt::flag_level:
      return "a flag is 0 in most frames: the encoder reports an error or a warning, or the flag "
             "is active-high";
    case Doubt::flags:
      return "the lowest bits of the position and the flags cannot be separated: capture another "
             "motion";
    case Doubt::counter:
      return "some bits count the frames: a sign of life, or a position at constant speed; capture "
             "another speed";
    case Doubt::checksum:
      return "too few different frames to be sure of the checksum: capture more cycles with motion";
    case Doubt::unchecked:
      return "no checksum fits the frames";
  }
  return "";
}

}  // namespace

std::string text_of(const FrameFormat& format) { return std::string(format_text(format).view()); }

std::string encoders_text(const FormatCandidate& candidate, std::size_t most) {
  const auto& names = candidate.encoders;
  const std::size_t count = std::min(most, names.size());
  return fmt::format("{}{}",
                     fmt::join(names.begin(), names.begin() + static_cast<long>(count), ", "),
                     count < names.size() ? ", ..." : "");
}

std::vector<std::string> what_is_missing(const FormatFinding& finding) {
  std::vector<std::string> sentences;
  if (finding.sure() != nullptr) return sentences;
  if (finding.candidates.empty()) return {"no frame was complete"};
  for (const Doubt doubt : finding.doubts) sentences.emplace_back(sentence_of(doubt));
  return sentences;
}

std::string what_is_still(const FormatCandidate& candidate) {
  std::vector<std::string> parts;
  for (std::size_t k = 0; k < candidate.format.channel_count; ++k) {
    const ChannelFormat& channel = candidate.format.channel_list[k];
    const identify::Fields& seen = candidate.fields[k];
    const std::string of =
        candidate.format.channel_count > 1 ? fmt::format(" (channel {})", k + 1) : "";
    const auto moved = static_cast<unsigned>(std::popcount(seen.position_moved));
    if (moved < channel.position_bits()) {
      parts.push_back(fmt::format("{} of {} bits of the position{}",
                                  channel.position_bits() - moved, channel.position_bits(), of));
    }
    const auto is_still = [&](const FlagField& flag) {
      return flag.present && ((seen.moved >> flag.shift) & 1U) == 0;
    };
    if (is_still(channel.error)) parts.push_back((channel.error.active_high ? "E" : "nE") + of);
    if (is_still(channel.warning)) parts.push_back((channel.warning.active_high ? "W" : "nW") + of);
  }
  return fmt::format("{}", fmt::join(parts, ", "));
}

void add_identified(report::Summary& summary, const FormatFinding& finding, bool used) {
  if (const FormatCandidate* sure = finding.sure()) {
    const std::string text = text_of(sure->format);
    summary.entry("format", text,
                  used ? fmt::format("identified, confidence {:.2f}; the same as -f \"{}\"",
                                     sure->confidence, text)
                       : fmt::format("identified, confidence {:.2f}; its columns differ from "
                                     "those of the first capture: decode it alone",
                                     sure->confidence));
    if (!sure->encoders.empty()) summary.entry("", "fits", encoders_text(*sure, 6));
    const std::string still = what_is_still(*sure);
    if (!still.empty()) summary.entry("", "not moved", still + ": their meaning is not known");
    return;
  }
  bool first = true;
  for (const std::string& sentence : what_is_missing(finding)) {
    summary.entry(first ? "format" : "", first ? "not known" : "", sentence);
    first = false;
  }
  constexpr std::size_t most = 3;
  for (std::size_t i = 0; i < std::min(most, finding.candidates.size()); ++i) {
    summary.entry("", i == 0 ? "may be" : "or",
                  fmt::format("{} ({:.2f})", text_of(finding.candidates[i].format),
                              finding.candidates[i].confidence));
  }
}

void add_used_format(report::Summary& summary, const DecodedCapture& capture, bool given) {
  const bool identified = !given && capture.finding() != nullptr;
  if (identified) {
    add_identified(summary, *capture.finding(), capture.format().has_value());
  } else if (capture.format()) {
    summary.entry("format", text_of(*capture.format()));
  }
  if (capture.format()) return;
  summary.entry(identified ? "" : "format", identified ? "used: none" : "none",
                "only the structure is checked; give -f FORMAT");
}

}  // namespace biss::cli
