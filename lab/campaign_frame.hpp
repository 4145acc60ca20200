// The two words of a safety frame in a campaign: encoded, with a fault, and judged by a monitor with
// a format and a setup that are known at run time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <optional>
#include <vector>

#include "biss/safety/monitor.hpp"
#include "lab/campaign_fault.hpp"

namespace biss::lab {

/// A plan that several monitors share, so that none has tables of its own.
class SharedSafetyPlan {
 public:
  using Codec = SafetyPlan<>::Codec;
  using Frame = SafetyPlan<>::Frame;
  static constexpr std::size_t most_channels = SafetyPlan<>::most_channels;
  static constexpr unsigned most_payload_bits = SafetyPlan<>::most_payload_bits;
  static constexpr unsigned least_payload_bits = SafetyPlan<>::least_payload_bits;
  static constexpr std::size_t most_faults = SafetyPlan<>::most_faults;
  // Faults of this computer's memory are outside the experiments.
  static constexpr bool checks_memory = false;

  /// \pre the plan outlives this
  explicit SharedSafetyPlan(const SafetyPlan<>& plan)
      : plan_(&plan), fingerprint_(plan.fingerprint()) {}

  const Codec& codec() const { return plan_->codec(); }
  const FrameFormat& format() const { return plan_->format(); }
  unsigned payload_bits() const { return plan_->payload_bits(); }
  const SafetySetup& setup() const { return plan_->setup(); }
  const safety_detail::Alignment& alignment() const { return plan_->alignment(); }
  std::optional<SafetySetupError> mistake() const { return plan_->mistake(); }
  const SafetyFingerprint& fingerprint() const { return fingerprint_; }
  bool is(const SafetyFingerprint& expected) const { return fingerprint_ == expected; }

 private:
  const SafetyPlan<>* plan_;
  SafetyFingerprint fingerprint_;
};

/// A SafetyMonitor that can be copied: only an experiment may return to an earlier state.
class Monitor : public SafetyMonitor<SharedSafetyPlan> {
 public:
  /// \pre the plan outlives this
  explicit Monitor(const SafetyPlan<>& plan) : SafetyMonitor(SharedSafetyPlan(plan)) {}
  Monitor(const Monitor& other) : SafetyMonitor(other.plan()) { *this = other; }
  Monitor& operator=(const Monitor& other) {
    std::memmove(static_cast<void*>(this), &other, sizeof *this);
    return *this;
  }

  bool self_test() { return SafetyMonitor::self_test(plan().fingerprint()); }
  /// Whatever fault is latched.
  void acknowledge() { SafetyMonitor::acknowledge(latched_cause()); }
};

/// Both words with their CRCs, right-aligned: bit 0 is a word's last bit on the line; and the bits
/// around them.
struct WordPair {
  std::uint64_t cpw = 0;
  std::uint64_t spw = 0;
  bool stop = false;
  bool cds = false;
  /// START is 1 at its place.
  bool start = true;
  /// The bit of ACK that is 1, in clocks before START; 0: none.
  std::uint8_t early_clocks = 0;

  bool operator==(const WordPair&) const = default;
};

/// The content of one frame from the encoder in a campaign, with no error and no warning.
struct SentFrame {
  std::uint64_t position = 0;
  std::uint8_t life_counter = 0;
};

/// The checks that accept a frame with a fault. The words begin after the bit that is taken for
/// START. All false if the frame was received as it was sent.
struct FrameOutcome {
  bool cpw = false;      ///< the control word is wrong, and its CRC is good
  bool spw = false;      ///< the safety word is wrong, and its CRC is good
  bool both = false;     ///< either word is wrong, and both CRCs are good
  bool monitor = false;  ///< the verdict is `safe`
  bool wrong = false;    ///< the verdict is `safe` with a position that was not sent

  bool operator==(const FrameOutcome&) const = default;
};

/// A format and a setup, ready for frames. The control word is the first channel, the safety word
/// the second and last one; each has at most 64 bits with its CRC.
class CampaignFrame {
 public:
  using Plan = SafetyPlan<>;

  /// A counter whose range the monitor would have to learn is taken as 1…63.
  /// \return nothing if the format and the setup are not such a pair or cannot be monitored
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
  /// How one wrong bit of a word changes its checksum, [0] for the word's last bit.
  const std::vector<std::uint32_t>& cpw_columns() const { return cpw_columns_; }
  const std::vector<std::uint32_t>& spw_columns() const { return spw_columns_; }

  /// Frame `index` of the sequence with this seed: any position, any counter of its range.
  SentFrame draw(std::uint64_t seed, std::uint64_t index) const;
  WordPair encode(const SentFrame& sent) const;
  /// With these bits of both words inverted; bit 0 is the last bit of the safety word.
  WordPair flipped(WordPair words, LineWord wrong) const {
    words.cpw ^= static_cast<std::uint64_t>(wrong >> spw_bits());
    words.spw ^= static_cast<std::uint64_t>(wrong) & low_mask(spw_bits());
    return words;
  }
  /// Frame `index` with the fault. \pre not flips; a burst or a place fits into bits()
  WordPair damage(const WordPair& words, const FaultChoice& fault, std::uint64_t seed,
                  std::uint64_t index) const;

  /// The words after the bit that the reader takes for START, within the bounds of the setup;
  /// nothing if it finds no START.
  std::optional<WordPair> read(const WordPair& received) const;
  /// By decoder and monitor alone, as in firmware.
  FrameOutcome judge(const SentFrame& sent, const WordPair& received) const;
  /// The monitor's judgement of a frame that follows good ones.
  SafetyJudgement monitor(const SentFrame& sent, const WordPair& received) const;

 private:
  CampaignFrame(const FrameFormat& format, const SafetySetup& setup);

  // Returns false if the self test fails.
  bool prepare();

  std::shared_ptr<const Plan> plan_;
  // [counter]: after good frames; a frame with this counter is due at `due_`.
  std::vector<Monitor> ready_;
  Picoseconds due_{};
  std::vector<std::uint32_t> cpw_columns_;
  std::vector<std::uint32_t> spw_columns_;
};

}  // namespace biss::lab
