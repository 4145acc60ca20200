// The mistakes of docs/guide-firmware.md, in its order: each is made on purpose and has one result.
// The line is made here, edge by edge, without the code under test: an encoder that sees the edges
// of MA, a cable with a delay, and an SPI that samples.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "biss/axis/encoder_axis.hpp"
#include "biss/catalogue/catalogue.hpp"
#include "biss/frame/codec.hpp"
#include "biss/frame/format_text.hpp"
#include "tests/core/safety_bench.hpp"

namespace biss::mistakes {

// ---- The board and its encoder

inline constexpr std::int64_t no_time = -1;

/// All that happens between the request and the bytes in memory. The defaults work.
struct Wiring {
  bool answers = true;
  bool stuck_low = false;
  bool ma_inverted = false;
  bool slo_inverted = false;
  std::int64_t delay_ps = 370'000;
  /// From LAT until the encoder has its answer.
  std::int64_t processing_ps = 4'000'000;
  bool idle_high = true;  // CPOL = 1
  bool samples_on_rising = true;
  std::int64_t period_ps = 100'000;
  std::int64_t pause_ps = 0;  // between two bytes
  bool lsb_first = false;
  bool swapped_words = false;
  int shift = 0;  // bits that are missing at the beginning, or too many if it is negative
  /// Two encoders in a chain.
  bool two = false;
  bool error = false;
  bool dma_writes = true;
  /// The bytes that the processor sees.
  std::size_t seen_bytes = 1'000;
};

/// An encoder of 26 bits, a cable, and an SPI at its end.
class Line {
 public:
  std::uint32_t position = 0x123'4567;

  /// Receives bytes; the first clock is at `begin_ps`.
  void transfer(const Wiring& wiring, std::int64_t begin_ps, std::span<std::uint8_t> into) {
    const std::size_t bits = into.size() * 8;
    std::size_t edges = 0;
    for (std::size_t k = 0; k < bits; ++k) {
      const std::int64_t sample_ps = edge(wiring, begin_ps, k, wiring.samples_on_rising);
      for (; edges < bits; ++edges) {
        const std::int64_t arrives_ps =
            edge(wiring, begin_ps, edges, !wiring.ma_inverted) + wiring.delay_ps;
        // A change at the moment of sampling is seen or not.
        toss_ = toss_ * 1'103'515'245U + 12'345U;
        if (arrives_ps > sample_ps || (arrives_ps == sample_ps && (toss_ >> 30U & 1U) != 0)) break;
        rise(wiring, arrives_ps - wiring.delay_ps);
      }
      const bool level = slo(sample_ps - wiring.delay_ps) != wiring.slo_inverted;
      put(into, k, wiring.answers ? level && !wiring.stuck_low : true);
    }
    for (; edges < bits; ++edges) rise(wiring, edge(wiring, begin_ps, edges, !wiring.ma_inverted));
    store(wiring, into);
  }

 private:
  static constexpr std::int64_t cycle_ps = 31'250'000;

  // Edge k of MA at the master.
  static constexpr std::int64_t edge(const Wiring& wiring, std::int64_t begin_ps, std::size_t k,
                                     bool rising) {
    const auto clock = static_cast<std::int64_t>(k);
    const std::int64_t second = rising == wiring.idle_high ? wiring.period_ps / 2 : 0;
    return begin_ps + clock * wiring.period_ps + clock / 8 * wiring.pause_ps + second;
  }

  // The encoder sees a rising edge of MA.
  constexpr void rise(const Wiring& wiring, std::int64_t time_ps) {
    const bool is_idle = lat_ps_ == no_time || time_ps >= lat_ps_ + cycle_ps;
    if (is_idle) {
      lat_ps_ = no_time;
      // MA was low: it only returns to its idle level, and the next edge begins the cycle.
      if (wiring.idle_high == wiring.ma_inverted && !returned_) {
        returned_ = true;
        return;
      }
      returned_ = false;
      lat_ps_ = time_ps;
      bit_ = 0;
      acks_ = true;
      level_ = true;
      return;
    }
    if (acks_) {
      level_ = level_ ? false : time_ps >= lat_ps_ + wiring.processing_ps;
      acks_ = !level_;
      return;
    }
    level_ = sent(wiring, bit_++);
  }

