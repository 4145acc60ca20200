// Safety configurations by name: the rows of Renishaw's data sheet, and the types of the Safety
// Concept.
#pragma once

#include <array>
#include <string_view>

#include "biss/frame/format_text.hpp"
#include "biss/safety/setup.hpp"
#include "biss/timing/device_timing.hpp"
#include "biss/timing/renishaw.hpp"

namespace biss {

/// A frame format, the setup of its monitor, and how the encoder behaves in time. The setup's
/// bounds are in clocks of the encoder's highest rate; with_timing() computes the bounds for
/// another rate. All text is static. For any other encoder, pass a FrameFormat and a SafetySetup.
struct SafetyConfiguration {
  /// The name that a user types, in lower case.
  std::string_view name{};
  /// Text of the frame format; it parses (proven at compile time).
  std::string_view format{};
  SafetySetup setup{};
  /// The timing of the encoder that the row describes. The types of the Safety Concept are not
  /// encoders; they have the widest limits that BiSS C allows.
  DeviceTiming timing{};
  /// The size of one count of CPW and SPW; empty if unknown.
  std::string_view resolution{};
  std::string_view source{};

  /// The format as data.
  constexpr FrameFormat frame_format() const { return parse_format(format).value(); }
};

namespace safety_detail {

inline constexpr std::string_view renishaw =
    "Renishaw data sheet: BiSS Safety for RESOLUTE and FORTiS";
inline constexpr std::string_view concept_a5 = "BiSS Safety Concept A5, table 1";

// All bits that both words have are compared: the data sheet names no comparison width, and the SPW
// is the upper part of the CPW.
constexpr SafetyConfiguration renishaw_row(std::string_view name, std::string_view format,
                                           std::string_view resolution) {
  return {.name = name,
          .format = format,
          .setup = with_timing({}, renishaw_timing, period_of(renishaw_timing.clock_max),
                               renishaw_line_delay_max),
          .timing = renishaw_timing,
          .resolution = resolution,
          .source = renishaw};
}

// On a binary symmetric channel with a bit error rate of 1e-2, with ACC_MIN bits compared, the
// types have up to 2.24e-9 undetected errors an hour: less than 1 % of SIL 2, more than 1 % of SIL
// 3, the level for which the Safety Concept calls the types suitable. Its residual error model is
// not public.
inline constexpr std::uint64_t type_residual_max_e15 = 2'500'000;

// `cycle` is the shortest safety cycle of the table, `compare_bits` its ACC_MIN.
constexpr SafetyConfiguration type(std::string_view name, std::string_view format,
                                   std::uint8_t compare_bits, Picoseconds cycle) {
  SafetySetup setup = at_cycle({}, cycle);
  setup.comparison.compare_bits = compare_bits;
  setup.residual_max_e15 = type_residual_max_e15;
  return {.name = name,
          .format = format,
          .setup = setup,
          .timing = {},
          .resolution = {},
          .source = concept_a5};
}

inline constexpr Picoseconds one_cycle = nanoseconds(31'250);
inline constexpr Picoseconds two_cycles = nanoseconds(62'500);

}  // namespace safety_detail

/// Renishaw's five rows, then the nine types of the Safety Concept. For the types RSH and LMM the
/// Safety Concept has 62.5 us, for frames of the same size Renishaw has 31.25 us; each row follows
/// its source.
// Made by a function, so that GCC 12 puts the table into read-only memory.
inline constexpr auto safety_configurations = [] {
  return std::array{
      safety_detail::renishaw_row("fs-32-32", "pos32,nE,nW,crc6+pos32,nE,nW,lc6,crc16;cds0",
                                  "0.0003 arcsec both; RESOLUTE rotary, LMM"),
      safety_detail::renishaw_row("fs-28-24", "pos28,nE,nW,crc6+pos24,nE,nW,lc6,crc16;cds0",
                                  "50 nm and 800 nm; RESOLUTE linear, RSM"),
      safety_detail::renishaw_row("fs-36-28", "pos36,nE,nW,crc6+pos28,nE,nW,lc6,crc16;cds0",
                                  "1 nm and 256 nm; RESOLUTE linear, RSH"),
      safety_detail::renishaw_row("fortis-fs-36-28-10nm",
                                  "pos36,nE,nW,crc6+pos28,nE,nW,lc6,crc16;cds0",
                                  "10 nm and 2560 nm; FORTiS linear, RSH"),
      safety_detail::renishaw_row("fortis-fs-36-28-1nm",
                                  "pos36,nE,nW,crc6+pos28,nE,nW,lc6,crc16;cds0",
                                  "1 nm and 256 nm; FORTiS linear, RSH"),
      safety_detail::type("rxm", "st16,nE,nW,crc6+st12,nE,nW,lc6,crc16", 9,
                          safety_detail::one_cycle),
      safety_detail::type("rxh", "st24,nE,nW,crc6+st16,nE,nW,lc6,crc16", 13,
                          safety_detail::one_cycle),
      safety_detail::type("rsm", "mt12,st16,nE,nW,crc6+mt12,st12,nE,nW,lc6,crc16", 9,
                          safety_detail::one_cycle),
      safety_detail::type("rsh", "mt12,st24,nE,nW,crc6+mt12,st16,nE,nW,lc6,crc16", 13,
                          safety_detail::two_cycles),
      safety_detail::type("rlm", "mt24,st16,nE,nW,crc6+mt24,st12,nE,nW,lc6,crc16", 9,
                          safety_detail::two_cycles),
      safety_detail::type("rlh", "mt24,st24,nE,nW,crc6+mt24,st16,nE,nW,lc6,crc16", 13,
                          safety_detail::two_cycles),
      safety_detail::type("rum", "mt12,st16,nE,nW,crc6+st12,nE,nW,lc6,crc16", 9,
                          safety_detail::one_cycle),
      safety_detail::type("ruh", "mt12,st24,nE,nW,crc6+st16,nE,nW,lc6,crc16", 13,
                          safety_detail::two_cycles),
      safety_detail::type("lmm", "mt16,st16,nE,nW,crc6+mt16,st16,nE,nW,lc6,crc16", 11,
                          safety_detail::two_cycles),
  };
}();

/// The configuration of that name, null when there is none. Names are compared exactly. The pointer
/// keeps all configurations in the program; firmware uses safety_configuration().
constexpr const SafetyConfiguration* find_safety_configuration(std::string_view name) {
  for (const SafetyConfiguration& each : safety_configurations) {
    if (each.name == name) return &each;
  }
  return nullptr;
}

namespace safety_detail {

// Never defined: the compiler prints this name if the name of a configuration is wrong.
void no_safety_configuration_of_this_name();

}  // namespace safety_detail

/// The configuration of that name at compile time. A name that does not exist stops the build.
consteval SafetyConfiguration safety_configuration(std::string_view name) {
  // Not by find_safety_configuration(): g++ -fsanitize=undefined refuses to compare its result with
  // null.
  for (const SafetyConfiguration& each : safety_configurations) {
    if (each.name == name) return each;
  }
  safety_detail::no_safety_configuration_of_this_name();
  return {};
}

namespace safety_detail {

constexpr bool can_be_monitored() {
  for (const SafetyConfiguration& each : safety_configurations) {
    const auto format = parse_format(each.format);
    if (!format.ok() || check_safety(*format, each.setup)) return false;
  }
  return true;
}
static_assert(can_be_monitored());

}  // namespace safety_detail

}  // namespace biss
