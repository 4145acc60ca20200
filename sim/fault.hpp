// The faults that the toolkit can inject, by name: one list for the line model (`simulate
// --fault`), the campaigns and the analysis. docs/faults.md is printed from it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "biss/safety/verdict.hpp"

namespace biss::sim {

/// The first simulated_fault_count kinds are faults of the line model. The others are errors in the
/// received bits of a frame, from any cause; lab injects these. The last ones, from
/// line_only_fault_first on, exist only in Line: faults of a master, and late turns.
enum class FaultKind : std::uint8_t {
  flip,
  burst,
  glitch_ma,
  glitch_ma_idle,
  glitch_slo,
  glitch_slo_idle,
  lost_clock,
  double_clock,
  extra_clock,
  ma_low,
  ma_high,
  slo_low,
  slo_high,
  late_start,
  no_answer,
  cut,
  swap_ma,
  swap_slo,
  exchange,
  delay_step,
  nE,
  nW,
  brown_out,
  frozen,
  // Wrong frames: all checksums are good, except in `masquerade`.
  repeat,
  reorder,
  loss,
  delay,
  insert,
  masquerade,
  other_encoder,
  lc_restart,
  lc_frozen,
  // Errors in the received bits.
  flips,
  lost_bit,
  doubled_bit,
  inserted_low,
  inserted_high,
  gap_low,
  gap_high,
  lost_start,
  false_start,
  cds_high,
  stop_high,
  // Only in Line.
  ma_pause,
  short_frame,
  reduced_frame,
  late_turns,
};

inline constexpr std::size_t fault_kind_count = 48;
inline constexpr std::size_t line_only_fault_first = 44;
inline constexpr std::size_t simulated_fault_count = 33;
/// The kinds before the wrong frames.
inline constexpr std::size_t line_fault_kind_count = 24;

/// The duration of a fault, and the place in a cycle at which it begins.
enum class FaultExtent : std::uint8_t {
  bit,         ///< one bit
  bits,        ///< several bits in a row
  clock,       ///< from just before a falling edge of MA to just after the next rising edge
  bounce,      ///< a short pulse just after an edge of MA
  pulse,       ///< a short pulse within the frame
  idle_pulse,  ///< a short pulse after the frame
  cycle,       ///< one whole cycle
  cycles,      ///< whole cycles
  span,        ///< from a point in the frame to a point in a later cycle
  permanent,   ///< begins with a cycle and does not end
  frame,       ///< to the end of the frame
};

/// The text of docs/faults.md.
constexpr std::string_view text_of(FaultExtent extent) {
  constexpr std::array<std::string_view, 11> texts{"a bit",
                                                   "several bits",
                                                   "a clock",
                                                   "2 % to 12 % of a period",
                                                   "2 % to 12 % of a period",
                                                   "2 % to 12 % of a period",
                                                   "a cycle",
                                                   "1 to 3 whole cycles",
                                                   "1 to 3 cycles, to any point",
                                                   "permanent",
                                                   "to the end of the frame"};
  return texts[static_cast<std::size_t>(extent)];
}

/// One kind of fault. Texts are for docs/faults.md.
struct FaultEntry {
  FaultKind kind{};
  /// The name that users see: the enumerator's name.
  std::string_view name;
  std::string_view effect;
  FaultExtent extent{};
  /// The transmission error of IEC 61784-3; none if the encoder itself causes or reports the fault.
  std::optional<TransmissionError> error{};
};

/// All kinds, in the order of the enumerators.
inline constexpr std::array<FaultEntry, fault_kind_count> fault_list = [] {
  using F = FaultKind;
  using X = FaultExtent;
  using E = TransmissionError;
  return std::array<FaultEntry, fault_kind_count>{{
      {F::flip, "flip", "one bit of data or CRC is inverted", X::bit, E::corruption},
      {F::burst, "burst", "bits in a row, the first and the last one wrong", X::bits,
       E::corruption},
      {F::glitch_ma, "glitch_ma", "a pulse on MA within the frame", X::pulse, E::corruption},
      {F::glitch_ma_idle, "glitch_ma_idle", "a pulse on MA after the frame", X::idle_pulse,
       E::corruption},
      {F::glitch_slo, "glitch_slo", "a pulse on SLO within the frame", X::pulse, E::corruption},
      {F::glitch_slo_idle, "glitch_slo_idle", "a pulse on SLO after the frame", X::idle_pulse,
       E::corruption},
      {F::lost_clock, "lost_clock", "the encoder misses a clock of MA", X::clock, E::corruption},
      {F::double_clock, "double_clock", "an edge of MA bounces at the encoder", X::bounce,
       E::corruption},
      {F::extra_clock, "extra_clock", "a pulse on MA that only the encoder sees", X::pulse,
       E::corruption},
      {F::ma_low, "ma_low", "MA is stuck at 0", X::span, E::loss},
      {F::ma_high, "ma_high", "MA is stuck at 1", X::span, E::loss},
      {F::slo_low, "slo_low", "SLO is stuck at 0", X::span, E::corruption},
      {F::slo_high, "slo_high", "SLO is stuck at 1", X::span, E::corruption},
      {F::late_start, "late_start", "START is 1 to 8 clocks later than the type's limit", X::cycle,
       E::corruption},
      {F::no_answer, "no_answer", "the encoder ignores the request", X::cycle, E::loss},
      {F::cut, "cut", "the cable is cut: both ends read 1", X::span, E::loss},
      {F::swap_ma, "swap_ma", "MA's wires are swapped: the encoder sees MA inverted", X::cycles,
       E::corruption},
      {F::swap_slo, "swap_slo", "SLO's wires are swapped: the master sees SLO inverted", X::cycles,
       E::corruption},
      {F::exchange, "exchange", "the pairs of MA and SLO are exchanged: both inputs read 1",
       X::cycles, E::loss},
      {F::delay_step, "delay_step", "SLO is 0.25 to 1.25 periods later", X::span, E::corruption},
      {F::nE, "nE", "the encoder reports an error", X::cycle},
      {F::nW, "nW", "the encoder reports a warning", X::cycle},
      {F::brown_out, "brown_out", "the encoder loses its supply and restarts", X::span, E::loss},
      {F::frozen, "frozen", "the encoder repeats its position", X::cycles},
      {F::repeat, "repeat", "the previous frame again", X::cycle, E::repetition},
      {F::reorder, "reorder", "the frame of 2 to 8 cycles ago", X::cycle, E::sequence},
      {F::loss, "loss", "1 to 8 frames before this one are lost", X::permanent, E::loss},
      {F::delay, "delay", "the next request comes 1 to 3 cycles late", X::cycle, E::delay},
      {F::insert, "insert", "a frame of another source", X::cycle, E::insertion},
      {F::masquerade, "masquerade", "noise in place of the last word", X::cycle, E::masquerade},
      {F::other_encoder, "other_encoder", "frames of another encoder", X::cycles, E::addressing},
      {F::lc_restart, "lc_restart", "the sign of life starts again", X::permanent, E::sequence},
      {F::lc_frozen, "lc_frozen", "the sign of life does not change", X::cycles, E::repetition},
      {F::flips, "flips", "each bit is wrong with the same probability", X::bits, E::corruption},
      {F::lost_bit, "lost_bit", "a bit is skipped: the next ones are read a clock early", X::frame,
       E::corruption},
      {F::doubled_bit, "doubled_bit", "a bit is read twice: the next ones are a clock late",
       X::frame, E::corruption},
      {F::inserted_low, "inserted_low", "a 0 is read before a bit", X::frame, E::corruption},
      {F::inserted_high, "inserted_high", "a 1 is read before a bit", X::frame, E::corruption},
      {F::gap_low, "gap_low", "bits in a row read 0", X::bits, E::corruption},
      {F::gap_high, "gap_high", "bits in a row read 1", X::bits, E::corruption},
      {F::lost_start, "lost_start", "START reads 0: the next 1 is taken for START", X::frame,
       E::corruption},
      {F::false_start, "false_start", "a bit of ACK reads 1 and is taken for START", X::frame,
       E::corruption},
      {F::cds_high, "cds_high", "CDS reads 1", X::bit, E::corruption},
      {F::stop_high, "stop_high", "STOP reads 1", X::bit, E::corruption},
      {F::ma_pause, "ma_pause", "MA pauses, high, after a clock", X::clock, E::delay},
      {F::short_frame, "short_frame", "a short frame of control communication: MA stops after STOP",
       X::cycle, E::loss},
      {F::reduced_frame, "reduced_frame", "a reduced frame: MA stops after ACK", X::cycle, E::loss},
      {F::late_turns, "late_turns", "the turns change 1/64 of a turn after the zero", X::cycles},
  }};
}();

constexpr const FaultEntry& entry_of(FaultKind kind) {
  return fault_list[static_cast<std::size_t>(kind)];
}

static_assert([] {
  for (std::size_t k = 0; k < fault_kind_count; ++k) {
    if (static_cast<std::size_t>(fault_list[k].kind) != k) return false;
  }
  return true;
}());

/// Returns the name that users see.
constexpr std::string_view name_of(FaultKind kind) { return entry_of(kind).name; }

/// Returns the kind of that name, or nothing.
constexpr std::optional<FaultKind> find_fault(std::string_view name) {
  for (const FaultEntry& entry : fault_list) {
    if (entry.name == name) return entry.kind;
  }
  return std::nullopt;
}

/// Returns whether the line model can inject the kind.
constexpr bool is_simulated(FaultKind kind) {
  return static_cast<std::size_t>(kind) < simulated_fault_count;
}

/// Returns whether Line can inject the kind.
constexpr bool is_injectable(FaultKind kind) {
  return is_simulated(kind) || static_cast<std::size_t>(kind) >= line_only_fault_first;
}

/// A set of kinds: bit k is the kind of that number.
using FaultSet = std::uint64_t;
static_assert(fault_kind_count <= 64);

template <class... Kinds>
constexpr FaultSet set_of(Kinds... kinds) {
  return ((FaultSet{1} << static_cast<unsigned>(kinds)) | ...);
}

/// Returns the names, separated by `;`.
inline std::string text_of(FaultSet faults) {
  std::string text;
  for (const FaultEntry& entry : fault_list) {
    if ((faults & set_of(entry.kind)) == 0) continue;
    if (!text.empty()) text += ';';
    text += entry.name;
  }
  return text;
}

/// The unit of a place in a cycle, counted from 0.
enum class PlaceUnit : std::uint8_t {
  bit,    ///< bits of data and CRC in the order on the line, as the master receives them
  clock,  ///< periods of MA at the master; the first one begins with the request
};

/// A point in a cycle, in thousandths of a bit or a clock from its beginning.
struct FaultPlace {
  PlaceUnit unit{};
  std::uint64_t thousandths = 0;

  constexpr std::uint64_t whole() const { return thousandths / 1000U; }
  bool operator==(const FaultPlace&) const = default;
};

/// The place at which a fault began.
struct InjectedFault {
  FaultKind kind{};
  FaultPlace place{};

  bool operator==(const InjectedFault&) const = default;
};

/// Returns false for kinds that affect whole cycles and so have no place in a cycle.
constexpr bool has_place(FaultKind kind) {
  const FaultExtent extent = entry_of(kind).extent;
  return extent != FaultExtent::cycle && extent != FaultExtent::cycles &&
         extent != FaultExtent::permanent;
}

/// A kind of fault, and the cycles in which the line model injects it.
struct FaultRule {
  FaultKind kind{};
  /// Share of cycles, in parts of 2^32.
  std::uint64_t share = 0;
  /// The only cycle, counted from 0; overrides the share.
  std::optional<std::uint64_t> cycle{};
  /// The place in the cycle, one of places_of(); if not given, it is drawn.
  std::optional<FaultPlace> place{};
};

}  // namespace biss::sim
