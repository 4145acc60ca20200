#include "explain/diagnose.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "biss/timing/cable.hpp"

namespace biss::explain {

namespace {

using Bits = std::array<double, cause_count>;

double& at(Bits& bits, Cause cause) { return bits[static_cast<std::size_t>(cause)]; }

// A kind that a cause predicts, and its additional cost there.
struct Part {
  Part(RequestKind predicted = {}, double more = 0) : kind(predicted), extra(more) {}

  RequestKind kind;
  double extra;
};
struct Model {
  Cause cause{};
  std::vector<Part> parts;
};

// In bits: the price of naming a cause, of a request that it does not predict, and of missing the
// requests that it predicts; and the number that a second cause must save.
constexpr double cause_price = 6;
constexpr double not_predicted = 14;
constexpr double not_seen = 60;
constexpr double second_saves = 20;
constexpr double never = 1e6;
constexpr int rounds = 8;

// The second of two causes counts as this much longer, so that the likelihood of the first one
// matches how often it is right.
constexpr double apart = 3.5;
// A cause that would explain some requests, but not many, counts as this much longer.
constexpr double also_apart = 12;
// A cause whose account is `b` bits longer than the shortest one weighs (1 + b /
// weight_scale)^-weight_power: rounded from the output of tests/explain/fit.py for development
// seeds.
constexpr double weight_scale = 1.2;
constexpr double weight_power = 1.5;
// Less likely causes are not listed.
constexpr double least_likelihood = 0.015;
// Without a format no checksum is judged: damaged frames look like good ones.
constexpr double healthy_without_format = 0.5;
// With fewer samples in a period of MA, edges are in doubt.
constexpr double coarse_samples = 5;

const std::vector<Model>& models() {
  using enum Cause;
  using enum RequestKind;
  static const std::vector<Model> all{
      {healthy, {}},
      {wrong_format, {refused, stop_high, cds_high, other_ack, {ones, 6}, {zeros, 6}}},
      {wrong_checksum, {other_checksum}},
      {format_changes, {other_length}},
      {ma_slo_swapped, {silent}},
      // A master that reads SLO inverted sends requests while the encoder is busy.
      {slo_inverted, {inverted, busy, hurried, stuck}},
      {ma_inverted, {half_early, stop_repeats}},
      {clock_too_fast_for_cable, {smeared, delay_part, flip, slo_pulse}},
      {ack_longer_than_master_waits, {cut_in_ack, cut_late}},
      {master_stops_early, {cut_in_data, {cut_in_ack, 3}}},
      {master_pauses_clock, {paused, restart}},
      {requested_too_soon, {hurried}},
      {noise_on_slo, {flip, slo_pulse, {smeared, 3}}},
      {noise_on_ma, {ma_pulse, slip, {delay_clocks, 2}, {literal, 2}, {ma_held, 2}}},
      {supply_or_intermittent, {silent, ones, delay_clocks, ma_held}},
      {no_encoder, {silent}},
      {stuck_low, {stuck, zeros, {cut_in_ack, 4}, busy}},
      {encoder_error, {error_flag}},
      {frames_lost_or_repeated, {life_jump}},
      {position_implausible, {implausible}},
      {limits_exceeded, {other_ack}},
      {sampling_too_slow,
       {literal, flip, slip, smeared, delay_part, silent, busy, cut_in_data, cut_in_ack, refused,
        other_length, delay_clocks, hurried, half_early, slo_pulse, ma_pulse}},
      {not_biss, {foreign, literal}},
  };
  return all;
}

class Diagnosis {
  using enum Cause;
  using enum RequestKind;

 public:
  Diagnosis(const Evidence& evidence, const Context& context)
      : evidence_(evidence), context_(context) {}

