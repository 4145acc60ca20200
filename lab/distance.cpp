#include "lab/distance.hpp"

#include <algorithm>
#include <bit>
#include <cstddef>

namespace biss::lab {
namespace {

// Extends the word bit by bit and keeps the smallest number of bits whose remainders cancel. A
// pattern may be shifted, so only patterns whose first and last bit are wrong are new.
class Growing {
 public:
  explicit Growing(std::uint32_t polynomial)
      : polynomial_(polynomial),
        degree_(static_cast<unsigned>(std::bit_width(polynomial)) - 1U),
        fewest_(std::size_t{1} << degree_, none),
        seen_(fewest_.size(), false) {
    fewest_[0] = 0;
  }

  unsigned degree() const { return degree_; }
  unsigned distance() const { return distance_; }

  void add_bit() {
    distance_ = std::min(distance_, with(remainder_));
    if (distance_ > 4) {
      take(remainder_);
    }
    seen_[remainder_] = true;
    remainder_ <<= 1U;
    if (((remainder_ >> degree_) & 1U) != 0) remainder_ ^= polynomial_;
  }

 private:
  static constexpr std::uint8_t none = 100;

  unsigned with(std::uint32_t remainder) const {
    if (seen_[remainder]) return 2;
    if ((remainder ^ 1U) < seen_.size() && seen_[remainder ^ 1U]) return 3;
    // Below 5 only 2 and 3 can be smaller, and these were just tested.
    return distance_ > 4 ? 1U + fewest_[remainder] : none;
  }

  void take(std::uint32_t remainder) {
    std::vector<std::uint8_t> next = fewest_;
    for (std::size_t sum = 0; sum < fewest_.size(); ++sum) {
      const auto one_more = static_cast<std::uint8_t>(std::min(fewest_[sum] + 1, int{none}));
      next[sum ^ remainder] = std::min(next[sum ^ remainder], one_more);
    }
    fewest_ = std::move(next);
  }

  std::uint32_t polynomial_;
  unsigned degree_;
  std::vector<std::uint8_t> fewest_;  // the fewest bits that give a remainder, by remainder
  std::vector<bool> seen_;
  std::uint32_t remainder_ = 1;
  unsigned distance_ = none;
};

}  // namespace

std::vector<DistanceRun> distance_runs(std::uint32_t polynomial) {
  Growing word(polynomial);
  for (unsigned i = 0; i < word.degree(); ++i) word.add_bit();
  std::vector<DistanceRun> runs;
  for (unsigned data_bits = 1; runs.empty() || runs.back().distance > 2; ++data_bits) {
    word.add_bit();
    if (!runs.empty() && runs.back().distance == word.distance()) continue;
    if (!runs.empty()) runs.back().data_bits_max = data_bits - 1;
    runs.push_back({word.distance(), data_bits, {}});
  }
  return runs;
}

}  // namespace biss::lab
