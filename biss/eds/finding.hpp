// EdsFinding: one thing that is wrong with a data sheet.
#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "biss/eds/field.hpp"

namespace biss {

/// One enumerator a fault.
enum class EdsProblem : std::uint8_t {
  all_zero,              ///< an empty bank, whose checksum is even right
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
  polynomial_full_form,  ///< with its lowest bit, where it belongs left out
  polynomial,            ///< not the profile's, or no CRC of 3 to 16 bits
  min_above_max,         ///< a shortest, lowest, first above its longest, highest, last
  lengths,               ///< MT_LEN, CO_LEN, FI_LEN, flags (and CRC with C = 1) do not add up to DL
  count_above_length,    ///< more counts than the bits of its length can tell apart
  encoder_type,          ///< rotary or linear, and counts, lengths and checksum are the other's
  crc_bit,               ///< C = 0 beside a safety word, where C = 1 is due
  identifier,            ///< not as registers 0x42 and 0x43
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

inline constexpr std::size_t eds_problem_count = 30;

/// The name scripts see, the same as the enumerator's.
constexpr std::string_view name_of(EdsProblem problem) {
  constexpr std::array<std::string_view, eds_problem_count> names{"all_zero",
                                                                  "all_ones",
                                                                  "checksum",
                                                                  "out_of_range",
                                                                  "version",
                                                                  "profile",
                                                                  "reserved_bit",
                                                                  "data_length",
                                                                  "reserved_not_zero",
                                                                  "unnamed_not_zero",
                                                                  "little_endian",
                                                                  "polynomial_full_form",
                                                                  "polynomial",
                                                                  "min_above_max",
                                                                  "lengths",
                                                                  "count_above_length",
                                                                  "encoder_type",
                                                                  "crc_bit",
                                                                  "identifier",
                                                                  "channel_count",
                                                                  "channel_unused",
                                                                  "bank_is_common",
                                                                  "bank_outside",
                                                                  "bank_shared",
                                                                  "bank_in_user_area",
                                                                  "too_few_banks",
                                                                  "slave_offset",
                                                                  "actuator",
                                                                  "data_length_differs",
                                                                  "polynomial_differs"};
  return names[static_cast<std::size_t>(problem)];
}

/// What a user is told, without a full stop.
constexpr std::string_view text_of(EdsProblem problem) {
  constexpr std::array<std::string_view, eds_problem_count> texts{
      "the bank is empty, every byte is 0",
      "the bank is erased memory, every byte is 0xFF",
      "not the sum of the bytes before it",
      "outside its range",
      "this version is not known",
      "not an identifier of BP3",
      "bit 7 must be 0",
      "the profile does not allow this data length",
      "a reserved byte must be 0",
      "no source names this byte or bit",
      "the bytes stand in the wrong order, the highest comes first",
      "the polynomial has its lowest bit, which must be left out",
      "not a polynomial of this profile",
      "the lower limit is above the upper one",
      "MT_LEN, CO_LEN, FI_LEN and the flags do not add up to DL",
      "more counts than its length can tell apart",
      "counts, lengths and checksum are those of the other type",
      "beside a safety word C must be 1",
      "not what the registers 0x42 and 0x43 say",
      "not the number of channels that are filled in",
      "something stands in a channel that DC_NUM leaves out",
      "the bank is the common part's own",
      "the bank is not one of the data sheet's",
      "two channels share this bank",
      "a bank of the data sheet lies among the user banks",
      "the data sheet's length has no room for its parts",
      "the device has not so many slaves",
      "BP3 is a profile of sensors",
      "not the data length of the profile's part",
      "not the polynomial of the profile's part"};
  return texts[static_cast<std::size_t>(problem)];
}

/// A finding. Text is static.
struct EdsFinding {
  EdsPart part = EdsPart::common;
  /// The data channel whose part it is; 0 in the common part.
  std::uint8_t channel = 0;
  /// The field that is wrong, as far as this can be told; the version field for a whole bank.
  std::string_view symbol{};
  EdsProblem problem = EdsProblem::checksum;
  /// As stored.
  std::uint32_t value = 0;
  /// The field it contradicts, which may as well be the wrong one; empty when it stands alone.
  std::string_view against{};
  /// What it should be where that is known (checksum, lengths, registers, the other byte order, the
  /// polynomial's right form); otherwise the value of `against`.
  std::uint32_t expected = 0;
};

/// What takes the findings, one by one.
template <class T>
concept EdsSink = std::invocable<T&, const EdsFinding&>;

/// What no document settles.
struct EdsCheckOptions {
  /// 0 and all ones mark an optional value that is not given (inferred: the ranges leave out just
  /// these two). False: they are out of range.
  bool zero_is_absent = true;
  bool ones_are_absent = true;
  /// Bytes that the documents reserve must be 0. They do not say so.
  bool reserved_zero = true;
  /// So must what no source names: common part 0x13, bits 2 and 4…7 of FORMAT_i, 5…7 of BC_OFF.
  bool unnamed_zero = false;
  /// With C = 1 DL counts the CRC's bits: ProfileOptions::length_counts_crc.
  bool length_counts_crc = true;
  /// Parts of other profiles have BP3's checksum too.
  bool raw_checksum = true;

  /// Whether a value of an optional field says that it is not given.
  constexpr bool absent(std::uint32_t value, std::uint32_t all_ones) const {
    return (zero_is_absent && value == 0) || (ones_are_absent && value == all_ones);
  }
};

}  // namespace biss