  std::vector<Finding> run() {
    if (evidence_.cycles == 0) {
      // A line at rest shows nothing.
      if (context_.reading.swapped) return {{ma_slo_swapped, 0.98}};
      if (context_.other) return {{not_biss, 0.98}};
      return {};
    }
    if (evidence_.rows.empty()) return {};
    note();
    Bits bits{};
    for (const Model& model : models()) {
      std::vector<Part> parts = model.parts;
      // Requests while the encoder is busy are due to inversion only if SLO was read inverted.
      if (model.cause == slo_inverted && !context_.reading.slo_inverted) parts.resize(1);
      // By the format that the frames show, the checksum is right.
      if (model.cause == wrong_format && shows_other_format()) parts.push_back(other_checksum);
      at(bits, model.cause) = note_on(model.cause) + length(parts);
    }
    // The parts of a request, and frames of two formats, show nothing else.
    const auto only = [&](Cause cause) {
      at(bits, cause) = *std::min_element(bits.begin(), bits.end()) - 30;
      return findings(bits);
    };
    if (evidence_.usual.rest_in_group && !other_is_clear()) return only(master_pauses_clock);
    if (!context_.format_parts.empty()) return only(format_changes);
    if (is_other_protocol()) {
      at(bits, not_biss) =
          *std::min_element(bits.begin(), bits.end()) - 30 * context_.other->confidence;
    } else if (context_.other && !(evidence_.has_format ? passes() : has_checksum())) {
      list_second(not_biss, bits);
    }
    const auto best = std::min_element(bits.begin(), bits.end());
    const auto first = static_cast<Cause>(best - bits.begin());
    add_second(first, bits);
    return findings(bits);
  }

 private:
  // The bits of all requests under these kinds, with the shares that fit best.
  double length(const std::vector<Part>& parts) const {
    std::vector<std::pair<std::size_t, double>> kinds{
        {static_cast<std::size_t>(ok), 1},
        {static_cast<std::size_t>(short_frame), 1},
        {static_cast<std::size_t>(literal), std::exp2(-not_predicted)}};
    for (const Part& part : parts) {
      const auto kind = static_cast<std::size_t>(part.kind);
      const auto known = std::find_if(kinds.begin(), kinds.end(),
                                      [kind](const auto& each) { return each.first == kind; });
      const double factor = std::exp2(-part.extra);
      known == kinds.end() ? kinds.emplace_back(kind, factor).second
                           : known->second = std::max(known->second, factor);
    }
    std::vector<double> weights(kinds.size(), 1.0 / static_cast<double>(kinds.size()));
    double sum = 0;
    for (int round = 0; round <= rounds; ++round) {
      std::vector<double> next(kinds.size(), 0.25);
      sum = 0;
      for (const Row& row : evidence_.rows) {
        double all = 0;
        std::array<double, kind_count> shares{};
        for (std::size_t i = 0; i < kinds.size(); ++i) {
          shares[i] =
              weights[i] * kinds[i].second * static_cast<double>(row.likely[kinds[i].first]);
          all += shares[i];
        }
        constexpr double least = 1e-40;
        sum -= row.count * std::log2(std::max(all, least));
        if (all < least) continue;
        for (std::size_t i = 0; i < kinds.size(); ++i) next[i] += row.count * shares[i] / all;
      }
      double total = 0;
      for (const double weight : next) total += weight;
      for (std::size_t i = 0; i < kinds.size(); ++i) weights[i] = next[i] / total;
    }
    const double price = 0.5 * std::log2(static_cast<double>(evidence_.cycles) + 1);
    const auto used = std::count_if(parts.begin(), parts.end(), [this](const Part& part) {
      return evidence_.count(part.kind) != 0;
    });
    return sum + price * static_cast<double>(std::max<std::ptrdiff_t>(used, 1));
  }

  static void list_second(Cause cause, Bits& bits) {
    at(bits, cause) =
        std::min(at(bits, cause), *std::min_element(bits.begin(), bits.end()) + apart);
  }

  std::uint64_t explained(const Model& model) const {
    std::uint64_t sum = 0;
    for (const Part& part : model.parts) sum += evidence_.count(part.kind);
    return sum;
  }

