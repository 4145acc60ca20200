// Renishaw: RESOLUTE and FORTiS with BiSS C (unidirectional), and with BiSS Safety.
#pragma once

#include <array>

#include "biss/catalogue/entry.hpp"

namespace biss {

namespace catalogue_detail {

inline constexpr std::string_view renishaw_bissc =
    "Renishaw data sheet: BiSS C-mode (unidirectional) for RESOLUTE and FORTiS";
inline constexpr std::string_view renishaw_safety =
    "Renishaw data sheet: BiSS Safety for RESOLUTE and FORTiS";
inline constexpr std::string_view renishaw_counter =
    "the sign-of-life counter's range is not clear: 63 or 64 values";
inline constexpr std::string_view renishaw_release =
    "when SLO returns to 1 is not stated for frames longer than 31.25 us: 1.5 periods assumed";

// Both data sheets, "Timing information" and "Timeout".
inline constexpr DeviceTiming renishaw_timing{
    .clock_min = kilohertz(250),
    .clock_max = megahertz(10),
    .start_min = nanoseconds(3'225),
    .ack_max = microseconds(16),
    .timeout = {TimeoutRule::cycle, nanoseconds(31'250)},
    .internal_delay_max = picoseconds(42'500),
    .cycle_min = nanoseconds(31'250),
    .sampling_min = nanoseconds(3'225),
    .sampling_typical = nanoseconds(3'250),
    .sampling_max = nanoseconds(3'275),
    .clock_constant = true,
};

constexpr CatalogueEntry renishaw_plain(std::string_view name, std::string_view product,
                                        std::string_view format, std::string_view resolution,
                                        std::string_view remark = {}) {
  return {.name = name,
          .vendor = "Renishaw",
          .product = product,
          .format = format,
          .timing = renishaw_timing,
          .resolution = resolution,
          .remark = remark,
          .source = renishaw_bissc,
          .uncertain = {renishaw_release}};
}

constexpr CatalogueEntry renishaw_double(std::string_view name, std::string_view product,
                                         std::string_view format, std::string_view resolution,
                                         std::string_view remark) {
  CatalogueEntry entry = renishaw_plain(name, product, format, resolution, remark);
  entry.source = renishaw_safety;
  entry.uncertain = {renishaw_counter, renishaw_release};
  return entry;
}

}  // namespace catalogue_detail

inline constexpr std::array renishaw_encoders{
    catalogue_detail::renishaw_plain("resolute-18", "RESOLUTE rotary, 18 bit",
                                     "pos18,nE,nW,crc6;cds0", "2^18 a turn, 4.94 arcsec"),
    catalogue_detail::renishaw_plain("resolute-26", "RESOLUTE rotary, 26 bit",
                                     "pos26,nE,nW,crc6;cds0", "2^26 a turn, 0.0193 arcsec"),
    catalogue_detail::renishaw_plain("resolute-32", "RESOLUTE rotary, 32 bit",
                                     "pos32,nE,nW,crc6;cds0", "2^32 a turn, 0.000302 arcsec"),
    catalogue_detail::renishaw_plain("fortis-36", "FORTiS linear, 36 bit", "pos36,nE,nW,crc6;cds0",
                                     "1 nm (range 68.7 m) or 10 nm (687 m)",
                                     "the standard word of FORTiS"),
    catalogue_detail::renishaw_plain("fortis-26", "FORTiS linear, 26 bit", "pos26,nE,nW,crc6;cds0",
                                     "50 nm, range 3.36 m", "on special request"),
    catalogue_detail::renishaw_plain("fortis-32", "FORTiS linear, 32 bit", "pos32,nE,nW,crc6;cds0",
                                     "10 nm, range 42.9 m", "on special request"),
    catalogue_detail::renishaw_double(
        "fs-32-32", "RESOLUTE FS rotary (LMM)", "pos32,nE,nW,crc6+pos32,nE,nW,lc6,crc16;cds0",
        "2^32 a turn, 0.000302 arcsec",
        "BiSS Safety: control word, then safety word of the same value"),
    catalogue_detail::renishaw_double(
        "fs-28-24", "RESOLUTE FS linear, 50 nm (RSM)",
        "pos28,nE,nW,crc6+pos24,nE,nW,lc6,crc16;cds0", "50 nm and 800 nm, range 13.4 m",
        "BiSS Safety: the safety word is the control word's upper 24 bits"),
    catalogue_detail::renishaw_double(
        "fs-36-28", "RESOLUTE FS linear, 1 nm (RSH)", "pos36,nE,nW,crc6+pos28,nE,nW,lc6,crc16;cds0",
        "1 nm and 256 nm, range 68.7 m",
        "BiSS Safety: the safety word is the control word's upper 28 bits"),
    catalogue_detail::renishaw_double(
        "fortis-fs-36-28", "FORTiS FS linear, 10 nm or 1 nm (RSH)",
        "pos36,nE,nW,crc6+pos28,nE,nW,lc6,crc16;cds0", "10 nm and 2560 nm, or 1 nm and 256 nm",
        "BiSS Safety: the safety word is the control word's upper 28 bits"),
};

}  // namespace biss
