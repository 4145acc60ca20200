// The help of every verb: it names existing items, fits the width, and its examples work.
#include <sys/wait.h>

#include <regex>

#include "tests/cli/run_command.hpp"

namespace biss::verbs::help_test {

Words lines_of(const std::string& text) {
  std::istringstream stream(text);
  Words lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

std::string help_of(Words verb) {
  verb.emplace_back("--help");
  const Outcome outcome = run_ok(verb);
  EXPECT_EQ(outcome.err, "");
  return outcome.out;
}

// The lines below a heading, up to the next empty one.
Words section(const std::string& help, const std::regex& heading) {
  Words lines;
  bool inside = false;
  for (const std::string& line : lines_of(help)) {
    if (inside && line.empty()) break;
    if (inside) lines.push_back(line);
    inside = inside || std::regex_match(line, heading);
  }
  return lines;
}

void collect(const Words& verb, std::vector<Words>& all) {
  all.push_back(verb);
  for (const std::string& line : section(help_of(verb), std::regex("Verbs:"))) {
    if (line.size() < 3 || line[2] == ' ') continue;
    Words below = verb;
    below.push_back(line.substr(2, line.find(' ', 2) - 2));
    collect(below, all);
  }
}

// The command itself, then every verb, such as {"eds", "show"}.
const std::vector<Words>& all_verbs() {
  static const std::vector<Words> all = [] {
    std::vector<Words> verbs;
    collect({}, verbs);
    return verbs;
  }();
  return all;
}

std::string joined(const Words& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : " ") + word;
  return text;
}

// The options in a help text, such as `--clock`.
Words options_of(const std::string& help) {
  Words options;
  const std::regex option("\n  (?:-[A-Za-z], )?(--[a-z-]+)");
  for (std::sregex_iterator at(help.begin(), help.end(), option), end; at != end; ++at) {
    options.push_back((*at)[1]);
  }
  return options;
}

TEST(Help, EveryVerb_IsReachedAndFits) {
  EXPECT_GT(all_verbs().size(), 15U);
  for (const Words& verb : all_verbs()) {
    SCOPED_TRACE(joined(verb));
    const std::string help = help_of(verb);
    EXPECT_THAT(help, testing::HasSubstr("\nUsage: biss"));
    EXPECT_EQ(help.find("Excludes"), std::string::npos) << help;
    for (const std::string& line : lines_of(help)) {
      if (line.starts_with("  biss ")) continue;  // examples are not wrapped
      EXPECT_LE(line.size(), 100U) << line;
    }
    Words asked = Words("help") + verb;
    EXPECT_EQ(run(asked).out, help);
  }
}

TEST(Help, UnknownVerb_IsWrongUsage) {
  EXPECT_THAT(
      run("help deocde"),
      fails(2, testing::Eq(
                   "biss: unknown verb 'deocde'; did you mean 'decode'? (see 'biss --help')\n")));
}

TEST(Help, Version_HasAShortOption) {
  const Outcome outcome = run_ok("-V");
  EXPECT_EQ(outcome.out, run("--version").out);
  EXPECT_TRUE(std::regex_match(outcome.out,
                               std::regex("biss \\d+\\.\\d+\\.\\d+( [0-9a-f]{40}(-dirty)?)?\n")));
}

// The files named in the examples, made by the command itself.
class ExampleFolder {
 public:
  ExampleFolder() {
    std::filesystem::create_directory(path("captures"));
    folder_.file("encoder.eds",
                 "[registers]\nEDS_BANK = 2\nMFR_ID = 0x6943\n"
                 "[common]\nTMA = 100ns\nTBUSY_MAX = 10us?\nTO_MAX = 20us?\n"
                 "[bp3]\nPON_PDL = 50ms\nMT_LEN = 12\nMT_CNT = 4096\nFI_LEN = 18\nSIP_CNT = 1\n"
                 "SIP_RES = 262144\n");
    for (const char* command :
         {"eds build encoder.eds -o encoder.hex", "eds build encoder.eds -o registers.hex",
          "eds build encoder.eds -o old.bin", "eds build encoder.eds -o new.bin",
          "eds build encoder.eds -o eeprom.bin",
          "simulate --registers encoder.hex -f pos26,nE,nW,crc6 --access read:0x78,8 -o "
          "capture.vcd",
          "simulate --registers encoder.hex -f pos26,nE,nW,crc6 --access read:0x78,8 -o capture.sr",
          "simulate -f resolute-32 -o capture.csv", "simulate -f fs-36-28 -o both.csv",
          "simulate -f resolute-26 --sample-rate 100MHz -o samples.bin",
          "simulate -f pos26,nE,nW,crc6 -o master.vcd", "simulate -f resolute-26 -o good.vcd",
          "simulate -f resolute-26 --clock 2MHz -o bad.vcd",
          "safety campaign -f fs-36-28 --frames 5000 --shard 2/7 --state part2.json",
          "simulate -f resolute-26 -o captures/a.vcd",
          "archive captures --shard 1/2 -o shard1.json",
          "archive captures --shard 2/2 -o shard2.json"}) {
      EXPECT_LE(status_of(std::string("biss ") + command), 1) << command << '\n' << error();
    }
    // One line for each file, each with its own name.
    one_line(folder_, "ma.csv", "MA", path("both.csv"), "D0");
    one_line(folder_, "slo.csv", "SLO", path("both.csv"), "D1");
    // SLO at bit 3.
    std::string samples = content_of(path("samples.bin"));
    for (char& sample : samples) sample = static_cast<char>((sample & 1) | (sample & 2) << 2);
    folder_.file("samples.bin", samples);
    folder_.file("page.html", R"(<script type="text/plain" id="biss-core">CORE</script>)");
    folder_.file("positions.txt", "1000\n0x2A\n");
    folder_.file("adapter.log", "0.1ms: B0 00 12 34 5C\n");
    // Only the bank of the profile's part.
    folder_.file("bank3.bin", content_of(path("eeprom.bin")).substr(3 * 64, 64));
  }