  // A second cause, if it explains some requests that the first one does not.
  void add_second(Cause first, Bits& bits) const {
    if (first == not_biss) return;
    // If the master cuts frames, no checksum proves their bits, so two of them must show the error.
    const bool cut = first == master_stops_early || first == ack_longer_than_master_waits;
    if (cut && evidence_.cut_errors.count >= 2) list_second(encoder_error, bits);
    if (4 * evidence_.good < evidence_.cycles && !evidence_.usual.checksum) return;
    const Model& model = models()[static_cast<std::size_t>(first)];
    const double alone = at(bits, first);
    std::vector<std::pair<double, const Model*>> seconds;
    for (const Model& other : models()) {
      if (other.cause == first || other.cause == not_biss || other.parts.empty()) continue;
      if (explained(other) < 2 && demanded_[static_cast<std::size_t>(other.cause)] <= 0) continue;
      std::vector<Part> both = model.parts;
      both.insert(both.end(), other.parts.begin(), other.parts.end());
      const double together = note_on(first) + note_on(other.cause) - all_demanded_ + length(both);
      if (together < alone) seconds.emplace_back(together, &other);
    }
    if (seconds.empty()) return;
    std::sort(seconds.begin(), seconds.end());
    const auto [together, second] = seconds.front();
    const bool saves = together < alone - second_saves;
    const double best = saves ? together : alone;
    // Causes that would explain requests as well.
    for (const auto& each : seconds) {
      double& length_of_other = at(bits, each.second->cause);
      length_of_other = std::min(length_of_other, best + also_apart);
    }
    if (!saves) return;
    // The cause that explains more requests comes first.
    const bool more = explained(*second) > explained(model);
    at(bits, first) = best + (more ? apart : 0);
    at(bits, second->cause) = best + (more ? 0 : apart);
  }

  double period() const {
    return evidence_.period.count() == 0 ? 0 : static_cast<double>(evidence_.period.median());
  }
  double samples_per_period() const {
    const auto step = static_cast<double>(evidence_.resolution.count);
    return step == 0 ? 1e9 : period() / step;
  }
  double share(std::uint64_t count) const {
    return evidence_.cycles == 0
               ? 0
               : static_cast<double>(count) / static_cast<double>(evidence_.cycles);
  }
  // The capture shows this cause: leaving it out costs this much.
  void demand(Cause cause, double price) {
    at(demanded_, cause) += price;
    all_demanded_ += price;
  }
  // The cost of an account with this cause alone, without its requests.
  double note_on(Cause cause) const {
    const auto c = static_cast<std::size_t>(cause);
    return notes_[c] + all_demanded_ - demanded_[c];
  }

  // The whole capture shows this cause, if no request does.
  void accept(Cause cause) {
    if (std::exchange(unseen_[static_cast<std::size_t>(cause)], false)) {
      at(notes_, cause) -= not_seen;
    }
  }

  // Evidence of the whole capture for and against each cause.
  void note() {
    notes_.fill(cause_price);
    for (const Model& model : models()) {
      const bool seen =
          std::any_of(model.parts.begin(), model.parts.end(),
                      [this](const Part& part) { return evidence_.count(part.kind) != 0; });
      unseen_[static_cast<std::size_t>(model.cause)] = !seen;
      if (!seen) at(notes_, model.cause) += not_seen;
    }
    at(notes_, healthy) = 0;
    note_format();
    note_lines();
    note_delay();
    note_sampling();
    if (evidence_.limits.empty()) {
      at(notes_, limits_exceeded) += never;
    } else {
      demand(limits_exceeded, 30);
      accept(limits_exceeded);
      at(notes_, limits_exceeded) -= cause_price;
    }
    if (evidence_.life_zeros != 0) {
      accept(frames_lost_or_repeated);
    } else if (evidence_.count(life_jump) == 0) {
      at(notes_, frames_lost_or_repeated) += never;
    }
    if (share(evidence_.answered) > 0.02) at(notes_, no_encoder) += 20;
    if (share(evidence_.good) < 0.05) {
      at(notes_, supply_or_intermittent) += 12;
      at(notes_, noise_on_slo) += 15;
      at(notes_, noise_on_ma) += 60;
      at(notes_, requested_too_soon) += 40;
    }
    note_slips();
    const bool of_cable = is_smeared();
    if (evidence_.count(flip) + evidence_.count(slo_pulse) != 0) {
      at(notes_, of_cable ? noise_on_slo : clock_too_fast_for_cable) += of_cable ? 25 : 80;
    }
    // A capture is BiSS C if its frames pass, if it is coarse or its format is identified, or if a
    // master with SPI gets a few answers.
    const bool coarse = samples_per_period() < coarse_samples;
    const bool shows_frames = (coarse || context_.identified) && !other_is_clear();
    const bool may_be_spi = other_is_weak() && share(evidence_.answered) > 0.1;
    const bool is_biss = passes() || share(evidence_.answered) > 0.6 || shows_frames || may_be_spi;
    at(notes_, not_biss) += is_biss ? never : answers() ? 60 : 20;
  }

