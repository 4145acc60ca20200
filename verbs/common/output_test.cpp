#include "verbs/common/output.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <pty.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "capture/test_folder.hpp"

namespace biss::verbs {
namespace output_test {

namespace fs = std::filesystem;
using test::content_of;

// Ignores SIGPIPE as the command does.
class OutputTest : public testing::Test {
 protected:
  OutputTest() { std::signal(SIGPIPE, SIG_IGN); }

  std::string path(const std::string& name) const { return folder_.path(name); }
  static void put(const std::string& path, const std::string& text) {
    std::ofstream(path, std::ios::binary) << text;
  }
  static mode_t mode(const std::string& path) {
    struct stat about {};
    EXPECT_EQ(::stat(path.c_str(), &about), 0);
    return about.st_mode & 07777U;
  }

  const test::Folder folder_;
  ProcessHost host_;
};

TEST_F(OutputTest, NewFile_AppearsOnlyAtTheEndWithTheModeOfTheUmask) {
  const mode_t before = ::umask(027);
  Output output(host_);
  ASSERT_TRUE(output.open(path("new.csv")));
  ASSERT_TRUE(output.write("text\n"));
  EXPECT_FALSE(fs::exists(path("new.csv")));
  EXPECT_TRUE(output.finish());
  ::umask(before);
  EXPECT_EQ(content_of(path("new.csv")), "text\n");
  EXPECT_EQ(mode(path("new.csv")), 0640U);
  EXPECT_EQ(folder_.files(), 1U);
  EXPECT_EQ(output.status(), ExitStatus::done);
}

TEST_F(OutputTest, ExistingFile_StaysUntilTheEndAndKeepsItsMode) {
  put(path("old"), "old");
  fs::permissions(path("old"), fs::perms(0600));
  Output output(host_);
  ASSERT_TRUE(output.open(path("old")));
  ASSERT_TRUE(output.write(std::string(1'000'000, 'x')));
  EXPECT_EQ(content_of(path("old")), "old");
  ASSERT_TRUE(output.finish());
  EXPECT_EQ(content_of(path("old")).size(), 1'000'000U);
  EXPECT_EQ(mode(path("old")), 0600U);
}

TEST_F(OutputTest, NoFinish_LeavesTheOldFileAndNoTemporaryOne) {
  put(path("old"), "old");
  {
    Output output(host_);
    ASSERT_TRUE(output.open(path("old")));
    output.write("half");
  }
  EXPECT_EQ(content_of(path("old")), "old");
  EXPECT_EQ(folder_.files(), 1U);
}

TEST_F(OutputTest, Abandoned_LeavesNothing) {
  Output output(host_);
  ASSERT_TRUE(output.open(path("new")));
  output.write("half");
  output.abandon();
  EXPECT_EQ(folder_.files(), 0U);
  EXPECT_FALSE(output.write("more"));
  EXPECT_FALSE(output.finish());
}

TEST_F(OutputTest, SymbolicLink_StaysAndItsTargetIsReplaced) {
  fs::create_directory(path("deep"));
  put(path("deep/target"), "old");
  fs::create_symlink("deep/target", path("link"));
  fs::create_symlink("link", path("link2"));
  Output output(host_);
  ASSERT_TRUE(output.open(path("link2")));
  output.write("new");
  ASSERT_TRUE(output.finish());
  EXPECT_TRUE(fs::is_symlink(path("link2")));
  EXPECT_TRUE(fs::is_symlink(path("link")));
  EXPECT_EQ(content_of(path("deep/target")), "new");
}

TEST_F(OutputTest, DanglingLink_CreatesItsTarget) {
  fs::create_symlink("missing", path("link"));
  Output output(host_);
  ASSERT_TRUE(output.open(path("link")));
  output.write("new");
  ASSERT_TRUE(output.finish());
  EXPECT_TRUE(fs::is_symlink(path("link")));
  EXPECT_EQ(content_of(path("missing")), "new");
}

TEST_F(OutputTest, LinksInACircle_AreAnError) {
  fs::create_symlink("b", path("a"));
  fs::create_symlink("a", path("b"));
  Output output(host_);
  EXPECT_FALSE(output.open(path("a")));
  EXPECT_EQ(output.status(), ExitStatus::io);
}

TEST_F(OutputTest, LongestName_IsWritten) {
  const std::string name(255, 'n');
  Output output(host_);
  ASSERT_TRUE(output.open(path(name)));
  output.write("x");
  EXPECT_TRUE(output.finish());
  EXPECT_EQ(content_of(path(name)), "x");
}

TEST_F(OutputTest, Folder_IsRefused) {
  Output output(host_);
  const std::string folder = fs::path(path("x")).parent_path().string();
  EXPECT_FALSE(output.open(folder));
  EXPECT_EQ(output.error(), "cannot write '" + folder + "': Is a directory");
  EXPECT_EQ(output.status(), ExitStatus::io);
}

TEST_F(OutputTest, FolderMissing_IsRefused) {
  Output output(host_);
  EXPECT_FALSE(output.open(path("none/file")));
  EXPECT_NE(output.error().find("No such file"), std::string::npos) << output.error();
}

TEST_F(OutputTest, TwoOutputsInOneFolder_DoNotDisturbEachOther) {
  Output a(host_);
  Output b(host_);
  ASSERT_TRUE(a.open(path("a")));
  ASSERT_TRUE(b.open(path("b")));
  a.write("A");
  b.write("B");
  ASSERT_TRUE(b.finish());
  ASSERT_TRUE(a.finish());
  EXPECT_EQ(content_of(path("a")), "A");
  EXPECT_EQ(content_of(path("b")), "B");
}

TEST_F(OutputTest, TargetBecomesAFolder_FailsTheFinish) {
  Output output(host_);
  ASSERT_TRUE(output.open(path("x")));
  output.write("text");
  fs::create_directory(path("x"));
  EXPECT_FALSE(output.finish());
  EXPECT_EQ(output.status(), ExitStatus::io);
  EXPECT_EQ(folder_.files(), 1U);
}

TEST_F(OutputTest, DevNull_TakesAllAndStaysADevice) {
  Output output(host_);
  ASSERT_TRUE(output.open("/dev/null"));
  EXPECT_TRUE(output.write(std::string(200'000, 'x')));
  EXPECT_TRUE(output.finish());
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

TEST_F(OutputTest, DevFull_SmallText_FailsTheFinish) {
  Output output(host_);
  ASSERT_TRUE(output.open("/dev/full"));
  EXPECT_TRUE(output.write("x"));
  EXPECT_FALSE(output.finish());
  EXPECT_EQ(output.error(), "cannot write '/dev/full': No space left on device");
  EXPECT_EQ(output.status(), ExitStatus::io);
}

TEST_F(OutputTest, DevFull_LargeText_FailsTheWriteAndAllAfter) {
  Output output(host_);
  ASSERT_TRUE(output.open("/dev/full"));
  EXPECT_FALSE(output.write(std::string(200'000, 'x')));
  EXPECT_FALSE(output.write("more"));
  EXPECT_FALSE(output.finish());
  EXPECT_EQ(output.status(), ExitStatus::io);
}

TEST_F(OutputTest, NamedPipe_IsWrittenStraight) {
  ASSERT_EQ(::mkfifo(path("pipe").c_str(), 0600), 0);
  std::string received;
  std::thread reader([&] { received = content_of(path("pipe")); });
  Output output(host_);
  EXPECT_TRUE(output.open(path("pipe")));
  EXPECT_TRUE(output.write(std::string(300'000, 'x')));
  EXPECT_TRUE(output.finish());
  reader.join();
  EXPECT_EQ(received.size(), 300'000U);
  EXPECT_TRUE(fs::is_fifo(path("pipe")));
}

TEST_F(OutputTest, ReaderLeaves_DropsTheRestWithoutAnError) {
  int ends[2] = {};
  ASSERT_EQ(::pipe(ends), 0);
  Output output(host_);
  ASSERT_TRUE(output.open("/dev/fd/" + std::to_string(ends[1])));
  ::close(ends[0]);
  EXPECT_FALSE(output.reader_left());
  EXPECT_TRUE(output.write(std::string(200'000, 'x')));
  EXPECT_TRUE(output.reader_left());
  EXPECT_TRUE(output.write(std::string(200'000, 'x')));
  EXPECT_TRUE(output.finish());
  EXPECT_EQ(output.error(), "");
  EXPECT_EQ(output.status(), ExitStatus::done);
  ::close(ends[1]);
}

TEST_F(OutputTest, NameOfAnOpenFile_IsAppendedToAndNotReplaced) {
  put(path("log"), "first\n");
  const int descriptor = ::open(path("log").c_str(), O_WRONLY | O_APPEND | O_CLOEXEC);
  ASSERT_GE(descriptor, 0);
  Output output(host_);
  ASSERT_TRUE(output.open("/dev/fd/" + std::to_string(descriptor)));
  output.write("second\n");
  ASSERT_TRUE(output.finish());
  ::close(descriptor);
  EXPECT_EQ(content_of(path("log")), "first\nsecond\n");
}

TEST_F(OutputTest, AbandonedStraight_KeepsWhatWasTaken) {
  put(path("log"), "");
  const int descriptor = ::open(path("log").c_str(), O_WRONLY | O_CLOEXEC);
  ASSERT_GE(descriptor, 0);
  {
    Output output(host_);
    ASSERT_TRUE(output.open("/dev/fd/" + std::to_string(descriptor)));
    output.write("so far\n");
  }
  ::close(descriptor);
  EXPECT_EQ(content_of(path("log")), "so far\n");
}

// Makes open() with O_TMPFILE fail from now on, as on a file system that does not support it.
bool refuse_files_without_name() {
  constexpr std::uint32_t flag = O_TMPFILE & ~O_DIRECTORY;
  sock_filter steps[] = {BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr)),
                         BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_openat, 0, 3),
                         BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, args[2])),
                         BPF_JUMP(BPF_JMP | BPF_JSET | BPF_K, flag, 0, 1),
                         BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | EOPNOTSUPP),
                         BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW)};
  const sock_fprog program{std::size(steps), steps};
  return ::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 &&
         ::prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program) == 0;
}

// The exit status of a child process that runs `body`.
template <class Body>
int status_of(const Body& body) {
  const pid_t child = ::fork();
  if (child == 0) {
    body();
    ::_exit(8);
  }
  int status = -1;
  EXPECT_EQ(::waitpid(child, &status, 0), child);
  return status;
}

TEST_F(OutputTest, Killed_LeavesTheOldFileAndNoOther) {
  put(path("old"), "old");
  const int status = status_of([this] {
    Output output(host_);
    if (!output.open(path("old")) || !output.write(std::string(200'000, 'x'))) ::_exit(9);
    std::raise(SIGKILL);
  });
  EXPECT_TRUE(WIFSIGNALED(status));
  EXPECT_EQ(content_of(path("old")), "old");
  EXPECT_EQ(folder_.files(), 1U);
}

TEST_F(OutputTest, FileSystemWithoutNamelessFiles_ReplacesTheFileAsElsewhere) {
  put(path("old"), "old");
  const int status = status_of([this] {
    if (!refuse_files_without_name()) ::_exit(9);
    Output output(host_);
    if (!output.open(path("old")) || !output.write("new") || folder_.files() != 2) ::_exit(1);
    ::_exit(output.finish() ? 0 : 2);
  });
  EXPECT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0);
  EXPECT_EQ(content_of(path("old")), "new");
  EXPECT_EQ(folder_.files(), 1U);
}

TEST_F(OutputTest, SignalThatEndsTheProcess_RemovesTheTemporaryFile) {
  put(path("old"), "old");
  const int status = status_of([this] {
    prepare_process();
    Output output(host_);
    if (!refuse_files_without_name() || !output.open(path("old"))) ::_exit(9);
    if (!output.write("half") || folder_.files() != 2) ::_exit(9);
    std::raise(SIGTERM);
  });
  EXPECT_TRUE(WIFSIGNALED(status));
  EXPECT_EQ(WTERMSIG(status), SIGTERM);
  EXPECT_EQ(content_of(path("old")), "old");
  EXPECT_EQ(folder_.files(), 1U);
}

TEST_F(OutputTest, FileSizeLimit_IsAnErrorAndLeavesTheOldFile) {
  put(path("old"), "old");
  const int status = status_of([this] {
    prepare_process();
    const rlimit limit = {4096, 4096};
    if (::setrlimit(RLIMIT_FSIZE, &limit) != 0) ::_exit(9);
    Output output(host_);
    const bool reported = output.open(path("old")) && !output.write(std::string(200'000, 'x')) &&
                          !output.error().empty();
    ::_exit(reported ? 0 : 1);
  });
  EXPECT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0);
  EXPECT_EQ(content_of(path("old")), "old");
  EXPECT_EQ(folder_.files(), 1U);
}

TEST_F(OutputTest, StdoutClosed_IsAnErrorAndNoOtherFileTakesItsPlace) {
  const int status = status_of([this] {
    ::close(STDOUT_FILENO);
    prepare_process();
    const int file = ::open(path("victim").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
    Output output(host_);
    const bool reported =
        output.open("-") && output.write("text") && !output.finish() && !output.error().empty();
    ::_exit(file > STDERR_FILENO && reported ? 0 : 1);
  });
  EXPECT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0);
  EXPECT_EQ(fs::file_size(path("victim")), 0U);
}

TEST_F(OutputTest, Colour_IsForTerminalsOnly) {
  Output output(host_);
  ASSERT_TRUE(output.open("/dev/null"));
  EXPECT_FALSE(output.table_options().colour);
  EXPECT_EQ(output.table_options().width, 0U);
}

// A terminal, and what it gets of a text that is written to its path.
class OnTerminal {
 public:
  OnTerminal() {
    termios raw{};
    ::cfmakeraw(&raw);
    EXPECT_EQ(::openpty(&reader_, &terminal_, nullptr, &raw, nullptr), 0);
  }
  ~OnTerminal() {
    ::close(terminal_);
    ::close(reader_);
  }
  OnTerminal(const OnTerminal&) = delete;
  OnTerminal& operator=(const OnTerminal&) = delete;

  std::string path() const { return ::ttyname(terminal_); }
  std::string read() const {
    std::string text(4096, '\0');
    const ssize_t got = ::read(reader_, text.data(), text.size());
    text.resize(got > 0 ? static_cast<std::size_t>(got) : 0);
    return text;
  }

 private:
  int reader_ = -1;
  int terminal_ = -1;
};

const std::string hostile =
    "\x1b[2J\x07\r\b\xE2\x80\xAE\xC2\x9B"
    "1m\x9B\x7F\xE2\x81\xA6\xC3\xA9";

bool is_harmless(const std::string& text) {
  if (std::any_of(text.begin(), text.end(), [](char c) {
        return (c >= 0 && c < ' ' && c != '\n' && c != '\t') || c == '\x7F';
      })) {
    return false;
  }
  return text.find("\xE2\x80\xAE") == text.npos && text.find("\xC2\x9B") == text.npos &&
         text.find("\xE2\x81\xA6") == text.npos && text.find("1m\x9B") == text.npos;
}

TEST_F(OutputTest, TextOfAnyWriterOnATerminal_CannotSteerIt) {
  ::setenv("TERM", "xterm", 1);
  ::unsetenv("NO_COLOR");
  const std::vector<report::Column> columns{
      {.name = "name" + hostile, .unit = "ns", .role = report::Role::status}};
  for (const auto format : {report::Format::table, report::Format::csv, report::Format::jsonl}) {
    const OnTerminal terminal;
    Output output(host_);
    ASSERT_TRUE(output.open(terminal.path()));
    const auto table = report::make_table_writer(format, columns, output, output.table_options());
    ASSERT_TRUE(table->row(std::vector<report::Cell>{hostile}));
    ASSERT_TRUE(table->finish() && output.finish());
    std::string shown = terminal.read();
    const bool coloured = format == report::Format::table;
    EXPECT_EQ(shown.find("\x1b[33m") != shown.npos, coloured);
    for (const std::string own : {"\x1b[2m", "\x1b[33m", "\x1b[0m"}) {
      for (auto at = shown.find(own); at != shown.npos; at = shown.find(own)) {
        shown.erase(at, own.size());
      }
    }
    EXPECT_TRUE(is_harmless(shown)) << testing::PrintToString(shown);
    EXPECT_NE(shown.find("\xC3\xA9"), shown.npos);
  }
}

TEST_F(OutputTest, CharacterBetweenTwoWrites_StaysWholeOnATerminal) {
  const OnTerminal terminal;
  Output output(host_);
  ASSERT_TRUE(output.open(terminal.path()));
  ASSERT_TRUE(output.write("a\tb\n\xE2") &&
              output.write("\x82\xAC"
                           "c\x1b") &&
              output.finish());
  EXPECT_EQ(terminal.read(),
            "a\tb\n\xE2\x82\xAC"
            "c\xEF\xBF\xBD");
}

TEST_F(OutputTest, TextToAFile_IsAsItWasGiven) {
  Output output(host_);
  ASSERT_TRUE(output.open(path("rows.csv")) && output.write(hostile) && output.finish());
  EXPECT_EQ(content_of(path("rows.csv")), hostile);
}

TEST_F(OutputTest, StandardOutputOfAHostInMemory_IsItsText) {
  MemoryHost memory;
  Output output(memory);
  ASSERT_TRUE(output.open("-") && output.write("a\x1b\n"));
  EXPECT_EQ(output.table_options().width, 0U);
  EXPECT_EQ(output.file(), nullptr);
  EXPECT_TRUE(output.finish());
  EXPECT_EQ(memory.output_text(), "a\x1b\n");
}

}  // namespace output_test
}  // namespace biss::verbs
