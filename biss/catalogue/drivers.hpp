// Encoders described by the source of drivers and demonstrations, not by their makers.
#pragma once

#include <array>

#include "biss/catalogue/entry.hpp"

namespace biss {

namespace catalogue_detail {

constexpr CatalogueEntry telescope(std::string_view name, std::string_view vendor,
                                   std::string_view product, std::string_view format,
                                   std::string_view resolution, std::string_view source) {
  return {.name = name,
          .vendor = vendor,
          .product = product,
          .format = format,
          .resolution = resolution,
          .source = source,
          .uncertain = {doubt::driver, doubt::clock, doubt::timeout}};
}

constexpr CatalogueEntry synapticon(std::string_view name, std::string_view vendor,
                                    std::string_view product, std::string_view format,
                                    std::string_view resolution, std::string_view source) {
  CatalogueEntry entry = telescope(name, vendor, product, format, resolution, source);
  entry.uncertain = {doubt::driver, doubt::clock_configured,
                     "the source configures the timeout, its limit is not known: the longest "
                     "legal assumed",
                     doubt::start_unstated};
  return entry;
}

inline constexpr CatalogueEntry aksim{
    .vendor = "RLS",
    .product = "AksIM-2 rotary magnetic",
    .timing = {.clock_max = megahertz(5)},
    .source = "unhuman-io/motorlib aksim2_encoder.h",
    .uncertain = {doubt::driver, "the clock limit is a comment in the source", doubt::timeout}};

}  // namespace catalogue_detail

inline constexpr auto driver_encoders = [] {
  using namespace catalogue_detail;
  return std::array{
      telescope("lika-asc85", "Lika", "ASC85 rotary", "pos25,nE,nW,crc6", "2^25 a turn",
                "OnStepX src/lib/encoder/bissc/Asc85.cpp"),
      synapticon("hengstler-ac36", "Hengstler", "ACURO AC36 1213 rotary multiturn",
                 "mt12,st13,nE,nW,crc6", "2^13 a turn, 2^12 turns",
                 "Synapticon sensor_config_biss_AC36_1213.h; KEB F5 manual"),
      synapticon("as50-18", "not named", "AS50 rotary, 18 bit", "pos18,nE,nW,crc6", "2^18 a turn",
                 "Synapticon sensor_config_biss_AS50_18.h"),
      synapticon("as50-10-18", "not named", "AS50 rotary multiturn, 10 and 18 bit",
                 "mt10,st18,nE,nW,crc6", "2^18 a turn, 2^10 turns",
                 "Synapticon sensor_config_biss_AS50_1018.h"),
      CatalogueEntry{.name = "broadcom-as37",
                     .vendor = "Broadcom",
                     .product = "AS37-H39B-B rotary multiturn",
                     .format = "mt16,st23,E,nW,crc6",
                     .resolution = "2^23 a turn, 2^16 turns",
                     .remark = "the error bit is high-active: 1 means error",
                     .source = "OnStepX src/lib/encoder/bissc/As37h39bb.cpp and Bissc.h",
                     .uncertain = {doubt::driver,
                                   "the clock range is a comment in the source on similar encoders",
                                   doubt::timeout}},
      telescope("jtw-24", "JTW", "telescope encoder, 24 bit", "pos24,nE,nW,crc6", "2^24 a turn",
                "OnStepX src/lib/encoder/bissc/Jtw24.cpp")
          .with_doubt("older versions of the source read 24 bits of turns too, and a high-active "
                      "error bit"),
      telescope("jtw-26", "JTW", "telescope encoder, 26 bit", "pos26,nE,nW,crc6", "2^26 a turn",
                "OnStepX src/lib/encoder/bissc/Jtw26.cpp"),
      aksim.type("aksim2-18", "pos18,nE,nW,crc6", "2^18 a turn"),
      aksim.type("aksim2-19", "pos19,nE,nW,crc6", "2^19 a turn"),
      aksim.type("aksim2-20", "pos20,nE,nW,crc6", "2^20 a turn"),
      CatalogueEntry{.name = "moons-12",
                     .vendor = "MOONS'",
                     .product = "12 bit rotary",
                     .format = "pos12,nE,nW,crc6",
                     .resolution = "2^12 a turn",
                     .source = "unhuman-io/motorlib moons_encoder.h",
                     .uncertain = {doubt::driver, "the clock limit is a comment in the source",
                                   doubt::timeout}},
      CatalogueEntry{.name = "ti-safety-demo",
                     .vendor = "Texas Instruments",
                     .product = "safety word of a demonstration encoder",
                     .format = "mt16,st12,nE,nW,lc6,crc16",
                     .resolution = "2^12 a turn, 2^16 turns",
                     .remark = "a position word with CRC6 comes from a second channel",
                     .source = "TI motor-control-sdk, bissc_safety_sample_output",
                     .uncertain = {doubt::driver, "the encoder's maker is not named",
                                   "the widths are deduced from a printed sample", doubt::timeout}},
  };
}();

}  // namespace biss