  // Many smeared edges come from the cable.
  bool is_smeared() const { return share(evidence_.count(smeared)) > 0.15; }

  // An encoder that counted a clock too many sends STOP in place of the last bit; an encoder that
  // missed a clock sends the last bit in place of STOP.
  void note_slips() {
    const std::uint64_t failed = evidence_.failed_checks;
    if (failed < 5) return;
    const bool slips =
        100 * evidence_.last_bit_low >= 85 * failed || 100 * evidence_.stops_high >= 15 * failed;
    const double price = 6 * static_cast<double>(failed);
    at(notes_, slips ? noise_on_slo : noise_on_ma) += price;
    if (slips) at(notes_, clock_too_fast_for_cable) += price;
  }

  // A wrong format, or a wrong checksum, lets frames pass by chance only.
  void note_format() {
    const double passed = static_cast<double>(evidence_.passed) /
                          static_cast<double>(std::max<std::uint64_t>(evidence_.answered, 1));
    if (!context_.given || !context_.format) at(notes_, wrong_format) += never;
    if (passed > 0.08) at(notes_, wrong_format) += 30;
    const bool passes_none = passed <= 0.08;
    if (const auto& found = context_.identified; found && context_.given && context_.format) {
      if (found->format == *context_.format) {
        at(notes_, wrong_format) += 25;
      } else if (passes_none && !differs_in_maker_error(found->format)) {
        demand(wrong_format, 60);
        // The checksum is right, in another place or by another rule of BiSS C.
        if (!found->format.deviates()) at(notes_, wrong_checksum) += never;
      }
    } else if (evidence_.usual.no_checksum_fits && has_checksum()) {
      at(notes_, wrong_format) -= 12;
    }
    // A frame of a different length has STOP; one that the master cuts ends with a bit of either
    // level.
    const auto other = static_cast<double>(evidence_.count(other_length));
    const auto high = static_cast<double>(evidence_.truncated - evidence_.truncated_low);
    if (other == 0) at(notes_, format_changes) += never;
    if (10 * high > other) at(notes_, format_changes) += 4 * high;
    if (passes_none && context_.given) {
      at(notes_, format_changes) += never;
      // Noise that spoils nearly all checksums spoils ACK, START and STOP as well.
      if (share(evidence_.answered) > 0.9) {
        const double price = 60 + 4 * static_cast<double>(evidence_.failed_checks);
        at(notes_, noise_on_slo) += price;
        at(notes_, noise_on_ma) += price;
        if (!is_smeared()) at(notes_, clock_too_fast_for_cable) += price;
      }
    }
  }

  // The frames certainly have another format than the given one, and its checksum is one of BiSS C.
  bool shows_other_format() const {
    const auto& found = context_.identified;
    return found && context_.given && context_.format && found->format != *context_.format &&
           !found->format.deviates() && !differs_in_maker_error(found->format);
  }

  // The likeliest format that the frames show, even if it is not certain, has a checksum.
  bool has_checksum() const {
    return !context_.candidates.empty() &&
           context_.candidates.front().channel_list[0].crc.present();
  }

  // The fields are the same as in the format, and the checksum is a usual one with a mistake.
  bool differs_in_maker_error(const FrameFormat& found) const {
    if (found.channel_count != 1 || context_.format->channel_count != 1) return false;
    FrameFormat same = found;
    CrcSpec& crc = same.channel_list[0].crc;
    const CrcSpec& given = context_.format->channel_list[0].crc;
    if (crc.width_bits != given.width_bits || !given.inverted || given.start != 0) return false;
    crc = given;
    return same == *context_.format;
  }

  void note_lines() {
    const Reading& reading = context_.reading;
    const auto judge = [&](Cause cause, bool changed) {
      if (!changed) return;
      demand(cause, 30);
      accept(cause);
    };
    judge(ma_slo_swapped, reading.swapped);
    judge(slo_inverted, reading.slo_inverted);
    judge(ma_inverted, reading.ma_inverted);
    // Pairs that are exchanged at the connector: both inputs are open.
    const bool open = share(evidence_.answered) < 0.02;
    if (!reading.swapped) at(notes_, ma_slo_swapped) += open ? 6 : never;
    if (!reading.slo_inverted && evidence_.count(inverted) == 0) {
      at(notes_, slo_inverted) += never;
    }
    const std::uint64_t half = evidence_.count(half_early) + evidence_.count(stop_repeats);
    // Without a format, only that each request ends with the same bit twice shows that it has no STOP.
    const auto& last = evidence_.last_bits;
    const std::uint64_t twice = std::min(last[0], last[3]);
    const bool judged = evidence_.has_format && !context_.assumed;
    const bool no_stop = judged || (has_checksum() && 6 * twice > evidence_.answered &&
                                    20 * (last[1] + last[2]) < evidence_.answered);
    if (!reading.ma_inverted && (half == 0 || !no_stop)) {
      at(notes_, ma_inverted) += no_stop ? 30 : never;
    }
  }

