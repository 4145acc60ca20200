#include "verbs/compare/compare.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "verbs/common/identified.hpp"

namespace biss::verbs {

namespace {

using decode::Distribution;
using decode::Rule;

// A consequence counts half, so that its cause comes first.
constexpr double consequence = 0.5;
// A different motion of the axis is not a fault: its effect is smaller than the effect of any
// fault.
constexpr double other_motion = 0.01;
// With more samples in a period of MA, a capture loses nothing.
constexpr double enough_samples = 10;
// A request that is this many clocks shorter has no frame.
constexpr double clocks_of_full_effect = 4;
// Half of the shorter level of an even clock.
constexpr double duty_of_full_effect = 25;

double rounded(double value, double parts) { return std::round(value * parts) / parts; }

// A time, and how uncertain the comparison with it is: half the spread in the good link, and the
// resolution of both captures.
struct Times {
  double good = 0;
  double bad = 0;
  double doubt = 0;

  double apart() const { return std::max(0.0, std::abs(bad - good) - doubt); }
  // 1 for twice or half as much.
  double doublings() const {
    const double high = std::max(good, bad) - doubt;
    const double low = std::min(good, bad);
    if (high <= low) return 0;
    return low <= 0 ? 1 : std::min(1.0, std::log2(high / low));
  }
  // The same in units of the clock of each link.
  Times in_periods(const Times& periods) const {
    return {good / periods.good, bad / periods.bad, doubt / periods.good};
  }
};

// A count among cases.
struct Count {
  std::uint64_t count = 0;
  std::uint64_t cases = 0;

  double share() const {
    return cases == 0 ? 0 : static_cast<double>(count) / static_cast<double>(cases);
  }
};

// The square root of a change in a share: a link that loses one frame in a hundred does not work,
// and the effect of that is 0.1. 0 if chance explains the change: up to two standard deviations.
double share_effect(const Count& good, const Count& bad, bool may_exceed_one = false) {
  if (good.cases == 0 || bad.cases == 0) return 0;
  const double change = std::abs(bad.share() - good.share());
  const double all = Count{good.count + bad.count, good.cases + bad.cases}.share();
  const double variance = may_exceed_one ? all : all * (1 - all);
  const double of_mean = 1 / static_cast<double>(good.cases) + 1 / static_cast<double>(bad.cases);
  if (change <= 2 * std::sqrt(variance * of_mean)) return 0;
  return std::sqrt(std::min(change, 1.0));
}

class Comparison {
 public:
  Comparison(const Link& good, const Link& bad) : good_(good), bad_(bad) {
    resolution_ =
        static_cast<double>(good.resolution.count) + static_cast<double>(bad.resolution.count);
    period_ = times(good.evidence.period, bad.evidence.period);
  }

  // Causes before their consequences: the order stays if the effect is the same.
  std::vector<Difference> run() {
    compare_words();
    compare_clock();
    compare_encoder();
    compare_line();
    compare_requests();
    compare_results();
    compare_rules();
    compare_motion();
    std::stable_sort(found_.begin(), found_.end(),
                     [](const Difference& a, const Difference& b) { return a.effect > b.effect; });
    return std::move(found_);
  }

 private:
  void add(std::string property, std::string_view unit, double good, double bad, double effect) {
    const double rounded_effect = rounded(std::min(effect, 1.0), 100);
    if (rounded_effect <= 0) return;
    found_.push_back({std::move(property), unit, good, bad, rounded_effect});
  }
  void add_words(std::string property, std::string good, std::string bad) {
    found_.push_back({std::move(property), {}, std::move(good), std::move(bad), 1});
  }
  void add_times(std::string property, const std::optional<Times>& of, double effect) {
    if (of)
      add(std::move(property), "ns", rounded(of->good / 1e3, 1e3), rounded(of->bad / 1e3, 1e3),
          effect);
  }
  template <class CountOf>
  void add_share(std::string property, double weight, CountOf count_of) {
    const Count good = count_of(good_);
    const Count bad = count_of(bad_);
    add(std::move(property), "%", rounded(100 * good.share(), 100), rounded(100 * bad.share(), 100),
        weight * share_effect(good, bad));
  }
  // Medians of thousandths of a period, in percent.
  Times shares_of_period(const Distribution& good, const Distribution& bad) const {
    return {static_cast<double>(good.median()) / 10, static_cast<double>(bad.median()) / 10,
            static_cast<double>(good.spread()) / 20 +
                100 * resolution_ / std::min(period_->good, period_->bad)};
  }

