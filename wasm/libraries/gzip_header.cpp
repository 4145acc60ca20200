#include "wasm/libraries/gzip_header.hpp"

#include <libdeflate.h>

#include <array>

namespace biss::wasm {
namespace {

constexpr std::uint8_t has_checksum = 2;
constexpr std::uint8_t has_extra = 4;
constexpr std::uint8_t has_name = 8;
constexpr std::uint8_t has_comment = 16;
constexpr std::uint8_t reserved = 0xE0;
constexpr std::uint8_t deflate = 8;
constexpr unsigned fixed_bytes = 10;

}  // namespace

// Goes on to the next part that the flags announce.
GzipHeader::State GzipHeader::end_part(Part part) {
  at_ = 0;
  value_ = 0;
  switch (part) {
    case Part::fixed:
      if ((flags_ & has_extra) != 0) {
        part_ = Part::extra_size;
        return State::more;
      }
      [[fallthrough]];
    case Part::extra_size:
    case Part::extra:
      if ((flags_ & has_name) != 0) {
        part_ = Part::name;
        return State::more;
      }
      [[fallthrough]];
    case Part::name:
      if ((flags_ & has_comment) != 0) {
        part_ = Part::comment;
        return State::more;
      }
      [[fallthrough]];
    case Part::comment:
      if ((flags_ & has_checksum) != 0) {
        part_ = Part::checksum;
        return State::more;
      }
      [[fallthrough]];
    case Part::checksum:
      break;
  }
  return State::complete;
}

GzipHeader::State GzipHeader::take(std::uint8_t byte) {
  constexpr std::array<std::uint8_t, 3> magic{0x1F, 0x8B, deflate};
  if (part_ != Part::checksum) checksum_ = libdeflate_crc32(checksum_, &byte, 1);
  const unsigned at = at_++;
  switch (part_) {
    case Part::fixed:
      if (at < magic.size() && byte != magic[at]) return State::wrong;
      if (at == magic.size()) flags_ = byte;
      if ((flags_ & reserved) != 0) return State::wrong;
      return at_ == fixed_bytes ? end_part(part_) : State::more;
    case Part::extra_size:
      value_ |= static_cast<unsigned>(byte) << 8U * at;
      if (at == 0) return State::more;
      if (value_ == 0) return end_part(Part::extra);
      part_ = Part::extra;
      at_ = 0;
      return State::more;
    case Part::extra:
      return at_ == value_ ? end_part(part_) : State::more;
    case Part::name:
    case Part::comment:
      return byte == 0 ? end_part(part_) : State::more;
    case Part::checksum:
      value_ |= static_cast<unsigned>(byte) << 8U * at;
      if (at == 0) return State::more;
      return value_ == (checksum_ & 0xFFFFU) ? State::complete : State::wrong;
  }
  return State::wrong;
}

}  // namespace biss::wasm
