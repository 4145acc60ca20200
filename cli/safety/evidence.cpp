// biss safety evidence: all that can be shown of one configuration, in a folder that proves itself.
#include "cli/safety/evidence.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <iterator>
#include <memory>

#include "cli/common/verb.hpp"
#include "cli/safety/safety.hpp"

namespace biss::cli {
namespace {

struct VerbOptions {
  EvidenceOptions evidence;
  std::uint64_t threads = 0;
  std::string folder;
  bool force = false;
  std::string checked;
};

struct Bundle {
  std::vector<EvidenceFile> files;
  std::vector<std::string> findings;
  std::string error;
};

template <class T>
void append(std::vector<T>& all, std::vector<T>&& more) {
  all.insert(all.end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
}

Bundle make_bundle(const EvidenceQuestion& question) {
  struct Step {
    const char* name;
    EvidencePart (*make)(const EvidenceQuestion&);
  };
  // The line first: it may refuse the rate.
  constexpr std::array steps{Step{"line model", evidence_line}, Step{"analysis", evidence_analysis},
                             Step{"campaign", evidence_campaign},
                             Step{"sequences", evidence_sequences}};
  Bundle bundle;
  EvidencePart all;
  for (const Step& step : steps) {
    if (isatty(STDERR_FILENO) != 0) print_summary(fmt::format("{} …\n", step.name));
    EvidencePart part = step.make(question);
    if (!part.error.empty()) return {{}, {}, part.error};
    append(all.files, std::move(part.files));
    append(all.coverage, std::move(part.coverage));
    append(all.findings, std::move(part.findings));
  }
  bundle.files.push_back(evidence_readme(question, all.coverage, all.findings));
  bundle.files.push_back(evidence_version());
  bundle.files.push_back(evidence_configuration(question));
  append(bundle.files, std::move(all.files));
  bundle.files.push_back(evidence_coverage(all.coverage));
  bundle.files.push_back(evidence_matrix());
  bundle.files.push_back({"safety.md", page_of_bundle(safety_page)});
  bundle.files.push_back({"safety-matrix.md", page_of_bundle(safety_matrix_page)});
  bundle.findings = std::move(all.findings);
  return bundle;
}

// What a reader of the table alone would not see.
void tell_choice(const EvidenceQuestion& question) {
  const SafetyChoice named = choose_safety({}, question.options.format, question.format, {});
  if (question.options.setup.configuration.empty() && named.name != question.configuration) {
    warn(
        fmt::format("a format's text is monitored by all that both words have, as safety campaign "
                    "does; the configuration with these words is -f {}",
                    named.name));
  }
  for (const std::string& each : not_run(question.options)) warn("nothing was run: " + each);
}

ExitStatus tell(const std::vector<std::string>& findings) {
  for (const std::string& finding : findings) warn(finding);
  return findings.empty() ? ExitStatus::done : ExitStatus::data_failed;
}

ExitStatus run_make(const VerbOptions& options) {
  const EvidenceChoice choice =
      choose_evidence(options.evidence, static_cast<unsigned>(options.threads));
  if (!choice.question) return fail(ExitStatus::usage, choice.error);
  tell_choice(*choice.question);
  // Before the minute that it takes.
  if (const std::string wrong = check_target(options.folder, options.force); !wrong.empty()) {
    return fail(ExitStatus::io, wrong);
  }
  const Bundle bundle = make_bundle(*choice.question);
  if (!bundle.error.empty()) return fail(ExitStatus::usage, bundle.error);
  const std::string wrong = write_bundle(options.folder, bundle.files, options.force);
  if (!wrong.empty()) return fail(ExitStatus::io, wrong);
  print_summary(
      fmt::format("{}: {} files, see README.md in it\n", options.folder, bundle.files.size() + 1));
  return tell(bundle.findings);
}

// Files that say something of the program and not of the configuration.
bool is_of_program(const std::string& name) {
  return name == "version.json" || name == "matrix.csv" || name == "safety.md" ||
         name == "safety-matrix.md";
}

ExitStatus run_check(const VerbOptions& options) {
  ReadBundle found = read_bundle(options.checked);
  if (!found.error.empty()) return fail(ExitStatus::io, found.error);
  const EvidenceFile* kept = found.find("configuration.json");
  const auto asked = kept != nullptr ? read_options(kept->text) : std::nullopt;
  const EvidenceChoice choice =
      asked ? choose_evidence(*asked, static_cast<unsigned>(options.threads)) : EvidenceChoice{};
  if (!choice.question) {
    static_cast<void>(tell(found.findings));
    return fail(
        ExitStatus::io,
        fmt::format("'{}': configuration.json does not say how to make it again", options.checked));
  }
  const Bundle again = make_bundle(*choice.question);
  if (!again.error.empty()) return fail(ExitStatus::io, again.error);
  std::size_t same = 0;
  for (const EvidenceFile& file : again.files) {
    const EvidenceFile* before = found.find(file.name);
    if (before == nullptr) continue;
    if (before->text == file.text) {
      ++same;
    } else if (is_of_program(file.name)) {
      warn(fmt::format("{}: of another build than this program", file.name));
    } else {
      found.findings.push_back(file.name + ": made again, it is another");
    }
  }
  for (const EvidenceFile& file : again.files) {
    if (found.find(file.name) == nullptr) {
      found.findings.push_back(file.name + ": this program makes it too; it is not there");
    }
  }
  append(found.findings, std::vector<std::string>(again.findings));
  print_summary(fmt::format("{}: {} of {} files made again and the same\n", options.checked, same,
                            again.files.size()));
  return tell(found.findings);
}

// What a bundle is checked by stands in the bundle. \return an option that was given all the same
std::string other_than_check(const Verb verb) {
  for (const Option& each : verb.given_options()) {
    const std::string name = each.name();
    if (name != "--check" && name != "--threads") return name;
  }
  return {};
}

}  // namespace

Run add_safety_evidence(Verb verb) {
  const auto options = std::make_shared<VerbOptions>();
  add_evidence_options(verb, options->evidence);
  add_count_option(verb, "--threads", into(options->threads), "As many as there are cores", 1024);
  Option folder = verb.add_option("-o,--output", options->folder,
                                  "The folder to make; it must not be there, or be empty")
                      .type_name("DIR");
  verb.add_flag("--force", options->force, "Replace a bundle that stands there").needs(folder);
  verb.add_option(
          "--check", options->checked,
          "Nothing is written: hold a bundle against its hashes, make it again and compare; "
          "goes with --threads alone")
      .type_name("DIR");
  return [options, verb] {
    if (!options->checked.empty()) {
      const std::string other = other_than_check(verb);
      if (!other.empty()) return fail(ExitStatus::usage, "--check does not go with " + other);
      return run_check(*options);
    }
    if (options->folder.empty()) {
      return fail(ExitStatus::usage,
                  "no folder given: -o DIR to make a bundle, --check DIR to "
                  "check one");
    }
    return run_make(*options);
  };
}

}  // namespace biss::cli