  // Medians in picoseconds.
  std::optional<Times> times(const Distribution& good, const Distribution& bad) const {
    if (good.count() == 0 || bad.count() == 0) return std::nullopt;
    return Times{static_cast<double>(good.median()), static_cast<double>(bad.median()),
                 static_cast<double>(good.spread()) / 2 + resolution_};
  }
  // Spreads of a time.
  std::optional<Times> spreads(const Distribution& good, const Distribution& bad) const {
    if (good.count() == 0 || bad.count() == 0) return std::nullopt;
    return Times{static_cast<double>(good.spread()), static_cast<double>(bad.spread()),
                 2 * resolution_};
  }
  bool has_clock() const { return period_ && period_->good > 0 && period_->bad > 0; }
  // In quarters of the shorter period: the place of a bit may vary by one quarter (D2,
  // characteristics, row 8).
  double in_quarters(const std::optional<Times>& of) const {
    if (!of || !has_clock()) return 0;
    return std::min(1.0, of->apart() / (std::min(period_->good, period_->bad) / 4));
  }
  // A time that follows the clock has not changed by itself, and neither has a time that stays the
  // same.
  double beside_clock(const std::optional<Times>& of) const {
    if (!of) return 0;
    if (!has_clock()) return of->doublings();
    return std::min(of->doublings(), of->in_periods(*period_).doublings());
  }

  static const FrameFormat* format_of(const Link& link) {
    if (link.context.identified) return &link.context.identified->format;
    return link.context.format ? &*link.context.format : nullptr;
  }
  static std::string inverted_text(const explain::Reading& reading) {
    if (reading.ma_inverted && reading.slo_inverted) return "MA, SLO";
    return reading.ma_inverted ? "MA" : reading.slo_inverted ? "SLO" : "none";
  }
  static std::string lines_text(const Link& link) {
    return fmt::format("MA = {}, SLO = {}", link.ma, link.slo);
  }
  static std::string protocol_of(const Link& link) {
    const auto& other = link.context.other;
    return other && other->confidence >= 0.5 ? other->name : "biss_c";
  }

  void compare_words() {
    if (protocol_of(good_) != protocol_of(bad_)) {
      add_words("protocol", protocol_of(good_), protocol_of(bad_));
    }
    const explain::Reading& good = good_.context.reading;
    const explain::Reading& bad = bad_.context.reading;
    if (good.swapped != bad.swapped) add_words("lines", lines_text(good_), lines_text(bad_));
    if (good.ma_inverted != bad.ma_inverted || good.slo_inverted != bad.slo_inverted) {
      add_words("inverted", inverted_text(good), inverted_text(bad));
    }
    const FrameFormat* of_good = format_of(good_);
    const FrameFormat* of_bad = format_of(bad_);
    if (of_good != nullptr && of_bad != nullptr && *of_good != *of_bad) {
      add_words("format", text_of(*of_good), text_of(*of_bad));
    }
  }

  void compare_clock() {
    if (!has_clock()) return;
    const auto rate = [](double period) { return std::round(1e12 / period); };
    add("clock", "Hz", rate(period_->good), rate(period_->bad), period_->doublings());
    const Distribution& good = good_.statistics.duty();
    const Distribution& bad = bad_.statistics.duty();
    if (good.count() != 0 && bad.count() != 0) {
      const Times duty = shares_of_period(good, bad);
      add("duty", "%", duty.good, duty.bad, duty.apart() / duty_of_full_effect);
    }
    const auto jitter = times(good_.jitter_ma, bad_.jitter_ma);
    add_times("jitter_ma", jitter, in_quarters(jitter));
    // Sampling that is finer than needed makes no difference.
    const auto samples = [](const Link& link, double period) {
      const auto step = static_cast<double>(link.resolution.count);
      return step == 0 ? enough_samples : std::min(enough_samples, period / step);
    };
    const Times both{samples(good_, period_->good), samples(bad_, period_->bad), 0};
    add("samples_per_clock", "samples", rounded(both.good, 10), rounded(both.bad, 10),
        both.doublings());
  }

