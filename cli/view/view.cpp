#include "cli/view/view.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstring>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "cli/live/read.hpp"
#include "cli/view/answer.hpp"
#include "cli/view/server.hpp"
#include "verbs/common/decoded_capture.hpp"
#include "verbs/common/host.hpp"
#include "verbs/common/output.hpp"
#include "verbs/common/page.hpp"
#include "verbs/decode/motion_options.hpp"
#include "verbs/decode/safety.hpp"

extern char** environ;

namespace biss::cli {

using namespace verbs;

namespace {

struct ViewOptions {
  CaptureArguments capture;
  SafetyArguments safety;
  MotionArguments motion;
  bool follow = false;
  bool no_open = false;
  std::uint16_t port = 0;
  std::string page;
  /// A line that is read now, if it has a port.
  ReadOptions line;
  std::optional<Verb> verb;
};

// Reads a line in a thread of its own. Its record is in memory, and gone with the process.
class RecordedLine {
 public:
  /// Throws a VerbError if the port cannot be opened.
  explicit RecordedLine(ReadOptions options)
      : options_(std::move(options)), record_(::memfd_create("biss", MFD_CLOEXEC)) {
    options_.record = path();
    options_.decode.output = "/dev/null";
    thread_ = std::thread([this, read = prepare_read(options_, host_, [this] { return !ended_; })] {
      try {
        read();
      } catch (const VerbError& error) {
        host_.fail(error);
      }
      const auto& lines = host_.lines();
      std::ofstream(path(), std::ios::app)
          << "# ended" << (lines.empty() ? "" : ": " + lines.back()) << '\n';
    });
  }
  ~RecordedLine() {
    ended_ = true;
    thread_.join();
    ::close(record_);
  }
  RecordedLine(const RecordedLine&) = delete;
  RecordedLine& operator=(const RecordedLine&) = delete;

  std::string path() const { return fmt::format("/proc/self/fd/{}", record_); }

