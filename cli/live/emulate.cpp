#include "cli/live/emulate.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <poll.h>
#include <sys/signalfd.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cli/live/private_device.hpp"
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
  if (!text.starts_with(step)) throw wrong_usage("--time: '{}' is not real or step:TIME", text);
  const std::string time = text.substr(step.size());
  const auto value = parse_duration(time);
  if (!value.ok()) {
    throw wrong_usage("--time: {}", quantity_error_text(Quantity::duration, time, value.error()));
  }
  if (*value < microseconds(1)) throw wrong_usage("--time: a step takes at least 1us");
  return *value;
}

sim::LineSetup setup_of(const EmulateOptions& options, const std::optional<Picoseconds>& step,
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
  return setup;
}

Picoseconds real_time() {
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  return nanoseconds(std::chrono::duration_cast<std::chrono::nanoseconds>(now).count());
}

// The file that the device is mounted on. It is removed at the end if it was made here.
class DeviceFile {
 public:
  explicit DeviceFile(const std::string& path) {
    struct stat found {};
    if (::lstat(path.c_str(), &found) == 0) {
      check(path, found);
      return;
    }
    if (errno == ENOTCONN) {
      throw wrong_file(
          "{0}: a device of an earlier run is still mounted; remove it: "
          "fusermount3 -u {0}",
          path);
    }
    const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
    if (file < 0) throw wrong_file("{}: {}", path, std::strerror(errno));
    ::close(file);
    made_ = path;
  }
  ~DeviceFile() {
    if (!made_.empty()) ::unlink(made_.c_str());
  }
  DeviceFile(const DeviceFile&) = delete;
  DeviceFile& operator=(const DeviceFile&) = delete;

 private:
  static void check(const std::string& path, const struct stat& found) {
    if (!S_ISREG(found.st_mode)) {
      throw wrong_file("{}: is not a regular file; give a new name, or an empty file", path);
    }
    const std::size_t slash = path.rfind('/');
    const std::string folder = slash == std::string::npos ? "." : path.substr(0, slash + 1);
    struct stat around {};
    if (::stat(folder.c_str(), &around) == 0 && around.st_dev != found.st_dev) {
      throw wrong_file(
          "{0}: something is mounted there; end that program, or remove it: "
          "fusermount3 -u {0}",
          path);
    }
    if (found.st_size != 0) throw wrong_file("{}: is not empty; give a new name", path);
  }

  std::string made_;
};

class Emulation {
 public:
  Emulation(const EmulateOptions& options, const sim::LineSetup& setup,
            const std::optional<Picoseconds>& step, Host& host)
      : options_(options),
        host_(host),
        step_(step),
        format_(setup.format),
        encoder_({.line = setup, .processing_max = setup.processing},
                 [this](const sim::FarEndCycle& request) { put_truth(request); }),
        bus_(encoder_, {.clock = options.controller_clock.value_or(Hertz{}),
                        .word_gap = options.byte_gap,
                        .ma = options.ma == "mosi" ? live::MaSource::mosi : live::MaSource::sck}),
        device_(bus_, setup.clock, {.now = [this] { return now(); }, .step = step}),
        mount_(device_, [this] { wait(); }) {}

  ~Emulation() {
    if (signals_ >= 0) ::close(signals_);
  }
  Emulation(const Emulation&) = delete;
  Emulation& operator=(const Emulation&) = delete;

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
    if (!written) return truth_output_.status();
    return status;
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
    Output output(host_);
    if (!output.open("") || !output.write(options_.at + "\n") || !output.finish()) {
      return output.status();
    }
    serve();
    mount_.unmount();
    return ExitStatus::done;
  }

  ExitStatus run_command() {
    const StartedCommand started = start_with_device(options_.command, options_.as);
    if (!started.problem.empty()) return host_.fail(ExitStatus::io, started.problem);
    mount_.adopt(started.fuse);
    child_ = started.process;
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
      std::array<pollfd, 3> ready = sources();
      ready[2] = {mount_.descriptor(), POLLIN, 0};
      if (::poll(ready.data(), ready.size(), -1) < 0) continue;
      if (ready[2].revents != 0 && !mount_.serve()) break;
      answer(ready);
      if (const std::string text = mount_.take_warning(); !text.empty()) host_.warn(text);
    }
  }

  std::array<pollfd, 3> sources() const {
    return {{{signals_, POLLIN, 0}, {control_.descriptor(), POLLIN, 0}, {-1, 0, 0}}};
  }

  void answer(const std::array<pollfd, 3>& ready) {
    if (ready[0].revents != 0) take_signal();
    if (ready[1].revents != 0) {
      control_.serve([this](std::string_view line) -> std::string {
        if (line != "quit") return encoder_.command(line, now());
        ended_ = true;
        return "ok quit";
      });
    }
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
      std::array<pollfd, 3> ready = sources();
      if (::ppoll(ready.data(), ready.size(), &limit, nullptr) > 0) answer(ready);
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
  const sim::LineSetup setup = setup_of(options, step, host);
  fail_if(wrong_faults(setup.faults,
                       sim::FarEnd::nominal_of({.line = setup, .processing_max = setup.processing}),
                       UINT64_MAX));
  return Emulation(options, setup, step, host).run();
}

ExitStatus run_ask(const AskOptions& options, Host& host) {
  std::string line = fmt::format("{}", fmt::join(options.words, " "));
  std::string answer;
  if (line.find('\n') != std::string::npos) throw wrong_usage("WORDS: one line");
  if (!live::ask_control_socket(options.socket, line, answer)) {
    return host.fail(ExitStatus::io, answer);
  }
  const ExitStatus written =
      write_output(host, "", [&](Output& output) { return output.write(answer + "\n"); });
  if (written != ExitStatus::done) return written;
  return answer.starts_with("ok") ? ExitStatus::done : ExitStatus::data_failed;
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
