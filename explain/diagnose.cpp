#include "explain/diagnose.hpp"

#include <algorithm>
#include <cmath>

#include "biss/timing/cable.hpp"
namespace biss::explain {

namespace {

using decode::CycleStatus;

using Weights = std::array<double, cause_count>;

double& at(Weights& weights, Cause cause) { return weights[static_cast<std::size_t>(cause)]; }

// How often a symptom occurs under a cause: shares of its affected cycles, rounded. Measured with
// the simulator; what the tables leave out is `elsewhere`.
struct Share {
  Symptom symptom;
  double share;
};
struct CauseShares {
  Cause cause;
  std::vector<Share> shares;
};
constexpr double elsewhere = 0.003;

// What is less likely is not listed.
constexpr double least_likelihood = 0.015;

// Without a format no checksum is judged: damaged frames look like good ones.
constexpr double healthy_without_format = 0.5;

// With fewer samples in a period of MA, edges are in doubt.
constexpr double coarse_samples = 5.2;

const std::vector<CauseShares>& cause_shares() {
  using C = Cause;
  using S = Symptom;
  static const std::vector<CauseShares> all{
      {C::wrong_format,
       {{S::flipped, .6},
        {S::slipped, .6},
        {S::cut_short, .5},
        {S::other_ack, .5},
        {S::cds_high, .7},
        {S::stop_high, .6},
        {S::tail_low, .3},
        {S::tail_high, .2},
        {S::cut_in_ack, .05},
        {S::error_flag, .02}}},
      {C::slo_inverted, {{S::inverted, .7}, {S::busy, .15}, {S::stuck, .3}}},
      {C::ma_inverted,
       {{S::half_early, .9},
        {S::stop_high, .5},
        {S::flipped, .1},
        {S::slipped, .1},
        {S::delay_changed, .01}}},
      {C::clock_too_fast_for_cable,
       {{S::smeared, .6},
        {S::delay_changed, .5},
        {S::flipped, .08},
        {S::slipped, .25},
        {S::late_answer, .03},
        {S::half_early, .1}}},
      {C::ack_longer_than_master_waits, {{S::cut_in_ack, .95}, {S::cut_short, .3}}},
      {C::master_stops_early, {{S::cut_short, .9}, {S::cut_in_ack, .1}, {S::tail_high, .05}}},
      {C::requested_too_soon,
       {{S::busy, .7}, {S::early, .3}, {S::stuck, .35}, {S::silent, .02}, {S::late_answer, .05}}},
      {C::noise_on_slo,
       {{S::flipped, .75},
        {S::slo_pulse, .9},
        {S::slipped, .05},
        {S::smeared, .03},
        {S::tail_low, .02},
        {S::other_ack, .06},
        {S::cut_in_ack, .03},
        {S::cut_short, .03},
        {S::early, .02},
        {S::cds_high, .02},
        {S::stop_high, .02}}},
      {C::noise_on_ma,
       {{S::ma_pulse, .95},
        {S::ma_uneven, .3},
        {S::slipped, .5},
        {S::flipped, .3},
        {S::cut_short, .02},
        {S::other_ack, .04},
        {S::life_jump, .05},
        {S::slo_pulse, .15}}},
      {C::supply_or_intermittent,
       {{S::silent, .6},
        {S::late_answer, .5},
        {S::tail_high, .6},
        {S::stop_high, .05},
        {S::flipped, .05},
        {S::other_ack, .05},
        {S::cut_short, .05},
        {S::cut_in_ack, .03},
        {S::early, .03},
        {S::slipped, .02},
        {S::smeared, .03},
        {S::slo_pulse, .01}}},
      {C::no_encoder, {{S::silent, .98}, {S::slo_pulse, .1}}},
      {C::stuck_low, {{S::stuck, .95}, {S::tail_low, .5}, {S::cut_in_ack, .12}, {S::busy, .1}}},
      {C::encoder_error, {{S::error_flag, .98}}},
      {C::sampling_too_slow,
       {{S::ma_uneven, .5},
        {S::ma_pulse, .3},
        {S::flipped, .2},
        {S::slipped, .2},
        {S::cut_short, .2},
        {S::early, .2},
        {S::half_early, .2},
        {S::silent, .1},
        {S::busy, .2},
        {S::smeared, .2},
        {S::other_ack, .2},
        {S::late_answer, .2},
        {S::delay_changed, .2},
        {S::stuck, .2},
        {S::cut_in_ack, .1},
        {S::slo_pulse, .1}}},
      {C::not_biss,
       {{S::early, .5},
        {S::busy, .1},
        {S::half_early, .2},
        {S::ma_uneven, .3},
        {S::late_answer, .3},
        {S::cut_in_ack, .15},
        {S::flipped, .2},
        {S::slipped, .2},
        {S::silent, .1},
        {S::stuck, .15},
        {S::ma_pulse, .2},
        {S::cut_short, .1},
        {S::tail_high, .1},
        {S::tail_low, .2},
        {S::slo_pulse, .1},
        {S::inverted, .05},
        {S::smeared, .1},
        {S::other_ack, .1}}},
      {C::frames_lost_or_repeated, {{S::life_jump, .95}}},
  };
  return all;
}

class Diagnosis {
 public:
  Diagnosis(const Evidence& evidence, const Context& context)
      : evidence_(evidence), context_(context) {}

