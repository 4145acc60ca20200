// What `biss safety analyse` finds, and the two ways in which it is written.
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

namespace biss::cli {

/// Stands in all output of the analysis.
inline constexpr const char* channel_model_text =
    "binary symmetric channel: a model of a channel, not a certificate";

/// What the user wants to know.
struct SafetyQuestion {
  FrameFormat format;
  std::vector<double> bit_error_rates;
  Hertz frame_rate;
  double limit_per_hour = 0;
  lab::PairChecks checks;
  unsigned gap_bits = 0;

  long double frames_per_hour() const { return 3600 * static_cast<long double>(frame_rate.count); }
};

/// Of something that is accepted although it is wrong.
struct Residual {
  lab::Undetected undetected;
  std::vector<long double> probabilities;  ///< at each bit error rate
  lab::WorstRate worst;
  /// The bit error rate at which so many frames an hour are accepted wrong; nothing: at none.
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
  /// Why there is none though the second channel has a counter, as safety words have.
  std::optional<lab::PairError> pair_problem;
  std::vector<lab::StructureRow> structure;
};

SafetyAnalysis analyse(const SafetyQuestion& question);

/// For eyes.
std::string analysis_text(const SafetyQuestion& question, const SafetyAnalysis& analysis);
/// An object a line: one a channel, one more for the pair.
std::string analysis_jsonl(const SafetyQuestion& question, const SafetyAnalysis& analysis);

}  // namespace biss::cli
