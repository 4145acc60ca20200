// The result of `biss safety` as JSON lines.
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "verbs/safety/analysis.hpp"

namespace biss::verbs {
namespace {

using Json = nlohmann::ordered_json;

// A reader that stores numbers as doubles would change integers above 2^53.
Json number(lab::Count count) {
  if (count <= lab::Count{1} << 53U) return static_cast<std::uint64_t>(count);
  return fmt::format("{}", count);
}

Json optional(const std::optional<long double>& value) { return value ? Json(*value) : Json(); }

// A number for one rate, a list in the given order for several.
Json one_or_list(const Json& list) { return list.size() == 1 ? list.front() : list; }

void add_residual(Json& object, const SafetyQuestion& question, const Residual& residual) {
  object["ber"] = one_or_list(question.bit_error_rates);
  object["p_undetected"] = one_or_list(residual.probabilities);
  object["p_undetected_max"] = residual.worst.probability;
  object["p_undetected_max_ber"] = residual.worst.bit_error_rate;
}

void add_rates(Json& object, const SafetyQuestion& question, const Residual& residual) {
  std::vector<long double> per_hour;
  for (const long double p : residual.probabilities) {
    per_hour.push_back(p * question.frames_per_hour());
  }
  object["rate_hz"] = question.frame_rate.count;
  object["per_hour"] = one_or_list(per_hour);
  object["limit_per_hour"] = question.limit_per_hour;
  object["ber_at_limit"] = optional(residual.rate_at_limit);
}

Json structure_of(const SafetyAnalysis& analysis) {
  const auto shares = [&](const lab::PassedShares& of, long double places) {
    return Json{{"first_word", of.first_word / places},
                {"all_words", of.all_words / places},
                {"trusted", of.trusted / places},
                {"pair", analysis.pair ? Json(of.pair / places) : Json()}};
  };
  Json rows = Json::array();
  for (const lab::StructureRow& row : analysis.structure) {
    rows.push_back({{"fault", sim::name_of(row.fault)},
                    {"places", row.places},
                    {"mean", shares(row.sum, row.places)},
                    {"worst", shares(row.worst, 1)},
                    {"worst_place", row.worst_place}});
  }
  return rows;
}

Json object_of(const SafetyQuestion& question, const WordAnalysis& word) {
  Json object;
  object["word"] = word.name;
  object["bits"] = word.channel.total_bits();
  object["data_bits"] = word.channel.data_bits;
  object["min_distance"] = lab::min_distance(word.weights);
  object["weights"] = Json::array();
  for (const lab::Count count : word.weights) object["weights"].push_back(number(count));
  add_residual(object, question, word.residual);
  object["polynomial"] = fmt::format("0x{:X}", word.channel.crc.polynomial);
  object["crc_bits"] = word.channel.crc.width_bits;
  object["distances"] = Json::array();
  for (const lab::DistanceRun& run : word.distances) {
    object["distances"].push_back(
        {{"distance", run.distance},
         {"data_bits_min", run.data_bits_min},
         {"data_bits_max", run.data_bits_max ? Json(*run.data_bits_max) : Json()}});
  }
  object["burst_bits_detected"] = word.channel.crc.width_bits;
  add_rates(object, question, word.residual);
  object["model"] = channel_model_text;
  return object;
}

Json object_of(const SafetyQuestion& question, const SafetyAnalysis& analysis,
               const PairAnalysis& pair) {
  const auto& words = analysis.words;
  const lab::Undetected& beyond = pair.weights.beyond_tolerance;
  const auto first = std::find_if(beyond.begin(), beyond.end(), [](auto n) { return n > 0; });
  Json object;
  object["word"] = "pair";
  object["bits"] = pair.weights.bits;
  object["data_bits"] = words[0].channel.data_bits + words[1].channel.data_bits;
  object["min_distance"] = first == beyond.end() ? Json() : Json(first - beyond.begin());
  object["weights"] = beyond;
  add_residual(object, question, pair.beyond_tolerance);
  object["compared_bits"] = pair.weights.compared_bits;
  object["tolerance_lsb"] = question.comparison.tolerance_lsb;
  add_rates(object, question, pair.beyond_tolerance);
  object["p_wrong"] = one_or_list(pair.wrong.probabilities);
  object["p_wrong_max"] = pair.wrong.worst.probability;
  object["p_wrong_ber_at_limit"] = optional(pair.wrong.rate_at_limit);
  object["model"] = channel_model_text;
  return object;
}

}  // namespace

std::string analysis_jsonl(const SafetyQuestion& question, const SafetyAnalysis& analysis) {
  std::vector<Json> objects;
  for (const WordAnalysis& word : analysis.words) objects.push_back(object_of(question, word));
  // The faults of structure are part of the pair, else of the first word.
  if (analysis.pair) objects.push_back(object_of(question, analysis, *analysis.pair));
  (analysis.pair ? objects.back() : objects.front())["structure"] = structure_of(analysis);
  std::string text;
  for (const Json& object : objects) text += object.dump() + "\n";
  return text;
}

}  // namespace biss::verbs
