#include "explain/diagnose.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "biss/timing/cable.hpp"
#include "explain/fitted.hpp"

namespace biss::explain {

namespace {

using Bits = std::array<double, cause_count>;

double& at(Bits& bits, Cause cause) { return bits[static_cast<std::size_t>(cause)]; }

// A kind that a cause predicts, and what it costs more than its price there.
struct Part {
  RequestKind kind{};
  double extra = 0;
};
struct Model {
  Cause cause{};
  std::vector<Part> parts;
};

// In bits: a cause that is named; a request that no part of it predicts; no request is what it
// predicts; a second cause must save as many.
constexpr double cause_price = 6;
constexpr double not_predicted = 14;
constexpr double not_seen = 60;
constexpr double second_saves = 20;
constexpr double never = 1e6;
constexpr int rounds = 8;

// The second of two causes counts as this much longer: then the first one is stated to be as likely
// as it is right.
constexpr double apart = 3.5;
// A cause that would explain some requests, but not many, counts as this much longer.
constexpr double also_apart = 12;

// What is less likely is not listed.
constexpr double least_likelihood = 0.015;
// Without a format no checksum is judged: damaged frames look like good ones.
constexpr double healthy_without_format = 0.5;
// With fewer samples in a period of MA, edges are in doubt.
constexpr double coarse_samples = 5;

const std::vector<Model>& models() {
  using C = Cause;
  using K = RequestKind;
  static const std::vector<Model> all{
      {C::healthy, {}},
      {C::wrong_format,
       {{K::refused}, {K::stop_high}, {K::cds_high}, {K::other_ack}, {K::ones, 6}, {K::zeros, 6}}},
      {C::wrong_checksum, {{K::other_checksum}}},
      {C::format_changes, {{K::other_length}}},
      {C::ma_slo_swapped, {{K::silent}}},
      // A master that takes SLO for inverted asks while the encoder is busy.
      {C::slo_inverted, {{K::inverted}, {K::busy}, {K::hurried}, {K::stuck}}},
      {C::ma_inverted, {{K::half_early}, {K::stop_repeats}}},
      {C::clock_too_fast_for_cable, {{K::smeared}, {K::delay_part}, {K::flip}, {K::slo_pulse}}},
      {C::ack_longer_than_master_waits, {{K::cut_in_ack}, {K::cut_late}}},
      {C::master_stops_early, {{K::cut_in_data}, {K::cut_in_ack, 3}}},
      {C::master_pauses_clock, {{K::paused}, {K::restart}}},
      {C::requested_too_soon, {{K::hurried}}},
      {C::noise_on_slo, {{K::flip}, {K::slo_pulse}, {K::smeared, 3}}},
      {C::noise_on_ma,
       {{K::ma_pulse}, {K::slip}, {K::delay_clocks, 2}, {K::literal, 2}, {K::ma_held, 2}}},
      {C::supply_or_intermittent, {{K::silent}, {K::ones}, {K::delay_clocks}, {K::ma_held}}},
      {C::no_encoder, {{K::silent}}},
      {C::stuck_low, {{K::stuck}, {K::zeros}, {K::cut_in_ack, 4}, {K::busy}}},
      {C::encoder_error, {{K::error_flag}}},
      {C::frames_lost_or_repeated, {{K::life_jump}}},
      {C::position_implausible, {{K::implausible}}},
      {C::limits_exceeded, {{K::other_ack}}},
      {C::sampling_too_slow,
       {{K::literal},
        {K::flip},
        {K::slip},
        {K::smeared},
        {K::delay_part},
        {K::silent},
        {K::busy},
        {K::cut_in_data},
        {K::cut_in_ack},
        {K::refused},
        {K::other_length},
        {K::delay_clocks},
        {K::hurried},
        {K::half_early},
        {K::slo_pulse},
        {K::ma_pulse}}},
      {C::not_biss, {{K::foreign}, {K::literal}}},
  };
  return all;
}

class Diagnosis {
 public:
  Diagnosis(const Evidence& evidence, const Context& context)
      : evidence_(evidence), context_(context) {}

