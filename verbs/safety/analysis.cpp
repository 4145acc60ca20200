#include "verbs/safety/analysis.hpp"

#include <fmt/format.h>

namespace biss::verbs {
namespace {

Residual residual_of(const SafetyQuestion& question, lab::Undetected undetected) {
  Residual residual;
  for (const double rate : question.bit_error_rates) {
    residual.probabilities.push_back(lab::probability(undetected, rate));
  }
  residual.worst = lab::worst_rate(undetected);
  residual.rate_at_limit =
      lab::rate_reaching(undetected, question.limit_per_hour / question.frames_per_hour());
  residual.undetected = std::move(undetected);
  return residual;
}

// The names of BiSS Safety if a word has a counter, as safety words have.
std::string name_of_word(const FrameFormat& format, std::size_t k) {
  const auto& channels = format.channel_list;
  if (channels[k].life_counter.present()) return "SPW";
  const bool before_one = k + 1 < format.channel_count && channels[k + 1].life_counter.present();
  return before_one ? "CPW" : fmt::format("channel {}", k + 1);
}

WordAnalysis analysed(const SafetyQuestion& question, std::size_t k) {
  const ChannelFormat& channel = question.format.channel_list[k];
  WordAnalysis word;
  word.name = name_of_word(question.format, k);
  word.channel = channel;
  word.weights = lab::weights_of(lab::code_of(channel));
  if (channel.crc.present()) word.distances = lab::distance_runs(channel.crc.polynomial);
  word.residual = residual_of(question, lab::undetected_of(word.weights));
  return word;
}

}  // namespace

SafetyAnalysis analyse(const SafetyQuestion& question) {
  const FrameFormat& format = question.format;
  SafetyAnalysis analysis;
  for (std::size_t k = 0; k < format.channel_count; ++k) {
    analysis.words.push_back(analysed(question, k));
  }
  if (format.channel_count > 1 && format.channel_list[1].life_counter.present()) {
    analysis.pair_problem = lab::pair_problem(format, question.comparison);
    if (!analysis.pair_problem) {
      PairAnalysis& pair = analysis.pair.emplace();
      pair.weights = lab::pair_weights(format, question.comparison);
      pair.beyond_tolerance = residual_of(question, pair.weights.beyond_tolerance);
      pair.wrong = residual_of(question, pair.weights.wrong);
    }
  }
  const lab::StructureModel model{.pair = analysis.pair.has_value(),
                                  .comparison = question.comparison,
                                  .gap_bits = question.gap_bits};
  for (const lab::FaultKind fault : lab::structural_faults) {
    analysis.structure.push_back(lab::structure_row(format, fault, model));
  }
  return analysis;
}

}  // namespace biss::verbs
