// The formats of the frames that the targets read: every kind of item occurs.
#pragma once

#include "biss/frame/encode.hpp"
#include "biss/frame/format_text.hpp"
#include "fuzz/target.hpp"

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

/// A codec of one of them.
template <class Codec>
const Codec& codec_of(std::size_t number) {
  static const std::vector<Codec> codecs = [] {
    std::vector<Codec> made;
    for (const std::string_view text : frame_formats) made.emplace_back(parse_format(text).value());
    return made;
  }();
  return codecs[number % codecs.size()];
}

/// Encoding the decoded frame gives the same bits, except `zeros` in place of the first ones.
template <class Frame, class Codec>
void check_given_back(const Frame& frame, BitView bits, std::size_t zeros, const Codec& codec) {
  const auto sent = encode_frame(frame, codec);
  require(sent.ok());
  const std::size_t size = sent->size_bits() - (frame.stop_seen ? 0U : 1U);
  require(size <= bits.size_bits());
  for (std::size_t i = zeros; i < size; ++i) require(sent->view()[i] == bits[i]);
}

}  // namespace biss::fuzz