  void compare_encoder() {
    const auto ack = times(good_.statistics.ack(), bad_.statistics.ack());
    const double effect = beside_clock(ack);
    const Distribution& good = good_.statistics.ack_clocks();
    const Distribution& bad = bad_.statistics.ack_clocks();
    if (ack && good.median() != bad.median()) {
      add("ack_clocks", "clocks", static_cast<double>(good.median()),
          static_cast<double>(bad.median()), effect);
    }
    add_times("ack", ack, effect);
    // At the encoder: without the line delay.
    auto release = times(good_.evidence.release, bad_.evidence.release);
    if (const auto delay = delays(); release && delay) {
      release->good -= delay->good;
      release->bad -= delay->bad;
      release->doubt += delay->doubt;
    }
    if (release && release->good > 0 && release->bad > 0) {
      add_times("timeout", release, beside_clock(release));
    }
    add_share("nE", 1, [](const Link& link) {
      return Count{link.statistics.errors(), link.statistics.count(CycleStatus::ok)};
    });
    add_share("nW", 1, [](const Link& link) {
      return Count{link.statistics.warnings(), link.statistics.count(CycleStatus::ok)};
    });
  }

  std::optional<Times> delays() const {
    return times(good_.statistics.line_delay(), bad_.statistics.line_delay());
  }

  void compare_line() {
    add_times("line_delay", delays(), in_quarters(delays()));
    const auto spread = spreads(good_.statistics.line_delay(), bad_.statistics.line_delay());
    add_times("line_delay_spread", spread, in_quarters(spread));
    const auto jitter = times(good_.jitter_slo, bad_.jitter_slo);
    add_times("jitter_slo", jitter, in_quarters(jitter));
    add_pulses("pulses_ma", good_.evidence.pulses_on_ma, bad_.evidence.pulses_on_ma);
    add_pulses("pulses_slo", good_.evidence.pulses_on_slo, bad_.evidence.pulses_on_slo);
  }

  void add_pulses(std::string property, std::uint64_t good, std::uint64_t bad) {
    const Count of_good{good, good_.evidence.cycles};
    const Count of_bad{bad, bad_.evidence.cycles};
    add(std::move(property), "per cycle", rounded(of_good.share(), 1e4),
        rounded(of_bad.share(), 1e4), share_effect(of_good, of_bad, true));
  }

  // A master without an answer makes its next requests in a different way.
  double request_weight() const {
    const bool good = good_.statistics.ack().count() != 0;
    return good == (bad_.statistics.ack().count() != 0) ? 1 : consequence * consequence;
  }

  void compare_requests() {
    compare_clocks();
    const auto interval = times(good_.statistics.interval(), bad_.statistics.interval());
    if (interval && interval->good > 0 && interval->bad > 0) {
      add("request_rate", "Hz", rounded(1e12 / interval->good, 10),
          rounded(1e12 / interval->bad, 10), request_weight() * beside_clock(interval));
    }
    if (good_.rest.count() == 0 || bad_.rest.count() == 0) return;
    const std::optional<Times> rest = Times{static_cast<double>(good_.rest.tenth()),
                                            static_cast<double>(bad_.rest.tenth()), resolution_};
    add_times("rest", rest, request_weight() * beside_clock(rest));
  }

