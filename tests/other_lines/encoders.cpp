// Lines of other encoders: SSI, EnDat and others.
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "tests/other_lines/generators.hpp"

namespace biss::other_lines {

namespace {

Picoseconds from_double(double picoseconds_count) {
  return Picoseconds{static_cast<std::int64_t>(picoseconds_count)};
}

Picoseconds period_of_rate(double hertz_count) { return from_double(1e12 / hertz_count); }

// 5 ns a metre, both ways, and the encoder.
Picoseconds loop_delay(Dice& dice, std::int64_t metres_count) {
  return nanoseconds(10 * metres_count) + nanoseconds(dice.between(20, 200));
}

// A clock that idles high.
class Clock {
 public:
  Clock(Dice& dice, Picoseconds period) : dice_(dice), period_(period) {
    low_ = period * dice.between(40, 60) / 100;
    jitter_ = dice.chance(30) ? period * dice.between(0, 20) / 1000 : Picoseconds{};
  }

  /// A pulse that begins at `time`. \return its rising edge
  Picoseconds pulse(Wave& wave, Picoseconds time) {
    const Picoseconds rise = time + low_ + jitter();
    wave.set(time + jitter(), false);
    wave.set(rise, true);
    return rise;
  }

 private:
  Picoseconds jitter() {
    return jitter_.count == 0 ? Picoseconds{}
                              : Picoseconds{dice_.between(-jitter_.count, jitter_.count)};
  }
  Dice& dice_;
  Picoseconds period_;
  Picoseconds low_;
  Picoseconds jitter_;
};

std::uint64_t gray(std::uint64_t value) { return value ^ (value >> 1U); }

}  // namespace

// The first falling edge latches, each rising edge shifts a bit out, MSB first; one more clock than
// bits; then low for the monoflop time. Within that time another n + 1 clocks give the word again.
Drawing draw_ssi(Dice& dice) {
  const unsigned bits = dice.of<unsigned>({13, 24, 25, 25, 26, 32});
  const bool is_gray = dice.chance(50);
  const unsigned extra_bits = dice.chance(25) ? 1 : 0;
  const bool parity = extra_bits == 1 && dice.chance(50);
  const Picoseconds period = period_of_rate(dice.decades(100e3, 2e6));
  std::int64_t length = dice.between(0, 100);
  // The master reads at the falling edge: data has to be there by then.
  while (length > 0 && nanoseconds(10 * length + 250) > period * 2 / 5) length /= 2;
  const Picoseconds delay = std::min(loop_delay(dice, length), period * 2 / 5);
  const Picoseconds monoflop = nanoseconds(dice.between(10'000, 30'000));
  const int words = dice.chance(20) ? static_cast<int>(dice.between(2, 3)) : 1;
  const Picoseconds between_words =
      words == 1 || dice.chance(50) ? Picoseconds{} : period * dice.between(1, 2);
  const std::int64_t pause_most = dice.chance(50) ? 60 : 900;
  const Picoseconds pause = monoflop + microseconds(dice.between(5, pause_most));
  Axis axis(dice, bits);
  Clock clock(dice, period);
  Drawing drawing;
  drawing.lines = {Wave(true), Wave(true)};
  Picoseconds time = microseconds(40);
  const std::int64_t transfers = dice.between(20, 120);
  for (std::int64_t i = 0; i < transfers; ++i) {
    std::uint64_t word = axis.at(time);
    if (is_gray) word = gray(word);
    if (extra_bits != 0) {
      bool odd = false;
      for (unsigned k = 0; k < bits; ++k) odd = odd != ((word >> k & 1U) != 0);
      word = word << 1U | (parity && odd ? 1U : 0U);
    }
    Picoseconds rise{};
    for (int w = 0; w < words; ++w) {
      for (unsigned k = 0; k <= bits + extra_bits; ++k) {
        rise = clock.pulse(drawing.lines[0], time);
        const bool last = k == bits + extra_bits;
        drawing.lines[1].set(rise + delay,
                             !last && (word >> (bits + extra_bits - 1 - k) & 1U) != 0);
        time += period;
      }
      if (w + 1 < words) time += between_words < monoflop * 4 / 5 ? between_words : Picoseconds{};
    }
    const Picoseconds off = monoflop * dice.between(985, 1015) / 1000;
    drawing.lines[1].set(rise + delay + off, true);
    time = rise + off + pause;
  }
  drawing.end = time;
  drawing.finest = period;
  drawing.note =
      fmt::format("ssi {} bits, {}, {} words, {} ns, delay {} ns", bits + extra_bits,
                  is_gray ? "Gray" : "binary", words, period.count / 1000, delay.count / 1000);
  return drawing;
}

namespace {

unsigned endat_crc(const std::vector<bool>& bits) {
  // Five flip-flops, all 1 at first; the feedback enters the first, second and fourth.
  std::array<bool, 5> ff{true, true, true, true, true};
  for (const bool bit : bits) {
    const bool feed = ff[4] != bit;
    ff = {feed, ff[0] != feed, ff[1], ff[2] != feed, ff[3]};
  }
  unsigned crc = 0;
  for (int i = 4; i >= 0; --i) crc = crc << 1U | (ff[static_cast<std::size_t>(i)] ? 0U : 1U);
  return crc;
}

void append_with_crc(std::vector<bool>& out, const std::vector<bool>& bits) {
  out.insert(out.end(), bits.begin(), bits.end());
  const unsigned crc = endat_crc(bits);
  for (int i = 4; i >= 0; --i) out.push_back((crc >> i & 1U) != 0);
}

}  // namespace

// 2 T, six mode bits from the master, 2 T, START, F1 (and F2), position LSB first, CRC, additional
// information; high for the recovery time, then low.
Drawing draw_endat(Dice& dice) {
  const bool is_22 = dice.chance(65);
  const auto bits = static_cast<unsigned>(dice.between(13, 37));
  const Picoseconds period =
      period_of_rate(is_22 ? dice.decades(100e3, 16e6) : dice.decades(100e3, 2e6));
  std::int64_t length = dice.between(0, 100);
  if (period < nanoseconds(125)) length /= 5;
  Picoseconds delay = loop_delay(dice, length);
  if (!is_22) delay = std::min(delay, period * 2 / 5);
  const bool short_recovery = is_22 && period < nanoseconds(1000) && dice.chance(60);
  const Picoseconds recovery = short_recovery ? nanoseconds(dice.between(1'250, 3'750))
                                              : nanoseconds(dice.between(10'000, 30'000));
  const int additional = is_22 ? static_cast<int>(dice.between(0, 2)) : 0;
  const unsigned mode = is_22 ? (additional == 0 && dice.chance(50)
                                     ? 0x07U
                                     : dice.of<unsigned>({0x38, 0x38, 0x09, 0x1B, 0x24}))
                              : 0x07U;
  const bool two_flags = is_22 && mode != 0x07U;
  const bool at_falling = dice.chance(75);
  const Picoseconds calculation = nanoseconds(dice.between(500, 5'000));
  const std::int64_t interval_most = dice.chance(50) ? 80 : 500;
  const Picoseconds interval = microseconds(dice.between(20, interval_most));
  Axis axis(dice, bits);
  Clock clock(dice, period);
  Drawing drawing;
  drawing.lines = {Wave(true), Wave(false)};
  Picoseconds time = microseconds(40);
  const std::int64_t transfers = dice.between(20, 100);
  for (std::int64_t i = 0; i < transfers; ++i) {
    // No error: F1 is 0, F2 is 1.
    std::vector<bool> word{false};
    if (two_flags) word.push_back(true);
    const std::uint64_t position = axis.at(time);
    for (unsigned k = 0; k < bits; ++k) word.push_back((position >> k & 1U) != 0);
    std::vector<bool> sent{true};
    append_with_crc(sent, word);
    for (int a = 0; a < additional && two_flags; ++a) {
      std::vector<bool> info;
      const std::uint64_t value =
          std::uint64_t{0x40} << 16U | (dice.chance(50) ? position & 0xFFFFU : 0x1234U);
      for (int k = 23; k >= 0; --k) info.push_back((value >> k & 1U) != 0);
      sent.push_back(true);
      append_with_crc(sent, info);
    }
    const Picoseconds begin = time;
    // START waits for the position.
    const std::int64_t wait =
        std::max<std::int64_t>(0, (calculation.count - 10 * period.count) / period.count + 1);
    const auto clocks =
        static_cast<std::int64_t>(10 + wait) + static_cast<std::int64_t>(sent.size());
    Picoseconds rise{};
    for (std::int64_t k = 0; k < clocks; ++k) {
      rise = clock.pulse(drawing.lines[0], time);
      if (k >= 2 && k < 8) {
        drawing.lines[1].set(at_falling ? time : rise - period / 10, (mode >> (7 - k) & 1U) != 0);
      }
      if (k == 8) drawing.lines[1].set(time, false);
      const std::int64_t at = k - 10 - wait;
      if (at >= 0) drawing.lines[1].set(rise + delay, sent[static_cast<std::size_t>(at)]);
      time += period;
    }
    // With a long cable the master needs more clocks than the encoder's bits; they find it at 1.
    for (std::int64_t k = 0; k < delay.count / period.count; ++k) {
      rise = clock.pulse(drawing.lines[0], time);
      time += period;
    }
    const Picoseconds last = begin + (clocks - 1) * period + period / 2 + delay;
    drawing.lines[1].set(last + period, true);
    drawing.lines[1].set(std::max(last + period * 2, rise + recovery), false);
    time = std::max(last + period * 3, rise + recovery) + interval;
  }
  drawing.end = time;
  drawing.finest = period;
  drawing.note = fmt::format("endat {} mode {:06b}, {} bits, {} additional, {} ns, delay {} ns",
                             is_22 ? "2.2" : "2.1", mode, bits, additional, period.count / 1000,
                             delay.count / 1000);
  return drawing;
}

namespace {

// 5b/6b and 3b/4b of the published 8b/10b code, for a running disparity of -1.
constexpr std::array<unsigned, 32> six_of{
    0b100111, 0b011101, 0b101101, 0b110001, 0b110101, 0b101001, 0b011001, 0b111000,
    0b111001, 0b100101, 0b010101, 0b110100, 0b001101, 0b101100, 0b011100, 0b010111,
    0b011011, 0b100011, 0b010011, 0b110010, 0b001011, 0b101010, 0b011010, 0b111010,
    0b110011, 0b100110, 0b010110, 0b110110, 0b001110, 0b101110, 0b011110, 0b101011};
constexpr std::array<unsigned, 8> four_of{0b1011, 0b1001, 0b0101, 0b1100,
                                          0b1101, 0b1010, 0b0110, 0b1110};

int ones(unsigned value) { return __builtin_popcount(value); }

// Appends a byte; the disparity is kept at -1 or +1.
void append_8b10b(std::vector<bool>& bits, unsigned byte, int& disparity) {
  unsigned six = six_of[byte & 31U];
  if (disparity > 0 && (ones(six) != 3 || six == 0b111000)) six = ~six & 63U;
  if (ones(six) != 3) disparity = -disparity;
  unsigned four = four_of[byte >> 5U & 7U];
  const bool alternate = (byte >> 5U & 7U) == 7 &&
                         ((disparity < 0 && (six & 3U) == 3) || (disparity > 0 && (six & 3U) == 0));
  if (alternate) four = 0b0111;
  if (disparity > 0 && (ones(four) != 2 || four == 0b1100)) four = ~four & 15U;
  if (ones(four) != 2) disparity = -disparity;
  for (int i = 5; i >= 0; --i) bits.push_back((six >> i & 1U) != 0);
  for (int i = 3; i >= 0; --i) bits.push_back((four >> i & 1U) != 0);
}

}  // namespace

// 9.375 Mbit/s without a pause, on one line or on both of the pair.
Drawing draw_dsl(Dice& dice) {
  Drawing drawing;
  const bool both = dice.chance(60);
  drawing.lines.assign(both ? 2 : 1, Wave(true));
  if (both) drawing.lines[1] = Wave(false);
  std::vector<bool> bits;
  int disparity = -1;
  const std::int64_t bytes = dice.between(200, 1200);
  for (std::int64_t i = 0; i < bytes; ++i)
    append_8b10b(bits, static_cast<unsigned>(dice.bits(8)), disparity);
  Picoseconds time = microseconds(1);
  for (std::size_t i = 0; i < bits.size(); ++i) {
    const Picoseconds at =
        time + Picoseconds{static_cast<std::int64_t>(static_cast<double>(i) * 1e12 / 9.375e6)};
    drawing.lines[0].set(at, bits[i]);
    if (both) drawing.lines[1].set(at, !bits[i]);
    drawing.end = at;
  }
  drawing.finest = nanoseconds(106);
  drawing.note = fmt::format("dsl on {} lines", both ? 2 : 1);
  return drawing;
}

namespace {

// A word of an asynchronous line, LSB first. \return its end
Picoseconds put_word(Wave& wave, Picoseconds time, double bit, std::uint64_t value, unsigned bits) {
  wave.set(time, false);
  for (unsigned k = 0; k < bits; ++k) {
    wave.set(time + from_double((k + 1) * bit), (value >> k & 1U) != 0);
  }
  wave.set(time + from_double((bits + 1) * bit), true);
  return time + from_double((bits + 2) * bit);
}

}  // namespace

// 2.5 Mbit/s: a request of one word, 3 us later the answer: control field, status, data, checksum.
// Panasonic's encoders use the same words.
Drawing draw_tamagawa(Dice& dice) {
  struct Id {
    unsigned control;
    unsigned data_words;
  };
  const Id id = dice.of<Id>({{0x02, 3}, {0x8A, 3}, {0x92, 1}, {0x1A, 8}, {0x2A, 5}, {0x52, 6}});
  const double bit = 400e3 * (1 + static_cast<double>(dice.between(-3, 3)) * 1e-4);
  const std::int64_t length = dice.between(0, 50);
  const Picoseconds delay = loop_delay(dice, length);
  const Picoseconds turn = delay + nanoseconds(dice.between(2'000, 6'000));
  const std::int64_t interval_most = dice.chance(50) ? 70 : 500;
  const Picoseconds interval = microseconds(dice.between(40, interval_most));
  const bool apart = dice.chance(25);
  const bool enable = dice.chance(30);
  Axis axis(dice, 23);
  Drawing drawing;
  drawing.lines.assign(apart ? 2 : 1, Wave(true));
  if (enable || !apart) drawing.lines.emplace_back(false);
  Wave& from_master = drawing.lines[0];
  Wave& from_encoder = drawing.lines[apart ? 1 : 0];
  Picoseconds time = microseconds(30);
  const std::int64_t transfers = dice.between(20, 120);
  for (std::int64_t i = 0; i < transfers; ++i) {
    if (enable) drawing.lines.back().set(time - nanoseconds(400), true);
    Picoseconds at = put_word(from_master, time, bit, id.control, 8);
    if (enable) drawing.lines.back().set(at + nanoseconds(100), false);
    at += turn;
    const std::uint64_t position = axis.at(time);
    unsigned sum = id.control;
    at = put_word(from_encoder, at, bit, id.control, 8);
    at = put_word(from_encoder, at, bit, 0, 8);
    for (unsigned k = 0; k < id.data_words; ++k) {
      const unsigned value = k < 3    ? static_cast<unsigned>(position >> (8 * k) & 0xFFU)
                             : k == 3 ? 0x17U
                                      : (k * 0x35U) & 0xFFU;
      sum ^= value;
      at = put_word(from_encoder, at, bit, value, 8);
    }
    at = put_word(from_encoder, at, bit, sum, 8);
    time = at + interval;
  }
  drawing.end = time;
  drawing.finest = nanoseconds(400);
  drawing.note = fmt::format("tamagawa id {:02x}{}", id.control, apart ? " on two lines" : "");
  return drawing;
}

// Words of 18 bits: start, 16 bits, stop. A request with its CRC of 3 bits, an answer of the
// information field and data with a CRC of 8 bits.
Drawing draw_nikon(Dice& dice) {
  const double bit = 1e6 / dice.of<double>({2.5, 4, 8});
  const Picoseconds turn = nanoseconds(dice.between(1'500, 6'000));
  const Picoseconds interval = microseconds(dice.between(40, 300));
  const auto data_words = static_cast<unsigned>(dice.between(2, 4));
  Axis axis(dice, 40);
  Drawing drawing;
  drawing.lines = {Wave(true), Wave(dice.chance(50))};
  Picoseconds time = microseconds(30);
  const std::int64_t transfers = dice.between(20, 100);
  for (std::int64_t i = 0; i < transfers; ++i) {
    Picoseconds at = put_word(drawing.lines[0], time, bit, 0x4102, 16) + turn;
    at = put_word(drawing.lines[0], at, bit, 0x0102, 16);
    std::uint64_t crc = 0;
    const std::uint64_t position = axis.at(time);
    for (unsigned k = 0; k < data_words; ++k) {
      std::uint64_t value = position >> (16 * k) & 0xFFFFU;
      const bool last = k + 1 == data_words;
      for (unsigned b = 0; b < (last ? 8U : 16U); ++b) {
        const bool feed = (crc >> 7U & 1U) != (value >> b & 1U);
        crc = (crc << 1U & 0xFFU) ^ (feed ? 0x1DU : 0U);
      }
      if (last) value = (value & 0xFFU) | crc << 8U;
      at = put_word(drawing.lines[0], at, bit, value, 16);
    }
    time = at + interval;
  }
  drawing.end = time;
  drawing.finest = from_double(bit);
  drawing.note = fmt::format("nikon {:.1f} ns, {} data words", bit / 1000, data_words);
  return drawing;
}

// Two square waves a quarter period apart, at a speed that changes, forwards and back.
Drawing draw_quadrature(Dice& dice) {
  Drawing drawing;
  drawing.lines = {Wave(false), Wave(false)};
  if (dice.chance(30)) drawing.lines.emplace_back(false);
  const double step = dice.decades(1e6, 1e9);
  const double change = static_cast<double>(dice.between(0, 30)) / 100;
  const bool turns_back = dice.chance(30);
  double time = 5e6;
  int state = 0;
  const std::int64_t steps = dice.between(200, 3000);
  const std::int64_t back = steps / 2;
  for (std::int64_t i = 0; i < steps; ++i) {
    const double slow = 1 + change * static_cast<double>(i) / static_cast<double>(steps);
    time += step * slow * (1 + static_cast<double>(dice.between(-80, 80)) / 1000);
    state = (state + (turns_back && i > back ? 3 : 1)) % 4;
    drawing.lines[0].set(from_double(time), state == 1 || state == 2);
    drawing.lines[1].set(from_double(time), state == 2 || state == 3);
    if (drawing.lines.size() > 2 && i % 1000 == 500)
      drawing.lines[2].pulse(from_double(time), from_double(step));
  }
  drawing.end = from_double(time + step);
  drawing.finest = from_double(step);
  drawing.note = fmt::format("quadrature {:.0f} ns a step", step / 1000);
  return drawing;
}

}  // namespace biss::other_lines
