// The possible kinds of a request, and the cost of each in bits: the lower, the better it predicts
// the edges that were seen.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "biss/frame/codec.hpp"
#include "biss/timing/device_timing.hpp"
#include "decode/cycle_edges.hpp"
#include "explain/checksum_variant.hpp"

namespace biss::explain {

enum class RequestKind : std::uint8_t {
  ok,
  error_flag,      ///< a good frame with nE = 0
  life_jump,       ///< a good frame whose sign of life is not one more than before
  implausible,     ///< a good frame whose position no axis can have
  short_frame,     ///< a frame for control communication alone
  other_length,    ///< a frame with more or fewer bits than usual
  paused,          ///< a good frame, MA rests inside it
  flip,            ///< bits are wrong
  refused,         ///< nothing is unusual, except that the format does not fit
  slip,            ///< the encoder has counted a clock too many or too few
  silent,          ///< SLO stayed high
  stuck,           ///< SLO was low until the next request
  busy,            ///< SLO was low at the request and rose later
  hurried,         ///< SLO was low at a request that came sooner than before good frames
  inverted,        ///< SLO rests low and rises for ACK
  half_early,      ///< SLO changes with the falling edges of MA
  stop_repeats,    ///< STOP has the level of the bit before
  cut_in_ack,      ///< MA stopped before START
  cut_late,        ///< START came later than in any good frame, and bits are missing
  cut_in_data,     ///< START came in time, and MA stopped before the last bit
  restart,         ///< as before, and the next clocks come soon
  ma_held,         ///< MA stopped within the request: it stays low, or one next to it is missing
  ones,            ///< SLO stayed high from a bit on to the end, STOP included
  zeros,           ///< SLO stayed low from a bit on to the end
  slo_pulse,       ///< a pulse on SLO, the frame otherwise good
  ma_pulse,        ///< a pulse on MA, the frame otherwise good
  smeared,         ///< a good frame, SLO changes far from its usual place in a bit
  delay_part,      ///< a good frame, the line delay differs by a part of a period
  delay_clocks,    ///< a good frame, one or more clocks later than usual
  stop_high,       ///< STOP is 1, the frame otherwise good
  cds_high,        ///< CDS is 1, 0 by the format; the frame otherwise good
  other_ack,       ///< START outside the bounds of the encoder, the frame otherwise good
  other_checksum,  ///< the checksum is right by a maker's rule
  foreign,         ///< each clock is a bit of a number that moves
  literal,         ///< as it was seen, without a reason
};

inline constexpr std::size_t kind_count = 35;

/// A few words for the evidence: "N of M cycles: …".
std::string_view text_of(RequestKind kind);

/// In bits, for one request; `impossible` for a kind that it is not.
using Prices = std::array<float, kind_count>;
inline constexpr float impossible = 1e9F;

/// The usual shape of the requests of a capture, from its beginning.
struct Usual {
  Picoseconds period{};
  /// How long MA is high in a period.
  Picoseconds high{};
  Picoseconds delay{};
  /// The number of bits between CDS and STOP: from the format, else from the frames.
  unsigned payload_bits = 0;
  /// Rising edges of MA.
  std::uint32_t clocks = 0;
  std::optional<ChecksumVariant> checksum;
  /// Almost no frame has the right checksum, and no rule fits.
  bool no_checksum_fits = false;
  /// If requests come in groups, each of which begins like a request of BiSS C: the usual pause in
  /// a group.
  std::optional<Picoseconds> rest_in_group;
};
/// \param cycles from the beginning of the capture
Usual usual_of(std::span<const decode::Cycle> cycles, const std::optional<FrameFormat>& format);

/// Prices the requests of a capture in their order.
class Pricer {
 public:
  Pricer(const std::optional<FrameFormat>& format, Picoseconds resolution, const Usual& usual);

  /// A good frame with nothing unusual that Cycle shows: it is `ok`, and its edges need not be seen.
  bool is_plain(const decode::Cycle& cycle) const;
  /// The next request is plain.
  void learn(const decode::Cycle& cycle);
  /// The next request is not. \param thorough also looks for one wrong bit or clock, which is slow
  Prices read(const decode::CycleEdges& edges, bool thorough = true);

