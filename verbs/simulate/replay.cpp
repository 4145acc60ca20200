#include "verbs/simulate/replay.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdlib>
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
#include "verbs/common/terminal.hpp"
#include "verbs/common/text_file.hpp"
#include "verbs/simulate/line_output.hpp"
#include "verbs/simulate/truth.hpp"

namespace biss::verbs {

namespace {

// The time between two requests that motions assume: the recorded one is not known in advance.
constexpr Picoseconds motion_interval = microseconds(100);

// One position a line. At least one position, at most a million.
std::vector<std::uint64_t> read_positions(const std::string& path, unsigned bits) {
  constexpr std::size_t max_positions = 1'000'000;
  std::vector<std::uint64_t> positions;
  read_lines("--positions", path, [&](std::string_view line) {
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
  if (positions.empty()) throw wrong_file("{}: no position", path == "-" ? "standard input" : path);
  return positions;
}

// A capture of one side of the line, and the capture of both sides that is made of it.
class Recording {
 public:
  Recording(const ReplayOptions& options, Host& host) : options_(options), host_(host) {}

  // Finds MA, and SLO for --slo-from, and opens the outputs. Prints why it cannot.
  ExitStatus open(const WriteOptions& write, const std::string& rows_path,
                  std::span<const report::Column> columns) {
    const bool reads_slo = !options_.slo_from.empty();
    InputArguments arguments{.files = {reads_slo ? options_.slo_from : options_.ma_from},
                             .ma = options_.ma,
                             .slo = options_.slo,
                             .raw = options_.raw};
    auto captures = list_captures(arguments, host_);
    if (!captures) return captures.error();
    const ExitStatus opened = input_.open(std::move(captures->front()), arguments);
    if (opened != ExitStatus::done) return opened;
    const decode::CycleReader reader(std::nullopt, DeviceTiming{});
    if (reads_slo) {
      const auto found = input_.find_lines(reader);
      if (!found) return found.error();
      lines_ = found->front().lines;
    } else {
      const auto found = input_.find_ma(reader);
      if (!found) return found.error();
      lines_.ma = *found;
    }
    fail_if(input_.error(), ExitStatus::io);
    const bool done =
        output_.open(write.output, {"MA", "SLO"}, clock(), write.sample_rate, rows_path, columns);
    return done ? ExitStatus::done : output_.status();
  }

  // Writes the row of the truth or of the readings that `make` returns, if there are rows.
  template <class Make>
  void row(const Make& make) {
    if (output_.has_rows()) output_.row(make());
  }

  // Passes all edges of the capture to `push`, which appends the edges that it makes. `finish` does
  // the same at the end, and returns when the new capture ends; `total` counts requests.
  template <class Push, class Finish>
  ExitStatus run(const Push& push, const Finish& finish, const std::uint64_t& total) {
    std::vector<wire::Edge> made;
    Progress progress(host_);
    for (auto block = input_.next(); !block.empty(); block = input_.next()) {
      if (progress.due()) progress.show(input_.progress_text(progress.seconds()));
      if (block.front().time < -sim::replay_time_max || block.back().time > sim::replay_time_max) {
        throw wrong_file("{}: has times beyond ten days; cut the part to be replayed out of it",
                         input_.name());
      }
      made.clear();
      push(block, lines_, made);
      if (!output_.write(made)) return output_.status();
    }
    fail_if(input_.error(), ExitStatus::io);
    made.clear();
    const Picoseconds end = finish(input_.end_time(), made);
    if (total == 0) {
      return host_.fail(ExitStatus::data_failed,
                        fmt::format("{}: no request on MA; check that --ma names "
                                    "the right line and that the master was running",
                                    input_.name()));
    }
    return output_.write(made) && output_.finish(end) ? ExitStatus::done : output_.status();
  }

 private:
  // An estimate from the shortest pulse of MA at the beginning, for the sample rate.
  Hertz clock() {
    Picoseconds shortest = period_of(biss_clock_min);
    std::optional<Picoseconds> last;
    for (const wire::Edge& edge : input_.beginning()) {
      if (edge.line != lines_.ma) continue;
      if (last) shortest = std::min(shortest, 2 * decode::elapsed(*last, edge.time));
      last = edge.time;
    }
    return std::clamp(rate_of(shortest), biss_clock_min, biss_clock_max);
  }

  const ReplayOptions& options_;
  Host& host_;
  CaptureInput input_{host_};
  decode::Lines lines_;
  LineOutput output_{host_};
};

sim::MaReplaySetup setup_of(const sim::LineSetup& line, bool timeout_known) {
  SlaveTiming timing = slave_timing(line.timing, line.processing);
  if (!timeout_known) timing.timeout = {TimeoutRule::adaptive, {}};
  return {.codec = FrameCodec<>(line.format),
          .timing = timing,
          .line_delay = line.ma_delay + line.slo_delay + line.internal_delay,
          .registers = line.registers.empty() ? std::nullopt : std::optional(line.registers[0])};
}

// Answers by kind.
struct AnswerCounts {
  std::array<std::uint64_t, 3> of_kind{};
  std::uint64_t total = 0;

  std::uint64_t answered() const { return of_kind[0]; }
  /// The master ended requests before STOP, and not only the last one at the end of the capture.
  bool cut() const { return of_kind[1] > (of_kind[0] == 0 ? 0U : 1U); }
  std::string text() const {
    std::string text = fmt::format("{} requests, {} answered up to STOP", total, of_kind[0]);
    if (of_kind[1] != 0) text += fmt::format(", {} cut by the master", of_kind[1]);
    if (of_kind[2] != 0) {
      text +=
          fmt::format(", {} before the encoder was ready (--timeout sets when it is)", of_kind[2]);
    }
    return text + "\n";
  }
};

// \param sampled when the encoder took its last position
FieldRow answer_row(const FrameFormat& format, std::uint64_t number, const sim::Answer& answer,
                    std::optional<Picoseconds> sampled) {
  constexpr std::array<std::string_view, 3> faults{"", "truncated", "not_ready"};
  sim::SimulatedCycle cycle;
  cycle.time = answer.time;
  cycle.sent = answer.sent;
  std::fill_n(cycle.taken.begin(), answer.sent.channel_count, true);
  if (answer.sent.channel_count != 0) cycle.sampled = sampled;
  return truth_row(format, number, cycle, faults[static_cast<std::size_t>(answer.kind)]);
}

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

// Answers the recording with this timing.
ExitStatus answer_recording(const ReplayOptions& options, const WriteOptions& write,
                            const sim::LineSetup& setup, bool timeout_known,
                            const std::vector<std::uint64_t>& positions, AnswerCounts& counts,
                            Host& host) {
  Recording recorded(options, host);
  const ExitStatus status =
      recorded.open(write, write.truth, columns_of(answer_row(setup.format, 0, {}, {})));
  if (status != ExitStatus::done) return status;
  sim::Encoder encoder(setup.format, sim::Motion(setup.motion, sim::position_word(setup.format),
                                                 motion_interval, setup.seed));
  sim::MaReplay replay(
      setup_of(setup, timeout_known),
      [&](Picoseconds moment) {
        encoder.begin_cycle(sim::sampling_shift(setup.timing, setup.seed, counts.total));
        if (!positions.empty()) encoder.hold(positions[counts.total % positions.size()]);
        return encoder.sample(moment);
      },
      [&](const sim::Answer& answer) {
        recorded.row(
            [&] { return answer_row(setup.format, counts.total, answer, encoder.sampled()); });
        ++counts.total;
        ++counts.of_kind[static_cast<std::size_t>(answer.kind)];
      });
  return recorded.run([&](auto edges, const decode::Lines& lines,
                          auto& made) { replay.push(edges, lines.ma, made); },
                      [&](Picoseconds end, auto& made) { return replay.finish(end, made); },
                      counts.total);
}

void check_rerun(const ReplayOptions& options, const WriteOptions& write) {
  if (options.rerun.empty()) return;
  if (options.ma_from == "-" || write.output == "-" || options.positions == "-") {
    throw wrong_usage("--rerun: give files, not -: the command writes and reads them");
  }
}

}  // namespace

ExitStatus replay_ma(const ReplayOptions& options, const WriteOptions& write,
                     const LineOptions& line, Host& host) {
  const sim::LineSetup setup = value_or_fail(line_setup(line));
  if (!line.register_busy.empty() && !parse_count(line.register_busy).ok()) {
    throw wrong_usage("--register-busy: with --ma-from give a number of frames, not a time");
  }
  check_rerun(options, write);
  std::vector<std::uint64_t> positions;
  if (!options.positions.empty()) {
    positions = read_positions(options.positions, sim::position_word(setup.format).position_bits());
  }
  const bool timeout_known =
      choose_device(line.device)->timing_known() || !line.device.timeout.empty();
  // Each run of a master that waits for START completes at least one request more.
  for (std::uint64_t answered = 0;;) {
    AnswerCounts counts;
    const ExitStatus status =
        answer_recording(options, write, setup, timeout_known, positions, counts, host);
    if (status != ExitStatus::done) return status;
    host.print_summary(counts.text());
    if (!counts.cut()) return ExitStatus::done;
    if (options.rerun.empty()) {
      host.warn(waiting_master(write.output));
      return ExitStatus::done;
    }
    if (counts.answered() < answered) {
      return host.fail(
          ExitStatus::data_failed,
          "--rerun: the master still ends requests before STOP; check that the command "
          "reads the output and writes the recording");
    }
    answered = counts.answered() + 1;
    // The master reads the answers and writes the recording again.
    if (std::system(options.rerun.c_str()) != 0) {
      throw wrong_file("--rerun: the command failed: '{}'", options.rerun);
    }
  }
}

ExitStatus replay_slo(const ReplayOptions& options, const WriteOptions& write,
                      const LineOptions& line, Host& host) {
  const sim::LineSetup setup = value_or_fail(line_setup(line));
  if (setup.format.needs_previous()) {
    throw wrong_usage("-f: with :previous a master cannot check a frame");
  }
  Recording recorded(options, host);
  rows::DecodeTable table(setup.format);
  ExitStatus status = recorded.open(write, options.readings, table.columns());
  if (status != ExitStatus::done) return status;

  MasterSetup master{
      .timing = setup.timing, .slaves = setup.slaves, .compensate = setup.compensate};
  if (options.own_clock) master.period = period_of(setup.clock);
  std::uint64_t total = 0;
  std::uint64_t good = 0;
  std::uint64_t marginal = 0;
  sim::SloReplay replay({FrameCodec<>(setup.format), master},
                        [&](const sim::ReplayReading& reading) {
                          const decode::Cycle cycle = cycle_of(reading, setup.format);
                          recorded.row([&] { return table.cells(total, cycle); });
                          ++total;
                          if (cycle.frame) ++good;
                          if (reading.reading.marginal) ++marginal;
                        });
  status = recorded.run([&](auto edges, const decode::Lines& lines,
                            auto& made) { replay.push(edges, lines.ma, lines.slo, made); },
                        [&](Picoseconds end, auto& made) {
                          replay.finish(end, made);
                          return end;
                        },
                        total);
  if (status != ExitStatus::done) return status;
  host.print_summary(
      fmt::format("{} requests, {} read, {} of them marginal\n", total, good, marginal));
  return ExitStatus::done;
}

}  // namespace biss::verbs
