#include "verbs/common/identified.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <bit>

#include "biss/frame/format_text.hpp"
#include "verbs/common/decoded_capture.hpp"

namespace biss::verbs {

namespace {

using identify::FormatCandidate;
using identify::FormatFinding;

constexpr std::string_view no_checksum =
    "too few different frames to be sure of the checksum: capture more cycles with motion";

// The difference between two candidates, and what to capture to see it.
std::string_view doubt_between(const FormatCandidate& a, const FormatCandidate& b) {
  if (a.format.channel_count != b.format.channel_count) return no_checksum;
  for (std::size_t k = 0; k < a.fields.size(); ++k) {
    const ChannelFormat& one = a.format.channel_list[k];
    const ChannelFormat& other = b.format.channel_list[k];
    if (one.data_bits != other.data_bits || one.crc != other.crc) return no_checksum;
    if (one.life_counter != other.life_counter) {
      return "some bits count the frames: a sign of life, or a position at constant speed; capture "
             "another speed";
    }
    if (a.fields[k].coding != b.fields[k].coding || a.fields[k].split != b.fields[k].split) {
      return "the motion does not show the order of the bits of the position, or Gray code: "
             "capture a slower and longer motion";
    }
    if (one.flags_mask() != other.flags_mask()) {
      return "the lowest bits of the position and the flags cannot be separated: capture another "
             "motion";
    }
    if (one.error != other.error || one.warning != other.warning) {
      return "a flag is 0 in most frames: the encoder reports an error or a warning, or the flag "
             "is active-high";
    }
  }
  return "the lowest bits of the position do not move: padding, or a coarse position; capture "
         "another speed";
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
  // A candidate that is less likely than this, compared with the first one, is not considered.
  constexpr double least_share = 0.05;
  const FormatCandidate& best = finding.candidates.front();
  if (finding.still) {
    sentences.emplace_back("a position did not move: capture while the axis moves");
  } else if (!best.layout.checked()) {
    sentences.emplace_back("no checksum fits the frames");
  } else {
    for (const FormatCandidate& each : finding.candidates) {
      if (&each == &best || each.confidence < least_share * best.confidence) continue;
      const std::string_view doubt = doubt_between(best, each);
      if (std::find(sentences.begin(), sentences.end(), doubt) == sentences.end()) {
        sentences.emplace_back(doubt);
      }
    }
    if (sentences.empty()) sentences.emplace_back(no_checksum);
  }
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
                                     "the columns of the first capture: decode it alone",
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

}  // namespace biss::verbs
