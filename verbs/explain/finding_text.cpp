#include "verbs/explain/finding_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "biss/frame/format_text.hpp"
#include "device/quantity.hpp"

namespace biss::verbs {

namespace {

using decode::Distribution;
using explain::Context;
using explain::Evidence;
using explain::RequestKind;
using explain::Sightings;

constexpr std::size_t kinds_shown = 3;
constexpr std::size_t formats_shown = 3;

std::string time_words(std::int64_t picoseconds) { return text_of(Picoseconds{picoseconds}, 3); }

// Parts joined by semicolons.
class Parts {
 public:
  template <class... Values>
  void add(fmt::format_string<Values...> format, Values&&... values) {
    if (!text_.empty()) text_ += "; ";
    text_ += fmt::format(format, std::forward<Values>(values)...);
  }
  std::string text() && { return std::move(text_); }

 private:
  std::string text_;
};

// Adds an observation, and the cycles in which it was seen.
void add_sightings(std::string_view what, const Sightings& where, const Evidence& evidence,
                   Parts& parts) {
  const std::string first = time_words(where.first_time.count);
  if (where.first_cycle == where.last_cycle) {
    parts.add("{} of {} cycles: {} (cycle {} at {})", where.count, evidence.cycles, what,
              where.first_cycle, first);
  } else {
    parts.add("{} of {} cycles: {} (cycles {} to {}, first at {})", where.count, evidence.cycles,
              what, where.first_cycle, where.last_cycle, first);
  }
}

// The kinds of requests of a cause, the most frequent ones first, and the cycles in which they were
// seen.
void add_kinds(Cause cause, const Evidence& evidence, Parts& parts) {
  std::vector<RequestKind> seen;
  for (const RequestKind kind : explain::kinds_of(cause)) {
    if (evidence.count(kind) != 0) seen.push_back(kind);
  }
  std::stable_sort(seen.begin(), seen.end(), [&](RequestKind a, RequestKind b) {
    return evidence.count(a) > evidence.count(b);
  });
  seen.resize(std::min(seen.size(), kinds_shown));
  for (const RequestKind kind : seen) {
    add_sightings(text_of(kind), evidence.seen(kind), evidence, parts);
  }
}

void add_warnings(const Evidence& evidence, Parts& parts) {
  if (evidence.warnings.count == 0) return;
  add_sightings("a good frame reports a warning (nW = 0)", evidence.warnings, evidence, parts);
}

void add_range(std::string_view what, const Distribution& values, Parts& parts) {
  if (values.count() == 0) return;
  if (values.min() == values.max()) {
    parts.add("{} {}", what, time_words(values.min()));
  } else {
    parts.add("{} {} to {}", what, time_words(values.min()), time_words(values.max()));
  }
}

void add_delay(const Evidence& evidence, Parts& parts) {
  if (evidence.line_delay.count() == 0 || evidence.period.count() == 0) return;
  const std::int64_t delay = evidence.line_delay.median();
  const std::int64_t period = std::max<std::int64_t>(evidence.period.median(), 1);
  parts.add("the line delay is {}, {:.2f} periods of {}", time_words(delay),
            static_cast<double>(delay) / static_cast<double>(period),
            text_of(rate_of(Picoseconds{period}), 3));
  const auto& extra = evidence.extra_clocks;
  if (extra.count() != 0 && extra.median() > 0) {
    parts.add("the master sends {} clock{} after STOP", extra.median(),
              extra.median() == 1 ? "" : "s");
  }
}

void add_format(const Evidence& evidence, const Context& context, Parts& parts) {
  if (evidence.has_format) {
    parts.add("{} of {} frames with START pass the format {}", evidence.passed,
              std::max(evidence.answered, evidence.passed),
              context.format ? format_text(*context.format).view() : "");
  }
  if (evidence.truncated != 0 && evidence.missing_bits.count() != 0) {
    parts.add("requests end {} bit{} before the last one of the format{}",
              evidence.missing_bits.median(), evidence.missing_bits.median() == 1 ? "" : "s",
              evidence.truncated_low == evidence.truncated ? ", always with a 0 as STOP has" : "");
  }
  if (context.identified) {
    parts.add("the frames fit {} (confidence {:.2f})",
              format_text(context.identified->format).view(), context.identified->confidence);
  }
}

void add_ack(const Evidence& evidence, Parts& parts) {
  const auto& late = evidence.truncated_ack_clocks;
  const auto& good = evidence.ack_clocks;
  if (late.count() != 0) {
    parts.add("ACK takes up to {} clocks in frames with missing bits", late.max());
  }
  if (good.count() != 0) parts.add("at most {} clocks in good frames", good.max());
}

void add_pulses(std::string_view line, std::uint64_t pulses, Parts& parts) {
  if (pulses == 0) return;
  parts.add("{} short pulse{} on {}", pulses, pulses == 1 ? "" : "s", line);
}

// The rules that `biss check` fails, with the measured value and the limit.
void add_limits(const Evidence& evidence, Parts& parts) {
  for (const explain::Exceeded& each : evidence.limits) {
    const decode::RuleText& rule = decode::text_of(each.rule);
    std::string seen;
    if (const auto& measured = each.result.measured) {
      const auto value = [&](std::int64_t thousandths) {
        return rule.unit == "ns"
                   ? time_words(thousandths)
                   : fmt::format("{:.4g} {}", static_cast<double>(thousandths) / 1000, rule.unit);
      };
      seen = fmt::format(", {} with a limit of {}", value(measured->worst), value(measured->limit));
    }
    parts.add("biss check fails {} in {} of {} cases{}", rule.name, each.result.faults,
              each.result.cases, seen);
  }
}

void add_plausibility(const Evidence& evidence, Parts& parts) {
  if (evidence.late_turns != 0) {
    parts.add(
        "the turns change before or after the zero of the singleturn: in between the position is "
        "wrong by one turn for up to {} frame{}",
        evidence.late_turns, evidence.late_turns == 1 ? "" : "s");
  }
  if (evidence.steps.count != 0) {
    add_sightings("the position jumps far beyond its fastest motion", evidence.steps, evidence,
                  parts);
  }
}

void add_checksum(const Evidence& evidence, Parts& parts) {
  const std::uint64_t right = evidence.count(RequestKind::other_checksum);
  parts.add("{} of {} frames have ACK and START, {} the right checksum", evidence.answered,
            evidence.cycles, evidence.has_format ? evidence.passed : 0);
  if (!evidence.usual.checksum || right == 0) return;
  parts.add("in {} of {} wrong frames {}", right, evidence.cycles - evidence.good + 0,
            text_of(evidence.usual.checksum->mistake));
}

void add_sampling(const Evidence& evidence, Parts& parts) {
  if (evidence.resolution.count == 0 || evidence.period.count() == 0) return;
  parts.add("edge times are accurate to {}: {:.1f} samples in a period of MA",
            time_words(evidence.resolution.count),
            static_cast<double>(evidence.period.median()) /
                static_cast<double>(evidence.resolution.count));
}

void add_figures(Cause cause, const Evidence& evidence, const Context& context, Parts& parts) {
  switch (cause) {
    case Cause::healthy:
      if (evidence.has_format) {
        parts.add("{} of {} cycles are good", evidence.good, evidence.cycles);
      } else {
        parts.add(
            "{} of {} cycles have the right structure; no format is known, so that no "
            "checksum is judged",
            evidence.good, evidence.cycles);
      }
      add_warnings(evidence, parts);
      return add_delay(evidence, parts);
    case Cause::wrong_format:
      return add_format(evidence, context, parts);
    case Cause::ma_slo_swapped:
    case Cause::slo_inverted:
    case Cause::ma_inverted: {
      const explain::Reading& reading = context.reading;
      const bool changed = (cause == Cause::ma_slo_swapped && reading.swapped) ||
                           (cause == Cause::slo_inverted && reading.slo_inverted) ||
                           (cause == Cause::ma_inverted && reading.ma_inverted);
      if (changed) {
        parts.add("{} of {} cycles have ACK and START when the capture is read that way",
                  evidence.answered, evidence.cycles);
      } else if (cause == Cause::ma_slo_swapped) {
        parts.add("SLO stays high, as an open input does");
      } else if (cause == Cause::ma_inverted && evidence.count(RequestKind::stop_repeats) != 0) {
        parts.add("a STOP of 1 repeats the bit before it: the encoder misses the last clock");
        add_delay(evidence, parts);
      }
      return;
    }
    case Cause::clock_too_fast_for_cable:
      if (evidence.smear.count != 0) {
        parts.add("SLO changes up to {} from its place", time_words(evidence.smear.count));
      }
      return add_delay(evidence, parts);
    case Cause::ack_longer_than_master_waits:
      return add_ack(evidence, parts);
    case Cause::master_stops_early:
      add_range("clocks of MA last", evidence.period, parts);
      if (evidence.missing_bits.count() != 0) {
        const auto [least, most] =
            std::pair(evidence.missing_bits.min(), evidence.missing_bits.max());
        parts.add("{}{} bit{} missing", least == most ? "" : fmt::format("{} to ", least), most,
                  most == 1 ? " is" : "s are");
      }
      return;
    case Cause::requested_too_soon:
      add_range("from the last edge of MA to such requests:", evidence.rest_of_bad, parts);
      return add_range("before good cycles:", evidence.good_rest, parts);
    case Cause::noise_on_slo:
      if (4 * evidence.likely_positions > 3 * evidence.failed_checks &&
          evidence.failed_checks != 0) {
        parts.add(
            "in {} of {} wrong frames the position is plausible: the bits after it are "
            "wrong",
            evidence.likely_positions, evidence.failed_checks);
      }
      return add_pulses("SLO", evidence.pulses_on_slo, parts);
    case Cause::noise_on_ma:
      return add_pulses("MA", evidence.pulses_on_ma, parts);
    case Cause::supply_or_intermittent:
      if (evidence.silent_runs != 0) {
        parts.add("{} time{} without an answer, for up to {} cycles", evidence.silent_runs,
                  evidence.silent_runs == 1 ? "" : "s", evidence.longest_silence);
      }
      return;
    case Cause::no_encoder:
    case Cause::stuck_low:
      parts.add("{} edges on SLO and {} on MA", evidence.slo_edges, evidence.ma_edges);
      return;
    case Cause::sampling_too_slow:
      return add_sampling(evidence, parts);
    case Cause::not_biss:
      if (context.other) {
        parts.add("the lines look like {} ({:.2f}): {}", context.other->name,
                  context.other->confidence, context.other->why);
        return;
      }
      parts.add("{} of {} requests have ACK and START", evidence.answered, evidence.cycles);
      return;
    case Cause::encoder_error:
      if (evidence.cut_errors.count != 0) {
        add_sightings("a frame without its checksum has nE = 0", evidence.cut_errors, evidence,
                      parts);
      }
      return add_warnings(evidence, parts);
    case Cause::frames_lost_or_repeated:
      if (evidence.life_zeros != 0) {
        parts.add("after its highest value the sign of life is 0, not 1, in {} frames",
                  evidence.life_zeros);
      }
      return;
    case Cause::wrong_checksum:
      return add_checksum(evidence, parts);
    case Cause::position_implausible:
      return add_plausibility(evidence, parts);
    case Cause::limits_exceeded:
      return add_limits(evidence, parts);
    case Cause::master_pauses_clock:
      if (evidence.usual.rest_in_group) {
        parts.add(
            "the requests come in groups, with pauses of {} between them; each group begins with "
            "ACK, as one request with pauses does",
            time_words(evidence.usual.rest_in_group->count));
      }
      return;
    case Cause::format_changes:
      if (!context.format_parts.empty()) parts.add("{}", context.format_parts);
      return;
  }
}

}  // namespace

std::string evidence_text(Cause cause, const Evidence& evidence, const Context& context) {
  Parts parts;
  add_kinds(cause, evidence, parts);
  add_figures(cause, evidence, context, parts);
  return std::move(parts).text();
}

std::string remedy_text(Cause cause, const Evidence& evidence, const Context& context) {
  std::string remedy(remedy_of(cause));
  if (cause == Cause::healthy && !evidence.has_format) {
    remedy = fmt::format("give -f {}, so that the checksums are judged",
                         context.identified ? format_text(context.identified->format).view()
                                            : std::string_view("FORMAT"));
    for (std::size_t i = 0; i < std::min(formats_shown, context.candidates.size()); ++i) {
      remedy += fmt::format("{}{}", i == 0 ? "; it may be " : " or ",
                            format_text(context.candidates[i]).view());
    }
  }
  if (cause == Cause::healthy && evidence.warnings.count != 0) {
    remedy =
        "the link needs no action, and the positions are valid; the warning of a Renishaw encoder "
        "asks to clean the scale or the reading window; for other encoders see the data sheet";
  }
  if (cause == Cause::wrong_format && context.identified) {
    remedy = fmt::format("give -f {}", format_text(context.identified->format).view());
  }
  if (cause == Cause::wrong_checksum && evidence.usual.checksum &&
      !evidence.usual.checksum->format.empty()) {
    remedy += fmt::format("; until then decode -f {} reads the positions",
                          evidence.usual.checksum->format);
  }
  if ((cause == Cause::healthy || cause == Cause::frames_lost_or_repeated) &&
      evidence.life_zeros != 0) {
    remedy =
        "the sign of life counts from 0 to its highest value, not from 1: give decode "
        "--counter count_0_63, and set the safety monitor to that range";
  }
  if (cause == Cause::sampling_too_slow && evidence.period.count() != 0) {
    const Picoseconds period{std::max<std::int64_t>(evidence.period.median(), 10)};
    remedy += fmt::format("; this clock needs {} or more", text_of(rate_of(period / 10), 0));
  }
  return remedy;
}

}  // namespace biss::verbs