  std::vector<Finding> run() {
    if (evidence_.cycles == 0) {
      // A line at rest shows nothing.
      if (context_.reading.swapped) return {{Cause::ma_slo_swapped, 0.98}};
      if (context_.other) return {{Cause::not_biss, 0.98}};
      return {};
    }
    if (evidence_.rows.empty()) return {};
    note();
    Bits bits{};
    for (const Model& model : models()) {
      std::vector<Part> parts = model.parts;
      // Only where SLO is read inverted is it the master who asks while the encoder is busy.
      if (model.cause == Cause::slo_inverted && !context_.reading.slo_inverted) parts.resize(1);
      // By the format that the frames show, the checksum is right.
      if (model.cause == Cause::wrong_format && shows_other_format()) {
        parts.push_back({RequestKind::other_checksum});
      }
      at(bits, model.cause) = note_on(model.cause) + length(parts);
    }
    // The parts of a request, and frames of two formats, show nothing else.
    const auto only = [&](Cause cause) {
      at(bits, cause) = *std::min_element(bits.begin(), bits.end()) - 30;
      return findings(bits);
    };
    if (evidence_.usual.rest_in_group && !other_is_clear()) return only(Cause::master_pauses_clock);
    if (!context_.format_parts.empty()) return only(Cause::format_changes);
    if (is_other_protocol()) {
      at(bits, Cause::not_biss) =
          *std::min_element(bits.begin(), bits.end()) - 30 * context_.other->confidence;
    }
    const double least = *std::min_element(bits.begin(), bits.end());
    // Another protocol may have ACK and START by chance, but no checksum.
    const bool proven = evidence_.has_format ? share(evidence_.passed) > 0.02 : has_checksum();
    if (context_.other && !proven) {
      at(bits, Cause::not_biss) = std::min(at(bits, Cause::not_biss), least + apart);
    }
    const auto best = std::min_element(bits.begin(), bits.end());
    const auto first = static_cast<Cause>(best - bits.begin());
    add_second(first, bits);
    return findings(bits);
  }

