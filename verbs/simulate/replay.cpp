#include "verbs/simulate/replay.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "biss/base/bits.hpp"
#include "decode/decoder.hpp"
#include "decode/times.hpp"
#include "device/quantity.hpp"
#include "rows/table.hpp"
#include "sim/encoder.hpp"
#include "sim/ma_replay.hpp"
#include "sim/slo_replay.hpp"
#include "verbs/common/capture_input.hpp"
#include "verbs/common/host.hpp"
#include "verbs/common/terminal.hpp"
#include "verbs/common/text_file.hpp"
#include "verbs/simulate/line_output.hpp"
#include "verbs/simulate/truth.hpp"

namespace biss::verbs {

namespace {

// The time between two requests that motions assume: the recorded one is not known in advance.
constexpr Picoseconds motion_interval = microseconds(100);

using Positions = tl::expected<std::vector<std::uint64_t>, VerbError>;

// One position a line. At least one position, at most a million.
Positions read_positions(const std::string& path, unsigned bits) {
  constexpr std::size_t max_positions = 1'000'000;
  std::vector<std::uint64_t> positions;
  const auto read = read_lines("--positions", path, [&](std::string_view line) {
    if (positions.size() == max_positions) {
      return fmt::format("more than {} positions", max_positions);
    }
    const auto position = parse_count(line, low_mask(bits));
    if (!position.ok()) {
      return quantity_error_text(Quantity::count, line, position.error(), low_mask(bits));
    }
    positions.push_back(*position);
    return std::string();
  });
  if (!read) return tl::make_unexpected(read.error());
  if (positions.empty()) {
    return tl::make_unexpected(VerbError{
        ExitStatus::io, fmt::format("{}: no position", path == "-" ? "standard input" : path)});
  }
  return positions;
}

// The capture of one side of the line.
struct Recording {
  explicit Recording(Host& host) : input(host) {}

  CaptureInput input;
  decode::Lines lines;
};

// Finds MA, and SLO for --slo-from. Prints why it cannot.
ExitStatus open_recording(const ReplayOptions& options, Recording& recording, Host& host) {
  const bool reads_slo = !options.slo_from.empty();
  InputArguments arguments{.files = {reads_slo ? options.slo_from : options.ma_from},
                           .ma = options.ma,
                           .slo = options.slo,
                           .raw = options.raw};
  CaptureInput& input = recording.input;
  auto captures = list_captures(arguments, host);
  if (!captures) return captures.error();
  const ExitStatus opened = input.open(std::move(captures->front()), arguments);
  if (opened != ExitStatus::done) return opened;
  const decode::CycleReader reader(std::nullopt, DeviceTiming{});
  if (reads_slo) {
    const auto found = input.find_lines(reader);
    if (!found) return found.error();
    recording.lines = found->front().lines;
  } else {
    const auto found = input.find_ma(reader);
    if (!found) return found.error();
    recording.lines.ma = *found;
  }
  return input.error().empty() ? ExitStatus::done : host.fail(ExitStatus::io, input.error());
}

// An estimate from the shortest pulse of MA at the beginning, for the sample rate.
Hertz clock_of(Recording& recording) {
  Picoseconds shortest = period_of(biss_clock_min);
  std::optional<Picoseconds> last;
  for (const wire::Edge& edge : recording.input.beginning()) {
    if (edge.line != recording.lines.ma) continue;
    if (last) shortest = std::min(shortest, 2 * decode::elapsed(*last, edge.time));
    last = edge.time;
  }
  return std::clamp(rate_of(shortest), biss_clock_min, biss_clock_max);
}

ExitStatus open_output(const WriteOptions& write, Recording& recording,
                       const std::string& rows_path, std::span<const report::Column> columns,
                       LineOutput& output) {
  const bool opened = output.open(write.output, {"MA", "SLO"}, clock_of(recording),
                                  write.sample_rate, rows_path, columns);
  return opened ? ExitStatus::done : output.status();
}

// Passes all blocks of the capture to `push`, which appends edges to its argument.
ExitStatus pump(
    CaptureInput& input, LineOutput& output,
    const std::function<void(std::span<const wire::Edge>, std::vector<wire::Edge>&)>& push,
    Host& host) {
  std::vector<wire::Edge> made;
  Progress progress(host);
  for (auto block = input.next(); !block.empty(); block = input.next()) {
    if (progress.due()) progress.show(input.progress_text(progress.seconds()));
    if (block.front().time < -sim::replay_time_max || block.back().time > sim::replay_time_max) {
      return host.fail(
          ExitStatus::io,
          fmt::format("{}: has times beyond ten days; cut the part to be replayed out of it",
                      input.name()));
    }
    made.clear();
    push(block, made);
    if (!output.write(made)) return output.status();
  }
  if (!input.error().empty()) return host.fail(ExitStatus::io, input.error());
  return ExitStatus::done;
}

sim::MaReplaySetup setup_of(const sim::LineSetup& line, bool timeout_known) {
  SlaveTiming timing = slave_timing(line.timing, line.processing);
  if (!timeout_known) timing.timeout = {TimeoutRule::adaptive, {}};
  return {.codec = FrameCodec<>(line.format),
          .timing = timing,
          .line_delay = line.ma_delay + line.slo_delay + line.internal_delay,
          .registers = line.registers.empty() ? std::nullopt : std::optional(line.registers[0])};
}

// Counts answers by kind and makes their rows of truth.
class AnswerLog {
 public:
  explicit AnswerLog(const FrameFormat& format) : table_(format) {}

