// A format and a setup, ready for runs of frames: monitor, words to bits, and other encoders.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "biss/base/units.hpp"
#include "biss/frame/encode.hpp"
#include "biss/safety/monitor.hpp"
#include "lab/campaign_frame.hpp"
#include "lab/sequence_row.hpp"
#include "sim/random.hpp"

namespace biss::lab {

/// What an encoder says in one frame, no error.
struct SequenceWords {
  std::uint64_t cpw = 0;
  std::uint64_t spw = 0;
  std::uint8_t life_counter = 0;
  bool cpw_nW = true;
  bool spw_nW = true;

  bool operator==(const SequenceWords&) const = default;
};

/// The monitor of one row, and whatever sends it frames.
class SequenceFrame {
 public:
  using Plan = CampaignFrame::Plan;
  using Monitor = CampaignFrame::Monitor;
  using Codec = Plan::Codec;

  /// \return none where CampaignFrame::make() gives none, or the monitor's self test fails
  static std::optional<SequenceFrame> make(const FrameFormat& format, SafetySetup setup,
                                           CounterMode counter, CounterMode encoder_counter);

  const SafetySetup& setup() const { return ready_.plan().setup(); }
  /// Tested, and without any frame seen.
  const Monitor& ready() const { return ready_; }
  /// The same pair of words with the encoder's counter, for theory.
  const CampaignFrame& words() const { return words_; }
  const Codec& codec() const { return words_.plan().codec(); }
  /// From request to request.
  Picoseconds cycle() const;
  /// From a request that is not answered in time to the watchdog's bound: begun cycles.
  unsigned watchdog_cycles() const;

  /// Encoders of the same type but for the start values of their CRCs: of the SPW, of the CPW, or
  /// of both. Their checksums differ from ours whatever the data.
  const std::vector<Codec>& other_starts() const { return other_starts_; }
  /// The same but for the polynomial of the SPW's CRC.
  const std::vector<Codec>& other_polynomials() const { return other_polynomials_; }

  /// The frame as an encoder with this codec sends it; how long ACK takes and where it begins is
  /// drawn within the setup's bounds, up to 16 clocks each.
  FrameBits encode(const SequenceWords& words, const Codec& codec, sim::Random& random) const;
  FrameBits encode(const SequenceWords& words, sim::Random& random) const {
    return encode(words, codec(), random);
  }
  /// Where the payload's first bit is in encoded bits.
  std::size_t payload_at(const FrameBits& bits) const { return bits.size_bits() - 1U - bits_; }

 private:
  SequenceFrame(const CampaignFrame& words, const Monitor& ready);

  CampaignFrame words_;
  Monitor ready_;
  std::vector<Codec> other_starts_;
  std::vector<Codec> other_polynomials_;
  std::uint16_t lead_min_ = 1;
  std::uint16_t lead_choice_ = 1;
  std::uint16_t ack_min_ = 1;
  std::uint16_t ack_choice_ = 1;
  unsigned bits_ = 0;
};

}  // namespace biss::lab
