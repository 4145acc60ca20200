#include "verbs/explain/finding_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "biss/frame/format_text.hpp"
#include "device/quantity.hpp"
#include "report/summary.hpp"

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

// Observations joined by semicolons.
class EvidenceText {
 public:
  EvidenceText(const Evidence& evidence, const Context& context)
      : evidence_(evidence), context_(context) {}

  std::string of(Cause cause) {
    add_kinds(cause);
    add_figures(cause);
    return std::move(text_);
  }

 private:
  template <class... Values>
  void add(fmt::format_string<Values...> format, Values&&... values) {
    if (!text_.empty()) text_ += "; ";
    text_ += fmt::format(format, std::forward<Values>(values)...);
  }

  // Adds an observation, and the cycles in which it was seen.
  void add_sightings(std::string_view what, const Sightings& where) {
    const std::string first = time_words(where.first_time.count);
    if (where.first_cycle == where.last_cycle) {
      add("{} of {} cycles: {} (cycle {} at {})", where.count, evidence_.cycles, what,
          where.first_cycle, first);
    } else {
      add("{} of {} cycles: {} (cycles {} to {}, first at {})", where.count, evidence_.cycles, what,
          where.first_cycle, where.last_cycle, first);
    }
  }

  // The kinds of requests of a cause, the most frequent ones first, and the cycles in which they were
  // seen.
  void add_kinds(Cause cause) {
    std::vector<RequestKind> seen;
    for (const RequestKind kind : explain::kinds_of(cause)) {
      if (evidence_.count(kind) != 0) seen.push_back(kind);
    }
    std::stable_sort(seen.begin(), seen.end(), [&](RequestKind a, RequestKind b) {
      return evidence_.count(a) > evidence_.count(b);
    });
    seen.resize(std::min(seen.size(), kinds_shown));
    for (const RequestKind kind : seen) add_sightings(text_of(kind), evidence_.seen(kind));
  }

  void add_warnings() {
    if (evidence_.warnings.count == 0) return;
    add_sightings("a good frame reports a warning (nW = 0)", evidence_.warnings);
  }

  void add_range(std::string_view what, const Distribution& values) {
    if (values.count() == 0) return;
    if (values.min() == values.max()) {
      add("{} {}", what, time_words(values.min()));
    } else {
      add("{} {} to {}", what, time_words(values.min()), time_words(values.max()));
    }
  }

  void add_delay() {
    if (evidence_.line_delay.count() == 0 || evidence_.period.count() == 0) return;
    const std::int64_t delay = evidence_.line_delay.median();
    const std::int64_t period = std::max<std::int64_t>(evidence_.period.median(), 1);
    add("the line delay is {}, {:.2f} periods of {}", time_words(delay),
        static_cast<double>(delay) / static_cast<double>(period),
        text_of(rate_of(Picoseconds{period}), 3));
    const auto& extra = evidence_.extra_clocks;
    if (extra.count() != 0 && extra.median() > 0) {
      add("the master sends {} clock{} after STOP", extra.median(), extra.median() == 1 ? "" : "s");
    }
  }

  void add_format() {
    if (evidence_.has_format) {
      add("{} of {} frames with START pass the format {}", evidence_.passed,
          std::max(evidence_.answered, evidence_.passed),
          context_.format ? format_text(*context_.format).view() : "");
    }
    if (evidence_.truncated != 0 && evidence_.missing_bits.count() != 0) {
      add("requests end {} bit{} before the last one of the format{}",
          evidence_.missing_bits.median(), evidence_.missing_bits.median() == 1 ? "" : "s",
          evidence_.truncated_low == evidence_.truncated ? ", always with a 0 as STOP has" : "");
    }
    if (context_.identified) {
      add("the frames fit {} (confidence {:.2f})", format_text(context_.identified->format).view(),
          context_.identified->confidence);
    }
  }

  void add_ack() {
    const auto& late = evidence_.truncated_ack_clocks;
    const auto& good = evidence_.ack_clocks;
    if (late.count() != 0) {
      add("ACK takes up to {} clocks in frames with missing bits", late.max());
    }
    if (good.count() != 0) add("at most {} clocks in good frames", good.max());
  }

  void add_pulses(std::string_view line, std::uint64_t pulses) {
    if (pulses == 0) return;
    add("{} on {}", report::counted(pulses, "short pulse"), line);
  }

  // The rules that `biss check` fails, with the measured value and the limit.
  void add_limits() {
    for (const explain::Exceeded& each : evidence_.limits) {
      const decode::RuleText& rule = decode::text_of(each.rule);
      std::string seen;
      if (const auto& measured = each.result.measured) {
        const auto value = [&](std::int64_t thousandths) {
          return rule.unit == "ns"
                     ? time_words(thousandths)
                     : fmt::format("{:.4g} {}", static_cast<double>(thousandths) / 1000, rule.unit);
        };
        seen =
            fmt::format(", {} with a limit of {}", value(measured->worst), value(measured->limit));
      }
      add("biss check fails {} in {} of {} cases{}", rule.name, each.result.faults,
          each.result.cases, seen);
    }
  }

  void add_plausibility() {
    if (evidence_.late_turns != 0) {
      add("the turns do not follow the zero of the singleturn: at it the position is wrong by "
          "one turn for up to {}",
          report::counted(evidence_.late_turns, "frame"));
    }
    if (evidence_.steps.count != 0) {
      add_sightings("the position jumps far beyond its fastest motion", evidence_.steps);
    }
  }

