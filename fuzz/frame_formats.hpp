// The formats of the frames that the targets read: every kind of item occurs.
#pragma once

#include <array>
#include <string_view>
#include <vector>

#include "biss/frame/format_text.hpp"

namespace biss::fuzz {

inline constexpr std::array<std::string_view, 12> frame_formats{
    "pos26,nE,nW,crc6;cds0",
    "pos12,nE,nW,crc6",
    "pos36,nE,nW,crc6",
    "mt12,st20,nE,nW,lc6,crc16",
    "pos36,nE,nW,crc6+pos28,nE,nW,lc6,crc16;cds0",
    "mt16,st19:gray,E,W,crc8",
    "pos1,crc3",
    "pos64,crc16",
    "pos55,nE,nW,crc6:0x43:0x15",
    "nE,pos17,lc32,nW,crc5:plain",
    "pos8",
    "pos8,crc4+pos9,crc4+pos10,crc5+pos11,crc5+pos12,crc6+pos13,crc6+pos14,crc7+pos64,crc16"};

/// A codec of each of them.
template <class Codec>
const std::vector<Codec>& all_codecs() {
  static const std::vector<Codec> codecs = [] {
    std::vector<Codec> made;
    for (const std::string_view text : frame_formats) made.emplace_back(parse_format(text).value());
    return made;
  }();
  return codecs;
}

}  // namespace biss::fuzz
