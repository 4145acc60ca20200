// The oracle: a second implementation of the protocol, written from its description alone. It
// shares no code with the core, is slow and simple, and is the reference for encoder and decoder in
// the tests.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace oracle {

/// Levels of SLO, one a MA clock, in transmission order.
using Bits = std::vector<bool>;

/// The meaning of an item of a channel. `nE`, `nW` are low-active on the line, `E`, `W`
/// high-active.
enum class Kind {
  position,
  multiturn,
  singleturn,
  gray_singleturn,
  padding,
  nE,
  nW,
  E,
  W,
  counter
};

struct Item {
  Kind kind{};
  std::size_t bits = 0;
};

/// A checksum by polynomial division.
struct Checksum {
  Bits polynomial;  ///< coefficients from x^width down to 1, all of them
  Bits start;       ///< the register before the first bit, width bits
  bool inverted = true;

  std::size_t width() const { return start.size(); }
};

struct ChannelDescription {
  std::vector<Item> items;  ///< in the order on the line
  std::optional<Checksum> checksum;

  std::size_t data_bits() const;
};

struct Description {
  std::vector<ChannelDescription> channels;  ///< in the order on the line
  bool cds_must_be_0 = false;
};

/// A channel's values. The flags in the sense of nE and nW (false = error, warning); true if the
/// channel has none.
struct Values {
  std::uint64_t position = 0;
  std::uint64_t counter = 0;
  bool nE = true;
  bool nW = true;

  bool operator==(const Values&) const = default;
};

/// The permitted number of clocks before START.
struct Limits {
  std::size_t lead_min = 1;
  std::size_t lead_max = 402;
  std::size_t ack_min = 1;
  std::size_t ack_max = 400;
};

/// A decoded frame: the cause of the failure (empty: none), else its values.
struct Reading {
  std::string cause;
  std::size_t channel = 0;  ///< if the cause is `crc`
  std::vector<Values> values;
  std::size_t lead = 0;
  std::size_t ack = 0;
  bool cds = false;
  bool stop_seen = false;
};

/// The lowest `count` bits of a number, most significant first.
Bits bits_of(std::uint64_t number, std::size_t count);
/// The number in the bits from `first` on, most significant first.
std::uint64_t number_of(const Bits& bits, std::size_t first, std::size_t count);

/// The checksum of some data as transmitted: the remainder of data * x^width, with the start value
/// added to the leading coefficients, divided by the polynomial.
Bits checksum_of(const Checksum& checksum, const Bits& data);

/// The line of one frame: `lead` ones, `ack` zeros, START, CDS, channels, STOP. Padding is 0.
Bits encode(const Description& description, const std::vector<Values>& values, std::size_t lead,
            std::size_t ack, bool cds);

Reading decode(const Description& description, const Limits& limits, const Bits& line);

}  // namespace oracle
