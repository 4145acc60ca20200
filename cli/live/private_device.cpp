#include "cli/live/private_device.hpp"

#include <dirent.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <sched.h>
#include <sys/mount.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <climits>
#include <csignal>
#include <cstring>

#include "live/spi_mount.hpp"

namespace biss::cli {

namespace {

// Why the child cannot run the command; in the child, all of them end it.
struct Problem {
  std::string text;
};

Problem problem_of(const std::string& what) {
  return {fmt::format("{}: {}", what, std::strerror(errno))};
}

void put_text(const std::string& path, const std::string& text) {
  const int file = ::open(path.c_str(), O_WRONLY | O_CLOEXEC);
  const bool written =
      file >= 0 && ::write(file, text.data(), text.size()) == static_cast<ssize_t>(text.size());
  if (file >= 0) ::close(file);
  if (!written) throw problem_of(path);
}

void enter_namespace() {
  const uid_t user = ::getuid();
  const gid_t group = ::getgid();
  if (::unshare(CLONE_NEWNS) != 0) {
    if (::unshare(CLONE_NEWUSER | CLONE_NEWNS) != 0) {
      throw problem_of(
          "a mount namespace for the command is not permitted; run as root, or use --at FILE");
    }
    put_text("/proc/self/setgroups", "deny");
    // As user 0: the file of a new FUSE mount belongs to that user.
    put_text("/proc/self/uid_map", fmt::format("0 {} 1", user));
    put_text("/proc/self/gid_map", fmt::format("0 {} 1", group));
  }
  if (::mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0) throw problem_of("/");
}

void make_file(const std::string& path) {
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  if (file < 0) throw problem_of(path);
  ::close(file);
}

// The same entry in the new /dev. An entry that cannot be there is missing.
void copy_entry(int old_folder, const char* name) {
  const std::string from = fmt::format("/proc/self/fd/{}/{}", old_folder, name);
  const std::string to = fmt::format("/dev/{}", name);
  struct stat found {};
  if (::fstatat(old_folder, name, &found, AT_SYMLINK_NOFOLLOW) != 0) return;
  if (S_ISLNK(found.st_mode)) {
    std::array<char, PATH_MAX> target{};
    const ssize_t size = ::readlinkat(old_folder, name, target.data(), target.size() - 1);
    if (size > 0 && ::symlink(target.data(), to.c_str()) != 0) return;
  } else if (S_ISDIR(found.st_mode)) {
    if (::mkdir(to.c_str(), 0755) == 0) {
      ::mount(from.c_str(), to.c_str(), nullptr, MS_BIND | MS_REC, nullptr);
    }
  } else {
    make_file(to);
    ::mount(from.c_str(), to.c_str(), nullptr, MS_BIND, nullptr);
  }
}

// A /dev of the command's own, with the same entries, in which a new name can be made.
void renew_dev() {
  DIR* const old = ::opendir("/dev");
  if (old == nullptr || ::mount("biss", "/dev", "tmpfs", MS_NOSUID, "mode=755") != 0) {
    throw problem_of("/dev");
  }
  while (const dirent* entry = ::readdir(old)) {
    const std::string name = entry->d_name;
    if (name != "." && name != "..") copy_entry(::dirfd(old), entry->d_name);
  }
  ::closedir(old);
}

void mount_device(const std::string& device, int fuse) {
  if (::access(device.c_str(), F_OK) != 0) {
    if (device.substr(0, device.rfind('/')) != "/dev") {
      throw Problem{fmt::format("--as: {}: give a name in /dev, or a file that exists", device)};
    }
    renew_dev();
    make_file(device);
  }
  const std::string options =
      fmt::format("fd={},rootmode=100000,user_id={},group_id={}", fuse, ::getuid(), ::getgid());
  if (::mount("biss", device.c_str(), "fuse", MS_NOSUID | MS_NODEV, options.c_str()) != 0) {
    throw problem_of(fmt::format("{}: cannot mount", device));
  }
}

// A message with room for one descriptor.
struct DescriptorMessage {
  DescriptorMessage(char* text, std::size_t size) : content{text, size} {
    header.msg_iov = &content;
    header.msg_iovlen = 1;
    header.msg_control = space.data();
    header.msg_controllen = space.size();
  }

  iovec content;
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(int))> space{};
  msghdr header{};
};

void send_descriptor(int to, int descriptor) {
  char byte = 0;
  DescriptorMessage message(&byte, 1);
  cmsghdr* const rights = CMSG_FIRSTHDR(&message.header);
  rights->cmsg_level = SOL_SOCKET;
  rights->cmsg_type = SCM_RIGHTS;
  rights->cmsg_len = CMSG_LEN(sizeof descriptor);
  std::memcpy(CMSG_DATA(rights), &descriptor, sizeof descriptor);
  if (::sendmsg(to, &message.header, 0) < 0) throw problem_of("/dev/fuse");
}

[[noreturn]] void run_in_child(const std::vector<std::string>& words, const std::string& device,
                               int report) {
  std::string text;
  try {
    enter_namespace();
    // FUSE mounts only in the user namespace that opened it.
    const int fuse = ::open("/dev/fuse", O_RDWR | O_CLOEXEC);
    if (fuse < 0) throw Problem{live::fuse_problem(errno)};
    mount_device(device, fuse);
    send_descriptor(report, fuse);
    for (const int number : {SIGPIPE, SIGXFSZ, SIGINT, SIGTERM, SIGHUP, SIGCHLD}) {
      std::signal(number, SIG_DFL);
    }
    sigset_t none;
    sigemptyset(&none);
    ::sigprocmask(SIG_SETMASK, &none, nullptr);
    std::vector<char*> argv;
    for (const std::string& word : words) argv.push_back(const_cast<char*>(word.c_str()));
    argv.push_back(nullptr);
    ::execvp(argv[0], argv.data());
    text = fmt::format("{}: cannot start: {}", words.front(), std::strerror(errno));
  } catch (const Problem& problem) {
    text = problem.text;
  }
  const ssize_t written = ::write(report, text.data(), text.size());
  ::_exit(written < 0 ? 126 : 127);
}

}  // namespace

StartedCommand start_with_device(const std::vector<std::string>& words, const std::string& device) {
  StartedCommand started;
  std::array<int, 2> ends{};
  if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends.data()) != 0 ||
      (started.process = ::fork()) < 0) {
    started.problem = fmt::format("cannot start a process: {}", std::strerror(errno));
    return started;
  }
  if (started.process == 0) run_in_child(words, device, ends[1]);
  ::close(ends[1]);
  // It ends when the command runs: first the descriptor, then perhaps a problem.
  for (;;) {
    std::array<char, 1000> text{};
    DescriptorMessage message(text.data(), text.size());
    const ssize_t got = ::recvmsg(ends[0], &message.header, MSG_CMSG_CLOEXEC);
    if (got <= 0) break;
    if (const cmsghdr* rights = CMSG_FIRSTHDR(&message.header); rights != nullptr) {
      std::memcpy(&started.fuse, CMSG_DATA(rights), sizeof started.fuse);
    } else {
      started.problem.append(text.data(), static_cast<std::size_t>(got));
    }
  }
  ::close(ends[0]);
  if (!started.problem.empty()) ::waitpid(started.process, nullptr, 0);
  return started;
}

}  // namespace biss::cli