  /// From the last edge of MA before to this request.
  std::optional<Picoseconds> rest_before(const decode::Cycle& cycle) const;
  /// In the request read last.
  unsigned ma_pulses() const { return view_.ma_pulses; }
  unsigned slo_pulses() const { return view_.slo_pulses; }
  Picoseconds smear() const { return view_.smear; }
  /// Its checksum is wrong, and its position is near the position of the frame before.
  bool position_is_likely() const { return view_.likely; }
  /// By its bits, which no checksum proves, the encoder reports an error.
  bool shows_error() const;

 private:
  using Bits = FrameBits;
  // A channel, and its first bit, counted from START.
  struct Place {
    ChannelFormat format;
    std::size_t at = 0;
  };
  // A request as it is read by a master that has the line delay.
  struct View {
    std::vector<Picoseconds> rises;
    Picoseconds time{};
    Picoseconds period{};
    unsigned ma_pulses = 0;
    unsigned slo_pulses = 0;
    unsigned pulses_in_bits = 0;
    unsigned pauses = 0;
    // SLO changes in a pause.
    bool gave_up = false;
    // Changes of SLO that are not at the beginning of a bit.
    float off_grid = 0;
    Picoseconds smear{};
    bool likely = false;
    Bits bits;
    // Indexes of ACK and START; past the end if missing.
    std::size_t ack = 0;
    std::size_t start = 0;

    std::size_t clocks() const { return rises.size(); }
    // From START on.
    BitView frame() const { return bits.view().from(start); }
    std::size_t ack_clocks() const { return start - ack; }
  };

  void look(const decode::CycleEdges& edges, Picoseconds delay);
  void count_pulses(const decode::CycleEdges& edges);
  void remove_pulses(std::vector<decode::LevelChange>& ma);
  void price_frame(const decode::CycleEdges& edges, Prices& prices);
  void price_good(const Frame& frame, float base, Prices& prices);
  void price_wrong(FrameError error, float base, float after, Prices& prices);
  void price_cut(const decode::CycleEdges& edges, Prices& prices) const;
  void price_tails(Prices& prices) const;
  void price_moved(const decode::CycleEdges& edges, Prices& prices);
  void price_low(const decode::CycleEdges& edges, Prices& prices) const;
  void price_length(Prices& prices);
  std::optional<std::size_t> bits_before_checksum() const;
  void price_checksum(float price, Prices& prices);
  void remember();
  bool is_part(const decode::CycleEdges& edges) const;
  bool is_held(const decode::CycleEdges& edges) const;
  bool is_brief() const;
  bool has_strong_checksum() const;
  float mended_price(BitView bits) const;
  float flip_price() const;
  float slip_price() const;
  float ack_price(std::size_t clocks) const;
  // moves_on: or the position moves on as between the last two good frames
  float data_price(BitView frame, bool moves_on = false) const;
  std::uint64_t due_position(std::size_t channel) const;
  static std::uint64_t position_of(BitView frame, const Place& place);
  float frame_change(BitView before, std::size_t size) const;
  Result<Frame, FrameFault> judge(BitView bits) const;

  std::optional<FrameCodec<>> codec_;
  bool thorough_ = true;
  Picoseconds resolution_;
  Usual usual_;
  std::vector<Place> channels_;
  View view_;
  // From the good frames before.
  std::array<std::uint32_t, 512> acks_{};
  std::uint32_t frames_ = 0;
  std::uint16_t longest_ack_ = 0;
  std::uint32_t fewest_clocks_ = UINT32_MAX;
  std::array<std::uint64_t, max_channels> data_{};
  std::array<std::uint64_t, max_channels> steps_{};
  Picoseconds data_time_{};
  Picoseconds step_time_{};
  std::optional<Picoseconds> shortest_rest_;
  // The last frame of any kind, the last one that was refused, and the last one whose length was
  // unusual, all from START on.
  decode::RawBits before_;
  decode::RawBits refused_;
  decode::RawBits other_;
  // The last unusual request from LAT on.
  Bits last_;
  std::optional<Picoseconds> last_edge_;
  std::optional<Picoseconds> last_request_;
  bool was_good_ = false;
  // From a good frame to the next one: the shortest, how many there were, and how many like it.
  Picoseconds interval_{};
  std::uint32_t intervals_ = 0;
  std::uint32_t regular_ = 0;
  // The last request may be a part of one.
  bool was_part_ = false;
};

}  // namespace biss::explain