  const std::vector<report::Column>& columns() const { return table_.columns(); }

  /// \param sampled when the encoder took its last position
  std::vector<report::Cell> cells(const sim::Answer& answer, std::optional<Picoseconds> sampled) {
    sim::SimulatedCycle cycle;
    cycle.time = answer.time;
    cycle.sent = answer.sent;
    std::fill_n(cycle.taken.begin(), answer.sent.channel_count, true);
    if (answer.sent.channel_count != 0) cycle.sampled = sampled;
    std::vector<report::Cell> cells = table_.cells(total(), cycle);
    ++counts_[static_cast<std::size_t>(answer.kind)];
    constexpr std::size_t faults = 5;
    if (answer.kind == sim::AnswerKind::cut) cells[faults] = "truncated";
    if (answer.kind == sim::AnswerKind::not_ready) cells[faults] = "not_ready";
    return cells;
  }

  std::uint64_t total() const { return counts_[0] + counts_[1] + counts_[2]; }
  std::uint64_t answered() const { return counts_[0]; }
  /// The master ended requests before STOP, and not only the last one at the end of the capture.
  bool cut() const { return counts_[1] > (counts_[0] == 0 ? 0U : 1U); }
  std::string text() const {
    std::string text = fmt::format("{} requests, {} answered up to STOP", total(), counts_[0]);
    if (counts_[1] != 0) text += fmt::format(", {} cut by the master", counts_[1]);
    if (counts_[2] != 0) {
      text +=
          fmt::format(", {} before the encoder was ready (--timeout sets when it is)", counts_[2]);
    }
    return text + "\n";
  }

