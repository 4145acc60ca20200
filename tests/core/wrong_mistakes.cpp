// Mistakes of docs/guide-firmware.md that do not compile. wrong_mistakes.cmake compiles one after
// the other, as MISTAKE 1, 2, …, and compares the compiler's message; without MISTAKE all is right.
#include "biss/axis/encoder_axis.hpp"
#include "biss/catalogue/catalogue.hpp"
#include "biss/frame/fixed.hpp"
#include "biss/master/polled_read.hpp"

#ifndef MISTAKE
#define MISTAKE 0
#endif

namespace biss::wrong_mistakes {

struct Spi {
  constexpr bool start(std::span<std::uint8_t>) { return true; }
};

constexpr auto encoder = catalogue_encoder("resolute-26");
using Codec = FixedCodec<encoder.frame_format()>;
constexpr SpiSetup spi_setup{.period = nanoseconds(100), .line_delay = {.max = nanoseconds(700)}};
constexpr SpiReader reader(Codec{}, spi_setup, encoder.timing);
constexpr AxisSetup setup{.cycle = nanoseconds(62'500),
                          .to_sampling = sampling_delay(spi_setup, encoder.timing),
                          .max_step = 210'000};

template <std::size_t bytes, std::size_t axes = 1>
using AnAxis = EncoderAxis<Spi, SpiReader<Codec>, bytes, axes>;
using Axis = AnAxis<reader.bytes()>;
constinit Spi spi;
constinit Axis axis{spi, reader, setup};

// Mistake: `period` is a bare number
// says: 'int' to 'biss::Picoseconds'
#if MISTAKE == 1
constexpr SpiSetup bare{.period = 100};
#endif
// Mistake: `period` is missing
// says: the_period_is_not_positive
#if MISTAKE == 2
constexpr SpiReader without(Codec{}, SpiSetup{}, encoder.timing);
#endif
// Mistake: The clock is above `clock_max` of the encoder
// says: the_clock_is_above_the_encoders_clock_max
#if MISTAKE == 3
constexpr SpiReader fast(Codec{}, {.period = nanoseconds(25)}, encoder.timing);
#endif
// Mistake: `max_pause` is longer than the encoder permits
// says: max_pause_is_below_half_a_period_or_not_below_shortest_timeout
#if MISTAKE == 4
constexpr SpiReader pausing(Codec{}, {.period = nanoseconds(100), .max_pause = microseconds(5)},
                            encoder.timing);
#endif
// Mistake: `time_step` is longer than half of `max_pause`
// says: time_step_is_negative_or_too_long_for_max_pause
#if MISTAKE == 5
struct Slow {
  static constexpr Picoseconds time_step = microseconds(10);
  constexpr Picoseconds now() { return {}; }
  constexpr std::uint8_t transfer() { return 0; }
};
constexpr SpiSetup pauses{.period = microseconds(2),
                          .line_delay = {.max = nanoseconds(700)},
                          .max_pause = nanoseconds(1'100),
                          .pause_anyway = true};
constinit Slow slow;
constinit PolledRequest polled(slow, pauses, encoder.timing);
#endif
// Mistake: The buffer is smaller than `reader.bytes()`
// says: AxisError::buffer
#if MISTAKE == 6
constinit AnAxis<reader.bytes() - 1> small{spi, reader, setup};
#endif
// Mistake: The format has no nE
// says: a_position_has_no_nE_and_the_setup_no_word_no_error_flag
#if MISTAKE == 7
constexpr SpiReader unflagged(FixedCodec<frame_format("pos26,crc6")>{}, spi_setup, encoder.timing);
#endif
// Mistake: The format has no CRC
// says: a_channel_has_no_crc_and_the_setup_no_word_unchecked
#if MISTAKE == 8
constexpr SpiReader unchecked(FixedCodec<frame_format("pos26,nE,nW")>{}, spi_setup, encoder.timing);
#endif
// Mistake: `axes` is not the number of channels
// says: AxisError::format
#if MISTAKE == 9
constinit AnAxis<reader.bytes(), 2> chain{spi, reader, setup};
#endif
// Mistake: The setup is a temporary object
// says: deleted
#if MISTAKE == 10
constinit Axis temporary{spi, reader, AxisSetup{.cycle = nanoseconds(62'500)}};
#endif
// Mistake: The reader is a temporary object
// says: deleted
#if MISTAKE == 11
constinit Axis temporary{spi, SpiReader(Codec{}, spi_setup, encoder.timing), setup};
#endif
// Mistake: The axis is copied
// says: deleted
#if MISTAKE == 12
Axis copy = axis;
#endif
// Mistake: `cycle` is missing
// says: AxisError::cycle
#if MISTAKE == 13
constexpr AxisSetup wrong{.to_sampling = setup.to_sampling, .max_step = 210'000};
constinit Axis without{spi, reader, wrong};
#endif
// Mistake: `to_sampling` is missing
// says: AxisError::cycle
#if MISTAKE == 14
constexpr AxisSetup wrong{.cycle = setup.cycle, .max_step = 210'000};
constinit Axis without{spi, reader, wrong};
#endif
// Mistake: `max_step` is missing
// says: AxisError::max_step
#if MISTAKE == 15
constexpr AxisSetup wrong{.cycle = setup.cycle, .to_sampling = setup.to_sampling};
constinit Axis without{spi, reader, wrong};
#endif
// Mistake: `max_step` is half a turn
// says: AxisError::max_step
#if MISTAKE == 16
constexpr AxisSetup wrong{
    .cycle = setup.cycle, .to_sampling = setup.to_sampling, .max_step = 1 << 25};
constinit Axis half{spi, reader, wrong};
#endif
// Mistake: `offset` is 2^62 counts or more
// says: AxisError::offset
#if MISTAKE == 17
constexpr AxisSetup wrong{.cycle = setup.cycle,
                          .to_sampling = setup.to_sampling,
                          .max_step = 210'000,
                          .offset = axis_position_max};
constinit Axis far{spi, reader, wrong};
#endif
// Mistake: The time of a request is a bare number
// says: 'int' to 'biss::Picoseconds'
#if MISTAKE == 18
void timer_interrupt() { axis.request(100); }
#endif

}  // namespace biss::wrong_mistakes