  // More or fewer clocks than a longer or shorter frame, ACK and line delay explain.
  void compare_clocks() {
    const Distribution& good = good_.evidence.rising_edges;
    const Distribution& bad = bad_.evidence.rising_edges;
    if (good.count() == 0 || bad.count() == 0) return;
    double least = 0;
    double most = 0;
    const auto explain = [&](double clocks) { (clocks < 0 ? least : most) += clocks; };
    if (const auto* of_good = format_of(good_), *of_bad = format_of(bad_); of_good && of_bad) {
      explain(static_cast<double>(of_bad->payload_bits()) -
              static_cast<double>(of_good->payload_bits()));
    }
    const Distribution& ack_good = good_.statistics.ack_clocks();
    const Distribution& ack_bad = bad_.statistics.ack_clocks();
    if (ack_good.count() != 0 && ack_bad.count() != 0) {
      explain(static_cast<double>(ack_bad.median() - ack_good.median()));
    }
    if (const auto delay = delays(); delay && has_clock()) {
      explain(std::round(delay->bad / period_->bad - delay->good / period_->good));
    }
    const auto of_good = static_cast<double>(good.median());
    const auto of_bad = static_cast<double>(bad.median());
    const double change = of_bad - of_good;
    const double doubt = static_cast<double>(good.spread()) / 2;
    const double beyond = std::max({0.0, change - most - doubt, least - doubt - change});
    add("clocks", "clocks", of_good, of_bad,
        request_weight() * std::min(1.0, beyond / clocks_of_full_effect));
  }

  void compare_results() {
    for (std::size_t i = 0; i < cycle_status_count; ++i) {
      const auto status = static_cast<CycleStatus>(i);
      if (!is_fault(status)) continue;
      add_share(fmt::format("status_{}", name_of(status)), consequence, [status](const Link& link) {
        return Count{link.evidence.status(status), link.evidence.cycles};
      });
    }
    add_share("good", consequence, [](const Link& link) {
      return Count{link.evidence.good, link.evidence.cycles};
    });
    add_share("marginal", consequence, [](const Link& link) {
      return Count{link.statistics.marginal(), link.statistics.margin_judged()};
    });
    if (good_.margin.count() == 0 || bad_.margin.count() == 0 || !has_clock()) return;
    const Times margin = shares_of_period(good_.margin, bad_.margin);
    add("sampling_margin", "%", margin.good, margin.bad,
        consequence * std::min(1.0, margin.apart() / 50));
  }

  // Up to twice or half as much is the same motion.
  void compare_motion() {
    const auto compare = [this](std::string property, std::string_view unit, std::int64_t good,
                                std::int64_t bad) {
      const double doublings =
          std::abs(std::log2((static_cast<double>(bad) + 1) / (static_cast<double>(good) + 1)));
      if (doublings <= 1) return;
      add(std::move(property), unit, static_cast<double>(good), static_cast<double>(bad),
          other_motion);
    };
    if (good_.step.count() == 0 || bad_.step.count() == 0) return;
    compare("largest_step", "counts", good_.step.max(), bad_.step.max());
    compare("speed", "counts/s", good_.speed.median(), bad_.speed.median());
  }

  // Rules that the statuses and the other properties do not show. The drift is judged against the
  // whole capture before: a single cycle makes all later ones fail.
  void compare_rules() {
    constexpr std::array shown{Rule::frame_structure,
                               Rule::frame_crc,
                               Rule::start,
                               Rule::cds_zero,
                               Rule::stop,
                               Rule::glitch_ma,
                               Rule::glitch_slo,
                               Rule::nE,
                               Rule::nW,
                               Rule::speed,
                               Rule::sampling_uncompensated,
                               Rule::line_delay_drift};
    for (std::size_t i = 0; i < decode::rule_count; ++i) {
      const auto rule = static_cast<Rule>(i);
      if (std::find(shown.begin(), shown.end(), rule) != shown.end()) continue;
      add_share(fmt::format("limit_{}", decode::text_of(rule).name), consequence,
                [i](const Link& link) {
                  const decode::RuleResult& result = link.rules[i];
                  return Count{std::min(result.faults, result.cases), result.cases};
                });
    }
  }

  const Link& good_;
  const Link& bad_;
  // The resolution of both captures together, in picoseconds.
  double resolution_ = 0;
  std::optional<Times> period_;
  std::vector<Difference> found_;
};

}  // namespace

std::vector<Difference> differences(const Link& good, const Link& bad) {
  return Comparison(good, bad).run();
}

}  // namespace biss::verbs