  std::vector<Finding> run() {
    gate();
    share_out();
    weigh_whole_capture();
    weigh_good_cycles();
    return findings();
  }

 private:
  double share(std::uint64_t count) const {
    return evidence_.cycles == 0
               ? 0
               : static_cast<double>(count) / static_cast<double>(evidence_.cycles);
  }
  std::uint64_t unusual() const { return evidence_.cycles - evidence_.count(Symptom::none); }
  double period() const {
    return evidence_.period.count() == 0 ? 0 : static_cast<double>(evidence_.period.median());
  }
  double samples_per_period() const {
    const auto step = static_cast<double>(evidence_.resolution.count);
    return step == 0 ? 1e9 : period() / step;
  }

  // Frames that came in time with all their edges in place, and were refused.
  std::uint64_t refused() const {
    using S = Symptom;
    std::uint64_t sum = 0;
    for (const S s : {S::flipped, S::slipped, S::cut_short, S::other_ack, S::cds_high, S::stop_high,
                      S::tail_low, S::tail_high}) {
      sum += evidence_.count(s);
    }
    return sum;
  }

  // Of frames that another format would accept, the share that this one accepts by chance.
  double chance() const {
    return std::min(0.3, 3 * std::pow(2.0, -static_cast<double>(evidence_.crc_bits)) + 0.02);
  }

  double wrong_format_gate() const {
    if (!evidence_.has_format) return 1e-6;
    // Not a matter of bits.
    if (context_.other && context_.other->confidence >= 0.5) return 0.1;
    if (share(evidence_.count(Symptom::early)) > 0.15) return 0.1;
    if (const auto& found = context_.identified; found && found->confidence >= 0.9) {
      return found->format == *context_.format ? 0.01 : 20;
    }
    const double refused_frames = static_cast<double>(refused());
    const double judged = refused_frames + static_cast<double>(evidence_.passed);
    if (refused_frames == 0) return 1e-6;
    const bool nearly_all = refused_frames >= (1 - chance()) * judged;
    const std::uint64_t truncated = evidence_.truncated;
    if (2 * truncated > refused()) {
      if (!nearly_all) return 0.01;
      // The whole frame is there: it ends with a STOP, after a bit that changes.
      if (evidence_.truncated_low != truncated) return 0.02;
      if (evidence_.before_last_changes || evidence_.usual_checksum) return 8;
      return 0.5;
    }
    if (evidence_.count(Symptom::cds_high) * 2 > refused()) return 8;
    if (const std::uint64_t stops = evidence_.count(Symptom::stop_high); stops * 2 > refused()) {
      // Where another channel follows, STOP is its first bit: 1 in many frames, whatever the bit
      // before is.
      const bool many = 10.0 * static_cast<double>(stops) > judged;
      return many && !evidence_.stop_repeats() ? 8 : 0.02;
    }
    if (evidence_.count(Symptom::other_ack) * 2 > refused()) return 4;
    return nearly_all ? 8 : 0.02;
  }

  double not_biss_gate() const {
    if (context_.other && context_.other->confidence >= 0.5) return 20;
    const double good = share(evidence_.good);
    if (good > 0.5 && evidence_.has_format) return 1e-4;
    if (good > 0.1 && evidence_.crc_bits >= 5) return 0.02;
    const double far = share(evidence_.far_delays);
    const double odd = share(evidence_.count(Symptom::early) + evidence_.count(Symptom::ma_uneven) +
                             evidence_.count(Symptom::late_answer));
    // Of one cause most cycles look alike.
    const auto kinds =
        std::count_if(evidence_.symptoms.begin(), evidence_.symptoms.end(),
                      [&](const Sightings& seen) { return share(seen.count) > 0.08; });
    double gate = 0.1;
    if (share(evidence_.answered) < 0.3 || far > 0.15) gate = 1;
    const bool hardly_any = share(evidence_.passed) < 0.05;
    if (odd > 0.1 && hardly_any) gate = 6;
    if (kinds >= 3 && hardly_any) gate = 8;
    return samples_per_period() < coarse_samples ? gate / 10 : gate;
  }

