// Mistakes in names and texts in constant expressions. No line compiles, and wrong_names.cmake
// compares the compiler's message with the text at each line.
#include "biss/base/bit_buffer.hpp"
#include "biss/catalogue/catalogue.hpp"
#include "biss/frame/fixed.hpp"
#include "biss/frame/format_text.hpp"
#include "biss/master/spi_read.hpp"
#include "biss/safety/configurations.hpp"

namespace biss {

constexpr auto encoder = catalogue_encoder("resolute-26");
constexpr auto format = frame_format("pos26,nE,nW,crc6;cds0");
constexpr auto type = safety_configuration("fs-36-28");

// says: the_catalogue_has_no_encoder_of_this_name
constexpr auto wrong_1 = catalogue_encoder("resolute-27");
// says: no_safety_configuration_of_this_name
constexpr auto wrong_2 = safety_configuration("fs-36-29");
// says: FormatMistake::unknown_item
constexpr auto wrong_3 = frame_format("pos26,nX,crc6");
// says: FormatMistake::option_twice
constexpr auto wrong_4 = frame_format("pos26,nE,nW,crc6;cds0;cds0");
// says: this_result_holds_an_error_and_no_value
constexpr auto wrong_5 = *parse_format("pos26,nE,nW,crc");
// says: this_result_holds_a_value_and_no_error
constexpr auto wrong_6 = parse_format("pos26").error();

// Readers of the wrong setup: a clock of 40 MHz for an encoder of 10 MHz, no nE, no CRC.
template <FrameFormat Format>
using Codec = FixedCodec<Format>;
constexpr auto no_flag = frame_format("pos26,crc6");
constexpr auto no_crc = frame_format("pos26,nE,nW");
constexpr SpiSetup at_10_MHz{.period = nanoseconds(100)};
constexpr SpiSetup words{.period = nanoseconds(100), .no_error_flag = true, .unchecked = true};
constexpr SpiReader right_8(Codec<format>{}, at_10_MHz, encoder.timing);
constexpr SpiReader right_9(Codec<no_flag>{}, words, encoder.timing);
constexpr SpiReader right_10(Codec<no_crc>{}, words, encoder.timing);
// says: the_clock_is_above_the_encoders_clock_max
constexpr SpiReader wrong_8(Codec<format>{}, {.period = nanoseconds(25)}, encoder.timing);
// says: a_position_has_no_nE_and_the_setup_no_word_no_error_flag
constexpr SpiReader wrong_9(Codec<no_flag>{}, at_10_MHz, encoder.timing);
// says: a_channel_has_no_crc_and_the_setup_no_word_unchecked
constexpr SpiReader wrong_10(Codec<no_crc>{}, at_10_MHz, encoder.timing);
// says: the_period_is_not_positive
constexpr SpiReader wrong_11(Codec<format>{}, SpiSetup{}, encoder.timing);
// says: the_line_delay_is_negative_or_its_minimum_above_its_maximum
constexpr SpiReader wrong_12(Codec<format>{},
                             {.period = nanoseconds(100), .line_delay = {nanoseconds(2), {}}},
                             encoder.timing);
// says: max_pause_is_below_half_a_period_or_not_below_shortest_timeout
constexpr SpiReader wrong_13(Codec<format>{},
                             {.period = nanoseconds(100), .max_pause = nanoseconds(150)},
                             encoder.timing);
// says: the_line_delay_is_too_long_for_pauses
constexpr SpiReader wrong_14(Codec<format>{},
                             {.period = nanoseconds(100), .max_pause = nanoseconds(149)},
                             encoder.timing);
// says: the_encoder_permits_no_pause_and_the_setup_has_no_word_pause_anyway
constexpr SpiReader wrong_15(Codec<format>{},
                             {.period = nanoseconds(100),
                              .line_delay = {.max = {}},
                              .max_pause = nanoseconds(149)},
                             encoder.timing);

constexpr BitBuffer<80> appended(unsigned count) {
  BitBuffer<80> bits;
  bits.append(1, count);
  return bits;
}
constexpr auto right_7 = appended(64);
// says: a_word_has_at_most_64_bits
constexpr auto wrong_7 = appended(65);

}  // namespace biss
