// The results of `biss safety analyse`, and its two output formats.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "biss/base/units.hpp"
#include "biss/frame/format.hpp"
#include "lab/distance.hpp"
#include "lab/pair.hpp"
#include "lab/residual.hpp"
#include "lab/structure.hpp"
#include "lab/weights.hpp"

namespace biss::verbs {

class Host;

/// Part of every output of the analysis.
inline constexpr const char* channel_model_text =
    "binary symmetric channel: a model of a channel, not a certificate";

/// The options of `biss safety analyse`, as typed.
struct QuestionOptions {
  std::vector<std::string> rates;
  std::string limit = "1e-9";
  Hertz frame_rate = kilohertz(32);
  SafetyComparison comparison;
  bool ignore_turns = false;
  unsigned gap_bits = 8;
};

/// The options, and what they say.
struct SafetyQuestion : QuestionOptions {
  FrameFormat format{};
  std::vector<double> bit_error_rates{};
  double limit_per_hour = 0;

  long double frames_per_hour() const { return 3600 * static_cast<long double>(frame_rate.count); }
};

/// The residual errors of a word or a pair.
struct Residual {
  lab::Undetected undetected;
  std::vector<long double> probabilities;  ///< at each bit error rate
  lab::WorstRate worst;
  /// The bit error rate with limit_per_hour undetected errors; nothing if no rate reaches it.
  std::optional<long double> rate_at_limit;
};

struct WordAnalysis {
  std::string name;
  ChannelFormat channel;
  lab::Polynomial<lab::Count> weights;
  std::vector<lab::DistanceRun> distances;  ///< empty without a checksum
  Residual residual;
};

struct PairAnalysis {
  lab::PairWeights weights;
  Residual beyond_tolerance;
  Residual wrong;
};

struct SafetyAnalysis {
  std::vector<WordAnalysis> words;
  std::optional<PairAnalysis> pair;
  /// Why there is no pair although the second channel has a counter, as safety words have.
  std::optional<lab::PairError> pair_problem;
  std::vector<lab::StructureRow> structure;
};

/// The question; throws a VerbError if an option is wrong.
SafetyQuestion safety_question(const FrameFormat& format, const QuestionOptions& options);

SafetyAnalysis analyse(const SafetyQuestion& question);
/// Prints a message if there is a pair_problem.
void warn_of_pair(const SafetyAnalysis& analysis, Host& host);

/// Human-readable.
std::string analysis_text(const SafetyQuestion& question, const SafetyAnalysis& analysis);
/// JSON lines: an object for each channel, and one for the pair.
std::string analysis_jsonl(const SafetyQuestion& question, const SafetyAnalysis& analysis);

}  // namespace biss::verbs