 private:
  ReadOptions options_;
  MemoryHost host_;
  std::atomic<bool> ended_ = false;
  int record_;
  std::thread thread_;
};

std::string name_of_file(const std::string& path) { return path.substr(path.rfind('/') + 1); }

// The browser continues to run when this command ends.
void open_browser(const std::string& address, Host& host) {
  std::string program = "xdg-open";
  std::string argument = address;
  char* arguments[] = {program.data(), argument.data(), nullptr};
  posix_spawnattr_t attributes;
  posix_spawn_file_actions_t actions;
  posix_spawnattr_init(&attributes);
  posix_spawn_file_actions_init(&actions);
  sigset_t usual;
  sigemptyset(&usual);
  for (const int number : {SIGPIPE, SIGXFSZ, SIGINT, SIGTERM, SIGHUP, SIGCHLD}) {
    sigaddset(&usual, number);
  }
  posix_spawnattr_setsigdefault(&attributes, &usual);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETSID);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
  pid_t child = -1;
  const int failed = posix_spawnp(&child, arguments[0], &actions, &attributes, arguments, environ);
  posix_spawn_file_actions_destroy(&actions);
  posix_spawnattr_destroy(&attributes);
  if (failed != 0) {
    host.warn(fmt::format("xdg-open: {}; open the address in a browser", std::strerror(failed)));
  }
}

ExitStatus check_options(const ViewOptions& options, Host& host) {
  const bool is_live = !options.line.port.empty();
  if (is_live != options.capture.files.empty()) {
    return host.fail(ExitStatus::usage, "name a capture, or a line by --port spi:DEVICE");
  }
  if (is_live && options.capture.device.format.empty()) {
    return host.fail(ExitStatus::usage, "--port: give the format of the line by -f");
  }
  if (!is_live && options.capture.files.front() == "-") {
    return host.fail(ExitStatus::usage, "-: the page asks for parts of the capture; name a file");
  }
  const FormatArguments& device = options.capture.device;
  const bool named = !device.format.empty() && device.format != "none";
  const auto error_of = [](const auto& read) { return read ? std::string{} : read.error(); };
  std::string wrong =
      named ? error_of(choose_device(device)) : error_of(override_timing(device, DeviceTiming{}));
  if (wrong.empty()) wrong = options.motion.wrong_usage();
  if (!wrong.empty()) return host.fail(ExitStatus::usage, wrong);
  return ExitStatus::done;
}

ExitStatus run_view(const ViewOptions& options, Host& host) {
  if (const ExitStatus wrong = check_options(options, host); wrong != ExitStatus::done)
    return wrong;
  std::optional<RecordedLine> line;
  const bool is_live = !options.line.port.empty();
  if (is_live) {
    ReadOptions reading = options.line;
    reading.decode.capture.device = options.capture.device;
    line.emplace(std::move(reading));
  }
  const std::string path = is_live ? line->path() : options.capture.files.front();
  std::optional<std::uint64_t> sample_bytes;
  if (options.capture.raw.rate) sample_bytes = options.capture.raw.bytes;
  ServedCapture capture;
  const auto opened = capture.open(path, options.follow || is_live, sample_bytes);
  if (!opened) return host.fail(opened.error());
  const std::string text = read_page(options.page);

  PageSettings settings = page_settings(options.verb->given_options());
  // The page reads words, which do not take the other options.
  if (is_live) {
    std::erase_if(settings.further, [](const auto& each) { return each.scope != Scope::rows; });
  }
  const std::string view = settings.link_text();
  ServedPage page(capture, [&](std::uint64_t size) {
    return page_with(text, "biss-capture",
                     {{"name", is_live ? options.line.port : name_of_file(path)},
                      {"address", "capture"},
                      {"size", fmt::format("{}", size)},
                      {is_live ? "live" : "watch", "size"},
                      {"follow", options.follow ? "yes" : ""},
                      {"view", view}},
                     "");
  });
  Output output(host);
  const std::string problem = serve(page, capture, options.port, [&] {
    if (!output.open("") || !output.write(page.address() + "\n") || !output.finish()) return false;
    if (!options.no_open) {
      std::signal(SIGCHLD, SIG_IGN);
      open_browser(page.address_to_open(), host);
    }
    return true;
  });
  return problem.empty() ? output.status() : host.fail(ExitStatus::io, problem);
}

void add_page_options(Verb verb, ViewOptions& options) {
  verb.add_text_option(
          "FILE", [&options](const std::string& file) { options.capture.files = {file}; },
          "The capture (VCD, FST, event CSV, oscilloscope CSV, .sr, .dsl, Saleae CSV and "
          "binary, raw samples; also compressed by gzip). Drop several files with one line each on "
          "the page")
      .file(FileUse::read);
  add_reading_options(verb, options.capture);
  add_safety_options(verb, options.safety);
  verb.scope(Scope::judging)
      .add_flag("--no-compensation", options.capture.no_compensation,
                "The master of this link samples half a period after its own edges of MA");
  add_range_options(verb, options.capture);
  add_motion_options(verb.section("Motion"), options.motion);
}

}  // namespace

void add_view(Command& command) {
  const auto options = std::make_shared<ViewOptions>();
  Verb verb = command.add_verb(
      {.name = "view",
       .purpose = "Look at a capture in the browser: waveform, decoded tracks, table and plots",
       .examples = {"biss view capture.vcd", "biss view capture.vcd -f resolute-26 --follow",
                    "biss view capture.sr --no-open --port 8080"}},
      [options](Host& host) { return run_view(*options, host); });
  const Verb serving = verb.section("Serving").scope(Scope::command);
  serving.add_flag("--follow", options->follow,
                   "Go on while the file grows: VCD, CSV, and raw samples with --raw-rate");
  serving.add_flag("--no-open", options->no_open,
                   "Only print the address; by default xdg-open opens it");
  serving
      .add_text_option(
          "--port",
          [options](const std::string& text) {
            if (text.starts_with("spi:")) {
              options->line.port = text;
              return;
            }
            const auto port = parse_count(text, 65535);
            if (!port) {
              wrong_value("--port",
                          quantity_error_text(Quantity::count, text, port.error(), 65535));
            }
            options->port = static_cast<std::uint16_t>(*port);
          },
          "Port of 127.0.0.1, any free one by default; or the port of an encoder, such as "
          "spi:/dev/spidev0.0, whose line the page then shows live")
      .type_name("N|PORT");
  add_page_option(serving, options->page);
  add_page_options(verb, *options);
  add_request_options(verb.section("Live line").scope(Scope::command), options->line);
  options->verb = verb;
}

}  // namespace biss::cli
