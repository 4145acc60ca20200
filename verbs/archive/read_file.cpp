#include "verbs/archive/archive.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <exception>
#include <new>
#include <utility>

#include "biss/frame/format_text.hpp"
#include "capture/open.hpp"
#include "decode/limits.hpp"
#include "decode/statistics.hpp"
#include "verbs/common/host.hpp"
#include "verbs/common/identified.hpp"

namespace biss::verbs {

namespace {

using archive::FileEntry;
using archive::LinkEntry;
using archive::Reading;
using identify::Protocol;

// The causes that are not in capture::CaptureCause.
constexpr const char* no_such_line = "no_such_line";
constexpr const char* out_of_memory = "out_of_memory";
constexpr const char* changed = "changed_while_read";

// A neighbour of BiSS C. A line that is dead or noisy may still be one of BiSS C.
bool is_other(Protocol protocol) {
  constexpr std::array perhaps_biss_c{Protocol::biss_c, Protocol::clock_alone, Protocol::noise,
                                      Protocol::idle, Protocol::unknown};
  return std::find(perhaps_biss_c.begin(), perhaps_biss_c.end(), protocol) == perhaps_biss_c.end();
}

// Measures one pair of lines of the current capture. False if reading failed.
bool measure(DecodedCapture& capture, LinkEntry& link) {
  link.ma = archive::utf8_text(capture.ma_name());
  link.slo = archive::utf8_text(capture.slo_name());
  if (capture.format()) link.format = text_of(*capture.format());
  if (const auto* finding = capture.finding(); finding != nullptr && finding->sure() != nullptr) {
    for (const std::string_view name : finding->sure()->encoders) link.encoders.emplace_back(name);
    if (const auto* better = capture.better_format();
        better != nullptr && text_of(better->format) != link.format) {
      link.other_format = text_of(better->format);
    }
  }
  decode::Statistics statistics;
  decode::LimitWatch limits(capture.timing(), capture.margin().resolution);
  const bool read = capture.read([&](std::uint64_t, const decode::Cycle& cycle) {
    statistics.add(cycle, limits.judge(cycle));
    return true;
  });
  link.counts = statistics.counts();
  // By Quantity.
  using decode::Statistics;
  constexpr std::array by_quantity{&Statistics::period,     &Statistics::interval,
                                   &Statistics::line_delay, &Statistics::ack,
                                   &Statistics::ack_clocks, &Statistics::duty};
  static_assert(by_quantity.size() == archive::quantity_count);
  for (std::size_t i = 0; i < archive::quantity_count; ++i) {
    const decode::Distribution& values = (statistics.*by_quantity[i])();
    if (values.count() != 0) link.ranges[i] = {values.min(), values.median(), values.max()};
    link.histograms.emplace_back(values);
  }
  return read;
}

void end_early(FileEntry& entry, std::string_view cause, const std::string& message) {
  entry.reading = entry.links.empty() ? Reading::none : Reading::part;
  entry.cause = cause;
  entry.message = archive::utf8_text(message);
}

class FileReader {
 public:
  FileReader(const CaptureArguments& arguments, unsigned threads, FileEntry& entry, Host& host)
      : arguments_(arguments), entry_(entry), host_(&host) {
    arguments_.threads = threads;
  }

  void read(const std::string& path) {
    arguments_.files = {path};
    arguments_.each = true;
    arguments_.keep_unknown = true;
    arguments_.one_of_many = true;
    arguments_.identify = true;
    arguments_.identify_besides = true;
    if (capture_.open(arguments_) != ExitStatus::done)
      return end_early(entry_, no_such_line, last_message());
    while (capture_.next()) {
      if (!read_link()) return;
    }
    if (capture_.status() >= ExitStatus::usage) return end_early(entry_, cause(), last_message());
    if (entry_.links.empty()) return end_early(entry_, "no_cycle", no_request_);
    entry_.reading = Reading::whole;
  }

 private:
  // False if nothing else of the file is to be read.
  bool read_link() {
    const bool given =
        !arguments_.device.format.empty() || !arguments_.ma.empty() || !arguments_.slo.empty();
    if (!capture_.has_lines() || !given) {
      const identify::ProtocolGuess guess = capture_.protocol();
      const bool other = is_other(guess.protocol);
      if (!capture_.has_lines() || other) {
        const std::string& name = capture_.input().name();
        end_early(entry_, other ? "other_protocol" : "no_lines",
                  other ? fmt::format("{}: the lines look like {} ({})", name,
                                      name_of(guess.protocol), guess.why)
                        : fmt::format("{}: no pair of lines behaves like MA and SLO", name));
        return false;
      }
    }
    LinkEntry link;
    const bool whole = measure(capture_, link);
    if (link.counts.cycles != 0) {
      entry_.links.push_back(std::move(link));
    } else {
      no_request_ = capture_.no_request();
    }
    if (!whole) end_early(entry_, cause(), capture_.input().error());
    return whole;
  }

  std::string_view cause() const {
    const auto& cause = capture_.input().cause();
    return cause ? capture::name_of(*cause) : no_such_line;
  }
  std::string last_message() const { return host_.lines().empty() ? "" : host_.lines().back(); }

  CaptureArguments arguments_;
  FileEntry& entry_;
  MemoryHost host_;
  DecodedCapture capture_{host_};
  std::string no_request_;
};

}  // namespace

FileEntry read_listed_file(const archive::ListedFile& file, const CaptureArguments& arguments,
                           unsigned threads, Host& host) {
  FileEntry entry;
  entry.path = archive::utf8_text(file.path);
  entry.bytes = file.stamp.bytes;
  entry.day = archive::day_in(entry.path);
  entry.dated_by_path = entry.day.has_value();
  if (!file.cause.empty()) {
    entry.cause = file.cause;
    entry.message = archive::utf8_text(file.message);
    return entry;
  }
  if (!entry.day) entry.day = archive::day_of(file.stamp.time);
  const auto fail = [&](const char* cause, const char* why) {
    entry.links.clear();
    end_early(entry, cause, fmt::format("{}: {}", file.path, why));
  };
  // One file must not end the run of all others.
  try {
    FileReader(arguments, threads, entry, host).read(file.path);
  } catch (const std::bad_alloc&) {
    fail(out_of_memory, "out of memory");
  } catch (const std::exception& error) {
    fail("read_failed", error.what());
  }
  archive::FileStamp after;
  if (archive::read_stamp(file.path, after) && after != file.stamp) {
    end_early(entry, changed,
              fmt::format("{}: the file changed while it was read; read it again", file.path));
  }
  return entry;
}

bool is_lasting(const FileEntry& entry) {
  constexpr std::array<std::string_view, 4> passing{"cannot_open", "read_failed", out_of_memory,
                                                    changed};
  return std::find(passing.begin(), passing.end(), entry.cause) == passing.end();
}

}  // namespace biss::verbs