  std::string path(const std::string& name) const { return folder_.path(name); }

  /// Runs a line as a shell does, in the folder.
  int status_of(const std::string& line) const {
    const std::filesystem::path command(BISS_COMMAND);
    const std::string all = "cd '" + path("") + "' && PATH='" + command.parent_path().string() +
                            "':\"$PATH\" && " + line + " >out 2>error";
    const int status = std::system(all.c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }
  std::string error() const { return content_of(path("error")); }

 private:
  Folder folder_;
};

// With a page of the folder; a server runs until it has printed its address, on any free port.
std::string with_page(const std::string& example) {
  if (example.starts_with("biss report ")) return example + " --page page.html";
  if (!example.starts_with("biss view ")) return example;
  static const std::regex port(" --port \\d+");
  return "{ " + std::regex_replace(example, port, "") +
         " --no-open --page page.html & server=$!; for i in $(seq 400); do [ -s out ] && break; "
         "sleep 0.05; done; kill $server; wait $server; }";
}

// An emulated device runs until it is ready, and for a command to it until the answer is there.
std::string with_device(const std::string& example) {
  const std::string wait = "for i in $(seq 400); do [ -s ready ] && break; sleep 0.05; done; ";
  const std::string end = "; status=$?; kill $device; wait $device && exit $status; }";
  if (example.starts_with("biss emulate ctl ")) {
    return "{ rm -f ready; biss emulate -f resolute-26 --at device --ctl ctl.socket > ready & "
           "device=$!; " +
           wait + example + end;
  }
  if (example.find("--ma-pin mosi") != std::string::npos) {
    return "biss emulate --registers encoder.hex --ma mosi -- " + example;
  }
  if (example.starts_with("biss read ") || example.starts_with("biss watch --port "))
    return "biss emulate -f resolute-26 -- " + example;
  if (example.find(" --at ") == std::string::npos) {
    return std::regex_replace(example, std::regex(" -- python3 read.py"), " -- true");
  }
  return "{ rm -f ready; " + example + " > ready & device=$!; " + wait + "[ -s ready ]" + end;
}

bool has_fuse() { return run("emulate -f resolute-26 -- true").status == 0; }

// Verbs with millions of counts run in a fraction of a second here.
std::string shortened(const std::string& example) {
  static const std::regex counted("biss safety (campaign -f|sequences|evidence -f)");
  if (!std::regex_search(example, counted)) return example;
  std::string line = example;
  const auto set = [&line](const std::string& option, const std::string& value) {
    const std::regex given(option + " \\d+");
    if (std::regex_search(line, given)) {
      line = std::regex_replace(line, given, option + ' ' + value);
    } else {
      line += ' ' + option + ' ' + value;
    }
  };
  set("--frames", "5000");
  if (line.find("sequences") != std::string::npos || line.find("evidence") != std::string::npos) {
    set("--faults", "200");
  }
  if (line.find("evidence") != std::string::npos) set("--cycles", "300");
  return line;
}

TEST(Help, EveryExample_Works) {
  const ExampleFolder folder;
  std::size_t examples = 0;
  const bool fuse = has_fuse();
  if (!fuse)
    std::puts("FUSE cannot be mounted here: the examples of biss emulate and biss read do not run");
  for (const Words& verb : all_verbs()) {
    for (const std::string& line : section(help_of(verb), std::regex("Examples?:"))) {
      ASSERT_TRUE(line.starts_with("  biss ")) << line;
      const bool emulates = line.starts_with("  biss emulate ") ||
                            line.starts_with("  biss read ") ||
                            line.starts_with("  biss watch --port ");
      if (emulates && !fuse) continue;
      const std::string example =
          emulates ? with_device(line.substr(2)) : with_page(shortened(line.substr(2)));
      SCOPED_TRACE(example);
      ++examples;
      // Exit status 1: a judgement of the data, with its reason in the output.
      EXPECT_LE(folder.status_of(example), 1) << folder.error();
    }
  }
  EXPECT_GT(examples, 30U);
}

TEST(Help, ManualPage_HasEveryVerbOptionAndExample) {
  const Outcome outcome = run_ok("help --to man");
  const std::string page = std::regex_replace(outcome.out, std::regex("\\\\-"), "-");
  for (const Words& verb : all_verbs()) {
    SCOPED_TRACE(joined(verb));
    const std::string help = help_of(verb);
    const std::string title = ".SS biss " + joined(verb) + '\n';
    std::size_t at = verb.empty() ? page.find(".SH OPTIONS") : page.find(title);
    ASSERT_NE(at, std::string::npos);
    const std::string part = page.substr(at, page.find("\n.S", at + 1) - at);
    for (const std::string& option : options_of(help)) {
      if (option == "--help" && !verb.empty()) continue;
      EXPECT_THAT(part, testing::HasSubstr(option)) << option;
    }
    for (const std::string& example : section(help, std::regex("Examples?:"))) {
      if (!verb.empty()) {
        EXPECT_THAT(part, testing::HasSubstr(example.substr(2))) << example;
      }
    }
  }
}

// The completions of bash for the last word of a line.
Words completions(const std::string& line) {
  const Folder folder;
  const std::string script = folder.path("biss.bash");
  run_ok("help --to bash -o {}", script);
  std::string call;
  Words words;
  std::istringstream stream(line);
  for (std::string word; stream >> word;) words.push_back(word);
  if (line.ends_with(' ')) words.emplace_back();
  for (const std::string& word : words) call += " '" + word + "'";
  const std::string test = folder.file(
      "test.bash", "PATH='" + std::filesystem::path(BISS_COMMAND).parent_path().string() +
                       "':\"$PATH\"\n. '" + script + "'\nCOMP_WORDS=(" + call +
                       ")\nCOMP_CWORD=$((${#COMP_WORDS[@]} - 1))\n_biss\nprintf '%s\\n' "
                       "\"${COMPREPLY[@]}\"\n");
  const std::string out = folder.path("out");
  EXPECT_EQ(std::system(("bash '" + test + "' >'" + out + "'").c_str()), 0);
  return lines_of(content_of(out));
}

TEST(Help, Completion_OffersVerbsOptionsAndValues) {
  EXPECT_EQ(completions("biss dec"), (Words{"decode"}));
  EXPECT_EQ(completions("biss eds sh"), (Words{"show"}));
  EXPECT_EQ(completions("biss decode --to j"), (Words{"jsonl"}));
  EXPECT_EQ(completions("biss plan -f resolute-3"), (Words{"resolute-32"}));
  EXPECT_EQ(completions("biss safety campaign m"), (Words{"merge"}));
  for (const Words& verb : all_verbs()) {
    SCOPED_TRACE(joined(verb));
    const Words offered = completions("biss " + joined(verb) + (verb.empty() ? "--" : " --"));
    for (const std::string& option : options_of(help_of(verb))) {
      EXPECT_TRUE(std::find(offered.begin(), offered.end(), option) != offered.end()) << option;
    }
  }
}

TEST(Readme, Example_ShowsTheRowsOfTheCommand) {
  const Folder folder;
  const std::string capture = folder.path("line.vcd");
  run_ok(
      "simulate -f resolute-26 --clock 10MHz --cable 50m --cycles 6 --fault flip@3 --fault "
      "no_answer@5 --seed 3 -o {}",
      capture);
  const std::string shown = run("decode {} -f resolute-26", capture).out;
  const std::string readme = content_of(BISS_SOURCE_FOLDER "/README.md");
  const std::size_t begin = readme.find("$ build/biss decode line.vcd -f resolute-26\n");
  ASSERT_NE(begin, std::string::npos);
  const std::size_t end = readme.find("line.vcd: 6 request cycles", begin);
  // The table of the page is narrower by its last columns.
  const Words lines = lines_of(readme.substr(begin, end - begin));
  ASSERT_EQ(lines.size(), 10U);
  for (std::size_t i = 1; i < lines.size(); ++i) {
    EXPECT_NE(shown.find(lines[i]), std::string::npos) << lines[i];
  }
}

}  // namespace biss::verbs::help_test
