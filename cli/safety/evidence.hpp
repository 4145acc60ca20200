// What `biss safety evidence` is asked for, and the parts that make its bundle, a file each.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "biss/base/units.hpp"
#include "biss/frame/format.hpp"
#include "biss/safety/setup.hpp"
#include "cli/decode/safety.hpp"
#include "cli/safety/evidence_folder.hpp"

namespace biss::cli {

class Verb;

/// As the user typed it, and as configuration.json keeps it: the same options give the same bundle.
struct EvidenceOptions {
  std::string format;
  std::uint64_t frames = 10'000'000;
  std::uint64_t faults = 1'000'000;
  std::uint64_t cycles = 50'000;
  std::uint64_t seed = 1;
  std::vector<std::string> bit_error_rates;
  /// Nothing: as often as the configuration's shortest cycle allows.
  std::optional<Hertz> rate;
  /// Counter, comparison, start-up and watchdog; without a configuration of another name.
  SafetyArguments setup;
  std::string missed;
  bool ignore_turns = false;
  std::uint64_t budget = 0;
  Picoseconds budget_window{};
};

void add_evidence_options(Verb verb, EvidenceOptions& options);

/// Of the options as an object, for configuration.json, and back from the whole of that file.
/// \return nothing where the text is not such a file
std::string options_json(const EvidenceOptions& options);
std::optional<EvidenceOptions> read_options(const std::string& configuration);

/// What all parts are made for.
struct EvidenceQuestion {
  EvidenceOptions options;
  FrameFormat format;
  /// Of configurations.hpp, or that there is none.
  std::string configuration;
  SafetySetup setup;
  std::vector<double> bit_error_rates;
  Hertz rate;
  /// 0: as many as there are cores. No byte of the bundle depends on it.
  unsigned threads = 0;

  const ChannelFormat& cpw() const { return format.channel_list[setup.cpw]; }
  const ChannelFormat& spw() const { return format.channel_list[setup.spw]; }
};

/// The question, or one line of text that says what is wrong (usage: exit status 2).
struct EvidenceChoice {
  std::optional<EvidenceQuestion> question;
  std::string error;
};

EvidenceChoice choose_evidence(const EvidenceOptions& options, unsigned threads);

/// The name by which `biss safety campaign` knows this monitor: a configuration, else the format.
std::string campaign_name(const EvidenceQuestion& question);

/// Bits of the control word's position that the comparison with the safety word does not reach.
struct UncheckedBits {
  unsigned below_resolution = 0;  ///< singleturn bits that the safety word does not have
  unsigned not_compared = 0;      ///< singleturn bits that both words have, by compare_bits
  unsigned turns = 0;             ///< turns that the safety word lacks, or that are ignored

  unsigned all() const { return below_resolution + not_compared + turns; }
};
UncheckedBits unchecked_bits(const EvidenceQuestion& question);

/// A count of faults, and what became of them.
struct CoverageRow {
  std::string_view kind;  ///< a name of TransmissionError, or what else it is
  std::string_view by;    ///< campaign, sequences or line
  std::string fault;
  std::uint64_t committed = 0;
  std::optional<std::uint64_t> detected;  ///< where it is counted
  std::uint64_t accepted_wrong = 0;
  /// Of those committed: accepted wrong, and where the share lies with 95 %.
  double share = 0;
  double low = 0;
  double high = 1;
  std::optional<double> theory;
  /// Cycles from the fault to its verdict, at worst.
  std::optional<std::uint64_t> reaction;
  /// Verdicts that it had, the most frequent first.
  std::string verdicts;
};

/// How often each was the first, the most frequent first.
using VerdictCounts = std::array<std::uint64_t, safety_verdict_count>;
std::string verdicts_text(const VerdictCounts& counts);

/// Share and limits (Wilson's, 95 %) from the counts.
void set_share(CoverageRow& row);

/// A file, and rows for coverage.csv.
struct EvidencePart {
  std::vector<EvidenceFile> files;
  std::vector<CoverageRow> coverage;
  /// A count is too far from its theory, or an undamaged frame was a fault.
  std::vector<std::string> findings;
  /// One line: it could not be made (usage).
  std::string error;
};

EvidencePart evidence_analysis(const EvidenceQuestion& question);
EvidencePart evidence_campaign(const EvidenceQuestion& question);
EvidencePart evidence_sequences(const EvidenceQuestion& question);
EvidencePart evidence_line(const EvidenceQuestion& question);
EvidenceFile evidence_coverage(const std::vector<CoverageRow>& rows);
EvidenceFile evidence_configuration(const EvidenceQuestion& question);
EvidenceFile evidence_version();
EvidenceFile evidence_matrix();
EvidenceFile evidence_readme(const EvidenceQuestion& question,
                             const std::vector<CoverageRow>& coverage,
                             const std::vector<std::string>& findings);

/// Parts of the bundle of which nothing was asked for, each a line.
std::vector<std::string> not_run(const EvidenceOptions& options);
/// A page with plain text in place of its links to what is not in the bundle.
std::string page_of_bundle(std::string_view page);

/// docs/safety.md and docs/safety-matrix.md as they were when this program was built.
extern const char* const safety_page;
extern const char* const safety_matrix_page;
/// The commit it was built from, `-dirty` behind it where files were changed; empty: not known.
extern const char* const build_commit;

/// Column names of the sim fault `kind` in coverage.csv.
std::string_view iec_kind_of(std::string_view sim_fault);

}  // namespace biss::cli
