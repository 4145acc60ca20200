#include "verbs/simulate/setup.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <limits>

#include "biss/timing/cable.hpp"
#include "device/quantity.hpp"
#include "report/summary.hpp"
#include "sim/encoder.hpp"
#include "sim/line.hpp"
#include "verbs/simulate/fault_option.hpp"

namespace biss::verbs {

namespace {

std::string put_motion(const LineOptions& options, sim::LineSetup& setup) {
  const auto& names = sim::motion_names;
  const auto motion = std::find(names.begin(), names.end(), options.motion);
  if (motion == names.end()) {
    return fmt::format("--motion: '{}' is not one of {}", options.motion, fmt::join(names, ", "));
  }
  setup.motion = static_cast<sim::MotionKind>(motion - names.begin());
  if (!setup.position) return {};
  const unsigned bits = sim::position_word(setup.format).position_bits();
  if (bits == 0) return "--position: the format has no position";
  if (*setup.position <= low_mask(bits)) return {};
  return fmt::format("--position: 0 to {}, the position has {} bits", low_mask(bits), bits);
}

std::string put_delays(const LineOptions& options, sim::LineSetup& setup) {
  const Picoseconds cable = cable_delay(options.cable);
  setup.ma_delay = options.ma_delay.value_or(cable / 2);
  setup.slo_delay = options.slo_delay.value_or(cable - cable / 2);
  setup.internal_delay = options.internal_delay.value_or(setup.timing.internal_delay_max);
  const Picoseconds delay = setup.ma_delay + setup.slo_delay + setup.internal_delay * setup.slaves;
  if (delay <= biss_line_delay_max) return {};
  return fmt::format("--cable: the line delay is {}; BiSS C allows at most {}", text_of(delay, 3),
                     text_of(biss_line_delay_max));
}

// An edge cannot arrive before it was sent. Returns one line if the jitter is too large, else nothing.
std::string check_jitter(const char* line, Picoseconds jitter, Picoseconds delay) {
  if (jitter <= delay) return {};
  return fmt::format(
      "--jitter: the delay of {} is {}, so its edges cannot come {} earlier; give a longer --cable "
      "or less jitter",
      line, text_of(delay, 3), text_of(jitter, 3));
}

std::string put_jitter(const LineOptions& options, sim::LineSetup& setup) {
  setup.ma_jitter = options.ma_jitter.value_or(options.jitter);
  setup.slo_jitter = options.slo_jitter.value_or(options.jitter);
  std::string wrong = check_jitter("MA", setup.ma_jitter, setup.ma_delay);
  if (!wrong.empty()) return wrong;
  return check_jitter("SLO", setup.slo_jitter, setup.slo_delay + setup.internal_delay);
}

std::string check_chain(const LineOptions& /*options*/, sim::LineSetup& setup) {
  return wrong_slaves(setup.slaves, setup.format);
}

std::string put_faults(const LineOptions& options, sim::LineSetup& setup) {
  if (setup.pause_clocks != 0 && setup.pause.count == 0) return "--pause-every: needs --pause";
  bool pauses = setup.pause_clocks != 0;
  for (const std::string& text : options.faults) {
    const auto rule = read_fault(text);
    if (!rule) return rule.error();
    const bool flag = rule->kind == sim::FaultKind::nE || rule->kind == sim::FaultKind::nW;
    const FieldKind needed =
        rule->kind == sim::FaultKind::nE ? FieldKind::error : FieldKind::warning;
    if (const auto missing = missing_field(setup.format, needed); flag && !missing.empty()) {
      return fmt::format("--fault: {}: {}", sim::name_of(rule->kind), missing);
    }
    const ChannelFormat& word = sim::position_word(setup.format);
    if (rule->kind == sim::FaultKind::late_turns &&
        (!word.multiturn.present() || !word.singleturn.present())) {
      return "--fault: late_turns: the format has no turns above a singleturn position (mt and st)";
    }
    pauses = pauses || rule->kind == sim::FaultKind::ma_pause;
    setup.faults.push_back(*rule);
  }
  return setup.pause.count != 0 && !pauses ? "--pause: needs --pause-every or --fault ma_pause"
                                           : "";
}

std::string put_life(const LineOptions& options, sim::LineSetup& setup) {
  setup.life.first = options.counter == "count_0_63" ? 0 : 1;
  const auto& starts = options.counter_start;
  const std::string missing = missing_field(setup.format, FieldKind::life_counter);
  if (!starts.empty() && !missing.empty()) return "--counter-start: " + missing;
  if (setup.format.channel_count == setup.slaves && options.drift != 0) {
    return "--drift: no encoder has a further word that could drift";
  }
  if (starts.size() > setup.format.channel_count) {
    return fmt::format("--counter-start: {} values for {} channels", starts.size(),
                       setup.format.channel_count);
  }
  for (std::size_t k = 0; k < max_channels && !starts.empty(); ++k) {
    const std::uint64_t start = starts[std::min(k, starts.size() - 1U)];
    if (start < setup.life.first || start > 63) {
      return fmt::format("--counter-start: {} to 63", setup.life.first);
    }
    setup.life.starts[k] = static_cast<std::uint8_t>(start);
  }
  if (options.drift < INT32_MIN || options.drift > INT32_MAX) {
    return fmt::format("--drift: {} to {} counts per cycle", INT32_MIN, INT32_MAX);
  }
  setup.drift = static_cast<std::int32_t>(options.drift);
  return {};
}

std::string check_control(const LineOptions& /*options*/, sim::LineSetup& setup) {
  if (!setup.registers.empty() && setup.format.cds0) {
    return "--registers: the format has the option cds0, so this encoder has no registers";
  }
  if (setup.registers.size() <= setup.slaves) return {};
  return fmt::format("--registers: there is no encoder with ID {}; --slaves gives their number, {}",
                     setup.registers.size() - 1, setup.slaves);
}

std::string put_processing(const LineOptions& options, sim::LineSetup& setup) {
  if (!options.processing) return {};
  const DeviceTiming& timing = setup.timing;
  if (timing.ack_clocks != 0) {
    return "--processing: ACK of this encoder has a fixed length of " +
           report::counted(timing.ack_clocks, "clock");
  }
  if (*options.processing > timing.ack_max) {
    return fmt::format("--processing: this encoder takes at most {}{}", text_of(timing.ack_max),
                       timing.ack_max < biss_busy_max ? "; --ack-max sets another limit" : "");
  }
  setup.processing = *options.processing;
  return {};
}

// After put_rate(): a time is counted in cycles.
std::string put_busy(const LineOptions& options, sim::LineSetup& setup) {
  if (options.register_busy.empty()) return {};
  if (setup.registers.empty()) return "--register-busy: needs --registers";
  RegisterBusy busy;
  std::string wrong = read_busy(options.register_busy, sim::Line(setup).nominal().interval, busy);
  for (sim::EncoderRegisters& registers : setup.registers) registers.set_busy(busy);
  return wrong;
}

std::string put_rate(const LineOptions& options, sim::LineSetup& setup) {
  const DeviceTiming& timing = setup.timing;
  if (setup.clock < timing.clock_min || setup.clock > timing.clock_max) {
    return fmt::format("--clock: this encoder accepts {} to {}", text_of(timing.clock_min),
                       text_of(timing.clock_max));
  }
  if (!options.rate) return {};
  // As soon as the encoder is ready: with a given rate, the jitter would add to it.
  setup.interval = picoseconds(1);
  const Picoseconds least = sim::least_interval(setup);
  setup.interval = period_of(*options.rate);
  if (setup.interval >= least) return {};
  return fmt::format(
      "--rate: a cycle takes {}, so at most {} is feasible", text_of(least, 3),
      text_of(Hertz{static_cast<std::uint32_t>(picoseconds_per_second / least.count)}));
}

}  // namespace

std::string wrong_start(const sim::LineSetup& setup) {
  const DeviceTiming& timing = setup.timing;
  const Picoseconds period = period_of(setup.clock);
  const Picoseconds earliest = std::max(timing.start_min, timing.sampling_typical);
  const std::int64_t least_clocks = clocks_to_cover(earliest, period) - 1;
  if (timing.ack_clocks != 0 && timing.ack_clocks < least_clocks) {
    return fmt::format(
        "--ack-clocks: at {} this encoder answers after {} clocks at the earliest; it takes its "
        "position {} after LAT",
        text_of(setup.clock), least_clocks, text_of(earliest));
  }
  if (setup.processing.count == 0 || setup.processing >= earliest - period) return {};
  return fmt::format("--processing: at {} this encoder takes at least {}", text_of(setup.clock),
                     text_of(earliest - period, 3));
}

std::string read_busy(const std::string& text, Picoseconds interval, RegisterBusy& busy) {
  constexpr std::uint16_t most = std::numeric_limits<std::uint16_t>::max();
  std::uint64_t frames = 0;
  if (const auto count = parse_count(text, most); count.ok()) {
    frames = *count;
  } else if (const auto time = parse_duration(text); time.ok()) {
    frames = static_cast<std::uint64_t>((time->count + interval.count - 1) / interval.count);
  } else {
    return fmt::format("--register-busy: '{}': give frames, at most {}, or a time like 3ms", text,
                       most);
  }
  if (frames > most) {
    return fmt::format("--register-busy: {} are {} frames at this rate; the limit is {}", text,
                       frames, most);
  }
  busy = {static_cast<std::uint16_t>(frames), static_cast<std::uint16_t>(frames)};
  return {};
}

tl::expected<sim::LineSetup, std::string> line_setup(const LineOptions& options) {
  const auto choice = choose_device(options.device);
  if (!choice) return tl::unexpected(choice.error());
  sim::LineSetup setup = options.setup;
  setup.format = choice->format;
  setup.timing = choice->timing;
  setup.compensate = !options.no_compensation;
  for (const auto put : {put_motion, check_chain, put_delays, put_jitter, put_life, put_faults,
                         check_control, put_processing, put_rate, put_busy}) {
    if (std::string wrong = put(options, setup); !wrong.empty()) return tl::unexpected(wrong);
  }
  return setup;
}

}  // namespace biss::verbs
