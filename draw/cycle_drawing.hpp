// A request cycle as a drawing: both lines over time, the sampling points, the bits by name, the
// checksums, and the flips that would correct them. A renderer decides the appearance.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "biss/frame/format.hpp"
#include "biss/frame/line_order.hpp"
#include "decode/cycle_edges.hpp"

namespace biss::draw {

/// A clock of MA and the bit that belongs to it.
struct DrawnBit {
  /// Rising edges of MA are counted from 0; 0 is LAT, 1 is ACK.
  std::size_t clock = 0;
  /// The rising edge of MA.
  Picoseconds time{};
  /// When SLO is sampled for it; absent if there was no ACK.
  std::optional<Picoseconds> sampled_at;
  /// The level of SLO at the sample; absent if it is not known.
  std::optional<bool> level;
  /// `LAT`, `ACK`, `START`, `CDS`, `STOP`, a field of the format with the bit's number (`pos25`,
  /// `crc0`, `nE`), with the number of the channel after a dot from the second one on (`pos27.2`);
  /// `bit` if no format is known; empty after STOP.
  std::string name;
  /// The name without the bit's number: `pos`, `nE`, `crc.2`; empty if `name` is not the name of a
  /// field.
  std::string field;
  /// Number among the bits of data and CRC, from 0, as `bit=N` of a fault.
  std::optional<std::size_t> payload_bit;
  /// The channel of a data or CRC bit.
  std::size_t channel = 0;
  /// The field of a data bit; absent in a CRC.
  std::optional<LineField> data_field;
  /// The value of a CRC bit that the received data need.
  std::optional<bool> expected;
};

/// One or two bits of data and CRC, by their payload_bit.
using Flips = std::vector<std::size_t>;

/// The checksum of a channel with all its bits.
struct DrawnCheck {
  std::size_t channel = 0;
  std::uint16_t received = 0;
  /// The checksum of the received data.
  std::uint16_t expected = 0;
  /// If they differ: single bits whose flip would correct the channel.
  std::vector<Flips> singles;
  /// The number of pairs of bits whose flip would correct the channel, and the first pairs.
  std::size_t pair_count = 0;
  std::vector<Flips> pairs;

  bool right() const { return received == expected; }
};

inline constexpr std::size_t drawn_pairs = 4;

struct CycleDrawing {
  /// The period of a cycle without a measured clock.
  static constexpr Picoseconds period_when_unknown = microseconds(1);

  std::uint64_t number = 0;
  decode::Cycle cycle;
  wire::Level ma_before = wire::Level::high;
  wire::Level slo_before = wire::Level::unknown;
  /// From the first edge of MA to `end`.
  std::vector<decode::LevelChange> ma;
  std::vector<decode::LevelChange> slo;
  Picoseconds end{};
  std::vector<DrawnBit> bits;
  std::vector<DrawnCheck> checks;

  Picoseconds period() const { return cycle.period.value_or(period_when_unknown); }
  /// The name of a bit of data and CRC; empty if it was not received.
  std::string_view name_of(std::size_t payload_bit) const;
};

/// How much of a cycle is drawn.
enum class DrawnExtent : std::uint8_t {
  frame,  ///< until SLO has settled after the last sample
  cycle,  ///< also the time until both lines rest: the timeout, CDM, pulses
};

/// \param margin as for the reader of the cycle
CycleDrawing draw_cycle(const decode::CycleEdges& edges, const std::optional<FrameFormat>& format,
                        const DeviceTiming& timing, const decode::MarginSetup& margin = {},
                        DrawnExtent extent = DrawnExtent::frame);

}  // namespace biss::draw
