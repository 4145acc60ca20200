#include "cli/live/emulate.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <poll.h>
#include <sched.h>
#include <sys/mount.h>
#include <sys/signalfd.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <exception>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <tuple>
#include <vector>

#include "live/control_socket.hpp"
#include "live/spi_bus.hpp"
#include "live/spi_device.hpp"
#include "live/spi_mount.hpp"
#include "live/virtual_encoder.hpp"
#include "report/table.hpp"
#include "sim/line.hpp"
#include "verbs/common/fields.hpp"
#include "verbs/common/host.hpp"
#include "verbs/common/output.hpp"
#include "verbs/simulate/fault_option.hpp"
#include "verbs/simulate/line_options.hpp"
#include "verbs/simulate/truth.hpp"

namespace biss::cli {

using namespace verbs;

namespace {

struct EmulateOptions {
  LineOptions line;
  std::vector<std::string> registers;
  std::string at;
  std::string as = "/dev/spidev0.0";
  std::vector<std::string> command;
  std::string ma = "sck";
  std::optional<Hertz> controller_clock;
  Picoseconds byte_gap{};
  std::string time = "real";
  bool no_wait = false;
  std::string control;
  std::string truth;
};

struct AskOptions {
  std::string socket;
  std::vector<std::string> words;
};

// The times of messages: empty for real time.
std::optional<Picoseconds> read_step(const std::string& text) {
  if (text == "real") return std::nullopt;
  constexpr std::string_view step = "step:";
  const auto time =
      parse_duration(std::string_view(text).substr(std::min(step.size(), text.size())));
  if (!text.starts_with(step) || !time.ok() || *time < microseconds(1)) {
    throw wrong_usage("--time: '{}' is not real or step:TIME with a TIME of at least 1us", text);
  }
  return *time;
}

sim::FarEndSetup setup_of(const EmulateOptions& options, const std::optional<Picoseconds>& step,
                          Host& host) {
  LineOptions line = options.line;
  put_registers(options.registers, line, host);
  if (line.device.format.empty()) {
    throw wrong_usage("give --format, or --registers with a profile identifier");
  }
  if (line.setup.slaves != 1) throw wrong_usage("--registers: there is one encoder, with ID 0");
  if (step && !line.rate) line.setup.interval = *step;
  sim::LineSetup setup = value_or_fail(line_setup(line));
  for (const sim::FaultRule& rule : setup.faults) {
    if (is_of_far_end(rule.kind)) continue;
    throw wrong_usage("--fault: {} needs a simulated master, see biss simulate; the kinds are {}",
                      sim::name_of(rule.kind), fault_kinds_text(sim::is_of_far_end));
  }
  const sim::FarEndSetup end{.line = setup, .processing_max = setup.processing};
  fail_if(wrong_faults(setup.faults, sim::FarEnd::nominal_of(end), UINT64_MAX));
  return end;
}

Picoseconds real_time() {
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  return nanoseconds(std::chrono::duration_cast<std::chrono::nanoseconds>(now).count());
}

// ---- A command that sees a device of ours: it runs in its own mount namespace, in which a name of
// /dev is a FUSE file. No other program sees the file, and nothing of it remains.

VerbError problem_of(const std::string& what) {
  return wrong_file("{}: {}", what, std::strerror(errno));
}

void put_text(const std::string& path, const std::string& text, int flags = O_WRONLY) {
  const int file = ::open(path.c_str(), flags | O_CLOEXEC, 0600);
  const bool written =
      file >= 0 && ::write(file, text.data(), text.size()) == static_cast<ssize_t>(text.size());
  if (file >= 0) ::close(file);
  if (!written) throw problem_of(path);
}

void make_file(const std::string& path) { put_text(path, "", O_WRONLY | O_CREAT | O_EXCL); }

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

// A /dev of the command's own, with the same entries, in which a new name can be made. An entry that
// cannot be there is missing.
void renew_dev() {
  const int old = ::open("/dev", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (old < 0 || ::mount("biss", "/dev", "tmpfs", MS_NOSUID, "mode=755") != 0) {
    throw problem_of("/dev");
  }
  for (const auto& entry :
       std::filesystem::directory_iterator(fmt::format("/proc/self/fd/{}", old))) {
    const std::string to = "/dev" / entry.path().filename();
    std::error_code ignored;
    if (entry.is_symlink(ignored)) {
      std::filesystem::copy_symlink(entry, to, ignored);
      continue;
    }
    if (entry.is_directory(ignored)) {
      std::filesystem::create_directory(to, ignored);
    } else {
      make_file(to);
    }
    ::mount(entry.path().c_str(), to.c_str(), nullptr, MS_BIND | MS_REC, nullptr);
  }
  ::close(old);
}

void mount_device(const std::string& device, int fuse) {
  if (::access(device.c_str(), F_OK) != 0) {
    if (device.substr(0, device.rfind('/')) != "/dev") {
      throw wrong_file("--as: {}: give a name in /dev, or a file that exists", device);
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

// \param fuse becomes /dev/fuse
[[noreturn]] void run_in_child(const std::vector<std::string>& words, const std::string& device,
                               int fuse, int report) {
  std::string text;
  try {
    enter_namespace();
    // FUSE mounts only in the user namespace that opened it.
    const int opened = ::open("/dev/fuse", O_RDWR | O_CLOEXEC);
    if (opened < 0) throw VerbError{ExitStatus::io, live::fuse_problem(errno)};
    ::dup3(opened, fuse, O_CLOEXEC);
    ::close(opened);
    mount_device(device, fuse);
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
  } catch (const VerbError& problem) {
    text = problem.text;
  } catch (const std::exception& problem) {
    text = problem.what();
  }
  const ssize_t written = ::write(report, text.data(), text.size());
  ::_exit(written < 0 ? 126 : 127);
}

// Starts `words` with `device` as a new regular file of FUSE. Without the right to mount it uses a
// user namespace, in which the user is number 0.
// \pre words is not empty
// \return the process, and an open descriptor of /dev/fuse; the file of the command is its root
std::pair<pid_t, int> start_with_device(const std::vector<std::string>& words,
                                        const std::string& device) {
  // The child has our descriptors, and we wait, until it runs the command: its /dev/fuse is ours.
  std::array<int, 2> ends{};
  const int fuse = ::open("/dev/null", O_RDWR | O_CLOEXEC);
  const bool opened = fuse >= 0 && ::pipe2(ends.data(), O_CLOEXEC) == 0;
  const auto child = static_cast<pid_t>(
      opened ? ::syscall(SYS_clone, CLONE_FILES | CLONE_VFORK | SIGCHLD, nullptr) : -1);
  if (child < 0) throw wrong_file("cannot start a process: {}", std::strerror(errno));
  if (child == 0) run_in_child(words, device, fuse, ends[1]);
  std::array<char, 1000> text{};
  ::close(ends[1]);
  const ssize_t got = ::read(ends[0], text.data(), text.size());
  ::close(ends[0]);
  if (got <= 0) return {child, fuse};
  ::waitpid(child, nullptr, 0);
  throw VerbError{ExitStatus::io, std::string(text.data(), static_cast<std::size_t>(got))};
}

// ---- The emulation

// The file that the device is mounted on. It is removed at the end if it was made here.
class DeviceFile {
 public:
  explicit DeviceFile(const std::string& path) {
    struct stat found {};
    struct stat around {};
    if (::lstat(path.c_str(), &found) == 0) {
      if (!S_ISREG(found.st_mode)) {
        throw wrong_file("{}: is not a regular file; give a new name, or an empty file", path);
      }
      const auto folder = std::filesystem::absolute(path).parent_path();
      if (::stat(folder.c_str(), &around) == 0 && around.st_dev != found.st_dev) {
        throw wrong_file(
            "{0}: something is mounted there; end that program, or remove it: fusermount3 -u {0}",
            path);
      }
      if (found.st_size != 0) throw wrong_file("{}: is not empty; give a new name", path);
      return;
    }
    if (errno == ENOTCONN) {
      throw wrong_file(
          "{0}: a device of an earlier run is still mounted; remove it: fusermount3 -u {0}", path);
    }
    make_file(path);
    made_ = path;
  }
  ~DeviceFile() {
    if (!made_.empty()) ::unlink(made_.c_str());
  }
  DeviceFile(const DeviceFile&) = delete;
  DeviceFile& operator=(const DeviceFile&) = delete;

 private:
  std::string made_;
};

class Emulation {
 public:
  Emulation(const EmulateOptions& options, const sim::FarEndSetup& setup,
            const std::optional<Picoseconds>& step, Host& host)
      : options_(options),
        host_(host),
        step_(step),
        format_(setup.line.format),
        encoder_(setup, [this](const sim::FarEndCycle& request) { put_truth(request); }),
        bus_(encoder_, {.clock = options.controller_clock.value_or(Hertz{}),
                        .word_gap = options.byte_gap,
                        .ma = options.ma == "mosi" ? live::MaSource::mosi : live::MaSource::sck}),
        device_(bus_, setup.line.clock, {.now = [this] { return now(); }, .step = step}),
        mount_(device_, [this] { wait(); }) {}

  ~Emulation() {
    if (signals_ >= 0) ::close(signals_);
  }

  ExitStatus run() {
    if (!options_.truth.empty()) {
      if (!truth_output_.open(options_.truth)) return truth_output_.status();
      truth_ = report::make_table_writer(report::Format::csv,
                                         columns_of(truth_row(format_, 0, {}, {})), truth_output_);
    }
    if (!options_.control.empty()) fail_if(control_.open(options_.control), ExitStatus::io);
    take_signals();
    const ExitStatus status = options_.command.empty() ? run_at_file() : run_command();
    encoder_.finish(now());
    const bool written = !truth_ || (truth_->finish() && truth_output_.finish());
    return written ? status : truth_output_.status();
  }

 private:
  // Before the first message in real time time is the time of the system.
  Picoseconds now() const {
    return step_ ? bus_.time() : std::max(real_time() - begin_, bus_.time());
  }

  void take_signals() {
    sigset_t taken;
    sigemptyset(&taken);
    for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGCHLD}) sigaddset(&taken, number);
    ::sigprocmask(SIG_BLOCK, &taken, nullptr);
    signals_ = ::signalfd(-1, &taken, SFD_CLOEXEC | SFD_NONBLOCK);
  }

  ExitStatus run_at_file() {
    const DeviceFile file(options_.at);
    fail_if(mount_.mount(options_.at), ExitStatus::io);
    const ExitStatus written =
        write_output(host_, "", [&](Output& output) { return output.write(options_.at + "\n"); });
    if (written != ExitStatus::done) return written;
    serve();
    mount_.unmount();
    return ExitStatus::done;
  }

  ExitStatus run_command() {
    int fuse = -1;
    std::tie(child_, fuse) = start_with_device(options_.command, options_.as);
    mount_.adopt(fuse);
    serve();
    // A command that waits for the device cannot end before.
    mount_.unmount();
    if (child_ > 0) end_command();
    const bool exited = WIFEXITED(child_status_);
    return static_cast<ExitStatus>(exited ? WEXITSTATUS(child_status_)
                                          : 128 + WTERMSIG(child_status_));
  }

  // After `quit`: SIGTERM, and SIGKILL two seconds later.
  void end_command() {
    ::kill(child_, SIGTERM);
    for (int tenths = 0; ::waitpid(child_, &child_status_, WNOHANG) == 0; ++tenths) {
      if (tenths == 20) ::kill(child_, SIGKILL);
      ::poll(nullptr, 0, 100);
    }
  }

  void serve() {
    while (!ended_) {
      if (answer(mount_.descriptor(), nullptr) && !mount_.serve()) break;
      if (const std::string text = mount_.take_warning(); !text.empty()) host_.warn(text);
    }
  }

  // Answers signals and commands, if there are any before the limit. \return the device is readable
  bool answer(int device, const timespec* limit) {
    std::array<pollfd, 3> ready{
        {{signals_, POLLIN, 0}, {control_.descriptor(), POLLIN, 0}, {device, POLLIN, 0}}};
    if (::ppoll(ready.data(), ready.size(), limit, nullptr) <= 0) return false;
    if (ready[0].revents != 0) take_signal();
    if (ready[1].revents != 0) {
      control_.serve([this](std::string_view line) -> std::string {
        if (line != "quit") return encoder_.command(line, now());
        ended_ = true;
        return "ok quit";
      });
    }
    return ready[2].revents != 0;
  }

  void take_signal() {
    signalfd_siginfo signal{};
    if (::read(signals_, &signal, sizeof signal) != sizeof signal) return;
    if (signal.ssi_signo == SIGCHLD) {
      if (child_ > 0 && ::waitpid(child_, &child_status_, WNOHANG) == child_) {
        child_ = 0;
        ended_ = true;
      }
    } else if (child_ <= 0) {
      ended_ = true;
    } else if (signal.ssi_code <= 0) {
      // The command gets it. Signals of the terminal have reached the command, too.
      ::kill(child_, static_cast<int>(signal.ssi_signo));
    }
  }

  // A message takes its time.
  void wait() {
    if (step_ || options_.no_wait) return;
    constexpr Picoseconds spin = microseconds(200);
    for (;;) {
      const Picoseconds rest = bus_.time() - (real_time() - begin_);
      if (rest.count <= 0) return;
      if (rest <= spin) continue;
      const std::int64_t sleep_ns = (rest - spin).count / 1000;
      const timespec limit{.tv_sec = sleep_ns / 1'000'000'000, .tv_nsec = sleep_ns % 1'000'000'000};
      answer(-1, &limit);
      if (ended_) return;
    }
  }

  void put_truth(const sim::FarEndCycle& request) {
    if (!truth_) return;
    sim::SimulatedCycle cycle;
    cycle.time = request.begin;
    cycle.sent = request.sent;
    if (request.sampled) std::fill_n(cycle.taken.begin(), format_.channel_count, true);
    cycle.sampled = request.sampled;
    cycle.injected = request.injected;
    write_row(*truth_, truth_row(format_, request.number, cycle, sim::text_of(request.faults)));
  }

  const EmulateOptions& options_;
  Host& host_;
  std::optional<Picoseconds> step_;
  FrameFormat format_;
  Picoseconds begin_ = real_time();
  Output truth_output_{host_};
  std::unique_ptr<report::TableWriter> truth_;
  live::VirtualEncoder encoder_;
  live::SpiBus bus_;
  live::SpiDevice device_;
  live::ControlSocket control_;
  live::SpiMount mount_;
  int signals_ = -1;
  pid_t child_ = -1;
  int child_status_ = 0;
  bool ended_ = false;
};

ExitStatus run_emulate(const EmulateOptions& options, Host& host) {
  if (options.at.empty() == options.command.empty()) {
    throw wrong_usage("give --at FILE, or -- COMMAND…");
  }
  if (options.controller_clock && *options.controller_clock < megahertz(1)) {
    throw wrong_usage("--controller-clock: at least 1 MHz");
  }
  const auto step = read_step(options.time);
  return Emulation(options, setup_of(options, step, host), step, host).run();
}

ExitStatus run_ask(const AskOptions& options, Host& host) {
  const std::string line = fmt::format("{}", fmt::join(options.words, " "));
  std::string answer;
  if (line.find('\n') != std::string::npos) throw wrong_usage("WORDS: one line");
  if (!live::ask_control_socket(options.socket, line, answer)) {
    return host.fail(ExitStatus::io, answer);
  }
  return std::max(
      write_output(host, "", [&](Output& output) { return output.write(answer + "\n"); }),
      answer.starts_with("ok") ? ExitStatus::done : ExitStatus::data_failed);
}

void add_device_options(Verb verb, EmulateOptions& options) {
  verb.add_option("--at", options.at, "Empty or new file that becomes the device")
      .type_name("FILE");
  verb.add_option("--as", options.as, "Name of the device for COMMAND; /dev/spidev0.0 by default")
      .type_name("NAME");
  add_name_option(verb, "--ma", options.ma, {"sck", "mosi"},
                  "Output of the controller that is MA; sck by default");
  add_rate_option(verb, "--controller-clock", into(options.controller_clock),
                  "Clock that the controller divides by an even number, for example 125MHz; by "
                  "default it reaches every rate");
  add_duration_option(verb, "--byte-gap", into(options.byte_gap),
                      "Pause of the clock after each word; none by default");
  verb.add_option("--time", options.time,
                  "Begin of a message: real, or step:TIME after the begin of the previous one, so "
                  "that each run gives the same; real by default")
      .type_name("real|step:TIME");
  verb.add_flag("--no-wait", options.no_wait,
                "Return from a message at once, and not after the time that it takes");
}

void add_run_options(Verb verb, EmulateOptions& options) {
  verb.add_option("--ctl", options.control, "Unix socket for commands; see biss emulate ctl")
      .type_name("SOCKET");
  verb.add_option("--truth", options.truth,
                  "Write the values that the encoder meant to send, and the faults, as CSV")
      .file(FileUse::write);
}

}  // namespace

void add_emulate(Command& command) {
  const auto options = std::make_shared<EmulateOptions>();
  Verb verb = command.add_verb(
      {.name = "emulate",
       .purpose = "Emulate an encoder that programs read as a Linux spidev device",
       .examples = {"biss emulate -f resolute-26 --fault flip:0.01 -- python3 read.py",
                    "biss emulate -f resolute-26 --cable 20m --at spidev0.0 --ctl ctl.socket "
                    "--truth truth.csv",
                    "biss emulate ctl ctl.socket fault cut@next"}},
      [options](Host& host) { return run_emulate(*options, host); });
  verb.add_option(
      "COMMAND", options->command,
      "Command after --, for which --as is the device; the exit status is the command's");
  add_device_options(verb.section("Device").scope(Scope::command), *options);
  add_line_options(verb, options->line, MasterKind::foreign);
  add_register_options(verb.section("Registers"), options->registers, options->line);
  add_run_options(verb.section("Run").scope(Scope::command), *options);

  const auto ask = std::make_shared<AskOptions>();
  const Verb control = verb.add_verb(
      {.name = "ctl",
       .purpose = "Send one command to a running biss emulate, and print the answer",
       .examples = {"biss emulate ctl ctl.socket fault flip@next",
                    "biss emulate ctl ctl.socket at 4711", "biss emulate ctl ctl.socket status"}},
      [ask](Host& host) { return run_ask(*ask, host); });
  control.add_option("SOCKET", ask->socket, "The socket of --ctl").required();
  control
      .add_option("WORDS", ask->words,
                  "fault KIND@next, fault KIND:RATE, fault off, at N, move N, motion KIND, nE 0|1, "
                  "nW 0|1, unplug, plug, power off|on, status or quit")
      .required();
}

}  // namespace biss::cli
