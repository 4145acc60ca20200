// A user's source: macros of Arduino and other headers before the core's headers, globals with
// common names after them, and templates that use these globals. Compiled by user.cmake, never run.
#ifdef STANDARD_FIRST
#include <algorithm>
#include <array>
#include <bit>
#include <compare>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string_view>
#include <type_traits>
#include <utility>
#endif

// The macros of Arduino's AVR core, in the order of its headers.
#define min(a, b) ((a) < (b) ? (a) : (b))
#define max(a, b) ((a) > (b) ? (a) : (b))
#ifdef STANDARD_FIRST  // <cstdlib>, which <algorithm> includes, declares abs()
#define abs(x) ((x) > 0 ? (x) : -(x))
#endif
#define constrain(amt, low, high) ((amt) < (low) ? (low) : ((amt) > (high) ? (high) : (amt)))
#define round(x) ((x) >= 0 ? (long)((x) + 0.5) : (long)((x)-0.5))
#define radians(deg) ((deg)*0.017453292519943295)
#define degrees(rad) ((rad)*57.29577951308232)
#define sq(x) ((x) * (x))
#define lowByte(w) ((uint8_t)((w)&0xff))
#define highByte(w) ((uint8_t)((w) >> 8))
#define bitRead(value, bit) (((value) >> (bit)) & 0x01)
#define bitSet(value, bit) ((value) |= (1UL << (bit)))
#define bitClear(value, bit) ((value) &= ~(1UL << (bit)))
#define bitToggle(value, bit) ((value) ^= (1UL << (bit)))
#define bitWrite(value, bit, bitvalue) ((bitvalue) ? bitSet(value, bit) : bitClear(value, bit))
#define bit(b) (1UL << (b))
#define _BV(b) (1 << (b))
#define word(...) makeWord(__VA_ARGS__)
#define interrupts() __asm__ volatile("")
#define noInterrupts() __asm__ volatile("")
#define F(text) (text)
#define B0 0
#define B1 1
#define B00000001 1
#define HIGH 0x1
#define LOW 0x0
#define INPUT 0x0
#define OUTPUT 0x1
#define PI 3.1415926535897932384626433832795
#define SERIAL 0x0
#define DISPLAY 0x1
#define CHANGE 1
#define FALLING 2
#define RISING 3
#define DEFAULT 1
#define EXTERNAL 0
#define INTERNAL 3
#define LSBFIRST 0
#define MSBFIRST 1

// user.cmake inserts every header of the core here.

int codec, setup, timing, reader, format, frame, bytes, clocks, bits, bounds, options, owner,
    source, plan, channel, channels, slave, master, monitor, line, now, position, period, phase,
    state, level, data, value, k, i, index, at, bank, registers, server, event, step_, last, first,
    end, begin_;

namespace user {

using namespace biss;

constexpr CatalogueEntry Encoder = catalogue_encoder("resolute-26");
constexpr SpiReader Reader(FixedCodec<Encoder.frame_format()>{},
                           SpiSetup{.period = nanoseconds(100)}, Encoder.timing);
bool read_spi(std::span<const std::uint8_t> buffer) { return Reader.read(buffer).ok(); }

using Codec = FrameCodec<CrcFast, 1>;
bool request(const Codec& Codec1, std::int64_t Time, bool Slo) {
  RequestCycle<Codec> Master(Codec1, MasterSetup{.period = nanoseconds(100)});
  return Master.begin(picoseconds(Time), Slo).level && Master.step(picoseconds(Time), Slo).level;
}

struct Device {
  RegisterServer<BankedRegisters<2>> Server{BankedRegisters<2>()};
  BasicFrame<1> sample(Picoseconds) { return {}; }
  bool cds(bool Predecessor) { return Server.cds(Predecessor); }
  void cdm(bool Bit) { Server.cdm(Bit); }
};
bool answer(const Codec& Codec1, std::int64_t Time, bool Ma) {
  Slave Slave1(Codec1, slave_timing(Encoder.timing), Device{});
  return Slave1.step(picoseconds(Time), Ma, false).level;
}

constexpr SafetyConfiguration Type = safety_configuration("fs-36-28");
bool watch(std::int64_t Time, const BitView& Bits) {
  SafetyMonitor<FixedSafetyPlan<Type.frame_format(), Type.setup>> Monitor;
  return Monitor.self_test() && Monitor.step(OneClock{picoseconds(Time)}, Bits).position;
}

}  // namespace user
