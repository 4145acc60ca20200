// Renishaw: RESOLUTE and FORTiS with BiSS C (unidirectional), and with BiSS Safety.
#pragma once

#include <array>
#include <string_view>

#include "biss/catalogue/entry.hpp"
#include "biss/timing/renishaw.hpp"

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

// The section "Position" lists the widths 18, 26, 32 and 36 bits.
inline constexpr std::string_view renishaw_rotary =
    "the data sheet does not state which of 18, 26, 32 and 36 bits are rotary: inferred";
inline constexpr std::string_view renishaw_linear =
    "the data sheet does not state which of 18, 26, 32 and 36 bits are linear: inferred";

inline constexpr CatalogueEntry renishaw{.vendor = "Renishaw",
                                         .timing = renishaw_timing,
                                         .source = renishaw_bissc,
                                         .uncertain = {renishaw_release}};

constexpr CatalogueEntry resolute(std::string_view name, std::string_view product,
                                  std::string_view format, std::string_view resolution,
                                  std::string_view doubt, std::string_view another_doubt = {}) {
  CatalogueEntry entry = renishaw.type(name, format, resolution, product);
  entry.uncertain[0] = doubt;
  if (!another_doubt.empty()) entry.uncertain[1] = another_doubt;
  return entry.with_doubt(renishaw_release);
}

constexpr CatalogueEntry renishaw_double(std::string_view name, std::string_view product,
                                         std::string_view format, std::string_view resolution,
                                         std::string_view remark) {
  CatalogueEntry entry = renishaw.type(name, format, resolution, product);
  entry.remark = remark;
  entry.source = renishaw_safety;
  entry.uncertain = {renishaw_counter, renishaw_release};
  return entry;
}

}  // namespace catalogue_detail

/// The size of one count is from the data sheet if the data sheet prints it. A size marked
/// "calculated" follows from the number of bits.
// Made by a function, so that GCC 12 puts the table into read-only memory.
inline constexpr auto renishaw_encoders = [] {
  using namespace catalogue_detail;
  return std::array{
      resolute("resolute-18", "RESOLUTE rotary, 18 bit", "pos18,nE,nW,crc6;cds0",
               "2^18 a turn, 4.94 arcsec (calculated)", renishaw_rotary),
      resolute("resolute-26", "RESOLUTE rotary, 26 bit", "pos26,nE,nW,crc6;cds0",
               "2^26 a turn, 0.0193 arcsec (calculated)", renishaw_rotary),
      resolute("resolute-32", "RESOLUTE rotary, 32 bit", "pos32,nE,nW,crc6;cds0",
               "2^32 a turn, 0.000302 arcsec (calculated)", renishaw_rotary),
      resolute("resolute-linear-26", "RESOLUTE linear, 26 bit", "pos26,nE,nW,crc6;cds0",
               "50 nm, range 3.36 m (calculated)", renishaw_linear,
               "50 nm with 26 bits is stated for FORTiS only: inferred"),
      resolute("resolute-linear-32", "RESOLUTE linear, 32 bit", "pos32,nE,nW,crc6;cds0", {},
               renishaw_linear,
               "the size of a count is not stated; 10 nm with 32 bits is stated for FORTiS only"),
      resolute("resolute-linear-36", "RESOLUTE linear, 36 bit", "pos36,nE,nW,crc6;cds0",
               "1 nm, range 68.7 m (calculated)", renishaw_linear,
               "1 nm with 36 bits is stated for RESOLUTE FS only: inferred"),
      renishaw
          .type("fortis-36", "pos36,nE,nW,crc6;cds0",
                "1 nm (range 68.7 m, calculated) or 10 nm (687 m, calculated)",
                "FORTiS linear, 36 bit")
          .with_remark("the standard word of FORTiS")
          .with_doubt(
              "1 nm or 10 nm is not stated here but for FORTiS FS: see the type of your encoder"),
      renishaw
          .type("fortis-26", "pos26,nE,nW,crc6;cds0", "50 nm, range 3.36 m (calculated)",
                "FORTiS linear, 26 bit")
          .with_remark("on special request"),
      renishaw
          .type("fortis-32", "pos32,nE,nW,crc6;cds0", "10 nm, range 42.9 m (calculated)",
                "FORTiS linear, 32 bit")
          .with_remark("on special request"),
      renishaw_double("fs-32-32", "RESOLUTE FS rotary (LMM)",
                      "pos32,nE,nW,crc6+pos32,nE,nW,lc6,crc16;cds0", "2^32 a turn, 0.0003 arcsec",
                      "BiSS Safety: control word, then safety word of the same value"),
      renishaw_double("fs-28-24", "RESOLUTE FS linear, 50 nm (RSM)",
                      "pos28,nE,nW,crc6+pos24,nE,nW,lc6,crc16;cds0",
                      "50 nm and 800 nm, range 13.4 m (calculated)",
                      "BiSS Safety: the safety word is the control word's upper 24 bits"),
      renishaw_double("fs-36-28", "RESOLUTE FS linear, 1 nm (RSH)",
                      "pos36,nE,nW,crc6+pos28,nE,nW,lc6,crc16;cds0",
                      "1 nm and 256 nm, range 68.7 m (calculated)",
                      "BiSS Safety: the safety word is the control word's upper 28 bits"),
      renishaw_double("fortis-fs-36-28", "FORTiS FS linear, 10 nm or 1 nm (RSH)",
                      "pos36,nE,nW,crc6+pos28,nE,nW,lc6,crc16;cds0",
                      "10 nm and 2560 nm, or 1 nm and 256 nm",
                      "BiSS Safety: the safety word is the control word's upper 28 bits")
          .with_doubt("10 nm or 1 nm: see the type of your encoder"),
  };
}();

}  // namespace biss
