// biss safety analyse: the errors that a format's checks do not detect, calculated exactly.
#include <fmt/format.h>

#include <memory>
#include <string>

#include "lab/pair.hpp"
#include "report/text.hpp"
#include "verbs/common/format_option.hpp"
#include "verbs/common/verb.hpp"
#include "verbs/safety/analysis.hpp"
#include "verbs/safety/safety.hpp"

namespace biss::verbs {
namespace {

struct AnalyseOptions {
  FormatArguments arguments;
  QuestionOptions question;
  std::string to = "table";
  std::string output;
};

// A number like 1e-3, independent of the locale, above 0 and at most `most`.
double positive_in(std::string_view option, const std::string& text, double most,
                   std::string_view range) {
  const double value = report::number_in<double>(text).value_or(0);
  if (value > 0 && value <= most) return value;
  throw wrong_usage("{} '{}': give a number above 0{}", option, text, range);
}

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

// The rating as C++ text, with the command that prints it.
std::string rating_text(const SafetyQuestion& question) {
  const SafetyComparison& comparison = question.comparison;
  const auto rating = lab::safety_rating(question.format, comparison);
  if (!rating) {
    const auto problem = lab::pair_problem(question.format, comparison);
    throw wrong_usage("no rating: {}",
                      problem ? lab::text_of(*problem) : "the residual error is too large");
  }
  const auto per_hour = static_cast<double>(static_cast<long double>(rating->residual_e24) *
                                            1e-24L * question.frames_per_hour());
  return fmt::format(
      "// {}: {} upper bits compared, tolerance {}{}\n"
      "// {:.4g} undetected errors an hour at {} frames a second and a bit error rate of {}\n"
      "biss::SafetyRating{{0x{:X}U, {}U, 0x{:X}U}}\n",
      format_text(question.format).view(),
      comparison.compare_bits == 0 ? "all" : std::to_string(comparison.compare_bits),
      comparison.tolerance_lsb,
      comparison.multiturn == MultiturnRule::with_carry ? "" : ", turns ignored", per_hour,
      question.frame_rate.count, lab::rated_bit_error_rate, rating->words, rating->residual_e24,
      rating->check);
}

ExitStatus run_analyse(const AnalyseOptions& options, Host& host) {
  const Device device = value_or_fail(parse_device(options.arguments.format));
  const SafetyQuestion question = safety_question(device.format, options.question);
  return write_output(host, options.output, [&](Output& output) {
    if (options.to == "c") return output.write(rating_text(question));
    const SafetyAnalysis analysis = analyse(question);
    warn_of_pair(analysis, host);
    return output.write(options.to == "jsonl" ? analysis_jsonl(question, analysis)
                                              : analysis_text(question, analysis));
  });
}

}  // namespace

SafetyQuestion safety_question(const FrameFormat& format, const QuestionOptions& options) {
  if (format.deviates()) throw wrong_usage("-f: a CRC with an error of the maker is not analysed");
  SafetyQuestion question{options, format};
  if (options.ignore_turns) question.comparison.multiturn = MultiturnRule::ignored;
  for (const std::string& text : options.rates) {
    question.bit_error_rates.push_back(positive_in("--ber", text, 0.5, ", up to 0.5"));
  }
  if (question.bit_error_rates.empty()) question.bit_error_rates = {1e-2, 1e-3, 1e-4};
  question.limit_per_hour = positive_in("--limit", options.limit, 1e12, "");
  return question;
}

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

void warn_of_pair(const SafetyAnalysis& analysis, Host& host) {
  if (!analysis.pair_problem) return;
  host.warn(fmt::format("the two words are not analysed as a pair: {}",
                        lab::text_of(*analysis.pair_problem)));
}

Run add_safety_analyse(Verb verb) {
  const auto options = std::make_shared<AnalyseOptions>();
  QuestionOptions& asked = options->question;
  add_format_option(verb, options->arguments, true);
  verb.add_option("--ber", asked.rates,
                  "Bit error rate. May be repeated; 1e-2, 1e-3 and 1e-4 by default")
      .type_name("P");
  add_rate_option(verb, "--rate", into(asked.frame_rate), "Frames per second; 32kHz by default");
  verb.add_option(
          "--limit", asked.limit,
          "Find the bit error rate with this many undetected errors per hour; 1e-9 by default")
      .type_name("N");
  add_count_option(verb, "--compare", into(asked.comparison.compare_bits),
                   "Number of upper singleturn bits to compare (ACC_MIN); by default all bits that "
                   "both words have",
                   64)
      .type_name("BITS");
  add_count_option(
      verb, "--tolerance", into(asked.comparison.tolerance_lsb),
      "Largest difference of the two words, in counts of the lowest bit compared; 1 by default",
      255)
      .type_name("LSB");
  verb.add_flag("--ignore-turns", asked.ignore_turns, "Do not compare turns");
  add_count_option(verb, "--gap", into(asked.gap_bits), "Length of a gap on the line; 8 by default",
                   640)
      .type_name("BITS");
  add_name_option(verb, "--to", options->to, {"table", "jsonl", "c"},
                  "Output format; c: the rating for SafetySetup; table by default");
  add_output_option(verb, options->output);
  return [options](Host& host) { return run_analyse(*options, host); };
}

}  // namespace biss::verbs