  void add_checksum() {
    const std::uint64_t right = evidence_.count(RequestKind::other_checksum);
    add("{} of {} frames have ACK and START, {} the right checksum", evidence_.answered,
        evidence_.cycles, evidence_.has_format ? evidence_.passed : 0);
    if (!evidence_.usual.checksum || right == 0) return;
    add("in {} of {} wrong frames {}", right, evidence_.cycles - evidence_.good + 0,
        text_of(evidence_.usual.checksum->mistake));
  }

  void add_sampling() {
    if (evidence_.resolution.count == 0 || evidence_.period.count() == 0) return;
    add("edge times are accurate to {}: {:.1f} samples in a period of MA",
        time_words(evidence_.resolution.count),
        static_cast<double>(evidence_.period.median()) /
            static_cast<double>(evidence_.resolution.count));
  }

  void add_figures(Cause cause) {
    switch (cause) {
      case Cause::healthy:
        if (evidence_.has_format) {
          add("{} of {} cycles are good", evidence_.good, evidence_.cycles);
        } else {
          add("{} of {} cycles have the right structure; no format is known, so that no "
              "checksum is judged",
              evidence_.good, evidence_.cycles);
        }
        add_warnings();
        return add_delay();
      case Cause::wrong_format:
        return add_format();
      case Cause::ma_slo_swapped:
      case Cause::slo_inverted:
      case Cause::ma_inverted: {
        const explain::Reading& reading = context_.reading;
        const bool changed = (cause == Cause::ma_slo_swapped && reading.swapped) ||
                             (cause == Cause::slo_inverted && reading.slo_inverted) ||
                             (cause == Cause::ma_inverted && reading.ma_inverted);
        if (changed) {
          add("{} of {} cycles have ACK and START when the capture is read that way",
              evidence_.answered, evidence_.cycles);
        } else if (cause == Cause::ma_slo_swapped) {
          add("SLO stays high, as an open input does");
        } else if (cause == Cause::ma_inverted && evidence_.count(RequestKind::stop_repeats) != 0) {
          add("a STOP of 1 repeats the bit before it: the encoder misses the last clock");
          add_delay();
        }
        return;
      }
      case Cause::clock_too_fast_for_cable:
        if (evidence_.smear.count != 0) {
          add("SLO changes up to {} from its place", time_words(evidence_.smear.count));
        }
        return add_delay();
      case Cause::ack_longer_than_master_waits:
        return add_ack();
      case Cause::master_stops_early:
        add_range("clocks of MA last", evidence_.period);
        if (evidence_.missing_bits.count() != 0) {
          const auto [least, most] =
              std::pair(evidence_.missing_bits.min(), evidence_.missing_bits.max());
          add("{}{} bit{} missing", least == most ? "" : fmt::format("{} to ", least), most,
              most == 1 ? " is" : "s are");
        }
        return;
      case Cause::requested_too_soon:
        add_range("from the last edge of MA to such requests:", evidence_.rest_of_bad);
        return add_range("before good cycles:", evidence_.good_rest);
      case Cause::noise_on_slo:
        if (4 * evidence_.likely_positions > 3 * evidence_.failed_checks &&
            evidence_.failed_checks != 0) {
          add("in {} of {} wrong frames the position is plausible: the bits after it are "
              "wrong",
              evidence_.likely_positions, evidence_.failed_checks);
        }
        return add_pulses("SLO", evidence_.pulses_on_slo);
      case Cause::noise_on_ma:
        return add_pulses("MA", evidence_.pulses_on_ma);
      case Cause::supply_or_intermittent:
        if (evidence_.silent_runs != 0) {
          add("{} without an answer, for up to {} cycles",
              report::counted(evidence_.silent_runs, "time"), evidence_.longest_silence);
        }
        return;
      case Cause::no_encoder:
      case Cause::stuck_low:
        add("{} edges on SLO and {} on MA", evidence_.slo_edges, evidence_.ma_edges);
        return;
      case Cause::sampling_too_slow:
        return add_sampling();
      case Cause::not_biss:
        if (context_.other) {
          add("the lines look like {} ({:.2f}): {}", context_.other->name,
              context_.other->confidence, context_.other->why);
          return;
        }
        add("{} of {} requests have ACK and START", evidence_.answered, evidence_.cycles);
        return;
      case Cause::encoder_error:
        if (evidence_.cut_errors.count != 0) {
          add_sightings("a frame without its checksum has nE = 0", evidence_.cut_errors);
        }
        return add_warnings();
      case Cause::frames_lost_or_repeated:
        if (evidence_.life_zeros != 0) {
          add("after its highest value the sign of life is 0, not 1, in {} frames",
              evidence_.life_zeros);
        }
        return;
      case Cause::wrong_checksum:
        return add_checksum();
      case Cause::position_implausible:
        return add_plausibility();
      case Cause::limits_exceeded:
        return add_limits();
      case Cause::master_pauses_clock:
        if (evidence_.usual.rest_in_group) {
          add("the requests come in groups, with pauses of {} between them; each group begins with "
              "ACK, as one request with pauses does",
              time_words(evidence_.usual.rest_in_group->count));
        }
        return;
      case Cause::format_changes:
        if (!context_.format_parts.empty()) add("{}", context_.format_parts);
        return;
    }
  }

  const Evidence& evidence_;
  const Context& context_;
  std::string text_;
};

}  // namespace

std::string evidence_text(Cause cause, const Evidence& evidence, const Context& context) {
  return EvidenceText(evidence, context).of(cause);
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
