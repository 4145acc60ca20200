// Encoders of other makers, from their own documents. Baumer, Balluff and the configurable ones do
// not state their widths and are therefore not listed.
#pragma once

#include <array>

#include "biss/catalogue/entry.hpp"

namespace biss {

namespace catalogue_detail {

inline constexpr std::array<std::string_view, 5> lika_doubts{doubt::clock, doubt::timeout,
                                                             doubt::start_unstated};

inline constexpr CatalogueEntry lika_amx{
    .vendor = "Lika",
    .remark = "both flags are always 1: no error is ever shown; not for several slaves on a line",
    .source = "Lika AMx36 manual E1.1, pages 21 to 23",
    .uncertain = lika_doubts};

inline constexpr CatalogueEntry lika_smra{
    .vendor = "Lika",
    .remark = "the width follows from the resolution code and the poles of the ring",
    .source = "Lika SMRA manual E1.2, pages 23 to 25",
    .uncertain = lika_doubts};

inline constexpr CatalogueEntry waycon{
    .vendor = "WayCon",
    .product = "MXS2-BISS linear magnetic",
    .resolution = "50, 10, 5, 2 or 1 um by variant",
    .remark = "the second flag is reserved for the maker",
    .source = "WayCon MXS2 manual, pages 10 to 18",
    .uncertain = {"the width is deduced from the SSI table: check which one yours has",
                  doubt::clock, doubt::timeout, doubt::start_unstated}};

inline constexpr CatalogueEntry kuebler{
    .vendor = "Kuebler",
    .product = "Sendix S36 motor feedback",
    .timing = {.clock_min = kilohertz(50)},
    .resolution = "2^12 turns",
    .remark = "early devices have no EDS",
    .source = "Kuebler Sendix S36 manual; KEB F5 and F6 encoder manuals",
    .uncertain = {doubt::flags, "the CRC polynomial is known from KEB's notes",
                  doubt::start_and_inversion, doubt::timeout}};

}  // namespace catalogue_detail

inline constexpr auto maker_encoders = [] {
  using namespace catalogue_detail;
  return std::array{
      CatalogueEntry{
          .name = "lenz-b3",
          .vendor = "LENZ Encoders",
          .product = "IRS/SIB B3 rotary inductive",
          .format = "pos24,nE,nW,crc6",
          .timing = {.clock_max = megahertz(5),
                     .ack_clocks = 4,
                     .timeout = {TimeoutRule::fixed, nanoseconds(13'200)}},
          .resolution = "left aligned; useful bits by model, 17 for example",
          .remark = "timeout 12.6-13.2 us, with register access 13.5-14.5 us; 12.5 MHz on request",
          .source = "LENZ BISS C B3 description Rev 1.1"},
      lika_amx.type("lika-amm3616", "mt12,st16,nE,nW,crc6", "2^16 a turn, 2^12 turns",
                    "AMM3616/4096SC rotary multiturn"),
      lika_amx.type("lika-amm3619", "mt12,st19,nE,nW,crc6", "2^19 a turn, 2^12 turns",
                    "AMM3619/4096SC rotary multiturn"),
      lika_smra.type("lika-smra-12", "pos12,nE,nW,crc6", {}, "SMRA ring encoder, 12 bit"),
      lika_smra.type("lika-smra-13", "pos13,nE,nW,crc6", {}, "SMRA ring encoder, 13 bit"),
      lika_smra.type("lika-smra-14", "pos14,nE,nW,crc6", {}, "SMRA ring encoder, 14 bit"),
      CatalogueEntry{.name = "lika-sma1",
                     .vendor = "Lika",
                     .product = "SMA1 and MTA1 linear magnetic",
                     .format = "pos24,nE,nW,crc6",
                     .remark = "profile identifier 0x2814 (BP1, variant 0-24)",
                     .source = "Lika SMA1 manual E2.9, pages 21 and 35",
                     .uncertain = lika_doubts}
          .with_doubt("24 + 2 + 6 bits are stated in the manual's chapter on BiSS B"),
      waycon.type("waycon-mxs2-18", "pos18,nE,pad1,crc6"),
      // 18 bits are stated for 50 um; the SSI table, with the error bit, has 19, 21, 22, 23 and 24.
      waycon.type("waycon-mxs2-19", "pos19,nE,pad1,crc6")
          .with_doubt("no variant of 19 bits follows from that table"),
      waycon.type("waycon-mxs2-20", "pos20,nE,pad1,crc6"),
      waycon.type("waycon-mxs2-21", "pos21,nE,pad1,crc6"),
      waycon.type("waycon-mxs2-22", "pos22,nE,pad1,crc6"),
      waycon.type("waycon-mxs2-23", "pos23,nE,pad1,crc6"),
      CatalogueEntry{
          .name = "siko-msa213c",
          .vendor = "SIKO",
          .product = "MSA213C-S linear magnetic",
          .format = "pos25,nE,nW,crc6",
          .timing = {.timeout = {TimeoutRule::adaptive, {}}, .cycle_min = microseconds(50)},
          .remark = "the position is signed: a sign and 24 bits; start-up below 250 ms",
          .source = "SIKO MSA213C manual 111/22, page 17",
          .uncertain = {doubt::sampling_clock, doubt::start_and_inversion,
                        "cycle of 50 us as stated for 10 MHz"}},
      CatalogueEntry{
          .name = "faulhaber-aemt",
          .vendor = "Faulhaber",
          .product = "AEMT-12/16 L rotary multiturn",
          .format = "mt16,st12,nE,nW,crc6",
          .timing = {.clock_max = megahertz(2), .timeout = {TimeoutRule::fixed, microseconds(20)}},
          .resolution = "2^12 a turn, 2^16 turns",
          .remark = "nE is 0 on a low battery too",
          .source = "Faulhaber AEMT manual 7000.05070, page 11",
          .uncertain = {doubt::polynomial, doubt::start_and_inversion,
                        "the manual draws DATA and CLK inverted: check the polarity"}},
      kuebler.type("kuebler-s36-12", "mt12,st12,nE,nW,crc6"),
      kuebler.type("kuebler-s36-13", "mt12,st13,nE,nW,crc6"),
      kuebler.type("kuebler-s36-14", "mt12,st14,nE,nW,crc6"),
      kuebler.type("kuebler-s36-15", "mt12,st15,nE,nW,crc6"),
      kuebler.type("kuebler-s36-16", "mt12,st16,nE,nW,crc6"),
      kuebler.type("kuebler-s36-17", "mt12,st17,nE,nW,crc6"),
      kuebler.type("kuebler-s36-18", "mt12,st18,nE,nW,crc6"),
      kuebler.type("kuebler-s36-19", "mt12,st19,nE,nW,crc6"),
      kuebler.type("kuebler-s36-20", "mt12,st20,nE,nW,crc6"),
      kuebler.type("kuebler-s36-21", "mt12,st21,nE,nW,crc6"),
      kuebler.type("kuebler-s36-22", "mt12,st22,nE,nW,crc6"),
      kuebler.type("kuebler-s36-23", "mt12,st23,nE,nW,crc6"),
      CatalogueEntry{.name = "xscene-24",
                     .vendor = "Xscene Motion",
                     .product = "24 bit multiturn",
                     .format = "mt12,st24,nE,nW,crc6",
                     .resolution = "2^24 a turn, 2^12 turns",
                     .source = "xscenemotion.com product page",
                     .uncertain = {"flags and CRC follow from \"BP3\", the page gives no details",
                                   doubt::clock, doubt::timeout}},
      CatalogueEntry{.name = "festo-sfc-laci",
                     .vendor = "Festo",
                     .product = "SFC-LACI built-in encoder",
                     .format = "mt12,st11,pad2,crc6",
                     .resolution = "2^11 a turn, 2^12 turns",
                     .remark =
                         "two error bits (amplitude, frequency) stand before the CRC: carried, "
                         "not judged",
                     .source = "Festo GDCP-SFC-LACI manual 0812NH, page 3-13",
                     .uncertain = {"the error bits' polarity is not stated",
                                   "an early device (2008): the BiSS version is not stated",
                                   doubt::clock, doubt::timeout, doubt::start_unstated}},
  };
}();

}  // namespace biss
