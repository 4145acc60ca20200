// The result of `biss safety analyse` as text and as JSON lines.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "device/quantity.hpp"
#include "report/summary.hpp"
#include "verbs/common/fields.hpp"
#include "verbs/safety/analysis.hpp"

namespace biss::verbs {
namespace {

// ---- Text

std::string share_text(long double share) {
  return share == 0 ? "0" : fmt::format("{:.4g}", share);
}

std::string distance_text(const WordAnalysis& word) {
  if (word.distances.empty()) return "1: no checksum";
  std::vector<std::string> texts;
  for (const auto& [distance, least, most] : word.distances) {
    texts.push_back(most ? fmt::format("{} for {}..{}", distance, least, *most)
                         : fmt::format("{} from {} on", distance, least));
  }
  return fmt::format("{}", fmt::join(texts, ", "));
}

// The four smallest weights that occur.
template <class Number>
std::string weights_text(const std::vector<Number>& weights, fmt::format_string<Number> number) {
  std::vector<std::string> texts;
  for (std::size_t w = 1; w < weights.size() && texts.size() < 4; ++w) {
    if (weights[w] != 0)
      texts.push_back(fmt::format("A{} = {}", w, fmt::format(number, Number(weights[w]))));
  }
  return texts.empty() ? "none" : fmt::format("{}", fmt::join(texts, ", "));
}

void add_rates(report::Summary& out, const SafetyQuestion& question, const Residual& residual,
               const char* what) {
  for (std::size_t i = 0; i < residual.probabilities.size(); ++i) {
    const long double p = residual.probabilities[i];
    out.entry(i == 0 ? what : "",
              fmt::format("{} a frame at {:g}", share_text(p), question.bit_error_rates[i]),
              fmt::format("{} an hour", share_text(p * question.frames_per_hour())));
  }
}

void add_residual(report::Summary& out, const SafetyQuestion& question, const Residual& residual,
                  const char* what) {
  add_rates(out, question, residual, what);
  out.entry("at most", fmt::format("{} a frame at {:.4f}", share_text(residual.worst.probability),
                                   residual.worst.bit_error_rate));
  out.entry(fmt::format("{:g} an hour", question.limit_per_hour),
            residual.rate_at_limit
                ? fmt::format("at a bit error rate of {:.4g}", *residual.rate_at_limit)
                : std::string("at no bit error rate"));
}

void add_word(report::Summary& out, const SafetyQuestion& question, const WordAnalysis& word) {
  const CrcSpec& crc = word.channel.crc;
  out.title(fmt::format("{}: {} bits, {} of data", word.name, word.channel.total_bits(),
                        word.channel.data_bits));
  out.entry("distance", fmt::format("{}", lab::min_distance(word.weights)),
            "the fewest wrong bits that can pass");
  out.entry("by data bits", distance_text(word));
  out.entry("undetected", weights_text(word.weights, "{}"));
  if (crc.present()) {
    out.entry("bursts", fmt::format("all seen up to {} bits", crc.width_bits),
              fmt::format("2^-{} of {} bits pass, 2^-{} of longer ones", crc.width_bits - 1,
                          crc.width_bits + 1, crc.width_bits));
  }
  add_residual(out, question, word.residual, "accepted wrong");
}

void add_pair(report::Summary& out, const SafetyQuestion& question, const PairAnalysis& pair) {
  out.title(fmt::format("CPW and SPW together: {} bits, {} compared, tolerance {}",
                        pair.weights.bits, pair.weights.compared_bits,
                        question.comparison.tolerance_lsb));
  out.entry("undetected", weights_text(pair.weights.beyond_tolerance, "{:.6g}"),
            "averaged over positions");
  out.entry("safe position", "wrong by more than the tolerance",
            "protected by both CRCs, nE, counter and comparison");
  add_residual(out, question, pair.beyond_tolerance, "accepted wrong");
  out.entry("control position", "any bit of the CPW wrong",
            "below the compared bits, only the CPW's CRC protects it");
  add_rates(out, question, pair.wrong, "accepted wrong");
}

std::string structure_table(const SafetyAnalysis& analysis) {
  std::vector<FieldRow> table;
  for (const lab::StructureRow& row : analysis.structure) {
    // Only one place can be the next 1: for lost_start the sum is the share.
    const long double places = row.fault == lab::FaultKind::lost_start ? 1 : row.places;
    FieldRow& fields =
        table.emplace_back(FieldRow{{"fault", sim::name_of(row.fault)},
                                    {"first word", share_text(row.sum.first_word / places)},
                                    {"all words", share_text(row.sum.all_words / places)},
                                    {"and nE", share_text(row.sum.trusted / places)}});
    if (analysis.pair) fields.emplace_back("and comparison", share_text(row.sum.pair / places));
    fields.emplace_back("worst place", share_text(row.worst.first_word));
    fields.emplace_back("at", row.worst_place);
  }
  return text_of(table, report::Format::table);
}

// ---- JSON lines

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

std::string analysis_text(const SafetyQuestion& question, const SafetyAnalysis& analysis) {
  report::Summary out;
  out.entry("model", channel_model_text);
  out.entry("frames", fmt::format("{} a second", question.frame_rate.count));
  for (const WordAnalysis& word : analysis.words) add_word(out, question, word);
  if (analysis.pair) add_pair(out, question, *analysis.pair);
  return out.text() + "\nFaults of structure: the share of positions that pass and are wrong\n" +
         structure_table(analysis);
}

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
