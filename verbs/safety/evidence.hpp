// The options of `biss safety evidence`, and the files of its bundle.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <tl/expected.hpp>

#include "biss/base/units.hpp"
#include "verbs/common/safety_format.hpp"
#include "verbs/decode/safety.hpp"
#include "verbs/safety/experiments.hpp"

namespace biss::verbs {

struct EvidenceFile {
  std::string name;  ///< without a folder
  std::string text;
};

/// The options as typed.
struct EvidenceOptions {
  std::string format;
  std::uint64_t frames = 10'000'000;
  std::uint64_t faults = 1'000'000;
  std::uint64_t cycles = 50'000;
  std::uint64_t seed = 1;
  std::vector<std::string> bit_error_rates;
  /// If not given: the highest rate of the configuration's shortest cycle.
  std::optional<Hertz> rate;
  /// Counter, comparison, start-up and watchdog; latch and by_widths are not used.
  SafetyArguments setup;
  std::string missed;
  bool ignore_turns = false;
  std::uint64_t budget = 0;
  Picoseconds budget_window{};
};

/// Declares the options. \pre options outlives the parsing
void add_evidence_options(Verb verb, EvidenceOptions& options);

/// A frame and its monitor, as the options describe them.
struct EvidenceSubject {
  EvidenceOptions options;
  SafetyFormat monitored;
  /// A name of configurations.hpp, or a text that states that there is none.
  std::string configuration;
  Hertz rate;
};

/// The subject, or one line of text with the error (usage: exit status 2).
tl::expected<EvidenceSubject, std::string> choose_evidence(const EvidenceOptions& options);

/// A command line of the bundle and the file that holds its output.
struct EvidenceCommand {
  std::string file;
  std::vector<std::string> arguments;
  /// Exit status 0: everything agrees with the theory.
  int status = 0;
};

/// The commands of the bundle, in the order in which they run.
std::vector<EvidenceCommand> evidence_commands(const EvidenceSubject& subject);

/// Returns `biss ARGUMENTS…` for a shell.
std::string command_line(const std::vector<std::string>& arguments);

/// A kind of fault, and how many of its instances had which result.
struct CoverageRow {
  std::string error;  ///< a name of TransmissionError, or `encoder`
  std::string by;     ///< campaign, sequences or line
  std::string fault;
  std::uint64_t injected = 0;
  std::optional<std::uint64_t> detected{};  ///< if it is counted
  std::uint64_t accepted_wrong = 0;
  /// accepted_wrong / injected, and its 95 % limits.
  double share = 0;
  double low = 0;
  double high = 1;
  std::optional<double> theory{};
  /// Cycles from the fault to its verdict, at worst.
  std::optional<std::uint64_t> reaction{};
  std::string verdicts{};
};

std::vector<CoverageRow> coverage_of(const SafetyFormat& monitored, const LineResult& line,
                                     std::span<const CampaignRow> campaign,
                                     std::span<const lab::SequenceResult> sequences);
/// Sets share and limits (Wilson limits, 95 %) from the counts.
void set_share(CoverageRow& row);

EvidenceFile coverage_file(const std::vector<CoverageRow>& rows);
/// Requirement, source and test: the table of docs/safety-matrix.md, a row for each test.
EvidenceFile matrix_file();
EvidenceFile readme_file(const EvidenceSubject& subject,
                         const std::vector<EvidenceCommand>& commands,
                         const std::vector<CoverageRow>& coverage);

/// The parts of the bundle that ran nothing, a line each.
std::vector<std::string> not_run(const EvidenceOptions& options);
/// A page with plain text in place of links to files that are not in the bundle.
std::string page_of_bundle(std::string_view page);

/// docs/safety.md and docs/safety-matrix.md as they were when this program was built.
extern const char* const safety_page;
extern const char* const safety_matrix_page;

// ---- The folder: written completely or not at all, and checked by its hashes.

/// The name of the list of hashes, in the format of `sha256sum -c`.
inline constexpr const char* hash_list_name = "SHA256SUMS";

/// Returns the hash in lower-case hexadecimal.
std::string sha256_of(std::string_view text);

/// Throws a VerbError if the folder cannot be made. Changes nothing.
/// \param replace an existing bundle may be replaced; a folder with any other file in it never is
void check_target(const std::string& folder, bool replace);

/// Writes the files and the list of their hashes into a folder next to the target and renames it: the
/// target is the whole bundle, or unchanged after a VerbError.
void write_bundle(const std::string& folder, const std::vector<EvidenceFile>& files, bool replace);

/// A bundle on the disk.
struct ReadBundle {
  std::vector<EvidenceFile> files;
  /// A line for each file that is changed, missing, or not in the list of hashes.
  std::vector<std::string> findings;

  const EvidenceFile* find(std::string_view name) const;
};

/// The bundle; throws a VerbError if it cannot be read.
ReadBundle read_bundle(const std::string& folder);

}  // namespace biss::verbs
