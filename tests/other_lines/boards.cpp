// Lines of buses on boards: SPI, I2C, UART, Modbus.
#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "tests/other_lines/generators.hpp"

namespace biss::other_lines {

namespace {

Picoseconds picoseconds_of(double count) { return Picoseconds{static_cast<std::int64_t>(count)}; }

// What a slave answers.
enum class Content { sensor, counter_with_crc, parity, slow_with_zeros, status_first, random };

class Answers {
 public:
  Answers(Dice& dice, unsigned bits) : dice_(dice), axis_(dice, std::min(bits, 40U)), bits_(bits) {
    content_ = dice.of<Content>({Content::sensor, Content::counter_with_crc, Content::parity,
                                 Content::slow_with_zeros, Content::slow_with_zeros,
                                 Content::status_first, Content::random});
    shift_ = static_cast<unsigned>(dice.between(2, 7));
    status_ = dice.bits(3);
  }

  std::uint64_t next(Picoseconds time) {
    const std::uint64_t value = axis_.at(time);
    switch (content_) {
      case Content::sensor:
        return value;
      case Content::counter_with_crc: {
        if (bits_ < 16) return value;
        const std::uint64_t data = value >> 8U;
        return data << 8U | crc8(data, bits_ - 8);
      }
      case Content::parity: {
        const std::uint64_t data = value >> 1U;
        return data << 1U | static_cast<unsigned>(__builtin_popcountll(data) & 1);
      }
      // Left zeros, right zeros: a converter of fewer bits.
      case Content::slow_with_zeros:
        return value >> shift_ & ~std::uint64_t{dice_zeros()};
      case Content::status_first:
        return (value >> 3U | status_ << (bits_ - 3)) & mask();
      default:
        return dice_.bits(std::min(bits_, 40U));
    }
  }

