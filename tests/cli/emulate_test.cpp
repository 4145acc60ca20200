// `biss emulate`: programs that know nothing of it read the emulated encoder through spidev.
#include <iostream>
#include <sstream>

#include "tests/cli/emulator.hpp"
#include "tests/common/long_run.hpp"
#include "tests/common/random.hpp"

namespace biss::verbs::emulate_test {

using testing::HasSubstr;
using testing::StartsWith;

const std::string client = BISS_SPIDEV_CLIENT;
TEST_F(Emulate, ProgramInC_ReadsWhatWasSentOrDetectsTheFault) {
  const std::string truth = folder.path("truth.csv");
  const Words options(
      "--time step:100us --motion sine --fault flip:0.05 --fault cut:0.01 --fault "
      "no_answer:0.02 --fault glitch_slo:0.02 --fault lost_clock:0.02 --fault "
      "brown_out:0.002 --seed 5 --truth {}",
      truth);
  const Words reads{client, "read", "/dev/spidev0.0", "8000", "12", "0"};
  const Outcome first = run_ok(emulate(options, reads));
  const std::string sent = content_of(truth);
  EXPECT_GT(expect_read(first.out, sent, 8000), 600U);
  // Each run gives the same.
  const Outcome second = run_ok(emulate(options, reads));
  EXPECT_TRUE(second.out == first.out);
  EXPECT_TRUE(content_of(truth) == sent);
}

// 10^4 requests, in a long run 10^6. A checksum of 6 bits does not detect 1 of 64 long damages.
TEST_F(Emulate, EveryFault_GivesNoWrongPositionBeyondTheShareOfTheChecksum) {
  const std::string truth = folder.path("truth.csv");
  const std::uint64_t count = test::rounds(50'000, 500);
  std::uint64_t all_faults = 0;
  std::uint64_t all_wrong = 0;
  for (const char* const fault : {"flip",        "burst",           "glitch_ma",  "glitch_ma_idle",
                                  "glitch_slo",  "glitch_slo_idle", "lost_clock", "double_clock",
                                  "extra_clock", "ma_low",          "ma_high",    "slo_low",
                                  "slo_high",    "late_start",      "no_answer",  "cut",
                                  "brown_out",   "delay_step",      "nE",         "nW"}) {
    SCOPED_TRACE(fault);
    const Outcome outcome =
        run_ok(emulate(Words("--time step:100us --motion sine --fault {}:0.05 --seed {} --truth {}",
                             fault, test::random_of()() % 1'000'000, truth),
                       Words{client, "read", "/dev/spidev0.0", std::to_string(count), "12", "0"}));
    const std::string log = folder.file("words.log", outcome.out);
    const auto rows = rows_of(run("decode --words {} -f resolute-26 --to csv", log).out);
    const auto sent = rows_of(content_of(truth));
    ASSERT_EQ(rows.size(), count);
    ASSERT_EQ(sent.size(), count);
    std::uint64_t faults = 0;
    std::uint64_t wrong = 0;
    bool before = false;
    for (std::size_t k = 0; k < count; ++k) {
      const bool now = !sent[k].at("faults").empty();
      const bool good = rows[k].at("status") == "ok" && rows[k].at("nE") == "1";
      const bool same = good && rows[k].at("position") == sent[k].at("position");
      faults += now ? 1U : 0U;
      wrong += good && !same ? 1U : 0U;
      EXPECT_TRUE(same || now || before) << k << ' ' << rows[k].at("status");
      before = now;
    }
    EXPECT_LE(wrong, faults / 32 + 2);
    all_faults += faults;
    all_wrong += wrong;
  }
  std::cout << all_faults << " faults, " << all_wrong << " wrong positions\n";
}

TEST_F(Emulate, Python3Spidev_ReadsWhatWasSentOrDetectsTheFault) {
  if (Emulator::run_client({"/usr/bin/python3", "-c", "import spidev"}, folder.path("probe")) !=
      0) {
    GTEST_SKIP() << "no python3-spidev: scripts/install-packages test";
  }
  const std::string script = folder.file("read.py",
                                         "import spidev\n"
                                         "bus = spidev.SpiDev()\n"
                                         "bus.open(1, 0)\n"
                                         "bus.mode = 3\n"
                                         "bus.max_speed_hz = 2000000\n"
                                         "assert bus.mode == 3 and bus.bits_per_word == 8\n"
                                         "for i in range(1000):\n"
                                         "    print(bytes(bus.xfer2([0xFF] * 12)).hex())\n"
                                         "    print(bytes(bus.readbytes(12)).hex())\n");
  const std::string truth = folder.path("truth.csv");
  const Outcome outcome = run_ok(
      emulate(Words("--time step:150us --fault flip:0.1 --as /dev/spidev1.0 --truth {}", truth),
              {"/usr/bin/python3", script}));
  EXPECT_GT(expect_read(outcome.out, content_of(truth), 2000), 150U);
}

// examples/control_loop; each row of its log is "number cause position".
TEST_F(Emulate, ControlLoop_MeasuresThePositionsThatWereSent) {
  for (const std::string rate : {"0", "0.02"}) {
    const std::string truth = folder.path("truth.csv");
    const Outcome outcome = run_ok(emulate(
        Words("--time step:1ms --motion sine --fault flip:{} --truth {}", rate, truth),
        Words(BISS_CONTROL_LOOP " /dev/spidev0.0 resolute-26 5000000 1000 2000 300000 log")));
    const Rows sent = rows_of(content_of(truth));
    ASSERT_EQ(sent.size(), 2000U);
    std::istringstream log(outcome.out);
    std::size_t measured = 0;
    for (std::size_t k = 0; k < sent.size(); ++k) {
      std::size_t number = 0;
      std::string cause;
      std::int64_t position = 0;
      log >> number >> cause >> position;
      if (number != k + 1) continue;
      ++measured;
      // The axis counts turns of 2^26 counts.
      EXPECT_EQ(std::to_string(position & 0x3FF'FFFF), sent[k].at("position"))
          << k << ' ' << cause << sent[k].at("faults");
    }
    // Every frame but the first. If this machine stopped for long, the axis trips: for four cycles
    // before a bad frame, or for 0.1 s, in which half a turn is possible.
    const bool stopped = outcome.out.find("cause     turns ") != std::string::npos;
    EXPECT_GE(measured, rate != "0" || stopped ? 1U : 1999U);
    EXPECT_THAT(outcome.out, HasSubstr("\ncycles    2000,"));
    EXPECT_THAT(outcome.out, HasSubstr(" missed\ncause     ok "));
  }
  EXPECT_THAT(run(emulate({}, Words(BISS_CONTROL_LOOP " /dev/null resolute-26 5000000 500 1 1"))),
              fails(1, "Inappropriate ioctl"));
}

TEST_F(Emulate, Mistakes_GetTheErrorsOfTheKernel) {
  const Outcome outcome = run_ok(emulate({}, {client, "mistakes", "/dev/spidev0.0"}));
  EXPECT_EQ(outcome.out,
            "wrong out: -1 Bad address\n"
            "wrong in: -1 Bad address\n"
            "end of memory: -1 Bad address\n"
            "read-only: -1 Bad address\n"
            "the device itself: -1 Bad address\n"
            "too long: -1 Message too long\n"
            "null argument: -1 Bad address\n"
            "another request: -1 Inappropriate ioctl for device\n"
            "long read: -1 Message too long\n"
            "long write: -1 Message too long\n"
            "many: 0 \n"
            "good: 16 \n");
}

TEST_F(Emulate, ExitStatus_IsTheCommands) {
  EXPECT_EQ(run(emulate({}, {"sh", "-c", "exit 37"})).status, 37);
  EXPECT_EQ(run(emulate({}, {"sh", "-c", "kill -9 $$"})).status, 137);
  EXPECT_THAT(run(emulate({}, {"no-such-command"})), refuses(3, "no-such-command: cannot start"));
  EXPECT_THAT(run(emulate({"--as", "/no/folder"}, {"true"})), refuses(3, "give a name in /dev"));
  EXPECT_FALSE(std::filesystem::exists("/dev/spidev77.7"));
  EXPECT_EQ(run(emulate({"--as", "/dev/spidev77.7"}, {"test", "-f", "/dev/spidev77.7"})).status, 0);
  EXPECT_FALSE(std::filesystem::exists("/dev/spidev77.7"));
}

TEST_F(Emulate, WhileItRuns_TheSocketChangesTheLine) {
  const std::string truth = folder.path("truth.csv");
  Emulator emulator(folder, Words("--time step:200us --truth {}", truth));
  const std::string words = folder.path("words");
  const auto read = [&](int count) {
    return Emulator::run_client(
        {client, "read", emulator.at, std::to_string(count), "12", "5000000"}, words);
  };
  EXPECT_EQ(emulator.ask("at 1234567"), "ok at 1234567\n");
  EXPECT_EQ(read(2), 0);
  EXPECT_EQ(expect_read(content_of(words), "faults,position\n,1234567\n,1234567\n", 2), 0U);
  EXPECT_EQ(emulator.ask("fault no_answer@next"), "ok fault no_answer@2\n");
  EXPECT_EQ(read(1), 0);
  EXPECT_THAT(content_of(words), testing::MatchesRegex("F+\n"));
  EXPECT_EQ(emulator.ask("unplug"), "ok unplug\n");
  EXPECT_EQ(read(1), 0);
  EXPECT_THAT(content_of(words), testing::MatchesRegex("F+\n"));
  EXPECT_EQ(emulator.ask("plug"), "ok plug\n");
  EXPECT_THAT(emulator.ask("nonsense"), StartsWith("error: no command 'nonsense'"));
  EXPECT_THAT(emulator.ask("status"), HasSubstr(R"("requests":4,"faults":2,"position":1234567)"));
  EXPECT_EQ(Emulator::run_client({client, "twice", emulator.at, "300", "12", "5000000"}), 0);
  EXPECT_EQ(emulator.ask("quit"), "ok quit\n");
  EXPECT_EQ(emulator.wait(), 0);
  EXPECT_FALSE(std::filesystem::exists(emulator.at));
  EXPECT_FALSE(std::filesystem::exists(emulator.ctl));
  const auto sent = rows_of(content_of(truth));
  ASSERT_EQ(sent.size(), 604U);
  // The cable was cut before the next request.
  EXPECT_EQ(sent[2].at("faults"), "no_answer;cut");
  EXPECT_EQ(sent[3].at("faults"), "cut");
}

// 65536 clocks of 100 kHz take 0.3 s.
TEST_F(Emulate, ProgramThatDiesInAMessage_HindersNoOther) {
  Emulator emulator(folder, {});
  const pid_t slow = start({client, "read", emulator.at, "1", "4000", "100000"});
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  ::kill(slow, SIGKILL);
  // Commands are answered in the meantime.
  EXPECT_THAT(emulator.ask("status"), StartsWith("ok {"));
  EXPECT_EQ(Emulator::run_client({client, "read", emulator.at, "1", "12", "5000000"}), 0);
  ::waitpid(slow, nullptr, 0);
  EXPECT_EQ(emulator.end(SIGTERM), 0);
  EXPECT_FALSE(std::filesystem::exists(emulator.at));
}

TEST_F(Emulate, KilledEmulator_LeavesErrorsAndARemedy) {
  Emulator emulator(folder, {"--no-wait"});
  const std::string out = folder.path("out");
  const pid_t reader = start({client, "until-error", emulator.at}, "/dev/null", out, out + ".err");
  for (int i = 0; i < 500 && content_of(out).empty(); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  EXPECT_EQ(emulator.end(SIGKILL), 137);
  int status = 0;
  ::waitpid(reader, &status, 0);
  EXPECT_EQ(WEXITSTATUS(status), 4) << content_of(out + ".err");
  EXPECT_THAT(run(Words{"emulate", "--at", emulator.at} + Words(line26)),
              refuses(3, "fusermount3 -u " + emulator.at));
}

TEST_F(Emulate, PlaceThatIsTaken_IsRefused) {
  const auto at = [&](const std::string& path) {
    return run(Words{"emulate", "--at", path} + Words(line26));
  };
  EXPECT_THAT(at(folder.file("full", "x")), refuses(3, "is not empty"));
  EXPECT_THAT(at(folder.path("")), refuses(3, "is not a regular file"));
  EXPECT_THAT(at(folder.path("no/file")), refuses(3, "No such file"));
  Emulator emulator(folder, {});
  EXPECT_THAT(at(emulator.at), refuses(3, "something is mounted there"));
  EXPECT_THAT(
      run(Words{"emulate", "--at", folder.path("other"), "--ctl", emulator.ctl} + Words(line26)),
      refuses(3, "the socket is in use"));
  EXPECT_FALSE(std::filesystem::exists(folder.path("other")));
  EXPECT_EQ(emulator.end(SIGINT), 0);
}

TEST(EmulateUsage, WrongOptions_AreNamed) {
  const auto with = [](const Words& more) { return run(Words{"emulate"} + more); };
  EXPECT_THAT(with(Words(line26)), refuses(2, "give --at FILE, or -- COMMAND"));
  EXPECT_THAT(with({"--", "true"}), refuses(2, "give --format, or --registers"));
  const Words line = Words("-f resolute-26 --at none");
  EXPECT_THAT(with(line + Words("--time fast")), refuses(2, "real or step:TIME"));
  EXPECT_THAT(with(line + Words("--time step:3")), refuses(2, "--time"));
  EXPECT_THAT(with(line + Words("--time step:10ns")), refuses(2, "at least 1us"));
  EXPECT_THAT(with(line + Words("--fault delay:0.1")),
              refuses(2, "delay needs a simulated master"));
  EXPECT_THAT(with(line + Words("--fault flip@3,bit=99")), refuses(2, "--fault"));
  EXPECT_THAT(with(line + Words("--controller-clock 1kHz")), refuses(2, "at least 1 MHz"));
  EXPECT_THAT(with(line + Words("--duty 40%")), fails(2, "--duty"));
  EXPECT_THAT(run("emulate ctl none status"), refuses(3, "is biss emulate running"));
}

}  // namespace biss::verbs::emulate_test
