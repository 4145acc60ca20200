// How many bits it takes to write down the values of a field, frame after frame. The shortest way
// to write the frames down is the likeliest meaning of their bits.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <utility>
#include <vector>

namespace biss::identify {

/// The share of the data bits that counts. Every coder is a little wrong, and its error
/// grows with the number of frames.
inline constexpr double data_weight = 0.6;

/// The cost of `ones` among `count` events, whose rate is Beta(a, b).
double events_cost(double ones, double count, double a, double b);

/// The cost of a hypothesis that is one of several, each at its own cost.
double cost_of_any(std::span<const double> costs);

/// When the frames were requested, and how a value is predicted from the frames before.
class Timeline {
 public:
  static constexpr std::size_t predictors = 7;

  /// \param requests the time of each frame in requests, ascending
  explicit Timeline(const std::vector<double>& requests);
  // The weights point into the map.
  Timeline(const Timeline&) = delete;
  Timeline& operator=(const Timeline&) = delete;

  /// The cost of a number of `bits` bits, first value included. `values` are one a frame, of `bits`
  /// bits, 1 to 64.
  double cost(std::span<const std::uint64_t> values, unsigned bits) const;
  /// The same, only to compare two codings of the same bits.
  static double rough_cost(std::span<const std::uint64_t> values, unsigned bits);

 private:
  // No frame is near before this one.
  std::vector<bool> begins_;
  // The weights of the values at these times, the nearest first: their sum is the prediction.
  std::map<std::pair<std::size_t, std::vector<double>>, std::vector<double>> extrapolations_;
  // For each predictor and frame.
  std::array<std::vector<const std::vector<double>*>, predictors> weights_;
};

/// 1 in half of the frames, and changes in half: as the lowest bit of a position may.
bool is_random(std::span<const std::uint8_t> bits);
/// The cost of a flag of one bit a frame; 1 is active.
double flag_cost(std::span<const std::uint8_t> active);
/// The cost of a bit without a meaning.
double padding_cost(std::span<const std::uint8_t> bits);
/// A sign of life, the number of its request, and how many repeats of the frame before it were left
/// out.
struct CounterValue {
  std::uint64_t value = 0;
  std::uint64_t cycle = 0;
  std::uint64_t repeats_before = 0;
};
/// The cost of a sign of life of `bits` bits: it increases by 1 from request to request.
double counter_cost(std::span<const CounterValue> values, unsigned bits);
/// The cost of words of `bits` bits that are equal in most frames.
double word_cost(std::span<const std::uint64_t> words, unsigned bits);

}  // namespace biss::identify
