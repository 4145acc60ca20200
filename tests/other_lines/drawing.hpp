// Lines drawn edge by edge, for the generators of captures that are not made by the simulator.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "biss/base/units.hpp"
#include "tests/core/random.hpp"
#include "wire/edge.hpp"

namespace biss::other_lines {

/// A seeded source of the values that a real setup has. An expression draws one number at most: the
/// order within an expression is a choice of the compiler.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : random_(seed) { random_.next(); }

  std::uint64_t bits(unsigned count) { return random_.bits(count); }
  /// least…most
  std::int64_t between(std::int64_t least, std::int64_t most) {
    const auto width = static_cast<std::uint64_t>(most - least) + 1U;
    return least + static_cast<std::int64_t>(random_.next() % width);
  }
  /// Each decade is as likely as the others.
  double decades(double least, double most);
  bool chance(unsigned percent) { return random_.below(100) < percent; }
  template <class T, std::size_t N>
  T of(const T (&values)[N]) {
    return values[random_.below(static_cast<std::uint32_t>(N))];
  }

 private:
  test::Random random_;
};

/// One line; times may come in any order, and the last level written for a time counts.
class Wave {
 public:
  explicit Wave(bool level) : first_(level) {}
  void set(Picoseconds time, bool level) { writes_.emplace_back(time, level); }
  /// Short pulse of the other level.
  void pulse(Picoseconds time, Picoseconds width) { pulses_.emplace_back(time, width); }
  /// The changes in order, pulses included; the first entry is the level at the beginning.
  std::vector<std::pair<Picoseconds, bool>> changes() const;
  bool first() const { return first_; }

 private:
  bool first_;
  std::vector<std::pair<Picoseconds, bool>> writes_;
  std::vector<std::pair<Picoseconds, Picoseconds>> pulses_;
};

/// The drawing of a generator.
struct Drawing {
  std::vector<Wave> lines;
  Picoseconds end{};
  /// The shortest time that a reader has to resolve, for the choice of a sample rate.
  Picoseconds finest{};
  /// The parameters, for the report of a failure.
  std::string note;
  /// Either polarity of the pair can be on the probe.
  bool may_be_inverted = true;
  /// Other lines of the board can be on the probe too.
  bool may_have_company = true;
};

/// A capture as a file delivers it.
struct Capture {
  std::vector<wire::Edge> edges;
  std::size_t lines = 0;
  Picoseconds sample_period{};
  Picoseconds end{};
  std::string note;
};

/// Lets an analyser see the drawing: as changes or at a sample rate of 4 to 40 samples in `finest`,
/// lines in any order, now and then inverted, begun in the middle, with additional lines that are
/// idle or change now and then.
Capture captured(const Drawing& drawing, Dice& dice);

/// A position at a time: standstill, slow, fast, or with noise in its last bits.
class Axis {
 public:
  Axis(Dice& dice, unsigned bits);
  std::uint64_t at(Picoseconds time);

 private:
  Dice& dice_;
  unsigned bits_;
  double start_;
  double speed_ = 0;  // of the range, per picosecond
  double wave_ = 0;   // amplitude of a sine
  double rate_ = 0;
  unsigned noise_ = 0;
};

}  // namespace biss::other_lines
