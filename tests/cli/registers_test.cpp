// `biss registers` reports the control communication of a simulated capture.
#include "tests/cli/run_command.hpp"

namespace biss::verbs::registers_test {

using testing::HasSubstr;

// Bank 0 complete; the direct registers as of an iC-MHM, some of them absent.
constexpr const char* page =
    "bank 0\n"
    "0x00: 48 44 00 78 80 00 00 00 CF 80 00 00 23 00 00 00\n"
    "0x10: 00 01 02 8C 55 AA 33 CC 0F F0 00 FF 01 80 7F FE\n"
    "0x20: 11 22 44 88 -- -- -- -- -- -- -- -- -- -- -- --\n"
    "0x40: 00 00 62 1E FF FF FF FF 00 00 00 00 00 00 8C FF\n"
    "0x70: 00 01 15 15 -- -- -- -- 4D 48 4D 23 44 00 69 43\n";
constexpr const char* format = "pos28,nE,nW,crc6";

class HeardRegisters : public testing::Test {
 protected:
  std::vector<Row> heard(const Words& simulate, const Words& more = {}) const {
    run_ok(Words("simulate --registers {} -f {} -o {} --seed 7", dump, format, capture) + simulate);
    return rows_of(run_ok(Words("registers {} --to csv", capture) + more).out);
  }

  Folder folder;
  std::string dump = folder.file("registers.txt", page);
  std::string capture = folder.path("line.vcd");
};

TEST_F(HeardRegisters, WholeMap_IsTheDumpThatWasGiven) {
  const std::string back = folder.path("back.txt");
  const auto rows = heard({"--access", "read:0x00,36", "--access", "read:0x40,16", "--access",
                           "read:0x70,4", "--access", "read:0x78,8", "--register-busy", "1"},
                          {"--dump", back, "-f", format});
  ASSERT_EQ(rows.size(), 64U);
  for (const Row& row : rows) EXPECT_EQ(row.at("outcome"), "ok");
  EXPECT_EQ(content_of(back), page);
}

TEST_F(HeardRegisters, EveryKindOfAccess_HasItsRow) {
  const auto rows = heard({"--access", "write:0x48=55", "--access", "read:0x20,8", "--access",
                           "read:0x60", "--access", "3/read:0x42", "--access", "command:channels",
                           "--access", "write:0x7F=01"});
  std::vector<std::string> reported;
  for (Row row : rows) {
    reported.push_back(row["id"] + " " + row["access"] + " " + row["address"] + " " + row["data"] +
                       " " + row["outcome"]);
  }
  EXPECT_EQ(reported.front(), "0 write 0x48 55 ok");
  EXPECT_THAT(reported, testing::IsSupersetOf(
                            {std::string("0 read 0x20 11 ok"), std::string("0 read 0x23 88 ok"),
                             std::string("0 read 0x60  refused"),
                             std::string("3 unknown 0x42  no_such_slave"),
                             std::string("0 write 0x7F  refused_or_not_addressed")}));
  EXPECT_EQ(std::count_if(rows.begin(), rows.end(),
                          [](const Row& row) { return row.at("access") == "command"; }),
            1);
}

TEST_F(HeardRegisters, RequestWithoutAnswer_BreaksItsAccessAlone) {
  const auto rows =
      heard({"--access", "read:0x42", "--access", "read:0x43", "--fault", "no_answer@30"});
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[0].at("outcome"), "frame_lost");
  EXPECT_EQ(rows[1].at("outcome"), "ok");
  EXPECT_EQ(rows[1].at("data"), "1E");
}

TEST_F(HeardRegisters, CaptureThatEndsInAnAccess_IsCutAndNotLost) {
  const std::string whole = folder.path("line.csv");
  run_ok("simulate --registers {} -f {} --access read:0x42 -o {} --seed 7", dump, format, whole);
  const std::string text = content_of(whole);
  std::size_t in_access = 0;
  for (std::size_t cut = 1; cut < 90; ++cut) {
    const std::size_t end = text.find('\n', text.size() * cut / 90) + 1;
    folder.file("cut.csv", text.substr(0, end));
    for (const Row& row :
         rows_of(run("registers {} -f {} --to csv", folder.path("cut.csv"), format).out)) {
      EXPECT_THAT(row.at("outcome"), testing::AnyOf("cut_end", "ok")) << cut;
      in_access += row.at("outcome") == "cut_end" ? 1U : 0U;
    }
  }
  EXPECT_GT(in_access, 20U);
}

