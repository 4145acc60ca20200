// `biss read --live`: its screen in a pseudo terminal, with the emulated encoder.
#include <fcntl.h>
#include <sys/ioctl.h>
#include <termios.h>

#include <array>

#include "tests/cli/emulator.hpp"
#include "tests/cli/view_server.hpp"

namespace biss::verbs::live_test {

using testing::AllOf;
using testing::ContainsRegex;
using testing::HasSubstr;

class Terminal {
 public:
  explicit Terminal(unsigned short rows = 40, unsigned short columns = 100)
      : master_(::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)) {
    ::grantpt(master_);
    ::unlockpt(master_);
    std::array<char, 64> name{};
    ::ptsname_r(master_, name.data(), name.size());
    path = name.data();
    slave_ = ::open(name.data(), O_RDWR | O_NOCTTY | O_CLOEXEC);
    const winsize size{rows, columns, 0, 0};
    ::ioctl(slave_, TIOCSWINSZ, &size);
    before_ = settings();
  }
  ~Terminal() {
    ::close(slave_);
    ::close(master_);
  }
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;

  void type(char key) const { EXPECT_EQ(::write(master_, &key, 1), 1); }
  const std::string& output() {
    std::array<char, 65536> block{};
    for (ssize_t got = 0; (got = ::read(master_, block.data(), block.size())) > 0;) {
      text_.append(block.data(), static_cast<std::size_t>(got));
    }
    return text_;
  }
  /// The content that was drawn last, without the sequences that draw it.
  std::string screen() {
    const std::string& text = output();
    const std::size_t end = text.rfind("\x1b[J");
    const std::size_t begin = text.rfind("\x1b[H", end);
    if (end == std::string::npos || begin == std::string::npos) return {};
    std::string lines = text.substr(begin + 3, end - begin - 3);
    for (const std::string_view each : {"\x1b[K", "\r"}) {
      for (std::size_t at = 0; (at = lines.find(each, at)) != std::string::npos;) {
        lines.erase(at, each.size());
      }
    }
    return lines;
  }
  /// Waits for a content.
  std::string wait_for(const testing::Matcher<std::string>& wanted) {
    for (int i = 0; i < 3000 && !wanted.Matches(screen()); ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    EXPECT_THAT(screen(), wanted);
    return screen();
  }
  /// The program has changed the terminal, and it is as before.
  void expect_restored() {
    EXPECT_THAT(output(), HasSubstr("\x1b[?1049h"));
    EXPECT_TRUE(output().ends_with("\x1b[?7h\x1b[?25h\x1b[?1049l")) << output();
    EXPECT_EQ(settings(), before_);
  }

  std::string path;

 private:
  std::array<tcflag_t, 4> settings() const {
    termios now{};
    ::tcgetattr(slave_, &now);
    return {now.c_iflag, now.c_oflag, now.c_lflag, now.c_cc[VSUSP]};
  }

  int master_;
  int slave_ = -1;
  std::array<tcflag_t, 4> before_{};
  std::string text_;
};

class ReadLive : public Emulate {
 protected:
  pid_t read(const Emulator& emulator, const Terminal& terminal, const Words& more = {}) const {
    return start(Words{"/usr/bin/env", "-C", folder.path("."), BISS_COMMAND, "read", "--port",
                       "spi:" + emulator.at, "--live"} +
                     more,
                 terminal.path, terminal.path, err);
  }
  static int wait(pid_t process) {
    int status = 0;
    ::waitpid(process, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }
  const std::string err = folder.path("err");
  const Words format{"-f", "resolute-26"};
};

TEST_F(ReadLive, ShowsWhatTheEncoderSendsAndEachFault) {
  const Emulator emulator(folder, Words("--motion constant"));
  Terminal terminal;
  emulator.ask("at 4711");
  const pid_t reader = read(emulator, terminal, format + Words("--scale 1000/turn"));
  terminal.wait_for(AllOf(ContainsRegex("position +1695.960000 deg\n"),
                          ContainsRegex("state +measured +ok\n"),
                          ContainsRegex("sent +4711 +nE = 1, nW = 1\n"),
                          ContainsRegex("line delay +0 clocks of MA +\\+0 since the start"),
                          ContainsRegex("ACK +[0-9]+ clocks"), ContainsRegex("\nok +[0-9]+")));
  emulator.ask("fault flip@next,bit=3");
  terminal.wait_for(ContainsRegex("\ncrc +1 "));
  emulator.ask("nW 0");
  terminal.wait_for(AllOf(ContainsRegex("state +measured +warning"), HasSubstr("nW = 0")));
  emulator.ask("nE 0");
  terminal.wait_for(AllOf(ContainsRegex("state +held +error_bit"), HasSubstr("nE = 0")));
  emulator.ask("nE 1");
  emulator.ask("nW 1");
  emulator.ask("unplug");
  terminal.wait_for(ContainsRegex("state +held +no_response"));
  emulator.ask("plug");
  terminal.wait_for(ContainsRegex("state +measured +ok"));
  terminal.type('q');
  EXPECT_EQ(wait(reader), 0);
  terminal.expect_restored();
  EXPECT_THAT(content_of(err), HasSubstr("failed      none"));
}

TEST_F(ReadLive, Keys) {
  const Emulator emulator(folder, Words("--motion constant"));
  Terminal terminal;
  emulator.ask("at 5000");
  // Also after many requests that were late, the distance is certain.
  const pid_t reader = read(emulator, terminal, format + Words("--unwrap --max-step 10000"));
  // The catalogue has the counts of a turn.
  terminal.wait_for(ContainsRegex("position +0.026822 deg\n"));
  terminal.type('u');
  terminal.wait_for(ContainsRegex("position +0.000075 turns\n"));
  terminal.type('u');
  terminal.wait_for(ContainsRegex("position +5000 counts\n"));
  terminal.type('z');
  terminal.wait_for(ContainsRegex("position +0 counts +from the zero set here\n"));
  emulator.ask("move -7000");
  terminal.wait_for(AllOf(ContainsRegex("position +-7000 counts"), ContainsRegex("turns +-1\n")));
  terminal.type('r');
  terminal.wait_for(ContainsRegex("record +biss-read-1.log\n"));
  terminal.type('r');
  terminal.wait_for(ContainsRegex("record +off\n"));
  terminal.type('r');
  terminal.wait_for(ContainsRegex("record +biss-read-2.log\n"));
  terminal.type('q');
  EXPECT_EQ(wait(reader), 0);
  for (const char* const name : {"biss-read-1.log", "biss-read-2.log"}) {
    const Outcome rows = run_ok("decode --words {} -f resolute-26 --to csv", folder.path(name));
    EXPECT_THAT(rows.out, HasSubstr(",ok,67106864,1,1,1,"));
  }
}

TEST_F(ReadLive, EverySignal_GivesTheTerminalBack) {
  const Emulator emulator(folder, {});
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) {
    Terminal terminal;
    const pid_t reader = read(emulator, terminal, format);
    terminal.wait_for(HasSubstr("q end"));
    ::kill(reader, number);
    EXPECT_EQ(wait(reader), 0);
    terminal.expect_restored();
  }
}

TEST_F(ReadLive, SecondSignal_GivesTheTerminalBack) {
  const Emulator emulator(folder, {});
  Terminal terminal;
  const pid_t reader = read(emulator, terminal, format);
  terminal.wait_for(HasSubstr("q end"));
  // Both before the process runs again.
  ::kill(reader, SIGSTOP);
  ::kill(reader, SIGTERM);
  ::kill(reader, SIGINT);
  ::kill(reader, SIGCONT);
  EXPECT_THAT(wait(reader), testing::AnyOf(128 + SIGINT, 128 + SIGTERM));
  terminal.expect_restored();
}

TEST_F(ReadLive, PortThatVanishes_IsNamed) {
  auto emulator = std::make_unique<Emulator>(folder, Words("--motion constant"));
  Terminal terminal;
  const pid_t reader = read(*emulator, terminal, format);
  terminal.wait_for(ContainsRegex("state +measured"));
  emulator->end(SIGKILL);
  emulator.reset();
  terminal.wait_for(AllOf(ContainsRegex("state +held +failed"),
                          ContainsRegex("failed +[0-9]+ gone"),
                          ContainsRegex("message +.*a transfer failed: gone")));
  const Emulator second(folder, Words("--motion constant"));
  terminal.wait_for(ContainsRegex("state +measured +ok"));
  terminal.type('q');
  EXPECT_EQ(wait(reader), 0);
  EXPECT_THAT(content_of(err), HasSubstr("a transfer failed: gone"));
}

TEST_F(ReadLive, WithoutAFormat_ShowsTheOneThatIsIdentified) {
  const Emulator emulator(folder, Words("--motion sine"));
  Terminal terminal;
  const pid_t reader = read(emulator, terminal);
  terminal.wait_for(
      AllOf(HasSubstr(": pos26,nE,nW,crc6"), ContainsRegex("position +-?[0-9]+ counts")));
  terminal.type('q');
  EXPECT_EQ(wait(reader), 0);
}

TEST_F(ReadLive, SmallTerminal_CutsLines) {
  const Emulator emulator(folder, {});
  Terminal terminal(3, 12);
  const pid_t reader = read(emulator, terminal, format);
  const std::string screen = terminal.wait_for(HasSubstr("\nturns "));
  const auto lines = split(screen, '\n');
  EXPECT_EQ(lines.size(), 3U) << screen;
  for (const std::string& line : lines) EXPECT_LE(line.size(), 12U) << line;
  terminal.type('q');
  EXPECT_EQ(wait(reader), 0);
}

TEST_F(ReadLive, TerminalThatTakesNothing_StopsNoRequest) {
  const Emulator emulator(folder, {});
  const Terminal terminal(200, 500);
  const pid_t reader =
      read(emulator, terminal, format + Words("--cycles 5000 --record {}", folder.path("all.log")));
  EXPECT_EQ(wait(reader), 0);
  EXPECT_THAT(content_of(err), HasSubstr("5000 words"));
  const std::string record = content_of(folder.path("all.log"));
  EXPECT_EQ(std::count(record.begin(), record.end(), '\n'), 5001);
}

TEST_F(ReadLive, ChannelsOfAChain) {
  Terminal terminal;
  const std::string two = "pos26,nE,nW,crc6+pos20,nE,nW,crc6";
  const pid_t reader =
      start(Words{BISS_COMMAND, "emulate", "-f", two, "--motion", "constant", "--", BISS_COMMAND,
                  "read", "--port", "spi:/dev/spidev0.0", "-f", two, "--live"},
            terminal.path, terminal.path, err);
  terminal.wait_for(AllOf(ContainsRegex("\nchannel 1\nposition +-?[0-9]+ counts"),
                          ContainsRegex("\nchannel 2\nposition +-?[0-9]+ counts")));
  terminal.type('q');
  EXPECT_EQ(wait(reader), 0) << content_of(err);
}

TEST_F(ReadLive, FormatThatIsNotKnown_IsRefused) {
  const Emulator emulator(folder, {});
  const Terminal terminal;
  const pid_t reader = read(emulator, terminal, Words("-f none"));
  EXPECT_EQ(wait(reader), 2);
  EXPECT_THAT(content_of(err), HasSubstr("--live: the format of the frame is not known; give -f"));
}

// The page decodes the record: view/test/live.test.mjs.
TEST_F(ReadLive, Server_GivesTheRecordAsItGrows) {
  auto emulator = std::make_unique<Emulator>(folder, Words("--motion constant"));
  emulator->ask("at 4711");
  view_test::Server server(folder, Words("--port spi:{} -f resolute-26 --scale deg", emulator->at));
  EXPECT_THAT(server.get(""), AllOf(HasSubstr("data-live=\"size\""), HasSubstr("units=deg")));
  std::string record;
  const auto wait_for_record = [&](const testing::Matcher<std::string>& wanted) {
    for (int i = 0; i < 3000 && !wanted.Matches(record); ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
      const std::string range = fmt::format("Range: bytes={}-\r\n", record.size());
      const std::string answer = server.get("capture", range);
      if (answer.starts_with("HTTP/1.1 206")) record += view_test::body_of(answer);
    }
    EXPECT_THAT(record, wanted);
  };
  wait_for_record(ContainsRegex("\n[0-9]+ns [0-9A-F]+\n"));
  const Outcome rows =
      run_ok("decode --words {} -f resolute-26 --to csv", folder.file("words.log", record));
  EXPECT_THAT(rows.out, HasSubstr(",ok,4711,"));
  emulator->end(SIGKILL);
  emulator.reset();
  wait_for_record(HasSubstr("# a transfer failed: gone\n"));
  EXPECT_EQ(server.end(SIGTERM), 0);
}

TEST(ReadLiveUsage, MistakesAreNamed) {
  EXPECT_THAT(run("read --port spi:/no/device -f resolute-26 --live"),
              refuses(2, "--live: standard output is not a terminal"));
  EXPECT_THAT(run("read --port spi:/no/device -f resolute-26 --live -o rows.csv"),
              fails(2, "--output"));
}

}  // namespace biss::verbs::live_test
