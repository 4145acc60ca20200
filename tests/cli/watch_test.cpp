// `biss watch`: captures that become worse, a state that survives, files that grow, and programs that
// take the figures.
#include <sys/wait.h>
#include <unistd.h>

#include <thread>

#include "tests/cli/emulator.hpp"
#include "tests/cli/view_server.hpp"
#include "tests/common/long_run.hpp"
#include "tests/common/random.hpp"

namespace biss::verbs::watch_test {

using testing::ContainsRegex;
using testing::HasSubstr;
using testing::Not;

template <class Condition>
bool wait_for(Condition condition) {
  for (int k = 0; k < 2000 && !condition(); ++k) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return condition();
}

int end(pid_t process, int signal) {
  ::kill(process, signal);
  int status = 0;
  ::waitpid(process, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

// A port of this machine that nobody uses.
std::uint16_t free_port() {
  const int socket = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in place{};
  place.sin_family = AF_INET;
  place.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof place;
  EXPECT_EQ(::bind(socket, reinterpret_cast<const sockaddr*>(&place), size), 0);
  ::getsockname(socket, reinterpret_cast<sockaddr*>(&place), &size);
  ::close(socket);
  return ntohs(place.sin_port);
}

std::uint64_t cycles_in(const std::string& state) {
  const Outcome shown = run("watch show {}", state);
  return shown.status == 0 ? std::strtoull(shown.err.c_str(), nullptr, 10) : 0;
}

class Watch : public InFolder {
 protected:
  void SetUp() override { std::filesystem::create_directory(captures); }

  // A capture with these options; without a cable of its own.
  void capture(int number, const std::string& options, int cycles = 300) const {
    ok(run(Words("simulate -f resolute-26 --clock 5MHz --rate 10kHz --cycles {} --seed {} -o {}",
                 cycles, number, path(number)) +
           Words(options.c_str())));
  }
  std::string path(int number) const { return fmt::format("{}/c{:03}.csv", captures, number); }
  void healthy(int count) const {
    for (int k = 0; k < count; ++k) capture(k, "--cable 80m --jitter 3ns");
  }
  Outcome watch(const Words& more) const {
    return run(Words("watch {} -f resolute-26 --baseline 8", captures) + more);
  }
  std::uint64_t cycles_in_state() const { return cycles_in(state); }

  const std::string captures = folder.path("captures");
  const std::string state = folder.path("axis.health");
};

TEST_F(Watch, EachWayToBecomeWorse_IsNamedBeforeTheFirstWrongFrame) {
  struct Case {
    const char* alarm;
    std::function<std::string(int)> options;
  };
  const std::string usual = "--cable 80m --jitter 3ns";
  const Case cases[] = {
      {"delay", [](int k) { return fmt::format("--cable {}m --jitter 3ns", 80 + k); }},
      {"noise", [](int k) { return fmt::format("--cable 80m --jitter {}ns", 3 + 4 * k); }},
      {"cable",
       [](int k) { return fmt::format("--cable {}m --jitter {}ns", 80 + k / 2, 3 + 4 * k); }},
      {"encoder", [&](int k) { return usual + fmt::format(" --fault nW:0.{:02}", 5 + k); }},
      {"noise",
       [&](int k) { return usual + fmt::format(" --fault glitch_slo_idle:0.{:02}", 5 + k); }},
  };
  healthy(8);
  for (const auto& [alarm, options] : cases) {
    for (int k = 1; k <= 8; ++k) capture(7 + k, options(k));
    const Outcome outcome = watch({});
    EXPECT_EQ(outcome.status, 1);
    EXPECT_THAT(outcome.err, ContainsRegex(fmt::format("Z  alarm {}: .*so far: 0\n", alarm)));
  }
}

TEST_F(Watch, IntermittentContact) {
  healthy(8);
  for (int k = 0; k < 4; ++k) {
    capture(8 + k, "--cable 80m --jitter 3ns --fault no_answer@100 --fault no_answer@101");
  }
  EXPECT_THAT(watch({}),
              fails(1, "alarm contact: answers to several requests in a row are missing"));
}

TEST_F(Watch, HealthyLink_HasARowForEachCapture_AndNoAlarm) {
  healthy(12);
  const Outcome outcome = watch(Words("--to csv"));
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("alarms      none"));
  const std::vector<Row> rows = rows_of(outcome.out);
  ASSERT_EQ(rows.size(), 12U);
  for (const Row& row : rows) {
    EXPECT_EQ(row.at("good"), "300");
    EXPECT_EQ(row.at("alarms"), "");
    EXPECT_NEAR(std::stod(row.at("line_delay_ns")), 842.5, 2);
  }
}

TEST_F(Watch, State_CountsEachCycleOnce) {
  healthy(3);
  EXPECT_EQ(watch(Words("--state {}", state)).status, 0);
  EXPECT_EQ(cycles_in_state(), 900U);
  // Nothing is new.
  const Outcome again = watch(Words("--state {} --to csv", state));
  EXPECT_EQ(rows_of(again.out).size(), 0U);
  EXPECT_EQ(cycles_in_state(), 900U);
  // One file is new, and will have more cycles.
  capture(3, "--cable 80m --jitter 3ns", 500);
  const std::string whole = content_of(path(3));
  const std::size_t half = whole.find('\n', whole.size() / 2) + 1;
  std::ofstream(path(3)) << whole.substr(0, half);
  EXPECT_EQ(watch(Words("--state {}", state)).status, 0);
  EXPECT_LT(cycles_in_state(), 1200U);
  std::ofstream(path(3), std::ios::app) << whole.substr(half);
  EXPECT_EQ(watch(Words("--state {}", state)).status, 0);
  EXPECT_EQ(cycles_in_state(), 1400U);
}

TEST_F(Watch, KilledAtAnyTime_LosesAndDoublesNothing) {
  auto random = test::random_of();
  const int kills = static_cast<int>(test::rounds(100, 10));
  std::uint64_t all = 0;
  for (int k = 0; k < kills; ++k) {
    capture(k, "--cable 80m --jitter 3ns --fault cut:0.01", 3000);
    all += 3000;
    const pid_t process = start(Words{BISS_COMMAND} + Words("watch {} -f resolute-26 --baseline 8 "
                                                            "--interval 10ms --state {}",
                                                            captures, state));
    std::this_thread::sleep_for(std::chrono::microseconds(random() % 60'000));
    end(process, SIGKILL);
  }
  EXPECT_LE(watch(Words("--interval 10ms --state {}", state)).status, 1);
  EXPECT_EQ(cycles_in_state(), all);
  // As one run that nothing has ended.
  const std::string other = folder.path("other.health");
  EXPECT_LE(watch(Words("--interval 10ms --state {}", other)).status, 1);
  const auto status_of = [](const std::string& err) {
    const std::size_t at = err.find("status ");
    return err.substr(at, err.find("flags") - at);
  };
  EXPECT_EQ(status_of(run("watch show {}", state).err), status_of(run("watch show {}", other).err));
}

// The state as a run leaves it that is killed after any of its lines.
TEST_F(Watch, StateThatEndsAfterAnyLine_LosesAndDoublesNothing) {
  for (int k = 0; k < 3; ++k) capture(k, "--cable 80m --jitter 3ns", 600);
  const Words words("--interval 10ms --state {}", state);
  EXPECT_EQ(watch(words).status, 0);
  const std::string whole = content_of(state);
  int lines = 0;
  for (std::size_t end = whole.find('\n'); end != std::string::npos;
       end = whole.find('\n', end + 1)) {
    std::ofstream(state) << whole.substr(0, end + 1);
    EXPECT_LE(watch(words).status, 1);
    EXPECT_EQ(cycles_in_state(), 1800U) << "after line " << lines;
    ++lines;
  }
  EXPECT_GT(lines, 10);
}

TEST_F(Watch, FileThatGrows) {
  capture(0, "--cable 80m --jitter 3ns", 6000);
  const std::string whole = content_of(path(0));
  const std::string growing = folder.path("line.csv");
  std::ofstream file(growing);
  const auto write = [&](std::size_t from, std::size_t to) {
    file.write(whole.data() + from, static_cast<std::streamsize>(to - from));
    file.flush();
  };
  write(0, whole.size() / 2 + 5);
  const Words words = Words{BISS_COMMAND} + Words(
                                                "watch {} -f resolute-26 --follow --interval "
                                                "50ms --state {}",
                                                growing, state);
  const pid_t process = start(words);
  ASSERT_TRUE(wait_for([&] { return std::filesystem::exists(state); }));
  write(whole.size() / 2 + 5, whole.size());
  ASSERT_TRUE(wait_for([&] { return cycles_in_state() > 5000; }));
  EXPECT_EQ(end(process, SIGTERM), 0);
  EXPECT_GE(cycles_in_state(), 5990U);
  // The next run takes the rest, and nothing again.
  EXPECT_EQ(run("watch {} -f resolute-26 --interval 50ms --state {}", growing, state).status, 0);
  EXPECT_EQ(cycles_in_state(), 6000U);
}

TEST_F(Watch, FolderThatGetsNewFiles) {
  healthy(2);
  const pid_t process = start(
      Words{BISS_COMMAND} + Words("watch {} -f resolute-26 --follow --state {}", captures, state));
  ASSERT_TRUE(wait_for([&] { return std::filesystem::exists(state) && cycles_in_state() == 600; }));
  capture(2, "--cable 80m --jitter 3ns");
  EXPECT_TRUE(wait_for([&] { return cycles_in_state() == 900; }));
  EXPECT_EQ(end(process, SIGTERM), 0);
}

TEST_F(Watch, WithoutAFormat_AllAreJudgedByTheFormatOfTheFirst) {
  healthy(8);
  for (int k = 0; k < 4; ++k) capture(8 + k, "--cable 80m --jitter 3ns --fault flip:0.8");
  for (int k = 0; k < 4; ++k) capture(12 + k, "--cable 80m --jitter 3ns --fault nE:1");
  const Outcome outcome = run("watch {} --baseline 8 --state {}", captures, state);
  EXPECT_EQ(outcome.status, 1);
  EXPECT_THAT(outcome.err, HasSubstr("judged by its format, pos26,nE,nW,crc6"));
  EXPECT_THAT(outcome.err, HasSubstr("alarm noise: frames are damaged"));
  EXPECT_THAT(outcome.err, HasSubstr("alarm encoder: nE is active"));
  // Nothing of a capture without a format.
  EXPECT_THAT(run("watch {}", path(12)), fails(1, "its format is not known"));
}

TEST_F(Watch, FileThatIsOverwritten_IsAnotherFile) {
  healthy(1);
  const std::string file = folder.file("line.csv", content_of(path(0)));
  EXPECT_EQ(run("watch {} -f resolute-26 --state {}", file, state).status, 0);
  capture(1, "--cable 70m --jitter 3ns", 400);
  std::ofstream(file) << content_of(path(1));
  EXPECT_EQ(run("watch {} -f resolute-26 --state {}", file, state).status, 0);
  EXPECT_EQ(cycles_in_state(), 700U);
}

TEST_F(Watch, NothingToWatch_IsNotSuccess) {
  EXPECT_THAT(watch({}), fails(1, "no cycle was read"));
}

TEST_F(Watch, FileThatCannotBeRead_IsNamed_AndTheOthersAreWatched) {
  healthy(2);
  std::ofstream(captures + "/b.vcd") << "no capture";
  const Outcome outcome = watch(Words("--to csv"));
  EXPECT_THAT(outcome, fails(3, "b.vcd"));
  EXPECT_EQ(rows_of(outcome.out).size(), 2U);
}

TEST_F(Watch, StateOfOtherOptions_OrDamaged_OrOfAnotherVerb_IsRefused) {
  healthy(1);
  EXPECT_EQ(watch(Words("--state {}", state)).status, 0);
  EXPECT_THAT(run("watch {} -f resolute-26 --baseline 9 --state {}", captures, state),
              refuses(3, "it was written with other options"));
  std::ofstream(state, std::ios::app) << "{\"counts\":1}\n";
  EXPECT_THAT(watch(Words("--state {}", state)), refuses(3, "is damaged"));
  EXPECT_THAT(run("watch show {}", state), refuses(3, "is damaged"));
  EXPECT_THAT(watch(Words("--state {}", path(0))), refuses(3, "not a journal of biss watch"));
  EXPECT_THAT(run("watch show {}", path(0)), refuses(3, "not a state of biss watch"));
}

TEST_F(Watch, Prometheus) {
  healthy(3);
  capture(3, "--cable 80m --jitter 3ns --fault no_answer@100");
  const std::uint16_t port = free_port();
  const pid_t process =
      start(Words{BISS_COMMAND} +
            Words("watch {} -f resolute-26 --follow --listen 127.0.0.1:{} --state {}", captures,
                  port, state));
  std::string text;
  EXPECT_TRUE(wait_for([&] {
    const view_test::Client client(port);
    if (!client.connected()) return false;
    client.send("GET /metrics HTTP/1.0\r\n\r\n");
    text = client.receive();
    return text.find("biss_cycles_total{status=\"no_response\"} 1") != std::string::npos;
  })) << text;
  EXPECT_THAT(text, HasSubstr("biss_cycles_total{status=\"ok\"} 1199"));
  EXPECT_THAT(text, HasSubstr("biss_alarm{alarm=\"noise\"} 0"));
  EXPECT_THAT(text, HasSubstr("biss_line_delay_seconds 8.4"));
  EXPECT_THAT(run("watch {} -f resolute-26 --listen 127.0.0.1:{}", captures, port),
              fails(3, "another program uses the port"));
  EXPECT_EQ(end(process, SIGTERM), 0);
  EXPECT_THAT(watch(Words("--listen 0.0.0.0:9464")), refuses(2, "write 127.0.0.1:PORT"));
}

TEST_F(Watch, BrokerThatIsNotThere_IsNamed) {
  healthy(2);
  const Outcome outcome = watch(Words("--mqtt 127.0.0.1:1 --topic axis/1 --to csv"));
  EXPECT_THAT(outcome, fails(0, "--mqtt 127.0.0.1:1: the broker has not taken 8 messages"));
  EXPECT_EQ(rows_of(outcome.out).size(), 2U);
  EXPECT_THAT(watch(Words("--mqtt 127.0.0.1:1 --topic axis/#")), refuses(2, "--topic"));
}

TEST_F(Watch, SubscriberOfABroker) {
  if (std::system("command -v mosquitto mosquitto_sub >/dev/null") != 0) {
    GTEST_SKIP() << "mosquitto is not installed";
  }
  healthy(8);
  for (int k = 0; k < 3; ++k) capture(8 + k, "--cable 80m --jitter 3ns --fault nW:0.2");
  const std::uint16_t port = free_port();
  const pid_t broker = start(Words("mosquitto -p {}", port));
  const std::string got = folder.path("got.txt");
  ASSERT_TRUE(wait_for([port] { return view_test::Client(port).connected(); }));
  const pid_t subscriber =
      start(Words("mosquitto_sub -p {} -t axis/# -v -C 18", port), "/dev/null", got);
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  const Outcome outcome = watch(Words("--mqtt 127.0.0.1:{} --topic axis", port));
  EXPECT_THAT(outcome.err, Not(HasSubstr("has not taken")));
  int status = 0;
  ::waitpid(subscriber, &status, 0);
  end(broker, SIGTERM);
  const std::string text = content_of(got);
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 18) << text;
  EXPECT_THAT(text, ContainsRegex("axis/interval \\{\"time\":.*\"cycles\":300"));
  EXPECT_THAT(text, ContainsRegex("axis/alarm/encoder nW is active"));
}

// An emulated encoder at a port.
class WatchPort : public Emulate {};

TEST_F(WatchPort, WarningAndUnpluggedCable_AreAlarms) {
  Emulator encoder(folder, {});
  const std::string state = folder.path("axis.health");
  const std::string err = folder.path("watch.err");
  const Words words =
      Words{BISS_COMMAND, "watch", "--port", "spi:" + encoder.at} +
      Words("-f resolute-26 --clock 4MHz --interval 250ms --baseline 4 --state {}", state);
  pid_t process = start(words, "/dev/null", "/dev/null", err);
  ASSERT_TRUE(wait_for([&] { return cycles_in(state) > 2'000; })) << content_of(err);
  const auto says = [&](const char* text) {
    return wait_for([&] { return content_of(err).find(text) != std::string::npos; });
  };
  encoder.ask("nW 0");
  EXPECT_TRUE(says("alarm encoder: nW is active")) << content_of(err);
  encoder.ask("unplug");
  EXPECT_TRUE(says("alarm silent: no good frame")) << content_of(err);
  encoder.ask("plug");
  // The state is at most half a second old.
  const std::uint64_t cycles = cycles_in(state);
  EXPECT_EQ(end(process, SIGKILL), 128 + SIGKILL);
  EXPECT_GE(cycles_in(state), cycles);
  process = start(words, "/dev/null", "/dev/null", err);
  EXPECT_TRUE(wait_for([&] { return cycles_in(state) > cycles + 1'000; })) << content_of(err);
  EXPECT_EQ(end(process, SIGTERM), 1);
  EXPECT_THAT(content_of(err), HasSubstr("alarm encoder"));
}

TEST_F(WatchPort, DeviceThatVanishes_IsSilent) {
  auto encoder = std::make_unique<Emulator>(folder, Words());
  const std::string state = folder.path("axis.health");
  const std::string err = folder.path("watch.err");
  const pid_t process = start(
      Words{BISS_COMMAND, "watch", "--port", "spi:" + encoder->at} +
          Words("-f resolute-26 --clock 4MHz --interval 250ms --baseline 4 --state {}", state),
      "/dev/null", "/dev/null", err);
  ASSERT_TRUE(wait_for([&] { return cycles_in(state) > 2'000; })) << content_of(err);
  encoder.reset();
  EXPECT_TRUE(wait_for([&] {
    return content_of(err).find("alarm silent: no cycle was read") != std::string::npos;
  })) << content_of(err);
  EXPECT_EQ(end(process, SIGTERM), 1);
}

}  // namespace biss::verbs::watch_test