  // The bits from CDS on.
  constexpr bool sent(const Wiring& wiring, unsigned bit) const {
    const std::uint64_t word = with_crc(std::uint64_t{position} << 2U | (wiring.error ? 1U : 3U));
    if (bit == 0) return false;
    if (bit <= 34) return (word >> (34U - bit) & 1U) != 0;
    return wiring.two && bit <= 68 && (word >> (68U - bit) & 1U) != 0;
  }

  // 28 bits and the CRC6 of x^6 + x + 1, inverted.
  static constexpr std::uint64_t with_crc(std::uint64_t data) {
    std::uint64_t rest = data << 6U;
    for (unsigned bit = 28; bit-- != 0;) {
      if ((rest >> (bit + 6U) & 1U) != 0) rest ^= std::uint64_t{0x43} << bit;
    }
    return data << 6U | (~rest & 0x3FU);
  }

  constexpr bool slo(std::int64_t time_ps) const {
    return lat_ps_ == no_time || time_ps >= lat_ps_ + cycle_ps || level_;
  }

  static constexpr void put(std::span<std::uint8_t> bytes, std::size_t bit, bool level) {
    const auto mask = static_cast<std::uint8_t>(0x80U >> (bit % 8));
    std::uint8_t& byte = bytes[bit / 8];
    byte = static_cast<std::uint8_t>(level ? byte | mask : byte & ~mask);
  }

  // The order in which the peripheral stores the bits.
  static void store(const Wiring& wiring, std::span<std::uint8_t> bytes) {
    for (int bits = wiring.shift; bits > 0; --bits) {
      for (std::size_t k = 0; k + 1 < bytes.size() * 8; ++k) {
        put(bytes, k, (bytes[(k + 1) / 8] >> (7U - (k + 1) % 8) & 1U) != 0);
      }
    }
    for (int bits = wiring.shift; bits < 0; ++bits) {
      for (std::size_t k = bytes.size() * 8 - 1; k > 0; --k) {
        put(bytes, k, (bytes[(k - 1) / 8] >> (7U - (k - 1) % 8) & 1U) != 0);
      }
    }
    if (wiring.lsb_first) {
      for (std::uint8_t& byte : bytes) {
        unsigned reversed = 0;
        for (unsigned bit = 0; bit < 8; ++bit) reversed |= (byte >> bit & 1U) << (7U - bit);
        byte = static_cast<std::uint8_t>(reversed);
      }
    }
    if (wiring.swapped_words) {
      for (std::size_t k = 1; k < bytes.size(); k += 2) std::swap(bytes[k - 1], bytes[k]);
    }
  }

