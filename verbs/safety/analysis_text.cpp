// The result of `biss safety` as text.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "device/quantity.hpp"
#include "report/summary.hpp"
#include "verbs/common/fields.hpp"
#include "verbs/safety/analysis.hpp"

namespace biss::verbs {
namespace {

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

}  // namespace biss::verbs
