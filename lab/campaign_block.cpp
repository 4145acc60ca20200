#include "lab/campaign_block.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <optional>
#include <string>

#include "lab/campaign_fitting.hpp"
#include "sim/random.hpp"

namespace biss::lab {
namespace {

constexpr std::size_t lane_words = 4;
constexpr std::size_t lane_frames = 64 * lane_words;

// One bit of each of 256 frames: frame n is bit n % 64 of word n / 64. The compiler divides it if
// vector units are narrower.
using Lanes = std::uint64_t __attribute__((vector_size(8 * lane_words)));

bool any(const Lanes& lanes) { return (lanes[0] | lanes[1] | lanes[2] | lanes[3]) != 0; }

// Four xoshiro256++ generators (Blackman and Vigna) side by side.
class LaneRandom {
 public:
  explicit LaneRandom(std::uint64_t seed) {
    sim::Random random(seed);
    for (Lanes& part : state_) {
      for (std::size_t word = 0; word < lane_words; ++word) part[word] = random.next();
    }
  }

  Lanes next() {
    const Lanes result = rotated<23>(state_[0] + state_[3]) + state_[0];
    const Lanes shifted = state_[1] << 17U;
    state_[2] ^= state_[0];
    state_[3] ^= state_[1];
    state_[1] ^= state_[2];
    state_[0] ^= state_[3];
    state_[2] ^= shifted;
    state_[3] = rotated<45>(state_[3]);
    return result;
  }

  // \pre rate is not 0
  Lanes chosen(std::uint32_t rate) {
    return chosen_bits<Lanes>(
        rate, [this] { return next(); }, any);
  }

 private:
  template <unsigned Bits>
  static Lanes rotated(const Lanes& value) {
    return (value << Bits) | (value >> (64U - Bits));
  }

  std::array<Lanes, 4> state_{};
};

std::uint64_t sequence_seed(const FaultSequence& sequence) {
  const std::string_view kind = sim::name_of(sequence.fault.kind);
  const std::string text = text_of(sequence.fault);
  return row_seed(sequence.seed, std::string(seed_name(kind)) + text.substr(kind.size()));
}

// Wrong bits of 256 frames; [0] is the last bit of the safety word.
class ErrorSlices {
 public:
  ErrorSlices(const CampaignFrame& frame, const FaultSequence& sequence, std::uint64_t block)
      : cpw_bits_(frame.cpw_bits()),
        spw_bits_(frame.spw_bits()),
        rate_(sequence.fault.sampling_rate()),
        random_(sim::scrambled(sequence_seed(sequence) + block)) {}

  void draw() {
    for (unsigned bit = 0; bit < cpw_bits_ + spw_bits_; ++bit) wrong_[bit] = random_.chosen(rate_);
  }
  const Lanes* spw() const { return wrong_.data(); }
  const Lanes* cpw() const { return wrong_.data() + spw_bits_; }
  std::uint64_t cpw(std::size_t lane) const { return lane_of(cpw(), cpw_bits_, lane); }
  std::uint64_t spw(std::size_t lane) const { return lane_of(spw(), spw_bits_, lane); }

 private:
  static std::uint64_t lane_of(const Lanes* slices, unsigned bits, std::size_t lane) {
    const std::size_t word = lane / 64;
    const std::size_t shift = lane % 64;
    std::uint64_t value = 0;
    for (unsigned bit = 0; bit < bits; ++bit) {
      value |= ((slices[bit][word] >> shift) & 1U) << bit;
    }
    return value;
  }