  std::int64_t lat_ps_ = no_time;  // of the cycle; no_time: idle
  unsigned bit_ = 0;
  bool acks_ = false;
  bool level_ = true;
  bool returned_ = false;
  std::uint32_t toss_ = 1;
};

// ---- The firmware, and how it is set up

inline constexpr CatalogueEntry encoder = catalogue_encoder("resolute-26");

/// The defaults work.
struct Firmware {
  FrameFormat format = encoder.frame_format();
  /// The delay of the line was measured.
  SpiSetup spi{.period = nanoseconds(100), .line_delay = {nanoseconds(301), nanoseconds(399)}};
  AxisSetup axis{.cycle = nanoseconds(62'500),
                 .to_sampling = sampling_delay(spi, encoder.timing),
                 .max_step = 210'000};
  /// From one request to the next.
  Picoseconds interval = nanoseconds(62'500);
};

struct Spi {
  std::span<std::uint8_t> receive{};
  bool busy = false;

  bool start(std::span<std::uint8_t> into) {
    if (busy) return false;
    busy = true;
    receive = into;
    return true;
  }
};

/// The firmware on the board.
template <std::size_t axes = 1>
struct Bench {
  using Reader = SpiReader<FrameCodec<CrcFast, axes>>;

  Wiring wiring{};
  Firmware firmware{};
  Line line{};
  Spi spi{};
  Picoseconds now{};
  Reader reader{FrameCodec<CrcFast, axes>(firmware.format), firmware.spi, encoder.timing};
  EncoderAxis<Spi, Reader, 64, axes> axis{spi, reader, firmware.axis};

  void request() {
    now += firmware.interval;
    axis.request(now);
  }
  // The DMA receives the bytes.
  void receive() {
    std::array<std::uint8_t, 64> bytes{};
    const std::span<std::uint8_t> received = std::span(bytes).first(spi.receive.size());
    line.transfer(wiring, now.count, received);
    const std::size_t seen = wiring.dma_writes ? std::min(wiring.seen_bytes, received.size()) : 0;
    std::copy_n(received.begin(), seen, spi.receive.begin());
    spi.busy = false;
  }
  void cycle() {
    request();
    receive();
    axis.transfer_complete();
  }
  /// The cause of the last cycle; nothing for a good frame.
  std::string_view cause() const {
    const AxisCause last = axis.position().cause;
    return last == AxisCause::ok || last == AxisCause::first ? "" : name_of(last);
  }
  std::uint32_t count(AxisCause cause) const { return axis.axis().counts()[cause]; }
};

// The cause of the first cycle.
template <std::size_t axes = 1>
std::string_view first_cycle(const Wiring& wiring, const Firmware& firmware = {}) {
  Bench<axes> bench{wiring, firmware};
  bench.cycle();
  return bench.cause();
}
inline std::string_view first_cycle_with(const SpiSetup& spi) {
  Firmware firmware;
  firmware.spi = spi;
  return first_cycle({}, firmware);
}
inline std::string_view first_cycle_as(std::string_view format) {
  Firmware firmware;
  firmware.format = *parse_format(format);
  return first_cycle({}, firmware);
}

// The cause of the next cycle after two good ones, with this wiring.
inline std::string_view next_cycle(const Wiring& wiring) {
  Bench<> bench;
  bench.cycle();
  bench.cycle();
  bench.wiring = wiring;
  bench.cycle();
  return bench.cause();
}

inline std::string_view power_up_too_short() {
  Firmware firmware;
  firmware.axis.power_up = {};
  Bench<> bench{{.answers = false}, firmware};
  for (int k = 0; k < 4; ++k) bench.cycle();
  return bench.axis.position().usable() ? "" : bench.cause();
}

inline std::string_view transfer_never_ends() {
  Bench<> bench;
  bench.request();
  bench.request();
  return bench.cause();
}

inline std::string_view no_interrupt() {
  Bench<> bench;
  bench.request();
  bench.receive();
  bench.request();
  return bench.cause();
}

inline std::string_view error_interrupt() {
  Bench<> bench;
  bench.request();
  bench.axis.transfer_failed();
  return bench.cause();
}

inline std::string_view two_interrupts() {
  Bench<> bench;
  bench.cycle();
  bench.axis.transfer_complete();
  return bench.count(AxisCause::unexpected) == 1 ? name_of(AxisCause::unexpected) : "";
}

// The encoder still sends zeros after its last frame.
inline std::string_view request_too_early() {
  Firmware firmware;
  firmware.interval = firmware.axis.cycle = microseconds(25);
  Bench<> bench{{}, firmware};
  bench.cycle();
  bench.cycle();
  return bench.cause();
}

inline std::string_view faster_than_max_step() {
  Bench<> bench;
  bench.cycle();
  bench.line.position += 250'000;
  bench.cycle();
  return bench.cause();
}

// Three cycles of a machine that turns.
inline std::string_view turning(const Firmware& firmware) {
  Bench<> bench{{}, firmware};
  for (int k = 0; k < 3; ++k) {
    bench.cycle();
    bench.line.position += 200'000;
  }
  return bench.cause();
}
inline std::string_view wrong_cycle(Picoseconds cycle) {
  Firmware firmware;
  firmware.axis.cycle = cycle;
  return turning(firmware);
}
inline std::string_view wrong_direction() {
  Firmware firmware;
  firmware.axis.reversed = true;
  return turning(firmware);
}

inline std::string_view verdict_after(Picoseconds wait) {
  test::SafetyBench bench;
  bench.until_safe();
  const SafetyVerdict verdict = bench.watch(bench.now + wait).verdict;
  return is_fault(verdict) ? name_of(verdict) : "";
}

// The only clock is fast by a third: requests seem to come later than they do.
inline std::string_view one_fast_clock() {
  test::SafetyBench bench;
  bench.until_safe();
  SafetyJudgement judged;
  for (int k = 0; k < 10; ++k) {
    bench.now += test::SafetyBench::cycle / 3;
    judged = bench.good();
  }
  return is_fault(judged.verdict) ? name_of(judged.verdict) : "";
}

inline std::string_view no_self_test() {
  test::SafetyBench bench([](SafetySetup&) {}, false);
  return name_of(bench.good().verdict);
}

// ---- The list

struct Mistake {
  std::string_view name;
  /// A cause or a verdict; empty: it is not detected. For a mistake that does not compile a part of
  /// the compiler's message; tests/core/wrong_mistakes.cpp makes it.
  std::string_view result;
  /// Returns the result. None: it does not compile, or no program can make it.
  std::string_view (*make)() = nullptr;

  constexpr bool compiles() const { return make != nullptr || result.empty(); }
};

inline constexpr auto list = std::to_array<Mistake>({
    // Wiring
    {"The encoder has no supply", "no_response", [] { return first_cycle({.answers = false}); }},
    {"MA and SLO are swapped: the receiver has no driver", "no_response",
     [] { return first_cycle({.answers = false}); }},
    {"The wires of SLO are swapped (A and B)", "not_ready",
     [] { return first_cycle({.slo_inverted = true}); }},
    {"The input pin is not SLO, or the receiver is off: it reads 0", "not_ready",
     [] { return first_cycle({.stuck_low = true}); }},
    {"The wires of MA are swapped", "response_range",
     [] { return first_cycle({.ma_inverted = true}); }},
    {"The cable is longer than `line_delay.max`", "response_range",
     [] { return first_cycle({.delay_ps = 470'000}); }},
    {"`power_up` is shorter than the encoder needs", "no_response", power_up_too_short},
    {"The encoder is dirty or not aligned: nE is 0", "error_bit",
     [] { return first_cycle({.error = true}); }},
    // SPI
    {"SPI mode 0", "response_range", [] { return first_cycle({.idle_high = false}); }},
    {"SPI mode 1", "response_range",
     [] { return first_cycle({.idle_high = false, .samples_on_rising = false}); }},
    {"SPI mode 2, and the setup has mode 3", "response_range",
     [] { return first_cycle({.samples_on_rising = false}); }},
    {"The same, and the delay is in the first half of a clock", "",
     [] { return first_cycle({.delay_ps = 330'000, .samples_on_rising = false}); }},
    {"SLO changes when the SPI samples", "crc",
     [] {
       Firmware firmware;
       firmware.spi.line_delay = {nanoseconds(250), nanoseconds(350)};
       return first_cycle({.delay_ps = 300'000}, firmware);
     }},
    {"`period` is a bare number", "'int' to 'biss::Picoseconds'"},
    {"`period` is missing", "the_period_is_not_positive"},
    {"`period` in microseconds, not nanoseconds", "response_range",
     [] {
       return first_cycle_with(
           {.period = microseconds(100), .line_delay = {nanoseconds(301), nanoseconds(399)}});
     }},
    {"The clock is above `clock_max` of the encoder", "the_clock_is_above_the_encoders_clock_max"},
    {"The SPI has another clock than the setup", "response_range",
     [] { return first_cycle({.period_ps = 200'000}); }},
    // Bits and bytes
    {"Least significant bit first", "not_ready", [] { return first_cycle({.lsb_first = true}); }},
    {"Words of 16 bits, low byte first", "not_ready",
     [] { return first_cycle({.swapped_words = true}); }},
    {"The first bit is missing", "response_range", [] { return first_cycle({.shift = 1}); }},
    {"A bit too many at the beginning", "response_range",
     [] { return first_cycle({.shift = -1}); }},
    {"The clock pauses between bytes", "ack_range",
     [] { return first_cycle({.pause_ps = 300'000}); }},
    {"`max_pause` is longer than the encoder permits",
     "max_pause_is_below_half_a_period_or_not_below_shortest_timeout"},
    {"`time_step` is longer than half of `max_pause`",
     "time_step_is_negative_or_too_long_for_max_pause"},
    {"The transfer is a byte too short", "stop_bit",
     [] { return first_cycle({.seen_bytes = 25}); }},
    {"The buffer is smaller than `reader.bytes()`", "AxisError::buffer"},
    // DMA, cache, interrupts
    {"The DMA writes nothing: wrong channel or stream; old bytes", "no_response",
     [] { return next_cycle({.dma_writes = false}); }},
    {"The DMA cannot reach the buffer and reports an error", "failed", error_interrupt},
    {"The DMA never ends", "late", transfer_never_ends},
    {"The cache is not invalidated", "no_response",
     [] { return next_cycle({.dma_writes = false}); }},
    {"The buffer shares a line of the cache with other data", "stop_bit",
     [] { return next_cycle({.seen_bytes = 16}); }},
    {"The interrupt at the end is missing", "unanswered", no_interrupt},
    {"The interrupt comes twice", "unexpected", two_interrupts},
    {"The interrupt of sending is used, one byte too early", "stop_bit",
     [] { return next_cycle({.seen_bytes = 25}); }},
    {"The interrupts have different priorities", ""},
    {"The request comes before the encoder is ready", "not_ready", request_too_early},
    // The format
    {"The position has another number of bits", "crc",
     [] { return first_cycle_as("pos24,nE,nW,crc6;cds0"); }},
    {"The CRC has another number of bits", "crc",
     [] { return first_cycle_as("pos26,nE,nW,crc8;cds0"); }},
    {"The CRC has another polynomial", "crc",
     [] { return first_cycle_as("pos26,nE,nW,crc6:0x59;cds0"); }},
    {"The CRC is not inverted", "crc",
     [] { return first_cycle_as("pos26,nE,nW,crc6:plain;cds0"); }},
    {"The format has no nE", "a_position_has_no_nE_and_the_setup_no_word_no_error_flag"},
    {"The format has no CRC", "a_channel_has_no_crc_and_the_setup_no_word_unchecked"},
    {"The timing of another encoder", "ack_range",
     [] { return first_cycle({.processing_ps = 2'000'000}); }},
    {"A chain of two encoders, and one in the format", "stop_bit",
     [] { return first_cycle({.two = true}); }},
    {"A chain of two encoders in the format, and one on the line", "crc",
     [] {
       Firmware firmware;
       firmware.format = *parse_format("pos26,nE,nW,crc6+pos26,nE,nW,crc6;cds0");
       return first_cycle<2>({}, firmware);
     }},
    {"`axes` is not the number of channels", "AxisError::format"},
    // The axis
    {"The setup is a temporary object", "deleted"},
    {"The reader is a temporary object", "deleted"},
    {"The axis is copied", "deleted"},
    {"`cycle` is missing", "AxisError::cycle"},
    {"`to_sampling` is missing", "AxisError::cycle"},
    {"`max_step` is missing", "AxisError::max_step"},
    {"`max_step` is half a turn", "AxisError::max_step"},
    {"`offset` is 2^62 counts or more", "AxisError::offset"},
    {"`max_step` is below the speed of the machine", "step", faster_than_max_step},
    {"`cycle` is too short by a factor of 1000", "turns",
     [] { return wrong_cycle(picoseconds(62'500)); }},
    {"`cycle` is too long by a factor of 1000", "early",
     [] { return wrong_cycle(microseconds(62'500)); }},
    {"The time of a request is a bare number", "'int' to 'biss::Picoseconds'"},
    {"Wrong direction, offset or zero", "", wrong_direction},
    // BiSS Safety
    {"The self test does not run", "self_test", no_self_test},
    {"Requests at half the rate of the safety setup", "watchdog",
     [] { return verdict_after(nanoseconds(62'500)); }},
    {"The only clock of the monitor is fast by a third", "", one_fast_clock},
});

}  // namespace biss::mistakes
