// `biss archive`: what the summary says of each file, and that it depends on the files alone.
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <nlohmann/json.hpp>

#include "tests/archive/archive_folder.hpp"
#include "tests/cli/run_command.hpp"

namespace biss::verbs::archive_test {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using testing::HasSubstr;

class Archive : public testing::Test {
 protected:
  Archive() { fs::create_directory(captures()); }

  std::string captures() const { return folder_.path("captures"); }
  std::string path(const std::string& name) const { return folder_.path(name); }

  // A capture below the folder of captures.
  std::string simulated(const std::string& name, const Words& options) const {
    const fs::path file = fs::path(captures()) / name;
    fs::create_directories(file.parent_path());
    Words arguments("simulate --seed 4 -o {}", file.string());
    for (const Words& usual :
         {Words("--cycles 60"), Words("--clock 5MHz"), Words("--motion sine")}) {
      if (std::find(options.begin(), options.end(), usual[0]) == options.end()) {
        arguments = arguments + usual;
      }
    }
    run_ok(arguments + options);
    return file.string();
  }
  void put(const std::string& name, std::string_view content) const {
    const fs::path file = fs::path(captures()) / name;
    fs::create_directories(file.parent_path());
    std::ofstream(file, std::ios::binary) << content;
  }

  Json summary(const Words& more = {}) const { return summary_of_folder(captures(), more); }
  Json summary_of_folder(const std::string& folder, const Words& more = {}) const {
    outcome_ = run(Words("archive {} -o {} --worst 0", folder, path("summary.json")) + more);
    return Json::parse(content_of(path("summary.json")), nullptr, false);
  }

  // The entry of a file of the summary, by the end of its path.
  static Json entry_of(const Json& summary, const std::string& name) {
    for (const Json& file : summary["files"]) {
      if (file["file"].get<std::string>().ends_with(name)) return file;
    }
    ADD_FAILURE() << name << " is not in " << summary.dump();
    return {};
  }
  static std::string cause_of(const Json& summary, const std::string& name) {
    return entry_of(summary, name).value("cause", "");
  }

  Outcome merge(const Words& parts) const {
    return run(Words("archive merge -o {}", path("merged.json")) + parts);
  }
  std::string shard(const std::string& number, const Words& more = {}) const {
    std::string part = path("part" + number.substr(0, number.find('/')) + ".json");
    run_ok(Words("archive {} --shard {} -o {}", captures(), number, part) + more);
    return part;
  }

