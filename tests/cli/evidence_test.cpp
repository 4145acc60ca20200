// biss safety evidence: a complete bundle that verifies itself and is reproducible byte by byte.
#include <set>

#include "sim/fault.hpp"
#include "tests/cli/run_command.hpp"

namespace biss::verbs::evidence_test {

using Evidence = InFolder;

namespace fs = std::filesystem;
using testing::HasSubstr;

// Small checksums, so that their theory is quick to compute.
constexpr const char* safety_pair = "pos14,nE,nW,crc4+pos10,nE,nW,lc6,crc8;cds0";

std::vector<std::string> evidence(const std::string& folder, const Words& more = {}) {
  return Words("safety evidence -f {} --frames 3000 --faults 200 --cycles 300 -o {}", safety_pair,
               folder) +
         more;
}

// One bundle, shared by all tests that only read it.
const std::string& bundle() {
  static const Folder folder;
  static const std::string path = [] {
    run_ok(evidence(folder.path("bundle"), "--threads 1"));
    return folder.path("bundle");
  }();
  return path;
}

std::set<std::string> names_in(const std::string& folder) {
  std::set<std::string> names;
  for (const auto& each : fs::directory_iterator(folder)) names.insert(each.path().filename());
  return names;
}

std::string copy_of_bundle(const Folder& folder) {
  const std::string path = folder.path("copy");
  fs::copy(bundle(), path);
  return path;
}

void append(const std::string& path, const std::string& text) {
  std::ofstream(path, std::ios::app) << text;
}

int shell(const std::string& line) {
  const int status = std::system(line.c_str());
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

// The words of a command in backquotes that begins with `begin`, split as by a shell.
std::vector<std::string> command_in(const std::string& text, const std::string& begin) {
  const std::size_t at = text.find("`" + begin);
  if (at == std::string::npos) return {};
  const std::string line = text.substr(at + 1, text.find('`', at + 1) - at - 1);
  Words words{""};
  bool quoted = false;
  for (const char letter : line) {
    if (letter == '\'') {
      quoted = !quoted;
    } else if (letter == ' ' && !quoted) {
      words.emplace_back();
    } else {
      words.back() += letter;
    }
  }
  words.erase(words.begin());  // biss
  return words;
}

TEST_F(Evidence, Bundle_HasItsFilesAndTheirHashes) {
  EXPECT_EQ(names_in(bundle()),
            (std::set<std::string>{"README.md", "SHA256SUMS", "analysis.jsonl", "analysis.txt",
                                   "campaign.csv", "configuration.json", "coverage.csv", "line.csv",
                                   "manifest.json", "matrix.csv", "safety-matrix.md", "safety.md",
                                   "sequences.csv", "version.json"}));
  EXPECT_EQ(shell("cd '" + bundle() + "' && sha256sum --strict --quiet -c SHA256SUMS"), 0);
  for (const char* file : {"README.md", "analysis.jsonl", "analysis.txt"}) {
    EXPECT_THAT(content_of(bundle() + "/" + file), HasSubstr("not a certificate")) << file;
  }
}

TEST_F(Evidence, AnyNumberOfThreads_GivesTheSameBytes) {
  const std::string again = folder.path("elsewhere");
  run_ok(evidence(again, "--threads 3"));
  for (const std::string& name : names_in(bundle())) {
    EXPECT_EQ(content_of(again + "/" + name), content_of(bundle() + "/" + name)) << name;
  }
  const std::string other = folder.path("other");
  run_ok(evidence(other, "--seed 2"));
  for (const char* name : {"campaign.csv", "line.csv", "sequences.csv", "manifest.json"}) {
    EXPECT_NE(content_of(other + "/" + name), content_of(bundle() + "/" + name)) << name;
  }
}

TEST_F(Evidence, CheckedBundle_IsMadeAgainTheSame) {
  EXPECT_THAT(run_ok("safety evidence --check {}", bundle()).err, HasSubstr("13 of 13 files"));
}

TEST_F(Evidence, ChangedBundle_IsFound) {
  const std::string copy = copy_of_bundle(folder);
  const auto found = [&](int status, const std::vector<std::string>& findings) {
    const Outcome checked = run("safety evidence --check {}", copy);
    EXPECT_EQ(checked.status, status) << checked.err;
    for (const std::string& each : findings) EXPECT_THAT(checked.err, HasSubstr(each));
  };
  append(copy + "/coverage.csv", "corruption,line,nothing,1\n");
  append(copy + "/notes.txt", "mine");
  fs::rename(copy + "/line.csv", folder.path("line.csv"));
  found(1, {"coverage.csv: another hash", "coverage.csv: differs", "notes.txt: not in the list",
            "line.csv: missing or unreadable"});
  fs::remove(copy + "/notes.txt");
  fs::rename(folder.path("line.csv"), copy + "/line.csv");
  // A change with renewed hashes is detected by the tables.
  ASSERT_EQ(shell("cd '" + copy + "' && sha256sum $(ls | grep -v SHA256SUMS) > SHA256SUMS"), 0);
  found(1, {"coverage.csv: differs"});
  const auto manifest = [&](const std::string& made_by) {
    std::ofstream(copy + "/manifest.json") << "{\"made_by\": " << made_by << "}";
  };
  for (const char* made_by :
       {"7", "[7]", "[\"decode\"]", "[\"--format=fs-36-29\"]", "[\"--help\"]",
        "[\"--format=fs-36-28\", \"--frames=-1\"]", "[\"--format=fs-36-28\", \"--output=x\"]"}) {
    manifest(made_by);
    found(3, {"manifest.json"});
  }
  std::ofstream(copy + "/SHA256SUMS") << "nothing";
  found(3, {"SHA256SUMS"});
  fs::remove_all(copy);
  found(3, {"cannot read"});
}

TEST_F(Evidence, BundleOfAnotherBuild_IsReportedAndNoFailure) {
  const std::string copy = copy_of_bundle(folder);
  append(copy + "/version.json", "\n");
  ASSERT_EQ(shell("cd '" + copy + "' && sha256sum $(ls | grep -v SHA256SUMS) > SHA256SUMS"), 0);
  const Outcome checked = run_ok("safety evidence --check {}", copy);
  EXPECT_THAT(checked.err, HasSubstr("version.json: from another build"));
}

TEST_F(Evidence, CommandsOfTheReadme_MakeTheSameTables) {
  const std::string readme = content_of(bundle() + "/README.md");
  for (const char* file :
       {"line.csv", "analysis.jsonl", "analysis.txt", "campaign.csv", "sequences.csv"}) {
    const std::size_t at = readme.find(std::string("* `") + file + "`: ");
    ASSERT_NE(at, std::string::npos) << file;
    const Outcome outcome = run_ok(command_in(readme.substr(at), "biss safety"));
    EXPECT_EQ(outcome.out, content_of(bundle() + "/" + file)) << file;
  }
}

TEST_F(Evidence, SetupOfItsOwn_IsGivenToTheVerbsByItsFile) {
  const std::string made = folder.path("made");
  run_ok(evidence(made, "--compare-bits 8 --tolerance 0"));
  const std::string readme = content_of(made + "/README.md");
  Words words = command_in(readme, "biss safety campaign");
  const auto file = std::find(words.begin(), words.end(), "configuration.json");
  ASSERT_NE(file, words.end());
  *file = made + "/configuration.json";
  EXPECT_EQ(run(words).out, content_of(made + "/campaign.csv"));
  EXPECT_EQ(run(command_in(readme, "biss safety analyse")).out,
            content_of(made + "/analysis.jsonl"));
  run_ok("safety evidence --check {}", made);
}

TEST_F(Evidence, Coverage_HasEveryFaultOfTheLineAndEveryKind) {
  std::set<std::string> line;
  std::set<std::string> kinds;
  bool flips = false;
  for (const Row& row : rows_of(content_of(bundle() + "/coverage.csv"))) {
    if (row.at("by") == "line") line.insert(row.at("fault"));
    if (row.at("by") == "sequences") kinds.insert(row.at("error"));
    if (row.at("by") == "campaign" && row.at("fault") == "flips:0.1") {
      flips = true;
      // Only the frames with a wrong bit are counted.
      EXPECT_EQ(row.at("injected"), "2976");
      EXPECT_NEAR(std::stod(row.at("dc_theory")), 1 - std::stod(row.at("share_theory")), 2e-9);
    }
    if (row.at("injected") == "0") continue;
    EXPECT_LE(std::stod(row.at("dc_low")), std::stod(row.at("dc")));
    EXPECT_LE(std::stod(row.at("dc")), std::stod(row.at("dc_high")));
    if (row.at("fault") == "flip" || row.at("fault") == "repeat") {
      EXPECT_EQ(row.at("detected"), row.at("injected"));
      EXPECT_EQ(row.at("reaction_cycles"), "0");
      EXPECT_EQ(row.at("accepted_wrong"), "0");
    }
    // The monitor does not detect this, so the report must mention it.
    if (row.at("fault") == "frozen") {
      EXPECT_EQ(row.at("accepted_wrong"), row.at("injected"));
      EXPECT_EQ(row.at("dc"), "0.000000000");
    }
  }
  EXPECT_TRUE(flips);
  EXPECT_EQ(kinds, (std::set<std::string>{"corruption", "repetition", "sequence", "loss", "delay",
                                          "insertion", "masquerade", "addressing"}));
  for (const sim::FaultEntry& entry : sim::fault_list) {
    EXPECT_EQ(line.contains(std::string(entry.name)), is_simulated(entry.kind)) << entry.name;
  }
}

// Times of more than 8.8 s times 2^20 do not fit into 64 bits.
TEST_F(Evidence, SlowestRate_HasNoFindingAndNoOverflow) {
  const std::string made = folder.path("made");
  run_ok(evidence(made, "--rate 1Hz"));
  for (const Row& row : rows_of(content_of(made + "/coverage.csv"))) {
    if (row.at("reaction_cycles").empty()) continue;
    EXPECT_LE(std::stod(row.at("reaction_cycles")), 4) << row.at("fault");
  }
}

TEST_F(Evidence, Matrix_HasARowForEachTestOfTheDocument) {
  const std::string matrix = content_of(bundle() + "/matrix.csv");
  EXPECT_TRUE(matrix.starts_with("requirement,source,test\n"));
  EXPECT_THAT(matrix, HasSubstr(",Safety.LatchedFault_HoldsToTheEnd\n"));
  EXPECT_THAT(matrix, HasSubstr(",Each/SafetyFault.OnTheWire_IsNamedInTime\n"));
  EXPECT_GT(std::count(matrix.begin(), matrix.end(), '\n'), 60);
}

TEST_F(Evidence, FolderThatIsNotFree_IsLeftAlone) {
  const auto refused = [&](const std::string& target, const std::string& what,
                           const Words& more = {}) {
    EXPECT_THAT(run(evidence(target, more)), refuses(3, what));
  };
  const std::string mine = folder.path("mine");
  fs::create_directory(mine);
  append(mine + "/thesis.txt", "all of it");
  refused(mine, "not empty");
  refused(mine, "--force replaces bundles only", {"--force"});
  EXPECT_EQ(names_in(mine), std::set<std::string>{"thesis.txt"});
  const std::string copy = copy_of_bundle(folder);
  refused(copy, "replace this bundle with --force");
  append(copy + "/notes.txt", "mine");
  refused(copy, "--force replaces bundles only", {"--force"});
  refused(mine + "/thesis.txt", "is not a folder");
  refused(mine + "/thesis.txt/below", "cannot write");
  refused(folder.path("none/below"), "cannot write");
  EXPECT_EQ(names_in(folder.path("")), (std::set<std::string>{"copy", "mine"}));
}

TEST_F(Evidence, EmptyFolderOrBundleByForce_IsReplaced) {
  const std::string target = folder.path("target");
  fs::create_directory(target);
  run_ok(evidence(target + "/"));
  const std::string before = content_of(target + "/campaign.csv");
  run_ok(evidence(target, "--seed 7 --force"));
  EXPECT_NE(content_of(target + "/campaign.csv"), before);
  run_ok("safety evidence --check {}", target);
  EXPECT_EQ(names_in(folder.path("")), std::set<std::string>{"target"});
}

// A limit on the file size, in place of a full disk.
TEST_F(Evidence, FilesThatCannotBeWritten_LeaveWhatWasThere) {
  const std::string copy = copy_of_bundle(folder);
  const std::string before = content_of(copy + "/SHA256SUMS");
  EXPECT_THAT(run_limited("-f 2", evidence(folder.path("new"))), fails(3, "cannot write"));
  EXPECT_EQ(run_limited("-f 2", evidence(copy, "--force --seed 3")).status, 3);
  EXPECT_EQ(content_of(copy + "/SHA256SUMS"), before);
  EXPECT_EQ(names_in(folder.path("")), std::set<std::string>{"copy"});
}

TEST_F(Evidence, WrongUsage_IsNamed) {
  const std::string target = folder.path("target");
  const auto refused = [&](const Words& more, const std::string& what) {
    EXPECT_THAT(run(Words("safety evidence") + more), refuses(2, what));
  };
  refused({}, "-o DIR");
  refused({"-o", target}, "--format");
  refused(Words("-f fs-36-29 -o {}", target), "fs-36-29");
  refused(Words("-f resolute-26 -o {}", target), "not the format of a control and a safety word");
  refused("-f fs-36-28", "-o DIR");
  refused(Words("-f {} -o {} --ber 0.7", safety_pair, target), "--ber");
  refused(Words("-f {} -o {} --compare-bits 11", safety_pair, target), "--compare-bits");
  refused(Words("-f {} -o {} --start-frames 1", safety_pair, target), "--start-frames");
  refused(Words("-f {} -o {} --watchdog 3ms", safety_pair, target), "--watchdog");
  refused(Words("-f {} -o {} --budget 5", safety_pair, target), "--budget");
  refused(Words("-f {} -o {} --rate 200kHz", safety_pair, target), "the line model");
  refused(Words("-f {} -o {} --counter count_2_63", safety_pair, target), "--counter");
  refused(Words("--check {} -o {}", bundle(), target), "--check");
  refused(Words("--check {} -f {}", bundle(), safety_pair), "--check");
  refused({"-f", safety_pair, "--force"}, "--force");
  EXPECT_EQ(folder.files(), 0U);
}

}  // namespace biss::verbs::evidence_test
