// The two words of a safety frame as a campaign sees them: made, damaged, and judged.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "biss/safety/monitor.hpp"
#include "lab/campaign_fault.hpp"

namespace biss::lab {

/// Both words with their CRCs, right-aligned: bit 0 is a word's last bit on the line. And what is
/// around them.
struct WordPair {
  std::uint64_t cpw = 0;
  std::uint64_t spw = 0;
  bool stop = false;
  bool cds = false;
  /// START is 1 where it was sent.
  bool start = true;
  /// A bit of ACK is 1, so many clocks before START; 0: none is.
  std::uint8_t early_clocks = 0;

  bool operator==(const WordPair&) const = default;
};

/// What an encoder says in one frame of a campaign: no error, no warning.
struct SentFrame {
  std::uint64_t position = 0;
  std::uint8_t life_counter = 0;
};

/// What becomes of a damaged frame; words are those that follow what is taken for START. All false
/// where everything came as it was sent.
struct FrameOutcome {
  bool cpw = false;      ///< the control word is not the one that was sent, and its CRC is good
  bool spw = false;      ///< the same of the safety word
  bool both = false;     ///< either is not the one that was sent, and both CRCs are good
  bool monitor = false;  ///< the monitor says `safe`
  bool wrong = false;    ///< … with a position that was not sent

  bool operator==(const FrameOutcome&) const = default;
};

/// A plan that several monitors share: tables are not copied with a monitor.
class SharedSafetyPlan {
 public:
  using Codec = SafetyPlan<>::Codec;
  using Frame = SafetyPlan<>::Frame;
  static constexpr std::size_t most_channels = SafetyPlan<>::most_channels;
  static constexpr unsigned most_payload_bits = SafetyPlan<>::most_payload_bits;
  static constexpr unsigned least_payload_bits = SafetyPlan<>::least_payload_bits;

  /// The plan must outlive this.
  explicit SharedSafetyPlan(const SafetyPlan<>& plan) : plan_(&plan) {}

  const Codec& codec() const { return plan_->codec(); }
  const FrameFormat& format() const { return plan_->format(); }
  unsigned payload_bits() const { return plan_->payload_bits(); }
  const SafetySetup& setup() const { return plan_->setup(); }
  const safety_detail::Alignment& alignment() const { return plan_->alignment(); }

 private:
  const SafetyPlan<>* plan_;
};

/// A format and a setup, ready for frames. The control word is the first channel, the safety word
/// the second and last one; each has at most 64 bits with its CRC.
class CampaignFrame {
 public:
  using Plan = SafetyPlan<>;
  using Monitor = SafetyMonitor<Plan>;

  /// A counter whose range would have to be learned is taken as 1…63.
  /// \return none where the format and the setup are no such pair or cannot be monitored
  static std::optional<CampaignFrame> make(const FrameFormat& format, SafetySetup setup);

  const Plan& plan() const { return *plan_; }
  const FrameFormat& format() const { return plan_->format(); }
  const ChannelFormat& cpw_format() const { return format().channel_list[0]; }
  const ChannelFormat& spw_format() const { return format().channel_list[1]; }
  unsigned cpw_bits() const { return cpw_format().total_bits(); }
  unsigned spw_bits() const { return spw_format().total_bits(); }
  unsigned bits() const { return cpw_bits() + spw_bits(); }
  unsigned first_counter() const {
    return plan_->setup().counter.mode == CounterMode::count_0_63 ? 0 : 1;
  }
  /// What one wrong bit of a word does to its checksum, [0] for the word's last bit.
  const std::vector<std::uint32_t>& cpw_columns() const { return cpw_columns_; }
  const std::vector<std::uint32_t>& spw_columns() const { return spw_columns_; }

  /// Frame `index` of the sequence that `seed` begins: any position, any counter of its range.
  SentFrame draw(std::uint64_t seed, std::uint64_t index) const;
  WordPair encode(const SentFrame& sent) const;
  /// Frame `index` after the fault. \pre not flips; a burst or a place fits into bits()
  WordPair damage(const WordPair& words, const FaultChoice& fault, std::uint64_t seed,
                  std::uint64_t index) const;

  /// The words behind what the reader takes for START, within the bounds of the setup; none where
  /// it finds no START.
  std::optional<WordPair> read(const WordPair& received) const;
  /// By decode and monitor alone, as firmware would.
  FrameOutcome judge(const SentFrame& sent, const WordPair& received) const;
  /// The monitor's word on a frame that follows good ones.
  SafetyJudgement monitor(const SentFrame& sent, const WordPair& received) const;

 private:
  CampaignFrame(const FrameFormat& format, const SafetySetup& setup);

  using SharedMonitor = SafetyMonitor<SharedSafetyPlan>;

  // False where the self test fails.
  bool prepare();

  std::shared_ptr<const Plan> plan_;
  // [counter]: behind good frames, a frame with this counter is due at `due_`.
  std::vector<SharedMonitor> ready_;
  Picoseconds due_{};
  std::vector<std::uint32_t> cpw_columns_;
  std::vector<std::uint32_t> spw_columns_;
};

}  // namespace biss::lab