  Folder folder_;
  mutable Outcome outcome_;
};

TEST_F(Archive, Capture_HasTheFiguresOfDecode) {
  const Words format{"-f", "resolute-26"};
  const std::string file =
      simulated("axis/a.vcd", "-f resolute-26 --fault flip:0.2 --fault nE:0.2");
  const auto rows = rows_of(run("decode {} --to csv -f resolute-26", file).out);
  const Json link = entry_of(summary(format), "a.vcd")["links"][0];
  EXPECT_EQ(outcome_.status, 0) << outcome_.err;
  EXPECT_EQ(link["format"], "pos26,nE,nW,crc6;cds0");
  EXPECT_EQ(link["cycles"], rows.size());
  const auto count = [&](const std::string& column, const std::string& value) {
    return std::count_if(rows.begin(), rows.end(),
                         [&](const Row& row) { return row.at(column) == value; });
  };
  EXPECT_GT(count("status", "crc"), 2);
  EXPECT_EQ(link["status"]["crc"], count("status", "crc"));
  EXPECT_EQ(link["status"]["ok"], count("status", "ok"));
  EXPECT_GT(count("nE", "0"), 2);
  EXPECT_EQ(link["errors"], count("nE", "0"));
  const double delay = std::stod(rows.front().at("line_delay_ns"));
  EXPECT_EQ(link["line_delay_ps"][1], std::llround(1000 * delay));
  EXPECT_EQ(link["period_ps"], Json::array({200000, 200000, 200000}));
}

TEST_F(Archive, FileThatIsNoCapture_HasItsCause) {
  const std::string whole = content_of(simulated("good.vcd", "-f resolute-26"));
  const std::string session = content_of(simulated("good.sr", "-f resolute-26"));
  fs::remove(fs::path(captures()) / "good.sr");
  put("cut.vcd", std::string_view(whole).substr(0, whole.find("\n#", whole.size() / 2) + 3));
  put("cut.sr", std::string_view(session).substr(0, session.size() / 2));
  put("empty.vcd", "");
  put("notes.txt", "axis x was replaced\n");
  put("samples.bin", "\1\2\3\4");
  put("still.csv", "time_ns,MA,SLO\n0,1,1\n1000,1,1\n");
  put("other.csv", "time_ns,a,b\n0,1,1\n10,0,1\n20,1,1\n");
  put("numbers.csv", "axis,comment\nx,replaced\n");
  const Json json = summary();
  EXPECT_EQ(outcome_.status, 0) << outcome_.err;
  EXPECT_EQ(cause_of(json, "good.vcd"), "");
  EXPECT_EQ(cause_of(json, "cut.vcd"), "truncated");
  EXPECT_EQ(entry_of(json, "cut.vcd")["read"], "part");
  EXPECT_GT(entry_of(json, "cut.vcd")["links"][0]["cycles"], 20);
  EXPECT_EQ(cause_of(json, "cut.sr"), "damaged");
  EXPECT_EQ(cause_of(json, "empty.vcd"), "empty");
  EXPECT_EQ(cause_of(json, "notes.txt"), "unknown_format");
  EXPECT_EQ(cause_of(json, "samples.bin"), "layout_missing");
  EXPECT_EQ(cause_of(json, "still.csv"), "no_cycle");
  EXPECT_EQ(cause_of(json, "other.csv"), "no_lines");
  EXPECT_EQ(cause_of(json, "numbers.csv"), "malformed");
  EXPECT_EQ(json["totals"]["files"], 9);
  EXPECT_EQ(json["causes"]["truncated"], 1);
}

TEST_F(Archive, LinksPipesAndDeepFolders_AreNamedAndNotFollowed) {
  simulated("m1/a.csv", "-f resolute-26");
  const fs::path root = captures();
  fs::create_directory_symlink("..", root / "m1" / "up");
  fs::create_directory_symlink(".", root / "self");
  fs::create_symlink("m1/a.csv", root / "again.csv");
  fs::create_symlink("nowhere", root / "broken");
  fs::create_symlink("circle", root / "circle");
  ASSERT_EQ(mkfifo((root / "pipe.vcd").c_str(), 0600), 0);
  // Outside, and reached by two links.
  fs::create_directory(folder_.path("store"));
  fs::copy_file(root / "m1" / "a.csv", fs::path(folder_.path("store")) / "b.csv");
  fs::create_directory_symlink("../store", root / "store1");
  fs::create_directory_symlink("../store", root / "store2");
  // A folder whose path is longer than the system allows.
  int folder = open(root.c_str(), O_RDONLY | O_DIRECTORY);
  const std::string name(250, 'd');
  for (int depth = 0; depth < 18; ++depth) {
    ASSERT_EQ(mkdirat(folder, name.c_str(), 0700), 0);
    const int inner = openat(folder, name.c_str(), O_RDONLY | O_DIRECTORY);
    close(folder);
    folder = inner;
  }
  close(folder);
  const Json json = summary();
  EXPECT_EQ(outcome_.status, 0) << outcome_.err;
  EXPECT_EQ(cause_of(json, "m1/a.csv"), "");
  EXPECT_EQ(cause_of(json, "store1/b.csv"), "");
  EXPECT_EQ(cause_of(json, "/store2"), "link");
  EXPECT_EQ(cause_of(json, "m1/up"), "link");
  EXPECT_EQ(cause_of(json, "/self"), "link");
  EXPECT_EQ(cause_of(json, "again.csv"), "link");
  EXPECT_EQ(cause_of(json, "/broken"), "broken_link");
  EXPECT_EQ(cause_of(json, "/circle"), "broken_link");
  EXPECT_EQ(cause_of(json, "pipe.vcd"), "not_a_file");
  EXPECT_EQ(json["totals"]["cycles"], 120);
  EXPECT_TRUE(json["causes"].contains("cannot_open") ||
              json["causes"].contains("folder_unreadable"))
      << json["causes"];
}

TEST_F(Archive, NameThatIsNoUtf8_IsShownByItsBytes) {
  const std::string file = simulated("a.csv", "-f resolute-26");
  fs::rename(file, fs::path(captures()) / "a\xE9.csv");
  const Json json = summary();
  EXPECT_EQ(outcome_.status, 0) << outcome_.err;
  EXPECT_EQ(cause_of(json, "a\\xE9.csv"), "");
  const std::string before = content_of(path("summary.json"));
  summary();
  EXPECT_EQ(content_of(path("summary.json")), before);
}

TEST_F(Archive, SeveralEncodersInACapture_AreAllRead) {
  const std::string first = simulated("a.csv", "-f pos26,nE,nW,crc6");
  std::string text = "time_ns,MA1,SLO1,MA2,SLO2\n";
  for (const Row& row : rows_of(content_of(first))) {
    const std::string levels = ',' + row.at("MA") + ',' + row.at("SLO");
    text += row.at("time_ns") + levels + levels + '\n';
  }
  fs::remove(first);
  put("two.csv", text);
  const Json json = summary();
  EXPECT_EQ(entry_of(json, "two.csv")["links"].size(), 2U) << json.dump(1);
  EXPECT_EQ(json["encoders"].size(), 2U);
  EXPECT_EQ(json["totals"]["cycles"], 120);
}

TEST_F(Archive, WorstFiles_ComeFirst) {
  simulated("good.csv", "-f resolute-26");
  simulated("worse.csv", "-f resolute-26 --fault flip:0.3");
  simulated("bad.csv", "-f resolute-26 --fault flip:0.1");
  simulated("flags.csv", "-f resolute-26 --fault nE@7");
  simulated("still.csv", "-f resolute-26 --motion constant");
  put("empty.vcd", "");
  put("a.txt", "no capture");
  const Json json = summary();
  Words names;
  for (const Json& file : json["files"]) {
    names.push_back(fs::path(file["file"].get<std::string>()).filename());
  }
  EXPECT_THAT(names, testing::ElementsAre("worse.csv", "bad.csv", "flags.csv", "empty.vcd",
                                          "still.csv", "good.csv", "a.txt"));
  const Outcome table = run("archive {} --to jsonl --worst 2", captures());
  const std::size_t end = table.out.find('\n');
  EXPECT_EQ(std::count(table.out.begin(), table.out.end(), '\n'), 2);
  const Json row = Json::parse(table.out.substr(0, end));
  EXPECT_THAT(row["file"].get<std::string>(), HasSubstr("worse.csv"));
  EXPECT_EQ(row["cause"], "crc");
  EXPECT_EQ(row["faults"], json["files"][0]["links"][0]["faults"]);
  EXPECT_THAT(table.err, HasSubstr("archive: 7 files, 5 read, 0 in part, 2 not read\n"));
}

TEST_F(Archive, LineDelayOverDates_IsADrift) {
  // 1 ns of line delay in 10 cm: 10 ns a month of 30 days.
  for (const int metres : {20, 21, 22, 23}) {
    const int day = 30 * (metres - 20);
    const std::string date = fmt::format("2023-{:02}-{:02}", 1 + day / 30, 1);
    simulated("axis/" + date + ".csv",
              {"-f", "resolute-26", "--cable", fmt::format("{}m", metres)});
  }
  const Json json = summary();
  const Json encoder = json["encoders"][0];
  ASSERT_EQ(encoder["days"].size(), 4U);
  EXPECT_EQ(encoder["days"][2]["date"], "2023-03-01");
  EXPECT_EQ(encoder["days"][2]["cycles"], 60);
  const std::int64_t delay = encoder["days"][2]["line_delay_ps"];
  EXPECT_EQ(delay - encoder["days"][0]["line_delay_ps"].get<std::int64_t>(), 20'000);
  // January to April: 90 days, 30 ns.
  EXPECT_NEAR(encoder["drift"]["line_delay_ps_per_year"].get<double>(), 30'000.0 / 90 * 365, 3'000);
  EXPECT_EQ(encoder["drift"]["ack_ps_per_year"], 0);
  EXPECT_EQ(encoder["line_delay_ps"]["count"], 240);
  EXPECT_THAT(outcome_.err, HasSubstr("a year"));
}

TEST_F(Archive, OutputInTheFolder_IsNoCapture) {
  simulated("a.csv", "-f resolute-26");
  const std::string output = captures() + "/summary.json";
  run_ok("archive {} -o {}", captures(), output);
  const std::string first = content_of(output);
  run_ok("archive {} -o {}", captures(), output);
  EXPECT_EQ(content_of(output), first);
  EXPECT_EQ(Json::parse(first)["list"]["files"], 1);
}

TEST_F(Archive, OutputOntoACapture_IsRefusedAndLeavesIt) {
  const std::string capture = simulated("a.csv", "-f resolute-26");
  simulated("b.csv", "-f resolute-26");
  const std::string before = content_of(capture);
  fs::create_hard_link(capture, path("hard.json"));
  fs::create_symlink(capture, path("link.json"));
  for (const std::string& output : {capture, path("hard.json"), path("link.json")}) {
    EXPECT_THAT(run("archive {} -o {}", captures(), output), fails(2, "are the same file"))
        << output;
    EXPECT_EQ(content_of(capture), before);
  }
  EXPECT_FALSE(fs::exists(capture + ".journal"));
  // Only a name that ends in .json or .journal is looked at as a file of this program.
  const Words named{"archive", captures(), "-o", captures() + "/summary.txt"};
  run_ok(named);
  EXPECT_EQ(run(named).status, 2) << "its own summary would be a file of the archive";
}

TEST_F(Archive, ThreadsAndShards_GiveTheSameSummary) {
  const ArchiveFolder archive(60);
  const std::string one = summary_of(archive, "1");
  EXPECT_EQ(summary_of(archive, "2"), one);
  EXPECT_EQ(summary_of(archive, "7"), one);
  EXPECT_EQ(merged_summary_of(archive, 7), one);
  EXPECT_EQ(merged_summary_of(archive, 17), one);
  EXPECT_EQ(Json::parse(one)["totals"]["files"], 60);
}

// All threads read it together.
TEST_F(Archive, FileLargerThanAllOthers_HasTheSameFiguresForAnyThreads) {
  const std::string large = simulated("large.vcd", "-f resolute-26 --cycles 1500 --fault flip:0.1");
  simulated("small.csv", "-f resolute-26");
  simulated("small.sr", "-f resolute-32");
  ASSERT_GT(fs::file_size(large), 1U << 20U);
  const Json one = summary("--threads 1");
  EXPECT_EQ(one["totals"]["files"], 3);
  for (const char* threads : {"2", "3", "7"}) {
    fs::remove(path("summary.json.journal"));
    EXPECT_EQ(summary({"--threads", threads}), one) << threads;
  }
}

TEST_F(Archive, KilledAtRandom_IsResumed) {
  const ArchiveFolder archive(60);
  EXPECT_GT(kill_and_resume(archive, 5, 1), 0);
}

TEST_F(Archive, ChangedFile_IsReadAgain) {
  simulated("a.csv", "-f resolute-26");
  const std::string changed = simulated("b.csv", "-f resolute-26");
  summary();
  const std::string journal = path("summary.json.journal");
  const auto size = fs::file_size(journal);
  const Json same = summary();
  EXPECT_EQ(fs::file_size(journal), size);
  simulated("b.csv", "-f resolute-26 --fault flip:0.4");
  // Also where the size did not change.
  fs::last_write_time(changed, fs::last_write_time(changed) + std::chrono::seconds(3));
  const Json json = summary();
  EXPECT_GT(fs::file_size(journal), size);
  EXPECT_GT(entry_of(json, "b.csv")["links"][0]["faults"], 10);
  EXPECT_EQ(entry_of(json, "a.csv"), entry_of(same, "a.csv"));
  fs::remove(changed);
  EXPECT_EQ(summary()["totals"]["files"], 1);
}

TEST_F(Archive, OtherOptions_UseNothingOfTheJournal) {
  simulated("a.csv", "-f resolute-26");
  EXPECT_EQ(summary()["settings"], Json::array());
  const Json json = summary("-f pos24,nE,nW,crc6");
  EXPECT_EQ(json["settings"], Json::array({"--format pos24,nE,nW,crc6"}));
  EXPECT_EQ(entry_of(json, "a.csv")["links"][0]["other_format"], "pos26,nE,nW,crc6;cds0");
  EXPECT_EQ(entry_of(json, "a.csv")["links"][0]["status"]["ok"], nullptr);
  EXPECT_EQ(summary()["totals"]["status"]["ok"], 60);
}

TEST_F(Archive, DamagedJournal_CostsOnlyTheLinesThatAreDamaged) {
  for (const char* name : {"a.csv", "b.csv", "c.csv"}) simulated(name, "-f resolute-26");
  summary();
  const std::string before = content_of(path("summary.json"));
  const std::string journal = path("summary.json.journal");
  const std::string lines = content_of(journal);
  for (const std::size_t bytes :
       {std::size_t{0}, std::size_t{5}, std::size_t{30}, lines.size() / 2, lines.size() - 1}) {
    std::ofstream(journal, std::ios::binary) << lines.substr(0, bytes);
    summary();
    EXPECT_EQ(outcome_.status, 0) << outcome_.err;
    EXPECT_EQ(content_of(path("summary.json")), before) << bytes;
    EXPECT_EQ(content_of(journal).size(), lines.size()) << bytes;
  }
  std::string flipped = lines;
  flipped[lines.size() / 2] ^= 4;
  std::ofstream(journal, std::ios::binary) << flipped;
  summary();
  EXPECT_EQ(content_of(path("summary.json")), before);
}

TEST_F(Archive, FileThatIsNoJournal_IsNotOverwritten) {
  simulated("a.csv", "-f resolute-26");
  const std::string text = folder_.file("summary.json.journal", "my diary\n");
  summary();
  EXPECT_EQ(outcome_.status, 3);
  EXPECT_THAT(outcome_.err, HasSubstr("not a journal of biss archive"));
  EXPECT_EQ(content_of(text), "my diary\n");
  EXPECT_FALSE(fs::exists(path("summary.json")));
}

TEST_F(Archive, SecondRunWithTheSameOutput_IsRefused) {
  simulated("a.csv", "-f resolute-26");
  const std::string journal = folder_.file("summary.json.journal", "");
  const int file = open(journal.c_str(), O_RDWR);
  ASSERT_EQ(flock(file, LOCK_EX), 0);
  summary();
  EXPECT_EQ(outcome_.status, 3);
  EXPECT_THAT(outcome_.err, HasSubstr("another run is writing it"));
  close(file);
  summary();
  EXPECT_EQ(outcome_.status, 0);
}

TEST_F(Archive, MissingShard_IsNamedAndCanBeAddedLater) {
  for (const char* name : {"a.csv", "b.csv", "c.csv", "d.csv"}) {
    simulated(name, "-f resolute-26");
  }
  summary();
  const std::string whole = content_of(path("summary.json"));
  const Words parts{shard("1/3"), shard("2/3"), shard("3/3")};
  EXPECT_THAT(merge({parts[2], parts[0]}), fails(1, "biss: shards are missing: 2 of 3; run them"));
  EXPECT_EQ(Json::parse(content_of(path("merged.json")))["shards"]["done"], Json::array({1, 3}));
  fs::rename(path("merged.json"), path("two.json"));
  EXPECT_EQ(merge({path("two.json"), parts[1]}).status, 0);
  EXPECT_EQ(content_of(path("merged.json")), whole);
}

TEST_F(Archive, TwoFolders_AddUpToBoth) {
  simulated("m1/a.csv", "-f resolute-26");
  simulated("m2/b.csv", "-f resolute-32 --fault flip:0.3");
  const std::string m1 = captures() + "/m1";
  const std::string m2 = captures() + "/m2";
  run_ok("archive {} -o {}", m1, path("1.json"));
  run_ok("archive {} -o {}", m2, path("2.json"));
  run_ok("archive {} {} {} {} -o {}", m1, m2, m1, captures() + "/./m1", path("both.json"));
  EXPECT_EQ(merge({path("2.json"), path("1.json")}).status, 0);
  EXPECT_EQ(content_of(path("merged.json")), content_of(path("both.json")));
  EXPECT_THAT(merge({path("1.json"), path("both.json")}),
              fails(3, "this file is in two of the summaries"));
}

TEST_F(Archive, PartsThatDoNotFit_AreRefusedWithTheCause) {
  simulated("a.csv", "-f resolute-26");
  simulated("b.csv", "-f resolute-26");
  const std::string first = shard("1/2");
  const std::string second = shard("2/2");
  const auto refused = [&](const Words& parts, const std::string& cause) {
    EXPECT_THAT(merge(parts), fails(3, cause)) << cause;
    EXPECT_FALSE(fs::exists(path("merged.json")));
  };
  refused({first, first, second}, "shard 1 of 2 is in an earlier file too");
  refused({first, shard("2/2", "-f resolute-26")}, "made with other options than");
  shard("2/2");
  simulated("c.csv", "-f resolute-26");
  refused({first, shard("2/2")},
          "the shards are from different lists of files, or some are missing");
  refused({path("none.json")}, "cannot open it");
  refused({folder_.file("text.json", "hello")}, "it is not JSON, or ends early");
  refused({folder_.file("other.json", "{}")}, "it is not a summary of biss archive");
  const std::string text = content_of(first);
  refused({folder_.file("cut.json", text.substr(0, text.size() - 10))}, "ends early");
  const auto edited = [&](const std::string& from, const std::string& to) {
    std::string changed = text;
    const std::size_t at = changed.rfind(from);
    EXPECT_NE(at, std::string::npos) << from;
    changed.replace(at, from.size(), to);
    return folder_.file("edited.json", changed);
  };
  refused({edited("\"ok\":60", "\"ok\":61")}, "'status' has more cycles than 'cycles'");
  refused({edited("\"cycles\":60", "\"cycles\":61")}, "'status' has fewer cycles than 'cycles'");
  refused({edited("\"warnings\":0", "\"warnings\":1")},
          "the figures of its encoders are not the sums of its files");
  refused({edited("\"count\":2", "\"count\":1")}, "it has 1 files, its shards have 2");
  refused({edited("\"biss_archive\":1", "\"biss_archive\":2")}, "this program reads version 1");
  refused({edited("\"read\":\"whole\"", "\"read\":\"half\"")}, "'read' is \"half\"");
}

TEST_F(Archive, NothingToRead_IsOneLine) {
  const auto refused = [&](const Words& more, int status, const std::string& cause) {
    EXPECT_THAT(run(Words("archive") + more), fails(status, cause));
  };
  refused({}, 2, "no folder given");
  refused({"-"}, 2, "standard input is not a folder");
  refused({captures(), "--shard", "0/3"}, 2, "--shard");
  refused({captures(), "--shard", "4/3"}, 2, "--shard");
  refused({captures(), "-f", "pos0"}, 2, "pos0");
  refused({path("nowhere")}, 3, "No such file or directory");
  refused({captures()}, 1, "no file has a request cycle");
  refused({"merge"}, 2, "FILE");
}

TEST_F(Archive, ListOfFiles_IsReadAsTheFolder) {
  const std::string a = simulated("a.csv", "-f resolute-26");
  const std::string b = simulated("m/b.csv", "-f resolute-26");
  summary();
  const std::string whole = content_of(path("summary.json"));
  const std::string list = folder_.file("list.txt", b + "\n" + a + "\n");
  run_ok("archive --files-from {} -o {}", list, path("list.json"));
  EXPECT_EQ(content_of(path("list.json")), whole);
}

TEST_F(Archive, ListOfFoldersAndWhatIsInThem_HasEachFileOnce) {
  for (const char* name : {"m/a.csv", "m/n/b.csv", "m-2/c.csv", "m.csv"}) {
    simulated(name, "-f resolute-26");
  }
  const std::string m = captures() + "/m";
  fs::create_symlink(m + "/n", captures() + "/m-2/inside");
  fs::create_symlink(captures(), captures() + "/m-2/around");
  const std::string list =
      folder_.file("list.txt", m + "/n/b.csv\n" + m + "/n\n" + m + "/\n" + m + "\n" + captures() +
                                   "/m-2\n" + captures() + "/m.csv\n" + m + "/a.csv\n");
  run_ok("archive --files-from {} -o {}", list, path("list.json"));
  const Json json = Json::parse(content_of(path("list.json")));
  EXPECT_EQ(json["totals"]["files"], 6);
  EXPECT_EQ(json["totals"]["whole"], 4);
  EXPECT_EQ(json["causes"], Json::object({{"link", 2}}));
}

TEST_F(Archive, PathOfAListThatIsGone_DoesNotEndTheRun) {
  const std::string a = simulated("a.csv", "-f resolute-26");
  const std::string gone = captures() + "/gone.csv";
  fs::create_symlink("nowhere", captures() + "/broken");
  const std::string list =
      folder_.file("list.txt", gone + "\n" + a + "\n" + gone + "\n" + captures() + "/broken\n");
  run_ok("archive --files-from {} -o {}", list, path("list.json"));
  const Json json = Json::parse(content_of(path("list.json")));
  EXPECT_EQ(json["totals"]["files"], 3);
  EXPECT_EQ(cause_of(json, "gone.csv"), "cannot_open");
  EXPECT_THAT(entry_of(json, "gone.csv").value("message", ""), HasSubstr("No such file"));
  EXPECT_EQ(cause_of(json, "a.csv"), "");
  EXPECT_EQ(run("archive {} {}", a, gone).status, 3) << "a path of the command line is a mistake";
}

TEST_F(Archive, ListWithCrlfAndByteOrderMark_IsReadAsTheFolder) {
  const std::string a = simulated("a.csv", "-f resolute-26");
  const std::string b = simulated("m/b.csv", "-f resolute-26");
  summary();
  const std::string whole = content_of(path("summary.json"));
  for (const std::string& text : {"\xEF\xBB\xBF" + a + "\r\n" + b + "\r\n",
                                  "\xEF\xBB\xBF" + b + "\n" + a, a + "\r\n\r\n" + b + "\r"}) {
    const std::string list = folder_.file("list.txt", text);
    run_ok("archive --files-from {} -o {}", list, path("list.json"));
    EXPECT_EQ(content_of(path("list.json")), whole) << text;
  }
}

TEST_F(Archive, ListWhoseLinesEndInCr_IsRefusedAtItsLine) {
  const std::string a = simulated("a.csv", "-f resolute-26");
  const std::string odd = simulated("b\rc.csv", "-f resolute-26");
  run_ok("archive --files-from {} -o {}", folder_.file("list.txt", odd + "\n"), path("list.json"));
  fs::remove(path("list.json"));
  const std::string list = folder_.file("list.txt", odd + "\n" + a + "\r" + a + "\r");
  EXPECT_THAT(run("archive --files-from {} -o {}", list, path("list.json")),
              fails(3, list + ": line 2 has a CR inside; end each line in LF or CRLF"));
  EXPECT_FALSE(fs::exists(path("list.json")));
}

TEST_F(Archive, ListThatIsNoTextOfPaths_IsRefusedAtItsLine) {
  const std::string a = simulated("a.csv", "-f resolute-26");
  const auto refused = [&](const std::string& list, const std::string& cause) {
    EXPECT_THAT(run("archive --files-from {} -o {}", list, path("list.json")),
                refuses(3, list + ": " + cause));
    EXPECT_FALSE(fs::exists(path("list.json")));
  };
  // Endless, without a line end.
  refused("/dev/zero", "line 1 has more than 4096 bytes");
  refused(folder_.file("long.txt", a + "\n" + std::string(1'000'000, 'x') + "\n"),
          "line 2 has more than 4096 bytes");
  // What is behind the zero byte must not be dropped: `a` would be read.
  const std::string zero(1, '\0');
  refused(folder_.file("zero.txt", a + zero + "x\n"), "line 1 has a zero byte");
  refused(folder_.file("print0.txt", a + zero + a + zero), "line 1 has a zero byte");
  std::string wide = "\xFF\xFE";
  for (const char letter : a + "\r\n") wide += letter + zero;
  refused(folder_.file("utf16.txt", wide), "line 1 has a zero byte");
}

TEST_F(Archive, FileUnderTwoNames_IsNotCountedTwice) {
  simulated("m/a.csv", "-f resolute-26");
  const std::string m = captures() + "/m";
  fs::create_directory_symlink(m, path("link"));
  fs::create_symlink(m + "/a.csv", path("a-link.csv"));
  const std::string here = fs::current_path().string();
  const std::string relative = fs::relative(m, here).string();
  run_ok("archive {} -o {}", m, path("1.json"));
  for (const std::string& other :
       {relative, relative + "/a.csv", "./" + relative, path("link") + "/../m", path("link"),
        path("link") + "/a.csv", path("a-link.csv")}) {
    ASSERT_EQ(run("archive {} -o {}", other, path("2.json")).status, 0) << other;
    EXPECT_THAT(merge({path("1.json"), path("2.json")}),
                fails(3, "this file is in two of the summaries"))
        << other;
  }
  EXPECT_THAT(merge({path("1.json"), path("2.json")}).err, HasSubstr("also named"));
}

TEST_F(Archive, ChangedByteOfASummary_IsRefused) {
  simulated("a.csv", "-f resolute-26 --fault flip:0.2");
  summary();
  const std::string text = content_of(path("summary.json"));
  EXPECT_EQ(merge({path("summary.json")}).status, 0);
  int refused = 0;
  int tried = 0;
  const auto is_digit = [](char letter) { return letter >= '0' && letter <= '9'; };
  for (std::size_t at = 0; at < text.size(); at += is_digit(text[at]) ? 29U : 1U) {
    if (!is_digit(text[at])) continue;
    std::string changed = text;
    changed[at] = changed[at] == '1' ? '2' : '1';
    if (merge({folder_.file("changed.json", changed)}).status == 3) ++refused;
    ++tried;
  }
  EXPECT_EQ(refused, tried);
  EXPECT_GT(tried, 40);
  // The text of an older version.
  std::string old = text;
  old.replace(old.find(",\n\"checksum\""), std::string::npos, "}\n");
  EXPECT_THAT(merge({folder_.file("old.json", old)}),
              fails(3, "old.json: not a usable summary: its checksum is missing"));
}

TEST_F(Archive, RawSamples_AreReadAmongOtherCaptures) {
  const Words link("-f resolute-26 --clock 1MHz --sample-rate 10MHz");
  simulated("a.bin", link);
  simulated("b.sr", link);
  const Json json = summary("--raw-rate 10MHz --ma D0 --slo D1");
  EXPECT_EQ(entry_of(json, "a.bin")["links"][0]["cycles"], 60) << outcome_.err;
  EXPECT_EQ(cause_of(json, "b.sr"), "no_such_line");
}

}  // namespace biss::verbs::archive_test
