#include "tests/other_lines/drawing.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace biss::other_lines {

namespace {

using Changes = std::vector<std::pair<Picoseconds, bool>>;

Changes without_repeats(const Changes& writes, bool first) {
  Changes out;
  bool level = first;
  for (std::size_t i = 0; i < writes.size(); ++i) {
    // The last one at a time counts.
    if (i + 1 < writes.size() && writes[i + 1].first == writes[i].first) continue;
    if (writes[i].second == level) continue;
    level = writes[i].second;
    out.push_back(writes[i]);
  }
  return out;
}

// As seen at the next sample; what lies between two samples is lost.
Changes sampled(const Changes& changes, Picoseconds period, Picoseconds phase, bool first) {
  Changes seen;
  for (const auto& [time, level] : changes) {
    const std::int64_t k = (time.count - phase.count + period.count - 1) / period.count;
    seen.emplace_back(Picoseconds{k * period.count + phase.count}, level);
  }
  return without_repeats(seen, first);
}

}  // namespace

double Dice::decades(double least, double most) {
  const double share = static_cast<double>(random_.bits(30)) / static_cast<double>(1U << 30U);
  return least * std::pow(most / least, share);
}

Changes Wave::changes() const {
  Changes sorted = writes_;
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  Changes plain = without_repeats(sorted, first_);
  if (pulses_.empty()) return plain;
  const auto level_at = [&](Picoseconds time) {
    const auto next = std::upper_bound(plain.begin(), plain.end(), time,
                                       [](Picoseconds t, const auto& c) { return t < c.first; });
    return next == plain.begin() ? first_ : (next - 1)->second;
  };
  Changes all = plain;
  for (const auto& [time, width] : pulses_) {
    if (level_at(time) != level_at(time + width)) continue;
    all.emplace_back(time, !level_at(time));
    all.emplace_back(time + width, level_at(time));
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  return without_repeats(all, first_);
}

namespace {

// Which lines the probe shows inverted: none, all, or any.
std::vector<bool> inversions(const Drawing& drawing, Dice& dice) {
  std::vector<bool> inverted(drawing.lines.size(), false);
  if (!drawing.may_be_inverted || dice.chance(86)) return inverted;
  if (dice.chance(50)) return std::vector<bool>(drawing.lines.size(), true);
  for (std::size_t i = 0; i < inverted.size(); ++i) inverted[i] = dice.chance(50);
  return inverted;
}

// A light, a trigger, an interrupt.
Wave company(Picoseconds end, Dice& dice) {
  Wave wave(dice.chance(50));
  const std::int64_t changes = dice.between(1, 60);
  for (std::int64_t i = 0; i < changes; ++i) {
    const Picoseconds time = end / 100'000 * dice.between(0, 100'000);
    wave.set(time, dice.chance(50));
  }
  return wave;
}

}  // namespace

Capture captured(const Drawing& alone, Dice& dice) {
  Drawing drawing = alone;
  if (drawing.may_have_company && dice.chance(15)) {
    drawing.lines.push_back(company(drawing.end, dice));
  }
  Capture capture;
  capture.note = drawing.note;
  Picoseconds phase{};
  if (dice.chance(60)) {
    const std::int64_t samples = dice.between(4, 40);
    capture.sample_period = std::max(picoseconds(200), drawing.finest / samples);
    phase = Picoseconds{dice.between(0, capture.sample_period.count - 1)};
  }
  const std::size_t idle_lines = dice.chance(25) ? static_cast<std::size_t>(dice.between(1, 5)) : 0;
  capture.lines = drawing.lines.size() + idle_lines;
  std::vector<wire::LineIndex> order(capture.lines);
  std::iota(order.begin(), order.end(), 0U);
  for (std::size_t i = order.size(); i > 1; --i) {
    std::swap(order[i - 1],
              order[static_cast<std::size_t>(dice.between(0, static_cast<std::int64_t>(i) - 1))]);
  }
  const std::vector<bool> inverse = inversions(drawing, dice);
  const Picoseconds begin =
      dice.chance(25) ? drawing.end * dice.between(1, 100) / 1000 : Picoseconds{};
  for (std::size_t i = 0; i < capture.lines; ++i) {
    const wire::LineIndex line = order[i];
    const bool drawn = i < drawing.lines.size();
    const bool inverted = drawn && inverse[i];
    bool level = drawn ? drawing.lines[i].first() : dice.chance(50);
    std::vector<wire::Edge> later;
    if (drawn) {
      Changes changes = drawing.lines[i].changes();
      if (capture.sample_period.count != 0)
        changes = sampled(changes, capture.sample_period, phase, level);
      for (const auto& [time, high] : changes) {
        if (time <= begin) {
          level = high;
        } else {
          later.push_back(
              {time - begin, line, high != inverted ? wire::Level::high : wire::Level::low});
        }
      }
    }
    capture.edges.push_back({{}, line, (level != inverted) ? wire::Level::high : wire::Level::low});
    capture.edges.insert(capture.edges.end(), later.begin(), later.end());
  }
  std::stable_sort(capture.edges.begin(), capture.edges.end(),
                   [](const wire::Edge& a, const wire::Edge& b) { return a.time < b.time; });
  capture.end = std::max(drawing.end - begin, capture.edges.back().time);
  return capture;
}

Axis::Axis(Dice& dice, unsigned bits)
    : dice_(dice),
      bits_(bits),
      start_(static_cast<double>(dice.bits(30)) / static_cast<double>(1U << 30U)) {
  if (dice.chance(20)) start_ /= 4096;  // shortly after it was set to zero
  const double second = 1e12;
  switch (dice.between(0, 4)) {
    case 0:
      break;
    case 1:
      speed_ = dice.decades(1e-5, 1e-1) / second;
      break;
    case 2:
      speed_ = dice.decades(1, 200) / second;
      break;
    case 3:
      wave_ = dice.decades(1e-4, 0.4);
      rate_ = dice.decades(1, 500) * 6.28 / second;
      break;
    default:
      noise_ = static_cast<unsigned>(dice.between(1, 4));
  }
  if (dice.chance(50)) speed_ = -speed_;
}

std::uint64_t Axis::at(Picoseconds time) {
  const auto t = static_cast<double>(time.count);
  double place = start_ + speed_ * t + wave_ * std::sin(rate_ * t);
  place -= std::floor(place);
  const auto counts = static_cast<std::uint64_t>(std::ldexp(place, static_cast<int>(bits_)));
  const std::uint64_t noise = noise_ == 0 ? 0 : dice_.bits(noise_);
  const std::uint64_t mask = bits_ >= 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << bits_) - 1U;
  return (counts + noise) & mask;
}

}  // namespace biss::other_lines