TEST_F(HeardRegisters, SequentialAccess_IsOneAccessOfManyBytes) {
  heard({"--access", "read:0x00,36", "--access", "write:0x48=55"});
  EXPECT_THAT(run("registers {}", capture).err, HasSubstr("2 accesses (37 bytes or commands)"));
}

TEST_F(HeardRegisters, CaptureWithoutControl_SaysSo) {
  run_ok("simulate -f resolute-26 -o {}", capture);
  EXPECT_THAT(run_ok("registers {}", capture).err, HasSubstr("0 accesses"));
  EXPECT_EQ(run("registers {} --dump {}", capture, folder.path("x")).status, 1);
  EXPECT_EQ(run("registers {} -o {}", capture, capture).status, 2);
}

TEST_F(HeardRegisters, Dump_HasTheFormatOfItsExtension) {
  heard({"--access", "read:0x00,4", "--access", "read:0x40,4"});
  for (const char* name : {"seen.ihx", "seen.ihex"}) {
    run_ok("registers {} --dump {}", capture, folder.path(name));
    EXPECT_THAT(content_of(folder.path(name)), testing::StartsWith(":0400000048440078"));
  }
  const Outcome binary = run_ok("registers {} --dump {}", capture, folder.path("seen.bin"));
  EXPECT_EQ(content_of(folder.path("seen.bin")).size(), 64U);
  EXPECT_THAT(binary.err, HasSubstr("banks 0 to 0, 64 bytes; this format has no place for the "
                                    "registers from 0x40 on"));
}

TEST_F(HeardRegisters, DumpWithoutARegister_IsAFailure) {
  heard({"--access", "read:0x60"});
  EXPECT_THAT(run("registers {} --dump {}", capture, folder.path("none.hex")),
              fails(1, "--dump: no register was read"));
  EXPECT_FALSE(std::filesystem::exists(folder.path("none.hex")));
  heard({"--access", "read:0x42,2"});
  EXPECT_THAT(run("registers {} --dump {}", capture, folder.path("none.bin")),
              fails(1, "--dump: no register of a bank was read"));
  EXPECT_FALSE(std::filesystem::exists(folder.path("none.bin")));
  run_ok("registers {} --dump {}", capture, folder.path("seen.hex"));
}

TEST_F(HeardRegisters, BankThatNoAccessShows_IsLeftOutAndNotGuessed) {
  heard({"--access", "read:0x00,4", "--access", "read:0x42,2"});
  const std::string seen = folder.path("seen.hex");
  const Outcome unknown = run_ok("registers {} --dump {}", capture, seen);
  EXPECT_THAT(unknown.err,
              HasSubstr("--dump: left out: 4 registers from 0x00 to 0x3F of which no access shows "
                        "the bank (BSEL, 0x40); --bank gives the bank at the beginning of the "
                        "capture\n"));
  EXPECT_EQ(content_of(seen), "0x40: -- -- 62 1E -- -- -- -- -- -- -- -- -- -- -- --\n");
  EXPECT_THAT(run("registers {} --dump {}", capture, folder.path("seen.bin")),
              fails(1, "--dump: no register of a known bank was read"));
  const Outcome given = run_ok("registers {} --dump {} --bank 2", capture, seen);
  EXPECT_THAT(content_of(seen), testing::StartsWith("bank 2\n0x00: 48 44 00 78 --"));
  EXPECT_THAT(given.err, testing::Not(HasSubstr("left out")));
}

TEST_F(HeardRegisters, OptionOfDumpWithoutDump_IsWrongUsage) {
  heard({"--access", "read:0x42"});
  for (const std::string option : {"--id", "--bank"}) {
    EXPECT_THAT(run("registers {} {} 3", capture, option), fails(2, option + ": needs --dump"));
  }
}

TEST_F(HeardRegisters, JsonLines_AreADumpAgain) {
  heard({"--access", "read:0x00,36", "--access", "read:0x40,8"});
  const std::string rows = folder.path("rows.jsonl");
  run_ok("registers {} --to jsonl -o {}", capture, rows);
  const Outcome again = run("simulate --registers {} -f {} -o {} --access read:0x42,2 --outcomes -",
                            rows, format, capture);
  EXPECT_THAT(again.out, HasSubstr("62 1E"));
}

}  // namespace biss::verbs::registers_test
