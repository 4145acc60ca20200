// Two lines that both matter at each change: I2C and the quadrature signals of an incremental encoder.
#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "identify/protocol_trials.hpp"

namespace biss::identify {

namespace {

// Calls `take(time, second, level)` for each change of both lines in the order of time; `second`
// says whose change it is.
template <class Take>
void merge(const Trace& first, const Trace& second, Take take) {
  std::size_t i = 0;
  std::size_t k = 0;
  while (i < first.changes.size() || k < second.changes.size()) {
    const bool from_second = i == first.changes.size() ||
                             (k < second.changes.size() && second.changes[k] < first.changes[i]);
    if (from_second) {
      take(second.changes[k], true, second.level_before(k + 1));
      ++k;
    } else {
      take(first.changes[i], false, first.level_before(i + 1));
      ++i;
    }
  }
}

// Follows START, bytes of nine clocks, repeated START, STOP.
class I2cReader {
 public:
  void clock(bool level) {
    if (level && started_) ++rises_;
    clock_ = level;
  }
  void data(bool level) {
    if (!clock_) {
      ++shifts_;
      return;
    }
    if (started_) end_part();
    if (!level) ++starts_;
    started_ = !level;
    rises_ = 0;
  }

  double bytes() const { return static_cast<double>(bytes_); }
  double parts() const { return static_cast<double>(good_ + bad_); }
  double good() const { return static_cast<double>(good_); }
  double shifts() const { return static_cast<double>(shifts_); }
  std::size_t starts() const { return starts_; }

 private:
  // Before STOP and repeated START the clock rises once more.
  void end_part() {
    const bool whole = rises_ > 1 && rises_ % 9 == 1;
    ++(whole ? good_ : bad_);
    if (whole) bytes_ += rises_ / 9;
  }

  bool clock_ = true;
  bool started_ = false;
  std::size_t rises_ = 0;
  std::size_t starts_ = 0;
  std::size_t good_ = 0;
  std::size_t bad_ = 0;
  std::size_t bytes_ = 0;
  std::size_t shifts_ = 0;
};

// A free bus has a high clock.
bool level_of_longest_gap(const Trace& line) {
  std::size_t longest = 1;
  for (std::size_t i = 2; i < line.changes.size(); ++i) {
    const auto gap = [&](std::size_t k) { return line.changes[k] - line.changes[k - 1]; };
    if (gap(i) > gap(longest)) longest = i;
  }
  return line.level_before(longest);
}

ProtocolGuess try_i2c(const Trace& clock, const Trace& data, bool inverted) {
  ProtocolGuess guess{Protocol::i2c, 0, "", clock.line, data.line, true};
  if (clock.changes.size() < 38) return guess;
  I2cReader reader;
  merge(clock, data, [&](Picoseconds, bool is_data, bool level) {
    is_data ? reader.data(level != inverted) : reader.clock(level != inverted);
  });
  if (reader.parts() < 2 || reader.bytes() < 4 || reader.shifts() < 2 * reader.parts())
    return guess;
  if (level_of_longest_gap(clock) == inverted) return guess;
  const double share = reader.good() / reader.parts();
  if (share < 0.8) return guess;
  const double certain = std::min(1.0, reader.bytes() / 8);
  guess.confidence = (share > 0.9 ? 0.95 : 0.8) * certain;
  guess.why = fmt::format("{} starts, {:.0f} of {:.0f} parts have whole bytes of nine clocks",
                          reader.starts(), reader.good(), reader.parts());
  return guess;
}

ProtocolGuess try_quadrature(const Trace& a, const Trace& b) {
  ProtocolGuess guess{Protocol::quadrature, 0, "", a.line, b.line, false};
  if (a.changes.size() < 16 || b.changes.size() < 16) return guess;
  std::size_t steps = 0;
  std::size_t alternating = 0;
  std::size_t centred = 0;
  std::size_t between = 0;
  std::optional<bool> last;
  Picoseconds last_time{};
  double last_gap = 0;
  merge(a, b, [&](Picoseconds time, bool second, bool) {
    if (last) {
      const double gap = length(last_time, time);
      ++steps;
      alternating += *last != second ? 1U : 0U;
      if (last_gap > 0 && *last != second) {
        ++between;
        const double share = gap / (gap + last_gap);
        centred += share > 0.15 && share < 0.85 ? 1U : 0U;
      }
      last_gap = gap;
    }
    last = second;
    last_time = time;
  });
  const double alternate = static_cast<double>(alternating) / static_cast<double>(steps);
  const double even =
      between == 0 ? 0 : static_cast<double>(centred) / static_cast<double>(between);
  if (alternate < 0.93 || even < 0.85) return guess;
  guess.confidence = 0.92 * std::min(1.0, static_cast<double>(steps) / 48);
  guess.why = fmt::format("{} of {} changes alternate between the lines, a quarter period apart",
                          alternating, steps);
  return guess;
}

}  // namespace

Guesses try_two_wire(const Scene& scene) {
  Guesses guesses;
  for (std::size_t i = 0; i < scene.traces.size(); ++i) {
    for (std::size_t k = 0; k < scene.traces.size(); ++k) {
      if (i == k) continue;
      for (const bool inverted : {false, true}) {
        guesses.push_back(try_i2c(scene.traces[i], scene.traces[k], inverted));
      }
      if (i < k) guesses.push_back(try_quadrature(scene.traces[i], scene.traces[k]));
    }
  }
  return guesses;
}

}  // namespace biss::identify
