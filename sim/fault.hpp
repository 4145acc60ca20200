// What can go wrong on the line, by name. docs/faults.md describes each.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace biss::sim {

enum class FaultKind : std::uint8_t {
  flip,             ///< one bit of data or CRC
  burst,            ///< 2 to 16 bits in a row, the first and the last one wrong
  glitch_ma,        ///< a short pulse on MA within the frame
  glitch_ma_idle,   ///< … behind it
  glitch_slo,       ///< a short pulse on SLO within the frame
  glitch_slo_idle,  ///< … behind it
  lost_clock,       ///< the encoder misses a clock of MA
  double_clock,     ///< the encoder sees an edge of MA bounce
  extra_clock,      ///< the encoder sees a pulse on MA between two edges
  ma_low,           ///< MA stuck from a point on, for some cycles
  ma_high,
  slo_low,  ///< SLO stuck from a point on, for some cycles
  slo_high,
  late_start,  ///< the encoder is busy for longer than it may
  no_answer,   ///< the encoder does not take notice of the request
  cut,         ///< the cable is cut at a point and connected again some cycles later
  swap_ma,     ///< the two wires of MA have changed places, for some cycles
  swap_slo,    ///< those of SLO
  exchange,    ///< MA's and SLO's pairs have changed places, for some cycles
  delay_step,  ///< SLO is later from a point on, for some cycles
  nE,          ///< the encoder reports an error
  nW,          ///< … a warning
  brown_out,   ///< the encoder loses its supply at a point and starts again some cycles later
  frozen,      ///< the encoder repeats its position for some cycles
  // From here on: frames whose checksums are good, all but one, and that are the wrong ones.
  repeat,         ///< the frame before once more
  reorder,        ///< an older one
  loss,           ///< some frames before this one never came
  delay,          ///< the request behind this one comes late
  insert,         ///< a frame of some other source, between those of the encoder
  masquerade,     ///< noise in the place of the last word
  other_encoder,  ///< frames of another encoder for some cycles
  lc_restart,     ///< the sign of life begins anew
  lc_frozen,      ///< it stands still for some cycles
};

inline constexpr std::size_t fault_kind_count = 33;
/// The kinds that damage levels and times, or are the encoder's own word; `repeat` comes next.
inline constexpr std::size_t line_fault_kind_count = 24;

inline constexpr std::array<std::string_view, fault_kind_count> fault_names{"flip",
                                                                            "burst",
                                                                            "glitch_ma",
                                                                            "glitch_ma_idle",
                                                                            "glitch_slo",
                                                                            "glitch_slo_idle",
                                                                            "lost_clock",
                                                                            "double_clock",
                                                                            "extra_clock",
                                                                            "ma_low",
                                                                            "ma_high",
                                                                            "slo_low",
                                                                            "slo_high",
                                                                            "late_start",
                                                                            "no_answer",
                                                                            "cut",
                                                                            "swap_ma",
                                                                            "swap_slo",
                                                                            "exchange",
                                                                            "delay_step",
                                                                            "nE",
                                                                            "nW",
                                                                            "brown_out",
                                                                            "frozen",
                                                                            "repeat",
                                                                            "reorder",
                                                                            "loss",
                                                                            "delay",
                                                                            "insert",
                                                                            "masquerade",
                                                                            "other_encoder",
                                                                            "lc_restart",
                                                                            "lc_frozen"};

constexpr std::string_view name_of(FaultKind kind) {
  return fault_names[static_cast<std::size_t>(kind)];
}

/// Kinds as a set: bit k is the kind of that number.
using FaultSet = std::uint64_t;
static_assert(fault_kind_count <= 64);

constexpr FaultSet set_of(FaultKind kind) { return FaultSet{1} << static_cast<unsigned>(kind); }

/// The names, a `;` between two.
inline std::string text_of(FaultSet faults) {
  std::string text;
  for (std::size_t k = 0; k < fault_kind_count; ++k) {
    if (((faults >> k) & 1U) == 0) continue;
    if (!text.empty()) text += ';';
    text += fault_names[k];
  }
  return text;
}

/// What a place in a cycle is counted in, from 0.
enum class PlaceUnit : std::uint8_t {
  bit,    ///< bits of data and CRC in the order on the line, as the master gets them
  clock,  ///< periods of MA at the master; the first one begins with the request
};

/// A point in a cycle, in thousandths of a bit or a clock from its beginning.
struct FaultPlace {
  PlaceUnit unit{};
  std::uint64_t thousandths = 0;

  constexpr std::uint64_t whole() const { return thousandths / 1000U; }
  bool operator==(const FaultPlace&) const = default;
};

/// Where a kind began.
struct FaultStrike {
  FaultKind kind{};
  FaultPlace place{};

  bool operator==(const FaultStrike&) const = default;
};

/// False for kinds that last for whole cycles: they begin nowhere in it.
constexpr bool has_place(FaultKind kind) {
  switch (kind) {
    case FaultKind::late_start:
    case FaultKind::no_answer:
    case FaultKind::swap_ma:
    case FaultKind::swap_slo:
    case FaultKind::exchange:
    case FaultKind::nE:
    case FaultKind::nW:
    case FaultKind::frozen:
    case FaultKind::repeat:
    case FaultKind::reorder:
    case FaultKind::loss:
    case FaultKind::delay:
    case FaultKind::insert:
    case FaultKind::masquerade:
    case FaultKind::other_encoder:
    case FaultKind::lc_restart:
    case FaultKind::lc_frozen:
      return false;
    default:
      return true;
  }
}

/// One kind of fault, and which cycles it strikes.
struct FaultRule {
  FaultKind kind{};
  /// Share of cycles in which it strikes, in parts of 2^32.
  std::uint64_t share = 0;
  /// The one cycle in which it strikes, counted from 0; then the share does not matter.
  std::optional<std::uint64_t> cycle{};
  /// Where in the cycle, one of places_of(); else drawn.
  std::optional<FaultPlace> place{};
};

}  // namespace biss::sim
