#include "live/spi_mount.hpp"

#define FUSE_USE_VERSION 35
#include <fcntl.h>
#include <fmt/format.h>
#include <fuse_lowlevel.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <new>
#include <utility>

namespace biss::live {

namespace {

// The errors of libfuse, which prints them and returns none.
std::string fuse_text;

void keep_text(fuse_log_level /*level*/, const char* format, va_list arguments) {
  std::array<char, 500> text{};
  std::vsnprintf(text.data(), text.size(), format, arguments);
  fuse_text += text.data();
  while (fuse_text.ends_with('\n')) fuse_text.pop_back();
  if (fuse_text.size() > 2000) fuse_text.clear();
}

// The memory of the thread that waits in its ioctl, so that the number still is its own.
class ProcessMemory final : public CallerMemory {
 public:
  explicit ProcessMemory(pid_t process) : process_(process) {}

  bool read(std::uint64_t address, std::span<std::uint8_t> to) override {
    return copy(process_vm_readv, address, to.data(), to.size());
  }
  bool write(std::uint64_t address, std::span<const std::uint8_t> from) override {
    return copy(process_vm_writev, address, const_cast<std::uint8_t*>(from.data()), from.size());
  }
  /// EPERM: the system permits no access to this process.
  int error() const { return error_; }

 private:
  template <class Copy>
  bool copy(const Copy& copy_memory, std::uint64_t address, std::uint8_t* bytes, std::size_t size) {
    const iovec here{bytes, size};
    const iovec there{reinterpret_cast<void*>(static_cast<std::uintptr_t>(address)), size};
    const ssize_t copied = size == 0 ? 0 : copy_memory(process_, &here, 1, &there, 1, 0);
    if (copied < 0) error_ = errno;
    return copied == static_cast<ssize_t>(size);
  }

  pid_t process_;
  int error_ = 0;
};

}  // namespace

struct SpiMount::State {
  SpiDevice& device;
  std::function<void()> before_reply;
  fuse_session* session = nullptr;
  bool mounted = false;
  uid_t owner = getuid();
  gid_t group = getgid();
  fuse_buf buffer{};
  std::string warning{};
  bool warned = false;

  static State& of(fuse_req_t request) { return *static_cast<State*>(fuse_req_userdata(request)); }

  static void get_attributes(fuse_req_t request, fuse_ino_t, fuse_file_info*) {
    struct stat attributes {};
    attributes.st_ino = FUSE_ROOT_ID;
    // Without a size it has no pages that a program could give us as its buffer.
    attributes.st_mode = S_IFREG | 0600;
    attributes.st_nlink = 1;
    attributes.st_uid = of(request).owner;
    attributes.st_gid = of(request).group;
    fuse_reply_attr(request, &attributes, 3600);
  }
  // A shell truncates the file that it redirects to.
  static void set_attributes(fuse_req_t request, fuse_ino_t node, struct stat*, int changed,
                             fuse_file_info* file) {
    const int harmless = FUSE_SET_ATTR_SIZE | FUSE_SET_ATTR_ATIME | FUSE_SET_ATTR_MTIME |
                         FUSE_SET_ATTR_ATIME_NOW | FUSE_SET_ATTR_MTIME_NOW | FUSE_SET_ATTR_CTIME;
    if ((changed & ~harmless) != 0) {
      fuse_reply_err(request, EPERM);
    } else {
      get_attributes(request, node, file);
    }
  }
  static void open(fuse_req_t request, fuse_ino_t, fuse_file_info* file) {
    file->direct_io = 1;
    file->nonseekable = 1;
    of(request).device.open();
    if (fuse_reply_open(request, file) != 0) of(request).device.release();
  }
  static void release(fuse_req_t request, fuse_ino_t, fuse_file_info*) {
    of(request).device.release();
    fuse_reply_err(request, 0);
  }
  // A message is done. True: it failed, and has its reply.
  static bool ends_with_error(fuse_req_t request, const SpiAnswer& answer) {
    of(request).before_reply();
    if (answer.result < 0) fuse_reply_err(request, -answer.result);
    return answer.result < 0;
  }
  static void read(fuse_req_t request, fuse_ino_t, std::size_t size, off_t, fuse_file_info*) {
    const SpiAnswer answer = of(request).device.read(size);
    if (ends_with_error(request, answer)) return;
    fuse_reply_buf(request, reinterpret_cast<const char*>(answer.out.data()), answer.out.size());
  }
  static void write(fuse_req_t request, fuse_ino_t, const char* bytes, std::size_t size, off_t,
                    fuse_file_info*) {
    const SpiAnswer answer =
        of(request).device.write({reinterpret_cast<const std::uint8_t*>(bytes), size});
    if (ends_with_error(request, answer)) return;
    fuse_reply_write(request, static_cast<std::size_t>(answer.result));
  }
  static void control(fuse_req_t request, fuse_ino_t, unsigned command, void*, fuse_file_info*,
                      unsigned, const void* in, std::size_t in_size, std::size_t) {
    State& state = of(request);
    const pid_t caller = fuse_req_ctx(request)->pid;
    ProcessMemory memory(caller);
    const SpiAnswer answer =
        state.device.control(command, {static_cast<const std::uint8_t*>(in), in_size}, memory);
    if (answer.result < 0 && (memory.error() == EPERM || caller == 0)) state.warn(caller);
    if (ends_with_error(request, answer)) return;
    fuse_reply_ioctl(request, answer.result, answer.out.data(), answer.out.size());
  }

