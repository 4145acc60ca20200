// iC-Haus: encoder chips whose frame is fixed or has a few variants. iC-MU, iC-MU150, iC-PVS and
// iC-TW29 are configurable to any width and are therefore not listed.
#pragma once

#include <array>

#include "biss/catalogue/entry.hpp"

namespace biss {

namespace catalogue_detail {

inline constexpr std::string_view ic_demo = "iC-Haus application note AN22: demo captures";

inline constexpr CatalogueEntry ic_mr{
    .vendor = "iC-Haus",
    .product = "iC-MR sin/cos interpolator",
    .timing = {.timeout = {TimeoutRule::adaptive, {}}},
    .remark =
        "singleturn left aligned with trailing zeros; a 16-bit temperature channel with CRC 0x25 "
        "can follow",
    .source = "iC-Haus iC-MR data sheet A1, pages 34 and 35",
    .uncertain = {doubt::clock, doubt::sampling_clock, doubt::start}};

constexpr CatalogueEntry ic_mr_crc16(std::string_view name, std::string_view format) {
  return ic_mr.type(name, format, {}, "iC-MR sin/cos interpolator, extended CRC")
      .with_remark(
          "singleturn left aligned with trailing zeros; with the life counter enabled lc6 "
          "stands before crc16");
}

inline constexpr CatalogueEntry ic_md{
    .vendor = "iC-Haus",
    .product = "iC-MD quadrature counter",
    .remark = "channel 0 alone; channels 1 and 2 (24 bits, 2 flags, CRC 0x25) can follow",
    .source = "iC-Haus iC-MD data sheet B1, page 25",
    .uncertain = {doubt::clock, doubt::timeout, "the flags are configured: nE and nW assumed",
                  doubt::start_unstated}};

}  // namespace catalogue_detail

inline constexpr auto ic_haus_encoders = [] {
  using namespace catalogue_detail;
  return std::array{
      CatalogueEntry{
          .name = "ic-mhm",
          .vendor = "iC-Haus",
          .product = "iC-MHM magnetic encoder chip, demo board",
          .format = "pos28,nE,nW,crc6",
          .timing = {.timeout = {TimeoutRule::adaptive, nanoseconds(680)}},
          .remark = "profile identifier 0x621E (BP3); multiturn and singleturn together",
          .source = ic_demo,
          .uncertain = {doubt::clock,
                        "timeout measured on one device at 2.27 MHz (1.3 us), not a limit",
                        "how the 28 bits divide into turns is not stated"}},
      CatalogueEntry{.name = "ic-mh",
                     .vendor = "iC-Haus",
                     .product = "iC-MH magnetic encoder chip, demo board",
                     .format = "pos12,nE,nW,crc6",
                     .resolution = "2^12 a turn",
                     .remark = "profile identifier 0x2C0C (BP1)",
                     .source = ic_demo,
                     .uncertain = {doubt::clock, doubt::timeout}},
      ic_mr.type("ic-mr-24", "st24,nE,nW,crc6"),
      ic_mr.type("ic-mr-26", "st26,nE,nW,crc6"),
      ic_mr.type("ic-mr-12-24", "mt12,st24,nE,nW,crc6"),
      ic_mr.type("ic-mr-12-26", "mt12,st26,nE,nW,crc6"),
      ic_mr.type("ic-mr-24-24", "mt24,st24,nE,nW,crc6"),
      ic_mr.type("ic-mr-24-26", "mt24,st26,nE,nW,crc6"),
      ic_mr_crc16("ic-mr-crc16-24", "st24,nE,nW,crc16"),
      ic_mr_crc16("ic-mr-crc16-26", "st26,nE,nW,crc16"),
      ic_mr_crc16("ic-mr-crc16-12-24", "mt12,st24,nE,nW,crc16"),
      ic_mr_crc16("ic-mr-crc16-12-26", "mt12,st26,nE,nW,crc16"),
      ic_mr_crc16("ic-mr-crc16-24-24", "mt24,st24,nE,nW,crc16"),
      ic_mr_crc16("ic-mr-crc16-24-26", "mt24,st26,nE,nW,crc16"),
      ic_md.type("ic-md-16", "pos16,nE,nW,crc6"),
      ic_md.type("ic-md-24", "pos24,nE,nW,crc6"),
      ic_md.type("ic-md-32", "pos32,nE,nW,crc6"),
      ic_md.type("ic-md-48", "pos48,nE,nW,crc6"),
      CatalogueEntry{.name = "ic-lgc",
                     .vendor = "iC-Haus",
                     .product = "iC-LGC optical encoder chip, example word",
                     .format = "mt12,st20,nE,nW,lc6,crc16",
                     .resolution = "2^20 a turn, 2^12 turns",
                     .source = "iC-Haus application note AN21 A1",
                     .uncertain = {"an example word of a note on CRC, not a data sheet",
                                   doubt::clock, doubt::timeout}},
  };
}();

}  // namespace biss
