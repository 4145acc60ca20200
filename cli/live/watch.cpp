#include "cli/live/watch.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <ctime>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "archive/hash.hpp"
#include "archive/listing.hpp"
#include "biss/frame/format_text.hpp"
#include "biss/master/spi_read.hpp"
#include "capture/bytes.hpp"
#include "capture/open.hpp"
#include "cli/live/end_by_signal.hpp"
#include "cli/live/health_log.hpp"
#include "cli/live/read.hpp"
#include "verbs/common/decoded_capture.hpp"

namespace biss::cli {

using namespace verbs;

namespace {

struct WatchOptions {
  /// The captures, or the port.
  ReadOptions read;
  HealthLogOptions log;
  bool follow = false;
  std::string state;  // of `show`
};

void pause() { ::usleep(100'000); }

std::int64_t seconds_now() { return static_cast<std::int64_t>(std::time(nullptr)); }

live::HealthSample sample_of(const decode::Cycle& cycle, live::LinkUnit unit) {
  live::HealthSample sample{.status = cycle.status, .period = cycle.period};
  if (cycle.frame) {
    const auto channels = cycle.frame->channels();
    const auto any = [&](auto is) { return std::any_of(channels.begin(), channels.end(), is); };
    sample.error = any([](const auto& channel) { return !channel.nE; });
    sample.warning = any([](const auto& channel) { return !channel.nW; });
  }
  sample.noisy = cycle.marginal.value_or(false);
  if (unit == live::LinkUnit::clock) {
    if (cycle.frame) sample.delay = line_delay_clocks(*cycle.frame);
    if (cycle.frame) sample.ack = cycle.frame->ack_clocks;
    return sample;
  }
  if (cycle.line_delay) sample.delay = cycle.line_delay->count;
  if (cycle.ack) sample.ack = cycle.ack->count;
  if (!cycle.signal || !cycle.period) return sample;
  if (cycle.signal->ma_pulses + cycle.signal->slo_pulses != 0) sample.noisy = true;
  if (const auto& changes = cycle.signal->changes) {
    const Picoseconds half{cycle.period->count / 2};
    const Picoseconds nearest = std::min(changes->sampled + half - changes->latest,
                                         changes->earliest + half - changes->sampled);
    sample.margin = 1000 * nearest.count / cycle.period->count;
  }
  return sample;
}

// A file that another program writes: at its end, waits for more until this program is to end.
class GrowingFile final : public capture::ByteSource {
 public:
  GrowingFile(std::string path, std::unique_ptr<ByteSource> file)
      : path_(std::move(path)), file_(std::move(file)) {
    is_replaced();
  }

  Result<std::size_t, capture::CaptureError> read(std::span<char> into) override {
    for (;;) {
      const auto got = file_->read(into);
      if (got.ok()) taken_ += *got;
      if (!got.ok() || *got != 0 || EndBySignal::wanted() || is_replaced()) return got;
      pause();
    }
  }

 private:
  // The name has another file, or the file begins again: the rest of this one will not come.
  bool is_replaced() {
    struct stat now {};
    if (::stat(path_.c_str(), &now) != 0) return false;
    const bool same = number_.value_or(now.st_ino) == now.st_ino;
    number_ = now.st_ino;
    return !same || static_cast<std::uint64_t>(now.st_size) < taken_;
  }

  std::string path_;
  std::optional<ino_t> number_;
  std::uint64_t taken_ = 0;
  std::unique_ptr<ByteSource> file_;
};

// The host of the command with one capture that grows.
class GrowingHost final : public MemoryHost {
 public:
  GrowingHost(Host& outer, const std::string& path) : MemoryHost(&outer), outer_(outer) {
    const auto open = [path](const InputArguments& arguments) -> capture::Opened {
      auto file = capture::open_bytes(path);
      if (!file) return tl::unexpected(file.error());
      return capture::open_capture(std::make_unique<GrowingFile>(path, *std::move(file)), path,
                                   {.analog = arguments.raw.analog});
    };
    give(path, {.open = open, .again = false});
  }

  void warn(std::string_view text) override { outer_.warn(text); }

 private:
  Host& outer_;
};

// An alarm matters more than a file that cannot be read.
ExitStatus status_of(ExitStatus health, ExitStatus reading) {
  return health == ExitStatus::data_failed ? health : std::max(health, reading);
}

class WatchRun {
 public:
  WatchRun(const WatchOptions& options, Host& host)
      : options_(options), host_(host), log_(options.log, host) {}

  ExitStatus run() {
    const EndBySignal signals;
    const std::vector<std::string>& paths = options_.read.decode.capture.files;
    struct stat about {};
    const bool grows = options_.follow && paths.size() == 1 &&
                       ::stat(paths.front().c_str(), &about) == 0 && S_ISREG(about.st_mode);
    do {
      bool is_new = false;
      const auto files = archive::list_files(paths);
      if (!files && (!options_.follow || log_.is_empty())) {
        throw VerbError{ExitStatus::io, files.error()};
      }
      // A folder may be away for a while.
      if (!files && !std::exchange(is_away_, true)) {
        host_.warn(files.error() + "; waiting for it");
      }
      is_away_ = !files;
      for (const auto& file : files.value_or(std::vector<archive::ListedFile>())) {
        if (EndBySignal::wanted()) break;
        if (file.cause.empty()) is_new |= read(file, grows);
      }
      for (int k = 0; k < 10 && options_.follow && !is_new && !EndBySignal::wanted(); ++k) pause();
    } while (options_.follow && !EndBySignal::wanted());
    return status_of(log_.finish(), status_);
  }

 private:
  // False if nothing of the file is new.
  bool read(const archive::ListedFile& file, bool grows) {
    struct stat about {};
    if (::stat(file.path.c_str(), &about) != 0) return false;
    FileMark& mark =
        log_.begin_file(archive::hash_of(fmt::format("{}:{}", about.st_dev, about.st_ino)));
    if (mark.bytes == file.stamp.bytes && mark.time == file.stamp.time) return false;
    // A file with another beginning is another one.
    std::string head(4096, '\0');
    head.resize(static_cast<std::size_t>(std::max<std::streamsize>(
        std::ifstream(file.path, std::ios::binary).read(head.data(), 4096).gcount(), 0)));
    if (head.size() < mark.head || archive::hash_of(head.substr(0, mark.head)) != mark.hash) {
      mark = {};
    }
    mark.head = head.size();
    mark.hash = archive::hash_of(head);
    read_rest(file, grows, mark);
    // A file that is left in the middle is read again, from the cycle after the last one.
    if (!EndBySignal::wanted()) {
      mark.bytes = file.stamp.bytes;
      mark.time = file.stamp.time;
    }
    log_.save();
    return true;
  }

  // The cycles that are not counted yet.
  void read_rest(const archive::ListedFile& file, bool grows, const FileMark& mark) {
    GrowingHost growing(host_, file.path);
    CaptureArguments arguments = options_.read.decode.capture;
    arguments.files = {file.path};
    if (grows) arguments.beginning = 4096;
    DecodedCapture capture(grows ? static_cast<Host&>(growing) : host_);
    if (capture.open(arguments) != ExitStatus::done || !capture.next()) {
      if (!EndBySignal::wanted()) status_ = std::max(status_, capture.status());
      return;
    }
    if (arguments.device.format.empty() && !use_known_format(capture)) return;
    const std::uint64_t known = mark.cycles;
    std::uint64_t cycles = 0;
    const bool whole = capture.read([&](std::uint64_t, const decode::Cycle& cycle) {
      // The cycle at the end of the file may be complete in the next reading.
      if (is_cut(cycle.status) || cycles++ < known) return !EndBySignal::wanted();
      log_.add(sample_of(cycle, live::LinkUnit::picosecond), cycle.time,
               grows ? seconds_now() : file.stamp.time / 1'000'000'000);
      return !EndBySignal::wanted();
    });
    if (!whole && !EndBySignal::wanted()) {
      status_ = std::max(status_, host_.fail(ExitStatus::io, capture.input().error()));
    }
    log_.end_capture();
  }

  // All captures are judged by the format of the first one. A damaged capture shows another format,
  // or none.
  bool use_known_format(DecodedCapture& capture) {
    std::string& known = log_.format();
    if (known.empty() && capture.format()) {
      known = format_text(*capture.format()).view();
      host_.warn(fmt::format("{}: all captures are judged by its format, {}; -f gives another one",
                             capture.name(), known));
    }
    if (!known.empty()) {
      capture.judge_by(*parse_format(known));
      return true;
    }
    status_ =
        host_.fail(ExitStatus::io,
                   capture.name() + ": its format is not known, so nothing is judged; give -f");
    return false;
  }

  const WatchOptions& options_;
  Host& host_;
  HealthLog log_;
  bool is_away_ = false;
  ExitStatus status_ = ExitStatus::done;
};

ExitStatus watch_port(const WatchOptions& options, Host& host) {
  HealthLogOptions chosen = options.log;
  chosen.health.unit = live::LinkUnit::clock;
  HealthLog log(chosen, host);
  const ExitStatus status =
      read_port(options.read, host, [&log](const decode::Cycle* cycle, Picoseconds time) {
        if (cycle == nullptr) return log.wait(time, seconds_now());
        log.add(sample_of(*cycle, live::LinkUnit::clock), time, seconds_now());
      });
  return status_of(log.finish(), status);
}

ExitStatus run_watch(const WatchOptions& options, Host& host) {
  CaptureArguments checked = options.read.decode.capture;
  if (checked.files.empty() == options.read.port.empty()) {
    throw wrong_usage("give captures or folders with captures, or --port");
  }
  if (!options.read.port.empty()) return watch_port(options, host);
  // The options are wrong for each file, or for none.
  checked.files = {"any"};
  if (const ExitStatus status = DecodedCapture(host).open(checked); status != ExitStatus::done) {
    return status;
  }
  return WatchRun(options, host).run();
}

}  // namespace

void add_watch(Command& command) {
  const auto options = std::make_shared<WatchOptions>();
  const auto given = std::make_shared<std::optional<Verb>>();
  Verb verb = command.add_verb(
      {.name = "watch",
       .purpose = "Watch the health of a link over hours and days, and give alarms",
       .examples =
           {"biss watch captures --state axis1.health",
            "biss watch --port spi:/dev/spidev0.0 -f resolute-26 --clock 4MHz --duration 2s"}},
      [options, given](Host& host) {
        std::string& settings = options->log.settings;
        settings.clear();
        for (const Option* option : (*given)->given_options()) {
          if (option->scope != Scope::reading) continue;
          settings += fmt::format("{} {} ", option->name(), fmt::join(option->given, " "));
        }
        return run_watch(*options, host);
      });
  *given = verb;
  verb.add_option("FILE", options->read.decode.capture.files,
                  "Captures, and folders with captures of any format")
      .file(FileUse::read);
  options->read.decode.capture.identify = true;
  options->read.decode.capture.signal = true;
  options->read.decode.capture.threads = 1;
  options->read.decode.capture.one_of_many = true;
  add_reading_options(verb, options->read.decode.capture);
  add_port_options(verb.section("Port"), options->read);
  const Verb own = verb.scope(Scope::command);
  add_duration_option(own, "--duration", into(options->read.duration),
                      "Ends the reading of a port after this time");
  own.add_flag("--follow", options->follow,
               "Wait for more: for new files in folders, or for the rest of a file that grows");
  own.add_option("--state", options->log.state,
                 "Keep all figures in this file; the next run goes on with them")
      .file(FileUse::write);
  add_duration_option(own, "--interval", into(options->log.interval),
                      "The time for which a row has figures; 10 s by default");
  add_count_option(own, "--baseline", into(options->log.health.baseline),
                   "The first N intervals are the baseline, with which all others are compared; 30 "
                   "by default");
  own.add_option("--listen", options->log.publish.listen,
                 "Give figures to Prometheus at http://127.0.0.1:PORT/metrics")
      .type_name("127.0.0.1:PORT");
  const Option& mqtt = own.add_option("--mqtt", options->log.publish.mqtt,
                                      "Send each row and each alarm to this MQTT broker")
                           .type_name("HOST[:PORT]");
  own.add_option("--topic", options->log.publish.topic,
                 "The beginning of the topics: TOPIC/interval, TOPIC/alarm/NAME; biss by default")
      .type_name("TOPIC")
      .needs(mqtt);
  add_output_option(verb.scope(Scope::rows), options->log.output);
  add_to_option(verb.scope(Scope::rows), options->log.to);
  Verb show = verb.add_verb({.name = "show",
                             .purpose = "Show a state file: the history, and the alarms",
                             .examples = {"biss watch show axis1.health"}},
                            [options](Host& host) {
                              return show_health(options->state, options->log.output,
                                                 options->log.to, host);
                            });
  show.add_option("STATE", options->state, "The file of --state").required().file(FileUse::read);
  add_output_option(show, options->log.output);
  add_to_option(show, options->log.to);
}

}  // namespace biss::cli