  void warn(pid_t caller) {
    if (std::exchange(warned, true)) return;
    warning =
        caller == 0
            ? "a program in another PID namespace uses the device: its buffers cannot be reached, "
              "and it gets EFAULT; run biss emulate in the same namespace"
            : fmt::format(
                  "process {}: its buffers may not be reached, and it gets EFAULT; run it "
                  "as -- COMMAND, or run biss emulate as root, or set "
                  "kernel.yama.ptrace_scope=0",
                  caller);
  }
};

SpiMount::SpiMount(SpiDevice& device, std::function<void()> before_reply)
    : state_(new State{.device = device, .before_reply = std::move(before_reply)}) {
  fuse_set_log_func(keep_text);
  fuse_lowlevel_ops operations{};
  operations.getattr = State::get_attributes;
  operations.setattr = State::set_attributes;
  operations.open = State::open;
  operations.release = State::release;
  operations.read = State::read;
  operations.write = State::write;
  operations.ioctl = State::control;
  std::string program = "biss";
  std::string option = "-ofsname=biss";
  std::array<char*, 3> words{program.data(), option.data(), nullptr};
  fuse_args arguments = FUSE_ARGS_INIT(2, words.data());
  state_->session = fuse_session_new(&arguments, &operations, sizeof operations, state_.get());
  fuse_opt_free_args(&arguments);
  if (state_->session == nullptr) throw std::bad_alloc();
}

SpiMount::~SpiMount() {
  unmount();
  std::free(state_->buffer.mem);
}

void SpiMount::unmount() {
  if (state_->session == nullptr) return;
  if (state_->mounted) fuse_session_unmount(state_->session);
  fuse_session_destroy(std::exchange(state_->session, nullptr));
}

std::string fuse_problem(int error) {
  if (error == EACCES || error == EPERM) {
    return "/dev/fuse: no permission; run as root, or let your user open it (chmod 666 /dev/fuse)";
  }
  return fmt::format(
      "/dev/fuse: {}; load it with `modprobe fuse`, or give it to the container "
      "(--device /dev/fuse)",
      std::strerror(error));
}

std::string SpiMount::mount(const std::string& path) {
  const int probe = ::open("/dev/fuse", O_RDWR | O_CLOEXEC);
  if (probe < 0) return fuse_problem(errno);
  ::close(probe);
  fuse_text.clear();
  if (fuse_session_mount(state_->session, path.c_str()) != 0) {
    return fmt::format("{}: cannot mount: {}; run as root, or install the package fuse3", path,
                       fuse_text.empty() ? "FUSE refuses" : fuse_text);
  }
  state_->mounted = true;
  ::fcntl(descriptor(), F_SETFD, FD_CLOEXEC);
  return {};
}

void SpiMount::adopt(int descriptor) {
  fuse_session_mount(state_->session, fmt::format("/dev/fd/{}", descriptor).c_str());
  state_->mounted = true;
  state_->owner = state_->group = 0;
}

int SpiMount::descriptor() const { return fuse_session_fd(state_->session); }

bool SpiMount::serve() {
  const int received = fuse_session_receive_buf(state_->session, &state_->buffer);
  if (received == -EINTR || received == -EAGAIN) return true;
  if (received <= 0) return false;
  fuse_session_process_buf(state_->session, &state_->buffer);
  return fuse_session_exited(state_->session) == 0;
}

std::string SpiMount::take_warning() { return std::exchange(state_->warning, {}); }

}  // namespace biss::live