  void note_delay() {
    if (evidence_.line_delay.count() == 0 || period() <= 0) return;
    const Picoseconds delay{evidence_.line_delay.median()};
    const Picoseconds clock{evidence_.period.median()};
    const auto longest = cable_max_compensated(rate_of(clock));
    // A line delay is accurate to one sample, at most a large part of the period.
    const bool too_long =
        longest &&
        delay > line_delay(*longest, context_.timing.internal_delay_max) * 11 / 10 + clock / 4;
    // A master that compensates nothing samples well for short delays only.
    const bool late = context_.compensated == false && 4 * delay > clock;
    if (!too_long && !late) return;
    demand(clock_too_fast_for_cable, late ? 25 : 20);
    accept(clock_too_fast_for_cable);
  }

  void note_sampling() {
    const double samples = samples_per_period();
    if (samples < coarse_samples) {
      demand(sampling_too_slow, 15 + 2 * static_cast<double>(evidence_.cycles));
    } else {
      at(notes_, sampling_too_slow) += samples < coarse_samples + 0.5 ? 40 : never;
    }
  }

  // Frames pass by their format. Another protocol may have ACK and START by chance, but no checksum.
  bool other_is_clear() const { return context_.other && context_.other->confidence > 0.9; }
  bool passes() const {
    return evidence_.has_format && share(evidence_.passed) > (other_is_clear() ? 0.6 : 0.2);
  }
  bool answers() const { return share(evidence_.answered) > 0.4; }

  // A master that reads BiSS C over SPI has no select line either.
  bool other_is_weak() const {
    return context_.other &&
           context_.other->confidence < (context_.other->name == "spi" ? 0.85 : 0.5);
  }

  // Another protocol that is recognised outweighs all causes, unless most requests have ACK and START.
  bool is_other_protocol() const {
    if (!context_.other || other_is_weak() || passes()) return false;
    return !answers() || context_.other->confidence > 0.85;
  }

  // Bits become likelihoods by a fitted table.
  std::vector<Finding> findings(const Bits& bits) const {
    const double least = *std::min_element(bits.begin(), bits.end());
    Bits weights{};
    double sum = 0;
    for (std::size_t c = 0; c < cause_count; ++c) {
      const double more = bits[c] - least;
      weights[c] = std::pow(1 + more / weight_scale, -weight_power);
      sum += weights[c];
    }
    std::vector<Finding> all;
    for (std::size_t c = 0; c < cause_count; ++c) {
      const auto cause = static_cast<Cause>(c);
      // Nothing is certain.
      double likelihood = 0.98 * weights[c] / sum;
      if (cause == healthy && (!evidence_.has_format || context_.assumed)) {
        likelihood = std::min(likelihood, healthy_without_format);
      }
      if (likelihood >= least_likelihood) all.push_back({cause, likelihood, bits[c] - least});
    }
    std::stable_sort(all.begin(), all.end(), [](const Finding& a, const Finding& b) {
      return a.likelihood > b.likelihood;
    });
    return all;
  }

  const Evidence& evidence_;
  const Context& context_;
  Bits notes_{};
  Bits demanded_{};
  double all_demanded_ = 0;
  std::array<bool, cause_count> unseen_{};
};

}  // namespace

std::vector<RequestKind> kinds_of(Cause cause) {
  std::vector<RequestKind> kinds;
  for (const Part& part : models()[static_cast<std::size_t>(cause)].parts) {
    kinds.push_back(part.kind);
  }
  return kinds;
}

std::vector<Finding> diagnose(const Evidence& evidence, const Context& context) {
  return Diagnosis(evidence, context).run();
}

}  // namespace biss::explain
