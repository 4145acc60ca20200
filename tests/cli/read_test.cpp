// `biss read`: an emulated encoder, read through spidev.
#include "tests/cli/emulator.hpp"

namespace biss::verbs::read_test {

using testing::HasSubstr;
using testing::Matches;
using testing::Not;

class Read : public Emulate {
 protected:
  static Words read(const Words& more) {
    return Words{BISS_COMMAND, "read", "--port", "spi:/dev/spidev0.0"} + more;
  }
  // The requests before the rows measured the clock.
  static Rows last(Rows rows, std::size_t count) {
    rows.erase(rows.begin(),
               rows.end() - static_cast<std::ptrdiff_t>(std::min(count, rows.size())));
    return rows;
  }

  // Starts `biss read`, and waits for its first rows.
  pid_t start_until_it_reads(const Emulator& emulator, const Words& more, const std::string& err) {
    const pid_t reader = start(Words{BISS_COMMAND, "read", "--port", "spi:" + emulator.at} +
                                   Words("-f resolute-26 --record {}", record) + more,
                               "/dev/null", "/dev/null", err);
    for (int i = 0; i < 3000 && content_of(record).size() < 2000; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return reader;
  }

  const std::string rows = folder.path("rows.csv");
  const std::string record = folder.path("record.log");
  const std::string truth = folder.path("truth.csv");
};

TEST_F(Read, RowsAreWhatWasSent_AndTheRecordGivesTheSameRows) {
  const Words options(
      "--motion sine --fault flip:0.05 --fault cut:0.01 --fault no_answer:0.02 --fault "
      "glitch_slo:0.02 --fault lost_clock:0.02 --seed 7 --truth {}",
      truth);
  const Outcome outcome = run(emulate(
      options, read(Words("-f resolute-26 --clock 5MHz --rate 4kHz --cycles 3000 -o {} --record {}",
                          rows, record))));
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const Rows got = rows_of(content_of(rows));
  ASSERT_EQ(got.size(), 3000U);
  EXPECT_GT(expect_rows(got, last(rows_of(content_of(truth)), 3000)), 150U);
  EXPECT_THAT(outcome.err, HasSubstr("failed      none"));
  const Outcome again = run_ok("decode --words {} -f resolute-26 --to csv", record);
  EXPECT_TRUE(again.out == content_of(rows));
}

TEST_F(Read, WithoutAFormat_IdentifiesTheEncoder) {
  const Outcome outcome = run(emulate({}, read(Words("--cycles 400 -o {}", rows))));
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("pos26,nE,nW,crc6"));
  EXPECT_EQ(rows_of(content_of(rows)).size(), 400U);
}

TEST_F(Read, MaFromTheDataOutput) {
  const Outcome outcome = run(
      emulate(Words("--ma mosi --truth {}", truth),
              read(Words("-f resolute-26 --ma-pin mosi --clock 4MHz --cycles 500 -o {}", rows))));
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(expect_rows(rows_of(content_of(rows)), last(rows_of(content_of(truth)), 500)), 0U);
}

TEST_F(Read, ClockThatIsLowerThanAsked_IsNamed) {
  const auto warning = HasSubstr("the controller has a lower clock, or it pauses between bytes");
  const Words reads = read(Words("-f resolute-26 --clock 4MHz --cycles 20 -o {}", rows));
  // The emulator keeps up with this clock also with sanitizers.
  const Words slow = read(Words("-f resolute-26 --clock 250kHz --cycles 20 -o {}", rows));
  // Other programs can make a measurement uncertain.
  for (const Words& cause : {Words("--controller-clock 5MHz"), Words("--byte-gap 400ns")}) {
    std::string err;
    for (int i = 0; i < 20 && !Matches(warning)(err); ++i) err = run(emulate(cause, reads)).err;
    EXPECT_THAT(err, warning);
  }
  // Other programs can make all transfers of a measurement slower.
  std::string err;
  for (int i = 0; i < 20 && (i == 0 || Matches(warning)(err)); ++i)
    err = run(emulate({}, slow)).err;
  EXPECT_THAT(err, Not(warning));
}

TEST_F(Read, DeviceThatVanishes_IsOpenedAgain) {
  auto first = std::make_unique<Emulator>(folder, Words{});
  const std::string err = folder.path("read.err");
  const pid_t reader = start_until_it_reads(*first, Words("--cycles 3000 -o {}", rows), err);
  first->end(SIGKILL);
  first.reset();
  const Emulator second(folder, {});
  int status = 0;
  ::waitpid(reader, &status, 0);
  EXPECT_EQ(WEXITSTATUS(status), 0);
  EXPECT_THAT(content_of(err), HasSubstr("a transfer failed: gone"));
  EXPECT_THAT(content_of(err), HasSubstr("status  3000 ok"));
  EXPECT_EQ(rows_of(content_of(rows)).size(), 3000U);
}

TEST_F(Read, PortThatIsAnotherFileForAWhile_IsOpenedAgain) {
  auto first = std::make_unique<Emulator>(folder, Words{});
  const std::string err = folder.path("read.err");
  const pid_t reader = start_until_it_reads(*first, {}, err);
  const std::string at = first->at;
  EXPECT_EQ(first->ask("quit"), "ok quit\n");
  EXPECT_EQ(first->wait(), 0);
  first.reset();
  folder.file("spidev", "");
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  const Emulator second(folder, {});
  const std::size_t before = content_of(record).size();
  for (int i = 0; i < 1000 && content_of(record).size() < before + 2000; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  EXPECT_GE(content_of(record).size(), before + 2000);
  ::kill(reader, SIGINT);
  ::waitpid(reader, nullptr, 0);
  EXPECT_THAT(content_of(err), HasSubstr("a transfer failed: gone"));
}

TEST_F(Read, RowsArriveWhileItReads) {
  const Emulator emulator(folder, {});
  const std::string out = folder.path("out");
  const pid_t reader = start(Words{BISS_COMMAND, "read", "--port", "spi:" + emulator.at} +
                                 Words("-f resolute-26 --rate 50Hz --to csv"),
                             "/dev/null", out);
  for (int i = 0; i < 3000 && rows_of(content_of(out)).size() < 20; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  const std::size_t count = rows_of(content_of(out)).size();
  EXPECT_GE(count, 20U);
  EXPECT_LT(count, 200U);
  ::kill(reader, SIGINT);
  ::waitpid(reader, nullptr, 0);
}

TEST_F(Read, FramesThatContradictTheIdentifiedFormat_AreNamed) {
  auto first = std::make_unique<Emulator>(folder, Words("--motion sine"));
  const std::string err = folder.path("read.err");
  const pid_t reader = start(Words{BISS_COMMAND, "read", "--port", "spi:" + first->at} +
                                 Words("--rate 2kHz -o {} --record {}", rows, record),
                             "/dev/null", "/dev/null", err);
  // 512 rows of about 90 bytes show the format.
  for (int i = 0; i < 3000 && content_of(record).size() < 60'000; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  EXPECT_EQ(first->ask("quit"), "ok quit\n");
  EXPECT_EQ(first->wait(), 0);
  first.reset();
  const std::size_t before = content_of(record).size();
  const Emulator second(folder, Words("--motion sine --fault flip:1"));
  for (int i = 0; i < 3000 && content_of(record).size() < before + 120'000; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  ::kill(reader, SIGINT);
  int status = 0;
  ::waitpid(reader, &status, 0);
  EXPECT_EQ(WEXITSTATUS(status), 1) << content_of(err);
  EXPECT_THAT(content_of(err), HasSubstr("frames contradict"));
}

TEST_F(Read, Interrupted_KeepsTheRows) {
  const Emulator emulator(folder, {});
  const std::string err = folder.path("read.err");
  const pid_t reader = start_until_it_reads(emulator, Words("-o {}", rows), err);
  ::kill(reader, SIGINT);
  int status = 0;
  ::waitpid(reader, &status, 0);
  EXPECT_EQ(status, 0);
  EXPECT_GT(rows_of(content_of(rows)).size(), 10U);
  EXPECT_THAT(content_of(err), HasSubstr(" ok\n"));
}

TEST_F(Read, SecondReader_IsRefused) {
  const Emulator emulator(folder, {});
  const pid_t first = start_until_it_reads(emulator, {}, "/dev/null");
  EXPECT_THAT(run(Words{"read", "--port", "spi:" + emulator.at}),
              refuses(3, "another `biss read` uses it"));
  ::kill(first, SIGINT);
  ::waitpid(first, nullptr, 0);
}

TEST_F(Read, FullDisk_EndsTheRecordAndNotTheReading) {
  const Outcome outcome =
      run(emulate({}, read(Words("-f resolute-26 --cycles 300 -o {} --record /dev/full", rows))));
  EXPECT_EQ(outcome.status, 3);
  EXPECT_EQ(rows_of(content_of(rows)).size(), 300U);
  EXPECT_THAT(outcome.err, HasSubstr("the record ends here, reading goes on"));
  EXPECT_THAT(outcome.err, HasSubstr("300 transfers are missing in the record"));
}

TEST(ReadUsage, MistakesAreNamed) {
  const auto with = [](const char* more) {
    return run(Words("read --port spi:/no/device") + Words(more));
  };
  EXPECT_THAT(with("-f resolute-26"), refuses(3, "not found; is SPI switched on"));
  EXPECT_THAT(with("-f resolute-26 --clock 20MHz"), refuses(2, "--clock: the encoder accepts"));
  EXPECT_THAT(with("-f resolute-26 --rate 1MHz"), refuses(2, "allow "));
  EXPECT_THAT(with("-f pos26,nE"), refuses(3, "not found"));
  EXPECT_THAT(run("read --port usb:1"), refuses(2, "write spi:DEVICE"));
  EXPECT_THAT(run("read --port spi:/dev/null -f resolute-26"), refuses(3, "is not an SPI device"));
}

}  // namespace biss::verbs::read_test