  double sampling_gate() const {
    const double samples = samples_per_period();
    const bool hopeless = 10 * evidence_.good < evidence_.cycles;
    if (hopeless && samples < coarse_samples + 2) return 20;
    if (samples > coarse_samples + 1) return samples < 14 && hopeless ? 2 : 1e-4;
    return samples < coarse_samples ? 20 : 1;
  }

  // How plausible each cause is by what is seen in the whole capture.
  void gate() {
    gates_.fill(1);
    at(gates_, Cause::healthy) = 0;
    at(gates_, Cause::ma_slo_swapped) = 0;
    at(gates_, Cause::wrong_format) = wrong_format_gate();
    at(gates_, Cause::not_biss) = not_biss_gate();
    at(gates_, Cause::sampling_too_slow) = sampling_gate();
    // An encoder that answers at times is there.
    const bool silent =
        evidence_.answered == 0 && 10 * evidence_.count(Symptom::silent) >= 9 * evidence_.cycles;
    at(gates_, Cause::no_encoder) = silent ? 4 : 0.001;
    if (evidence_.answered != 0 && evidence_.count(Symptom::stuck) < evidence_.cycles / 50) {
      at(gates_, Cause::stuck_low) = 0.3;
    }
    if (evidence_.count(Symptom::silent) + evidence_.count(Symptom::late_answer) == 0) {
      at(gates_, Cause::supply_or_intermittent) = 0.2;
    }
    // SLO may be low because the encoder had too little time, or for good.
    if (const auto& rest = evidence_.rest_of_bad; rest.count() != 0) {
      const bool hurried = rest.median() < timeout().count;
      at(gates_, Cause::requested_too_soon) = hurried ? 3 : 0.5;
    }
    // Of an encoder that sees MA inverted, SLO is early, or it misses the last clock.
    if (evidence_.count(Symptom::stop_high) != 0 && evidence_.count(Symptom::half_early) == 0 &&
        !evidence_.stop_repeats()) {
      at(gates_, Cause::ma_inverted) = 0.02;
    }
    at(gates_, Cause::noise_on_ma) = evidence_.pulses_on_ma == 0 ? 0.9 : 1;
    // Bits that are wrong beside pulses on MA come from these.
    if (evidence_.count(Symptom::ma_pulse) >= 3) at(gates_, Cause::noise_on_slo) = 0.15;
    if (evidence_.passed == 0) {
      // Noise that leaves no frame good is rare.
      at(gates_, Cause::noise_on_slo) *= 0.2;
      at(gates_, Cause::noise_on_ma) *= 0.3;
    }
    gate_truncation();
  }

  // By the encoder's rule, or as measured.
  Picoseconds timeout() const {
    if (evidence_.release.count() >= 3) return Picoseconds{evidence_.release.min() * 19 / 20};
    const Timeout& rule = context_.timing.timeout;
    const Picoseconds period{evidence_.period.count() == 0 ? 0 : evidence_.period.median()};
    if (rule.rule == TimeoutRule::fixed) return rule.time;
    return period * 3 / 2;
  }

  // No good cycle shows how long ACK is and how many clocks the master sends.
  void gate_truncation() {
    if (evidence_.ack_clocks.count() != 0 || evidence_.truncated == 0) return;
    const auto& ack = evidence_.truncated_ack_clocks;
    const bool varies = ack.count() != 0 && ack.max() > ack.min() + 1;
    if (varies && evidence_.count(Symptom::early) == 0)
      at(gates_, Cause::ack_longer_than_master_waits) = 8;
  }

  // Which cause explains which share of the unusual cycles: the most likely mixture.
  void share_out() {
    const auto& table = cause_shares();
    Weights mixture{};
    for (const CauseShares& row : table) at(mixture, row.cause) = 1.0 / cause_count;
    Weights first{};
    for (int round = 0; round < 60; ++round) {
      Weights next{};
      double total = 0;
      for (std::size_t s = 1; s < symptom_count; ++s) {
        const auto count = static_cast<double>(evidence_.symptoms[s].count);
        if (count == 0) continue;
        Weights parts{};
        double sum = 0;
        for (const CauseShares& row : table) {
          double p = elsewhere;
          for (const Share& each : row.shares) {
            if (static_cast<std::size_t>(each.symptom) == s) p = each.share;
          }
          sum += at(parts, row.cause) = at(mixture, row.cause) * at(gates_, row.cause) * p;
        }
        if (sum <= 0) continue;
        for (std::size_t c = 0; c < cause_count; ++c) next[c] += count * parts[c] / sum;
        total += count;
      }
      if (total == 0) return;
      for (double& weight : next) weight /= total;
      if (round == 0) first = next;
      mixture = next;
    }
    for (std::size_t c = 0; c < cause_count; ++c) {
      weights_[c] = 0.85 * mixture[c] + 0.15 * first[c];
    }
  }

