// Mistakes in names and texts in constant expressions. No line compiles, and wrong_names.cmake
// compares the compiler's message with the text at each line.
#include "biss/base/bit_buffer.hpp"
#include "biss/catalogue/catalogue.hpp"
#include "biss/frame/format_text.hpp"
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

constexpr BitBuffer<80> appended(unsigned count) {
  BitBuffer<80> bits;
  bits.append(1, count);
  return bits;
}
constexpr auto right_7 = appended(64);
// says: a_word_has_at_most_64_bits
constexpr auto wrong_7 = appended(65);

}  // namespace biss
