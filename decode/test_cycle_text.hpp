// A cycle as text, for tests that compare two ways of reading it.
#pragma once

#include <fmt/format.h>

#include <optional>
#include <string>
#include <type_traits>

#include "decode/cycle.hpp"

namespace biss::decode::test {

template <class T>
std::string text_of_value(const std::optional<T>& value) {
  if (!value) return "-";
  if constexpr (std::is_same_v<T, Picoseconds>) {
    return fmt::format("{}", value->count);
  } else {
    return fmt::format("{}", *value);
  }
}

// Everything that a row can show, and a little more.
inline std::string text_of(const Cycle& cycle) {
  std::string text = fmt::format(
      "{} {} delay {} early {} ack {} period {} duty {} marginal {} rises {} clocked {} doubt {} "
      "cdm {} release {}",
      cycle.time.count, name_of(cycle.status), text_of_value(cycle.line_delay),
      text_of_value(cycle.early), text_of_value(cycle.ack), text_of_value(cycle.period),
      text_of_value(cycle.duty_per_mille), text_of_value(cycle.marginal), cycle.rising_edges,
      cycle.clocked.count, cycle.uncertainty.count, text_of_value(cycle.cdm),
      text_of_value(cycle.release));
  if (cycle.clock_change) {
    text += fmt::format(" change {} {}", cycle.clock_change->most.count,
                        cycle.clock_change->doubt.count);
  }
  if (cycle.pauses != 0) {
    text += fmt::format(" pauses {} {}", cycle.pauses, cycle.longest_pause.count);
  }
  if (cycle.signal) {
    const LineSignal& signal = *cycle.signal;
    text += fmt::format(" signal {} {} {} {} {} {}", signal.pulse_max.count, signal.ma_pulses,
                        signal.slo_pulses, text_of_value(signal.ma_shortest),
                        text_of_value(signal.ready), text_of_value(signal.frame_clocks));
    if (signal.changes) {
      text += fmt::format(" changes {} {} {}", signal.changes->earliest.count,
                          signal.changes->latest.count, signal.changes->sampled.count);
    }
  }
  text += " raw ";
  for (std::size_t i = 0; i < cycle.raw.size_bits(); ++i) text += cycle.raw.view()[i] ? '1' : '0';
  for (const auto& ok : cycle.crc_ok) text += fmt::format(" {}", text_of_value(ok));
  if (cycle.frame) {
    text += fmt::format(" frame {} {} {} {}", cycle.frame->cds, cycle.frame->stop_seen,
                        cycle.frame->lead_clocks, cycle.frame->ack_clocks);
    for (const Channel& channel : cycle.frame->channels()) {
      text += fmt::format(" [{} {} {} {}]", channel.position, channel.life_counter, channel.nE,
                          channel.nW);
    }
  }
  return text;
}

}  // namespace biss::decode::test