  // Lines that had to be exchanged or inverted: what is left is the smaller problem.
  void weigh_whole_capture() {
    if (evidence_.cycles == 0) {
      at(weights_, context_.reading.swapped ? Cause::ma_slo_swapped : Cause::not_biss) += 1;
      return;
    }
    const auto put_first = [this](Cause cause) {
      for (double& weight : weights_) weight *= 0.3;
      at(weights_, cause) += 1;
    };
    if (context_.reading.swapped) put_first(Cause::ma_slo_swapped);
    // What reads hardly better that way says nothing.
    const bool reads = 2 * evidence_.answered > evidence_.cycles;
    if (context_.reading.slo_inverted && reads) put_first(Cause::slo_inverted);
    if (context_.reading.ma_inverted && reads) put_first(Cause::ma_inverted);
    // Pairs exchanged at the connector: both inputs are open.
    if (at(weights_, Cause::no_encoder) > 0.5) at(weights_, Cause::ma_slo_swapped) += 0.08;
  }

  // What good cycles say: nothing is wrong, or the clock is at its limit.
  void weigh_good_cycles() {
    const bool found =
        context_.reading.swapped || context_.reading.slo_inverted || context_.reading.ma_inverted;
    const std::uint64_t bad = unusual();
    double left = 0;
    if (evidence_.good != 0 && !found) {
      left = bad == 0 ? 1 : bad <= 2 && 20 * bad <= evidence_.cycles ? 0.4 : 0.01;
    }
    const double fast = too_fast();
    if (bad == 0) {
      at(weights_, Cause::clock_too_fast_for_cable) += left * fast;
      at(weights_, Cause::healthy) += left * (1 - fast);
    } else {
      at(weights_, Cause::healthy) += left;
      at(weights_, Cause::clock_too_fast_for_cable) += 0.05 * fast;
    }
  }

  // How likely it is that the clock is too fast, by the line delay alone.
  double too_fast() const {
    if (evidence_.line_delay.count() == 0 || period() <= 0) return 0;
    const auto delay = static_cast<double>(evidence_.line_delay.median());
    const double periods = delay / period();
    double likely = periods > 0.25 ? 0.1 : 0.0;
    const Picoseconds cycle_period{evidence_.period.median()};
    const auto longest = cable_max_compensated(rate_of(cycle_period));
    const Picoseconds inside = context_.timing.internal_delay_max;
    const Picoseconds seen{evidence_.line_delay.median()};
    // A line delay is measured to a sample, a good part of the period at most.
    if (longest && seen > line_delay(*longest, inside) * 11 / 10 + cycle_period / 4) likely = 0.7;
    const double place = periods - std::floor(periods);
    const double margin = std::abs(place - 0.5);
    // A master that compensates nothing sees START as many clocks late and sends as many more.
    const auto late = static_cast<std::int64_t>(std::floor(periods + 0.5));
    const bool sends_more =
        late >= 1 && evidence_.extra_clocks.count() != 0 && evidence_.extra_clocks.median() == late;
    if (sends_more) likely = std::max(likely, margin < 0.25 ? 0.8 : 0.45);
    if (context_.compensated == false && (margin < 0.25 || periods > 0.25)) likely = 0.9;
    return likely;
  }

  std::vector<Finding> findings() const {
    double sum = 0;
    for (const double weight : weights_) sum += weight;
    std::vector<Finding> all;
    for (std::size_t c = 0; c < cause_count; ++c) {
      const auto cause = static_cast<Cause>(c);
      // Nothing is certain.
      double likelihood = sum <= 0 ? 0 : 0.98 * weights_[c] / sum;
      if (cause == Cause::healthy && !evidence_.has_format) {
        likelihood = std::min(likelihood, healthy_without_format);
      }
      if (likelihood < least_likelihood) continue;
      all.push_back({cause, likelihood});
    }
    std::stable_sort(all.begin(), all.end(), [](const Finding& a, const Finding& b) {
      return a.likelihood > b.likelihood;
    });
    return all;
  }

  const Evidence& evidence_;
  const Context& context_;
  Weights gates_{};
  Weights weights_{};
};

}  // namespace

std::vector<Symptom> symptoms_of(Cause cause) {
  std::vector<Symptom> symptoms;
  for (const CauseShares& row : cause_shares()) {
    if (row.cause != cause) continue;
    for (const Share& each : row.shares) symptoms.push_back(each.symptom);
  }
  return symptoms;
}

std::vector<Finding> diagnose(const Evidence& evidence, const Context& context) {
  return Diagnosis(evidence, context).run();
}

}  // namespace biss::explain