 private:
  // The bits of all requests under these kinds, whose shares are those that fit best.
  double length(const std::vector<Part>& parts) const {
    std::vector<std::pair<std::size_t, double>> kinds{
        {static_cast<std::size_t>(RequestKind::ok), 1},
        {static_cast<std::size_t>(RequestKind::short_frame), 1},
        {static_cast<std::size_t>(RequestKind::literal), std::exp2(-not_predicted)}};
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

  // A second cause, if it explains some requests that the first one does not.
  void add_second(Cause first, Bits& bits) const {
    if (first == Cause::not_biss) return;
    // What frames say that the master cuts, no checksum proves.
    const bool cut =
        first == Cause::master_stops_early || first == Cause::ack_longer_than_master_waits;
    if (cut && evidence_.cut_errors.count >= 2) {
      double& error = at(bits, Cause::encoder_error);
      error = std::min(error, at(bits, first) + apart);
    }
    if (4 * evidence_.good < evidence_.cycles && !evidence_.usual.checksum) return;
    const Model& model = models()[static_cast<std::size_t>(first)];
    const double alone = at(bits, first);
    std::vector<std::pair<double, const Model*>> seconds;
    for (const Model& other : models()) {
      if (other.cause == first || other.cause == Cause::not_biss || other.parts.empty()) continue;
      std::uint64_t explained = 0;
      for (const Part& part : other.parts) explained += evidence_.count(part.kind);
      if (explained < 2 && demanded_[static_cast<std::size_t>(other.cause)] <= 0) continue;
      std::vector<Part> both = model.parts;
      both.insert(both.end(), other.parts.begin(), other.parts.end());
      const double together = note_on(first) + note_on(other.cause) - all_demanded_ + length(both);
      if (together < alone) seconds.emplace_back(together, &other);
    }
    if (seconds.empty()) return;
    std::sort(seconds.begin(), seconds.end());
    double best = alone;
    const Model* second = nullptr;
    if (seconds.front().first < alone - second_saves) std::tie(best, second) = seconds.front();
    // Causes that would explain requests as well.
    for (const auto& [together, other] : seconds) {
      if (other == second) continue;
      at(bits, other->cause) = std::min(at(bits, other->cause), best + also_apart);
    }
    if (second == nullptr) return;
    // The one that explains more requests comes first.
    const auto explained = [this](const Model& of) {
      std::uint64_t sum = 0;
      for (const Part& part : of.parts) sum += evidence_.count(part.kind);
      return sum;
    };
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
  // The capture shows this cause: to leave it out costs so much.
  void demand(Cause cause, double price) {
    at(demanded_, cause) += price;
    all_demanded_ += price;
  }
  // What an account with this cause alone costs besides its requests.
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

  // What the whole capture says for a cause and against it.
  void note() {
    notes_.fill(cause_price);
    for (const Model& model : models()) {
      const bool seen =
          std::any_of(model.parts.begin(), model.parts.end(),
                      [this](const Part& part) { return evidence_.count(part.kind) != 0; });
      unseen_[static_cast<std::size_t>(model.cause)] = !seen;
      if (!seen) at(notes_, model.cause) += not_seen;
    }
    at(notes_, Cause::healthy) = 0;
    note_format();
    note_lines();
    note_delay();
    note_sampling();
    if (evidence_.limits.empty()) {
      at(notes_, Cause::limits_exceeded) += never;
    } else {
      demand(Cause::limits_exceeded, 30);
      accept(Cause::limits_exceeded);
      at(notes_, Cause::limits_exceeded) -= cause_price;
    }
    if (evidence_.life_zeros != 0) {
      accept(Cause::frames_lost_or_repeated);
    } else if (evidence_.count(RequestKind::life_jump) == 0) {
      at(notes_, Cause::frames_lost_or_repeated) += never;
    }
    if (share(evidence_.answered) > 0.02) at(notes_, Cause::no_encoder) += 20;
    if (share(evidence_.good) < 0.05) {
      at(notes_, Cause::supply_or_intermittent) += 12;
      at(notes_, Cause::noise_on_slo) += 15;
      at(notes_, Cause::noise_on_ma) += 60;
      at(notes_, Cause::requested_too_soon) += 40;
    }
    note_slips();
    const bool smeared = is_smeared();
    if (evidence_.count(RequestKind::flip) + evidence_.count(RequestKind::slo_pulse) != 0) {
      at(notes_, smeared ? Cause::noise_on_slo : Cause::clock_too_fast_for_cable) +=
          smeared ? 25 : 80;
    }
    note_truncation();
    note_other();
  }

  // Smeared edges are of the cable if there are many.
  bool is_smeared() const { return share(evidence_.count(RequestKind::smeared)) > 0.15; }

  // An encoder that counted a clock too many sends STOP where the last bit is expected; one that
  // missed a clock sends the last bit where STOP is expected.
  void note_slips() {
    const std::uint64_t failed = evidence_.failed_checks;
    if (failed < 5) return;
    const bool slips =
        100 * evidence_.last_bit_low >= 85 * failed || 100 * evidence_.stops_high >= 15 * failed;
    const double price = 6 * static_cast<double>(failed);
    at(notes_, slips ? Cause::noise_on_slo : Cause::noise_on_ma) += price;
    if (slips) at(notes_, Cause::clock_too_fast_for_cable) += price;
  }

  // A wrong format, or a wrong checksum, lets frames pass by chance only.
  void note_format() {
    const double passed = static_cast<double>(evidence_.passed) /
                          static_cast<double>(std::max<std::uint64_t>(evidence_.answered, 1));
    if (!context_.given || !context_.format) at(notes_, Cause::wrong_format) += never;
    if (passed > 0.08) at(notes_, Cause::wrong_format) += 30;
    if (passed > 0.3 && evidence_.has_format) at(notes_, Cause::wrong_checksum) += 30;
    const bool refused = passed <= 0.08;
    if (const auto& found = context_.identified; found && context_.given && context_.format) {
      if (found->format == *context_.format) {
        at(notes_, Cause::wrong_format) += 25;
      } else if (differs_in_maker_error(found->format)) {
        at(notes_, Cause::wrong_checksum) -= 25;
      } else if (refused) {
        demand(Cause::wrong_format, 60);
        // The checksum is right, in another place or by another rule of BiSS C.
        if (!found->format.deviates()) at(notes_, Cause::wrong_checksum) += never;
      }
    } else if (evidence_.usual.no_checksum_fits) {
      if (has_checksum()) at(notes_, Cause::wrong_format) -= 12;
    }
    // A frame of another length has STOP; one that the master cuts ends with a bit of either level.
    const auto other = static_cast<double>(evidence_.count(RequestKind::other_length));
    const auto high = static_cast<double>(evidence_.truncated - evidence_.truncated_low);
    const bool most = 3 * other > 2 * static_cast<double>(evidence_.answered);
    if (other == 0 || (most && !evidence_.has_format)) at(notes_, Cause::format_changes) += never;
    if (10 * high > other) at(notes_, Cause::format_changes) += 4 * high;
    if (refused && context_.given) {
      at(notes_, Cause::format_changes) += never;
      // Noise that spoils nearly all checksums spoils ACK, START and STOP as well.
      if (share(evidence_.answered) > 0.9) {
        const double price = 60 + 4 * static_cast<double>(evidence_.failed_checks);
        at(notes_, Cause::noise_on_slo) += price;
        at(notes_, Cause::noise_on_ma) += price;
        if (!is_smeared()) at(notes_, Cause::clock_too_fast_for_cable) += price;
      }
    }
  }

  // The frames surely have another format than that given, and its checksum is one of BiSS C.
  bool shows_other_format() const {
    const auto& found = context_.identified;
    return found && context_.given && context_.format && found->format != *context_.format &&
           !found->format.deviates() && !differs_in_maker_error(found->format);
  }

  // The likeliest format that the frames show, though not a sure one, has a checksum.
  bool has_checksum() const {
    return !context_.candidates.empty() &&
           context_.candidates.front().channel_list[0].crc.present();
  }

  // The fields are those of the format, and the checksum is a usual one done wrong.
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
    // What reads hardly better that way says nothing.
    const bool reads = 2 * evidence_.answered > evidence_.cycles || evidence_.cycles == 0;
    const auto judge = [&](Cause cause, bool changed) {
      if (!changed || !reads) return;
      demand(cause, 30);
      accept(cause);
    };
    judge(Cause::ma_slo_swapped, reading.swapped);
    judge(Cause::slo_inverted, reading.slo_inverted);
    judge(Cause::ma_inverted, reading.ma_inverted);
    // Pairs that are exchanged at the connector: both inputs are open.
    const bool open = share(evidence_.answered) < 0.02;
    if (!reading.swapped) at(notes_, Cause::ma_slo_swapped) += open ? 6 : never;
    if (!reading.slo_inverted && evidence_.count(RequestKind::inverted) == 0) {
      at(notes_, Cause::slo_inverted) += never;
    }
    const std::uint64_t half =
        evidence_.count(RequestKind::half_early) + evidence_.count(RequestKind::stop_repeats);
    // Without a format, only that each request ends with the same bit twice shows that it has no STOP.
    const auto& last = evidence_.last_bits;
    const std::uint64_t twice = std::min(last[0], last[3]);
    const bool judged = evidence_.has_format && !context_.assumed;
    const bool no_stop = judged || (has_checksum() && 6 * twice > evidence_.answered &&
                                    20 * (last[1] + last[2]) < evidence_.answered);
    if (!reading.ma_inverted && (half == 0 || !no_stop)) {
      at(notes_, Cause::ma_inverted) += no_stop ? 30 : never;
    }
  }

  void note_delay() {
    if (evidence_.line_delay.count() == 0 || period() <= 0) return;
    const auto delay = static_cast<double>(evidence_.line_delay.median());
    const double periods = delay / period();
    const Picoseconds cycle_period{evidence_.period.median()};
    const auto longest = cable_max_compensated(rate_of(cycle_period));
    // A line delay is measured to a sample, a good part of the period at most.
    const Picoseconds inside = context_.timing.internal_delay_max;
    const bool too_long = longest && Picoseconds{evidence_.line_delay.median()} >
                                         line_delay(*longest, inside) * 11 / 10 + cycle_period / 4;
    const double margin = std::abs(periods - std::floor(periods) - 0.5);
    // A master that compensates nothing sees START as many clocks late and sends as many more.
    const auto late = static_cast<std::int64_t>(std::floor(periods + 0.5));
    const bool sends_more =
        late >= 1 && evidence_.extra_clocks.count() != 0 && evidence_.extra_clocks.median() == late;
    double price = 0;
    if (too_long) price = 20;
    if (sends_more && margin < 0.15) price = std::max(price, 4.0);
    if (context_.compensated == false && (margin < 0.25 || periods > 0.25)) price = 25;
    if (price == 0) return;
    demand(Cause::clock_too_fast_for_cable, price);
    accept(Cause::clock_too_fast_for_cable);
  }

  void note_sampling() {
    const double samples = samples_per_period();
    if (samples < coarse_samples) {
      demand(Cause::sampling_too_slow, 15 + 2 * static_cast<double>(evidence_.cycles));
    } else {
      at(notes_, Cause::sampling_too_slow) += samples < coarse_samples + 0.5 ? 40 : never;
    }
  }

  // Where no frame is whole, only ACK tells whether the master stops early or waits too short.
  void note_truncation() {
    if (evidence_.truncated == 0 || evidence_.ack_clocks.count() != 0) return;
    const auto& ack = evidence_.truncated_ack_clocks;
    const bool varies = ack.count() != 0 && ack.max() > ack.min() + 1;
    const bool cut = evidence_.count(RequestKind::cut_in_data) != 0;
    if (varies && cut) accept(Cause::ack_longer_than_master_waits);
    at(notes_, varies ? Cause::master_stops_early : Cause::ack_longer_than_master_waits) += 6;
  }

  // A master that reads BiSS C over SPI has no select line either.
  bool other_is_weak() const {
    const auto& other = context_.other;
    return !other || other->confidence < (other->name == "spi" ? 0.85 : 0.5);
  }
  bool other_is_clear() const { return context_.other && context_.other->confidence > 0.9; }

  // Another protocol that is recognised outweighs all causes, unless most requests have ACK and START.
  bool is_other_protocol() const {
    if (other_is_weak()) return false;
    if (50 * evidence_.slo_edges < evidence_.ma_edges) return false;
    if (share(evidence_.passed) > (other_is_clear() ? 0.6 : 0.2) && evidence_.has_format)
      return false;
    return evidence_.answered * 10 < evidence_.cycles * 4 || context_.other->confidence > 0.85;
  }

  void note_other() {
    const bool answers = evidence_.answered * 10 > evidence_.cycles * 4;
    const bool passes = share(evidence_.passed) > 0.2 && evidence_.has_format;
    const bool coarse = samples_per_period() < coarse_samples;
    const bool most = evidence_.answered * 10 > evidence_.cycles * 6;
    const bool shows_frames = coarse || context_.identified;
    const bool may_be_spi = context_.other && other_is_weak();
    const bool is_biss = passes || most || (shows_frames && !other_is_clear()) ||
                         (may_be_spi && evidence_.answered * 10 > evidence_.cycles);
    at(notes_, Cause::not_biss) += is_biss ? never : answers ? 60 : 20;
  }

  // Bits become likelihoods by a fitted table.
  std::vector<Finding> findings(const Bits& bits) const {
    const double least = *std::min_element(bits.begin(), bits.end());
    Bits weights{};
    double sum = 0;
    for (std::size_t c = 0; c < cause_count; ++c) {
      const double more = bits[c] - least;
      weights[c] = fitted::prior[c] * std::pow(1 + more / fitted::scale, -fitted::power);
      sum += weights[c];
    }
    std::vector<Finding> all;
    for (std::size_t c = 0; c < cause_count; ++c) {
      const auto cause = static_cast<Cause>(c);
      // Nothing is certain.
      double likelihood = 0.98 * weights[c] / sum;
      if (cause == Cause::healthy && (!evidence_.has_format || context_.assumed)) {
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