 private:
  std::uint64_t mask() const { return (std::uint64_t{1} << bits_) - 1U; }
  unsigned dice_zeros() const { return shift_ % 2 == 0 ? 3U : 0U; }
  static std::uint64_t crc8(std::uint64_t data, unsigned bits) {
    std::uint64_t crc = 0;
    for (unsigned k = bits; k-- > 0;) {
      const bool feed = (crc >> 7U & 1U) != (data >> k & 1U);
      crc = (crc << 1U & 0xFFU) ^ (feed ? 0x07U : 0U);
    }
    return crc;
  }
  Dice& dice_;
  Axis axis_;
  unsigned bits_;
  Content content_{};
  unsigned shift_ = 0;
  std::uint64_t status_ = 0;
};

}  // namespace

// All four modes; words of bytes, with or without gaps; select and MOSI may be on the probe.
Drawing draw_spi(Dice& dice) {
  const unsigned bits = dice.of<unsigned>({8, 16, 16, 24, 24, 32, 40, 48});
  const auto mode = static_cast<unsigned>(dice.between(0, 3));
  const bool idle = mode >= 2;
  const bool changes_first = mode % 2 == 1;
  const Picoseconds period = picoseconds_of(1e12 / dice.decades(50e3, 20e6));
  const Picoseconds byte_gap = dice.chance(30) ? period * dice.between(5, 30) / 10 : Picoseconds{};
  const bool has_select = dice.chance(60);
  const bool has_mosi = dice.chance(50);
  // MISO without a driver: pulled up, pulled down, or as it was.
  const auto undriven = dice.between(0, 2);
  const Picoseconds out = std::min(nanoseconds(dice.between(5, 60)), period * 4 / 10);
  const Picoseconds setup = std::max(nanoseconds(50), period * dice.between(3, 30) / 10);
  Picoseconds interval = period * dice.between(4, 10);
  const std::int64_t interval_most = dice.chance(50) ? 50 : 1000;
  interval += microseconds(dice.between(1, interval_most));
  const unsigned command_bits = has_mosi && dice.chance(50) ? 8 : 0;
  Answers answers(dice, bits);
  Drawing drawing;
  drawing.lines = {Wave(idle), Wave(undriven == 0)};
  if (has_mosi) drawing.lines.emplace_back(false);
  if (has_select) drawing.lines.emplace_back(true);
  const std::size_t select_line = drawing.lines.size() - 1;
  const std::uint64_t command = dice.bits(8) | 0x80U;
  bool last = undriven == 0;
  Picoseconds time = microseconds(20);
  const std::int64_t transfers = dice.between(20, 150);
  for (std::int64_t i = 0; i < transfers; ++i) {
    const std::uint64_t answer = answers.next(time);
    const unsigned all = command_bits + bits;
    const auto miso = [&](unsigned k) {
      return k >= command_bits && (answer >> (all - 1 - k) & 1U) != 0;
    };
    const auto mosi = [&](unsigned k) { return k < 8 && (command >> (7 - k) & 1U) != 0; };
    if (has_select) drawing.lines[select_line].set(time, false);
    if (!changes_first) {
      drawing.lines[1].set(time + out, miso(0));
      if (has_mosi) drawing.lines[2].set(time + nanoseconds(10), mosi(0));
    } else if (undriven != 2) {
      // The driver is on before the first bit is.
      drawing.lines[1].set(time + out, false);
    }
    Picoseconds at = time + setup;
    for (unsigned k = 0; k < all; ++k) {
      drawing.lines[0].set(at, !idle);
      drawing.lines[0].set(at + period / 2, idle);
      if (changes_first) {
        drawing.lines[1].set(at + out, miso(k));
        if (has_mosi) drawing.lines[2].set(at + nanoseconds(5), mosi(k));
      } else if (k + 1 < all) {
        drawing.lines[1].set(at + period / 2 + out, miso(k + 1));
        if (has_mosi) drawing.lines[2].set(at + period / 2 + nanoseconds(5), mosi(k + 1));
      }
      last = miso(k);
      at += period;
      if (k % 8 == 7 && k + 1 < all) at += byte_gap;
    }
    at += setup;
    if (has_select) drawing.lines[select_line].set(at, true);
    drawing.lines[1].set(at + out, undriven == 0 ? true : undriven == 1 ? false : last);
    time = at + interval;
  }
  drawing.end = time;
  drawing.finest = period;
  drawing.note = fmt::format("spi mode {}, {} bits, {} ns, gap {} ns{}{}, undriven {}", mode,
                             command_bits + bits, period.count / 1000, byte_gap.count / 1000,
                             has_select ? ", select" : "", has_mosi ? ", mosi" : "", undriven);
  return drawing;
}

// A register read: address, register, repeated START, address, bytes; or a write.
Drawing draw_i2c(Dice& dice) {
  const double rate = dice.of<double>({100e3, 100e3, 400e3, 400e3, 1e6, 3.4e6});
  const double slower = static_cast<double>(dice.between(0, 150)) / 1000;
  const Picoseconds period = picoseconds_of(1e12 / rate * (1 + slower));
  const Picoseconds hold = period * dice.between(5, 25) / 100;
  const bool stretches = dice.chance(30);
  const auto read_bytes = static_cast<unsigned>(dice.between(1, 8));
  const std::uint64_t address = dice.bits(7);
  const Picoseconds interval = microseconds(dice.between(20, 1000));
  Axis axis(dice, 16);
  Drawing drawing;
  drawing.lines = {Wave(true), Wave(true)};
  drawing.may_be_inverted = false;
  Wave& clock = drawing.lines[0];
  Wave& data = drawing.lines[1];
  Picoseconds time = microseconds(30);
  const auto put_bit = [&](bool bit) {
    clock.set(time, false);
    data.set(time + hold, bit);
    clock.set(time + period / 2, true);
    time += period;
  };
  const auto put_byte = [&](std::uint64_t value, bool acknowledged) {
    for (int k = 7; k >= 0; --k) put_bit((value >> k & 1U) != 0);
    put_bit(!acknowledged);
    if (stretches && dice.chance(40)) {
      // The slave holds the clock down after a byte.
      clock.set(time, false);
      const Picoseconds held = period * dice.between(5, 60) / 10;
      time += held;
      clock.set(time - held / 10, false);
    }
  };
  const auto start = [&](bool repeated) {
    if (repeated) {
      clock.set(time, false);
      data.set(time + hold, true);
      clock.set(time + period / 2, true);
      time += period;
    }
    data.set(time, false);
    time += period / 2;
  };
  const std::int64_t transfers = dice.between(8, 60);
  for (std::int64_t i = 0; i < transfers; ++i) {
    const std::uint64_t value = axis.at(time);
    start(false);
    put_byte(address << 1U, true);
    put_byte(0x0E, true);
    if (dice.chance(80)) {
      start(true);
      put_byte(address << 1U | 1U, true);
      for (unsigned k = 0; k < read_bytes; ++k) {
        put_byte(k < 2 ? value >> (8 * (1 - k)) & 0xFFU : dice.bits(3), k + 1 < read_bytes);
      }
    } else {
      put_byte(dice.bits(8), true);
    }
    clock.set(time, false);
    data.set(time + hold, false);
    clock.set(time + period / 2, true);
    data.set(time + period, true);
    time += period + interval;
  }
  drawing.end = time;
  drawing.finest = period / 2;
  drawing.note = fmt::format("i2c {} ns, {} bytes read{}", period.count / 1000, read_bytes,
                             stretches ? ", stretches" : "");
  return drawing;
}

namespace {

struct Framing {
  unsigned data_bits = 8;
  char parity = 'N';
  unsigned stop_bits = 1;
};

Picoseconds put_uart(Wave& wave, Picoseconds time, double bit, unsigned value,
                     const Framing& framing) {
  unsigned at = 0;
  const auto put = [&](bool level) {
    wave.set(time + picoseconds_of(at * bit), level);
    ++at;
  };
  put(false);
  bool odd = false;
  for (unsigned k = 0; k < framing.data_bits; ++k) {
    const bool one = (value >> k & 1U) != 0;
    odd = odd != one;
    put(one);
  }
  if (framing.parity != 'N') put(framing.parity == 'E' ? odd : !odd);
  put(true);
  return time + picoseconds_of((at + framing.stop_bits - 1) * bit);
}

constexpr std::string_view log_text =
    "[00:01:32.118] motor: speed 1480 rpm, torque 2.31 Nm, temp 41 "
    "C\r\n$GPGGA,092750.000,5321.6802,N"
    ",00630.3372,W,1,8,1.03,61.7,M,55.2,M,,*76\r\nOK\r\n> read position\r\nposition = 0x00A31F\r\n";

}  // namespace

// One line that sends, or two that send in turn or at once: text or bytes.
Drawing draw_uart(Dice& dice) {
  const double rate = dice.of<double>(
      {9600, 19200, 38400, 57600, 115200, 115200, 230400, 460800, 921600, 1e6, 2e6, 3e6});
  const double bit = 1e12 / rate * (1 + static_cast<double>(dice.between(-20, 20)) / 1000);
  const Framing framing = dice.of<Framing>(
      {{8, 'N', 1}, {8, 'N', 1}, {8, 'N', 1}, {8, 'E', 1}, {7, 'E', 1}, {8, 'N', 2}, {8, 'O', 1}});
  const bool text = dice.chance(50);
  const bool both = dice.chance(70);
  Drawing drawing;
  drawing.lines = {Wave(true), Wave(true)};
  Picoseconds end{};
  for (std::size_t line = 0; line < (both ? 2U : 1U); ++line) {
    Picoseconds time = picoseconds_of(bit * static_cast<double>(dice.between(30, 300)));
    const std::int64_t messages = dice.between(4, 30);
    auto at = static_cast<std::size_t>(dice.between(0, 100));
    for (std::int64_t i = 0; i < messages; ++i) {
      const std::int64_t bytes = dice.between(3, 40);
      for (std::int64_t k = 0; k < bytes; ++k) {
        const auto letter = static_cast<unsigned char>(log_text[at++ % log_text.size()]);
        const unsigned value = text ? letter : static_cast<unsigned>(dice.bits(8));
        time = put_uart(drawing.lines[line], time, bit, value, framing);
        if (dice.chance(10))
          time += picoseconds_of(bit * static_cast<double>(dice.between(0, 40)) / 10);
      }
      time += picoseconds_of(bit * static_cast<double>(dice.between(15, 400)));
    }
    end = std::max(end, time);
  }
  drawing.end = end;
  drawing.finest = picoseconds_of(bit);
  drawing.note = fmt::format("uart {:.0f} Bd {}{}{} {}{}", rate, framing.data_bits, framing.parity,
                             framing.stop_bits, text ? "text" : "bytes", both ? ", both ways" : "");
  return drawing;
}

// RS-485: request and answer on one pair, with the driver's enable line.
Drawing draw_modbus(Dice& dice) {
  const double bit = 1e12 / dice.of<double>({9600, 19200, 38400, 115200});
  const Framing framing = dice.of<Framing>({{8, 'E', 1}, {8, 'N', 1}, {8, 'N', 2}});
  Drawing drawing;
  drawing.lines = {Wave(true), Wave(false)};
  Axis axis(dice, 16);
  Picoseconds time = picoseconds_of(50 * bit);
  const std::int64_t messages = dice.between(10, 40);
  for (std::int64_t i = 0; i < messages; ++i) {
    drawing.lines[1].set(time - picoseconds_of(bit), true);
    for (const unsigned value : {0x01U, 0x03U, 0x00U, 0x10U, 0x00U, 0x02U, 0xC5U, 0xCEU}) {
      time = put_uart(drawing.lines[0], time, bit, value, framing);
    }
    drawing.lines[1].set(time, false);
    time += picoseconds_of(bit * static_cast<double>(dice.between(40, 200)));
    const std::uint64_t value = axis.at(time);
    for (const std::uint64_t each :
         {std::uint64_t{1}, std::uint64_t{3}, std::uint64_t{4}, value >> 8U & 0xFFU, value & 0xFFU,
          std::uint64_t{0}, value * 31 & 0xFFU, value * 17 & 0xFFU}) {
      time = put_uart(drawing.lines[0], time, bit, static_cast<unsigned>(each), framing);
    }
    time += picoseconds_of(bit * static_cast<double>(dice.between(60, 600)));
  }
  drawing.end = time;
  drawing.finest = picoseconds_of(bit);
  drawing.note =
      fmt::format("modbus {:.0f} Bd {}{}", 1e12 / bit, framing.data_bits, framing.parity);
  return drawing;
}

// One or two outputs of a timer: the duty follows a sine or stays.
Drawing draw_pwm(Dice& dice) {
  const double period = dice.decades(1e7, 1e9);
  const bool complementary = dice.chance(50);
  const bool moves = dice.chance(70);
  Drawing drawing;
  drawing.may_have_company = false;
  drawing.lines = {Wave(false), Wave(complementary)};
  double time = 5e6;
  const std::int64_t pulses = dice.between(100, 1500);
  double duty = static_cast<double>(dice.between(10, 90)) / 100;
  double other = static_cast<double>(dice.between(10, 90)) / 100;
  for (std::int64_t i = 0; i < pulses; ++i) {
    if (moves) {
      duty += static_cast<double>(dice.between(-30, 30)) / 1000;
      other += static_cast<double>(dice.between(-30, 30)) / 1000;
      duty = std::clamp(duty, 0.05, 0.95);
      other = std::clamp(other, 0.05, 0.95);
    }
    drawing.lines[0].set(picoseconds_of(time), true);
    drawing.lines[0].set(picoseconds_of(time + duty * period), false);
    if (complementary) {
      const double dead = period * 0.01;
      drawing.lines[1].set(picoseconds_of(time - dead), false);
      drawing.lines[1].set(picoseconds_of(time + duty * period + dead), true);
    } else {
      drawing.lines[1].set(picoseconds_of(time), true);
      drawing.lines[1].set(picoseconds_of(time + other * period), false);
    }
    time += period;
  }
  drawing.end = picoseconds_of(time);
  drawing.finest = picoseconds_of(period / 4);
  drawing.note =
      fmt::format("pwm {:.1f} us{}", period / 1e6, complementary ? ", complementary" : "");
  return drawing;
}

// The master of BiSS or SSI without an encoder, SPI with a stuck line, or a clock without a pause.
Drawing draw_clock_alone(Dice& dice) {
  const Picoseconds period = picoseconds_of(1e12 / dice.decades(80e3, 10e6));
  const auto kind = dice.between(0, 3);
  const bool idle = kind < 2 || dice.chance(50);
  const bool stuck = dice.chance(50);
  const std::int64_t clocks = kind == 0   ? dice.between(30, 90)
                              : kind == 1 ? dice.between(14, 33)
                                          : 8 * dice.between(1, 4);
  Picoseconds pause = period * dice.between(3, 10);
  pause += microseconds(dice.between(5, 500));
  Drawing drawing;
  drawing.may_have_company = false;
  drawing.lines = {Wave(idle), Wave(stuck)};
  Picoseconds time = microseconds(20);
  const std::int64_t bursts = dice.between(10, 120);
  for (std::int64_t i = 0; i < bursts; ++i) {
    for (std::int64_t k = 0; k < clocks; ++k) {
      drawing.lines[0].set(time, !idle);
      drawing.lines[0].set(time + period / 2, idle);
      time += period;
    }
    if (kind != 3) time += pause;
  }
  drawing.end = time;
  drawing.finest = period;
  drawing.note = fmt::format("clock alone, {} clocks, {} ns{}", clocks, period.count / 1000,
                             kind == 3 ? ", no pause" : "");
  return drawing;
}

// Edges without a sender: an open input, bursts of ringing, or a clock coupled to the other line.
Drawing draw_noise(Dice& dice) {
  Drawing drawing;
  drawing.may_have_company = false;
  for (int i = 0; i < 2; ++i) drawing.lines.emplace_back(dice.chance(50));
  const auto kind = dice.between(0, 2);
  const double mean = dice.decades(1e5, 1e8);
  double time = 1e6;
  drawing.finest = picoseconds_of(mean / 4);
  const std::int64_t events = dice.between(150, 1500);
  for (std::int64_t i = 0; i < events; ++i) {
    const double wait = mean * dice.decades(0.02, 4);
    time += wait;
    const auto line = static_cast<std::size_t>(dice.between(0, 1));
    if (kind == 0) {
      const Picoseconds at = picoseconds_of(time);
      drawing.lines[line].set(at, dice.chance(50));
    } else if (kind == 1) {
      // Ringing: shorter and shorter pulses on both lines.
      time += 30 * wait;
      double width = mean * 0.3;
      for (int k = 0; k < 6; ++k) {
        drawing.lines[0].pulse(picoseconds_of(time), picoseconds_of(width));
        if (dice.chance(60))
          drawing.lines[1].pulse(picoseconds_of(time + width * 0.2), picoseconds_of(width * 0.7));
        time += 2.3 * width;
        width *= 0.8;
      }
    } else {
      drawing.lines[1].pulse(picoseconds_of(time), picoseconds_of(mean * dice.decades(0.01, 0.3)));
      if (dice.chance(50))
        drawing.lines[0].pulse(picoseconds_of(time + mean * 0.01), picoseconds_of(mean * 0.02));
    }
  }
  drawing.end = picoseconds_of(time + mean);
  drawing.note = fmt::format("noise of kind {}, {:.2f} us", kind, mean / 1e6);
  return drawing;
}

Drawing draw_idle(Dice& dice) {
  Drawing drawing;
  drawing.may_have_company = false;
  for (int i = 0; i < 2; ++i) drawing.lines.emplace_back(dice.chance(50));
  drawing.end = milliseconds(dice.between(1, 100));
  drawing.finest = microseconds(1);
  drawing.note = "idle";
  return drawing;
}

}  // namespace biss::other_lines
