// The emulated encoder for tests of the command: programs read it through spidev.
#pragma once

#include <sys/wait.h>
#include <unistd.h>

#include <thread>

#include "tests/cli/run_command.hpp"

namespace biss::verbs {

using Rows = std::vector<Row>;

inline constexpr const char* line26 = "-f resolute-26 --clock 5MHz --cable 10m";

/// With --time the bytes do not depend on the speed of this machine.
inline Words emulate(const Words& options, const Words& command) {
  return Words{"emulate"} + Words(line26) + options + Words{"--"} + command;
}

/// `biss emulate --at` until the end of the test.
class Emulator {
 public:
  Emulator(const Folder& folder, const Words& more, const Words& line = Words(line26))
      : at(folder.path("spidev")), ctl(folder.path("ctl")) {
    process_ = start(Words{BISS_COMMAND, "emulate", "--at", at, "--ctl", ctl} + line + more,
                     "/dev/null", folder.path("ready"), folder.path("err"));
    for (int i = 0; i < 500 && content_of(folder.path("ready")) != at + "\n"; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    EXPECT_EQ(content_of(folder.path("ready")), at + "\n") << content_of(folder.path("err"));
  }
  ~Emulator() {
    if (process_ > 0) end(SIGKILL);
    run_client(Words{"fusermount3", "-q", "-u", "-z", at});
  }
  Emulator(const Emulator&) = delete;
  Emulator& operator=(const Emulator&) = delete;

  int end(int signal) {
    ::kill(process_, signal);
    return wait();
  }
  int wait() {
    int status = 0;
    ::waitpid(std::exchange(process_, -1), &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }
  std::string ask(const std::string& command) const {
    const Outcome outcome = run(Words{"emulate", "ctl", ctl, command});
    EXPECT_EQ(outcome.status, outcome.out.starts_with("ok") ? 0 : 1) << outcome.err;
    return outcome.out;
  }
  static int run_client(const Words& words, const std::string& out = "/dev/null") {
    int status = -1;
    ::waitpid(start(words, "/dev/null", out, out + ".err"), &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }

  const std::string at;
  const std::string ctl;

 private:
  pid_t process_ = -1;
};

class Emulate : public InFolder {
 protected:
  // A machine without FUSE, or a container without the right to mount.
  void SetUp() override {
    const Outcome probe = run(emulate({}, {"true"}));
    if (probe.status == 3) GTEST_SKIP() << "FUSE cannot be mounted here: " << probe.err;
    ASSERT_EQ(probe.status, 0) << probe.err;
  }

  // Each request that was read: undamaged with the position that was sent, damaged never with
  // another one. \return the number of damaged ones
  std::size_t expect_read(const std::string& words, const std::string& truth, std::size_t count) {
    const std::string log = folder.file("words.log", words);
    const auto rows =
        rows_of(run(Words{"decode", "--words", log, "-f", "resolute-26", "--to", "csv"}).out);
    const auto sent = rows_of(truth);
    EXPECT_EQ(rows.size(), count);
    EXPECT_EQ(sent.size(), count);
    return expect_rows(rows, sent);
  }
  static std::size_t expect_rows(const Rows& rows, const Rows& sent) {
    std::size_t damaged = 0;
    bool before = false;
    for (std::size_t k = 0; k < std::min(rows.size(), sent.size()); ++k) {
      const bool now = !sent[k].at("faults").empty();
      const bool good = rows[k].at("status") == "ok" && rows[k].at("nE") == "1";
      if (good || !(now || before)) {
        EXPECT_TRUE(good) << k << ' ' << rows[k].at("status");
        EXPECT_EQ(rows[k].at("position"), sent[k].at("position")) << k << sent[k].at("faults");
      }
      damaged += now && !good ? 1U : 0U;
      before = now;
    }
    return damaged;
  }
};

}  // namespace biss::verbs