  std::array<Lanes, 128> wrong_{};
  unsigned cpw_bits_;
  unsigned spw_bits_;
  std::uint32_t rate_;
  LaneRandom random_;
};

// Lanes with a bad checksum, and lanes with any wrong bit.
struct WordLanes {
  Lanes bad{};
  Lanes altered{};
};

WordLanes check_word(const Lanes* wrong, const std::vector<std::uint32_t>& columns) {
  std::array<Lanes, max_crc_bits> sums{};
  WordLanes word;
  for (std::size_t bit = 0; bit < columns.size(); ++bit) {
    word.altered |= wrong[bit];
    for (std::uint32_t left = columns[bit]; left != 0; left &= left - 1U) {
      sums[static_cast<std::size_t>(std::countr_zero(left))] ^= wrong[bit];
    }
  }
  for (const Lanes& sum : sums) word.bad |= sum;
  return word;
}

template <class Visit>
void for_each_lane(const Lanes& lanes, std::size_t count, Visit visit) {
  for (std::size_t word = 0; word < lane_words; ++word) {
    for (std::uint64_t left = lanes[word]; left != 0; left &= left - 1U) {
      const std::size_t lane = 64 * word + static_cast<std::size_t>(std::countr_zero(left));
      if (lane < count) visit(lane);
    }
  }
}

void add_outcome(CampaignCounts& counts, const FrameOutcome& outcome, std::uint64_t index,
                 std::size_t cpw_weight, std::size_t spw_weight) {
  const std::size_t weight = cpw_weight + spw_weight;
  if (outcome.cpw) counts.add(Acceptance::cpw, cpw_weight);
  if (outcome.spw) counts.add(Acceptance::spw, spw_weight);
  if (outcome.both) counts.add(Acceptance::both, weight);
  if (outcome.monitor) counts.add(Acceptance::monitor, weight);
  if (!outcome.wrong) return;
  counts.add(Acceptance::wrong, weight);
  counts.add_missed(index);
}

void add_fitted(CampaignCounts& counts, const FrameOutcome& outcome, std::uint64_t index,
                const FittedBits& bits) {
  if (outcome.monitor) ++counts.fitted[{Acceptance::monitor, bits}];
  if (!outcome.wrong) return;
  ++counts.fitted[{Acceptance::wrong, bits}];
  counts.add_missed(index);
}

std::size_t weight_of(std::uint64_t wrong) {
  return static_cast<std::size_t>(std::popcount(wrong));
}

CampaignCounts count_flips(const CampaignFrame& frame, const FaultSequence& sequence,
                           std::uint64_t block, std::uint64_t frames) {
  ErrorSlices slices(frame, sequence, block);
  const std::uint64_t seed = sequence_seed(sequence);
  CampaignCounts counts;
  counts.frames = frames;
  for (std::uint64_t done = 0; done < frames; done += lane_frames) {
    const auto here = static_cast<std::size_t>(std::min<std::uint64_t>(lane_frames, frames - done));
    slices.draw();
    const WordLanes cpw = check_word(slices.cpw(), frame.cpw_columns());
    const WordLanes spw = check_word(slices.spw(), frame.spw_columns());
    for_each_lane(cpw.altered & ~cpw.bad, here, [&](std::size_t lane) {
      counts.add(Acceptance::cpw, weight_of(slices.cpw(lane)));
    });
    for_each_lane(spw.altered & ~spw.bad, here, [&](std::size_t lane) {
      counts.add(Acceptance::spw, weight_of(slices.spw(lane)));
    });
    const Lanes both = (cpw.altered | spw.altered) & ~cpw.bad & ~spw.bad;
    for_each_lane(both, here, [&](std::size_t lane) {
      const std::uint64_t index = block * block_frames + done + lane;
      const SentFrame sent = frame.draw(seed, index);
      WordPair received = frame.encode(sent);
      const std::uint64_t cpw_wrong = slices.cpw(lane);
      const std::uint64_t spw_wrong = slices.spw(lane);
      received.cpw ^= cpw_wrong;
      received.spw ^= spw_wrong;
      FrameOutcome outcome = frame.judge(sent, received);
      outcome.cpw = outcome.spw = false;  // counted above
      add_outcome(counts, outcome, index, weight_of(cpw_wrong), weight_of(spw_wrong));
    });
  }
  return counts;
}

// Calls visit(index, replayed) for each frame of a block.
template <class Visit>
void for_each_frame(const CampaignFrame& frame, const FaultSequence& sequence, std::uint64_t block,
                    std::uint64_t frames, Visit visit) {
  const std::uint64_t seed = sequence_seed(sequence);
  const FaultChoice& fault = sequence.fault;
  std::optional<FittingDraws> draws;
  std::optional<ErrorSlices> slices;
  if (fault.fitting) {
    draws.emplace(frame, fault.rate);
  } else if (fault.kind == FaultKind::flips) {
    slices.emplace(frame, sequence, block);
  }
  for (std::uint64_t n = 0; n < frames; ++n) {
    const std::uint64_t index = block * block_frames + n;
    const SentFrame sent = frame.draw(seed, index);
    const WordPair encoded = frame.encode(sent);
    ReplayedFrame replayed{sent, encoded, encoded};
    if (draws) {
      const FittingDraws::Pattern pattern = draws->draw(sent, seed, index);
      replayed.received = frame.flipped(encoded, pattern.wrong);
      replayed.drawn = pattern.bits;
    } else if (slices) {
      if (n % lane_frames == 0) slices->draw();
      replayed.received.cpw ^= slices->cpw(n % lane_frames);
      replayed.received.spw ^= slices->spw(n % lane_frames);
    } else {
      replayed.received = frame.damage(encoded, fault, seed, index);
    }
    visit(index, replayed);
  }
}

}  // namespace

CampaignCounts count_block_plainly(const CampaignFrame& frame, const FaultSequence& sequence,
                                   std::uint64_t block, std::uint64_t frames) {
  CampaignCounts counts;
  counts.frames = frames;
  const bool flips = sequence.fault.kind == FaultKind::flips;
  for_each_frame(frame, sequence, block, frames,
                 [&](std::uint64_t index, const ReplayedFrame& one) {
                   const FrameOutcome outcome = frame.judge(one.sent, one.received);
                   if (sequence.fault.fitting) {
                     add_fitted(counts, outcome, index, one.drawn);
                   } else {
                     add_outcome(counts, outcome, index,
                                 flips ? weight_of(one.encoded.cpw ^ one.received.cpw) : 0,
                                 flips ? weight_of(one.encoded.spw ^ one.received.spw) : 0);
                   }
                 });
  return counts;
}

CampaignCounts count_block(const CampaignFrame& frame, const FaultSequence& sequence,
                           std::uint64_t block, std::uint64_t frames) {
  const bool sliced = sequence.fault.kind == FaultKind::flips && !sequence.fault.fitting;
  return (sliced ? count_flips : count_block_plainly)(frame, sequence, block, frames);
}

ReplayedFrame replay_frame(const CampaignFrame& frame, const FaultSequence& sequence,
                           std::uint64_t index) {
  ReplayedFrame last;
  for_each_frame(frame, sequence, index / block_frames, index % block_frames + 1,
                 [&](std::uint64_t, const ReplayedFrame& one) { last = one; });
  return last;
}

}  // namespace biss::lab
