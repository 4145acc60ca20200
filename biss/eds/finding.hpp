// EdsFinding: what is wrong with a data sheet, in words.
#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "biss/eds/field.hpp"

namespace biss {

/// The faults that a data sheet can have.
enum class EdsProblem : std::uint8_t {
  all_zero,              ///< an empty bank, although its checksum is right
  all_ones,              ///< erased memory
  checksum,              ///< not the sum of the bytes
  out_of_range,          ///< outside the document's range, not marked as absent either
  version,               ///< a version that is not known
  profile,               ///< the identifier is not BP3's
  reserved_bit,          ///< bit 7 of the identifier
  data_length,           ///< DL that the profile does not allow
  reserved_not_zero,     ///< a reserved byte
  unnamed_not_zero,      ///< a byte or bit that no source names (only when asked)
  little_endian,         ///< lowest byte first: the other order makes sense
  polynomial_full_form,  ///< with its lowest bit, which must be left out
  polynomial,            ///< not the polynomial of the profile, or no CRC of 3 to 16 bits
  min_above_max,         ///< a shortest, lowest, first above its longest, highest, last
  lengths,               ///< MT_LEN, CO_LEN, FI_LEN, flags (and CRC with C = 1) do not add up to DL
  length_reading,        ///< C = 1: they add up to DL in the other reading, with or without CRC
  count_above_length,    ///< more counts than its length in bits can represent
  alignment,             ///< zeros at the wrong end of MT or of the singleturn value
  encoder_type,          ///< rotary or linear, but counts, lengths and checksum fit the other type
  crc_bit,               ///< C = 0 in a safety encoder, C = 1 in a standard encoder
  identifier,            ///< differs from registers 0x42 and 0x43
  channel_count,         ///< DC_NUM is not the number of channels that are filled in
  channel_unused,        ///< something in a channel beyond DC_NUM
  bank_is_common,        ///< a channel's part in the common part's own bank: a loop
  bank_outside,          ///< a channel's part outside the data sheet
  bank_shared,           ///< two channels with one part
  bank_in_user_area,     ///< a bank of the data sheet among the user banks
  too_few_banks,         ///< EDS_LEN leaves no room for the parts, or runs past bank 255
  slave_offset,          ///< SL_OFF is not below SL_NUM
  actuator,              ///< BP3 is a sensor's profile
  data_length_differs,   ///< DLEN_i is not the profile's DL
  polynomial_differs,    ///< CPOLY_i is not the profile's CPOLY
};

/// The name of a problem, and the message for a user, without a full stop.
struct EdsProblemWords {
  std::string_view name;
  std::string_view text;
};

inline constexpr EdsProblemWords eds_problems[] = {
    {"all_zero", "the bank is empty, every byte is 0"},
    {"all_ones", "the bank is erased memory, every byte is 0xFF"},
    {"checksum", "not the sum of the bytes before it"},
    {"out_of_range", "outside its range"},
    {"version", "this version is not known"},
    {"profile", "not an identifier of BP3"},
    {"reserved_bit", "bit 7 must be 0"},
    {"data_length", "the profile does not allow this data length"},
    {"reserved_not_zero", "a reserved byte must be 0"},
    {"unnamed_not_zero", "no source names this byte or bit"},
    {"little_endian", "the bytes are in the wrong order: the highest comes first"},
    {"polynomial_full_form", "the polynomial has its lowest bit, which must be left out"},
    {"polynomial", "not a polynomial of this profile"},
    {"min_above_max", "the lower limit is above the upper one"},
    {"lengths", "MT_LEN, CO_LEN, FI_LEN and the flags do not add up to DL"},
    {"length_reading",
     "the lengths and flags fit only the other reading of DL; with C = 1, BP3's table 5 adds the "
     "CRC bits to the data length, and table 6 says \"data length without CRC\""},
    {"count_above_length", "more counts than its length can distinguish"},
    {"alignment",
     "BP3 aligns turns right, with leading zeros, and the singleturn value left, with trailing "
     "zeros"},
    {"encoder_type", "counts, lengths and checksum fit the other type"},
    {"crc_bit", "C must be 1 in a safety encoder, and 0 in a standard encoder"},
    {"identifier", "not the same as the registers 0x42 and 0x43"},
    {"channel_count", "not the number of channels that are filled in"},
    {"channel_unused", "there is a value in a channel that DC_NUM leaves out"},
    {"bank_is_common", "the bank is the common part's own"},
    {"bank_outside", "the bank does not belong to the data sheet"},
    {"bank_shared", "two channels share this bank"},
    {"bank_in_user_area", "a bank of the data sheet lies among the user banks"},
    {"too_few_banks", "the data sheet's length has no room for its parts"},
    {"slave_offset", "the device has fewer slaves"},
    {"actuator", "BP3 is a profile of sensors"},
    {"data_length_differs", "not the data length of the profile's part"},
    {"polynomial_differs", "not the polynomial of the profile's part"},
};

/// The name that scripts see: the enumerator's name.
constexpr std::string_view name_of(EdsProblem problem) {
  return eds_problems[static_cast<std::size_t>(problem)].name;
}
constexpr std::string_view text_of(EdsProblem problem) {
  return eds_problems[static_cast<std::size_t>(problem)].text;
}

/// A finding. Text is static.
struct EdsFinding {
  EdsPart part = EdsPart::common;
  /// The data channel whose part it is; 0 in the common part.
  std::uint8_t channel = 0;
  /// The wrong field, as far as it is known; the version field for a whole bank.
  std::string_view symbol{};
  EdsProblem problem = EdsProblem::checksum;
  /// As stored.
  std::uint32_t value = 0;
  /// The field that it contradicts, which may be the wrong one instead; empty when there is none.
  std::string_view against{};
  /// The right value if it is known (checksum, lengths, registers, the other byte order, the
  /// polynomial's right form); otherwise the value of `against`.
  std::uint32_t expected = 0;
};

/// Two fields, or the data sheet and the registers, describe different frames or times, and no rule
/// defines which is right. A format from such a data sheet may be wrong.
constexpr bool contradicts(const EdsFinding& finding) {
  using enum EdsProblem;
  constexpr auto always = std::to_array<EdsProblem>(
      {lengths, count_above_length, encoder_type, identifier, bank_is_common, bank_shared,
       slave_offset, data_length, data_length_differs});
  if (std::find(always.begin(), always.end(), finding.problem) != always.end()) return true;
  switch (finding.problem) {
    case alignment:
      return finding.against.ends_with("_FMT");  // no format has zeros between two fields
    case out_of_range:
      return finding.against == "FB2";  // no nE
    case polynomial_differs:
      return finding.value != 0;  // else it is not given
    case channel_count:
      return finding.expected > finding.value;  // fewer: registers may describe the others
    case min_above_max:
      return finding.part == EdsPart::common;  // temperature and supply do not count
    case little_endian:
      return !finding.against.empty();  // a count; identifier and polynomial are repaired
    default:
      return false;
  }
}

/// A function that takes the findings, one by one.
template <class T>
concept EdsSink = std::invocable<T&, const EdsFinding&>;

}  // namespace biss