 private:
  TruthTable table_;
  std::array<std::uint64_t, 3> counts_{};
};

decode::Cycle cycle_of(const sim::ReplayReading& replayed, const FrameFormat& format) {
  const auto& reading = replayed.reading;
  decode::Cycle cycle;
  cycle.time = reading.begin;
  cycle.line_delay = reading.line_delay;
  if (reading.line_delay) cycle.marginal = reading.marginal;
  if (replayed.period.count != 0) cycle.period = replayed.period;
  if (reading.ack_clocks != 0) cycle.ack = reading.ack_clocks * replayed.period;
  // The number of channels with a good checksum; the master reads no channel after a wrong one.
  std::size_t right = format.channel_count;
  if (reading.frame.ok()) {
    cycle.frame = *reading.frame;
  } else {
    const FrameFault fault = reading.frame.error();
    cycle.status = status_of(fault.cause);
    if (fault.cause == FrameError::crc) {
      right = fault.channel;
      cycle.crc_ok[right] = false;
    } else if (fault.cause != FrameError::stop_bit) {
      right = 0;
    }
  }
  for (std::size_t k = 0; k < right; ++k) {
    if (format.channel_list[k].crc.present()) cycle.crc_ok[k] = true;
  }
  return cycle;
}

// A recorded master cannot wait for an answer that did not exist when it was recorded.
std::string waiting_master(const std::string& output) {
  return fmt::format(
      "the recorded master ended requests before STOP. If it waits for START, feed it the SLO of "
      "{}, "
      "record its MA again and run --ma-from on the new recording; repeat until every request is "
      "answered up to STOP",
      output == "-" ? "the output" : fmt::format("'{}'", output));
}

ExitStatus no_request(const CaptureInput& input, Host& host) {
  return host.fail(ExitStatus::data_failed,
                   fmt::format("{}: no request on MA; check that --ma names "
                               "the right line and that the master was running",
                               input.name()));
}

// Answers the recording with this timing.
ExitStatus answer_recording(const ReplayOptions& options, const WriteOptions& write,
                            const sim::LineSetup& setup, bool timeout_known,
                            const std::vector<std::uint64_t>& positions, AnswerLog& log,
                            Host& host) {
  Recording recorded(host);
  LineOutput output(host);
  ExitStatus status = open_recording(options, recorded, host);
  if (status == ExitStatus::done) {
    status = open_output(write, recorded, write.truth, log.columns(), output);
  }
  if (status != ExitStatus::done) return status;

  sim::Encoder encoder(setup.format, sim::Motion(setup.motion, sim::position_word(setup.format),
                                                 motion_interval, setup.seed));
  sim::MaReplay replay(
      setup_of(setup, timeout_known),
      [&](Picoseconds moment) {
        encoder.begin_cycle(sim::sampling_shift(setup.timing, setup.seed, log.total()));
        if (!positions.empty()) encoder.hold(positions[log.total() % positions.size()]);
        return encoder.sample(moment);
      },
      [&](const sim::Answer& answered) { output.row(log.cells(answered, encoder.sampled())); });
  CaptureInput& input = recorded.input;
  status = pump(
      input, output, [&](auto edges, auto& made) { replay.push(edges, recorded.lines.ma, made); },
      host);
  if (status != ExitStatus::done) return status;
  std::vector<wire::Edge> made;
  const Picoseconds end = replay.finish(input.end_time(), made);
  if (log.total() == 0) return no_request(input, host);
  if (!output.write(made) || !output.finish(end)) return output.status();
  return ExitStatus::done;
}

// The master of --rerun, which reads the answers and writes the recording again.
ExitStatus run_master(const std::string& command, Host& host) {
  const int status = std::system(command.c_str());
  if (status == 0) return ExitStatus::done;
  return host.fail(ExitStatus::io, fmt::format("--rerun: the command failed: '{}'", command));
}

ExitStatus check_rerun(const ReplayOptions& options, const WriteOptions& write, Host& host) {
  if (options.rerun.empty()) return ExitStatus::done;
  if (options.ma_from != "-" && write.output != "-" && options.positions != "-") {
    return ExitStatus::done;
  }
  return host.fail(ExitStatus::usage,
                   "--rerun: give files, not -: the command writes and reads them");
}

}  // namespace

ExitStatus replay_ma(const ReplayOptions& options, const WriteOptions& write,
                     const LineOptions& line, Host& host) {
  const auto setup = line_setup(line);
  if (!setup) return host.fail(ExitStatus::usage, setup.error());
  if (!line.register_busy.empty() && !parse_count(line.register_busy).ok()) {
    return host.fail(ExitStatus::usage,
                     "--register-busy: with --ma-from give a number of frames, not a time");
  }
  if (const ExitStatus wrong = check_rerun(options, write, host); wrong != ExitStatus::done)
    return wrong;
  std::vector<std::uint64_t> positions;
  if (!options.positions.empty()) {
    auto read =
        read_positions(options.positions, sim::position_word(setup->format).position_bits());
    if (!read) return host.fail(read.error());
    positions = std::move(*read);
  }
  const bool timeout_known =
      choose_device(line.device)->timing_known() || !line.device.timeout.empty();
  // Each run of a master that waits for START completes at least one request more.
  for (std::uint64_t answered = 0;;) {
    AnswerLog log(setup->format);
    const ExitStatus status =
        answer_recording(options, write, *setup, timeout_known, positions, log, host);
    if (status != ExitStatus::done) return status;
    host.print_summary(log.text());
    if (!log.cut()) return ExitStatus::done;
    if (options.rerun.empty()) {
      host.warn(waiting_master(write.output));
      return ExitStatus::done;
    }
    if (log.answered() < answered) {
      return host.fail(
          ExitStatus::data_failed,
          "--rerun: the master still ends requests before STOP; check that the command "
          "reads the output and writes the recording");
    }
    answered = log.answered() + 1;
    if (const ExitStatus ran = run_master(options.rerun, host); ran != ExitStatus::done) return ran;
  }
}

ExitStatus replay_slo(const ReplayOptions& options, const WriteOptions& write,
                      const LineOptions& line, Host& host) {
  const auto setup = line_setup(line);
  if (!setup) return host.fail(ExitStatus::usage, setup.error());
  if (setup->format.needs_previous()) {
    return host.fail(ExitStatus::usage, "-f: with :previous a master cannot check a frame");
  }
  Recording recorded(host);
  LineOutput output(host);
  rows::DecodeTable table(setup->format);
  ExitStatus status = open_recording(options, recorded, host);
  if (status == ExitStatus::done) {
    status = open_output(write, recorded, options.readings, table.columns(), output);
  }
  if (status != ExitStatus::done) return status;

  MasterSetup master{
      .timing = setup->timing, .slaves = setup->slaves, .compensate = setup->compensate};
  if (options.own_clock) master.period = period_of(setup->clock);
  std::uint64_t total = 0;
  std::uint64_t good = 0;
  std::uint64_t marginal = 0;
  sim::SloReplay replay({FrameCodec<>(setup->format), master},
                        [&](const sim::ReplayReading& reading) {
                          const decode::Cycle cycle = cycle_of(reading, setup->format);
                          output.row(table.cells(total++, cycle));
                          if (cycle.frame) ++good;
                          if (reading.reading.marginal) ++marginal;
                        });
  CaptureInput& input = recorded.input;
  const decode::Lines lines = recorded.lines;
  status = pump(
      input, output, [&](auto edges, auto& made) { replay.push(edges, lines.ma, lines.slo, made); },
      host);
  if (status != ExitStatus::done) return status;
  std::vector<wire::Edge> made;
  replay.finish(input.end_time(), made);
  if (total == 0) return no_request(input, host);
  if (!output.write(made) || !output.finish(input.end_time())) return output.status();
  host.print_summary(
      fmt::format("{} requests, {} read, {} of them marginal\n", total, good, marginal));
  return ExitStatus::done;
}

}  // namespace biss::verbs
