// A control session with a script of the CDS bits of a control frame.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "biss/base/wrapping_time.hpp"
#include "biss/control/session.hpp"

namespace biss::test {

/// A line of bits as characters: '0', '1', and '?' for a frame without CDS.
struct CdsScript {
  std::array<char, 1024> text{};
  std::size_t size = 0;

  constexpr void add(char bit) {
    if (size < text.size()) text[size++] = bit;
  }
  constexpr void add(std::string_view bits) {
    for (const char bit : bits) {
      if (bit != ' ') add(bit);
    }
  }
  /// The lowest `count` bits of a number, the highest of them first.
  constexpr void number(std::uint32_t value, unsigned count) {
    for (unsigned i = count; i-- > 0;) add((value >> i & 1U) != 0 ? '1' : '0');
  }
  constexpr std::string_view view() const { return {text.data(), size}; }
};

/// CRC of the control channel as the protocol defines it, independent of the core: the remainder of
/// data * x^4 by x^4 + x + 1, inverted.
constexpr std::uint32_t plain_crc4(std::uint32_t data, unsigned bits) {
  std::uint32_t rest = data << 4U;
  for (unsigned i = bits + 4; i-- > 4;) {
    if ((rest >> i & 1U) != 0) rest ^= 0x13U << (i - 4U);
  }
  return ~rest & 0xFU;
}

/// A byte and its CRC.
constexpr void add_byte(CdsScript& line, std::uint32_t data) {
  line.number(data, 8);
  line.number(plain_crc4(data, 8), 4);
}

/// CDS of a register access to the only slave up to S of the first byte.
inline constexpr std::string_view read_accepted = "1000000000000000 101";
inline constexpr std::string_view write_accepted = "1000000000000000 011";

/// Steps frame by frame. CDS bit k of the script comes in the frame after the frame that CDM bit k
/// ended. Bit 0 belongs to the next 1 of CDM.
class Frames {
 public:
  constexpr explicit Frames(ControlSession& session) : session_(session) {}

  /// The script counts from the next 1 of CDM on.
  constexpr void answer(std::string_view cds) {
    cds_ = cds;
    started_ = false;
    heard_ = {};
  }

  /// One frame, with the CDS of the script.
  constexpr bool step() { return step(next_cds()); }
  constexpr bool step(CdsBit cds) {
    now = wrapping_later(now, cycle);
    const bool bit = session_.step(now, cds);
    if (bit && !started_) {
      started_ = true;
      at_ = 0;
      zeros_before = zeros;
    }
    if (started_) heard_.add(bit ? '1' : '0');
    if (bit) {
      zeros = 0;
    } else if (cds != CdsBit::missing) {
      ++zeros;
    }
    return bit;
  }

  /// Runs until the access has ended, at most `most` frames. Returns the number of frames.
  constexpr std::uint32_t run(std::uint32_t most = 2000) {
    std::uint32_t count = 0;
    for (; !session_.done() && count < most; ++count) step();
    return count;
  }
  constexpr std::uint32_t run(std::string_view cds, std::uint32_t most = 2000) {
    answer(cds);
    return run(most);
  }

  /// CDM from the start bit on.
  constexpr std::string_view cdm() const { return heard_.view(); }

  Picoseconds now{};
  Picoseconds cycle = microseconds(250);
  /// CDM = 0 in frames that were not lost, since the last 1; and how many there were before the
  /// start bit.
  unsigned zeros = 0;
  unsigned zeros_before = 0;

 private:
  constexpr CdsBit next_cds() {
    if (!started_ || at_ >= cds_.size()) return CdsBit::zero;
    while (at_ + 1 < cds_.size() && cds_[at_] == ' ') ++at_;
    const char bit = cds_[at_++];
    if (bit == '?') return CdsBit::missing;
    return bit == '1' ? CdsBit::one : CdsBit::zero;
  }

  ControlSession& session_;
  std::string_view cds_;
  std::size_t at_ = 0;
  bool started_ = false;
  CdsScript heard_;
};

}  // namespace biss::test
